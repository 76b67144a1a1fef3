// A photo on which the bores of a valve body are marked, one after another: by a press, or with the arrow keys.
//
// Marks are held here from the first one to the last, and sent whole after each step.

const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }
const STEP = 0.005 // of the photo's width and height
const AT_REST = 400 // [ms] without a key, after which marks that keys moved are sent

export default function show({ data, parentElement, setTriggerValue }) {
    const place = (parentElement.marking ??= new Marking(parentElement.querySelector(".marking")))
    place.tell = marks => setTriggerValue("marks", marks)
    place.take(data)
    return () => place.send()
}

class Marking {
    constructor(root) {
        this.part = name => root.querySelector(name)
        this.unsent = null // timer of marks that are not sent yet
        this.photo = this.part(".photo")
        this.select = this.part("select")
        this.select.onchange = () => this.draw()
        this.part(".next").onclick = () => this.next()
        this.part(".undo").onclick = () => {
            this.marks = this.past.pop()
            this.done()
        }
        this.part("img").onclick = event => {
            const { left, top, width, height } = this.part("img").getBoundingClientRect()
            this.put((event.clientX - left) / width, (event.clientY - top) / height)
            this.photo.focus({ preventScroll: true })
        }
        this.photo.onblur = () => this.send() // whoever goes to another page leaves the photo first
        this.photo.onkeydown = event => {
            if (event.key === "Enter") this.next()
            else if (event.key in STEPS) {
                const [x, y] = this.marks[this.select.value] ?? [0.5, 0.5], [across, down] = STEPS[event.key]
                const step = event.shiftKey ? 10 * STEP : STEP
                this.put(x + across * step, y + down * step, AT_REST)
            } else if (event.key === "Delete") {
                this.past.push(this.marks)
                this.marks = Object.fromEntries(Object.entries(this.marks).filter(([id]) => id !== this.select.value))
                this.done()
            } else return
            event.preventDefault()
        }
    }

    take(data) {
        const { photo, marks, bores, words } = data
        if (this.part("img").getAttribute("src") !== photo) [this.part("img").src, this.past, this.marks] = [photo, [], marks]
        if (JSON.stringify([bores, words]) !== this.shape) {
            this.shape = JSON.stringify([bores, words])
            this.bores = bores
            this.words = words
            this.select.replaceChildren(...bores.map(([id]) => new Option("", id)))
            this.part("img").alt = this.photo.ariaLabel = words.title
            for (const name of ["bore", "press", "undo"]) this.part(`.${name}`).textContent = words[name]
            this.select.value = this.following() ?? bores[0][0]
        }
        this.draw()
    }

    /** The next bore without a mark, behind the one that is marked now. */
    following() {
        const ids = this.bores.map(([id]) => id), at = ids.indexOf(this.select.value)
        return [...ids.slice(at + 1), ...ids.slice(0, at)].find(id => !this.marks[id])
    }

    next() {
        this.select.value = this.following() ?? this.select.value
        this.draw()
    }

    put(x, y, after = 0) {
        this.past.push(this.marks)
        this.marks = { ...this.marks, [this.select.value]: [x, y].map(each => Math.min(Math.max(each, 0), 1)) }
        this.done(after)
    }

    done(after = 0) {
        this.draw()
        clearTimeout(this.unsent)
        this.unsent = setTimeout(() => this.send(), after)
    }

    send() {
        if (this.unsent === null) return
        clearTimeout(this.unsent)
        this.unsent = null
        this.tell(this.marks)
    }

    draw() {
        const names = Object.fromEntries(this.bores), following = this.following()
        this.photo.querySelectorAll("b").forEach(mark => mark.remove())
        for (const [id, [x, y]] of Object.entries(this.marks).filter(([id]) => id in names)) {
            const mark = document.createElement("b")
            mark.textContent = names[id].split(" ")[0]
            mark.className = id === this.select.value ? "now" : ""
            mark.style.left = `${100 * x}%`
            mark.style.top = `${100 * y}%`
            this.photo.append(mark)
        }
        for (const option of this.select.options) option.text = `${this.marks[option.value] ? "✓ " : ""}${names[option.value]}`
        const count = this.bores.filter(([id]) => this.marks[id]).length
        this.part(".marked").textContent = this.words.marked.replace("{count}", count).replace("{bores}", this.bores.length)
        this.part(".next").textContent = this.words.next.replace("{bore}", names[following] ?? "–")
        this.part(".next").hidden = !following
        this.part(".undo").disabled = !this.past.length
    }
}

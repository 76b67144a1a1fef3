// The grid for measuring: cells that are typed into at the speed of a hand or of callipers.
//
// What is typed is kept here, step by step, until the server says that the job holds it. Whatever arrives meanwhile
// changes no cell that is being typed in, and none that is on its way.

const ANSWER_WITHIN = 8000 // [ms], then what was sent is sent once more: the server does no step twice, by its number
const TOGETHER = 150 // [ms] in which entries are collected into one batch

export default function show({ data, parentElement, setStateValue }) {
    const grid = (parentElement.measuring ??= new Grid(parentElement))
    grid.send = batch => setStateValue("batch", batch)
    grid.take(data)
    return () => grid.leave()
}

const named = key => JSON.stringify(key)

function made(tag, attributes = {}, ...children) {
    const element = document.createElement(tag)
    for (const [name, value] of Object.entries(attributes)) {
        if (name.startsWith("on")) element.addEventListener(name.slice(2), value)
        else if (value !== false && value != null) element.setAttribute(name, value === true ? "" : value)
    }
    element.append(...children)
    return element
}

class Grid {
    constructor(root) {
        this.page = Math.random().toString(36).slice(2) // which page the steps come from
        this.number = 0 // of the last step
        this.sent = 0 // number of the last step that was sent
        this.steps = [] // that are not answered
        this.own = new Map() // texts that the server does not hold yet, by cell
        this.shape = "" // of the tables that stand
        this.inputs = new Map()
        this.now = null // the cell that is measured
        this.root = root.querySelector(".measuring")
        this.part = name => this.root.querySelector(`.${name}`)
        this.on_hide = () => this.hold()
        window.addEventListener("pagehide", this.on_hide)
        this.on_full = () => document.fullscreenElement || this.bench(false)
        document.addEventListener("fullscreenchange", this.on_full)
        this.root.addEventListener("click", () => this.root.matches(".bench") && this.inputs.get(this.now)?.focus())
        this.part("alone").addEventListener("click", () => this.bench(!this.root.matches(".bench")))
        for (const [name, act] of [["back", () => this.step(-1)], ["next", () => this.step(1)], ["undo", () => this.undo()]]) {
            this.part(name).addEventListener("pointerdown", event => event.preventDefault()) // the field keeps the focus
            this.part(name).addEventListener("click", () => {
                this.commit(this.now)
                act()
            })
        }
    }

    // --- what comes from the server

    take(data) {
        const first = this.data === undefined
        this.data = data
        this.cells = new Map(data.cells.map(cell => [named(cell.key), cell]))
        this.order = [...this.cells.keys()]
        this.answered(data.answer)
        const shape = JSON.stringify([this.order, data.words, data.readonly])
        const begun = shape === this.shape || this.order.some(name => this.text_of(name))
        if (!begun || !this.cells.has(this.now)) this.now = this.first_empty()
        if (shape !== this.shape) {
            this.shape = shape
            this.build()
        }
        if (first) this.fetch_held()
        this.refresh()
        this.follow(data.answer)
    }

    answered(answer) {
        if (!answer || answer.page !== this.page || !this.steps.some(step => step.number <= answer.number)) return
        const done = this.steps.filter(step => step.number <= answer.number)
        this.steps = this.steps.filter(step => step.number > answer.number)
        const later = new Set(this.steps.map(step => step.cell && named(step.cell)))
        for (const step of done) if (step.cell && !later.has(named(step.cell))) this.own.delete(named(step.cell))
        this.hold()
        if (answer.number < this.sent) return
        clearTimeout(this.waiting)
        this.waiting = null
        this.soon()
    }

    follow(answer) {
        // the server knows where a pasted block ends, and what was undone
        if (!answer || answer.page !== this.page || !answer.at || this.followed === answer.number) return
        this.followed = answer.number
        const at = named(answer.at)
        if (this.cells.has(at) && this.untouched === this.now) this.go(at)
    }

    first_empty() {
        return this.order.find(name => !this.cells.get(name).text) ?? this.order[0] ?? null
    }

    // --- what is typed

    text_of(name) {
        return this.own.get(name) ?? this.cells.get(name)?.text ?? ""
    }

    commit(name) {
        const input = this.inputs.get(name)
        if (!input || this.data.readonly) return
        const text = input.value.trim()
        if (text === this.text_of(name)) return
        this.own.set(name, text)
        this.add({ do: "put", cell: this.cells.get(name).key, text })
        this.refresh()
    }

    add(step) {
        this.steps.push({ ...step, number: ++this.number })
        this.hold()
        this.soon()
    }

    soon() {
        if (this.waiting || !this.steps.length || this.collecting) return
        this.collecting = setTimeout(() => this.dispatch(), TOGETHER)
    }

    dispatch(again = 0) {
        clearTimeout(this.collecting)
        clearTimeout(this.waiting)
        this.collecting = null
        this.untouched = this.now
        this.sent = this.number
        this.waiting = setTimeout(() => this.dispatch(again + 1), ANSWER_WITHIN)
        this.send({ page: this.page, steps: this.steps, again })
        this.refresh_state()
    }

    left(event) {
        // whoever leaves the grid may leave the page with the same click: then there is no time to collect
        this.commit(this.now)
        const elsewhere = ![...this.inputs.values()].includes(event.relatedTarget)
        if (elsewhere && this.steps.some(step => step.number > this.sent)) this.dispatch()
    }

    leave() {
        this.commit(this.now)
        this.hold()
        clearTimeout(this.waiting)
        clearTimeout(this.collecting)
        window.removeEventListener("pagehide", this.on_hide)
        document.removeEventListener("fullscreenchange", this.on_full)
        this.bench(false)
    }

    // What the server does not hold yet outlives another page and, once the job has a name, a reload of this tab.

    places() {
        return [this.data.owner, this.data.job].filter(Boolean).map(name => `atleak-measuring-${name}`)
    }

    hold() {
        if (!this.data) return
        const steps = this.steps.filter(step => step.do !== "undo")
        const input = this.inputs.get(this.now)
        if (input && !this.data.readonly && input.value.trim() !== this.text_of(this.now))
            steps.push({ do: "put", cell: this.cells.get(this.now).key, text: input.value.trim() })
        for (const place of this.places())
            if (steps.length) sessionStorage.setItem(place, JSON.stringify(steps))
            else sessionStorage.removeItem(place)
    }

    fetch_held() {
        if (this.data.readonly) return
        const held = this.places().map(place => sessionStorage.getItem(place)).find(Boolean)
        for (const step of JSON.parse(held ?? "[]")) {
            if (step.do === "put" && this.cells.has(named(step.cell))) this.own.set(named(step.cell), step.text)
            this.add(step)
        }
    }

    // --- where one is

    bench(on) {
        // one reading at a time, as large as the screen: the same fields, all but one unseen
        if (on === this.root.matches(".bench")) return
        this.root.classList.toggle("bench", on)
        this.part("alone").textContent = on ? this.data.words.sheet : this.data.words.bench
        if (on) this.root.requestFullscreen?.().catch(() => {}) // without it, over the page
        else if (document.fullscreenElement) document.exitFullscreen()
        this.go(this.now, on)
    }

    go(name, focus = true) {
        if (!this.cells.has(name)) return false
        this.ended = false
        const elsewhere = this.cells.get(name).component !== this.cells.get(this.now)?.component
        this.now = name
        if (elsewhere) {
            this.build()
            this.refresh()
        } else this.light()
        if (focus) this.inputs.get(name)?.focus({ preventScroll: false })
        return true
    }

    step(by) {
        return this.go(this.order[this.order.indexOf(this.now) + by])
    }

    below(by) {
        const { component, part, repeat } = this.cells.get(this.now)
        const column = this.order.filter(name => {
            const cell = this.cells.get(name)
            return cell.component === component && cell.part === part && cell.repeat === repeat
        })
        return this.go(column[column.indexOf(this.now) + by])
    }

    undo() {
        if (!this.data.readonly) this.add({ do: "undo" })
    }

    key(event, name) {
        const input = event.target
        const held = event.ctrlKey || event.metaKey || event.altKey
        if (event.key === "z" && held && !event.altKey && !event.shiftKey) {
            event.preventDefault()
            if (input.value.trim() !== this.text_of(name)) this.restore(input, name)
            else this.undo()
        } else if (held) return
        else if (event.key === "Escape") this.restore(input, name)
        else if (event.key === "F8") {
            event.preventDefault()
            this.commit(name)
            const doubtful = this.doubtful()
            this.go(doubtful.find(other => this.order.indexOf(other) > this.order.indexOf(name)) ?? doubtful[0])
        }
        else if (event.key === "Enter" || event.key === "Tab") {
            this.commit(name)
            const gone = this.step(event.shiftKey ? -1 : 1)
            if (gone || event.key === "Enter") event.preventDefault()
            this.ended = !gone && !event.shiftKey
            this.light()
        } else if (event.key === "ArrowDown" || event.key === "ArrowUp") {
            event.preventDefault()
            this.commit(name)
            this.below(event.key === "ArrowDown" ? 1 : -1)
        }
    }

    restore(input, name) {
        input.value = this.text_of(name)
        input.select()
        this.hold()
    }

    paste(event, name) {
        const block = event.clipboardData.getData("text/plain")
        if (this.data.readonly || !/[\t\r\n]/.test(block)) return
        event.preventDefault()
        this.restore(event.target, name)
        this.add({ do: "paste", cell: this.cells.get(name).key, text: block })
    }

    // --- what is seen

    build() {
        const typing = this.inputs.get(this.now)
        const raw = typing && typing.value !== this.text_of(this.now) ? typing.value : null
        const had_focus = typing && typing.getRootNode().activeElement === typing
        this.inputs = new Map()
        const at = this.cells.get(this.now)?.component ?? 0
        const { words } = this.data
        const component = this.data.components[at]
        this.part("title").textContent = component?.title ?? ""
        this.part("hint").textContent = words.hint
        for (const [name, text] of [["back", words.back], ["next", words.next], ["undo", words.undo]])
            this.part(name).textContent = text
        this.part("alone").textContent = this.root.matches(".bench") ? words.sheet : words.bench
        this.part("alone").hidden = this.data.readonly
        const parts = new Map()
        for (const [name, cell] of this.cells) {
            if (cell.component !== at) continue
            if (!parts.has(cell.part)) parts.set(cell.part, new Map())
            const rows = parts.get(cell.part)
            if (!rows.has(cell.place)) rows.set(cell.place, new Map())
            rows.get(cell.place).set(cell.repeat, name)
        }
        this.part("parts").replaceChildren(...[...parts].map(([part, rows]) => this.table(part, rows, component)))
        const input = this.inputs.get(this.now)
        if (raw !== null && input) input.value = raw
        if (had_focus) input?.focus()
    }

    table(part, rows, component) {
        const repeats = [...new Set([...rows.values()].flatMap(row => [...row.keys()]))].sort((a, b) => a - b)
        const { words } = this.data
        const heads = repeats.map(repeat => made("th", { scope: "col" }, `${words.repeat} ${repeat}`))
        const body = [...rows].map(([place, row]) => {
            const nominal = this.cells.get([...row.values()][0]).nominal
            const head = made("th", { scope: "row" }, place, made("small", {}, `⌀ ${nominal}`))
            return made("tr", {}, head, ...repeats.map(repeat => this.field(row.get(repeat), part, place, component)))
        })
        const title = made("caption", {}, part)
        return made("table", {}, title, made("tr", {}, made("td"), ...heads), ...body)
    }

    field(name, part, place, component) {
        if (!name) return made("td")
        const { words, readonly } = this.data
        const input = made("input", {
            type: "text",
            inputmode: "decimal",
            enterkeyhint: "next",
            autocomplete: "off",
            autocorrect: "off",
            spellcheck: "false",
            readonly,
            "aria-label": [component.label, part, place, `${words.repeat} ${this.cells.get(name).repeat}`].join(", "),
            onkeydown: event => this.key(event, name),
            onpaste: event => this.paste(event, name),
            oninput: () => this.hold(),
            onblur: event => this.left(event),
            onfocus: () => {
                this.now = name
                input.select()
                this.light()
            },
        })
        input.value = input.shown = this.text_of(name)
        this.inputs.set(name, input)
        return made("td", {}, input)
    }

    refresh() {
        for (const [name, input] of this.inputs) {
            const focused = input.getRootNode().activeElement === input
            const shown = input.shown ?? ""
            const text = this.text_of(name)
            const being_typed = focused && input.value !== shown
            if (!being_typed && input.value !== text) {
                input.value = text
                if (focused) input.select()
            }
            if (input.value.trim() === text) input.shown = input.value
            const cell = this.cells.get(name)
            const doubtful = this.is_doubtful(name)
            input.className = doubtful ? (cell.counts ? "doubted" : "refused") : ""
            input.setAttribute("aria-invalid", doubtful && !cell.counts ? "true" : "false")
        }
        this.refresh_components()
        this.refresh_lands()
        this.refresh_doubts()
        this.light()
        this.refresh_state()
    }

    refresh_components() {
        const at = this.cells.get(this.now)?.component
        const bar = this.part("components")
        const buttons = this.data.components.map((component, number) => {
            const names = this.order.filter(name => this.cells.get(name).component === number)
            const done = names.filter(name => this.text_of(name)).length
            const sign = names.some(name => this.is_doubtful(name)) ? "⚠ " : done === names.length ? "✓ " : ""
            return made(
                "button",
                {
                    type: "button",
                    class: number === at ? "chosen" : "",
                    "aria-pressed": number === at ? "true" : "false",
                    title: component.title,
                    tabindex: number === at ? 0 : -1, // one stop for Tab; arrows lead along
                    onkeydown: event => bar.children[number + ({ ArrowRight: 1, ArrowLeft: -1 }[event.key] ?? NaN)]?.focus(),
                    onclick: () => this.go(names.find(name => !this.text_of(name)) ?? names[0]),
                },
                `${sign}${component.label} `,
                made("small", {}, `${done}/${names.length}`),
            )
        })
        const drawn = JSON.stringify(buttons.map(button => button.outerHTML))
        if (bar.drawn === drawn) return
        bar.drawn = drawn
        bar.replaceChildren(...buttons)
        const chosen = bar.querySelector(".chosen")
        if (chosen) bar.scrollLeft = chosen.offsetLeft - bar.offsetLeft - bar.clientWidth / 3
    }

    refresh_lands() {
        const { words, components } = this.data
        const component = components[this.cells.get(this.now)?.component]
        if (!component) return
        const rows = component.lands.map(land => {
            const result = land.result
            if (!result) {
                const nothing = Array.from({ length: 3 }, () => made("td", {}, "–"))
                return made("tr", {}, made("th", { scope: "row" }, land.name), ...nothing, made("td", {}, land.progress))
            }
            const verdict = made("td", { class: "verdict" }, result.verdict)
            if (result.ink) Object.assign(verdict.style, { background: result.ground, color: result.ink })
            if (result.sure) verdict.append(made("small", {}, result.sure))
            return made(
                "tr",
                {},
                made("th", { scope: "row" }, land.name),
                ...[result.clearance, result.wear, result.ovality].map(text => made("td", {}, text)),
                verdict,
            )
        })
        const names = ["land", "clearance", "wear", "ovality", "verdict"]
        const heads = names.map(name => made("th", { scope: "col" }, words[name]))
        this.part("lands").replaceChildren(made("tr", {}, ...heads), ...rows)
        const drawing = this.part("drawing")
        if (drawing.drawn !== component.drawing) {
            drawing.drawn = component.drawing
            drawing.innerHTML = component.drawing // made by the server; what users named is escaped there
        }
    }

    refresh_doubts() {
        const doubtful = this.doubtful()
        const buttons = doubtful.map(name => {
            const go = made("button", { type: "button", onclick: () => this.go(name) }, this.where(name))
            go.append(made("small", {}, this.doubt(name)))
            return made("li", {}, go)
        })
        this.part("doubts").replaceChildren(...buttons)
        this.part("doubted").hidden = !doubtful.length
        this.part("doubted-title").textContent = `${this.data.words.doubtful} (${doubtful.length})`
    }

    doubtful() {
        return this.order.filter(name => this.is_doubtful(name))
    }

    is_doubtful(name) {
        return Boolean(this.cells.get(name).doubt) && !this.own.has(name)
    }

    doubt(name) {
        const cell = this.cells.get(name)
        const doubt = cell.counts ? cell.doubt : `${cell.doubt.replace(/[^.?!]$/, "$&.")} ${this.data.words.counts_not}`
        return `${this.text_of(name)}: ${doubt}`
    }

    where(name) {
        const cell = this.cells.get(name)
        const { label: component } = this.data.components[cell.component]
        return [component, cell.part, cell.place, `${this.data.words.repeat} ${cell.repeat}`].join(", ")
    }

    refresh_state() {
        const done = this.order.filter(name => this.text_of(name)).length
        const { words, readonly } = this.data
        const kept = this.steps.length ? words.under_way : words.kept
        this.part("state").textContent = [`${done}/${this.order.length}`, ...(readonly ? [] : [kept])].join(" · ")
        this.part("state").dataset.kept = String(!this.steps.length)
    }

    light() {
        const cell = this.cells.get(this.now)
        if (!cell) return
        for (const input of this.inputs.values()) for (const tag of ["table", "tr", "td"]) input.closest(tag).classList.remove("now")
        for (const tag of ["table", "tr", "td"]) this.inputs.get(this.now)?.closest(tag).classList.add("now")
        const [, , plane, direction] = cell.key
        for (const line of this.part("drawing").querySelectorAll("[data-plane]"))
            line.classList.toggle("lit", line.dataset.plane === plane)
        for (const line of this.part("drawing").querySelectorAll("[data-direction]"))
            line.classList.toggle("lit", line.dataset.direction === String(direction))
        this.say_doubt()
    }

    say_doubt() {
        // of the cell that is measured now, or else of the first that waits to be looked at
        const name = this.is_doubtful(this.now) ? this.now : this.doubtful()[0]
        const place = this.part("said")
        const cell = name && this.cells.get(name)
        const open = this.order.filter(each => !this.text_of(each)).length
        const end = this.ended ? `${this.data.words.last} ${open ? `${this.data.words.open} ${open}.` : ""}` : ""
        const text = end || !cell ? end : name === this.now ? this.doubt(name) : `${this.where(name)}: ${this.doubt(name)}`
        if (place.textContent !== text) place.textContent = text
        place.dataset.now = this.now ? this.where(this.now) : "" // shown while there is no doubt
        place.className = `said ${cell ? (cell.counts ? "doubted" : "refused") : ""}`
        place.onclick = () => name && this.go(name)
    }
}

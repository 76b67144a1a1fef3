// One cursor over all curves of the chart below: moved by the mouse over it, a click, the slider or the arrow keys.
//
// What is drawn is what is read: the curves are those that plotly holds, each with its unit and look in `meta`.

const moments = new Map() // [s] at which a chart's cursor stands, kept while the page is drawn anew

export default function show({ data, parentElement }) {
    // where the page was drawn anew its elements may be others
    if (parentElement.cursor?.slider.isConnected !== true) parentElement.cursor = new Cursor(parentElement)
    const cursor = parentElement.cursor
    cursor.take(data)
    return () => cursor.leave()
}

/** Return the place of the last of rising numbers that is not above a value; -1 below the first. */
function place(numbers, value) {
    let [low, high] = [0, numbers.length]
    while (low < high) {
        const middle = (low + high) >> 1
        if (numbers[middle] <= value) low = middle + 1
        else high = middle
    }
    return low - 1
}

class Cursor {
    constructor(root) {
        ;[this.bar, this.slider, this.time, this.values] = [".bar", "input", "output", "dl"].map(each => root.querySelector(each))
        this.line = document.createElement("div")
        this.line.style.cssText = "position:absolute; border-left:1.5px solid currentcolor; pointer-events:none; z-index:2"
        this.slider.addEventListener("input", () => this.go(Number(this.slider.value)))
        root.querySelectorAll("button").forEach((button, number) => {
            button.addEventListener("click", () => this.go(Number(this.slider.value) + (number ? 1 : -1)))
        })
        this.on_move = event => event.buttons || this.follow(event)
        this.on_click = event => this.follow(event) && this.slider.focus({ preventScroll: true }) // for its arrow keys
        this.on_plot = () => this.read()
        this.watch = new MutationObserver(() => this.find())
    }

    take(data) {
        this.data = data
        const [back, next] = this.bar.querySelectorAll("button")
        for (const [element, name] of [[back, "back"], [next, "next"], [this.slider, "cursor"]]) {
            element.ariaLabel = element.title = data.words[name]
        }
        this.watch.observe(document.body, { childList: true, subtree: true })
        this.find()
    }

    /** Take the chart once it is drawn, and again where another was drawn in its place. */
    find() {
        const name = this.data.chart.replace(/[^a-zA-Z0-9_-]/g, "-") // as Streamlit writes a key in a class
        const chart = document.querySelector(`.st-key-${name} .js-plotly-plot`)
        if (!chart?.on || chart === this.chart) return
        this.drop()
        this.chart = chart
        chart.on("plotly_afterplot", this.on_plot)
        chart.addEventListener("mousemove", this.on_move)
        chart.addEventListener("click", this.on_click, true)
        this.read()
    }

    drop() {
        if (!this.chart) return
        this.chart.removeListener?.("plotly_afterplot", this.on_plot)
        this.chart.removeEventListener("mousemove", this.on_move)
        this.chart.removeEventListener("click", this.on_click, true)
        this.line.remove()
    }

    leave() {
        this.watch.disconnect()
        this.drop()
        this.chart = null
    }

    /** Read the chart's curves, and from each row of it what stands beside its own curve. */
    read() {
        this.curves = (this.chart._fullData ?? []).filter(trace => trace.meta?.look)
        this.bar.hidden = this.values.hidden = !this.curves.length
        if (!this.curves.length) return
        this.stamps = this.chart._fullLayout.meta.stamps // those at which every curve has the sample that holds there
        this.slider.max = this.stamps.length - 1
        const kept = moments.get(this.data.chart) ?? this.stamps[0]
        this.go(Math.max(place(this.stamps, kept), 0))
    }

    /** Move to where the mouse is; tell whether it is over the curves. */
    follow(event) {
        const axis = this.chart._fullLayout?.xaxis
        if (!axis || !this.stamps) return false
        const at = event.clientX - this.chart.getBoundingClientRect().left - axis._offset
        if (at < 0 || at > axis._length) return false
        this.go(Math.max(place(this.stamps, axis.p2l(at)), 0))
        return true
    }

    go(number) {
        const step = Math.min(Math.max(number, 0), this.stamps.length - 1)
        const moment = this.stamps[step]
        moments.set(this.data.chart, moment)
        this.slider.value = step
        this.time.textContent = this.slider.ariaValueText = `${this.written(moment, 2)} s`
        this.mark(moment)
        const own = this.curves.filter(trace => trace.meta.look === "own")
        this.values.replaceChildren(...own.map(trace => this.row(trace, moment)))
    }

    mark(moment) {
        const { xaxis, _size } = this.chart._fullLayout ?? {}
        if (!xaxis) return
        const at = xaxis._offset + xaxis.l2p(moment)
        this.line.style.left = `${at}px`
        this.line.style.top = `${_size.t}px`
        this.line.style.height = `${_size.h}px`
        this.line.hidden = at < xaxis._offset || at > xaxis._offset + xaxis._length
        if (this.line.parentElement !== this.chart) this.chart.append(this.line)
    }

    row(own, moment) {
        const of = look => this.curves.filter(trace => trace.yaxis === own.yaxis && trace.meta.look === look)
        const [name, value] = [document.createElement("dt"), document.createElement("dd")]
        const small = words => value.append(Object.assign(document.createElement("small"), { textContent: words }))
        const there = this.at(own, moment)
        name.textContent = own.name.replaceAll("&lt;", "<")
        value.textContent = `${this.written(there)} ${own.meta.unit}`
        for (const other of of("over")) {
            const theirs = moment > other.x.at(-1) ? null : this.at(other, moment)
            const less = theirs === null || there === null ? null : theirs - there
            small(` | ${this.written(theirs)} (${less > 0 ? "+" : ""}${this.written(less)})`)
        }
        for (const [look, sign] of [["least", "≥"], ["most", "≤"]]) {
            const limits = of(look).map(each => this.at(each, moment)).filter(each => each !== null)
            if (limits.length) small(` ${sign} ${this.written(limits[0])}`)
        }
        const row = document.createElement("div")
        row.append(name, value)
        return row
    }

    /** Return the last value of a curve at or before a moment; null before the first and where it has none. */
    at(trace, moment) {
        const value = trace.y[place(trace.x, moment)]
        return value == null || Number.isNaN(value) ? null : value
    }

    /** Write a number with three digits and every digit before the decimal sign. */
    written(value, digits = Number.isInteger(value) ? 0 : Math.min(Math.max(2 - Math.floor(Math.log10(Math.abs(value))), 0), 5)) {
        return value == null ? "–" : value.toFixed(digits).replace("-", "−").replace(".", this.data.decimal)
    }
}

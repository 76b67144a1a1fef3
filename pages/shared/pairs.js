export default function ({ data, parentElement, setTriggerValue }) {
  const place = parentElement.querySelector(".pairs")
  if (place.shown !== data.html) place.innerHTML = place.shown = data.html // the same again would lose the focus
  for (const button of place.querySelectorAll("[data-pair]")) button.ariaPressed = String(button.dataset.pair === data.opened)
  place.onclick = (event) => {
    const button = event.target.closest("[data-pair]")
    if (button) setTriggerValue("pair", button.dataset.pair)
  }
  place.onkeydown = (event) => { // a bore on a photo is no button of HTML, which does this by itself
    const bore = event.target.closest("g[data-pair]")
    if (!bore || ![" ", "Enter"].includes(event.key)) return
    event.preventDefault()
    setTriggerValue("pair", bore.dataset.pair)
  }
}

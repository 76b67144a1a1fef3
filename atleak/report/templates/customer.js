(() => {
  const form = document.querySelector("form"), sum = document.getElementById("sum");
  if (!form || !sum) return;
  const { tax, digits, language } = sum.dataset, scale = 10 ** digits;
  const write = new Intl.NumberFormat(language, { minimumFractionDigits: digits, maximumFractionDigits: digits });
  const count = () => {
    let net = 0, known = true;  // in the smallest unit of the currency
    for (const line of form.querySelectorAll("li")) {
      const chosen = line.querySelector("input:checked");
      if (chosen ? chosen.value === "yes" : line.dataset.counts === "yes") {
        net += Math.round(Number(line.dataset.net) * scale);
        known = known && line.dataset.known === "yes";
      }
    }
    sum.textContent = (known ? "" : "≥ ") + write.format((net + Math.round(net * tax / 100)) / scale);
  };
  form.addEventListener("change", count);
  if (form.querySelector("input:checked")) count();
})();

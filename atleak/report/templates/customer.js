(() => {
  const form = document.querySelector("form"), sum = document.getElementById("sum");
  if (!form || !sum) return;
  const { tax, digits, language, least } = sum.dataset;
  const scale = 10 ** digits, write = new Intl.NumberFormat(language, { minimumFractionDigits: digits, maximumFractionDigits: digits });
  const count = () => {
    let net = 0;
    for (const line of form.querySelectorAll("li")) {
      const chosen = line.querySelector("input:checked");
      if (chosen ? chosen.value === "yes" : line.dataset.counts === "yes") net += Number(line.dataset.net);
    }
    sum.textContent = least + write.format(net + Math.round(net * tax * scale / 100) / scale);
  };
  form.addEventListener("change", count);
  if (form.querySelector("input:checked")) count();
})();

// Start of the page: reads the data in the page and shows it.

const data = JSON.parse(document.getElementById("data").textContent);
chooseTheme(document.getElementById("theme"));
prepareForPaper();
Promise.resolve(START(data)).then((page) => {
  globalThis.camopt = page;
  document.documentElement.dataset.ready = "yes";
});

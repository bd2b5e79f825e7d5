// What the page starts with: its data are in the page itself.

const data = JSON.parse(document.getElementById("data").textContent);
chooseTheme(document.getElementById("theme"));
prepareForPaper();
Promise.resolve(START(data)).then((page) => {
  globalThis.camopt = page;
  document.documentElement.dataset.ready = "yes";
});

// Printing: folded sections are opened, the page is light, and drawings get the width of the paper.

const ON_PAPER = { ".diagram svg": "330px", ".plot": "940px" }; // the printer scales a drawing of this width to its place

function prepareForPaper() {
  const { dataset } = document.documentElement;
  let folded = [], theme;
  addEventListener("beforeprint", () => {
    folded = [...document.querySelectorAll("details:not([open])")];
    for (const each of folded) each.open = true;
    theme = dataset.theme;
    dataset.theme = "light";
    drawAgain("paper", (width) => width);
  });
  addEventListener("afterprint", () => {
    for (const each of folded) each.open = false;
    if (theme) dataset.theme = theme;
    else delete dataset.theme;
    drawAgain("screen", () => "");
  });
}

/** Redraw the drawings for paper or screen. */
function drawAgain(where, widthOf) {
  for (const [selector, width] of Object.entries(ON_PAPER))
    for (const each of document.querySelectorAll(selector)) {
      each.style.width = widthOf(width);
      each.dispatchEvent(new Event(where));
    }
}

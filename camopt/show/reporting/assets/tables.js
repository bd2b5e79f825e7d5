// Tables that change: built like those of the templates, from texts.

function drawTable(parent, { title, heads, rows, note }) {
  const box = htmlElement(parent, "div", { class: "tablebox", tabindex: "0", role: "region", "aria-label": title });
  const table = htmlElement(box, "table");
  htmlElement(table, "caption", {}, title);
  const kindOf = (kind) => (kind ? { class: kind } : {});
  const top = htmlElement(htmlElement(table, "thead"), "tr");
  for (const [text, kind] of heads) htmlElement(top, "th", { scope: "col", ...kindOf(kind) }, text);
  const body = htmlElement(table, "tbody");
  for (const cells of rows) {
    const row = htmlElement(body, "tr");
    for (const [text, kind] of cells) htmlElement(row, "td", kindOf(kind), text);
  }
  if (note) htmlElement(box, "small", {}, note);
}

/** Draw the sections that unfold; open sections stay open. */
function drawSections(parent, sections) {
  const open = new Set([...parent.querySelectorAll("details[open] > summary")].map((each) => each.textContent));
  parent.replaceChildren();
  for (const { title, tables, text, detail } of sections) {
    const details = htmlElement(parent, "details", { ...(open.has(title) ? { open: "" } : {}), ...(detail ? { class: "noprint" } : {}) });
    htmlElement(details, "summary", {}, title);
    for (const each of tables) drawTable(details, each);
    if (text) htmlElement(details, "pre", {}, text);
  }
}

/** Draw the lines at the head of the page. */
function drawLines(header, lines) {
  header.querySelectorAll("p").forEach((each) => each.remove());
  for (const [text, kind] of lines) htmlElement(header, "p", kind ? { class: kind } : {}, text);
}

/** Download a text as a file. */
function saveText(name, kind, text) {
  const link = htmlElement(document.body, "a", { href: URL.createObjectURL(new Blob([text], { type: kind })), download: name });
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

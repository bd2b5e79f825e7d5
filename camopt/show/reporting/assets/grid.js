// The table of designs: sorts and filters; only visible rows are in the page.

const ROW = 26, SEEN = 16; // px, rows
const PRINTED_ROWS = 50, PRINTED_COLUMNS = 8; // on paper: size of a table that fits a page
const ROW_NAMES = ["result", "row"]; // columns that identify a row, in every printed table

class Grid {
  constructor(box, rows) {
    Object.assign(this, { rows, box, order: rows.passing, sorted: null });
    box.classList.add("grid");
    this.table = htmlElement(box, "table", { role: "grid", "aria-rowcount": rows.count + 2 });
    const head = htmlElement(this.table, "thead");
    const [titles, filters] = [htmlElement(head, "tr"), htmlElement(head, "tr", { class: "noprint" })];
    for (const column of rows.columns) {
      const cell = htmlElement(titles, "th", { scope: "col", "aria-sort": "none", class: column.words ? "" : "number" });
      const button = htmlElement(cell, "button", { type: "button", title: column.about || column.title }, column.title);
      button.addEventListener("click", () => this.sort(column, cell));
      this.filterOf(column, htmlElement(filters, "td"));
    }
    this.body = htmlElement(this.table, "tbody");
    this.focused = 0;
    box.style.height = `${ROW * SEEN + 90}px`;
    box.addEventListener("scroll", () => this.draw());
    this.body.addEventListener("keydown", (event) => this.key(event));
    head.addEventListener("keydown", (event) => this.enter(event));
    rows.listen((what) => { if (what === "filter") { this.showFilters(); this.arrange(); } else this.draw(); });
    this.paper = htmlElement(box.parentNode, "div", { class: "onlyprint" });
    box.after(this.paper);
    addEventListener("beforeprint", () => this.print());
    addEventListener("afterprint", () => this.paper.replaceChildren());
    this.arrange();
  }

  /** Print the first rows with all columns, in as many tables as the paper width needs. */
  print() {
    const { rows } = this, order = [...this.order.slice(0, PRINTED_ROWS)];
    const names = rows.columns.filter(({ name }) => ROW_NAMES.includes(name)), others = rows.columns.filter((column) => !names.includes(column));
    const title = order.length < this.order.length ? `The first ${order.length} of ${this.order.length.toLocaleString("en")} designs, in the order of the page` : "All designs that pass the filters";
    const kindOf = (column) => (column.words ? "" : "number");
    for (let k = 0; k < others.length; k += PRINTED_COLUMNS) {
      const columns = [...names, ...others.slice(k, k + PRINTED_COLUMNS)];
      const heads = columns.map((column) => [column.title, kindOf(column)]);
      drawTable(this.paper, { title, heads, rows: order.map((row) => columns.map((column) => [rows.text(column, row).replaceAll(",", ", "), kindOf(column)])) });
    }
  }

  /** The filtered rows as CSV, in the order of the page. */
  csv() {
    const quoted = (word) => (/[",\n]/.test(word) ? `"${word.replaceAll('"', '""')}"` : word);
    const cellText = ({ values, words }, row) => (words ? quoted(words[values[row]]) : Number.isNaN(values[row]) ? "" : Number(values[row].toPrecision(8)));
    const lines = [this.rows.columns.map(({ called }) => quoted(called)), ...Array.from(this.order, (row) => this.rows.columns.map((column) => cellText(column, row)))];
    return lines.map((cells) => `${cells.join(",")}\n`).join("");
  }

  filterOf(column, cell) {
    const { rows } = this;
    if (column.words) {
      const choice = htmlElement(cell, "select", { "aria-label": `filter ${column.title}` });
      htmlElement(choice, "option", { value: "" }, "all");
      column.words.forEach((word, k) => htmlElement(choice, "option", { value: k }, word || "(none)"));
      choice.addEventListener("change", () => rows.filter(column.name, choice.value === "" ? null : new Set([Number(choice.value)])));
      column.showFilter = (what) => (choice.value = what && what.size === 1 ? [...what][0] : "");
      return;
    }
    const ends = ["min", "max"].map((end) => htmlElement(cell, "input", { type: "text", inputmode: "decimal", size: 6, placeholder: end, "aria-label": `${end} ${column.title}` }));
    const read = () => {
      const [low, high] = ends.map(({ value }) => readNumber(value));
      const wrong = (end) => end.value.trim() !== "" && Number.isNaN(readNumber(end.value));
      for (const end of ends) {
        end.setAttribute("aria-invalid", String(wrong(end)));
        end.title = wrong(end) ? "a number" : "";
      }
      if (ends.some(wrong)) return;
      rows.filter(column.name, Number.isNaN(low) && Number.isNaN(high) ? null : [Number.isNaN(low) ? -Infinity : low, Number.isNaN(high) ? Infinity : high]);
    };
    for (const end of ends) end.addEventListener("change", read);
    column.showFilter = (what) => ends.forEach((end, k) => (end.value = what && Number.isFinite(what[k]) ? Number(what[k].toPrecision(6)) : ""));
  }

  showFilters() { for (const column of this.rows.columns) column.showFilter(this.rows.filters.get(column.name)); }

  sort(column, cell) {
    const rising = !(this.sorted && this.sorted.column === column && this.sorted.rising);
    this.sorted = { column, rising };
    for (const each of this.table.querySelectorAll("th")) each.setAttribute("aria-sort", "none");
    cell.setAttribute("aria-sort", rising ? "ascending" : "descending");
    this.arrange();
  }

  arrange() {
    this.order = this.rows.passing;
    if (this.sorted) {
      const { column: { values }, rising } = this.sorted, side = rising ? 1 : -1;
      this.order = Uint32Array.from(this.order).sort((a, b) => side * (values[a] - values[b]) || a - b);
    }
    this.box.scrollTop = 0;
    this.focused = 0;
    this.drawn = undefined;
    this.draw();
  }

  draw() {
    const first = Math.max(0, Math.floor(this.box.scrollTop / ROW) - 4), last = Math.min(this.order.length, first + SEEN + 12);
    const key = `${first}|${this.rows.chosen}|${this.focused}`;
    if (key === this.drawn) return;
    this.drawn = key;
    const held = this.body.contains(document.activeElement);
    this.body.replaceChildren();
    this.gap(first);
    for (let k = first; k < last; k++) this.drawRow(k);
    this.gap(this.order.length - last);
    if (held) this.body.querySelector("[tabindex='0']")?.focus({ preventScroll: true });
  }

  gap(count) {
    if (count > 0) htmlElement(this.body, "tr", { "aria-hidden": "true", class: "gap" }).style.height = `${count * ROW}px`;
  }

  drawRow(k) {
    const row = this.order[k], { rows } = this, chosen = rows.chosen.indexOf(row);
    const line = htmlElement(this.body, "tr", { tabindex: k === this.focused ? 0 : -1, "aria-rowindex": k + 3, "aria-selected": chosen >= 0, class: chosen < 0 ? "" : chosen === rows.chosen.length - 1 ? "last" : "before" });
    for (const column of rows.columns) htmlElement(line, "td", { class: column.words ? "" : "number" }, rows.text(column, row));
    line.addEventListener("click", () => { this.focused = k; rows.choose(row); });
  }

  /** Arrow down moves from the heads into the rows: heads and rows are one Tab stop each. */
  enter(event) {
    if (event.key !== "ArrowDown" || event.target.matches("select")) return;
    this.body.querySelector("[tabindex='0']")?.focus();
    event.preventDefault();
  }

  key(event) {
    const last = this.order.length;
    const step = { Home: -last, End: last, ArrowDown: 1, ArrowUp: -1, PageDown: SEEN, PageUp: -SEEN }[event.key];
    if (step) {
      this.focused = Math.min(Math.max(this.focused + step, 0), this.order.length - 1);
      const top = this.focused * ROW;
      if (top < this.box.scrollTop) this.box.scrollTop = top;
      if (top > this.box.scrollTop + (SEEN - 2) * ROW) this.box.scrollTop = top - (SEEN - 2) * ROW;
      this.draw();
      this.body.querySelector("[tabindex='0']")?.focus({ preventScroll: true });
    } else if (event.key === "Enter" || event.key === " ") this.rows.choose(this.order[this.focused]);
    else return;
    event.preventDefault();
  }
}

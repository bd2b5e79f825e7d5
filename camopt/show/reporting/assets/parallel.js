// Parallel coordinates: an axis for each column, a line for each design; drag along an axis to filter.

const AXIS = 104; // px: width of an axis with its title
const MOST_LINES = 2500; // more lines cannot be told apart; the front is always drawn

class Parallel {
  constructor(box, note, rows, names) {
    Object.assign(this, { rows, box, note });
    this.every = names.map((name) => rows.column(name));
    this.canvas = htmlElement(box, "canvas", { role: "img", "aria-label": "Parallel coordinates of all designs. The filters of the table below do the same as dragging here." });
    new ResizeObserver(() => this.draw()).observe(box);
    addEventListener("themechange", () => this.draw());
    for (const where of ["paper", "screen"]) box.addEventListener(where, () => this.draw());
    rows.listen(() => this.draw());
    this.canvas.addEventListener("pointerdown", (event) => this.press(event));
    this.canvas.addEventListener("pointermove", (event) => this.brushing && this.brush(event, false));
    this.canvas.addEventListener("pointerup", (event) => this.brushing && this.brush(event, true));
  }

  x(k) { return 60 + (k / Math.max(this.axes.length - 1, 1)) * (this.width - 120); }

  y(axis, value) {
    const range = axis.high - axis.low || 1;
    return this.height - 26 - ((Math.min(value, axis.high) - axis.low) / range) * (this.height - 70);
  }

  value(axis, py) {
    const share = Math.min(Math.max((this.height - 26 - py) / (this.height - 70), 0), 1);
    return axis.low + share * (axis.high - axis.low);
  }

  draw() {
    const { width, height } = this.box.getBoundingClientRect(), scale = devicePixelRatio || 1;
    if (!width) return;
    [this.width, this.height] = [width, height];
    this.axes = this.every.slice(0, Math.max(2, Math.floor(width / AXIS)));
    this.canvas.width = width * scale;
    this.canvas.height = height * scale;
    const pen = this.canvas.getContext("2d"), colours = palette();
    pen.scale(scale, scale);
    pen.font = "11px system-ui, sans-serif";
    this.drawLines(pen, colours);
    this.axes.forEach((axis, k) => this.drawAxis(pen, colours, axis, k));
  }

  drawLines(pen, colours) {
    const { rows } = this, front = rows.column("front");
    const all = rows.passing, step = Math.max(1, Math.ceil(all.length / MOST_LINES)), drawn = new Set();
    for (let k = 0; k < all.length; k += step) drawn.add(all[k]);
    if (front) for (const row of all) if (front.values[row]) drawn.add(row);
    pen.lineWidth = 0.8;
    pen.globalAlpha = Math.min(1, Math.max(0.08, 60 / drawn.size));
    for (const row of drawn) this.line(pen, row, rows.paint(row, colours));
    pen.globalAlpha = 1;
    pen.lineWidth = 2.5;
    rows.chosen.forEach((row, k) => this.line(pen, row, colours[k === rows.chosen.length - 1 ? "second" : "first"]));
    const passing = `${all.length.toLocaleString("en")} of ${rows.count.toLocaleString("en")} designs pass the filters`;
    const lines = drawn.size < all.length ? `; ${drawn.size.toLocaleString("en")} of them are drawn as lines` : "";
    const axes = this.axes.length < this.every.length ? `; ${this.axes.length} of ${this.every.length} axes fit` : "";
    this.note.textContent = `${passing}${lines}${axes}.`;
  }

  line(pen, row, colour) {
    pen.strokeStyle = colour;
    pen.beginPath();
    this.axes.forEach((axis, k) => pen.lineTo(this.x(k), this.y(axis, axis.values[row])));
    pen.stroke();
  }

  drawAxis(pen, colours, axis, k) {
    const at = this.x(k), words = axis.title.split(" ");
    pen.strokeStyle = colours.muted;
    pen.fillStyle = colours.ink;
    pen.textAlign = "center";
    pen.lineWidth = 1;
    pen.strokeRect(at, 44, 0, this.height - 70);
    const half = Math.ceil(words.length / 2);
    pen.fillText(words.slice(0, half).join(" "), at, 12);
    pen.fillText(words.slice(half).join(" "), at, 25);
    pen.fillStyle = colours.muted;
    pen.fillText(fourDigits(axis.high), at, 39);
    pen.fillText(fourDigits(axis.low), at, this.height - 10);
    const filter = this.rows.filters.get(axis.name);
    if (!filter) return;
    const [low, high] = filter, top = this.y(axis, Math.min(high, axis.high)), bottom = this.y(axis, Math.max(low, axis.low));
    pen.fillStyle = colours.second;
    pen.globalAlpha = 0.35;
    pen.fillRect(at - 7, top, 14, Math.max(bottom - top, 2));
    pen.globalAlpha = 1;
  }

  at(event) {
    const { left, top } = this.canvas.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  }

  press(event) {
    const [px, py] = this.at(event), k = this.axes.findIndex((_, place) => Math.abs(this.x(place) - px) < 14);
    if (k < 0) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.brushing = { axis: this.axes[k], from: py };
  }

  brush(event, ended) {
    const { axis, from } = this.brushing, [, py] = this.at(event);
    if (ended) this.brushing = undefined;
    if (Math.abs(py - from) < 4) return ended && this.rows.filter(axis.name, null);
    this.rows.filter(axis.name, [this.value(axis, from), this.value(axis, py)].sort((a, b) => a - b));
  }
}

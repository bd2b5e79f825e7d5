// Scatter plot of two columns: a dot for each row; drag a rectangle to filter, click to choose.

const NEAR = 12; // px: largest distance of a click from its dot

class Scatter {
  constructor(box, rows, [x, y]) {
    Object.assign(this, { rows, box });
    this.canvas = htmlElement(box, "canvas", { role: "img", tabindex: "-1" });
    this.over = htmlElement(box, "canvas", { class: "over", "aria-hidden": "true" });
    this.axes(x, y);
    new ResizeObserver(() => this.draw()).observe(box);
    addEventListener("themechange", () => this.draw());
    for (const where of ["paper", "screen"]) box.addEventListener(where, () => { this.onPaper = where === "paper"; this.draw(); });
    rows.listen((what) => (what === "choice" ? this.drawOver() : this.draw()));
    this.over.addEventListener("pointerdown", (event) => this.press(event));
    this.over.addEventListener("pointermove", (event) => this.move(event));
    this.over.addEventListener("pointerup", (event) => this.release(event));
  }

  axes(x, y) {
    [this.x, this.y] = [this.rows.column(x), this.rows.column(y)];
    this.canvas.setAttribute("aria-label", `${this.y.title} against ${this.x.title}, a dot for each design. The table below has the numbers.`);
    this.draw();
  }

  place(canvas) {
    const { width, height } = this.box.getBoundingClientRect(), scale = devicePixelRatio || 1;
    canvas.width = width * scale;
    canvas.height = height * scale;
    const pen = canvas.getContext("2d");
    pen.scale(scale, scale);
    pen.font = "11px system-ui, sans-serif";
    [this.width, this.height] = [width, height];
    return pen;
  }

  span(column) {
    const room = 0.03 * (column.high - column.low) || Math.abs(column.high) || 1;
    return [column.low - room, column.high + room];
  }

  toX(value) { const [low, high] = this.span(this.x); return 58 + ((value - low) / (high - low)) * (this.width - 70); }

  toY(value) { const [low, high] = this.span(this.y); return this.height - 36 - ((value - low) / (high - low)) * (this.height - 58); }

  fromX(px) { const [low, high] = this.span(this.x); return low + ((px - 58) / (this.width - 70)) * (high - low); }

  fromY(px) { const [low, high] = this.span(this.y); return low + ((this.height - 36 - px) / (this.height - 58)) * (high - low); }

  draw() {
    const pen = this.place(this.canvas), colours = palette(), { rows } = this;
    if (!this.width) return;
    this.drawAxes(pen, colours);
    const front = rows.column("front"), series = rows.column(rows.colour), [xs, ys] = [this.x.values, this.y.values];
    const dot = (row, size) => pen.fillRect(this.toX(xs[row]) - size / 2, this.toY(ys[row]) - size / 2, size, size);
    const small = rows.count > 5000 ? 1.5 : 4;
    pen.fillStyle = colours.faint;
    if (rows.passing.length < rows.count) for (let row = 0; row < rows.count; row++) if (!rows.mask[row]) dot(row, small);
    const layers = [[(row) => !rows.feasible[row], small, true], [(row) => rows.feasible[row], small], [(row) => front?.values[row], 7]];
    for (const [among, size, grey] of layers) {
      pen.globalAlpha = size === small && rows.count > 5000 ? 0.35 : 0.9;
      for (let group = 0; group < (series ? series.words.length : 1); group++) {
        pen.fillStyle = grey ? colours.muted : colours[SERIES[group % SERIES.length]];
        for (const row of rows.passing) if ((!series || series.values[row] === group) && among(row)) dot(row, size);
      }
    }
    pen.globalAlpha = 1;
    if (this.onPaper) this.drawChosen(pen, colours); // a browser prints only one of two canvases that overlap
    else this.drawOver();
  }

  drawAxes(pen, colours) {
    pen.strokeStyle = colours.faint;
    pen.fillStyle = colours.muted;
    pen.lineWidth = 0.5;
    pen.beginPath();
    for (const value of roundNumbers(...this.span(this.x), 6)) {
      const at = this.toX(value);
      pen.moveTo(at, 22); pen.lineTo(at, this.height - 36);
      pen.textAlign = "center";
      pen.fillText(fourDigits(value), at, this.height - 22);
    }
    for (const value of roundNumbers(...this.span(this.y), 5)) {
      const at = this.toY(value);
      pen.moveTo(58, at); pen.lineTo(this.width - 12, at);
      pen.textAlign = "right";
      pen.fillText(fourDigits(value), 52, at + 4);
    }
    pen.stroke();
    pen.fillStyle = colours.ink;
    pen.textAlign = "center";
    pen.fillText(this.x.title, this.width / 2, this.height - 6);
    pen.textAlign = "left";
    pen.fillText(this.y.title, 4, 10);
  }

  /** Draw the chosen designs and the rectangle that is being dragged. */
  drawOver() {
    const pen = this.place(this.over), colours = palette();
    this.drawChosen(pen, colours);
    if (!this.from) return;
    pen.strokeStyle = colours.ink;
    pen.setLineDash([4, 3]);
    pen.strokeRect(this.from[0], this.from[1], this.to[0] - this.from[0], this.to[1] - this.from[1]);
  }

  drawChosen(pen, colours) {
    this.rows.chosen.forEach((row, k) => {
      pen.strokeStyle = colours[k === this.rows.chosen.length - 1 ? "second" : "first"];
      pen.lineWidth = 2.5;
      pen.beginPath();
      pen.arc(this.toX(this.x.values[row]), this.toY(this.y.values[row]), 8, 0, 2 * Math.PI);
      pen.stroke();
    });
  }

  at(event) {
    const { left, top } = this.over.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  }

  press(event) {
    this.over.setPointerCapture(event.pointerId);
    this.from = this.to = this.at(event);
  }

  move(event) {
    if (!this.from) return;
    this.to = this.at(event);
    this.drawOver();
  }

  release(event) {
    const { from } = this, to = this.at(event);
    this.from = undefined;
    if (!from) return;
    if (Math.hypot(to[0] - from[0], to[1] - from[1]) < 4) {
      const row = this.nearest(to);
      if (row !== undefined) this.rows.choose(row);
      return this.drawOver();
    }
    const xs = [this.fromX(from[0]), this.fromX(to[0])].sort((a, b) => a - b), ys = [this.fromY(from[1]), this.fromY(to[1])].sort((a, b) => a - b);
    this.rows.filters.set(this.x.name, xs);
    this.rows.filter(this.y.name, ys);
  }

  nearest([px, py]) {
    let best = NEAR * NEAR, found;
    const front = this.rows.column("front");
    for (const row of this.rows.passing) {
      const far = (this.toX(this.x.values[row]) - px) ** 2 + (this.toY(this.y.values[row]) - py) ** 2;
      const weighed = front && front.values[row] ? far / 4 : far; // prefer designs on the front
      if (weighed < best) [best, found] = [weighed, row];
    }
    return found;
  }
}

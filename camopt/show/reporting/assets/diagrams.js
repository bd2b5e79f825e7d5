// Diagrams over the cam angle, with one cursor for all of them.

const HEIGHT = 150, LEFT = 52, RIGHT = 10, TOP = 8, BOTTOM = 22; // px

class Diagram {
  /** `series` has one panel for each cam: {panel, motion, place}. */
  constructor(parent, series, move) {
    this.series = series;
    const { title, note } = series[0].panel;
    [this.factor, this.unit] = inPowers(series);
    const unit = this.unit;
    this.figure = htmlElement(parent, "figure", { class: "diagram" });
    const caption = htmlElement(this.figure, "figcaption");
    htmlElement(caption, "b", {}, unit ? `${title}, ${unit}` : title);
    this.readouts = series.map(({ place }) => htmlElement(caption, "output", { class: `series-${place}` }));
    if (note) htmlElement(caption, "small", {}, note);
    this.svg = svgElement(this.figure, "svg", { height: HEIGHT, role: "img", "aria-label": this.inWords() });
    this.range = this.rangeOfValues();
    new ResizeObserver(() => this.draw()).observe(this.svg);
    for (const where of ["paper", "screen"]) this.svg.addEventListener(where, () => this.draw());
    this.svg.addEventListener("pointerdown", (event) => this.svg.setPointerCapture(event.pointerId));
    this.svg.addEventListener("pointermove", (event) => event.buttons && move(this.angleAt(event)));
    this.svg.addEventListener("pointerdown", (event) => move(this.angleAt(event)));
  }

  inWords() {
    const peaks = this.series.map(({ panel }) => panel.peaks.map((peak) => `${this.textOf(peak)} at ${fourDigits(peak.angle)}°`).join(", "));
    return `${this.series[0].panel.title}${this.unit ? ` in ${this.unit}` : ""} over one turn of the cam. Peaks: ${peaks.filter(Boolean).join("; ") || "none"}.`;
  }

  /** The text at a peak, with the power of ten of the diagram. */
  textOf({ text, value }) {
    return this.factor !== 1 && /\d$/.test(text) ? fourDigits(value * this.factor) : text;
  }

  angleAt(event) {
    const box = this.svg.getBoundingClientRect();
    const share = (event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT);
    return Math.min(Math.max(share, 0), 1) * 360;
  }

  rangeOfValues() {
    let low = 0, high = 0;
    const reach = (value) => { if (value !== null) { low = Math.min(low, value); high = Math.max(high, value); } };
    for (const { panel } of this.series) {
      if (panel.span) panel.span.forEach(reach);
      else [...panel.values, ...(panel.reference || [])].forEach((piece) => piece.forEach(reach));
    }
    const far = 2.5 * Math.max(-low, high);
    for (const { panel } of this.series)
      for (const { kinds, bound } of panel.limits)
        if (Math.abs(bound) <= far) { reach(bound); if (kinds.length && low < 0) reach(-bound); }
    if (high === low || this.series.some(({ panel }) => panel.impulses.length)) {
      high = Math.max(high, -low) || 1;
      low = -high;
    }
    const room = 0.14 * (high - low);
    return [low < 0 ? low - room : low - room / 4, high + room];
  }

  x(angle) { return LEFT + (angle / 360) * (this.width - LEFT - RIGHT); }

  y(value) {
    const [low, high] = this.range;
    return TOP + ((high - value) / (high - low)) * (HEIGHT - TOP - BOTTOM);
  }

  draw() {
    const width = this.svg.clientWidth;
    if (!width || width === this.width) return;
    this.width = width;
    this.svg.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
    this.svg.replaceChildren();
    this.drawGrid();
    this.series.forEach((each) => this.drawSeries(each));
    this.cursor = svgElement(this.svg, "line", { class: "cursor", y1: TOP, y2: HEIGHT - BOTTOM });
    this.dots = this.series.map(({ place }) => svgElement(this.svg, "circle", { r: 3.5, class: `dot series-${place}` }));
    if (this.at !== undefined) this.show(this.at);
  }

  drawGrid() {
    const [low, high] = this.range, bottom = HEIGHT - BOTTOM, { strokes } = this.series[0];
    for (const { kind, start, angle } of strokes)
      svgElement(this.svg, "rect", { x: this.x(start), y: TOP, width: this.x(start + angle) - this.x(start), height: bottom - TOP, class: `shade ${kind}` });
    const steps = this.width < 420 ? 90 : this.width < 700 ? 60 : 30;
    for (let angle = 0; angle <= 360; angle += steps) {
      svgElement(this.svg, "line", { x1: this.x(angle), x2: this.x(angle), y1: TOP, y2: bottom, class: "grid" });
      svgElement(this.svg, "text", { x: this.x(angle) + (angle === 360 ? 8 : 0), y: HEIGHT - 6, class: angle === 360 ? "tick end" : "tick middle" }).textContent = `${angle}°`;
    }
    for (const value of roundNumbers(low, high, 4)) {
      svgElement(this.svg, "line", { x1: this.x(0), x2: this.x(360), y1: this.y(value), y2: this.y(value), class: value ? "grid" : "grid zero" });
      svgElement(this.svg, "text", { x: LEFT - 6, y: this.y(value) + 4, class: "tick end" }).textContent = fourDigits(value * this.factor);
    }
  }

  drawSeries({ panel, motion, strokes, place }) {
    const clip = (value) => Math.min(Math.max(value, this.range[0]), this.range[1]);
    for (const [low, high] of panel.bands)
      svgElement(this.svg, "rect", { x: this.x(0), y: this.y(high), width: this.x(360) - this.x(0), height: Math.max(this.y(low) - this.y(high), 1), class: "band" });
    this.drawLimits(panel, strokes);
    if (panel.undercut) motion.pieces.forEach((piece, k) => this.drawUndercut(piece.angle, panel.undercut[k]));
    motion.pieces.forEach((piece, k) => {
      for (const [values, kind] of [[panel.reference, "reference"], [panel.other, "other"], [panel.values, "curve"]])
        if (values) svgElement(this.svg, "path", { d: this.line(piece.angle, values[k], clip), class: `${kind} ${piece.kind} series-${place}` });
    });
    this.drawRisers(panel, motion, place);
    for (const [start, end, low, high] of panel.marks)
      svgElement(this.svg, "rect", { x: this.x(start) - 2.5, y: this.y(high) - 2.5, width: this.x(end) - this.x(start) + 5, height: this.y(low) - this.y(high) + 5, class: "mark" });
    const largest = Math.max(...panel.impulses.map(({ size }) => Math.abs(size)), 0);
    for (const { angle, size } of panel.impulses) {
      const tip = this.y((0.35 + 0.5 * (Math.abs(size) / largest)) * this.range[1] * Math.sign(size)), back = 7 * Math.sign(size);
      const at = this.x(angle), d = `M${at} ${this.y(0)}V${tip}M${at - 4} ${tip + back}L${at} ${tip}L${at + 4} ${tip + back}`;
      svgElement(this.svg, "path", { d, class: "impulse" });
    }
    this.drawPeaks(panel, place);
  }

  line(angles, values, clip) {
    let pen = "M", d = "";
    values.forEach((value, k) => {
      if (value === null) { pen = "M"; return; }
      d += `${pen}${this.x(angles[k]).toFixed(2)} ${this.y(clip(value)).toFixed(2)}`;
      pen = "L";
    });
    return d;
  }

  drawLimits(panel, strokes) {
    const level = (bound, from, to) => {
      if (bound > this.range[0] && bound < this.range[1])
        svgElement(this.svg, "line", { x1: this.x(from), x2: this.x(to), y1: this.y(bound), y2: this.y(bound), class: "limit" });
    };
    for (const { kinds, bound } of panel.limits) {
      if (!kinds.length) level(bound, 0, 360);
      for (const { kind, start, angle } of strokes)
        if (kinds.includes(kind) || (kinds.length && kind === "move")) [bound, -bound].forEach((each) => level(each, start, start + angle));
    }
  }

  drawRisers(panel, motion, place) {
    const range = this.range[1] - this.range[0];
    panel.values.forEach((values, k) => {
      const earlier = panel.values.at(k - 1), before = earlier[earlier.length - 1], after = values[0];
      if (before === null || after === null || Math.abs(after - before) <= 1e-6 * range) return;
      const at = this.x(motion.pieces[k].angle[0]);
      svgElement(this.svg, "line", { x1: at, x2: at, y1: this.y(before), y2: this.y(after), class: `riser series-${place}` });
    });
  }

  /** A band for each run of undercut samples; in a pale colour, since printers lose opacity. */
  drawUndercut(angles, bad) {
    for (let k = 1; k < bad.length; k++) {
      if (!bad[k]) continue;
      const start = this.x(angles[k - 1]);
      while (bad[k + 1]) k++;
      svgElement(this.svg, "rect", { x: start, y: TOP, width: this.x(angles[k]) - start, height: HEIGHT - TOP - BOTTOM, class: "undercut" });
    }
  }

  /** Peaks with their exact values. A text that would overlap another is left out; the aria-label has it. */
  drawPeaks(panel, place) {
    const written = this.written || (this.written = []);
    if (place === this.series[0].place) written.length = 0;
    for (const peak of panel.peaks) {
      const { angle, value } = peak, text = this.textOf(peak);
      if (value === null) continue;
      const [x, y] = [this.x(angle), this.y(value)];
      svgElement(this.svg, "circle", { cx: x, cy: y, r: 2.5, class: `peak series-${place}` });
      const half = 3.4 * text.length, found = this.placeFor(x, y, half, value >= 0, written);
      if (!found) continue;
      written.push([...found, half]);
      svgElement(this.svg, "text", { x: found[0], y: found[1], class: `value middle series-${place}` }).textContent = text;
    }
  }

  /** A place for a text beside a peak that overlaps no other text: outwards, inwards, right or left. */
  placeFor(x, y, half, up, written) {
    const [above, below] = [Math.max(y - 6, TOP + 9), Math.min(y + 15, HEIGHT - BOTTOM - 3)], outwards = up ? above : below;
    const across = (at) => Math.min(Math.max(at, LEFT + half), this.width - RIGHT - half);
    const places = [[x, outwards], [x, up ? below : above], [x + half + 8, outwards], [x - half - 8, outwards], [x + half + 8, y + 4], [x - half - 8, y + 4]];
    return places.map(([a, b]) => [across(a), b]).find(([a, b]) => !written.some(([c, d, h]) => Math.abs(a - c) < h + half && Math.abs(b - d) < 12));
  }

  /** Move the cursor to a cam angle in deg, and show the values there. */
  show(angle) {
    this.at = angle;
    if (!this.cursor) return;
    const x = this.x(angle);
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
    this.series.forEach((each, k) => {
      const value = valueAt(each.motion.pieces, each.panel.values, angle);
      const nothing = Math.abs(value) < 1e-6 * (this.range[1] - this.range[0]); // 0 with rounding errors
      this.readouts[k].textContent = value === null ? "–" : fourDigits(nothing ? 0 : value * this.factor);
      this.dots[k].setAttribute("visibility", value === null ? "hidden" : "visible");
      this.dots[k].setAttribute("cx", x);
      this.dots[k].setAttribute("cy", this.y(Math.min(Math.max(value || 0, this.range[0]), this.range[1])));
    });
  }
}

/** A factor for short numbers in a diagram, and the unit with its power of ten. */
function inPowers(series) {
  let largest = 0;
  for (const { panel } of series)
    for (const piece of panel.values) for (const value of piece) largest = Math.max(largest, Math.abs(value || 0));
  const { unit } = series[0].panel;
  if (largest === 0 || (largest >= 1e-2 && largest < 1e4)) return [1, unit];
  const power = 3 * Math.floor(Math.log10(largest) / 3);
  return [10 ** -power, `10${[...String(power)].map((each) => SUPERSCRIPTS[each]).join("")} ${unit}`];
}

const SUPERSCRIPTS = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

/** The value at a cam angle, interpolated between samples; null in a gap. */
function valueAt(pieces, values, degrees) {
  const found = pieces.findIndex((each) => degrees <= each.angle[each.angle.length - 1]);
  const place = found < 0 ? pieces.length - 1 : found, angles = pieces[place].angle, row = values[place];
  const k = Math.min(Math.max(firstAbove(angles, degrees), 1), angles.length - 1);
  const [a, b] = [row[k - 1], row[k]];
  if (a === null || b === null) return null;
  const t = Math.min(Math.max((degrees - angles[k - 1]) / (angles[k] - angles[k - 1]), 0), 1);
  return a + t * (b - a);
}

/** The motion, strokes and panels of a cam, later in the turn by its shift in deg. A piece that passes 360° is cut there. */
function laterBy(cam) {
  const { shift = 0, motion: { pieces }, strokes, panels } = cam;
  if (!shift) return cam;
  const late = (angle) => (((angle + shift) % 360) + 360) % 360;
  const cuts = pieces.map(({ angle }) => {
    const back = Math.floor((angle[0] + shift) / 360) * 360 - shift;
    const angles = angle.map((each) => each - back), k = angles.findIndex((each) => each > 360);
    return { angles, k, share: k > 0 ? (360 - angles[k - 1]) / (angles[k] - angles[k - 1]) : 0 };
  });
  const cut = (values, { k, share }) => {
    if (k < 1) return [values];
    const [a, b] = [values[k - 1], values[k]], middle = typeof a === "number" && typeof b === "number" ? a + share * (b - a) : b;
    return [[...values.slice(0, k), middle], [middle, ...values.slice(k)]];
  };
  const parts = cuts.flatMap((each, place) => cut(each.angles, each).map((angle, part) => ({ kind: pieces[place].kind, angle: part ? angle.map((x) => x - 360) : angle })));
  const order = [...parts.keys()].sort((a, b) => parts[a].angle[0] - parts[b].angle[0]);
  const sorted = (rows) => rows && order.map((k) => rows.flatMap((values, place) => cut(values, cuts[place]))[k]);
  const moved = strokes.flatMap((each) => {
    const start = late(each.start), over = start + each.angle - 360;
    return over > 1e-9 ? [{ ...each, start, angle: 360 - start }, { ...each, start: 0, angle: over }] : [{ ...each, start }];
  });
  return {
    ...cam, strokes: moved, motion: { ...cam.motion, pieces: order.map((k) => parts[k]) },
    panels: panels.map((panel) => ({
      ...panel, values: sorted(panel.values), reference: sorted(panel.reference), other: sorted(panel.other), undercut: sorted(panel.undercut),
      peaks: panel.peaks.map((peak) => ({ ...peak, angle: late(peak.angle) })), impulses: panel.impulses.map((each) => ({ ...each, angle: late(each.angle) })),
      marks: panel.marks.map(([start, end, ...levels]) => [late(start), late(start) + end - start, ...levels]),
    })),
  };
}

/** All diagrams of the cams: panels with the same title and unit share a diagram. */
function drawDiagrams(parent, cams, move) {
  const groups = new Map();
  cams.map(laterBy).forEach((cam, place) => {
    for (const panel of cam.panels) {
      const key = `${panel.title}|${panel.unit}`;
      if (!groups.has(key)) groups.set(key, []);
      groups.get(key).push({ panel, motion: cam.motion, strokes: cam.strokes, place });
    }
  });
  parent.classList.toggle("compared", cams.length > 1);
  return [...groups.values()].map((series) => new Diagram(parent, series, move));
}

// The rows of a result: columns of numbers or words, filters, and chosen designs.

class Rows {
  constructor(table, count) {
    this.count = count;
    this.columns = table;
    this.filters = new Map(); // by column: [low, high], or a Set of indices of words
    this.chosen = []; // the last chosen at the end
    this.listeners = [];
    const feasible = this.column("feasible"); // without this column all designs are feasible
    this.feasible = Uint8Array.from({ length: count }, (_, row) => (feasible && feasible.words[feasible.values[row]] === "no" ? 0 : 1));
    this.passing = Uint32Array.from({ length: count }, (_, row) => row);
    this.mask = new Uint8Array(count).fill(1);
  }

  column(name) { return this.columns.find((each) => each.name === name); }

  get numeric() { return this.columns.filter((each) => !each.words); }

  text(column, row) {
    const value = column.values[row];
    if (column.words) return column.words[value];
    if (Number.isInteger(value)) return String(value).replace("-", "−");
    return Number.isNaN(value) ? "" : Number.isFinite(value) ? String(Number(value.toPrecision(6))).replace("-", "−") : fourDigits(value);
  }

  /** Filter a column; null removes its filter. All views of the rows are redrawn. */
  filter(name, what) {
    if (what === null) this.filters.delete(name);
    else this.filters.set(name, what);
    this.apply();
  }

  clear() {
    this.filters.clear();
    this.apply();
  }

  apply() {
    this.mask.fill(1);
    for (const [name, what] of this.filters) {
      const { values, words } = this.column(name);
      if (words) for (let row = 0; row < this.count; row++) this.mask[row] &= what.has(values[row]) ? 1 : 0;
      else {
        const [low, high] = [loosened(what[0], -1), loosened(what[1], 1)];
        for (let row = 0; row < this.count; row++) this.mask[row] &= values[row] >= low && values[row] <= high ? 1 : 0;
      }
    }
    let n = 0;
    const found = new Uint32Array(this.count);
    for (let row = 0; row < this.count; row++) if (this.mask[row]) found[n++] = row;
    this.passing = found.subarray(0, n);
    this.tell("filter");
  }

  /** The name of a row, with its number in the file, as for `--row`. */
  called(row) {
    const front = this.column("front"), file = this.files[front && !front.values[row] ? 1 : 0] ?? this.files[0];
    const where = file || this.column("result")?.words[this.column("result").values[row]];
    return `Row ${this.column("row").values[row]}${where ? ` of ${where}` : ""}`;
  }

  /** The colour of a row: that of its series; grey if the design is not feasible. */
  paint(row, colours) {
    const series = this.column(this.colour);
    return this.feasible[row] ? colours[SERIES[(series ? series.values[row] : 0) % SERIES.length]] : colours.muted;
  }

  choose(row) {
    if (this.chosen.at(-1) !== row) this.chosen = [...this.chosen.slice(-1), row];
    this.tell("choice");
  }

  listen(listener) { this.listeners.push(listener); }

  tell(what) { for (const listener of this.listeners) listener(what); }
}

/** A bound widened by rounding to six digits, so that a row shown with this number passes. */
const loosened = (value, side) => value + side * 6e-7 * (Number.isFinite(value) ? Math.abs(value) : 0);

/** A number from a text with decimal point or comma, or commas between thousands; NaN if it is not a number. */
function readNumber(text) {
  const plain = text.trim().replace("−", "-");
  if (!plain) return NaN;
  return Number(/^-?\d{1,3}(,\d{3})+(\.\d*)?$/.test(plain) ? plain.replaceAll(",", "") : plain.replace(",", "."));
}

/** Bytes from base64, inflated. */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (each) => each.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

/** Columns from the page: floats in byte planes, words as indices of their list. */
async function unpackedColumns(packedColumns, count) {
  return Promise.all(packedColumns.map(async (column) => {
    const buffer = await unpacked(column.packed);
    if (column.words) return { ...column, values: new Uint16Array(buffer) };
    const planes = new Uint8Array(buffer), whole = new Uint8Array(4 * count);
    for (let plane = 0; plane < 4; plane++)
      for (let row = 0; row < count; row++) whole[4 * row + plane] = planes[plane * count + row];
    const values = new Float32Array(whole.buffer);
    let low = Infinity, high = -Infinity;
    for (const value of values) if (Number.isFinite(value)) { low = Math.min(low, value); high = Math.max(high, value); }
    return { ...column, values, low, high };
  }));
}

/** Colours from the style of the page, for the light or dark theme. */
function palette() {
  const style = getComputedStyle(document.documentElement);
  const probe = document.createElement("i");
  document.body.append(probe);
  const found = {};
  for (const name of ["ink", "muted", "faint", "paper", "alarm", "rise", ...SERIES]) {
    probe.style.color = `var(--${name})`;
    found[name] = getComputedStyle(probe).color;
  }
  probe.remove();
  return found;
}

const SERIES = ["first", "second", "third", "fourth", "fifth", "sixth", "seventh"];

// Helpers for SVG, HTML and shown numbers.

const SVG = "http://www.w3.org/2000/svg";

function svgElement(parent, name, attributes = {}) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent.append(element);
  return element;
}

function htmlElement(parent, name, attributes = {}, text = "") {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text) element.textContent = text;
  parent.append(element);
  return element;
}

/** A number with four significant digits, or all digits before the point, and a real minus sign. */
function fourDigits(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const size = Math.abs(value);
  const text = size >= 1e4 && size < 1e7 ? value.toFixed(0) : size !== 0 && (size >= 1e7 || size < 1e-4)
    ? value.toExponential(3) : String(Number(value.toPrecision(4)));
  return text.replace("-", "−");
}

const pathOf = (points, close = false) =>
  points.length ? "M" + points.map(([x, y]) => `${+x.toFixed(4)} ${+y.toFixed(4)}`).join("L") + (close ? "Z" : "") : "";

/** About `count` round numbers in a range. */
function roundNumbers(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].find((each) => each * power >= rough) * power;
  const numbers = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) numbers.push(k === 0 ? 0 : k * step);
  return numbers;
}

// The page of a machine: its cams and tools, and a cursor in its timing diagram, at one angle of the shaft.

/** The value of a list over a turn at an angle in deg, between its entries. */
function valueAt(values, degrees) {
  const place = (degrees / 360) * (values.length - 1), low = Math.min(Math.floor(place), values.length - 2);
  return values[low] + (place - low) * (values[low + 1] - values[low]);
}

/** Draw the outlines of tools and bodies to scale; return the function that moves them. */
function drawTools(stage, { tools, box: [left, bottom, right, top] }) {
  const figure = htmlElement(stage, "figure");
  htmlElement(figure, "figcaption", {}, "Tools");
  const svg = svgElement(figure, "svg", { class: "cam tools", role: "img", "aria-label": "outlines of the tools, to scale", viewBox: `${left} ${-top} ${right - left} ${top - bottom}` });
  const size = (right - left + top - bottom) / 45;
  const groups = tools.map(({ name, outline, middle, station }) => {
    const group = svgElement(svg, "g", { class: station === null ? "" : `series-${station % 6}` });
    svgElement(group, "path", { d: pathOf(pairs(outline).map(([x, y]) => [x, -y]), true), ...FIXED });
    svgElement(group, "text", { x: middle[0], y: -middle[1], "font-size": size }).textContent = name;
    return group;
  });
  return (degrees) => tools.forEach(({ x, y, turned, pivot }, k) => {
    const turn = turned ? `rotate(${-valueAt(turned, degrees)} ${pivot[0]} ${-pivot[1]})` : `translate(${valueAt(x, degrees)} ${-valueAt(y, degrees)})`;
    groups[k].setAttribute("transform", turn);
  });
}

/** The cursor over the picture of the timing diagram, which the pointer drags; return the function that moves it. */
function followTiming(figure, { left, right, top, stations }, turnTo) {
  const svg = figure.querySelector("svg"), cursor = svg.querySelector(".cursor"), output = svg.querySelector(".angle");
  const groups = [...svg.querySelectorAll(".station")];
  const drag = (event) => {
    if (event.type === "pointermove" && !event.buttons) return;
    const { x } = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    turnTo(Math.min(Math.max(((x - left) / (right - left)) * 360, 0), 360));
  };
  svg.onpointerdown = svg.onpointermove = drag;
  return (degrees) => {
    const x = left + ((right - left) * degrees) / 360;
    for (const end of ["x1", "x2"]) cursor.setAttribute(end, x);
    output.textContent = `${degrees.toFixed(1)}°`;
    stations.forEach(({ lift, low, high, largest, unit }, k) => {
      const value = valueAt(lift, degrees), [dot, text] = [groups[k].querySelector("circle"), groups[k].querySelector("text")];
      dot.setAttribute("cx", x);
      dot.setAttribute("cy", largest ? low + ((high - low) * value) / largest : low);
      text.textContent = `${fourDigits(Math.abs(value) < 1e-9 * largest ? 0 : value)} ${unit}`;
    });
  };
}

function showMachinePage(data, player = new Player(document.getElementById("player"))) {
  const find = (id) => document.getElementById(id);
  showCams(player, find("stage"), null, data.cams, data.labels, data.words, null);
  if (data.tools) player.follow(drawTools(find("stage"), data.tools));
  player.follow(followTiming(find("timing"), data.timing, (angle) => { player.stop(); player.go(angle); }));
  player.go(0);
  return { player };
}

const START = (data) => (typeof ServeMachinePage === "undefined" ? showMachinePage(data) : new ServeMachinePage(data));

// The page of tables of designs: scatter plot, parallel coordinates, table and chosen cams.

async function showResultsPage(data) {
  const find = (id) => document.getElementById(id);
  const rows = new Rows(await unpackedColumns(data.columns, data.count), data.count);
  const motions = JSON.parse(new TextDecoder().decode(await unpacked(data.motions)));
  const motionOf = new Uint16Array(await unpacked(data.motion_of));
  rows.colour = data.colour;
  rows.files = data.files;
  rows.cam = (row) => camOfRow(rows, data.results, motions[motionOf[row]], row);
  const player = new Player(find("player"));
  const scatter = new Scatter(find("scatter"), rows, data.axes);
  const choices = ["x", "y"].map((axis) => find(`axis-${axis}`));
  choices.forEach((choice, k) => {
    for (const column of rows.numeric) htmlElement(choice, "option", { value: column.name }, column.title);
    choice.value = data.axes[k];
    choice.addEventListener("change", () => scatter.axes(...choices.map((each) => each.value)));
  });
  showColours(find("colours"), rows);
  new Parallel(find("parallel"), find("passing"), rows, data.parallel);
  const grid = new Grid(find("table"), rows);
  find("clear").addEventListener("click", () => rows.clear());
  find("save").addEventListener("click", () => saveText(`${document.title.replace(/[^\w-]+/g, "-")}.csv`, "text/csv", grid.csv()));
  const show = () => showChosen(rows, player, find);
  rows.listen((what) => what === "choice" && show());
  for (const row of data.first) rows.choose(row);
  return { player, rows, scatter, grid };
}

/** The legend of colours. */
function showColours(list, rows) {
  const column = rows.column(rows.colour);
  if (rows.column("feasible")?.words.includes("no")) htmlElement(list, "li", { class: "grey" }, "not feasible");
  if (rows.column("front")) htmlElement(list, "li", { class: "large" }, "large: on the Pareto front");
  if (column) column.words.forEach((word, k) => htmlElement(list, "li", { class: SERIES[k % SERIES.length] }, `${column.title}: ${word || "(none)"}`));
}

/** The cam of a row, with the sizes and motion of the row; null if the page lacks its motion. */
function camOfRow(rows, results, motion, row) {
  const result = results[rows.column("result")?.values[row] ?? 0], sizes = { ...result.sizes };
  for (const [size, name] of Object.entries(result.columns)) sizes[size] = rows.column(name).values[row] * rows.column(name).scale; // mm
  const steepest = rows.column("pressure_angle_max_deg")?.values[row];
  const broken = rows.column("violated"), undercut = !!broken && /undercut|self_crossing/.test(broken.words[broken.values[row]]);
  return motion ? { ...result.kind, ...motion, sizes, steepest, undercut } : null;
}

function showChosen(rows, player, find) {
  const cams = rows.chosen.map(rows.cam);
  const labels = rows.chosen.map((row) => rows.called(row)), broken = rows.column("violated");
  const words = rows.chosen.map((row) => (rows.feasible[row] ? [] : [`not feasible${broken ? `: ${rows.text(broken, row).replaceAll("_", " ").replaceAll(",", ", ")}` : ""}`]));
  find("chosen-note").textContent = cams.includes(null)
    ? "The page does not contain the motion of this row. camopt report TABLE --row N draws it." : "";
  const there = [...cams.keys()].filter((k) => cams[k]), of = (list) => there.map((k) => list[k]);
  showCams(player, find("stage"), null, of(cams), of(labels), of(words));
  player.go(player.angle);
  showDifferences(find("differences"), rows, labels);
}

/** The numbers of the chosen rows side by side. */
function showDifferences(box, rows, labels) {
  box.replaceChildren();
  const table = htmlElement(box, "table"), head = htmlElement(htmlElement(table, "thead"), "tr"), body = htmlElement(table, "tbody");
  for (const text of ["", ...labels]) htmlElement(head, "th", { scope: "col", class: "number" }, text);
  for (const column of rows.columns) {
    const line = htmlElement(body, "tr");
    htmlElement(line, "th", { scope: "row" }, column.title);
    for (const row of rows.chosen) htmlElement(line, "td", { class: "number" }, rows.text(column, row));
  }
}

const START = showResultsPage;

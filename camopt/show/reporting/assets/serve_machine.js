// The page of a machine with a slider for each phase.

class ServeMachinePage extends ServedPage {
  constructor(data) {
    super(data.own, "All phases are reset.");
    this.data = data;
    this.page = showMachinePage(data);
  }

  /** Change phases by station: the cams turn at once, all else when the sliders rest. */
  change(values, moved) {
    super.change(values, moved);
    this.data.cams.forEach((cam, k) => (cam.shift = this.values[this.data.labels[k]]));
    this.page.player.go(this.page.player.angle);
    this.find("timing").classList.add("stale");
  }

  show(answer, rests) {
    for (const control of this.controls) control.complain();
    if (answer.mistakes) return this.complain(answer.mistakes);
    if (!rests) return;
    const angle = this.page.player.angle;
    this.page.player.stop();
    this.data = answer.data;
    drawLines(document.querySelector("header"), answer.lines);
    this.find("timing").querySelector("img").src = answer.timing;
    this.find("timing").classList.remove("stale");
    const results = this.find("results");
    results.replaceChildren();
    for (const table of answer.tables) drawTable(results, table);
    this.page = showMachinePage(answer.data, this.page.player);
    this.page.player.go(angle);
  }
}

// The page of one cam with its controls.

class ServePage extends ServedPage {
  constructor(data) {
    super(data.own, "All controls are reset.");
    this.label = data.label;
    this.player = new Player(this.find("player"));
    this.draw(data.answer.cam, true);
    this.player.go(0);
    this.find("smallest").addEventListener("click", () => this.smallest().catch((trouble) => this.fail(trouble)));
    this.find("report").addEventListener("click", () => this.download().catch((trouble) => this.fail(trouble)));
  }

  /** Show an answer of the server; `newest` if no control has moved since its request. */
  show(answer, proved, newest) {
    for (const control of this.controls) control.complain();
    this.find("stage").classList.toggle("stale", Boolean(answer.mistakes && !answer.picture));
    if (answer.picture) {
      for (const id of ["stage", "legend"]) this.find(id).replaceChildren();
      drawLines(document.querySelector("header"), answer.mistakes.map(({ text }) => [text, "verdict broken"]));
      htmlElement(this.find("stage"), "img", { src: answer.picture, alt: "The linkage, as far as it goes" });
    }
    if (answer.mistakes) return this.complain(answer.mistakes);
    if (newest) {
      this.values = answer.values;
      for (const control of this.controls) if (control.key !== this.moved) control.show(answer.values[control.key]);
    }
    drawLines(document.querySelector("header"), answer.lines);
    const limits = this.find("limits");
    limits.style.minHeight = proved ? "" : `${limits.offsetHeight}px`; // so that the page below does not jump while controls move
    limits.replaceChildren();
    drawTable(limits, answer.limits);
    if (proved) drawSections(this.find("sections"), answer.sections);
    this.draw(answer.cam, proved);
  }

  /** Draw the cam, or keep the last one if it cannot be made. The scale stays while controls move, so that a cam visibly grows. */
  draw(cam, proved) {
    if (!cam.exists && this.box) return this.find("stage").classList.add("stale");
    const box = showCams(this.player, this.find("stage"), this.find("diagrams"), [cam], [this.label], [], proved || !this.box ? [] : [this.box]);
    if (box) this.box = box;
  }

  async smallest() {
    const button = this.find("smallest");
    if (this.searching) return void (await ask("stop", { values: {} }));
    this.searching = true;
    button.textContent = "Stop the search";
    this.status.textContent = "Searching for the smallest cam that meets the limits (at most 60 s) …";
    try {
      const found = await ask("smallest", { values: this.values });
      if (found.values) this.set(found.values, found.told);
      else if (found.mistakes) this.complain(found.mistakes);
      else this.status.textContent = `No smallest cam: ${found.why}.`;
    } finally {
      this.searching = false;
      button.textContent = "Smallest cam";
    }
  }

  async download() {
    const found = await ask("report", this.question());
    if (found.mistakes) return this.complain(found.mistakes);
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([found.text], { type: "text/html" }));
    link.download = found.name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }
}

const START = (data) => new ServePage(data);

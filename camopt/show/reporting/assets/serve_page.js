// The page of one cam with its controls.

class ServePage {
  constructor(data) {
    const find = (id) => document.getElementById(id);
    Object.assign(this, { find, label: data.label, own: data.own, values: { ...data.own }, moved: "" });
    this.player = new Player(find("player"));
    this.status = find("status");
    const moved = (key, value) => this.change({ [key]: value }, key);
    this.controls = [...document.querySelectorAll(".control")].map((each) => new Control(each, moved));
    const question = () => ({ values: this.values, moved: this.moved });
    this.requests = new RequestQueue(question, (...shown) => this.show(...shown), (trouble) => this.fail(trouble));
    this.draw(data.answer.cam, true);
    this.player.go(0);
    find("start").addEventListener("click", () => this.set(this.own, "All controls are reset."));
    find("smallest").addEventListener("click", () => this.smallest().catch((trouble) => this.fail(trouble)));
    find("report").addEventListener("click", () => this.download().catch((trouble) => this.fail(trouble)));
    find("save").addEventListener("submit", (event) => { event.preventDefault(); this.save(false); });
    find("overwrite").addEventListener("click", () => this.save(true));
    find("file").addEventListener("input", () => (find("overwrite").hidden = true));
  }

  /** Change the values of controls by key; `moved` is the control that the user moves. */
  change(values, moved = "") {
    Object.assign(this.values, values);
    this.moved = moved;
    this.requests.changed();
  }

  /** Set the values of all controls, and show a sentence. */
  set(values, told) {
    for (const control of this.controls) control.show(values[control.key]);
    this.change(values);
    this.status.textContent = told;
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

  /** Show mistakes beside their controls, else beside the control that was moved. */
  complain(mistakes) {
    const texts = new Map();
    for (const { key, text } of mistakes) {
      const control = this.controls.find((each) => each.key === key) || this.controls.find((each) => each.key === this.moved);
      const told = control ? (control.key === key ? text : `${key}: ${text}`) : `${key}: ${text}`;
      texts.set(control, [...(texts.get(control) || []), told]);
    }
    for (const [control, found] of texts) {
      if (control) control.complain(found.join("; "));
      else this.status.textContent = found.join("; ");
    }
  }

  fail(trouble) {
    this.status.textContent = trouble instanceof TypeError ? "The server has ended: start camopt serve again." : `Error: ${trouble.message}.`;
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
    const found = await ask("report", { values: this.values, moved: this.moved });
    if (found.mistakes) return this.complain(found.mistakes);
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([found.text], { type: "text/html" }));
    link.download = found.name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  async save(overwrite) {
    try {
      const name = this.find("file").value;
      const found = await ask("save", { values: this.values, moved: this.moved, name, overwrite });
      this.find("overwrite").hidden = !found.exists;
      if (found.mistakes) return this.complain(found.mistakes);
      this.status.textContent = found.exists ? `${found.exists} exists already.` : `Saved ${found.saved}`;
    } catch (trouble) {
      this.fail(trouble);
    }
  }
}

const START = (data) => new ServePage(data);

// The page of a machine with a slider for each phase.

class ServeMachinePage {
  constructor(data) {
    const find = (id) => document.getElementById(id);
    Object.assign(this, { find, data, own: data.own, values: { ...data.own }, status: find("status") });
    this.page = showMachinePage(data);
    const moved = (key, value) => this.change({ [key]: value });
    this.controls = [...document.querySelectorAll(".control")].map((each) => new Control(each, moved));
    this.requests = new RequestQueue(() => ({ values: this.values }), (...shown) => this.show(...shown), (trouble) => this.fail(trouble));
    find("start").addEventListener("click", () => this.reset());
    find("save").addEventListener("submit", (event) => { event.preventDefault(); this.save(false); });
    find("overwrite").addEventListener("click", () => this.save(true));
    find("file").addEventListener("input", () => (find("overwrite").hidden = true));
  }

  /** Change phases by station: the cams turn at once, all else when the sliders rest. */
  change(values) {
    Object.assign(this.values, values);
    this.data.cams.forEach((cam, k) => (cam.shift = this.values[this.data.labels[k]]));
    this.page.player.go(this.page.player.angle);
    this.find("timing").classList.add("stale");
    this.requests.changed();
  }

  reset() {
    for (const control of this.controls) control.show(this.own[control.key]);
    this.change(this.own);
    this.status.textContent = "All phases are reset.";
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

  complain(mistakes) {
    for (const { key, text } of mistakes) {
      const control = this.controls.find((each) => each.key === key);
      if (control) control.complain(text);
      else this.status.textContent = `${key}: ${text}`;
    }
  }

  fail(trouble) {
    this.status.textContent = trouble instanceof TypeError ? "The server has ended: start camopt serve again." : `Error: ${trouble.message}.`;
  }

  async save(overwrite) {
    try {
      const found = await ask("save", { values: this.values, name: this.find("file").value, overwrite });
      this.find("overwrite").hidden = !found.exists;
      if (found.mistakes) return this.complain(found.mistakes);
      this.status.textContent = found.exists ? `${found.exists} exists already.` : `Saved ${found.saved}`;
    } catch (trouble) {
      this.fail(trouble);
    }
  }
}

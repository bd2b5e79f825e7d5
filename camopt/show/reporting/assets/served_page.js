// A page that the server answers: its controls, its requests and the form that saves.

class ServedPage {
  /** `own` has the values of the controls by key; `reset` is the sentence after a reset. */
  constructor(own, reset) {
    const find = (id) => document.getElementById(id);
    Object.assign(this, { find, own, values: { ...own }, moved: "", status: find("status") });
    const moved = (key, value) => this.change({ [key]: value }, key);
    this.controls = [...document.querySelectorAll(".control")].map((each) => new Control(each, moved));
    this.requests = new RequestQueue(() => this.question(), (...shown) => this.show(...shown), (trouble) => this.fail(trouble));
    find("start").addEventListener("click", () => this.set(this.own, reset));
    find("save").addEventListener("submit", (event) => { event.preventDefault(); this.save(false); });
    find("overwrite").addEventListener("click", () => this.save(true));
    find("file").addEventListener("input", () => (find("overwrite").hidden = true));
  }

  question() {
    return { values: this.values, moved: this.moved };
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

  async save(overwrite) {
    try {
      const found = await ask("save", { ...this.question(), name: this.find("file").value, overwrite });
      this.find("overwrite").hidden = !found.exists;
      if (found.mistakes) return this.complain(found.mistakes);
      this.status.textContent = found.exists ? `${found.exists} exists already.` : `Saved ${found.saved}`;
    } catch (trouble) {
      this.fail(trouble);
    }
  }
}

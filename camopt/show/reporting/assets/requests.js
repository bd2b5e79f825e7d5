// Requests to the server: only the newest, one at a time; an outdated answer is dropped.

const REST = 300; // ms without a move before the limits are proved

async function ask(what, question) {
  const response = await fetch(what, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(question) });
  if (!response.ok) throw new Error(`the server answers ${response.status}`);
  return response.json();
}

class RequestQueue {
  /** `question` returns the body of a request; `show` takes the answer and whether the controls rest. */
  constructor(question, show, trouble) {
    Object.assign(this, { question, show, trouble, newest: 0, asked: 0, shown: 0 });
  }

  /** A control has moved. */
  changed() {
    this.newest++;
    document.documentElement.dataset.state = "moving";
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.settle(), REST);
    if (!this.running) this.running = this.move().catch(this.trouble).finally(() => (this.running = null));
  }

  async move() {
    while (this.asked < this.newest) {
      const number = (this.asked = this.newest), answer = await ask("move", this.question());
      if (number <= this.shown) continue;
      this.shown = number;
      this.show(answer, false, number === this.newest);
    }
  }

  async settle() {
    const number = this.newest;
    try {
      const answer = await ask("settle", this.question());
      if (number !== this.newest) return;
      this.shown = number;
      this.show(answer, true, true);
      document.documentElement.dataset.state = answer.mistakes ? "refused" : "proved";
    } catch (trouble) {
      this.trouble(trouble);
    }
  }
}

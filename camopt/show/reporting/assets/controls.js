// Controls of the page: sliders, number fields and choices, by keys of the scene.

class Control {
  /** `moved` is called with the key and the new value. */
  constructor(element, moved) {
    this.key = element.dataset.key;
    this.element = element;
    this.slider = element.querySelector("input[type=range]");
    this.field = element.querySelector("input[type=number], select");
    this.alarm = element.querySelector(".alarm");
    this.numeric = this.field.tagName !== "SELECT" || [...this.field.options].every(({ value }) => value !== "" && Number.isFinite(Number(value)));
    if (this.slider) this.slider.addEventListener("input", () => this.take(Number(this.slider.value), moved));
    this.field.addEventListener("input", () => {
      const value = this.numeric ? this.field.valueAsNumber ?? Number(this.field.value) : this.field.value;
      if (this.numeric && !Number.isFinite(value)) this.complain("must be a number");
      else this.take(value, moved);
    });
  }

  take(value, moved) {
    this.show(value);
    moved(this.key, value);
  }

  /** Show a value, except in a field in which the user types. */
  show(value) {
    if (this.slider) {
      if (value < Number(this.slider.min)) this.slider.min = value;
      if (value > Number(this.slider.max)) this.slider.max = value;
      if (document.activeElement !== this.slider || Number(this.slider.value) !== value) this.slider.value = value;
      this.slider.setAttribute("aria-valuetext", fourDigits(value));
    }
    if (this.slider && document.activeElement === this.field) return;
    this.field.value = this.slider ? Number(value.toPrecision(8)) : this.numeric ? [...this.field.options].find((each) => Number(each.value) === value)?.value : value;
  }

  /** Show a text beside the control; an empty text removes it. */
  complain(text = "") {
    this.alarm.textContent = text;
    this.alarm.hidden = !text;
    if (text) this.field.setAttribute("aria-invalid", "true");
    else this.field.removeAttribute("aria-invalid");
  }
}

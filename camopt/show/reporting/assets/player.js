// The cam angle, from playing, dragging, slider or keyboard; all pictures and diagrams follow it.

class Player {
  /** `controls` holds the slider and the buttons; `followers` are functions of the cam angle in deg. */
  constructor(controls) {
    this.angle = 0;
    this.followers = [];
    this.slider = controls.querySelector("input[type=range]");
    this.button = controls.querySelector("button.play");
    this.speed = controls.querySelector("select");
    this.output = controls.querySelector("output");
    this.name = this.slider.getAttribute("aria-label");
    this.slider.addEventListener("input", () => { this.stop(); this.go(Number(this.slider.value)); });
    this.button.addEventListener("click", () => (this.playing ? this.stop() : this.play()));
    window.addEventListener("beforeprint", () => this.stop());
  }

  follow(follower) {
    this.followers.push(follower);
    follower(this.angle);
  }

  forget() { this.followers = []; }

  go(degrees) {
    this.angle = degrees;
    this.slider.value = degrees;
    const text = `${degrees.toFixed(1)}°`;
    this.slider.setAttribute("aria-valuetext", `${this.name} ${text}`);
    this.output.textContent = text;
    for (const follower of this.followers) follower(degrees);
  }

  play() {
    this.playing = true;
    this.label("Pause", "true");
    this.before = undefined;
    requestAnimationFrame((now) => this.step(now));
  }

  stop() {
    this.playing = false;
    this.label("Play", "false");
  }

  label(text, pressed) {
    this.button.textContent = text;
    this.button.setAttribute("aria-pressed", pressed);
  }

  step(now) {
    if (!this.playing) return;
    if (this.before !== undefined) this.go((this.angle + ((now - this.before) / 1000) * (360 / Number(this.speed.value))) % 360);
    this.before = now;
    requestAnimationFrame((next) => this.step(next));
  }
}

/** The angle in deg of a cam that starts its turn at `shift` and turns `ratio` times in a turn of the player. */
function camAngle({ shift = 0, ratio = 1 }, angle) {
  return ((((angle - shift) * ratio) % 360) + 360) % 360;
}

/** Dragging a disc cam turns it; dragging a developed groove moves it along. */
function dragToTurn(view, player) {
  let last;
  const place = (event) => {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(view.plane.getScreenCTM().inverse());
    return isGrooved(view.cam) ? (-point.x / view.cam.sizes.size) * (180 / Math.PI) : view.cam.sense * Math.atan2(point.y, point.x) * (180 / Math.PI);
  };
  view.svg.addEventListener("pointerdown", (event) => {
    view.svg.setPointerCapture(event.pointerId);
    player.stop();
    last = place(event);
  });
  view.svg.addEventListener("pointermove", (event) => {
    if (!event.buttons || last === undefined) return;
    const here = place(event), moved = ((here - last + 540) % 360) - 180;
    last = here;
    player.go((player.angle + moved / (view.cam.ratio || 1) + 360) % 360);
  });
  view.svg.addEventListener("pointerup", () => (last = undefined));
}

/** Draw cams side by side, at one scale unless `room` is null, and their diagrams; all follow the player. Return the common box. */
function showCams(player, stage, diagrams, cams, labels, words = [], room = []) {
  player.forget();
  stage.replaceChildren();
  const there = cams.filter((cam) => cam.exists);
  const views = cams.map((cam, place) => {
    const figure = htmlElement(stage, "figure", { class: `series-${place}` });
    if (cams.length > 1 || !diagrams) {
      htmlElement(figure, "figcaption", {}, labels[place]);
      for (const line of words[place] || []) htmlElement(figure, "small", line.startsWith("not ") ? { class: "alarm" } : {}, line);
    }
    if (!cam.exists) { htmlElement(figure, "p", { class: "alarm" }, "This mechanism cannot be assembled."); return null; }
    const view = new CamView(figure, cam, `${labels[place]}: the cam under its follower, to scale`);
    dragToTurn(view, player);
    return view;
  }).filter(Boolean);
  if (!views.length) return null;
  const box = commonBox([...views.map((view) => view.box), ...(room || [])]);
  for (const view of views) {
    view.frame(room ? box : view.box);
    player.follow((angle) => view.turn(camAngle(view.cam, angle)));
  }
  drawLegend(stage);
  if (!diagrams) return box;
  diagrams.replaceChildren();
  for (const diagram of drawDiagrams(diagrams, there, (angle) => { player.stop(); player.go(angle); }))
    player.follow((angle) => diagram.show(angle));
  return box;
}

/** Legend of the pictures: selector, class and meaning of each line. */
const MEANINGS = [
  [".profile.rise", "rise", "rise"], [".profile.return", "return", "return"], [".profile.dwell", "dwell", "dwell"], [".profile.move", "rise", "move"],
  [".second", "fifth", "profile of the second disc"], [".pitch-curve", "pitch", "pitch curve"], [".base-circle", "thin", "base circle"], [".prime-circle", "thin dashed", "prime circle"],
  [".pitch-point", "mark", "ring: pitch point"], [".profile.thin", "thin", "thin profile: cut away"], [".normal", "normal", "common normal at the contact"],
  [".direction:not([d=''])", "direction", "direction of motion; the angle between these two is the pressure angle"],
];

function drawLegend(stage) {
  const list = document.getElementById("legend");
  if (!list) return;
  list.replaceChildren();
  for (const [selector, kind, words] of MEANINGS) if (stage.querySelector(selector)) htmlElement(list, "li", { class: kind }, words);
}

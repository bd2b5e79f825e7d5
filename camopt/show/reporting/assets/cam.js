// The cam turning under its follower, to scale.

const FIXED = { "vector-effect": "non-scaling-stroke" };
const MARGIN = 0.04; // share of the picture

class CamView {
  /** Draws into `figure`. Call `frame` with the common view before `turn`. */
  constructor(figure, cam, label) {
    this.cam = cam;
    this.still = constantsOf(cam);
    this.curves = curvesOf(cam);
    const pitch = this.curves.flatMap((each) => each.pitch);
    this.size = Math.max(...pitch.map(([x, y]) => Math.hypot(x, y)), 1e-9);
    if (isGrooved(cam)) this.size = Math.max(cam.motion.lift * (cam.sizes.arm_length || 1), 3 * cam.sizes.roller_radius);
    this.around = 2 * Math.PI * cam.sizes.size;
    this.reach = 0.3 * this.size + (cam.contact === "spherical" ? 0 : cam.sizes.roller_radius); // length of the drawn normal
    this.svg = svgElement(figure, "svg", { class: "cam", role: "img", "aria-label": label, preserveAspectRatio: "xMidYMid meet" });
    this.plane = svgElement(this.svg, "g", { transform: "scale(1 -1)" });
    this.body = svgElement(this.plane, "g", { class: "body" });
    this.still_parts = svgElement(this.plane, "g");
    this.follower = svgElement(this.plane, "g", { class: "follower" });
    this.train = svgElement(this.plane, "g", { class: "train" });
    this.links = [];
    this.touch = svgElement(this.plane, "g", { class: "touch" });
    this.drawBody();
    this.box = this.drawFollower();
    this.drawTouch();
  }

  path(parent, points, kind, close = false) {
    return svgElement(parent, "path", { d: pathOf(points, close), class: kind, ...FIXED });
  }

  circle(parent, radius, kind, [x, y] = [0, 0]) {
    return svgElement(parent, "circle", { r: Math.max(radius, 0), cx: x, cy: y, class: kind, ...FIXED });
  }

  drawBody() {
    if (isGrooved(this.cam)) return this.drawGroove();
    const { sizes, undercut, left, shaft, pitch_point: at } = this.cam, edge = this.edge;
    if (edge) this.drawPlate(edge);
    else {
      const profile = this.curves.flatMap((each) => each.profile);
      const solid = left ? left[0].map((x, k) => [x, left[1][k]]) : profile;
      this.path(this.body, solid, undercut ? "solid what-is-left" : "solid", true);
    }
    if (shaft) this.circle(this.body, shaft, "shaft");
    this.circle(this.body, sizes.size, "base-circle");
    if (sizes.roller_radius > 0) {
      this.circle(this.body, sizes.size + sizes.roller_radius, "prime-circle");
      for (const pitch of ["pitch", "second"]) this.path(this.body, this.curves.flatMap((each) => each[pitch]), "pitch-curve", true);
    }
    for (const side of edge ? ["profile", "flank"] : ["profile"]) {
      this.curves.forEach((each, k) => {
        const before = this.curves.at(k - 1)[side];
        this.path(this.body, [before[before.length - 1], each[side][0]], "profile joint");
        this.path(this.body, each[side], `profile ${each.kind}${undercut ? " thin" : ""}`);
      });
    }
    const { second } = this.cam;
    if (second && second.outline) this.path(this.body, pairs(second.outline), "second", true);
    if (at !== null) this.markPitchPoint(at);
    const mark = 0.06 * this.size;
    this.path(this.body, [[-mark, 0], [mark, 0]], "centre-mark");
    this.path(this.body, [[0, -mark], [0, mark]], "centre-mark");
    this.path(this.body, [[0, 0], [0, 0.97 * sizes.size]], "timing");
  }

  /** Radius of a disc with a groove or rib on its face, by default a little more than its flanks; else 0. */
  get edge() {
    if (!this.cam.on_face) return 0;
    const far = Math.max(...this.curves.flatMap((each) => [...each.profile, ...each.flank].map(([x, y]) => Math.hypot(x, y))));
    return this.cam.outer_diameter / 2 || 1.08 * far;
  }

  drawPlate(edge) {
    const [face, between] = isRibbed(this.cam) ? ["plate", "rib"] : ["solid", "channel"];
    this.circle(this.body, edge, face);
    for (const each of this.curves) {
      this.path(this.body, [...each.profile, ...[...each.flank].reverse()], between, true);
    }
  }

  markPitchPoint(degrees) {
    const angle = (degrees * Math.PI) / 180, [y, slope] = motionAt(this.cam.motion, degrees);
    const [x, up] = contactAt(this.cam, this.still, angle, y, slope);
    this.circle(this.body, 0.012 * this.size, "pitch-point", turned(x, up, -this.cam.sense * angle));
  }

  drawGroove() {
    const { roller_radius: radius } = this.cam.sizes;
    const pitches = [this.curves.flatMap((each) => each.pitch), this.curves.flatMap((each) => each.second)];
    const ys = pitches.flat().map(([, y]) => y), edge = 1.4 * radius + 0.05 * this.size;
    const [metal, cut] = isRibbed(this.cam) ? ["channel", "rib"] : ["sheet", "channel"];
    this.low = Math.min(...ys) - edge;
    this.high = Math.max(...ys) + edge;
    const turns = [-1, 0, 1].map((turn) => ({ transform: `translate(${turn * this.around} 0)` }));
    for (const turn of turns) {
      svgElement(this.body, "rect", { ...turn, x: 0, y: this.low, width: this.around, height: this.high - this.low, class: metal, ...FIXED });
    }
    for (const turn of turns) {
      const sheet = svgElement(this.body, "g", turn);
      for (const each of this.curves) {
        const [one, other] = [each.profile, each.flank];
        if (radius > 0) this.path(sheet, [...one, ...[...other].reverse()], cut, true);
      }
      for (const each of this.curves) {
        for (const side of radius > 0 ? [each.profile, each.flank] : [each.pitch]) this.path(sheet, side, `profile ${each.kind}`);
      }
      for (const pitch of pitches) this.path(sheet, pitch, "pitch-curve");
      this.path(sheet, [[0, this.low], [0, this.high]], "timing");
    }
  }

  /** Draw the follower at y = 0 and the fixed parts; return the box that all positions need. */
  drawFollower() {
    const { cam, size } = this;
    const [x, y] = contactAt(cam, this.still, 0, 0, 0);
    if (isGrooved(cam)) return this.drawGrooveFollower([x, y]);
    const swings = cam.moves === "oscillating";
    this.pivot = swings ? [cam.sizes.centre_distance, 0] : null;
    const every = this.curves.flatMap((each) => [...each.profile, ...each.pitch]);
    const outer = 1.02 * Math.max(this.edge, ...every.map(([a, b]) => Math.hypot(a, b)));
    const reach = isFlat(cam) ? this.drawFace([x, y]) : this.drawTip([x, y]);
    const lines = this.pivot ? this.reach : this.reach + cam.motion.lift; // normal and direction, at the highest
    const points = [[-outer, -outer], [outer, outer], [x, y + lines], ...reach, ...this.drawSecond()];
    const [xs, ys] = [points.map(([a]) => a), points.map(([, b]) => b)];
    return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
  }

  /** Draw the parts of the follower at a second contact; return their points. */
  drawSecond() {
    const { second } = this.cam;
    if (!second) return [];
    for (const each of second.lines) this.path(this.follower, pairs(each), "second-frame");
    for (const each of second.solid) this.path(this.follower, pairs(each), "tip", true);
    return [...second.lines, ...second.solid, ...(second.outline ? [second.outline] : [])].flatMap(pairs);
  }

  drawTip(trace) {
    const { cam, size } = this, radius = cam.sizes.roller_radius;
    const up = this.pivot ? this.acrossArm(trace) : [0, 1];
    const along = (a, b) => [trace[0] + size * (up[0] * a - up[1] * b), trace[1] + size * (up[1] * a + up[0] * b)];
    let seat = trace;
    const carrier = svgElement(this.follower, "g");
    if (cam.contact === "knife") {
      this.path(this.follower, [trace, along(0.12, -0.045), along(0.12, 0.045)], "tip", true);
      seat = along(0.12, 0);
    } else if (cam.contact === "roller") {
      this.circle(this.follower, radius, "roller", trace);
      this.circle(this.follower, Math.min(0.15 * radius, 0.015 * size), "pin", trace);
    } else {
      const half = Math.min(Math.max((cam.steepest || 0) + 8, 20), 85) * (Math.PI / 180);
      const cap = [...Array(61).keys()].map((k) => along((-radius / size) * Math.cos(half * (k / 30 - 1)), (-radius / size) * Math.sin(half * (k / 30 - 1))));
      const thick = Math.max(0.04, (0.06 * radius) / size), lift = ([a, b]) => [a + size * thick * up[0], b + size * thick * up[1]];
      this.path(this.follower, [...cap, lift(cap[60]), lift(cap[0])], "tip", true);
      seat = lift([(cap[0][0] + cap[60][0]) / 2, (cap[0][1] + cap[60][1]) / 2]);
    }
    if (this.pivot) return this.drawArm(carrier, seat);
    return this.drawStem(carrier, seat, cam.contact === "roller" ? radius : 0);
  }

  acrossArm([x, y]) {
    const arm = [x - this.pivot[0], y - this.pivot[1]], length = Math.hypot(...arm);
    return [arm[1] / length, -arm[0] / length];
  }

  drawStem(parent, [x, y], clear) {
    const { size } = this, half = 0.035 * size, lift = this.cam.motion.lift;
    const guide = 0.05 * size + clear + lift, top = guide + 0.16 * size;
    this.path(parent, [[x - half, y], [x + half, y], [x + half, y + top], [x - half, y + top]], "tip", true);
    for (const side of [-1, 1]) {
      const [a, b] = [x + side * half, x + side * (half + 0.07 * size)];
      this.path(this.still_parts, [[a, y + guide], [b, y + guide], [b, y + guide + 0.1 * size], [a, y + guide + 0.1 * size]], "ground", true);
    }
    return [[x - 0.12 * size, y], [x + 0.12 * size, y + top + lift], ...this.drawTrain([x, y + top])];
  }

  /** Draw the links from the point that the follower drives at y = 0; return the corners of their reach. */
  drawTrain([x, y]) {
    const { train } = this.cam;
    if (!train) return [];
    const place = { transform: `translate(${x} ${y})` };
    const [still, moving] = [svgElement(this.still_parts, "g", place), svgElement(this.train, "g", place)];
    for (const each of train.standing) this.drawStanding(still, each);
    for (const member of train.members) {
      if (member.shape === "bar") this.path(still, pairs(member.at), "swing");
      const group = svgElement(moving, "g");
      this.drawMember(group, member);
      this.links.push([group, member]);
    }
    return pairs(train.reach).map(([a, b]) => [x + a, y + b]);
  }

  drawStanding(parent, { ground, at, way }) {
    const { size } = this, [[x, y]] = pairs(at), [[a, b]] = pairs(way), length = Math.hypot(a, b);
    if (ground === "pivot") return void this.path(parent, [[x, y], [x + 0.055 * size, y - 0.075 * size], [x - 0.055 * size, y - 0.075 * size]], "ground", true);
    for (const side of [-1, 1]) {
      const beside = (share, end) => [x + end * a - (side * share * size * b) / length, y + end * b + (side * share * size * a) / length];
      this.path(parent, [beside(0.037, -1), beside(0.037, 1), beside(0.062, 1), beside(0.062, -1)], "ground", true);
    }
  }

  drawMember(group, { shape, points }) {
    const ends = pairs(points), [[x, y]] = ends, half = 0.022 * this.size;
    if (shape === "wheel" || shape === "roller") {
      this.circle(group, Math.hypot(x, y), "tip");
      this.path(group, [[0, 0], [x, y]], "pin");
    } else if (shape === "bar") {
      const [, [a, b]] = ends, length = Math.hypot(a, b) || 1, [along, across] = [(half * a) / length, (half * b) / length];
      this.path(group, [[-across, along], [a - across, b + along], [a + along, b + across], [a + across, b - along], [across, -along], [-along, -across]], "tip", true);
      for (const end of ends) this.circle(group, 0.4 * half, "pin", end);
    } else this.path(group, ends, shape === "belt" ? "pin" : "tip", shape !== "belt");
  }

  drawArm(parent, end) {
    const { size } = this, [px, py] = this.pivot, half = 0.03 * size;
    const arm = [end[0] - px, end[1] - py], length = Math.hypot(...arm) || 1, [ax, ay] = [(-arm[1] / length) * half, (arm[0] / length) * half];
    this.path(parent, [[px + ax, py + ay], [end[0] + 0.7 * ax, end[1] + 0.7 * ay], [end[0] - 0.7 * ax, end[1] - 0.7 * ay], [px - ax, py - ay]], "tip", true);
    this.path(this.still_parts, [[px, py], [px + 0.07 * size, py - 0.09 * size], [px - 0.07 * size, py - 0.09 * size]], "ground", true);
    this.circle(this.follower, 1.25 * half, "tip", this.pivot);
    const lift = this.cam.motion.lift, swung = [...Array(25).keys()].map((k) => {
      const [x, y] = turned(arm[0], arm[1], (-lift * k) / 24);
      return [px + x, py + y];
    });
    this.path(this.still_parts, swung, "swing");
    const room = this.cam.sizes.roller_radius;
    const swept = swung.flatMap(([x, y]) => [[x - room, y - room], [x + room, y + room]]);
    return [...swept, [px + 0.1 * size, py - 0.1 * size], ...this.drawTrain(this.pivot)];
  }

  drawFace([x, y]) {
    const { cam, size } = this, [near, far] = this.reachOfFace();
    if (!this.pivot) {
      const ends = [near, far];
      const [left, right] = [Math.min(...ends, cam.sizes.offset - 0.07 * size) - 0.05 * size, Math.max(...ends, cam.sizes.offset + 0.07 * size) + 0.05 * size];
      const carrier = svgElement(this.follower, "g"), thick = 0.045 * size;
      this.path(this.follower, [[left, y], [right, y], [right, y + thick], [left, y + thick]], "tip", true);
      return [[left, y], [right, y], ...this.drawStem(carrier, [cam.sizes.offset, y + thick], 0)];
    }
    const psi = this.still.firstSine, along = [-Math.cos(psi), Math.sin(psi)], normal = [Math.sin(psi), Math.cos(psi)];
    const foot = [this.pivot[0] + cam.sizes.face_offset * normal[0], cam.sizes.face_offset * normal[1]], thick = 0.05 * size;
    const at = (a, n) => [foot[0] + a * along[0] + n * normal[0], foot[1] + a * along[1] + n * normal[1]];
    const [start, end] = [near - 0.08 * size, far + 0.08 * size];
    const carrier = svgElement(this.follower, "g");
    this.path(this.follower, [at(start, 0), at(end, 0), at(end, thick), at(start, thick)], "tip", true);
    return [at(end, thick), ...this.drawArm(carrier, at(start, thick / 2))];
  }

  /** Where contact begins and ends: across a face square to the motion, or from the foot of the pivot's normal. */
  reachOfFace() {
    const { cam } = this, found = [];
    for (const { angle, y, slope } of cam.motion.pieces) {
      angle.forEach((degrees, k) => {
        const [x, up] = contactAt(cam, this.still, (degrees * Math.PI) / 180, y[k], slope[k]);
        if (!this.pivot) { found.push(x); return; }
        const psi = y[k] + this.still.firstSine;
        const foot = [this.pivot[0] + cam.sizes.face_offset * Math.sin(psi), cam.sizes.face_offset * Math.cos(psi)];
        found.push((foot[0] - x) * Math.cos(psi) + (up - foot[1]) * Math.sin(psi));
      });
    }
    return [Math.min(...found), Math.max(...found)];
  }

  drawGrooveFollower(trace) {
    const { cam, size } = this, radius = cam.sizes.roller_radius, half = cam.motion.lift / 2;
    this.pivot = cam.moves === "oscillating" ? [cam.sense * cam.sizes.arm_length * Math.cos(half), 0] : null;
    const carrier = svgElement(this.follower, "g");
    if (radius > 0) this.circle(this.follower, radius, "roller", trace);
    else this.circle(this.follower, 0.02 * size, "tip", trace);
    let reach = [];
    const [x, y] = isRibbed(cam) ? secondAt(cam, this.still, 0, 0, 0) : trace;
    if (isRibbed(cam)) this.circle(this.follower, radius, "roller", [x, y]);
    if (this.pivot) {
      reach = this.drawArm(carrier, trace);
      if (isRibbed(cam)) reach.push(...this.drawArm(carrier, [x, y]));
    } else {
      if (isRibbed(cam)) this.path(this.follower, [trace, [x, y]], "second-frame");
      this.path(this.still_parts, [[0, this.low], [0, this.high]], "swing");
      if (cam.train) reach = this.drawGrooveStem(trace);
    }
    const wide = Math.min(this.around, 2.2 * (this.high - this.low)) / 2;
    const points = [[-wide, this.low], [wide, this.high], ...reach], [xs, ys] = [points.map(([a]) => a), points.map(([, b]) => b)];
    return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
  }

  /** The stem from the roller to the point that drives the train, outside the surface. */
  drawGrooveStem([x, y]) {
    const half = 0.025 * this.cam.sizes.size, top = this.high + 0.25 * this.cam.sizes.size;
    this.path(this.follower, [[x - half, y], [x - half, top], [x + half, top], [x + half, y]], "tip", true);
    return [[x, top + this.cam.motion.lift], ...this.drawTrain([x, top])];
  }

  drawTouch() {
    this.normal = this.path(this.touch, [], "normal");
    this.direction = this.path(this.touch, [], "direction");
    this.point = this.circle(this.touch, 0.012 * this.size, "contact");
  }

  /** Show this part of the plane: [left, low, right, high] in mm. */
  frame([left, low, right, high]) {
    const margin = MARGIN * Math.max(right - left, high - low);
    const [x, y, w, h] = [left - margin, -high - margin, right - left + 2 * margin, high - low + 2 * margin];
    this.svg.setAttribute("viewBox", `${x} ${y} ${w} ${h}`);
  }

  /** Turn to a cam angle in deg. */
  turn(degrees) {
    const { cam } = this, angle = (degrees * Math.PI) / 180;
    const [y, slope] = motionAt(cam.motion, degrees);
    let [x, up, across, along] = contactAt(cam, this.still, angle, y, slope);
    if (isGrooved(cam)) x -= angle * cam.sizes.size;
    this.body.setAttribute("transform", isGrooved(cam) ? `translate(${-angle * cam.sizes.size} 0)` : `rotate(${cam.sense * degrees})`);
    const swing = (-y * 180) / Math.PI * (isGrooved(cam) ? cam.sense : 1);
    this.follower.setAttribute("transform", this.pivot ? `rotate(${swing} ${this.pivot[0]} ${this.pivot[1]})` : `translate(0 ${y})`);
    for (const [group, member] of this.links) group.setAttribute("transform", placeOf(member, degrees));
    const radius = cam.sizes.roller_radius, { reach } = this;
    const [px, py] = [x - radius * across, up - radius * along];
    this.point.setAttribute("cx", px);
    this.point.setAttribute("cy", py);
    const way = this.pivot ? this.acrossArm([x, up]) : [0, 1];
    this.normal.setAttribute("d", pathOf([[px, py], [x + reach * across, up + reach * along]]));
    this.direction.setAttribute("d", isFlat(cam) ? "" : pathOf([[x, up], [x + reach * way[0], up + reach * way[1]]]));
  }
}

/** Points [x, y] from a list of x and a list of y. */
function pairs([xs, ys]) {
  return xs.map((x, k) => [x, ys[k]]);
}

/** The transform of a member at a cam angle in deg, interpolated between its positions. */
function placeOf({ at: [xs, ys], turned }, degrees) {
  const place = ((((degrees % 360) + 360) % 360) / 360) * (xs.length - 1), k = Math.min(Math.floor(place), xs.length - 2);
  const [x, y, angle] = [xs, ys, turned].map((values) => values[k] + (place - k) * (values[k + 1] - values[k]));
  return `translate(${x} ${y}) rotate(${angle})`;
}

/** One box that holds all boxes, so that cams are drawn at one scale. */
function commonBox(boxes) {
  return [0, 1, 2, 3].map((k) => (k < 2 ? Math.min : Math.max)(...boxes.map((box) => box[k])));
}

// Contact of cam and follower: the formulas of camopt/model/mechanisms, in mm and rad.

/** The square root; 0 for negative numbers. */
function rootOf(square) {
  return Math.sqrt(Math.max(square, 0));
}

/** Heights and angles that do not change as the cam turns. */
function constantsOf(cam) {
  const { size, roller_radius: radius, offset, arm_length: arm, centre_distance: centre, face_offset: face, roller_spacing: spacing } = cam.sizes;
  const prime = size + radius;
  const between = cam.moves === "oscillating" ? 2 * Math.asin(spacing / 2 / arm) || 0 : spacing; // of the rollers about a rib
  return {
    height: rootOf((prime - offset) * (prime + offset)),
    firstAngle: 2 * Math.atan2(rootOf((prime - arm + centre) * (prime + arm - centre)), rootOf((arm + centre - prime) * (arm + centre + prime))),
    firstSine: Math.asin((size - face) / centre),
    between,
    ahead: isGrooved(cam) ? between / 2 : 0,
  };
}

/** The trace point of a cam with its follower (the contact of a flat face), and the outward normal there. */
const CONTACTS = {
  "disc translating": ({ sizes, sense }, still, angle, y, slope) => {
    const s = y + still.height;
    return [sizes.offset, s, (sense * sizes.offset - slope) * sense, s];
  },
  "disc translating flat": ({ sizes, sense }, still, angle, y, slope) => [slope * sense, y + sizes.size, 0, 1],
  "disc oscillating": ({ sizes, sense }, still, angle, y, slope) => {
    const psi = y + still.firstAngle, turn = slope * sense;
    const x = sizes.centre_distance - sizes.arm_length * Math.cos(psi), up = sizes.arm_length * Math.sin(psi);
    return [x, up, x - turn * (sizes.centre_distance - x), up + turn * up];
  },
  "disc oscillating flat": ({ sizes, sense }, still, angle, y, slope) => {
    const psi = y + still.firstSine, cosine = Math.cos(psi), sine = Math.sin(psi);
    const t = (cosine * sizes.centre_distance) / (slope * sense + 1);
    return [sine * sizes.face_offset - t * cosine + sizes.centre_distance, cosine * sizes.face_offset + t * sine, sine, cosine];
  },
  "cylindrical translating": ({ sizes }, still, angle, y, slope) => [angle * sizes.size, y + still.ahead, -slope, sizes.size],
  "cylindrical oscillating": ({ sizes, sense, motion }, still, angle, y, slope) => {
    const half = motion.lift / 2, psi = y + still.ahead - half, cosine = Math.cos(psi), sine = Math.sin(psi), arm = sizes.arm_length;
    const x = angle * sizes.size - (cosine - Math.cos(half)) * sense * arm;
    return [x, sine * arm, -slope * cosine * arm, slope * sine * sense * arm + sizes.size];
  },
};

const isFlat = (cam) => cam.contact === "flat";
const isGrooved = (cam) => cam.form === "cylindrical";
const isRibbed = (cam) => cam.sizes.roller_spacing > 0;
const contactOf = (cam) => CONTACTS[`${cam.form} ${cam.moves}${isFlat(cam) ? " flat" : ""}`];

/** [x, y, across, up] with a unit normal, at a cam angle in rad. */
function contactAt(cam, still, angle, y, slope) {
  const [x, up, across, along] = contactOf(cam)(cam, still, angle, y, slope);
  const length = Math.hypot(across, along);
  return [x, up, across / length, along / length];
}

/** As contactAt, for the second roller of a rib, with the normal towards that roller. */
function secondAt(cam, still, angle, y, slope) {
  const [x, up, across, along] = contactAt(cam, still, angle, y - still.between, slope);
  return [x, up, -across, -along];
}

/** A point turned by an angle in rad about the origin. */
function turned(x, y, angle) {
  const cosine = Math.cos(angle), sine = Math.sin(angle);
  return [x * cosine - y * sine, x * sine + y * cosine];
}

/**
 * The curves of a cam in its own frame, for each piece {kind, pitch, profile, flank}, lists of points [x, y].
 * For a rib, `flank` is touched by the second roller, and `second` is the pitch curve of that roller.
 */
function curvesOf(cam) {
  const still = constantsOf(cam), radius = cam.sizes.roller_radius;
  return cam.motion.pieces.map((piece) => {
    const curves = { kind: piece.kind, pitch: [], profile: [], flank: [], second: [] };
    piece.angle.forEach((degrees, k) => {
      const angle = (degrees * Math.PI) / 180;
      const [x, y, across, up] = contactAt(cam, still, angle, piece.y[k], piece.slope[k]);
      const turn = isGrooved(cam) ? 0 : -cam.sense * angle;
      curves.pitch.push(turned(x, y, turn));
      curves.profile.push(turned(x - radius * across, y - radius * up, turn));
      if (!isRibbed(cam)) return void curves.flank.push(turned(x + radius * across, y + radius * up, turn));
      const [a, b, aside, along] = secondAt(cam, still, angle, piece.y[k], piece.slope[k]);
      curves.second.push(turned(a, b, turn));
      curves.flank.push(turned(a - radius * aside, b - radius * along, turn));
    });
    return curves;
  });
}

/** y and dy/dθ at a cam angle in deg, by the cubic Hermite polynomial between two samples. */
function motionAt(motion, degrees) {
  const pieces = motion.pieces;
  let piece = pieces.find((each) => degrees <= each.angle[each.angle.length - 1]) || pieces[pieces.length - 1];
  const angles = piece.angle, k = Math.min(Math.max(firstAbove(angles, degrees), 1), angles.length - 1);
  const width = ((angles[k] - angles[k - 1]) * Math.PI) / 180;
  const t = Math.min(Math.max((degrees - angles[k - 1]) / (angles[k] - angles[k - 1]), 0), 1);
  const [a, b, da, db] = [piece.y[k - 1], piece.y[k], piece.slope[k - 1] * width, piece.slope[k] * width];
  const c = 3 * (b - a) - 2 * da - db, d = 2 * (a - b) + da + db;
  return [a + t * (da + t * (c + t * d)), (da + t * (2 * c + t * 3 * d)) / width];
}

/** The index of the first number above a value, in rising numbers; their count if there is none. */
function firstAbove(numbers, value) {
  let low = 0, high = numbers.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (numbers[middle] > value) high = middle;
    else low = middle + 1;
  }
  return low;
}

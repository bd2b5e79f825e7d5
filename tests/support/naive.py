"""Slow, obvious, complete reference for cam geometry, at 50 digits.

Nothing here uses a closed form for pressure angle or curvature.  Each mechanism is drawn: the pitch curve (or
the envelope of the face) is written down as a complex function of the cam angle, differentiated by the chain
rule, and measured by the general formulas of plane curves.  Nothing here imports the package under test.

Every function that makes numbers takes `ctx`, an mpmath context: `mpmath.mp` (exact to `DPS` digits) gives
the answers, `mpmath.fp` (plain floats, same code) only finds out in which interval to look for an extreme.
Angles are in radians inside, lengths in mm.  A jet is the tuple (y, y', y'', y''') by cam angle.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

from mpmath import fp, mp

DPS = 50
SAMPLES = 1000

LAWS = (
    "uniform",
    "parabolic",
    "harmonic",
    "cycloidal",
    "poly345",
    "poly4567",
    "modified-trapezoid",
    "modified-sine",
    "cubic",
    "double-harmonic",
    "poly56789",
    "poly8",
    "modified-constant-velocity",
    "cycloidal-constant-velocity",
    "half-cycloidal-1",
    "half-cycloidal-2",
    "half-harmonic-1",
    "half-harmonic-2",
)
COMMON = LAWS[:8]
"""Those of the whole cams in reference.json."""

Jet = tuple[Any, Any, Any, Any]
Curve = Callable[[Any], Jet]
State = Callable[[Any, Jet], dict[str, Any]]
Scene = dict[str, Any]


class Piece(NamedTuple):
    """A stretch on which the motion is smooth, with its jet (valid up to and at both ends)."""

    start: Any
    end: Any
    kind: str
    jet: Curve


# ---------------------------------------------------------------------------------------------------- laws


def polynomial(coefficients: dict[int, Any], ctx: Any) -> Curve:
    """s(x) = sum of c_n x^n, with three derivatives term by term."""

    def term(n: int, c: Any, k: int, x: Any) -> Any:
        for i in range(k):
            c *= n - i
        return c * x ** (n - k) if n >= k else ctx.zero

    def jet(x: Any) -> Jet:
        return tuple(sum(term(n, c, k, x) for n, c in coefficients.items()) for k in range(4))

    return jet


def conditions(start: tuple[float, ...], end: tuple[float, ...], ctx: Any) -> Curve:
    """The polynomial with s, s', s'' ... at x = 0 and at x = 1: all its powers from one system of equations."""
    powers = range(len(start) + len(end))

    def row(order: int, x: Any) -> list[Any]:
        return [mp.ff(n, order) * (mp.mpf(x) ** (n - order) if n >= order else 0) for n in powers]

    asked = [(order, x, value) for x, each in enumerate((start, end)) for order, value in enumerate(each)]
    with mp.workdps(mp.dps + 20):
        matrix = mp.matrix([row(order, x) for order, x, _ in asked])
        found = mp.lu_solve(matrix, mp.matrix([mp.mpf(value) for _, _, value in asked]))
    return polynomial({n: ctx.mpf(found[n]) for n in powers}, ctx)


def harmonic(ctx: Any) -> Curve:
    """s = (1 - cos pi x)/2: the projection of a point going half round a circle of diameter 1."""

    def jet(x: Any) -> Jet:
        w = ctx.pi * 1
        c, d = ctx.cos(w * x), ctx.sin(w * x)
        return (1 - c) / 2, w * d / 2, w**2 * c / 2, -(w**3) * d / 2

    return jet


def double_harmonic(ctx: Any) -> Curve:
    """s = (1 - cos pi x)/2 - (1 - cos 2 pi x)/8: a harmonic less a quarter of one of twice its speed."""

    def jet(x: Any) -> Jet:
        w = ctx.pi * 1
        c, d, c2, d2 = ctx.cos(w * x), ctx.sin(w * x), ctx.cos(2 * w * x), ctx.sin(2 * w * x)
        return (
            (1 - c) / 2 - (1 - c2) / 8,
            w * d / 2 - w * d2 / 4,
            w**2 * c / 2 - w**2 * c2 / 2,
            -(w**3) * d / 2 + w**3 * d2,
        )

    return jet


def cycloidal(ctx: Any) -> Curve:
    """s = x - sin(2 pi x)/(2 pi): a circle of circumference 1 rolling once on a line."""

    def jet(x: Any) -> Jet:
        w = 2 * ctx.pi
        c, d = ctx.cos(w * x), ctx.sin(w * x)
        return x - d / w, 1 - c, w * d, w**2 * c

    return jet


def half_cycloidal(sign: int, ctx: Any) -> Curve:
    """s = x - sign sin(pi x)/pi: a half turn of the circle of a cycloidal motion twice as high and long."""

    def jet(x: Any) -> Jet:
        w = ctx.pi * 1
        c, d = ctx.cos(w * x), ctx.sin(w * x)
        return x - sign * d / w, 1 - sign * c, sign * w * d, sign * w**2 * c

    return jet


def half_harmonic(start: int, ctx: Any) -> Curve:
    """s = cos(pi start/2) - cos(pi (x + start)/2): a quarter turn, the first (start = 0) or the second (1)."""

    def jet(x: Any) -> Jet:
        w = ctx.pi / 2
        c, d = ctx.cos(w * (x + start)), ctx.sin(w * (x + start))
        return 1 - start - c, w * d, w**2 * c, -(w**3) * d

    return jet


def wave(x0: Any, s0: Any, v0: Any, A: Any, w: Any, m: Any, ctx: Any) -> Curve:
    """The motion from x0, where s = s0 and v = v0, under the acceleration a = A cos(w (x - m))."""

    def jet(x: Any) -> Jet:
        r = x - x0
        if w == 0:
            return s0 + v0 * r + A * r**2 / 2, v0 + A * r, A, ctx.zero
        c, d = ctx.cos(w * (x - m)), ctx.sin(w * (x - m))
        c0, d0 = ctx.cos(w * (x0 - m)), ctx.sin(w * (x0 - m))
        s = s0 + (v0 - A / w * d0) * r - A / w**2 * (c - c0)
        return s, v0 + A / w * (d - d0), A * c, -A * w * d

    return jet


def from_acceleration(waves: list[tuple[Any, ...]], ctx: Any) -> list[tuple[Any, Any, Curve]]:
    """Integrate a chain of waves (x0, x1, sign, w, m) twice from rest and scale it so that s(1) = 1."""

    def chain(A: Any) -> tuple[list[tuple[Any, Any, Curve]], Any]:
        pieces, s, v = [], ctx.zero, ctx.zero
        for x0, x1, sign, w, m in waves:
            jet = wave(x0, s, v, A * sign, w, m, ctx)
            s, v = jet(x1)[:2]
            pieces.append((x0, x1, jet))
        return pieces, s

    return chain(1 / chain(ctx.one)[1])[0]


def scca(b: Any, c: Any, d: Any, e: Any, ctx: Any) -> list[tuple[Any, Any, Curve]]:
    """Acceleration: quarter sine over b/2, flat over c/2, cosine over d/2, none over e, and the same backwards."""
    x, waves = ctx.zero, []
    ends = [(b / 2, "rise"), (c / 2, "flat"), (d / 2, "fall"), (e, "none")]
    for sign, parts in ((1, ends), (-1, ends[2::-1])):
        for length, part in parts:
            w = ctx.pi / 2 / length if length and part in ("rise", "fall") else ctx.zero
            crest = x + length if (part == "rise") == (sign == 1) else x  # a sine is a cosine about its crest
            if length:
                waves.append((x, x + length, 0 if part == "none" else sign, w, crest))
            x += length
    return from_acceleration(waves, ctx)


SCCA = {
    "modified-trapezoid": (2, 4, 2, 0),
    "modified-sine": (2, 0, 6, 0),
    "modified-constant-velocity": (1, 0, 3, 4),
    "cycloidal-constant-velocity": (2, 0, 2, 4),
}
"""Shares of the stroke in eighths."""


def law_pieces(law: str, ctx: Any = mp) -> list[tuple[Any, Any, Curve]]:
    """The smooth pieces (x0, x1, jet) of a normalised law; jet(x) = (s, v, a, j)."""
    zero, half, one = ctx.zero, ctx.one / 2, ctx.one
    if law == "parabolic":  # 2x^2, then 1 - 2(1-x)^2
        return [
            (zero, half, polynomial({2: 2}, ctx)),
            (half, one, polynomial({0: -1, 1: 4, 2: -2}, ctx)),
        ]
    if law in SCCA:
        return scca(*(share * one / 8 for share in SCCA[law]), ctx)
    whole = {
        "uniform": lambda: polynomial({1: 1}, ctx),
        "harmonic": lambda: harmonic(ctx),
        "cycloidal": lambda: cycloidal(ctx),
        "poly345": lambda: polynomial({3: 10, 4: -15, 5: 6}, ctx),
        "poly4567": lambda: polynomial({4: 35, 5: -84, 6: 70, 7: -20}, ctx),
        "cubic": lambda: polynomial({2: 3, 3: -2}, ctx),
        "double-harmonic": lambda: double_harmonic(ctx),
        "poly56789": lambda: polynomial({5: 126, 6: -420, 7: 540, 8: -315, 9: 70}, ctx),
        "poly8": lambda: conditions((0, 0, 0, 36.5853, 0), (1, 0, -5.2683, 0), ctx),
        "half-cycloidal-1": lambda: half_cycloidal(1, ctx),
        "half-cycloidal-2": lambda: half_cycloidal(-1, ctx),
        "half-harmonic-1": lambda: half_harmonic(0, ctx),
        "half-harmonic-2": lambda: half_harmonic(1, ctx),
    }
    return [(zero, one, whole[law]())]


def law_at(law: str, x: Any, ctx: Any = mp) -> Jet:
    """(s, v, a, j) of a law at x; at a break the value from the left."""
    pieces = law_pieces(law, ctx)
    return next((jet for _, x1, jet in pieces if x <= x1), pieces[-1][2])(x)


# ----------------------------------------------------------------------------------------------- programme


def number(value: Any, ctx: Any) -> Any:
    """A number of a scene: an int or float as the machine holds it, a string as the decimal it spells."""
    return ctx.mpf(value)


def stroke(jet: Curve, start: Any, b: Any, y0: Any, h: Any) -> Curve:
    """y = y0 + h s(x), x = (theta - start)/b; each derivative by theta brings a 1/b."""

    def stroke_motion(theta: Any) -> Jet:
        s, v, a, j = jet((theta - start) / b)
        return y0 + h * s, h * v / b, h * a / b**2, h * j / b**3

    return stroke_motion


def programme(motion: list[Scene], ctx: Any = mp, oscillating: bool = False) -> list[Piece]:
    """The smooth pieces of a turn, in order from theta = 0; y in mm, or in radians when oscillating."""
    pieces: list[Piece] = []
    degree = ctx.pi / 180
    turned, y = ctx.zero, ctx.zero  # degrees so far, displacement so far
    for segment in motion:
        kind = segment["segment"]
        start, b = turned * degree, number(segment["angle"], ctx) * degree
        turned += number(segment["angle"], ctx)
        if kind == "dwell":
            pieces.append(Piece(start, turned * degree, kind, lambda theta, y=y: (y, 0 * y, 0 * y, 0 * y)))
            continue
        h = number(segment["lift"], ctx) * (degree if oscillating else 1) * (1 if kind == "rise" else -1)
        for x0, x1, jet in law_pieces(segment["law"], ctx):
            pieces.append(Piece(start + x0 * b, start + x1 * b, kind, stroke(jet, start, b, y, h)))
        y += h
    if abs(turned - 360) > 360e-9 or abs(y) > 1e-9:
        raise ValueError("the programme does not close")
    return pieces


def jumps(pieces: list[Piece], order: int) -> list[bool]:
    """For each piece, whether the derivative of that order jumps between it and the next (round the turn)."""
    scale = max(abs(p.jet(p.start + (p.end - p.start) * k / 8)[order]) for p in pieces for k in range(9))
    after = pieces[1:] + pieces[:1]
    return [
        abs(p.jet(p.end)[order] - q.jet(q.start)[order]) > mp.mpf(10) ** -30 * scale
        for p, q in zip(pieces, after, strict=True)
    ]


def stroke_jumps(pieces: list[Piece], order: int, kind: str) -> bool:
    """Whether the derivative jumps anywhere on strokes of a kind, the ends of the strokes included."""
    jump = jumps(pieces, order)
    return any((jump[i - 1] or jump[i]) for i, p in enumerate(pieces) if p.kind == kind)


# -------------------------------------------------------------------------------------------- plane curves


def cross(a: Any, b: Any) -> Any:
    """z-component of a x b for plane vectors held as complex numbers."""
    return a.real * b.imag - a.imag * b.real


def curvature(d1: Any, d2: Any) -> Any:
    """(x' y'' - y' x'')/|p'|^3: positive where the curve, run along p', turns to the left."""
    return cross(d1, d2) / abs(d1) ** 3


def angle_between(direction: Any, normal: Any, ctx: Any) -> Any:
    """Signed angle from `direction` to `normal`, positive counter-clockwise."""
    ratio = normal * direction.conjugate()
    return ctx.atan2(ratio.imag, ratio.real)


def follower_radius(scene: Scene, ctx: Any = mp) -> Any:
    """R_r: the radius of the roller, of the spherical face, or 0 for a knife edge."""
    follower = scene["follower"]
    key = {"roller": "roller_radius", "spherical": "face_radius"}.get(follower["contact"])
    return number(follower[key], ctx) if key else ctx.zero


def spin(scene: Scene) -> int:
    """Sense in which the follower goes round in the cam's frame: -1 (clockwise) for a ccw cam, +1 for cw."""
    return 1 if scene["cam"].get("rotation", "ccw") == "cw" else -1


def turned_frame(sigma: int, theta: Any, q: Any, q1: Any, q2: Any, ctx: Any) -> tuple[Any, Any, Any, Any]:
    """p = exp(i sigma theta) q with p', p'', and the turn itself."""
    i = ctx.mpc(0, sigma)
    turn = ctx.expj(sigma * theta)
    return turn * q, turn * (q1 + i * q), turn * (q2 + 2 * i * q1 - q), turn


def psi_start(scene: Scene, ctx: Any = mp) -> Any:
    """Angle of the arm (or of the face) of an oscillating follower of a disc cam at y = 0."""
    cam, follower = scene["cam"], scene["follower"]
    c, R_b = number(follower["centre_distance"], ctx), number(cam["base_radius"], ctx)
    if follower["contact"] == "flat":  # distance from cam centre to face: R_b = f + c sin psi_0
        return ctx.asin((R_b - number(follower["face_offset"], ctx)) / c)
    arm, R_p = number(follower["arm_length"], ctx), R_b + follower_radius(scene, ctx)
    return ctx.acos((c**2 + arm**2 - R_p**2) / (2 * c * arm))  # triangle centre, pivot, trace point


def pitch_curve(scene: Scene, ctx: Any, theta: Any, jet: Jet) -> tuple[Any, Any, Any, Any]:
    """Trace point of a disc cam in the cam's frame: p, p', p'', and the follower's direction of motion.

    In the ground frame the trace point is q = offset + i (s0 + y), moving along i; or, with the pivot at
    distance c to the right and the arm above, q = c - l exp(-i psi), moving along i exp(-i psi).
    """
    y, y1, y2, _ = jet
    follower, sigma, i = scene["follower"], spin(scene), ctx.mpc(0, 1)
    if follower["motion"] == "translating":
        offset = number(follower.get("offset", 0), ctx)
        R_p = number(scene["cam"]["base_radius"], ctx) + follower_radius(scene, ctx)
        s0 = ctx.sqrt(R_p**2 - offset**2)
        p, p1, p2, turn = turned_frame(sigma, theta, ctx.mpc(offset, s0 + y), i * y1, i * y2, ctx)
        return p, p1, p2, turn * i
    c, arm = number(follower["centre_distance"], ctx), number(follower["arm_length"], ctx)
    psi = psi_start(scene, ctx) + y
    if not 0 < psi < ctx.pi:
        raise ValueError("the arm passes through the line of centres")
    rod = arm * ctx.expj(-psi)
    q, q1, q2 = c - rod, i * y1 * rod, (i * y2 + y1**2) * rod
    p, p1, p2, turn = turned_frame(sigma, theta, q, q1, q2, ctx)
    return p, p1, p2, turn * i * rod / arm


def disc_state(scene: Scene, ctx: Any) -> State:
    """beta and kappa of a trace-point disc cam.

    The outward normal is p' turned a quarter against the sense of travel.  beta is the angle from the
    direction of motion to it, ccw positive with the pivot on the right; with a translating follower it is
    counted in the sense of the cam's rotation, so that a rise of a radial follower has beta > 0.
    """
    sigma = spin(scene)
    sign = -sigma if scene["follower"]["motion"] == "translating" else 1

    def state(theta: Any, jet: Jet) -> dict[str, Any]:
        _, p1, p2, direction = pitch_curve(scene, ctx, theta, jet)
        normal = p1 * ctx.mpc(0, -sigma)
        return {
            "beta": sign * angle_between(direction, normal, ctx),
            "kappa": sigma * curvature(p1, p2),
        }

    return state


def swing_middle(scene: Scene, ctx: Any = mp) -> Any:
    """Half of the whole swing of the programme, in radians: where the arm stands square to the cam axis."""
    y = top = ctx.zero
    for segment in scene["motion"]:
        if segment["segment"] != "dwell":
            y += number(segment["lift"], ctx) * (1 if segment["segment"] == "rise" else -1)
            top = max(top, y)
    return top * ctx.pi / 360


def developed_curve(scene: Scene, ctx: Any, theta: Any, jet: Jet) -> tuple[Any, Any, Any, Any]:
    """Trace point of a cylindrical cam on the developed plane: p, p', p'', and the direction of motion.

    Translating: R_m theta + i y.  Oscillating: R_m theta -/+ l (cos psi - cos psi_end) + i l sin psi, upper
    sign for ccw, psi = y - swing/2: the arc of the arm's end laid on the tangent plane.
    """
    y, y1, y2, _ = jet
    R_m = number(scene["cam"]["mean_radius"], ctx)
    if scene["follower"]["motion"] == "translating":
        return ctx.mpc(R_m * theta, y), ctx.mpc(R_m, y1), ctx.mpc(0, y2), ctx.mpc(0, 1)
    arm, sigma, end = number(scene["follower"]["arm_length"], ctx), spin(scene), swing_middle(scene, ctx)
    psi = y - end
    # sigma cos psi + i sin psi is the arm; `across` is its derivative by psi
    rod = ctx.mpc(sigma * ctx.cos(psi), ctx.sin(psi))
    across = ctx.mpc(-sigma * ctx.sin(psi), ctx.cos(psi))
    p = R_m * theta - sigma * arm * ctx.cos(end) + arm * rod
    return p, R_m + arm * y1 * across, arm * (y2 * across - y1**2 * rod), across


def cylinder_state(scene: Scene, ctx: Any) -> State:
    """beta and kappa of the developed curve of a cylindrical cam; kappa > 0 where it bends towards +y."""

    def state(theta: Any, jet: Jet) -> dict[str, Any]:
        _, p1, p2, direction = developed_curve(scene, ctx, theta, jet)
        return {
            "beta": angle_between(direction, p1 * ctx.mpc(0, 1), ctx),
            "kappa": curvature(p1, p2),
        }

    return state


def wall_curvature(scene: Scene, theta: Any, jet: Jet, wall: int, ctx: Any) -> Any:
    """Curvature of one wall of a groove where it touches the roller, above 0 where it bulges towards the roller.

    Wall 1 is on the side of the roller from which it is pushed in the direction of motion, wall -1 on the other.
    By the circle through three points of the wall close together, without any derivative of the curve's normal.
    """
    y, y1, y2, y3 = jet
    step = ctx.mpf(10) ** (-ctx.dps // 5)

    def point(d: Any) -> Any:
        near = (y + d * y1 + d**2 / 2 * y2 + d**3 / 6 * y3, y1 + d * y2 + d**2 / 2 * y3, y2, y3)
        centre, along, _, direction = developed_curve(scene, ctx, theta + d, near)
        across = ctx.mpc(0, 1) * along / abs(along)
        side = 1 if (across * direction.conjugate()).real > 0 else -1  # of `across`, towards the motion
        return centre - wall * side * follower_radius(scene, ctx) * across, wall * side * across

    (before, _), (here, towards_roller), (after, _) = (point(d) for d in (-step, 0, step))
    chord, first, second = after - before, here - before, after - here
    radius_inverse = 2 * cross(first, second) / (abs(first) * abs(second) * abs(chord))
    return -radius_inverse if cross(chord, towards_roller) > 0 else radius_inverse


def flat_face(scene: Scene, ctx: Any, theta: Any, jet: Jet) -> dict[str, Any]:
    """Contact of a flat face with a disc cam: the envelope of the face's lines in the cam's frame.

    The line is Re(P conj u) = H with u = exp(i phi) its outward unit normal.  Differentiated by theta,
    Re(P conj(i phi' u)) = H'; so P = u (H + i H'/phi').  Its tangent is the line itself, which turns by
    phi', so the radius of curvature is (dP/dtheta along i u)/phi'.
    """
    y, y1, y2, _ = jet
    follower, sigma, i = scene["follower"], spin(scene), ctx.mpc(0, 1)
    if follower["motion"] == "translating":
        H, H1, H2 = number(scene["cam"]["base_radius"], ctx) + y, y1, y2
        phi, phi1, phi2 = sigma * theta + ctx.pi / 2, sigma, 0
    else:
        c, f = number(follower["centre_distance"], ctx), number(follower["face_offset"], ctx)
        psi = psi_start(scene, ctx) + y
        if not -sigma * (sigma - y1) < 0 or not 0 < psi < ctx.pi:
            raise ValueError("the face turns with the cam or passes through the line of centres")
        sine, cosine = c * ctx.sin(psi), c * ctx.cos(psi)
        H, H1, H2 = f + sine, cosine * y1, cosine * y2 - sine * y1**2
        phi, phi1, phi2 = sigma * theta - psi + ctx.pi / 2, sigma - y1, -y2
    u = ctx.expj(phi)
    P = u * (H + i * H1 / phi1)
    P1 = i * phi1 * u * (H + i * H1 / phi1) + u * (H1 + i * (H2 / phi1 - H1 * phi2 / phi1**2))
    ground = ctx.expj(-sigma * theta)  # back from the cam's frame to the ground's
    return {
        "u": u * ground,
        "P": P * ground,
        "rho": (P1 * (i * u).conjugate()).real / phi1,
    }


def flat_state(scene: Scene, ctx: Any) -> State:
    """beta, rho and the reach along the face.

    Translating: reach is the contact's x from the follower's axis, positive to the side where the contact
    lies on the rise of a radial follower (right for ccw, left for cw).  Oscillating: distance from the foot
    of the pivot on the face, positive towards the cam.
    """
    follower, sigma, i = scene["follower"], spin(scene), ctx.mpc(0, 1)
    oscillating = follower["motion"] == "oscillating"
    offset = number(follower.get("offset", 0), ctx)
    pivot = number(follower["centre_distance"], ctx) if oscillating else None

    def state(theta: Any, jet: Jet) -> dict[str, Any]:
        face = flat_face(scene, ctx, theta, jet)
        u, P = face["u"], face["P"]
        if oscillating:
            # a rising arm turns clockwise about the pivot: the contact moves along -i (P - pivot)
            direction = -i * (P - pivot)
            reach = ((P - pivot) * (i * u).conjugate()).real
            beta = angle_between(direction, u, ctx)
        else:
            reach = -sigma * (P.real - offset)
            beta = ctx.zero
        return {"beta": beta, "rho": face["rho"], "reach": reach}

    return state


def geometry(scene: Scene, ctx: Any = mp) -> State:
    """The function (theta, jet) -> beta and kappa, or beta, rho and reach, of the scene's mechanism."""
    if scene["cam"]["form"] == "cylindrical":
        return cylinder_state(scene, ctx)
    return (flat_state if scene["follower"]["contact"] == "flat" else disc_state)(scene, ctx)


# ------------------------------------------------------------------------------------------- external load


Line = tuple[Any, Any, Any, Any]
"""Two ends of a straight line of a load: cam angle and load, twice."""


def lines(rows: Any, ctx: Any = mp) -> list[Line]:
    """The straight lines over the turn that join rows (deg, load), periodic."""
    degree = ctx.pi / 180
    rows = [(number(angle, ctx), number(value, ctx)) for angle, value in rows]
    before = [(angle - 360, value) for angle, value in rows]
    after = [(angle + 360, value) for angle, value in rows]
    every = [*before, *rows, *after]
    return [
        (max(a, 0) * degree, p + (q - p) * (max(a, 0) - a) / (b - a), b * degree, q)
        for (a, p), (b, q) in pairwise(every)
        if b > a and b > 0 and a < 360
    ]


def on_line(line: Line, theta: Any) -> Any:
    """The load at a cam angle."""
    a, p, b, q = line
    return p + (q - p) * (theta - a) / (b - a)


def under_load(pieces: list[Piece], rows: Any, ctx: Any = mp) -> list[tuple[Piece, Line]]:
    """Pieces cut where a load has corners, each with the line of the load over it."""
    found = []
    for piece in pieces:
        for line in lines(rows, ctx):
            start, end = max(piece.start, line[0]), min(piece.end, line[2])
            if end - start > (piece.end - piece.start) * 1e-9:
                found.append((piece._replace(start=start, end=end), line))
    return found


# ------------------------------------------------------------------------------------------------ extremes


def golden(g: Callable[[Any], Any], lo: Any, hi: Any) -> tuple[Any, Any]:
    """Largest value of a unimodal g on [lo, hi], by golden section, and where it is."""
    ratio = (mp.sqrt(5) - 1) / 2
    a, b = lo, hi
    c, d = b - ratio * (b - a), a + ratio * (b - a)
    gc, gd = g(c), g(d)
    while b - a > mp.mpf(10) ** (-DPS // 2 - 3) * (hi - lo):
        if gc >= gd:
            b, d, gd = d, c, gc
            c = b - ratio * (b - a)
            gc = g(c)
        else:
            a, c, gc = c, d, gd
            d = a + ratio * (b - a)
            gd = g(d)
    return max((gc, c), (gd, d))


def refine(g: Callable[[Any], Any], lo: Any, hi: Any) -> tuple[Any, Any]:
    """The local maximum bracketed by [lo, hi]: Newton on differences at 50 digits, else golden section."""
    x, step = (lo + hi) / 2, (hi - lo) * mp.mpf(10) ** -14
    for _ in range(30):
        if not lo + step < x < hi - step:
            break
        left, here, right = g(x - step), g(x), g(x + step)
        bend = (right - 2 * here + left) / step**2
        if bend >= 0:
            break
        move = -(right - left) / (2 * step) / bend
        if abs(move) < mp.mpf(10) ** -26 * (hi - lo):
            return here, x
        x += move
    return golden(g, lo, hi)


def piece_peak(g: Callable[[Any], Any], nodes: list[Any], samples: list[float]) -> tuple[Any, Any]:
    """Largest g on one smooth piece and where: of both ends and the local maxima among the top samples."""
    lo, hi = nodes[0], nodes[-1]
    found = [(g(lo), lo), (g(hi), hi)]
    spread, size = max(samples) - min(samples), max(map(abs, samples))
    if spread <= 1e-12 * size or size == 0:
        for k in (1, 2, 3):
            if abs(g(lo + (hi - lo) * k / 4) - found[0][0]) > mp.mpf(10) ** -40 * (size or 1):
                raise ArithmeticError("neither constant nor resolved by the scan")
        return found[0]
    top = max(samples) - 0.01 * spread
    for i in range(1, len(nodes) - 1):
        if samples[i] >= top and samples[i - 1] <= samples[i] >= samples[i + 1]:
            found.append(refine(g, nodes[i - 1], nodes[i + 1]))
    for k, inner in ((0, nodes[1]), (-1, nodes[-2])):
        value, end = found[:2][k]
        near = [end + (inner - end) * mp.mpf(10) ** -m for m in (3, 10)]
        if samples[k] >= top and any(g(x) > value for x in near):
            found.append(refine(g, *sorted((end, inner))))
    return best(found)


def best(found: list[tuple[Any, Any]]) -> tuple[Any, Any]:
    """The largest (value, where); of equal values the first of the turn."""
    top = max(value for value, _ in found)
    slack = mp.mpf(10) ** -38 * abs(top)
    return top, min(where for value, where in found if value >= top - slack)


def spans(pieces: list[Piece], coarse: list[Piece], state: State, rough: State) -> list[dict[str, Any]]:
    """For each piece: its kind, and per quantity the largest and least value with their cam angles."""
    out = []
    for p, q in zip(pieces, coarse, strict=True):
        n = 4 if p.kind == "dwell" else SAMPLES
        nodes = [p.start + (p.end - p.start) * k / n for k in range(n + 1)]
        rows = [rough(float(t), q.jet(float(t))) for t in nodes]
        span: dict[str, Any] = {"kind": p.kind}
        for name in rows[0]:
            samples = [float(row[name]) for row in rows]

            def up(t: Any, p: Piece = p, name: str = name) -> Any:
                return state(t, p.jet(t))[name]

            def down(t: Any, up: Callable[[Any], Any] = up) -> Any:
                return -up(t)

            low, at = piece_peak(down, nodes, [-v for v in samples])
            span[name] = (piece_peak(up, nodes, samples), (-low, at))
        out.append(span)
    return out


def turn_max(found: list[dict[str, Any]], name: str, kinds: tuple[str, ...]) -> tuple[Any, Any]:
    """Largest value over the pieces of these kinds, and where."""
    return best([span[name][0] for span in found if span["kind"] in kinds])


def turn_min(found: list[dict[str, Any]], name: str, kinds: tuple[str, ...]) -> tuple[Any, Any]:
    """Least value over the pieces of these kinds, and where."""
    low, at = best([(-v, t) for v, t in (span[name][1] for span in found if span["kind"] in kinds)])
    return -low, at


def turn_abs(found: list[dict[str, Any]], name: str, kinds: tuple[str, ...]) -> tuple[Any, Any]:
    """Largest magnitude over the pieces of these kinds, and where."""
    low, at = turn_min(found, name, kinds)
    return best([turn_max(found, name, kinds), (-low, at)])


# --------------------------------------------------------------------------------------------- the quantities

TURN = ("rise", "dwell", "return")
DERIVATIVES = ("velocity", "acceleration", "jerk")


def motion_state(theta: Any, jet: Jet) -> dict[str, Any]:
    """The derivatives of a motion, as a state."""
    return dict(zip(DERIVATIVES, jet[1:], strict=True))


def motion_unit(scene: Scene, order: int) -> tuple[str, Any]:
    """Suffix and factor that take the derivative of that order from mm (or rad) per rad^order to its unit."""
    oscillating, rpm = scene["follower"]["motion"] == "oscillating", scene["cam"].get("rpm")
    power = "" if order == 1 else str(order)
    if rpm is None:
        unit, factor = ("deg", 180 / mp.pi) if oscillating else ("mm", mp.one)
        return f"{unit}_per_rad{power}", factor
    omega = number(rpm, mp) * 2 * mp.pi / 60
    return (f"rad_s{power}", omega**order) if oscillating else (f"m_s{power}", omega**order / 1000)


def motion_quantities(scene: Scene, pieces: list[Piece], coarse: list[Piece]) -> dict[str, Any]:
    """Peak velocity, acceleration and jerk of rises, returns and both; infinite where what is below jumps."""
    found = spans(pieces, coarse, motion_state, motion_state)
    out: dict[str, Any] = {}
    for order, name in enumerate(DERIVATIVES, 1):
        unit, factor = motion_unit(scene, order)
        for kind in ("rise", "return"):
            infinite = any(stroke_jumps(pieces, k, kind) for k in range(1, order))
            peak = mp.inf if infinite else factor * turn_abs(found, name, (kind,))[0]
            out[f"{name}_max_{kind}_{unit}"] = peak
        out[f"{name}_max_{unit}"] = max(out[f"{name}_max_rise_{unit}"], out[f"{name}_max_return_{unit}"])
    return out


def evaluate(scene: Scene) -> dict[str, Any]:
    """Every quantity of a scene (a dict in the shape of a scene's TOML), at DPS digits.

    Curvature, reach and undercut are left out where the displacement has corners.  `undercut` is the local
    test alone, profile_radius_min_mm <= 0.
    """
    with mp.workdps(DPS):
        oscillating = scene["follower"]["motion"] == "oscillating"
        pieces = programme(scene["motion"], mp, oscillating)
        coarse = programme(scene["motion"], fp, oscillating)
        out = motion_quantities(scene, pieces, coarse)
        found = spans(pieces, coarse, geometry(scene, mp), geometry(scene, fp))

        degrees = 180 / mp.pi
        for key, kinds in {"": TURN, "_rise": ("rise",), "_return": ("return",)}.items():
            out[f"pressure_angle_max{key}_deg"] = turn_abs(found, "beta", kinds)[0] * degrees
        if out["pressure_angle_max_deg"] < mp.mpf(10) ** (10 - DPS):  # square to the motion everywhere
            out |= {key: mp.zero for key in out if key.startswith("pressure_angle")}
        else:
            out["pressure_angle_max_at_deg"] = turn_abs(found, "beta", TURN)[1] * degrees
        if any(jumps(pieces, 1)):
            return out

        if "rho" in found[0]:
            out["profile_radius_min_mm"] = turn_min(found, "rho", TURN)[0]
            out["face_reach_max_mm"] = turn_max(found, "reach", TURN)[0]
            out["face_reach_min_mm"] = turn_min(found, "reach", TURN)[0]
        else:
            out["pitch_curvature_max_per_mm"] = turn_max(found, "kappa", TURN)[0]
            out["pitch_curvature_min_per_mm"] = turn_min(found, "kappa", TURN)[0]
            both_flanks = scene["cam"]["form"] == "cylindrical"
            kappa = (turn_abs if both_flanks else turn_max)(found, "kappa", TURN)[0]
            out["profile_radius_min_mm"] = 1 / kappa - follower_radius(scene)
        out["undercut"] = bool(out["profile_radius_min_mm"] <= 0)
        return out


def law_peaks(law: str) -> tuple[Any, Any, Any]:
    """Peak |v|, |a|, |j| of a law standing between two dwells; infinite where the derivative below jumps."""
    rest = [{"segment": "dwell", "angle": 90}]
    one = [{"segment": s, "angle": 90, "lift": 1, "law": law} for s in ("rise", "return")]
    with mp.workdps(DPS):
        motion = [one[0], *rest, one[1], *rest]
        found = spans(programme(motion), programme(motion, fp), motion_state, motion_state)
        b, pieces = mp.pi / 2, programme(motion)
        return tuple(
            mp.inf
            if any(stroke_jumps(pieces, k, "rise") for k in range(1, order))
            else turn_abs(found, name, ("rise",))[0] * b**order
            for order, name in enumerate(DERIVATIVES, 1)
        )

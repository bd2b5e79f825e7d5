"""Normal force, thrust, guide and torque of any scene, from the equilibrium of the follower in its guide.

An independent answer to ``camopt.model.effects.{loads,thrust,torque}``: no formula of theirs is used. The contact
presses with N along the normal of a flank, the ends of the guide press with R₁ (near) and R₂ (far) across the
motion and rub with μ|R₁| and μ|R₂| against it. Three equations, lateral, of moments about the near end, and along
the motion, give N, R₁ and R₂; the flank that bears is the one with N ≥ 0. A groove has two flanks, an open cam one:
if that gives no N ≥ 0, contact is lost. The torque is what the contact does on the follower by the cam angle.

The geometry is that of ``naive``, in floats. Extremes are those of dense samples, refined between the cam angles
where anything changes sign; integrals are by Gauss's rule between them.
"""

from itertools import pairwise
from math import cos, inf, pi, sin

import numpy as np
from mpmath import fp
from scipy.interpolate import BSpline
from scipy.optimize import brentq, minimize_scalar

from camopt import Scene, evaluate
from support import naive

SAMPLES = 240
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)
LAWS = ["harmonic", "parabolic", "cycloidal", "poly345", "poly4567", "modified-sine", "modified-trapezoid"]


# ----------------------------------------------------------------------------------------------------- motion


def spline_pieces(table):
    """A spline of a scene as the pieces of a law: (x0, x1, jet), without the package's splines."""
    whole = BSpline(np.array(table["knots"]), np.array(table["coefficients"]), table["degree"])
    orders = [whole, *(whole.derivative(k) for k in (1, 2, 3))]

    def jet(x, low, high):
        x = min(max(x, np.nextafter(low, 2)), np.nextafter(high, -1))
        return tuple(float(each(x)) for each in orders)

    breaks = sorted(set(table["knots"]))
    return [(a, b, lambda x, a=a, b=b: jet(x, a, b)) for a, b in pairwise(breaks)]


def turn(scene):
    """The smooth pieces of the turn with the line of the external load over each: (start, end, jet, load)."""
    swinging = scene["follower"]["motion"] == "oscillating"
    degree = pi / 180
    pieces, turned, y = [], 0.0, 0.0
    for segment in scene["motion"]:
        start, angle = turned * degree, segment["angle"] * degree
        turned += segment["angle"]
        lift = segment.get("lift", 0.0) * (degree if swinging else 1.0)
        change = {"rise": lift, "return": -lift, "dwell": 0.0}[segment["segment"]]
        if segment["segment"] == "dwell":
            pieces.append(naive.Piece(start, start + angle, "dwell", lambda theta, y=y: (y, 0.0, 0.0, 0.0)))
        else:
            own = scene.get("laws", {}).get(segment["law"])
            for x0, x1, jet in spline_pieces(own) if own else naive.law_pieces(segment["law"], fp):
                moved = naive.stroke(jet, start, angle, y, change)
                pieces.append(naive.Piece(start + x0 * angle, start + x1 * angle, segment["segment"], moved))
        y += change
    load = scene["follower"]["dynamics"].get("load", 0.0)
    rows = load if isinstance(load, list) else [[0, load]]
    return naive.under_load(pieces, rows, fp)


# ------------------------------------------------------------------------------------------------ equilibrium


class Jams(ArithmeticError):
    """No force of the cam gives the motion; its argument: whether an open cam would have to pull there."""


def along_the_motion(scene, jet, external):
    """F: what has to push the follower along its motion, N (N·mm where it swings)."""
    given, (y, y1, y2, _) = scene["follower"]["dynamics"], jet
    omega = scene["cam"]["rpm"] * pi / 30
    swinging = scene["follower"]["motion"] == "oscillating"
    unit = 1e3 if swinging else 1.0
    mass = given["inertia"] * 1e3 if swinging else given["mass"] * 1e-3
    weight = mass * given.get("gravity", 0.0) * 1e3
    spring = given.get("spring_rate", 0.0) * y + given.get("damping", 0.0) * omega * y1 + given.get("preload", 0.0)
    return mass * omega**2 * y2 + (spring + external) * unit + weight


def equilibrium(scene, force, y, beta, way):
    """N·(the flank's sign), R₁ and R₂ of a follower in its guide that moves a way; Jams where no flank can bear."""
    given = scene["follower"]["dynamics"]
    b, a, mu = given["guide_length"], given["overhang"] - y, given.get("friction", 0.0)
    for flank in (1.0, -1.0):
        across, along = flank * sin(beta), flank * cos(beta)
        far = np.sign(across)  # the far end is pressed the way the contact pushes, the near end against it
        rows = [[across, 1.0, 1.0], [across * a, 0.0, -b], [along, way * mu * far, -way * mu * far]]
        found = np.linalg.solve(rows, [0.0, 0.0, force])
        if found[0] >= 0.0:
            return flank * found[0], found[1], found[2]
    raise Jams(force < 0.0 and scene["cam"]["form"] == "disc")


def state_of(scene):
    """(cam angle, jet, external load, way) to everything that is compared; ``pulled`` where an open cam would."""
    follower, given = scene["follower"], scene["follower"]["dynamics"]
    geometry, groove = naive.geometry(scene, fp), scene["cam"]["form"] == "cylindrical"
    swinging, flat = follower["motion"] == "oscillating", follower["contact"] == "flat"
    guided = not swinging and not flat and "guide_length" in given

    def state(theta, jet, external, way):
        seen, force = geometry(theta, jet), along_the_motion(scene, jet, external)
        beta, y, y1 = float(seen["beta"]), jet[0], jet[1]
        out = {"force": force, "beta": beta, "torque": force * y1, "lost": 0.0}
        if flat:
            out["normal"] = force / seen["reach"] if swinging else force
        elif guided:
            normal, near, far = equilibrium(scene, force, y, beta, way)
            rub = given.get("friction", 0.0) * (abs(near) + abs(far))
            reach = given["overhang"] - y
            out |= {
                "normal": normal,
                "thrust": normal * sin(beta),
                "guide": near,
                "bend": normal * sin(beta) * reach,
            }
            out |= {"torque": normal * cos(beta) * y1, "lost": rub * abs(y1)}
        else:
            lever = follower["arm_length"] if swinging else 1.0
            out |= {"normal": force / lever / cos(beta), "thrust": force / lever * np.tan(beta)}
        if force < 0.0 and not groove:  # contact is lost
            out |= {name: 0.0 for name in ("normal", "thrust", "guide", "bend") if name in out}
        return {name: float(value) for name, value in out.items()}

    return state


# --------------------------------------------------------------------------------------------------- extremes


def smooth(scene):
    """The parts of the turn in which nothing changes sign: (start, end, state of a cam angle)."""
    geometry = naive.geometry(scene, fp)
    for piece, line in turn(scene):
        start, end = piece.start, piece.end

        def signs(theta, piece=piece, line=line):
            jet = piece.jet(theta)
            force = along_the_motion(scene, jet, naive.on_line(line, theta))
            return force, float(jet[1]), float(geometry(theta, jet)["beta"])

        nodes = np.linspace(start, end, SAMPLES + 1)
        rows = np.array([signs(theta) for theta in nodes])
        rows[np.abs(rows) < 1e-13 * np.abs(rows).max(axis=0)] = 0.0  # rounding, as of the speed where a stroke ends
        cuts = [start, end]
        for column, values in enumerate(rows.T):
            for k in np.flatnonzero(values[:-1] * values[1:] < 0.0):
                cuts.append(brentq(lambda x, c=column, f=signs: f(x)[c], nodes[k], nodes[k + 1], xtol=1e-15))
        for low, high in pairwise(sorted(cuts)):
            if high - low > 1e-13:
                way = float(np.sign(piece.jet((low + high) / 2)[1])) if piece.kind != "dwell" else 0.0
                state = state_of(scene)
                yield low, high, lambda x, p=piece, n=line, w=way, s=state: s(x, p.jet(x), naive.on_line(n, x), w)


def top_of(function, nodes, values):
    """The largest value on a part: of both ends, and of the local maxima near the top."""
    best, spread = values.max(), np.ptp(values)

    def refined(low, high):
        return -minimize_scalar(
            lambda x: -function(x), bounds=(low, high), method="bounded", options={"xatol": 1e-11}
        ).fun

    for k in range(len(nodes)):
        before, after = max(k - 1, 0), min(k + 1, len(nodes) - 1)
        if values[k] >= max(values[before], values[after]) and values[k] > best - 0.02 * spread:
            best = max(best, refined(nodes[before], nodes[after]))
    return best


def expected_quantities(scene):
    """Every quantity that is compared, in the units of the package's columns."""
    given, groove = scene["follower"]["dynamics"], scene["cam"]["form"] == "cylindrical"
    parts, top = list(smooth(scene)), {}
    total, squares, spent = 0.0, 0.0, 0.0
    for low, high, state in parts:
        edge = 1e-13 * (high - low)
        nodes = np.linspace(low + edge, high - edge, SAMPLES + 1)
        rows = [state(x) for x in nodes]
        for name in rows[0]:
            values = np.array([row[name] for row in rows])
            for sign, key in ((1.0, f"{name}+"), (-1.0, f"{name}-")):
                if (sign * values).max() > top.get(key, -inf) - 0.05 * np.ptp(values):
                    found = top_of(lambda x, n=name, g=sign, s=state: g * s(x)[n], nodes, sign * values)
                    top[key] = max(top.get(key, -inf), found)
        half = (high - low) / 2
        places = (low + high) / 2 + half * NODES
        at = [state(x) for x in places]
        torque = np.array([row["torque"] for row in at])
        total += half * WEIGHTS @ torque
        squares += half * WEIGHTS @ torque**2
        spent += half * WEIGHTS @ np.array([row["lost"] for row in at])
    omega = scene["cam"]["rpm"] * pi / 30
    mean = total / (2 * pi)
    normal = max(top["normal+"], top["normal-"]) if groove else max(top["normal+"], 0.0)
    out = {
        "normal_force_max_N": normal,
        "torque_max_N_m": top["torque+"] * 1e-3,
        "torque_min_N_m": -top["torque-"] * 1e-3,
        "torque_peak_N_m": max(top["torque+"], top["torque-"]) * 1e-3,
        "torque_mean_N_m": mean * 1e-3,
        "torque_rms_N_m": np.sqrt(squares / (2 * pi)) * 1e-3,
        "power_peak_W": max(top["torque+"], top["torque-"]) * omega * 1e-3,
        "power_mean_W": mean * omega * 1e-3,
        "energy_fluctuation_J": fluctuation(parts, mean) * 1e-3,
        "lost": spent,
    }
    for name, column in (("thrust", "side_thrust_max_N"), ("guide", "guide_reaction_max_N")):
        if f"{name}+" in top:
            out[column] = max(top[f"{name}+"], top[f"{name}-"])
    if "bend+" in top and "stem_diameter" in given:
        out["stem_bending_stress_max_MPa"] = (
            32 * max(top["bend+"], top["bend-"]) / (pi * given["stem_diameter"] ** 3)
        )
    return out


def fluctuation(parts, mean):
    """Largest minus least running integral of T less its mean: its extremes are where T passes the mean."""
    work, reached = 0.0, [0.0]
    for low, high, state in parts:

        def excess(x, state=state):
            return state(x)["torque"] - mean

        nodes = np.linspace(low, high, SAMPLES + 1)
        nodes[[0, -1]] += 1e-12 * (high - low) * np.array([1, -1])
        values = np.array([excess(x) for x in nodes])
        cuts = [low, high]
        for k in np.flatnonzero(values[:-1] * values[1:] < 0.0):
            cuts.append(brentq(excess, nodes[k], nodes[k + 1], xtol=1e-15))
        for a, b in pairwise(sorted(cuts)):
            half = (b - a) / 2
            work += half * sum(w * excess((a + b) / 2 + half * u) for u, w in zip(NODES, WEIGHTS, strict=True))
            reached.append(work)
    return max(reached) - min(reached)


# ----------------------------------------------------------------------------------------------- random scenes

WAVY = {  # rises that turn back on the way: between 0 and 1 throughout
    "wavy": {
        "degree": 4,
        "knots": [0.0] * 5 + [0.25, 0.4, 0.55, 0.7] + [1.0] * 5,
        "coefficients": [0.0, 0.0, 0.1, 0.75, 0.95, 0.25, 0.9, 1.0, 1.0],
    },
    "hesitant": {
        "degree": 5,
        "knots": [0.0] * 6 + [0.3, 0.5, 0.7] + [1.0] * 6,
        "coefficients": [0.0, 0.0, 0.0, 0.9, 0.55, 0.3, 1.0, 1.0, 1.0],
    },
}
CONTACTS = [
    "knife",
    "roller",
    "spherical",
    "roller",
    "groove",
    "groove",
    "flat",
    "arm",
    "swinging-face",
    "groove-arm",
]


def follower_of(contact, random):
    radius = float(random.uniform(4, 25))
    translating = {"motion": "translating", "offset": float(random.uniform(-18, 18))}
    return {
        "knife": {**translating, "contact": "knife"},
        "roller": {**translating, "contact": "roller", "roller_radius": radius},
        "spherical": {**translating, "contact": "spherical", "face_radius": 3 * radius},
        "groove": {"motion": "translating", "contact": "roller", "roller_radius": radius},
        "flat": {"motion": "translating", "contact": "flat"},
        "arm": {
            "motion": "oscillating",
            "contact": "roller",
            "roller_radius": radius,
            "arm_length": float(random.uniform(100, 130)),
            "centre_distance": float(random.uniform(125, 150)),
        },
        "swinging-face": {
            "motion": "oscillating",
            "contact": "flat",
            "centre_distance": float(random.uniform(120, 150)),
            "face_offset": float(random.uniform(0, 20)),
        },
        "groove-arm": {
            "motion": "oscillating",
            "contact": "roller",
            "roller_radius": radius,
            "arm_length": float(random.uniform(90, 140)),
        },
    }[contact]


def random_scene(seed):
    """A scene: every mechanism, springs that lose contact or keep it, laws that turn back, loads that change."""
    random = np.random.default_rng(seed)
    contact = CONTACTS[seed % len(CONTACTS)]
    follower, swinging = follower_of(contact, random), contact in ("arm", "swinging-face", "groove-arm")
    lift = float(random.uniform(5, 12) if swinging else random.uniform(10, 35))
    weights = random.uniform(0.4, 1.6, 4) * random.permutation([1, 1, 1, random.choice([0.0, 0.5, 1.0])])
    angles = np.round(360 * weights / weights.sum(), 3)
    angles[np.argmax(angles)] += round(360 - angles.sum(), 3)
    own = random.random() < 0.3
    laws = [str(random.choice(list(WAVY) if own else LAWS)) for _ in range(2)]
    motion = []
    for kind, angle in zip(("rise", "dwell", "return", "dwell"), angles, strict=True):
        if kind == "dwell":
            motion += [{"segment": kind, "angle": float(angle)}] if angle > 0 else []
        else:
            motion.append(
                {"segment": kind, "angle": float(max(angle, 1)), "lift": lift, "law": laws[kind != "rise"]}
            )
    motion[-1]["angle"] = float(360 - sum(s["angle"] for s in motion[:-1]))
    scale = 1e-2 if swinging else 1.0  # moments in N·m, an arm of about 0.1 m
    given = {
        "inertia" if swinging else "mass": float(random.uniform(0.2, 2.0)) * scale,
        "spring_rate": float(random.uniform(0, 15)) * (10 * scale * 100 if swinging else 1),
        "preload": float(random.choice([0.0, 40.0, 400.0])) * scale * (5 if swinging else 1),
        "damping": float(random.choice([0.0, 0.05])),
    }
    if random.random() < 0.25:
        at = sorted(random.uniform(0, 360, 4))
        given["load"] = [
            [round(float(a), 2), float(p) * scale] for a, p in zip(at, random.uniform(-80, 200, 4), strict=True)
        ]
    if not swinging and contact != "flat":
        given |= {"guide_length": float(random.uniform(50, 120)), "overhang": lift + float(random.uniform(0, 50))}
        given |= {"friction": float(random.choice([0.0, 0.05, 0.12, 0.2])), "stem_diameter": 14.0}
    size = float(random.uniform(45, 110))
    if contact == "swinging-face":
        size = follower["centre_distance"] * 0.6 + follower["face_offset"]
    cam = (
        {"form": "cylindrical", "mean_radius": size}
        if contact.startswith("groove")
        else {"form": "disc", "base_radius": size}
    )
    used = {name: WAVY[name] for name in set(laws) & WAVY.keys()}
    return {
        "cam": {**cam, "rpm": float(random.uniform(60, 900)), "rotation": str(random.choice(["ccw", "cw"]))},
        "follower": {**follower, "dynamics": given},
        "motion": motion,
        "outputs": ["thrust", "torque"],
        **({"laws": used} if used else {}),
    }


def differences(scene):
    """How far each quantity of the package is from that of the model, relative to the largest of its kind."""
    found = evaluate(Scene.from_dict(scene))
    try:
        model = expected_quantities(scene)
    except Jams as jam:  # what an open cam cannot give is a matter of the torque alone
        names = ("torque_peak_N_m", "power_mean_W", *(() if jam.args[0] else ("normal_force_max_N",)))
        model = dict.fromkeys(names, inf)
    apart = {}
    for name, value in model.items():
        if value == inf or name in found.unbounded:
            apart[name] = 0.0 if found[name] == value else inf
        elif name in found:
            scale = model["torque_peak_N_m"] if name.startswith("torque") else abs(value)
            if name == "power_mean_W":
                scale = model["power_peak_W"]
            apart[name] = abs(found[name] - value) / (scale or 1.0)
    return found, apart

"""Scenes where loads decide the size: those whose proof once took minutes, and random ones.

A random scene takes a random cam and sets its limits a few per cent around what that cam has.
"""

from typing import Any

import numpy as np

from camopt import BadInput, Scene, evaluate
from camopt.scene.problem.limits import LOAD_LIMITS

STEEL = {"cam": "steel", "follower": "steel", "face_width": 10}
SURFACE = {"wear_rate": 1e-10, "viscosity": 0.05, "pressure_viscosity": 18, "roughness": 0.3}
MOVED = {"mass": 0.5, "spring_rate": 5, "preload": 100}
GUIDED = {**MOVED, "guide_length": 60, "overhang": 40, "friction": 0.1, "stem_diameter": 12}
SWUNG = {"inertia": 0.01, "spring_rate": 40, "preload": 20}
Raw = dict[str, Any]


def turn(lift: float, angles: tuple[float, ...] = (120, 60, 120, 60), law: str = "cycloidal") -> list[Raw]:
    """A rise and a return of one law between two dwells."""
    moving = {"lift": lift, "law": law}
    kinds = ("rise", "dwell", "return", "dwell")
    return [
        {"segment": kind, "angle": angle, **(moving if kind != "dwell" else {})}
        for kind, angle in zip(kinds, angles, strict=True)
    ]


def named_scenes() -> dict[str, Raw]:
    """The scenes that were found slow."""
    disc = {"form": "disc", "rpm": 300, "base_radius": 60}
    groove = {"form": "cylindrical", "rpm": 300, "mean_radius": 60}
    knife, roller = {"motion": "translating", "contact": "knife"}, {"motion": "translating", "contact": "roller"}
    face = {"motion": "oscillating", "contact": "flat", "centre_distance": 120, "face_offset": 8}
    return {
        "cylindrical knife, normal force with friction": {
            "cam": groove,
            "follower": {**knife, "dynamics": GUIDED},
            "motion": turn(20),
            "limits": {"normal_force": 260},
        },
        "knife, stem bending": {
            "cam": disc,
            "follower": {**knife, "dynamics": GUIDED},
            "motion": turn(20),
            "limits": {"stem_bending_stress": 12},
        },
        "knife, stem bending, offset free": {
            "cam": disc,
            "follower": {**knife, "dynamics": GUIDED},
            "motion": turn(20),
            "limits": {"stem_bending_stress": 12},
            "search": {"offset": {"start": -20, "stop": 20}},
        },
        "roller of 140 mm, contact stress": {
            "cam": disc,
            "follower": {**roller, "roller_radius": 140, "dynamics": MOVED},
            "materials": STEEL,
            "motion": turn(20),
            "limits": {"contact_stress": 250},
        },
        "swinging face, contact stress, three free": {
            "cam": disc,
            "follower": {**face, "dynamics": SWUNG},
            "materials": STEEL,
            "motion": turn(12),
            "limits": {"contact_stress": 200},
            "search": {"face_offset": {"start": -20, "stop": 20}, "centre_distance": {"start": 80, "stop": 160}},
        },
    }


CONTACTS: dict[str, Raw] = {
    "knife": {"motion": "translating", "contact": "knife"},
    "roller": {"motion": "translating", "contact": "roller", "roller_radius": 12},
    "face": {"motion": "translating", "contact": "flat"},
    "mushroom": {"motion": "translating", "contact": "spherical", "face_radius": 60},
    "arm": {"motion": "oscillating", "contact": "roller", "roller_radius": 12, "arm_length": 110},
    "knife on an arm": {"motion": "oscillating", "contact": "knife", "arm_length": 110},
    "mushroom on an arm": {"motion": "oscillating", "contact": "spherical", "face_radius": 60, "arm_length": 110},
    "swinging face": {"motion": "oscillating", "contact": "flat", "face_offset": 8},
    "groove": {"motion": "translating", "contact": "roller", "roller_radius": 8},
    "groove, knife": {"motion": "translating", "contact": "knife"},
    "groove, arm": {"motion": "oscillating", "contact": "roller", "roller_radius": 8, "arm_length": 110},
}
LAWS = ("cycloidal", "harmonic", "poly345", "poly4567", "modified-sine", "modified-trapezoid")
OF_MOTION = ("contact_force_min", "contact_force_elastic", "jump_speed", "residual_vibration", "torque", "power")
QUANTITIES = {
    "pressure_angle": "pressure_angle_max_rise_deg",
    "curvature_radius": "profile_radius_min_mm",
    **{key: quantity for key, quantity in LOAD_LIMITS.items() if key not in OF_MOTION},
}
GEOMETRIC = ("pressure_angle", "curvature_radius")
MOST = {"pressure_angle": 89.0, "jamming_margin": 1.0}
LENGTHS = ("offset", "roller_radius", "face_radius", "arm_length", "centre_distance", "face_offset")
TRIES = 60


def random_scene(seed: int) -> tuple[str, Raw]:
    """What it is, and a scene with limits near what a random cam of it has."""
    rng = np.random.default_rng(seed)
    for _ in range(TRIES):
        contact = str(rng.choice(list(CONTACTS)))
        raw = _random_scene(rng, contact)
        limits = _limits(rng, _quantities(raw))
        if limits:
            return f"{seed} {contact}: {', '.join(limits)}", {**raw, "limits": limits, "search": _search(rng, raw)}
    raise RuntimeError("no random cam has a load to limit")


def _random_scene(rng: Any, contact: str) -> Raw:
    """A random scene without limits."""
    swinging, groove = CONTACTS[contact]["motion"] == "oscillating", contact.startswith("groove")
    follower = dict(CONTACTS[contact])
    for key in ("roller_radius", "face_radius", "arm_length"):
        if key in follower:
            follower[key] = round(float(follower[key] * rng.uniform(0.5, 2.0)), 2)
    if swinging and not groove:
        follower["centre_distance"] = round(float(rng.uniform(1.0, 1.5) * follower.get("arm_length", 120)), 2)
    if not swinging and not groove and contact != "face":
        follower["offset"] = round(float(rng.uniform(-12, 12)), 2)
    follower["dynamics"] = _dynamics(rng, swinging)
    angles = rng.dirichlet([4, 1, 4, 2]) * 300 + 15
    lift = float(rng.uniform(6, 18) if swinging else rng.uniform(5, 30))
    return {
        "cam": {
            "form": "cylindrical" if groove else "disc",
            "mean_radius" if groove else "base_radius": round(float(rng.uniform(25, 110)), 2),
            "rpm": round(float(rng.uniform(60, 600)), 1),
            "rotation": str(rng.choice(["ccw", "cw"])),
        },
        "follower": follower,
        "materials": {**STEEL, **SURFACE},
        "motion": _closed_turn(round(lift, 2), angles, str(rng.choice(LAWS)), str(rng.choice(LAWS))),
    }


def _quantities(raw: Raw) -> Any:
    """All that its cam has; nothing if it cannot be put together."""
    try:
        return evaluate(Scene.from_dict({**raw, "outputs": ["all"]}))
    except BadInput:
        return {}


def _closed_turn(lift: float, angles: Any, rise: str, fall: str) -> list[Raw]:
    """A turn of 360 deg with different laws on its strokes."""
    first = [round(float(a), 1) for a in angles[:3]]
    segments = turn(lift, (*first, round(360 - sum(first), 1)), rise)
    segments[2]["law"] = fall
    return segments


def _dynamics(rng: Any, swinging: bool) -> Raw:
    if swinging:
        inertia, rate = 0.01 * float(rng.uniform(0.3, 3)), float(rng.uniform(0, 80))
        return {"inertia": inertia, "spring_rate": rate, "preload": 30}
    guided = GUIDED if rng.random() < 0.6 else MOVED
    rate, preload = round(float(rng.uniform(0, 15)), 2), round(float(rng.uniform(50, 400)), 1)
    return {**guided, "spring_rate": rate, "preload": preload}


def _limits(rng: Any, cam: Any) -> Raw:
    """Up to two loads, and sometimes angle and curvature, each up to 4 % from what a cam has; none, or a load."""
    values = {key: cam[quantity] for key, quantity in QUANTITIES.items() if quantity in cam}
    values = {key: float(value) for key, value in values.items() if np.isfinite(value) and value > 0.0}
    loads = [key for key in values if key not in GEOMETRIC]
    if not loads or not cam["feasible"]:
        return {}
    chosen = [str(key) for key in rng.permutation(loads)[: int(rng.integers(1, 3))]]
    chosen += [key for key in GEOMETRIC if key in values and rng.random() < 0.3]
    return {key: min(values[key] * float(rng.uniform(0.96, 1.04)), MOST.get(key, np.inf)) for key in chosen}


def _search(rng: Any, raw: Raw) -> Raw:
    """Up to two free sizes beside the cam's own, which has a range or none."""
    follower, cam = raw["follower"], raw["cam"]
    own = "mean_radius" if "mean_radius" in cam else "base_radius"
    others = [str(key) for key in rng.permutation([key for key in LENGTHS if key in follower])]
    search: Raw = {}
    for key in others[: int(rng.integers(0, 3))]:
        room = max(abs(follower[key]) * 0.3, 5.0 if key in ("offset", "face_offset") else 0.0)
        search[key] = {"start": follower[key] - room, "stop": follower[key] + room}
    if rng.random() < 0.5:
        search[own] = {
            "start": cam[own] * float(rng.uniform(0.1, 0.9)),
            "stop": cam[own] * float(rng.uniform(1.2, 5)),
        }
    return search

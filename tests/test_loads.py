"""Loads on the contact: force, thrust and contact stress, against 50 digits, equilibrium, identities and scans."""

from math import inf, isinf, isnan, pi, radians, sqrt

import naive
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import fp, mp

from camopt import BadInput, Scene, certify, evaluate, optimise, sweep
from camopt.effects import EFFECTS
from camopt.quantities import QUANTITIES
from camopt.effects.hertz import DEPTH, SHEAR

STEEL = {"cam": "steel", "follower": "steel", "face_width": 15}
FREE = {"mass": 0.8, "spring_rate": 9.0, "preload": 260.0, "damping": 0.03, "load": 12.0, "gravity": 9.81}
GUIDED = {**FREE, "guide_length": 80, "overhang": 70, "friction": 0.12, "stem_diameter": 16}
SWUNG = {"inertia": 0.02, "spring_rate": 60.0, "preload": 35.0, "damping": 0.2, "load": 1.5}
UNGUIDED = {**FREE, "guide_length": 80, "overhang": 70, "stem_diameter": 16}

CONTACTS = {
    "knife": {"motion": "translating", "contact": "knife"},
    "roller": {"motion": "translating", "contact": "roller", "roller_radius": 14},
    "offset-roller": {"motion": "translating", "contact": "roller", "roller_radius": 14, "offset": 11},
    "flat": {"motion": "translating", "contact": "flat"},
    "spherical": {"motion": "translating", "contact": "spherical", "face_radius": 60},
    "arm": {
        "motion": "oscillating",
        "contact": "roller",
        "roller_radius": 14,
        "arm_length": 110,
        "centre_distance": 130,
    },
    "swinging-face": {"motion": "oscillating", "contact": "flat", "centre_distance": 130, "face_offset": 10},
    "groove": {"motion": "translating", "contact": "roller", "roller_radius": 6},
    "groove-arm": {"motion": "oscillating", "contact": "roller", "roller_radius": 6, "arm_length": 110},
}


def turn_of(law, lift, angles=(110, 40, 95, 115)):
    kinds = ("rise", "dwell", "return", "dwell")
    moving = {"lift": lift, "law": law}
    return [
        {"segment": kind, "angle": angle, **(moving if kind != "dwell" else {})}
        for kind, angle in zip(kinds, angles, strict=True)
    ]


def question(contact, law="cycloidal", dynamics=None, rotation="ccw", rpm=420, **more):
    follower = CONTACTS[contact]
    swinging, groove = follower["motion"] == "oscillating", contact.startswith("groove")
    size = {"form": "cylindrical", "mean_radius": 60} if groove else {"form": "disc", "base_radius": 70}
    chosen = dynamics if dynamics is not None else SWUNG if swinging else UNGUIDED
    return {
        "cam": {**size, "rpm": rpm, "rotation": rotation},
        "follower": {**follower, "dynamics": chosen},
        "materials": STEEL,
        "motion": turn_of(law, 14 if swinging else 24),
        "outputs": ["all"],
        **more,
    }


def found(scene, **changes):
    made = Scene.from_dict(scene)
    return evaluate(made.replace(**changes) if changes else made)


# ------------------------------------------------------------------------------------------ 50 digits


def modulus(materials, ctx):
    """E* of two bodies of the same steel, MPa."""
    assert materials["cam"] == materials["follower"] == "steel"
    return ctx.mpf(207) * 1000 / (2 * (1 - naive.number("0.292", ctx) ** 2))


def constants(scene, ctx):
    """m, c, k and the constant force, in N, mm, s and t (or moments in N·mm)."""
    given = {key: naive.number(str(value), ctx) for key, value in scene["follower"]["dynamics"].items()}
    swinging = scene["follower"]["motion"] == "oscillating"
    unit = 1000 if swinging else 1
    mass = given["inertia"] * 1000 if swinging else given["mass"] / 1000
    constant = (given.get("preload", 0) + given.get("load", 0)) * unit + mass * 1000 * given.get("gravity", 0)
    return mass, given.get("damping", 0) * unit, given.get("spring_rate", 0) * unit, constant, given


def loads(scene, kind, ctx):
    """All loads at a cam angle, as a state of ``naive``; friction opposes the motion of the stroke."""
    geometry = naive.geometry(scene, ctx)
    mass, damping, stiffness, constant, given = constants(scene, ctx)
    omega = naive.number(scene["cam"]["rpm"], ctx) * ctx.pi / 30
    follower = scene["follower"]
    lever = naive.number(follower["arm_length"], ctx) if "arm_length" in follower else 1
    bore, over, mu = (given.get(key, 0) for key in ("guide_length", "overhang", "friction"))
    against = {"rise": -1, "dwell": 0, "return": 1}[kind]

    def state(theta, jet):
        y, y1, y2, _ = jet
        seen = geometry(theta, jet)
        force = mass * omega**2 * y2 + damping * omega * y1 + stiffness * y + constant
        out = {"force": force / lever}
        beta = seen["beta"]
        if "rho" in seen:
            normal = force / seen["reach"] if follower["motion"] == "oscillating" else force
            load = normal / seen["rho"]
        else:
            reach = over - y
            drag = mu * (2 * reach + bore) / bore * abs(ctx.sin(beta)) if bore and mu else 0
            normal = force / lever / (ctx.cos(beta) + against * drag)
            out["thrust"] = normal * ctx.sin(beta)
            if bore:
                out["guide"] = out["thrust"] * (reach + bore) / bore
                out["bend"] = out["thrust"] * reach
            roller = naive.follower_radius(scene, ctx)
            load = None
            if follower["contact"] == "roller":
                flank = seen["kappa"] / (1 - seen["kappa"] * roller)
                load = normal * (flank + 1 / roller)
                if scene["cam"]["form"] == "cylindrical":  # the other flank
                    other = -seen["kappa"] / (1 + seen["kappa"] * roller)
                    out["other"] = normal * (other + 1 / roller)
        out["normal"] = normal
        if load is not None:
            out["load"] = load
        return out

    return state


def slow(scene):
    """Every load of a scene at 50 digits."""
    swinging = scene["follower"]["motion"] == "oscillating"
    groove = scene["cam"]["form"] == "cylindrical"
    with mp.workdps(naive.DPS):
        spans = []
        pieces = [naive.programme(scene["motion"], ctx, swinging) for ctx in (mp, fp)]
        for fine, coarse in zip(*pieces, strict=True):
            spans += naive.spans([fine], [coarse], loads(scene, fine.kind, mp), loads(scene, fine.kind, fp))
        turn, given = naive.TURN, constants(scene, mp)[-1]
        out = {}
        if not (swinging and scene["follower"]["contact"] == "flat"):
            out["contact_force_min_N"] = naive.turn_min(spans, "force", turn)[0]
            out["contact_force_max_N"] = naive.turn_max(spans, "force", turn)[0]
        largest = naive.turn_abs if groove else naive.turn_max
        out["normal_force_max_N"] = largest(spans, "normal", turn)[0]
        if "thrust" in spans[0]:
            out["side_thrust_max_N"] = naive.turn_abs(spans, "thrust", turn)[0]
        if "guide" in spans[0]:
            out["guide_reaction_max_N"] = naive.turn_abs(spans, "guide", turn)[0]
            bend = naive.turn_abs(spans, "bend", turn)[0]
            out["stem_bending_stress_max_MPa"] = 32 * bend / (mp.pi * given["stem_diameter"] ** 3)
        if "load" in spans[0]:
            both = [largest(spans, name, turn) for name in ("load", "other") if name in spans[0]]
            load, at = max(both)
            per = modulus(scene["materials"], mp) / (mp.pi * scene["materials"]["face_width"])
            stress = mp.sqrt(load * per)
            piece = next(p for p in pieces[0] if p.start <= at <= p.end)
            normal = loads(scene, piece.kind, mp)(at, piece.jet(at))["normal"]
            width = 2 * abs(normal) / (mp.pi * scene["materials"]["face_width"] * stress)
            out["contact_stress_max_MPa"] = stress
            out["contact_shear_max_MPa"] = stress * mp.mpf("0.300283106")
            out["contact_half_width_mm"] = width
            out["contact_shear_depth_mm"] = width * mp.mpf("0.786151378")
        return out


CASES = [
    *((contact, "cycloidal", "ccw", None) for contact in CONTACTS),
    ("roller", "parabolic", "cw", None),
    ("offset-roller", "poly4567", "cw", None),
    ("roller", "modified-trapezoid", "ccw", GUIDED),
    ("offset-roller", "modified-sine", "ccw", GUIDED),
    ("knife", "harmonic", "cw", GUIDED),
    ("flat", "parabolic", "ccw", None),
    ("arm", "harmonic", "cw", None),
    ("swinging-face", "poly345", "cw", None),
    ("groove-arm", "parabolic", "cw", None),
]


@pytest.mark.parametrize(("contact", "law", "rotation", "dynamics"), CASES)
def test_all_loads_against_fifty_digits(contact, law, rotation, dynamics):
    scene = question(contact, law, dynamics, rotation)
    ours, theirs = found(scene), slow(scene)
    for name, value in theirs.items():
        rel = 1e-8 if "shear" in name else 2e-12
        assert ours[name] == pytest.approx(float(value), rel=rel, abs=1e-9), name
    assert not {n for n in ours if QUANTITIES[n].effect in LOADED} - theirs.keys() - DERIVED


LOADED = ("force", "thrust", "hertz")
DERIVED = {
    "preload_required_N",
    "preload_required_N_m",
    "spring_rate_required_N_per_mm",
    "spring_rate_required_N_m_per_rad",
    "jump_speed_rpm",
    "jump_speed_ratio",
    "jamming_margin",
    "jamming_angle_deg",
}

"""Loads on the contact: force, thrust and contact stress, against 50 digits, equilibrium, identities and scans."""

from math import inf, isinf, isnan, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import fp, mp
from support import naive
from support.cams import (
    CONTACTS,
    CORNERED,
    FREE,
    GUIDED,
    JUMPING,
    MOMENT,
    STEEL,
    SWUNG,
    UNGUIDED,
    WORN,
    cam_with,
    turn_of,
)
from support.depth import times

from camopt import BadInput, Scene, certify, evaluate, load, optimise, sweep
from camopt.core.quantities import QUANTITIES
from camopt.model.effects import EFFECTS
from camopt.model.effects.hertz import SHEAR_DEPTH, SHEAR_SHARE


def evaluate_changed(scene, **changes):
    made = Scene.from_dict(scene)
    return evaluate(made.replace(**changes) if changes else made)


# ------------------------------------------------------------------------------------------ 50 digits


def modulus(materials, ctx):
    """E* of two bodies of the same steel, MPa."""
    assert materials["cam"] == materials["follower"] == "steel"
    return ctx.mpf(207) * 1000 / (2 * (1 - naive.number("0.292", ctx) ** 2))


def constants(scene, ctx):
    """m, c, k and the constant force, in N, mm, s and t (or moments in N·mm)."""
    dynamics = scene["follower"]["dynamics"].items()
    given = {key: naive.number(str(value), ctx) for key, value in dynamics if not isinstance(value, list)}
    swinging = scene["follower"]["motion"] == "oscillating"
    unit = 1000 if swinging else 1
    mass = given["inertia"] * 1000 if swinging else given["mass"] / 1000
    constant = (given.get("preload", 0) + given.get("load", 0)) * unit + mass * 1000 * given.get("gravity", 0)
    return mass, given.get("damping", 0) * unit, given.get("spring_rate", 0) * unit, constant, given


def loads(scene, kind, line, ctx):
    """All loads at a cam angle, as a state of ``naive``, under an external load that follows a line.

    Friction opposes the motion of the stroke.
    """
    geometry = naive.geometry(scene, ctx)
    mass, damping, stiffness, constant, given = constants(scene, ctx)
    omega = naive.number(scene["cam"]["rpm"], ctx) * ctx.pi / 30
    follower = scene["follower"]
    lever = naive.number(follower["arm_length"], ctx) if "arm_length" in follower else 1
    bore, over, mu = (given.get(key, 0) for key in ("guide_length", "overhang", "friction"))
    against = {"rise": -1, "dwell": 0, "return": 1}[kind]

    @by_angle
    def state(theta, jet):
        y, y1, y2, _ = jet
        seen = geometry(theta, jet)
        external = naive.on_line(line, theta) * (1000 if follower["motion"] == "oscillating" else 1)
        force = mass * omega**2 * y2 + damping * omega * y1 + stiffness * y + constant + external
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
            if follower["contact"] == "roller" and scene["cam"]["form"] == "cylindrical":
                for name, wall in WALLS.items():
                    out[name] = wall * normal * (naive.wall_curvature(scene, theta, jet, wall, ctx) + 1 / roller)
            elif follower["contact"] == "roller":
                flank = seen["kappa"] / (1 - seen["kappa"] * roller)
                load = normal * (flank + 1 / roller)
        out["normal"] = normal
        if load is not None:
            out["load"] = load
        return out

    return state


WALLS = {"push": 1, "pull": -1}
"""The walls of a groove, by the sign of the force that each bears."""


def by_angle(state):
    """A state that is computed once at each cam angle: the peaks of all its values are looked for alike."""
    seen = {}

    def at(theta, jet):
        if theta not in seen:
            seen[theta] = state(theta, jet)
        return seen[theta]

    return at


def line_contact():
    """Largest shear under a line contact, over p₀ and b: on the axis σ_x − σ_z in units of p₀, z in units of b.

    Stresses along the axis are integrals of those of a line load over the elliptic pressure.
    """
    with mp.workdps(30):

        def shear(z):
            root = mp.sqrt(1 + z**2)
            across, along = (1 + 2 * z**2) / root - 2 * z, 1 / root
            return (along - across) / 2

        z = mp.findroot(lambda z: mp.diff(shear, z), 0.78)
        return shear(z), z


def spans_of(scene, make):
    """The extremes of states over the pieces of the motion; and these with their lines of load, fine and coarse."""
    load, found = scene["follower"]["dynamics"].get("load", 0), []
    rows = load if isinstance(load, list) else [[0, 0]]
    swinging = scene["follower"]["motion"] == "oscillating"
    pieces = [naive.under_load(naive.programme(scene["motion"], c, swinging), rows, c) for c in (mp, fp)]
    for (fine, line), (coarse, rough) in zip(*pieces, strict=True):
        both = make(scene, fine.kind, line, mp), make(scene, fine.kind, rough, fp)
        found += naive.spans([fine], [coarse], *both)
    return found, pieces


def slow(scene):
    """Every load of a scene at 50 digits."""
    swinging = scene["follower"]["motion"] == "oscillating"
    groove = scene["cam"]["form"] == "cylindrical"
    with mp.workdps(naive.DPS):
        spans, pieces = spans_of(scene, loads)
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
        names = [name for name in ("load", *WALLS) if name in spans[0]]
        if names:
            load, at = max(naive.turn_max(spans, name, turn) for name in names)
            per = modulus(scene["materials"], mp) / (mp.pi * scene["materials"]["face_width"])
            stress = mp.sqrt(load * per)
            for name in WALLS if groove else ():
                out[f"contact_stress_{name}_MPa"] = mp.sqrt(max(naive.turn_max(spans, name, turn)[0], 0) * per)
            if groove:
                either = max(naive.turn_abs(spans, name, turn)[0] for name in WALLS)
                out["contact_stress_either_MPa"] = mp.sqrt(either * per)
            here = [loads(scene, p.kind, k, mp)(at, p.jet(at)) for p, k in pieces[0] if p.start <= at <= p.end]
            first, last = pieces[0][0], pieces[0][-1]
            here += [loads(scene, p.kind, k, mp)(0, p.jet(0)) for p, k in (first,) if at == last[0].end]
            normal = max(here, key=lambda state: max(state[name] for name in names))["normal"]
            width = 2 * abs(normal) / (mp.pi * scene["materials"]["face_width"] * stress)
            shear, depth = line_contact()
            out["contact_stress_max_MPa"] = stress
            out["contact_shear_max_MPa"] = stress * shear
            out["contact_half_width_mm"] = width
            out["contact_shear_depth_mm"] = width * depth
        return out


ALTERNATING = {"mass": 0.8, "preload": 20.0}  # so that both flanks of a groove carry
CHANGING = [  # external loads over the turn
    ("roller", "modified-trapezoid", GUIDED, JUMPING),
    ("offset-roller", "cycloidal", UNGUIDED, CORNERED),
    ("knife", "parabolic", GUIDED, CORNERED),
    ("flat", "poly345", UNGUIDED, JUMPING),
    ("arm", "modified-sine", SWUNG, MOMENT),
    ("swinging-face", "cycloidal", SWUNG, MOMENT),
    ("groove", "harmonic", UNGUIDED, CORNERED),
]
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
    ("groove", "modified-sine", "cw", ALTERNATING),
    ("groove-arm", "cycloidal", "cw", {"inertia": 0.02}),
    *((contact, law, "ccw", {**dynamics, "load": rows}) for contact, law, dynamics, rows in CHANGING),
]


@pytest.mark.slow
@pytest.mark.one_in(10)
@pytest.mark.parametrize(("contact", "law", "rotation", "dynamics"), CASES)
def test_all_loads_against_fifty_digits(contact, law, rotation, dynamics):
    scene = cam_with(contact, law, dynamics, rotation)
    ours, theirs = evaluate_changed(scene), slow(scene)
    for name, value in theirs.items():
        assert ours[name] == pytest.approx(float(value), rel=2e-12, abs=1e-9), name
    extra = {n for n in ours if QUANTITIES[n].effect == "hertz"} if contact in ELSEWHERE else set()
    assert not {n for n in ours if QUANTITIES[n].effect in LOADED} - theirs.keys() - DERIVED - extra


def surfaces(scene, kind, line, ctx):
    """Film and wear, µm, as a state of ``naive``, from how fast both bodies move along the tangent, in mm/rad."""
    pressed, geometry = loads(scene, kind, line, ctx), naive.geometry(scene, ctx)
    follower, sigma, i = scene["follower"], naive.spin(scene), ctx.mpc(0, 1)
    eta, alpha, wear, width = (
        naive.number(str(scene["materials"][key]), ctx)
        for key in ("viscosity", "pressure_viscosity", "wear_rate", "face_width")
    )
    twice, omega = 2 * modulus(scene["materials"], ctx), naive.number(scene["cam"]["rpm"], ctx) * ctx.pi / 30

    @by_angle
    def state(theta, jet):
        normal = pressed(theta, jet)["normal"]
        if follower["contact"] == "flat":
            face, R = naive.flat_face(scene, ctx, theta, jet), geometry(theta, jet)["rho"]
            swung = follower["motion"] == "oscillating"
            along, y1 = i * face["u"], jet[1]
            moved = -i * y1 * (face["P"] - naive.number(follower["centre_distance"], ctx)) if swung else i * y1
            slid = ((-i * sigma * face["P"] - moved) * along.conjugate()).real
            over = R * (sigma - (y1 if swung else 0))
        else:
            radius = naive.follower_radius(scene, ctx)
            left = 1 - geometry(theta, jet)["kappa"] * radius
            over, R = abs(naive.pitch_curve(scene, ctx, theta, jet)[1]) * left, radius * left
            slid = 0 if follower["contact"] == "roller" else over  # a roller turns, an edge does not
        out = {"worn": 10**9 * wear * normal / width * abs(slid / over)}
        if follower["contact"] != "knife":
            speed = eta * abs(over + slid / 2) * omega / 10**6  # N/mm from Pa·s and mm/s
            load = normal / (twice * R * width)
            lubricant = (alpha * twice / 1000) ** ctx.mpf("0.54")
            out["film"] = 2650 * R * lubricant * (speed / twice / R) ** ctx.mpf("0.7") / load ** ctx.mpf("0.13")
        return out

    return state


@pytest.mark.slow
@pytest.mark.one_in(5)
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("contact", ["offset-roller", "arm", "flat", "swinging-face", "knife"])
def test_film_and_wear_against_fifty_digits(contact, rotation):
    scene = cam_with(contact, "modified-sine", rotation=rotation, materials=WORN)
    ours = evaluate_changed(scene)
    with mp.workdps(naive.DPS):
        spans, _ = spans_of(scene, surfaces)
        assert ours.get("wear_depth_max_um", 0) == pytest.approx(
            float(naive.turn_max(spans, "worn", naive.TURN)[0]), rel=2e-12
        )
        if contact != "knife":
            film = float(naive.turn_min(spans, "film", naive.TURN)[0])
            assert ours["film_thickness_min_um"] == pytest.approx(film, rel=2e-12)
            assert ours["film_ratio_min"] == pytest.approx(film / WORN["roughness"], rel=2e-12)


ELSEWHERE = ("knife", "spherical")  # no bound; test_point_contact.py
LOADED = ("force", "thrust", "hertz")
DERIVED = {  # tested below
    "preload_required_N",
    "preload_required_N_m",
    "spring_rate_required_N_per_mm",
    "spring_rate_required_N_m_per_rad",
    "jump_speed_rpm",
    "jump_speed_ratio",
    "jamming_margin",
    "jamming_angle_deg",
}


# ------------------------------------------------------------------------------------------ the stress field


def test_the_constants_of_line_contact_are_those_of_its_stress_field():
    """By quadrature of Flamant's line load over the elliptic pressure, and of the closed form on the axis."""

    def axis(z):
        def pressed(part):
            return mp.quad(lambda x: mp.sqrt(1 - x**2) * part(x) / (x**2 + z**2) ** 2, [-1, 0, 1])

        normal = 2 * z**3 / mp.pi * pressed(lambda x: 1)
        across = 2 * z / mp.pi * pressed(lambda x: x**2)
        return (normal - across) / 2

    shear, depth = line_contact()
    assert float(axis(depth)) == pytest.approx(float(shear), rel=1e-12)
    assert all(axis(depth * k) < shear for k in (0.99, 1.01))
    assert pytest.approx(float(shear), rel=1e-13) == SHEAR_SHARE
    assert pytest.approx(float(depth), rel=1e-13) == SHEAR_DEPTH


# -------------------------------------------------------------------------------------- worked example


def test_parallel_cylinders_by_the_formula_of_the_textbooks():
    """p = 2F/(π·b·l), b = √((2F/(π·l))·((1 − ν₁²)/E₁ + (1 − ν₂²)/E₂)/(1/d₁ + 1/d₂)): Shigley, cylindrical contact.

    A round cam (a dwell beside a negligible lift) under a load alone: d₁ = 2·R_b, d₂ = 2·R_r.
    """
    scene = cam_with("roller", dynamics={"mass": 1e-9, "preload": 500.0}, rpm=1e-3)
    scene["motion"] = turn_of("cycloidal", 1e-9)
    scene["materials"] = {"cam": "grey-cast-iron", "follower": "steel", "face_width": 20}
    ours = evaluate_changed(scene)
    compliance = (1 - 0.211**2) / 100e3 + (1 - 0.292**2) / 207e3
    half = sqrt(2 * 500 / (pi * 20) * compliance / (1 / 140 + 1 / 28))
    assert ours["contact_half_width_mm"] == pytest.approx(half, rel=1e-9)
    assert ours["contact_stress_max_MPa"] == pytest.approx(2 * 500 / (pi * half * 20), rel=1e-9)


# ------------------------------------------------------------------------------------------ identities


def with_dynamics(scene, **dynamics):
    return {**scene, "follower": {**scene["follower"], "dynamics": {**scene["follower"]["dynamics"], **dynamics}}}


def at_speed(scene, rpm):
    return {**scene, "cam": {**scene["cam"], "rpm": rpm}}


FORCES = ("contact_force_min_N", "contact_force_max_N", "normal_force_max_N", "side_thrust_max_N")


@pytest.mark.slow
@pytest.mark.parametrize("contact", ["offset-roller", "arm", "groove"])
def test_inertia_is_linear_in_mass_and_square_in_speed(contact):
    mass = "inertia" if CONTACTS[contact]["motion"] == "oscillating" else "mass"
    bare = cam_with(contact, dynamics={mass: 0.5})
    once, twice = evaluate_changed(bare), evaluate_changed(with_dynamics(bare, **{mass: 1.0}))
    slowed = evaluate_changed(at_speed(with_dynamics(bare, **{mass: 0.5 * 9}), 140))
    for name in FORCES:
        assert twice[name] == pytest.approx(2 * once[name], rel=1e-12)
        assert slowed[name] == pytest.approx(once[name], rel=1e-12)


def test_guide_and_stem_are_in_equilibrium():
    """Forces and moments on the follower, solved at dense samples: the reported values bound and reach them."""
    scene = cam_with("roller", "poly345", GUIDED)
    mass, damping, stiffness, constant, given = [float(v) for v in constants(scene, mp)[:4]] + [
        constants(scene, mp)[4]
    ]
    omega, mu, b = 420 * pi / 30, 0.12, 80.0
    peak = {"N": 0.0, "S": 0.0, "near": 0.0, "bend": 0.0}
    for piece in naive.programme(scene["motion"], fp):
        against = {"rise": -1, "dwell": 0, "return": 1}[piece.kind]
        for theta in np.linspace(piece.start, piece.end, 1501):
            y, y1, y2, _ = piece.jet(theta)
            beta = np.arctan2(y1, 84.0 + y)
            a = 70.0 - y
            force = mass * omega**2 * y2 + damping * omega * y1 + stiffness * y + constant
            s, side = np.sin(beta), np.sign(np.sin(beta)) or 1.0
            rows = [
                [np.cos(beta), against * mu, against * mu],  # along the motion
                [s, -side, side],  # across it
                [0.0, -a, a + b],  # moments about the trace point
            ]
            normal, near, far = np.linalg.solve(rows, [force, 0.0, 0.0])
            assert near >= 0.0 or normal < 0.0
            for name, value in zip(peak, (normal, normal * abs(s), near, abs(normal * s) * a), strict=True):
                peak[name] = max(peak[name], value)
            del far
    peak["bend"] *= 32 / (pi * float(given["stem_diameter"]) ** 3)
    ours = evaluate_changed(scene)
    names = ("normal_force_max_N", "side_thrust_max_N", "guide_reaction_max_N", "stem_bending_stress_max_MPa")
    for name, most in zip(names, peak.values(), strict=True):
        assert most <= ours[name] * (1 + 1e-12)
        assert most == pytest.approx(ours[name], rel=1e-5)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("damping", [0.0, 0.05, 0.6])
@pytest.mark.parametrize(("contact", "law"), [("roller", "cycloidal"), ("arm", "parabolic"), ("flat", "poly4567")])
def test_contact_is_lost_at_the_jump_speed(contact, law, damping):
    scene = cam_with(contact, law)
    scene["outputs"] = ["force"]
    swinging = CONTACTS[contact]["motion"] == "oscillating"
    scene = with_dynamics(scene, damping=damping * (10 if swinging else 1))
    jump = evaluate_changed(scene)["jump_speed_rpm"]
    at, above = evaluate_changed(at_speed(scene, jump)), evaluate_changed(at_speed(scene, jump * (1 + 1e-9)))
    scale = at["contact_force_max_N"]
    assert at["jump_speed_ratio"] == pytest.approx(1.0, rel=1e-14)
    assert abs(at["contact_force_min_N"]) < 1e-12 * scale
    assert above["contact_force_min_N"] < 0.0
    for share in np.linspace(0.02, 0.98, 25):
        assert evaluate_changed(at_speed(scene, jump * share))["contact_force_min_N"] > 0.0


@pytest.mark.slow
def test_contact_that_damping_loses():
    """A falling follower that its damper holds up: kept at every speed below the jump speed, lost just above."""
    scene = cam_with("roller", dynamics={"mass": 1.0, "damping": 5.0, "preload": 300.0, "spring_rate": 8.0})
    scene["outputs"] = ["force"]
    jump = evaluate_changed(scene)["jump_speed_rpm"]
    speeds = jump * np.linspace(0.9, 1.3, 100)
    kept = np.array([evaluate_changed(at_speed(scene, rpm))["contact_force_min_N"] > 0.0 for rpm in speeds])
    np.testing.assert_array_equal(kept[speeds < jump], True)
    assert not kept[speeds > jump][0]


@pytest.mark.parametrize(("contact", "law"), [("roller", "cycloidal"), ("arm", "harmonic"), ("flat", "parabolic")])
def test_what_is_required_just_keeps_contact(contact, law):
    swinging = CONTACTS[contact]["motion"] == "oscillating"
    scene = at_speed(cam_with(contact, law), 1500)
    scene["outputs"] = ["force"]
    ours = evaluate_changed(scene)
    assert ours["contact_force_min_N"] < 0.0
    preload = ours["preload_required_N_m" if swinging else "preload_required_N"]
    rate = ours["spring_rate_required_N_m_per_rad" if swinging else "spring_rate_required_N_per_mm"]
    for change in ({"preload": preload}, {"spring_rate": rate}):
        kept = evaluate_changed(with_dynamics(scene, **change))
        assert abs(kept["contact_force_min_N"]) < 1e-12 * kept["contact_force_max_N"]
        less = {key: value * (1 - 1e-6) for key, value in change.items()}
        assert evaluate_changed(with_dynamics(scene, **less))["contact_force_min_N"] < 0.0


def test_contact_stress_goes_with_the_root_of_load_over_width():
    scene = cam_with("roller", dynamics={"mass": 0.5, "preload": 900.0})
    once = evaluate_changed(scene)
    wide = evaluate_changed({**scene, "materials": {**STEEL, "face_width": 60}})
    heavy = evaluate_changed(with_dynamics(scene, mass=2.0, preload=3600.0))
    for name in ("contact_stress_max_MPa", "contact_half_width_mm"):
        assert wide[name] == pytest.approx(once[name] / 2, rel=1e-12)
        assert heavy[name] == pytest.approx(once[name] * 2, rel=1e-12)


@pytest.mark.parametrize("contact", ["offset-roller", "flat"])
def test_lengths_scale(contact):
    """All lengths × k with the same forces: forces stay, and the stress falls as 1/k with the face as wide."""
    k = 3.0
    scene = cam_with(contact, dynamics={"mass": 0.9, "spring_rate": 6.0, "preload": 200.0})
    big = with_dynamics(scene, mass=0.9 / k, spring_rate=6.0 / k)
    big["cam"] = {**scene["cam"], "base_radius": 70 * k}
    for name in ("roller_radius", "offset"):
        if name in big["follower"]:
            big["follower"][name] = scene["follower"][name] * k
    big["motion"] = turn_of("cycloidal", 24 * k)
    big["materials"] = {**STEEL, "face_width": 15 * k}
    one, other = evaluate_changed(scene), evaluate_changed(big)
    for name in FORCES:
        if name in one:
            assert other[name] == pytest.approx(one[name], rel=1e-12)
    assert other["contact_stress_max_MPa"] == pytest.approx(one["contact_stress_max_MPa"] / k, rel=1e-12)
    assert other["contact_half_width_mm"] == pytest.approx(one["contact_half_width_mm"], rel=1e-9)


def test_a_mirrored_cam_has_the_same_loads():
    one = cam_with("offset-roller", dynamics=GUIDED)
    other = cam_with("offset-roller", dynamics=GUIDED, rotation="cw")
    other["follower"] = {**other["follower"], "offset": -11}
    ours, mirrored = evaluate_changed(one), evaluate_changed(other)
    turned = ("offset_mm", "centroid_x_mm")
    assert mirrored["centroid_x_mm"] == -ours["centroid_x_mm"]
    assert {n: v for n, v in ours.items() if n not in turned} == {
        n: v for n, v in mirrored.items() if n not in turned
    }


@pytest.mark.slow
def test_a_huge_roller_is_a_flat_face():
    """As R_r grows the trace point's normal turns into the motion, and 1/R into 1/ρ of the flat face."""
    flat = evaluate_changed(cam_with("flat"))
    scene = cam_with("roller")
    scene["follower"] = {**scene["follower"], "roller_radius": 1e8}
    roller = evaluate_changed(scene)
    for name in ("normal_force_max_N", "contact_stress_max_MPa", "contact_half_width_mm"):
        assert roller[name] == pytest.approx(flat[name], rel=1e-6)


@pytest.mark.parametrize("contact", ["groove", "offset-roller"])
def test_friction_never_hides_a_load(contact):
    """Samples with the friction on the side where it acts: a groove pulls, and then it acts on the other."""
    scene = cam_with(contact, "harmonic", {**GUIDED, "preload": 20.0}, rpm=500)
    ours, top = evaluate_changed(scene), 0.0
    mass, damping, stiffness, constant, _ = constants(scene, fp)
    omega, groove = 500 * pi / 30, contact == "groove"
    geometry = naive.geometry(scene, fp)
    for piece in naive.programme(scene["motion"], fp):
        for theta in np.linspace(piece.start, piece.end, 801):
            jet = piece.jet(theta)
            beta = geometry(theta, jet)["beta"]
            force = mass * omega**2 * jet[2] + damping * omega * jet[1] + stiffness * jet[0] + constant
            if force < 0.0 and not groove:
                continue
            against = {"rise": -1, "dwell": 0, "return": 1}[piece.kind] * np.sign(force)
            drag = 0.12 * (2 * (70 - jet[0]) + 80) / 80 * abs(np.sin(beta))
            top = max(top, abs(force) / (np.cos(beta) + against * drag))
    assert top <= ours["normal_force_max_N"] * (1 + 1e-12)
    assert top == pytest.approx(ours["normal_force_max_N"], rel=2e-2)


# ------------------------------------------------------------------------------------- what is infinite


def reasons(scene):
    made = evaluate_changed(scene)
    assert not any(isinstance(v, float) and isnan(v) for v in made.values())
    return made, made.unbounded


@pytest.mark.parametrize("contact", list(CONTACTS))
def test_corners_make_loads_infinite_and_say_why(contact):
    made, why = reasons(cam_with(contact, "uniform"))
    for name, quantity in QUANTITIES.items():
        if name in why and quantity.effect in LOADED:
            knife = contact == "knife" and quantity.effect == "hertz"
            assert (
                why[name] == "a knife edge has no width" if knife else why[name].startswith("the velocity jumps at")
            )
    assert made["normal_force_max_N"] == inf
    assert made["jump_speed_rpm"] == 0.0


def test_undercut_and_jamming_make_loads_infinite_and_say_why():
    sharp = cam_with("roller", dynamics=GUIDED)
    sharp["cam"]["base_radius"] = 4
    sharp["follower"] = {**sharp["follower"], "roller_radius": 40}
    made, why = reasons(sharp)
    assert made["undercut"]
    assert why["contact_stress_max_MPa"] == why["contact_half_width_mm"] == "the profile is undercut"
    stuck = with_dynamics(cam_with("roller", dynamics=GUIDED), friction=3.0)
    made, why = reasons(stuck)
    assert made["jamming_margin"] < 0.0
    for name in ("normal_force_max_N", "guide_reaction_max_N", "contact_stress_max_MPa", "contact_shear_depth_mm"):
        assert made[name] == inf
        assert why[name] == "the follower jams in its guide"


UNDERCUT, JAMMED = "the profile is undercut", "the follower jams in its guide"


@pytest.mark.parametrize(
    ("contact", "base_radius", "dynamics", "expected"),
    [
        ("flat", 10, FREE, {"contact_stress_max_MPa": UNDERCUT, "wear_depth_max_um": UNDERCUT}),
        ("spherical", 10, FREE, {"contact_stress_max_MPa": UNDERCUT, "contact_half_length_mm": UNDERCUT}),
        (
            "knife",
            40,
            {**GUIDED, "friction": 3.0},
            {
                "normal_force_max_N": JAMMED,
                "wear_depth_max_um": JAMMED,
                "contact_stress_max_MPa": "a knife edge has no width",
            },
        ),
    ],
)
def test_each_infinite_load_has_its_own_reason(contact, base_radius, dynamics, expected):
    scene = cam_with(contact, dynamics=dynamics, materials=WORN)
    scene["cam"]["base_radius"] = base_radius
    made, why = reasons(scene)
    for name, reason in expected.items():
        assert made[name] == inf
        assert why[name] == reason


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
def test_a_face_that_turns_as_fast_as_the_cam(rotation):
    """ψ' reaches 1 where 60° are swung in 30° of the cam: the contact runs off, and nothing is NaN."""
    scene = cam_with("swinging-face", rotation=rotation, materials=WORN)
    scene["cam"]["base_radius"] = 60
    scene["motion"] = turn_of("cycloidal", 60, (30, 150, 30, 150))
    made, why = reasons(scene)
    assert made["profile_radius_min_mm"] == -inf
    assert why["profile_radius_min_mm"] == why["face_reach_max_mm"] == "the face turns as fast as the cam"
    assert why["contact_stress_max_MPa"] == why["wear_depth_max_um"] == UNDERCUT
    assert made["feasible"] is False


def test_no_spring_presses_where_the_follower_is_lowest():
    made, why = reasons(cam_with("roller", dynamics={"mass": 1.0, "preload": 5.0, "load": -9.0}))
    assert made["spring_rate_required_N_per_mm"] == inf
    assert "no spring rate" in why["spring_rate_required_N_per_mm"]
    assert made["jump_speed_rpm"] == 0.0


def test_a_flank_that_conforms_to_the_roller_carries_without_stress():
    """κ_profile → −1/R_r: κ_pitch → −∞ there, so the stress comes from elsewhere and stays finite."""
    for base in (30.0, 20.0, 12.0, 9.0):
        scene = cam_with("roller", "harmonic", rpm=30)
        scene["cam"]["base_radius"] = base
        scene["follower"] = {**scene["follower"], "roller_radius": 3.0}
        made, _ = reasons(scene)
        assert 0.0 < made["contact_stress_max_MPa"] <= inf


@settings(max_examples=times(9, deep=600))
@given(
    contact=st.sampled_from(list(CONTACTS)),
    law=st.sampled_from(["uniform", "parabolic", "cycloidal"]),
    rpm=st.floats(1e-9, 1e15),
    extreme=st.tuples(*[st.floats(0, 1e15)] * 3),
    mass=st.floats(1e-15, 1e15),
    load=st.floats(-1e9, 1e9),
    friction=st.floats(0, 1e15),
    moduli=st.tuples(*[st.floats(1e-15, 1e15)] * 2),
    width=st.floats(1e-9, 1e9),
)
def test_no_dynamics_give_nan(contact, law, rpm, extreme, mass, load, friction, moduli, width):  # noqa: PLR0913
    swinging = CONTACTS[contact]["motion"] == "oscillating"
    names = ("spring_rate", "preload", "damping")
    dynamics = {"inertia" if swinging else "mass": mass, **dict(zip(names, extreme, strict=True)), "load": load}
    if not swinging:
        dynamics |= {"guide_length": 80, "overhang": 70, "friction": friction, "stem_diameter": 12}
    scene = cam_with(contact, law, dynamics, rpm=rpm)
    scene["outputs"] = list(LOADED)[: 2 if contact == "spherical" else 3]
    scene["materials"] = {"cam_poisson": 0.3, "follower_poisson": 0.0, "face_width": width}
    scene["materials"] |= {"cam_modulus": moduli[0], "follower_modulus": moduli[1]}
    made, why = reasons(scene)
    assert {n for n, v in made.items() if isinstance(v, float) and isinf(v)} == why.keys()


# ------------------------------------------------------------------------------------------------ the plan


@pytest.mark.parametrize("contact", list(CONTACTS))
def test_what_two_plans_share_is_the_same_to_the_bit(contact):
    scene = cam_with(contact)
    everything = evaluate_changed(scene)
    for outputs in (["pressure", "curvature"], ["force"], ["normal_force_max_N"], ["jump_speed_ratio"], ["thrust"]):
        some = evaluate_changed({**scene, "outputs": outputs})
        assert some.keys() - {"relative_half_width"} <= everything.keys()
        assert all(some[n] == everything[n] for n in some if n != "relative_half_width")
    if "contact_stress_max_MPa" in everything:
        alone = evaluate_changed({**scene, "outputs": ["contact_stress_max_MPa"]})
        assert alone["contact_stress_max_MPa"] == everything["contact_stress_max_MPa"]


def test_a_sweep_with_and_without_loads_agrees_to_the_bit(tmp_path):
    scene = cam_with("roller", dynamics=GUIDED, search={"base_radius": [50, 60, 70]})
    names = ["base_radius_mm", "pressure_angle_max_deg", "profile_radius_min_mm"]
    for folder, outputs in (("few", names), ("all", ["all"])):
        sweep(Scene.from_dict({**scene, "outputs": outputs}), tmp_path / folder, keep="all")
    few, everything = (load(tmp_path / folder / "designs.parquet") for folder in ("few", "all"))
    assert len(few) == 3
    for name in names:
        np.testing.assert_array_equal(few[name], everything[name])


@pytest.mark.parametrize("key", ["friction", "damping", "preload", "gravity", "load", "spring_rate"])
def test_a_parameter_of_zero_is_one_left_out(key):
    dynamics = {name: value for name, value in GUIDED.items() if name != key}
    absent, zero = (
        evaluate_changed(cam_with("offset-roller", dynamics=d)) for d in (dynamics, {**dynamics, key: 0.0})
    )
    assert dict(absent) == dict(zero)


READS = {("hertz", "thrust"), ("surface", "thrust")}  # both ask whether the follower jams


@pytest.mark.slow
@pytest.mark.parametrize("idle", LOADED)
def test_what_nobody_calls_for_does_not_run(idle, monkeypatch):
    def run(case, wanted):
        raise AssertionError(idle)

    scene = cam_with("roller", dynamics=GUIDED)
    of_scene = {QUANTITIES[name].effect for name in evaluate_changed(scene)} & EFFECTS.keys()
    others = [name for name in of_scene if name != idle and (name, idle) not in READS]
    monkeypatch.setitem(EFFECTS, idle, EFFECTS[idle]._replace(evaluate_columns=run))
    assert evaluate_changed({**scene, "outputs": others})
    with pytest.raises(AssertionError, match=idle):
        evaluate_changed({**scene, "outputs": [idle]})


# ------------------------------------------------------------------------------------------ missing keys


def mistakes(scene):
    with pytest.raises(BadInput) as error:
        evaluate_changed(scene)
    return [str(mistake) for mistake in error.value.mistakes]


def test_limits_on_loads_name_the_keys_they_lack():
    scene = cam_with("roller")
    bare = {key: value for key, value in scene.items() if key not in ("materials", "outputs")}
    bare["cam"] = {"form": "disc", "base_radius": 70}
    bare["follower"] = CONTACTS["roller"]
    bare["limits"] = {"contact_stress": 900, "jump_speed": 500, "guide_reaction": 100}
    jump, guide, stress = sorted(mistakes(bare), key=lambda line: ["jump", "guide", "contact"].index(
        next(word for word in ("jump", "guide", "contact") if f"limits.{word}" in line)
    ))  # fmt: skip
    mass = "follower.dynamics.mass"
    assert f"needs {mass}" in jump
    assert "cam.rpm" not in jump
    for key in ("cam.rpm", mass, "materials.cam", "materials.follower", "materials.face_width"):
        assert key in stress
    for key in ("cam.rpm", mass, "follower.dynamics.guide_length", "follower.dynamics.overhang"):
        assert key in guide
    (line,) = mistakes({**bare, "limits": {}, "outputs": ["contact_stress_max_MPa"]})
    assert "needs cam.rpm, follower.dynamics.mass, materials.cam" in line
    (line,) = mistakes({**bare, "limits": {}, "outputs": ["contact_stres_max_MPa"]})
    assert "contact_stress_max_MPa" in line


@pytest.mark.parametrize(
    ("contact", "dynamics", "key"),
    [
        ("arm", {"mass": 1.0}, "mass"),
        ("arm", {**SWUNG, "friction": 0.1}, "friction"),
        ("arm", {**SWUNG, "gravity": 9.81}, "gravity"),
        ("roller", {"inertia": 1.0}, "inertia"),
        ("roller", {**GUIDED, "overhang": 20.0}, "overhang"),
    ],
)
def test_keys_of_another_follower_are_mistakes(contact, dynamics, key):
    lines = mistakes({**cam_with(contact, dynamics=dynamics), "outputs": ["motion"]})
    assert len(lines) == 1
    assert f"follower.dynamics.{key}" in lines[0]


# ----------------------------------------------------------------------------------------- the smallest cam


@pytest.mark.long
@pytest.mark.parametrize(
    ("contact", "limit", "quantity", "bound", "dynamics"),
    [
        ("roller", "contact_stress", "contact_stress_max_MPa", 330.0, None),
        ("offset-roller", "side_thrust", "side_thrust_max_N", 90.0, GUIDED),
        pytest.param("roller", "normal_force", "normal_force_max_N", 640.0, GUIDED, marks=pytest.mark.long),
        pytest.param("flat", "contact_stress", "contact_stress_max_MPa", 180.0, None, marks=pytest.mark.long),
        ("roller", "jamming_margin", "jamming_margin", 0.9, GUIDED),
        pytest.param("groove", "side_thrust", "side_thrust_max_N", 150.0, UNGUIDED, marks=pytest.mark.long),
        pytest.param(
            "groove", "contact_stress", "contact_stress_max_MPa", 206.0, ALTERNATING, marks=pytest.mark.long
        ),
    ],
)
def test_the_smallest_cam_under_a_load(contact, limit, quantity, bound, dynamics):
    scene = cam_with(contact, dynamics=dynamics, limits={limit: bound})
    scene["outputs"] = [quantity]
    key = "mean_radius" if contact == "groove" else "base_radius"
    falls = -1.0 if limit == "jamming_margin" else 1.0
    made = Scene.from_dict({**scene, "limits": {}})
    low, high = 5.0, 2000.0

    def holds(size):
        value = evaluate(made.replace(**{f"cam.{key}": size}))[quantity]
        return falls * value <= falls * bound

    assert holds(high)
    while high - low > 1e-7:
        middle = (low + high) / 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    best = optimise(Scene.from_dict(scene)).best
    least = best[f"{key}_mm"]
    assert least == pytest.approx(high, abs=1e-6)
    assert best["proved"]
    assert limit in best["binding"]
    question_ = Scene.from_dict(scene)
    assert certify(question_.replace(**{f"cam.{key}": least}))[limit] == "held"
    assert certify(question_.replace(**{f"cam.{key}": least - 1e-6}))[limit] == "broken"


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("contact", "limits"),
    [
        ("roller", {"jump_speed": 1e5}),
        ("roller", {"contact_force_min": 1e5}),
        ("arm", {"jump_speed": 1e5}),
        ("groove", {"contact_force_min": 1e5}),
        ("knife", {"contact_stress": 1e9}),
        ("roller", {"jamming_margin": 1.0}),
    ],
)
def test_a_limit_that_no_size_holds_is_named(contact, limits):
    dynamics = GUIDED if "jamming_margin" in limits else None
    scene = {**cam_with(contact, dynamics=dynamics, limits=limits), "outputs": ["sizes"]}
    if contact != "groove":
        scene["search"] = {"base_radius": {"start": 40, "stop": 120}}
    answer = optimise(Scene.from_dict(scene))
    assert answer.best is None
    assert not answer.out_of_time
    assert all(next(iter(limits)) in obstacle for obstacle in answer.obstacles.values())


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("contact", ["knife", "flat"])
@pytest.mark.parametrize("law", ["cycloidal", "poly345"])
def test_a_limit_next_to_the_least_load_of_all_sizes_is_solved_and_one_equal_to_it_is_not_proved(contact, law):
    """The spring at full lift, 100 N + 5 N/mm · 24 mm, which no size changes, decides but for rounding.

    1e-14 above it, intervals prove cams that doubles leave undecided.
    """
    scene = cam_with(contact, law, {"mass": 0.5, "spring_rate": 5, "preload": 100}, rpm=300)

    def solve(share):
        return optimise(Scene.from_dict({**scene, "limits": {"normal_force": 220.0 * (1.0 + share)}}))

    best, eased, tie = solve(1e-14).best, solve(1e-11).best, solve(0.0)
    assert best["proved"]
    assert best["base_radius_mm"] == pytest.approx(eased["base_radius_mm"], abs=5e-9 * 80)
    assert evaluate(best.scene)["feasible"]
    assert (tie.best, tie.out_of_time) == (None, False)
    assert tie.obstacles == {law: "normal_force (not proved)"}


@pytest.mark.parametrize(("share", "verdict"), [(1e-13, "held"), (0.0, "undecided"), (-1e-13, "broken")])
def test_a_limit_at_the_end_of_a_stroke_is_decided_next_to_the_bound(share, verdict):
    scene = cam_with("flat", "cycloidal", {"mass": 0.5, "spring_rate": 5, "preload": 100}, rpm=300)
    limits = {"normal_force": 220.0 * (1.0 + share)}
    assert certify(Scene.from_dict({**scene, "limits": limits}))["normal_force"] == verdict


@pytest.mark.slow
def test_a_motion_that_rounding_leaves_undecided_is_no_proof():
    scene = cam_with("flat", "cycloidal", {"mass": 0.5, "spring_rate": 5, "preload": 100}, rpm=300)
    torque = evaluate(Scene.from_dict(scene))["torque_peak_N_m"]
    limited = {**scene, "limits": {"torque": torque * (1.0 - 1e-15)}, "outputs": ["sizes"]}
    answer = optimise(Scene.from_dict(limited))
    assert (answer.best, answer.out_of_time) == (None, False)
    assert next(iter(answer.obstacles.values())) == "torque (not proved)"


# -------------------------------------------------------------------------------------- near an undercut

NEARLY = [  # law, angles, spring rate, preload, rpm, base radius, roller radius, offset
    ("modified-trapezoid", (53, 10, 64, 233), 10, 300, 1500, 10.35, 11.21, -4.8),
    ("poly345", (79, 10, 104, 167), 10, 150, 600, 13.68, 40.49, -4.7),
]


def nearly_undercut(law, angles, spring_rate, preload, rpm, base_radius, roller_radius, offset, **more):
    dynamics = {"mass": 0.8, "spring_rate": spring_rate, "preload": preload}
    scene = cam_with("offset-roller", law, dynamics, rpm=rpm, motion=turn_of(law, 20, angles), **more)
    scene["cam"]["base_radius"] = base_radius
    scene["follower"] |= {"roller_radius": roller_radius, "offset": offset}
    return scene


@pytest.mark.slow
@pytest.mark.parametrize("given", NEARLY)
def test_a_stress_near_an_undercut_is_as_exact_as_elsewhere(given):
    """A bound of the rounding error over a whole panel says nothing where N/R is nearly divided by zero."""
    scene = nearly_undercut(*given)
    ours, theirs = evaluate_changed({**scene, "outputs": ["hertz"]}), slow(scene)["contact_stress_max_MPa"]
    assert 0.0 < ours["profile_radius_min_mm"] < 1.0
    assert ours["contact_stress_max_MPa"] == pytest.approx(float(theirs), rel=1e-11)
    assert ours["relative_half_width"] < 1e-11


def test_a_sweep_reaches_its_tolerance_near_an_undercut():
    scene = nearly_undercut(*NEARLY[0], limits={"contact_stress": 3000.0}, outputs=[])
    sizes = {"base_radius": [10, 14, 18, 22], "roller_radius": [11, 14, 17, 20], "offset": [-5, 0, 5]}
    numbers = {"dynamics": {"spring_rate": [0, 10], "preload": [10, 300]}}
    objectives = ["base_radius_mm", "contact_stress_max_MPa"]
    scene["search"] = {**sizes, "follower": numbers, "minimise": objectives}
    result = sweep(Scene.from_dict(scene))
    assert result.reached <= 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("base_radius", [13.387580233188274, 13.387321430531342])
def test_the_half_width_next_to_an_undercut_is_that_of_rounding(base_radius):
    """Profile radii of 3e-4 and 1e-4 mm are differences of 54 mm, whose rounding is more than the tolerance."""
    scene = nearly_undercut(*NEARLY[1], outputs=["contact_stress_max_MPa", "profile_radius_min_mm"])
    scene["cam"]["base_radius"] = base_radius
    ours = evaluate_changed(scene)
    left = ours["profile_radius_min_mm"]
    assert 0.0 < left < 1e-3
    assert ours["relative_half_width"] <= 3e-14 * 54.0 / left
    stress = float(slow(scene)["contact_stress_max_MPa"])
    assert ours["contact_stress_max_MPa"] == pytest.approx(stress, rel=ours["relative_half_width"])

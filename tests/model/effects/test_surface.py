"""Sliding, rolling, wear and film against the velocities of the bodies, and an eccentric circle in closed form."""

from itertools import product

import numpy as np
import pytest
from flint import arb, arb_series
from support.balls.ball import precisely

import camopt
from camopt.core.kernels.compile import compiled
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.jet import Jet
from camopt.model.mechanisms.geometry import cam_curves
from camopt.scene.problem.problem import resolve
from camopt.solve.verdicts.certify import certify

PUSHED = {"mass": 0.2, "spring_rate": 30.0, "preload": 300.0}
SWUNG = {"inertia": 1e-3, "spring_rate": 40.0, "preload": 20.0}
MOTION = [
    {"segment": "rise", "angle": 90.0, "lift": 6.0, "law": "modified-sine"},
    {"segment": "dwell", "angle": 20.0},
    {"segment": "return", "angle": 90.0, "lift": 6.0, "law": "cycloidal"},
    {"segment": "dwell", "angle": 160.0},
]
MATERIALS = {
    "cam": "steel", "follower": "grey-cast-iron", "face_width": 12.0, "wear_rate": 1e-10, "viscosity": 0.02,
    "pressure_viscosity": 18.0, "roughness": 0.3,
}  # fmt: skip
ARM = {"arm_length": 80.0, "centre_distance": 90.0}
FOLLOWERS = {
    "roller": {"motion": "translating", "contact": "roller", "roller_radius": 12.0, "offset": 3.0},
    "flat": {"motion": "translating", "contact": "flat"},
    "knife": {"motion": "translating", "contact": "knife", "offset": -3.0},
    "spherical": {"motion": "translating", "contact": "spherical", "face_radius": 100.0, "offset": 2.0},
    "swinging roller": {"motion": "oscillating", "contact": "roller", "roller_radius": 12.0, **ARM},
    "swinging knife": {"motion": "oscillating", "contact": "knife", **ARM},
    "swinging spherical": {"motion": "oscillating", "contact": "spherical", "face_radius": 25.0, **ARM},
    "swinging flat": {"motion": "oscillating", "contact": "flat", "face_offset": 5.0, "centre_distance": 90.0},
}


def scene_of(name, rotation="ccw", base_radius=30.0, **more):
    follower = FOLLOWERS[name]
    dynamics = SWUNG if follower["motion"] == "oscillating" else PUSHED
    return camopt.Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": base_radius, "rpm": 1500.0, "rotation": rotation},
            "follower": {**follower, "dynamics": dynamics},
            "motion": MOTION,
            "materials": MATERIALS,
            "outputs": ["surface"],
            **more,
        }
    )


def grid_extremes(scene):
    """Extremes of a grid from where the bodies are: mm, rad, N. The contact moves at (X(θ + h) − X(θ − h))/2h."""
    problem = resolve(scene)
    setup, programme, design = problem.setup, problem.programme, problem.design
    sense, bodies = design.sense, setup.bodies
    angles = np.linspace(0, 2 * np.pi, 14401)[:-1] + 1e-5
    step = 1e-5

    def contact(shift):
        points = cam_curves(setup.mechanism, design, programme, np.mod(angles + shift, 2 * np.pi)).profile[0]
        return points * np.exp(1j * sense * (angles + shift))

    here, normal = contact(0.0), cam_curves(setup.mechanism, design, programme, angles).normal
    normal = normal * np.exp(1j * sense * angles)
    moves = (contact(step) - contact(-step)) / (2 * step)
    y, y1, y2, _ = programme.motion_at(angles)
    # per unit of the follower's own motion, and per rad of the cam
    lever = -1j * (here - design.centre_distance) if setup.angular else np.full(here.shape, 1j)
    follower, cam = lever * y1, 1j * sense * here
    assert np.abs(((follower - cam) * np.conj(normal)).real).max() < 1e-6  # they neither part nor meet
    along = (moves - cam) / np.abs(moves - cam)
    over_cam, over_follower = (((moves - body) * np.conj(along)).real for body in (cam, follower))
    sliding = over_cam - over_follower
    d = setup.dynamics
    force = d.mass * setup.omega**2 * y2 + d.stiffness * y + d.preload
    force = force / (lever * np.conj(normal)).real
    turned = np.unwrap(np.angle(normal * np.exp(-1j * sense * angles)))
    bend = np.abs(np.gradient(turned, angles, edge_order=2)) / over_cam  # of the profile, convex here
    rolls = scene.follower.contact == "roller"
    radius = 1 / (bend + (1 / design.roller_radius[0] if rolls else 0.0))
    entrained = over_cam if rolls else 0.5 * (over_cam + over_follower)
    modulus, width = 2 * bodies.modulus, bodies.face_width
    u = np.abs(entrained) * setup.omega * 1e-3  # m/s; Dowson and Higginson in SI
    speed = MATERIALS["viscosity"] * u / (modulus * 1e6 * radius * 1e-3)
    load = force / (modulus * radius * width)
    film = 2.65 * radius * 1e3 * (18e-9 * modulus * 1e6) ** 0.54 * speed**0.7 * load**-0.13  # µm
    if entrained.min() < 0 < entrained.max():
        film = np.zeros(1)
    return {
        "sliding_speed_max_m_s": np.abs(sliding).max() * setup.omega / 1e3,
        "roller_speed_max_rpm": np.abs(sliding).max() / (design.roller_radius[0] or 1.0) * 1500.0,
        "entrainment_speed_max_m_s": entrained.max() * setup.omega / 1e3,
        "entrainment_speed_min_m_s": entrained.min() * setup.omega / 1e3,
        "wear_depth_max_um": 1e9 * 1e-10 * np.max(force / width * np.abs(sliding) / over_cam),
        "film_thickness_min_um": film.min(),
        "film_ratio_min": film.min() / 0.3,
    }


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("name", FOLLOWERS)
def test_against_the_velocities_of_the_bodies(name, rotation):
    scene = scene_of(name, rotation)
    found, expected = camopt.evaluate(scene), grid_extremes(scene)
    quantities = [n for n in expected if n in found]
    assert len(quantities) == {"roller": 5, "flat": 6, "knife": 4, "spherical": 3}[scene.follower.contact]
    for quantity in quantities:
        room = 1e-4 if quantity.startswith(("film", "wear")) else 2e-5
        assert found[quantity] == pytest.approx(expected[quantity], rel=room), quantity
    assert not np.isnan([v for v in found.values() if isinstance(v, float)]).any()


R, E = 25.0, 4.0
HALF = {"angle": 180.0, "lift": 2 * E, "law": "harmonic"}


def eccentric(**more):
    """A circle of radius R turning E off its centre under a flat face, y = E·(1 − cos θ), at a constant load."""
    scene = scene_of("flat", base_radius=R - E, motion=[{"segment": "rise", **HALF}, {"segment": "return", **HALF}])
    return scene.replace(**{"follower.dynamics": {"mass": 1e-9, "preload": 500.0}, **more})


def test_an_eccentric_circle_under_a_flat_face():
    """v = R_b + y, c = R, u = (R + E·cos θ)/2: least where the face is highest, where sliding is fastest."""
    found, problem = camopt.evaluate(eccentric()), resolve(eccentric())
    omega, modulus = 50 * np.pi, 2 * problem.setup.bodies.modulus * 1e6
    assert found["sliding_speed_max_m_s"] == pytest.approx((R + E) * omega / 1e3, rel=1e-12)
    assert found["entrainment_speed_max_m_s"] == pytest.approx((R + E) / 2 * omega / 1e3, rel=1e-12)
    assert found["entrainment_speed_min_m_s"] == pytest.approx((R - E) / 2 * omega / 1e3, rel=1e-12)
    assert found["wear_depth_max_um"] == pytest.approx(1e9 * 1e-10 * 500 / 12 * (R + E) / R, rel=1e-8)
    radius, u = R * 1e-3, (R - E) / 2 * omega / 1e3
    speed, load = 0.02 * u / (modulus * radius), 500 / (modulus * radius * 12e-3)
    film = 2.65 * radius * (18e-9 * modulus) ** 0.54 * speed**0.7 * load**-0.13 * 1e6
    assert found["film_thickness_min_um"] == pytest.approx(film, rel=1e-8)
    assert found["film_ratio_min"] == pytest.approx(film / 0.3, rel=1e-8)


@pytest.mark.parametrize(
    ("change", "quantity", "factor"),
    [
        ({"materials.wear_rate": 2e-10}, "wear_depth_max_um", 2.0),
        ({"materials.face_width": 24.0}, "wear_depth_max_um", 0.5),
        ({"materials.face_width": 24.0}, "film_thickness_min_um", 2**0.13),
        ({"materials.viscosity": 0.04}, "film_thickness_min_um", 2**0.7),
        ({"materials.pressure_viscosity": 36.0}, "film_thickness_min_um", 2**0.54),
        ({"materials.roughness": 0.6}, "film_ratio_min", 0.5),
        ({"materials.roughness": 0.6}, "film_thickness_min_um", 1.0),
    ],
)
def test_what_grows_with_what(change, quantity, factor):
    one, other = camopt.evaluate(eccentric()), camopt.evaluate(eccentric(**change))
    assert other[quantity] == pytest.approx(factor * one[quantity], rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "quantity", "side"),
    [
        ("wear", "wear_depth_max_um", 1),
        ("sliding_speed", "sliding_speed_max_m_s", 1),
        ("film_ratio", "film_ratio_min", -1),
    ],
)
def test_limits_are_decided_next_to_the_bound(key, quantity, side):
    scene = scene_of("flat")
    value = camopt.evaluate(scene)[quantity]
    for off in (1e-9, -1e-9):
        limited = scene.replace(**{f"limits.{key}": value * (1 + off)})
        held = side * off > 0
        assert camopt.evaluate(limited)["feasible"] is held
        assert certify(limited)[key] == ("held" if held else "broken")


@pytest.mark.long
def test_the_smallest_cam_with_a_film():
    """The film grows with the flat face's cam: the least cam is the one whose film is the bound."""
    bound = camopt.evaluate(scene_of("flat", base_radius=34.0))["film_ratio_min"]
    best = camopt.optimise(scene_of("flat", limits={"film_ratio": bound})).best
    assert best["base_radius_mm"] == pytest.approx(34.0, rel=1e-7)


def test_no_film_where_contact_is_lost_or_the_motion_has_corners():
    lost = scene_of("roller").replace(**{"follower.dynamics": {"mass": 2.0, "preload": 1.0}})
    assert camopt.evaluate(lost)["film_ratio_min"] == 0.0
    cornered = scene_of("flat", motion=[{**m, "law": "uniform"} if "law" in m else m for m in MOTION])
    found = camopt.evaluate(cornered)
    assert found["film_ratio_min"] == 0.0
    assert found["wear_depth_max_um"] == np.inf
    assert not np.isnan([v for v in found.values() if isinstance(v, float)]).any()


def test_what_is_missing_is_named():
    with pytest.raises(camopt.BadInput, match=r"needs materials\.wear_rate"):
        camopt.evaluate(scene_of("flat", materials={"face_width": 10.0}, limits={"wear": 1.0}))
    with pytest.raises(camopt.BadInput, match="this mechanism has no sliding_speed_max_m_s"):
        camopt.evaluate(scene_of("roller", limits={"sliding_speed": 1.0}))


@compiled
def to_power(a, exponent, found):
    z = Jet(a[0], a[1], a[2], a[3], a[4], a[5]) ** exponent
    found[0], found[1], found[2], found[3], found[4], found[5] = z.low, z.high, z.error, z.first, z.second, z.third


@pytest.mark.parametrize("exponent", [0.13, 0.7, -0.35, -0.43, 2.5])
@pytest.mark.parametrize("width", [1e-6, 1e-2, 0.5])
@precisely()
def test_powers_of_jets_hold_all_that_they_may(exponent, width):
    """At 200 bits at the corners of the operand; bounds are close where the stretch is short."""
    rng = np.random.default_rng(7)
    low = rng.uniform(0.3, 4.0)
    jet = np.array([low, low + width, 1e-15, *rng.uniform(0.1, 4, 3)])
    found = np.empty(6)
    to_power(jet, exponent, found)
    first, second, third = arb(jet[3]), arb(jet[4]) / 2, arb(jet[5]) / 6
    corners = [
        (arb_series([arb(v), i * first, j * second, k * third], prec=4).log() * arb(exponent)).exp()
        for v in np.linspace(jet[0], jet[1], 5)
        for i, j, k in product((-1, 1), repeat=3)
    ]  # fmt: skip
    values = [float(z[0]) for z in corners]
    assert found[0] <= min(values) * (1 + 1e-15)
    assert max(values) <= found[1] * (1 + 1e-15)
    for k, factor in ((1, 1), (2, 2), (3, 6)):
        worst = max(abs(float(z[k])) for z in corners) * factor
        assert worst * (1 - 1e-12) <= found[2 + k] <= worst * (1 + 30 * width / low)
    inner = Interval(np.array(jet[0]), np.array(jet[1]))
    power = np.power(inner, exponent)
    assert (power.low, power.high) == pytest.approx((min(values), max(values)), rel=1e-14)


@pytest.mark.parametrize("low", [-1.0, 0.0])
def test_a_power_of_what_may_be_zero_has_no_bounds(low):
    found = np.empty(6)
    to_power(np.array([low, 1.0, 0.0, 1.0, 1.0, 1.0]), 0.7, found)
    assert found[1] == np.inf
    assert not np.isfinite(found[2:]).any()


@pytest.mark.parametrize(("contact", "rpm"), [("roller", 200), ("roller", 2000), ("flat", 2000)])
def test_proofs_know_that_there_is_no_film_without_contact(contact, rpm):
    scene = scene_of(contact, limits={"film_ratio": 1e-6}).replace(**{"cam.rpm": rpm})
    found, proved = camopt.evaluate(scene), camopt.certify(scene)["film_ratio"]
    assert proved == ("held" if found["film_ratio_min"] >= 1e-6 else "broken")

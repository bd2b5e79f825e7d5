"""The shaft of a machine: sums against a million samples, closed forms, printed examples, and the motors."""

import itertools
from math import pi

import numpy as np
import pytest
from numpy.polynomial import Chebyshev
from support.depth import times

import camopt
from camopt.core.numerics.turn_curve import TURN, TurnCurve
from camopt.scene.machine import Machine
from camopt.solve.machine.shaft import Shaft
from camopt.solve.machine.stations import resolve_stations

STILL = TurnCurve.constant(0.0)


def curve_of(function, panels=16, degree=14) -> TurnCurve:
    """A smooth function of the angle as a curve, by Chebyshev interpolation on each panel."""
    ends = np.linspace(0.0, TURN, panels + 1)
    pieces = [
        Chebyshev.interpolate(function, degree, [a, b]).convert(kind=np.polynomial.Polynomial, domain=[a, b]).coef
        for a, b in itertools.pairwise(ends)
    ]
    return TurnCurve(ends, np.array([np.pad(each, (0, degree + 1 - len(each))) for each in pieces]).T)


def test_flywheel_of_an_engine_and_a_machine():
    """R. S. Khurmi and J. K. Gupta, Theory of Machines, ch. 16: 5000 + 600 sin 2θ against 5000 + 500 sin θ [N·m].

    500 kg at a radius of gyration of 0.4 m, 150 rev/min. Printed: 1204 N·m and 6.1 %.
    """
    shaft = Shaft(curve_of(lambda x: 600.0 * np.sin(2.0 * x) - 500.0 * np.sin(x)), 150.0, STILL)
    assert shaft.energy_fluctuation == pytest.approx(1204.0, abs=1.0)
    assert shaft.speed_fluctuation(500.0 * 0.4**2) == pytest.approx(0.061, abs=5e-4)


def test_flywheel_for_one_per_cent():
    """The same book: 20000 + 9500 sin 2θ − 5700 cos 2θ [N·m], 180 rev/min, 1 %. Printed: 377 kW, 3121 kg·m²."""
    shaft = Shaft(curve_of(lambda x: 2e4 + 9500.0 * np.sin(2.0 * x) - 5700.0 * np.cos(2.0 * x)), 180.0, STILL)
    assert shaft.mean_power == pytest.approx(377e3, rel=1e-3)
    assert shaft.energy_fluctuation == pytest.approx(np.hypot(9500.0, 5700.0), rel=1e-9)  # half a wave of sin 2θ
    assert shaft.flywheel_inertia(0.01) == pytest.approx(3121.0, rel=2e-3)


def random_machine(rng: np.random.Generator) -> Machine:
    """Stations of one kind of follower with random masses, springs, moves, phases and ratios."""
    stations = []
    for number in range(int(rng.integers(1, 5))):
        angles = rng.dirichlet([2.0] * 4) * 300.0 + 15.0
        lift = rng.uniform(5.0, 40.0)
        motion = [
            {"segment": "rise", "lift": lift, "law": str(rng.choice(["cycloidal", "harmonic", "poly345"]))},
            {"segment": "dwell"},
            {"segment": "return", "lift": lift, "law": str(rng.choice(["modified-sine", "parabolic"]))},
            {"segment": "dwell"},
        ]
        dynamics = {
            "mass": rng.uniform(0.1, 3.0),
            "spring_rate": rng.uniform(0.0, 9.0),
            "preload": rng.uniform(0.0, 99.0),
            "damping": rng.choice([0.0, 0.02]),
        }
        scene = {
            "cam": {"form": "disc", "base_radius": 60},
            "follower": {"motion": "translating", "contact": "knife", "dynamics": dynamics},
            "motion": [row | {"angle": angle} for row, angle in zip(motion, angles, strict=True)],
        }
        place = {"phase": rng.uniform(-400.0, 400.0), "ratio": int(rng.integers(1, 4))}
        stations.append({"name": f"s{number}", "scene": scene} | place)
    return Machine(rpm=rng.uniform(20.0, 300.0), station=stations)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("seed", range(times(3, deep=6)))
def test_sums_agree_with_a_million_samples(seed):
    rng = np.random.default_rng(seed)
    machine = random_machine(rng)
    found = camopt.evaluate_machine(machine).shaft
    count = 1_000_000
    angles, total, kinetic = (np.arange(count) + 0.5) * TURN / count, np.zeros(count), np.zeros(count)
    for station in resolve_stations(machine):
        turns, dynamics = station.station.ratio, station.scene.follower.dynamics
        own = np.mod(turns * (angles - np.radians(station.station.phase)), TURN)
        y, y1, y2 = station.problem.programme.motion_at(own, 2)
        omega = machine.rpm * turns * pi / 30.0
        mass = 1e-3 * dynamics.mass  # in t, for N and mm
        force = mass * omega**2 * y2 + (dynamics.damping or 0.0) * omega * y1 + dynamics.spring_rate * y
        total += 1e-3 * turns * (force + dynamics.preload) * y1
        kinetic += turns**2 * dynamics.mass * (1e-3 * y1) ** 2
    work = np.cumsum(total - total.mean()) * TURN / count
    close = {"rel": 1e-4, "abs": 1e-4}
    assert found.largest.value == pytest.approx(total.max(), **close)
    assert found.least.value == pytest.approx(total.min(), **close)
    assert found.mean == pytest.approx(total.mean(), **close)
    assert found.rms == pytest.approx(np.sqrt(np.mean(total**2)), **close)
    assert found.energy_fluctuation == pytest.approx(work.max() - work.min(), **close)
    assert found.inertia.largest().value == pytest.approx(kinetic.max(), **close)
    assert found.inertia.mean == pytest.approx(kinetic.mean(), **close)
    assert found.largest.value >= total.max() - 1e-9
    assert found.least.value <= total.min() + 1e-9


CATALOGUE = """name,rated_torque_N_m,peak_torque_N_m,rated_speed_rpm,inertia_kg_m2
large,9,30,3000,1
small,{rms},{peak},{speed},{inertia}
"""


@pytest.mark.parametrize("lacking", ["", "rms", "peak", "speed", "inertia"])
def test_the_smallest_motor_that_fits_is_chosen(tmp_path, lacking):
    machine = camopt.find_machine("pick-and-place")
    tables = machine.to_dict()
    del tables["clear"], tables["motor"]  # clearances take most of the time
    tables["station"] = [row | {"scene": machine.scenes[row["name"]].to_dict()} for row in tables["station"]]
    gear, ratio, shaft = 5.0, 20.0, camopt.evaluate_machine(Machine.from_dict(tables)).shaft
    needed = {
        "rms": shaft.rms / gear,
        "peak": shaft.peak / gear,
        "speed": shaft.rpm * gear,
        "inertia": (shaft.inertia.mean + shaft.flywheel_inertia(0.3)) / gear**2 / ratio,
    }
    data = {name: value * (1.0 - 1e-6 if name == lacking else 1.0 + 1e-6) for name, value in needed.items()}
    catalogue = tmp_path / "motors.csv"
    catalogue.write_text(CATALOGUE.format(**data))
    tables["motor"] = {"catalogue": str(catalogue), "gear": gear, "inertia_ratio": ratio}
    found = camopt.evaluate_machine(Machine.from_dict(tables)).to_dict()["motors"]
    assert [row["name"] for row in found if row["smallest"]] == ["large" if lacking else "small"]

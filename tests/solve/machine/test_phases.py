"""Phases of least peak torque against a dense scan of all phases."""

import numpy as np
import pytest
from support.machines import LAWS, random_moves

from camopt.core.numerics.turn_curve import sum_curves
from camopt.scene.machine import Machine
from camopt.solve.machine.clearances import clearances_of_machine
from camopt.solve.machine.phases import least_torque_phases
from camopt.solve.machine.stations import resolve_stations

ANGLES = np.radians(np.arange(0.0, 360.0, 0.5))


def loaded_scene(moves):
    """A translating roller follower with a mass and a spring."""
    return {
        "cam": {"form": "disc", "base_radius": 45.0},
        "follower": {
            "motion": "translating",
            "contact": "roller",
            "roller_radius": 8.0,
            "dynamics": {"mass": 2.0, "spring_rate": 5.0, "preload": 100.0},
        },
        "motion": moves,
    }


def three_stations(seed, ranges, clear=(), laws=LAWS[:4]):
    """A machine with three cams, of which some phases are free."""
    rng = np.random.default_rng(seed)
    stations = [
        {
            "name": name,
            "scene": loaded_scene(random_moves(rng, float(rng.uniform(5.0, 15.0)), laws)),
            "phase": phase,
        }
        for name, phase in (("a", 0.0), ("b", 20.0), ("c", 60.0))
    ]
    tables = {"rpm": 120.0, "station": stations, "search": {"phase": ranges}, "clear": [*clear]}
    return Machine.from_dict(tables)


def scanned_peaks(stations, phases):
    """Peaks of the torque at dense angles for phases b and c [deg], a row for each b."""
    a, b, c = (station.torque_at_phase(0.0) for station in stations)
    shifted = [np.array([each.value(ANGLES - np.radians(phase)) for phase in phases]) for each in (b, c)]
    return np.array([np.abs(a.value(ANGLES) + one + shifted[1]).max(axis=1) for one in shifted[0]])


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("seed", range(3))
def test_least_peak_of_three_stations_is_that_of_a_dense_scan(seed):
    machine = three_stations(seed, {"b": [0, 360], "c": [0, 360]})
    stations = resolve_stations(machine)
    found = least_torque_phases(machine, stations)
    scanned = scanned_peaks(stations, np.arange(0.0, 360.0, 3.0))
    assert found.bound <= found.peak <= scanned.min() * (1.0 + 1e-3)
    assert found.relative_gap <= 1e-4
    total = sum(each.torque_at_phase(found.phases.get(each.name, 0.0)).value(ANGLES) for each in stations)
    assert found.peak * (1.0 - 1e-3) <= np.abs(total).max() <= found.peak
    before = sum(each.torque.value(ANGLES) for each in stations)
    assert np.abs(before).max() == pytest.approx(found.peak_before, rel=1e-3)
    assert found.peak < found.peak_before


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("seed", [0, 2])
def test_bounds_hold_where_torques_jump(seed):
    """Laws of constant acceleration; the peaks at scanned phases, and at phases near the best, are exact."""
    laws = ("constant-acceleration", "harmonic", "modified-trapezoid")
    machine = three_stations(seed, {"b": [0, 360], "c": [0, 360]}, laws=laws)
    stations, rng = resolve_stations(machine), np.random.default_rng(seed)
    found = least_torque_phases(machine, stations)
    best = np.array([found.phases["b"], found.phases["c"]])
    for phases in (*rng.uniform(0.0, 360.0, (40, 2)), *best + rng.normal(size=(30, 2)) * 0.3, best):
        shifted = [each.torque_at_phase(p) for each, p in zip(stations, [0.0, *phases], strict=True)]
        total = sum_curves(shifted)
        assert found.bound <= max(total.largest().value, -total.least().value) + 1e-12
    assert found.relative_gap <= 1e-4


@pytest.mark.long
def test_found_phases_hold_the_clearances_and_no_scanned_ones_are_better():
    """The clearance is 1 mm more than the best phases have without it."""
    ranges = {"b": [0, 360], "c": [-180, 180]}
    stations = resolve_stations(three_stations(1, ranges))
    free = least_torque_phases(three_stations(1, ranges), stations)
    a, b = (station.lift_at_phase(0.0) for station in stations[:2])
    angles = np.radians(np.linspace(90.0, 270.0, 721))

    def least_difference(phase):
        return (a.value(angles) - b.value(angles - np.radians(phase))).min()

    at_least = float(least_difference(free.phases["b"])) + 1.0
    clear = {"between": ["a", "b"], "along": [1, -1], "at_least": at_least, "angles": [90, 270]}
    machine = three_stations(1, ranges, [clear])
    found = least_torque_phases(machine, resolve_stations(machine))
    assert found.peak > 1.01 * free.peak
    tables = machine.to_dict()
    for station in tables["station"]:
        station["phase"] = found.phases.get(station["name"], 0.0)
    moved = Machine.from_dict(tables)
    (clearance,) = clearances_of_machine(moved, resolve_stations(moved))
    assert clearance.verdict == "held"
    phases = np.arange(0.0, 360.0, 3.0)
    held = [least_difference(phase) >= at_least for phase in phases]
    scanned = scanned_peaks(stations, phases)[held]
    assert 0 < sum(held) < len(held)
    assert found.bound <= scanned.min()
    assert found.peak <= scanned.min() * (1.0 + 1e-3)
    assert found.relative_gap <= 1e-4


def test_phases_that_no_clearance_allows():
    clear = {"between": ["a", "b"], "along": [1, 1], "at_least": 100.0}
    machine = three_stations(2, {"b": [0, 360]}, [clear])
    found = least_torque_phases(machine, resolve_stations(machine))
    assert (found.phases, found.peak, found.bound, found.relative_gap) == (None, np.inf, np.inf, 0.0)


def test_no_search_or_no_torque_gives_no_optimum():
    machine = three_stations(2, {})
    assert least_torque_phases(machine, resolve_stations(machine)) is None
    tables = three_stations(2, {"b": [0, 360]}).to_dict()
    for station in tables["station"]:
        del station["scene"]["follower"]["dynamics"]
    machine = Machine.from_dict(tables)
    assert least_torque_phases(machine, resolve_stations(machine)) is None


def test_opposed_sines():
    """With a spring rate of mω² and harmonic moves of half a turn the force is even, and the torque a sine.

    A force of half the stroke times the rate acts on a slope of half the stroke. So two cams with strokes of 10 and
    5 mm have least torque half a turn apart, the difference of their peaks.
    """
    rate, tables = 3.0 * (2.0 * np.pi * 5.0) ** 2 * 1e-3, []
    for name, lift in (("a", 10.0), ("b", 5.0)):
        moves = [{"segment": move, "angle": 180, "lift": lift, "law": "harmonic"} for move in ("rise", "return")]
        scene = loaded_scene(moves)
        scene["follower"]["dynamics"] = {"mass": 3.0, "spring_rate": rate, "preload": 0.0}
        tables.append({"name": name, "scene": scene, "phase": 30.0})
    machine = Machine.from_dict({"rpm": 300.0, "station": tables, "search": {"phase": {"b": [0, 360]}}})
    found = least_torque_phases(machine, resolve_stations(machine))
    one = 1e-3 * rate * 25.0
    assert found.peak_before == pytest.approx(1.25 * one, rel=1e-9)
    assert found.peak == pytest.approx(0.75 * one, rel=1e-4)
    assert 0.75 * one * (1.0 - 2e-4) <= found.bound <= 0.75 * one * (1.0 + 1e-12)
    assert found.phases["b"] == pytest.approx(210.0, abs=3.0)


def test_a_shift_of_all_phases_changes_nothing():
    """Two phases free of two are as good as one, and as quick."""
    tables = three_stations(2, {}).to_dict()
    tables["station"] = tables["station"][:2]
    found, other = (
        least_torque_phases(machine, resolve_stations(machine))
        for ranges in ({"b": [0, 360]}, {"a": [0, 360], "b": [0, 360]})
        for machine in [Machine.from_dict({**tables, "search": {"phase": ranges}})]
    )
    assert found.peak == pytest.approx(other.peak, rel=1e-4)
    assert other.phases["a"] == 0.0
    assert other.relative_gap <= 1e-4

"""Stations of a machine: the curves of lift and torque against those of their scenes."""

import numpy as np
import pytest
from support.machines import KNIFE

import camopt
from camopt.core.numerics.turn_curve import TURN
from camopt.scene.machine import Machine
from camopt.show.machines.timing_spans import TimingData
from camopt.solve.machine.stations import resolve_stations


def scenes_with_torque():
    """Shipped scenes with a torque that is finite."""
    for name in camopt.shipped_scenes():
        scene = camopt.find_scene(name)
        with_torque = scene.replace(outputs=["torque"])
        try:
            found = camopt.evaluate(with_torque)
        except camopt.BadInput:
            continue
        if np.isfinite(found.get("torque_peak_N_m", np.inf)):
            yield pytest.param(with_torque, id=name)


@pytest.mark.parametrize("scene", [*scenes_with_torque()])
def test_torque_of_a_station_is_that_of_its_scene(scene):
    phase, ratio = 77.7, 3
    machine = Machine(station=[{"name": "a", "scene": scene.to_dict(), "phase": phase, "ratio": ratio}])
    (station,) = resolve_stations(machine)
    found, torque = camopt.evaluate(scene), station.torque
    assert machine.shaft_rpm == pytest.approx(scene.cam.rpm / ratio)
    close = {"rel": 1e-9, "abs": 1e-9}
    assert torque.largest().value == pytest.approx(ratio * found["torque_max_N_m"], **close)
    assert torque.least().value == pytest.approx(ratio * found["torque_min_N_m"], **close)
    assert torque.rms == pytest.approx(ratio * found["torque_rms_N_m"], **close)
    assert torque.mean == pytest.approx(ratio * found["torque_mean_N_m"], **close)


@pytest.mark.parametrize("name", ["two-pauses", "oscillating-roller", "bucket-valve", "slide-by-bell-crank"])
def test_lift_of_a_station_is_that_of_its_tool(name):
    scene, rng = camopt.find_scene(name), np.random.default_rng(5)
    phase, ratio = rng.uniform(-400.0, 400.0), int(rng.integers(1, 4))
    machine = Machine(station=[{"name": "a", "scene": name, "phase": phase, "ratio": ratio}])
    (station,) = resolve_stations(machine)
    angles = rng.uniform(0.0, TURN, 1000)
    programme = station.problem.programme.tool
    own = (
        programme.motion_at(np.mod(ratio * (angles - np.radians(phase)), TURN), 0)[0] / programme.unit_in_mm_or_rad
    )
    assert np.abs(station.lift.value(angles) - own).max() < 1e-9
    assert station.unit == ("deg" if scene.tool_turns else "mm")


@pytest.mark.parametrize("name", ["clamp-by-wedge", "pusher-by-lever", "press-feed-by-pair", "three-arc-valve"])
def test_the_inertia_of_the_masses_is_what_the_speed_adds_to_the_torque(name):
    """T(2ω) − T(ω) = 3·ω²·(dI/dθ)/2 for scenes without damping."""
    ratio, scene = 2, camopt.find_scene(name)
    rows = [{"name": "a", "scene": name, "ratio": ratio, "phase": 33.0}]
    slow, fast = (resolve_stations(Machine(rpm=rpm, station=rows))[0] for rpm in (60.0, 120.0))
    assert not scene.follower.dynamics.damping
    angles = np.random.default_rng(1).uniform(0.0, TURN, 500)
    change = fast.torque.value(angles) - slow.torque.value(angles)
    expected = 3.0 * TURN**2 * slow.reflected_inertia.derivative.value(angles) / 2.0
    assert np.abs(change - expected).max() <= 1e-8 * np.abs(change).max()
    assert abs(slow.reflected_inertia.least().value) <= 1e-12 * slow.reflected_inertia.largest().value


def test_a_station_with_an_infinite_torque_is_left_out_of_the_sum():
    cornered = {
        **KNIFE,
        "follower": {**KNIFE["follower"], "dynamics": {"mass": 1.0, "preload": 9.0}},
        "motion": [{**row, "law": "uniform"} if "law" in row else row for row in KNIFE["motion"]],
    }
    rows = [{"name": "a", "scene": cornered}, {"name": "b", "scene": "pusher-by-lever"}]
    both, alone = (camopt.evaluate_machine(Machine(rpm=60.0, station=rows[first:])) for first in (0, 1))
    assert both.shaft.peak == alone.shaft.peak
    assert [note for note in both.notes if note.startswith("a has no torque: it is infinite")]


def test_lifts_of_different_units_have_none_together_in_the_table_and_on_the_sheet():
    rows = [{"name": "a", "scene": "two-pauses"}, {"name": "b", "scene": "oscillating-roller"}]
    machine = Machine(station=rows, clear=[{"between": ["a", "b"], "along": [-1, -1], "at_least": -80}])
    found = camopt.evaluate_machine(machine)
    assert [row[4].text for row in found.clearance_table().rows] == ["-80"]
    assert "≥ −80, least" in TimingData.from_machine(found).clearances[0][1].words
    assert [note for note in found.notes if "mm and in deg" in note]

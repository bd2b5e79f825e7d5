"""Clearances of random machines against dense samples by shapely, and against closed forms."""

import numpy as np
import pytest
from support.depth import times
from support.machines import (
    machine_with_circles_on_lines,
    random_linear_machine,
    random_machine,
    shapely_distances,
    sliding_scene,
    turning_scene,
    with_required,
)

from camopt.core.numerics.budget import Budget
from camopt.core.numerics.turn_curve import sum_curves
from camopt.scene.machine import Machine, find_machine
from camopt.scene.sources import shipped_machines
from camopt.solve.machine.clearances import (
    LEAST_WORK,
    clearance_form,
    clearances_of_machine,
    held_and_violating_shifts,
)
from camopt.solve.machine.stations import resolve_stations

TIES = np.array([1.0 - 1e-9, 1.0 + 1e-9])


def clearances(machine):
    """The results of all clearances of a machine."""
    return clearances_of_machine(machine, resolve_stations(machine))


def distances(machine, stations, angles, shift=0.0, shifted=""):
    """Distances of the two outlines of a machine by shapely at angles [deg], with one phase shifted [deg]."""
    curves = {each.name: each.lift for each in stations}
    tables = {each.name: each for each in (*machine.station, *machine.body)}
    lifts = [
        curves[name].value(np.radians(angles - shift * (name == shifted))) if name in curves else 0.0 * angles
        for name in ("a", "b")
    ]
    return shapely_distances(tables["a"], tables["b"], *lifts)


def least_by_zooming(machine, stations, shift, shifted):
    """The least sample of the distances with one phase shifted, by samples that get denser about the least."""
    least, (start, end) = np.inf, machine.clear[0].angles
    for _ in range(7):
        angles = np.linspace(start, end, 400)
        values = distances(machine, stations, angles, shift, shifted)
        here, step = angles[np.argmin(values)], angles[1] - angles[0]
        least = min(least, values.min())
        start, end = max(start, here - 3.0 * step), min(end, here + 3.0 * step)
    return least


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("seed", range(times(2, deep=5)))
def test_least_distances_of_random_machines_are_enclosed(seed):
    rng = np.random.default_rng(seed)
    for _ in range(40):
        machine = random_machine(rng)
        stations = resolve_stations(machine)
        found = clearance_form(machine, stations, machine.clear[0]).enclose_least_clearance(Budget(LEAST_WORK))
        samples = distances(machine, stations, np.linspace(*machine.clear[0].angles, 500))
        (attained,) = distances(machine, stations, np.degrees([found.angle]))
        assert found.lower <= samples.min() + 1e-10
        assert attained == pytest.approx(found.upper, abs=1e-9)
        assert found.upper - found.lower <= 1e-9 * max(found.upper, 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(times(2, deep=3)))
def test_slacks_of_outlines_are_held_up_to_their_end_and_broken_there(seed):
    rng, ends = np.random.default_rng(seed), 0
    for _ in range(9):
        machine = with_required(random_machine(rng, widest=100.0), 1e-3)
        (found,) = clearances(machine)
        if found.lower < 0.1:
            continue
        machine = with_required(machine, found.lower * rng.uniform(0.9, 0.999))
        stations, required = resolve_stations(machine), machine.clear[0].at_least
        (found,) = clearances_of_machine(machine, stations)
        assert found.verdict == "held"
        for slack in found.slacks:
            for sign, (proved, broken) in ((-1.0, slack.earlier), (1.0, slack.later)):
                for shift in sign * proved * np.array([*rng.uniform(0.0, 1.0, 3), TIES[0]]):
                    angles = np.linspace(*machine.clear[0].angles, 200)
                    assert distances(machine, stations, angles, shift, slack.station).min() >= required - 1e-10
                if broken < np.inf:
                    shift, ends = sign * broken * TIES[1], ends + 1
                    assert least_by_zooming(machine, stations, shift, slack.station) < required + 1e-10
                    assert broken - proved <= 1e-6 * broken
                else:
                    assert proved == 180.0
    assert ends > 3


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(times(2, deep=4)))
def test_linear_forms_and_their_slacks_agree_with_exact_extremes(seed):
    rng, ends = np.random.default_rng(seed), 0
    for _ in range(7):
        machine = random_linear_machine(rng)
        (found,) = clearances(machine)
        machine = with_required(machine, found.lower - rng.uniform(0.01, 5.0))
        stations, (clearance,) = resolve_stations(machine), machine.clear
        (found,) = clearances_of_machine(machine, stations)
        curves = {each.name: each.lift for each in stations}
        start, end = np.radians(clearance.angles)

        def form(shift, station, curves=curves, clearance=clearance):
            return sum_curves(
                [
                    curves[name].shifted(np.radians(shift) if name == station else 0.0) * weight
                    for name, weight in zip(clearance.between, clearance.along, strict=True)
                ]
            )

        samples = form(0.0, "").value(np.linspace(start, end, 20_000))
        assert found.lower - 1e-10 <= samples.min() <= found.upper + 1e-3
        assert form(0.0, "").value(np.radians(found.angle)) == pytest.approx(found.upper, abs=1e-9)
        assert (found.verdict, found.upper - found.lower < 1e-9) == ("held", True)
        for slack in found.slacks:
            for sign, (proved, broken) in ((-1.0, slack.earlier), (1.0, slack.later)):
                for shift in sign * proved * np.array([*rng.uniform(0.0, 1.0, 2), TIES[0]]):
                    least = form(shift, slack.station).least(start, end - start)
                    assert least.value >= clearance.at_least - least.room
                if broken < np.inf:
                    ends += 1
                    least = form(sign * broken * TIES[1], slack.station).least(start, end - start)
                    assert least.value < clearance.at_least + least.room
                    assert broken - proved <= 1e-9 * broken
                else:
                    assert proved == 180.0
    assert ends > 4


MOVES = [
    {"segment": "rise", "angle": 100, "lift": 20, "law": "constant-velocity"},
    {"segment": "return", "angle": 100, "lift": 20, "law": "constant-velocity"},
    {"segment": "dwell", "angle": 160},
]


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("beyond", [-1e-3, -1e-6, -1e-9, 0.0, 1e-9, 1e-6, 1e-3])
def test_a_minimum_just_inside_the_end_of_a_segment_is_found(beyond):
    """A point goes at an even speed towards another and returns; the range of angles ends about the turning."""
    station = {"name": "a", "scene": sliding_scene(MOVES), "phase": 30, "direction": 0, "outline": [[0, 0]]}
    machine = Machine.from_dict(
        {
            "station": [station],
            "body": [{"name": "b", "outline": [[25, 0]]}],
            "clear": [
                {"between": ["a", "b"], "at_least": 5.0, "angles": [40, 130 + beyond]},
                {"between": ["a"], "along": [-1], "at_least": -20.0, "angles": [40, 130 + beyond]},
            ],
        }
    )
    outlines, linear = clearances(machine)
    true = 5.0 + 20.0 * max(-beyond, 0.0) / 100.0
    for found, least in ((outlines, true), (linear, true - 25.0)):
        assert found.lower - 1e-12 <= least <= found.upper + 1e-12
        assert found.upper - found.lower < 5e-9
        assert found.angle == pytest.approx(130.0 + min(beyond, 0.0), abs=1e-6)
    if beyond == -1e-3:  # later by any shift; earlier, the end of the range is the turning
        (slack,) = outlines.slacks
        assert (outlines.verdict, slack.later[0]) == ("held", 180.0)


def test_circles_on_parallel_lines():
    """Two circles pass each other, at the least distance where their lifts are equal."""
    machine, apart, radii = machine_with_circles_on_lines(gap=30.0, first_radius=7.0, second_radius=4.0)
    (found,) = clearances(machine)
    assert found.lower <= apart - radii <= found.upper
    assert found.upper - found.lower <= 1e-9 * apart
    (far,) = clearances(
        machine.from_dict({**machine.to_dict(), "clear": [{"between": ["a", "b"], "angles": [0, 40]}]})
    )
    lifts = [each.lift.value(np.radians(np.linspace(0.0, 40.0, 40_001))) for each in resolve_stations(machine)]
    samples = np.hypot(apart, lifts[0] - lifts[1]) - radii
    assert far.lower <= samples.min() <= far.upper + 1e-6


@pytest.mark.parametrize("sense", ["ccw", "cw"])
def test_a_point_on_an_arc(sense):
    """A point turns about a pivot by 20 deg past a fixed circle, or less far than it."""
    turn = 1.0 if sense == "ccw" else -1.0
    for at in (5.0, 12.3, 20.0, 31.0):
        centre = 90.0 * np.exp(1j * turn * np.radians(at))
        station = {
            "name": "a",
            "scene": turning_scene(MOVES),
            "pivot": [0, 0],
            "outline": [[60, 0]],
            "sense": sense,
        }
        body = {"name": "b", "outline": [[centre.real, centre.imag]], "outline_radius": 6.0}
        clear = {"between": ["a", "b"], "at_least": 3.0}
        (found,) = clearances(Machine.from_dict({"station": [station], "body": [body], "clear": [clear]}))
        nearest = 60.0 * np.exp(1j * turn * np.radians(min(at, 20.0)))
        assert found.lower - 1e-12 <= abs(nearest - centre) - 6.0 <= found.upper + 1e-12
        assert found.upper - found.lower <= 1e-9 * found.upper
        assert found.slacks[0].earlier[0] == found.slacks[0].later[0] == 180.0


def test_outlines_that_overlap_touch_or_hold_each_other_are_broken():
    ring = [[-50, -50], [50, -50], [50, 50], [-50, 50]]
    for outline, radius in (
        ([[0, 0]], 1.0),
        ([[45, 0]], 0.0),
        ([[60, 0]], 10.0),
        ([[20, 0], [80, 10]], 0.0),
        (ring, 0.0),
    ):
        station = {"name": "a", "scene": sliding_scene(MOVES), "direction": 90, "outline": outline}
        tables = {
            "station": [{**station, "outline_radius": radius}],
            "body": [{"name": "b", "outline": ring}],
            "clear": [{"between": ["a", "b"]}],
        }
        (found,) = clearances(Machine.from_dict(tables))
        assert (found.lower, found.verdict) == (0.0, "broken")
        assert found.upper < 1e-9
        assert found.slacks[0].earlier == found.slacks[0].later == (0.0, 0.0)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("work", [1, 300, 3000])
def test_searches_that_end_early_are_honest(work):
    rng = np.random.default_rng(3)
    for _ in range(5):
        machine = with_required(random_machine(rng, widest=100.0), 1e-3)
        (whole,) = clearances(machine)
        machine = with_required(machine, max(0.95 * whole.lower, 1e-3))
        stations, (whole,) = resolve_stations(machine), clearances(machine)
        form = clearance_form(machine, stations, machine.clear[0])
        least = form.enclose_least_clearance(Budget(work))
        assert least.lower <= whole.upper
        assert least.upper >= whole.lower
        if whole.verdict == "held":
            (early, late) = np.degrees(
                held_and_violating_shifts(form, np.array([[-1.0, 0.0], [1.0, 0.0]]), Budget(work))
            )
            for (proved, broken), pair in ((early, whole.slacks[0].earlier), (late, whole.slacks[0].later)):
                assert proved <= pair[1]
                assert broken >= pair[0]


def test_fixed_bodies_and_angles_many_turns_away():
    """The distance of two fixed bodies; the angles of a clearance count modulo a turn."""
    station = {"name": "a", "scene": sliding_scene(MOVES), "direction": 0, "outline": [[0, 0]], "phase": -3600.0}
    bodies = [{"name": name, "outline": [[x, 0]], "outline_radius": 2.0} for name, x in (("b", 40), ("c", 90))]
    near, far = ({"between": ["a", "b"], "angles": [50 + turn, 90 + turn]} for turn in (0, 360 * 5000))
    tables = {"station": [station], "body": bodies, "clear": [{"between": ["b", "c"]}, near, far]}
    fixed, one, other = clearances(Machine.from_dict(tables))
    assert (fixed.lower, fixed.upper) == pytest.approx((46.0, 46.0), abs=1e-11)
    assert fixed.slacks == ()
    assert one.upper == pytest.approx(40.0 - 2.0 - 18.0, abs=1e-9)
    assert (one.lower, one.upper) == pytest.approx((other.lower, other.upper), abs=1e-9)
    assert one.angle == pytest.approx(90.0)


@pytest.mark.parametrize("name", shipped_machines())
def test_slacks_of_shipped_machines_are_closed(name):
    """A tool at rest breaks a clearance by a constant value: only halves of the shift end such a box."""
    machine = find_machine(name)
    slacks = [slack for each in clearances_of_machine(machine, resolve_stations(machine)) for slack in each.slacks]
    for proved, broken in (end for slack in slacks for end in (slack.earlier, slack.later)):
        assert proved == 180.0 or 0.0 < broken - proved < 1e-6 * broken

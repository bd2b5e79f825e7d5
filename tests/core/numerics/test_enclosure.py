"""Ranges with slopes, and what they say of boxes of designs, against values, differences and feasible designs."""

from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support.cams import CONTACTS, GUIDED, WORN, cam_with
from support.depth import is_deep, times

from camopt import Scene, evaluate
from camopt.core.numerics.curves import value_and_slope
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.sloped_interval import PARTIALS, Quotient, as_quotient, as_sloped_interval, box_variables
from camopt.core.quantities import QUANTITIES
from camopt.model.mechanisms import Designs
from camopt.scene.problem.limits import LOAD_LIMITS
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.solve.smallest.boxes import DesignBoxes
from camopt.solve.smallest.enclosure import enclose_limits, size_constraints_with_error_variants
from camopt.solve.verdicts.feasible_filter import feasible_designs

FREE = {
    "translating": ("size", "offset", "roller_radius"),
    "oscillating": ("size", "arm_length", "centre_distance", "face_offset", "roller_radius"),
}


KEYS = [*LOAD_LIMITS, "pressure_angle", "curvature_radius"]
BOXES = times(4, deep=12)
COARSE, FINE = (np.radians(np.arange(0.0, 360.0, step)) for step in (3.0, 0.25))


def scene_of(contact, limits=None):
    """A scene in which every limit can be asked: friction in the guide, bodies that wear."""
    dynamics = None if CONTACTS[contact]["motion"] == "oscillating" else GUIDED
    return Scene.from_dict(cam_with(contact, "poly345", dynamics, materials=WORN, limits=limits or {}))


@cache
def limits_of(name):
    """What the cam has, a little eased or tightened: every limit of the registry that it can be asked."""
    cam, rng, limits = evaluate(scene_of(name)), np.random.default_rng(7), {}
    for key, quantity in LOAD_LIMITS.items():
        if quantity in cam and np.isfinite(cam[quantity]) and cam[quantity] > 0.0:
            limits[key] = float(cam[quantity] * (1.0 + QUANTITIES[quantity].limit_sign * rng.uniform(0.0, 0.02)))
    if "jamming_margin" in limits:
        limits["jamming_margin"] = min(limits["jamming_margin"], 0.99)
    limits["pressure_angle"] = min(80.0, 1.01 * cam["pressure_angle_max_deg"]) or 45.0
    limits["curvature_radius"] = 0.99 * cam["profile_radius_min_mm"]
    return limits


@cache
def limited_problem(name):
    """The question with all limits."""
    return with_rounding_relative_error(resolve(scene_of(name, limits_of(name))))


@cache
def problem_with_some_limits(name):
    """The question with every fourth limit, each mechanism with others; with all of them in ``.ci/deep``.

    A search for the worst cam angle is compiled for each limit and mechanism, or takes as long.
    """
    first = list(CONTACTS).index(name)
    limits = {
        key: bound for key, bound in limits_of(name).items() if is_deep() or (KEYS.index(key) + first) % 4 == 0
    }
    return with_rounding_relative_error(resolve(scene_of(name, limits)))


def free_of(problem):
    """The sizes that the mechanism has, of those that may be free."""
    moving = FREE["oscillating" if problem.setup.angular else "translating"]
    return [n for n in moving if n == "size" or problem.design.sizes[n][0] != 0.0]


def random_boxes(problem, rng, count, wide, away=None):
    """Boxes (low, high) and their free sizes, each a share ``wide`` of the question's design at most.

    Their middles are up to a share ``away`` of it away from it; as far as they are wide if not given.
    """
    away = wide if away is None else away
    design, free = problem.design.sizes, free_of(problem)
    low = {n: np.full(count, v[0]) for n, v in design.items()}
    high = {n: v.copy() for n, v in low.items()}
    for name in free:
        middle = low[name] * (1.0 + away * rng.uniform(-1.0, 1.0, count))
        half = 0.5 * wide * rng.uniform(0.0, 1.0, count) * np.abs(low[name])
        low[name], high[name] = middle - half, middle + half
    return low, high, free


def designs_inside(low, high, rng, sense, count=60):
    """Random designs of each box, one box after the other."""
    boxes = len(low["size"])
    share = {n: rng.uniform(0.0, 1.0, (boxes, count)) for n in low}
    drawn = {n: low[n][:, None] + share[n] * (high[n] - low[n])[:, None] for n in low}
    return Designs(**{n: values.ravel() for n, values in drawn.items()}, sense=sense)


ARGUMENTS = {np.arcsin: (-0.9, 0.9), np.sqrt: (0.1, 4.0), np.arctan2: (0.1, 3.0), np.power: (0.2, 3.0)}


@pytest.mark.one_in(5)
@pytest.mark.parametrize("operation", PARTIALS, ids=lambda operation: operation.__name__)
@given(seed=st.integers(0, 10**6))
@settings(max_examples=times(15, deep=1000))
def test_values_and_differences_lie_in_ranges_and_slopes(operation, seed):
    """Of every operation, on a function of two variables whose operands both depend on both."""
    rng = np.random.default_rng(seed)
    least, most = ARGUMENTS.get(operation, (-2.0, 2.0))
    ends = np.sort(rng.uniform(least, most, (2, 2)), axis=1)

    def function(x, y):
        if operation is np.power:
            return np.power(x + 0.1 * y, -0.7)
        operands = (x, y * x + 4.0 if operation is np.true_divide else y)
        return operation(*operands[: operation.nin])

    def value_at(point):
        return float(function(*map(np.array, point)))

    points = [np.array([v]) for v in rng.uniform(ends[:, 0], ends[:, 1])]
    box = [Interval(end[:1], end[1:]) for end in ends]
    made = as_quotient(function(*box_variables(box, points)))
    assert isinstance(made, Quotient)
    found = made.above if isinstance(made.below, float) else made.divide()
    for sample in rng.uniform(ends[:, 0], ends[:, 1], (40, 2)):
        value = value_at(sample)
        assert found.value.low[0] - 1e-12 <= value <= found.value.high[0] + 1e-12
        for k, step in enumerate(1e-6 * np.eye(2)):
            if (
                operation is not np.sign
                and np.all(sample - step > ends[:, 0])
                and np.all(sample + step < ends[:, 1])
            ):
                slope = (value_at(sample + step) - value_at(sample - step)) / 2e-6
                assert found.slopes.low[k, 0] - 1e-5 <= slope <= found.slopes.high[k, 0] + 1e-5


def test_the_excess_width_falls_with_the_square_of_the_box():
    """x·(1 − x) near ½, where its slope is 0: interval arithmetic alone is too wide by the width itself."""

    def excess(width):
        (x,) = box_variables([Interval(np.array([0.5 - width]), np.array([0.5 + width]))], [np.array([0.5])])
        return (x * (1.0 - x)).value.high[0] - 0.25

    assert excess(1e-3) <= 2.1e-6
    assert excess(1e-5) <= 2.1e-10


def test_a_quotient_by_what_may_be_zero_keeps_its_bound():
    """1/x ≤ 4 over −1 ≤ x ≤ 1, for x > 0: 1 ≤ 4·x leaves ¼ ≤ x."""
    (x,) = box_variables([Interval(np.array([-1.0]), np.array([1.0]))], [np.array([0.1])])
    kept = 2.0 * (1.0 / x)
    assert isinstance(kept, Quotient)
    excess = kept.above - 8.0 * kept.below
    assert (excess.at.low[0], excess.at.high[0]) == (pytest.approx(1.2), pytest.approx(1.2))
    assert (excess.slopes.low[0, 0], excess.slopes.high[0, 0]) == pytest.approx((-8.0, -8.0), rel=2e-15)


@pytest.mark.parametrize("power", [0.5, -0.5])
def test_a_power_of_a_quotient_keeps_its_bound(power):
    """(1/x)^p ≤ 2 over −1 ≤ x ≤ 1, for x > 0: above − 2·below is finite, with the sign of the excess at ½ and ⅛."""
    (x,) = box_variables([Interval(np.array([-1.0, -1.0]), np.array([1.0, 1.0]))], [np.array([0.5, 0.125])])
    with np.errstate(divide="ignore"):
        kept = np.power(1.0 / x, power)
    assert isinstance(kept, Quotient)
    excess = kept.above - 2.0 * kept.below
    assert np.all(np.isfinite(excess.value.low))
    assert np.array_equal(np.sign(excess.at.low), np.sign(np.array([0.5, 0.125]) ** -power - 2.0))


def test_a_side_too_narrow_to_be_cut_is_not_cut():
    """A side that decides the most, but is a unit in the last place wide, gives way to the widest."""
    ends = {"size": (50.0, 60.0), "offset": (-5.0, 5.0)}
    boxes = DesignBoxes.single_box(ends, 60.0, {})
    point = np.array([50.0])
    narrowed = boxes.with_ends_and_cut_side({"size": point}, {"size": np.nextafter(point, 51.0)}, boxes.side)
    halves = narrowed.halve_boxes()
    assert np.array_equal(halves.low["offset"], [-5.0, 0.0])
    assert np.array_equal(halves.low["size"], [50.0, 50.0])


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", CONTACTS)
@given(seed=st.integers(0, 10**6), wide=st.sampled_from([1e-6, 1e-3, 0.05, 0.5]))
@settings(max_examples=times(4, deep=100))
def test_no_design_of_a_box_lies_outside_of_a_limit_s_range(name, seed, wide):
    """Every limit at random cam angles: values and ranges of the limit's own formula."""
    problem, rng = limited_problem(name), np.random.default_rng(seed)
    low, high, free = random_boxes(problem, rng, 5, wide)
    setup, sense = problem.setup, problem.design.sense
    boxes = Designs(**{n: Interval(low[n], high[n]) for n in low}, sense=sense)
    possible = ~setup.mechanism.cannot_assemble(boxes, problem.programme)
    low, high = ({n: v[possible] for n, v in ends.items()} for ends in (low, high))
    points = designs_inside(low, high, rng, sense)
    first = {n: points.sizes[n][::60] for n in free}
    exists, home = setup.mechanism.can_assemble(points, problem.programme), np.repeat(np.arange(possible.sum()), 60)
    points, home = points.take(exists), home[exists]
    assume(len(points))
    sizes = dict(
        zip(free, box_variables([Interval(low[n], high[n]) for n in free], list(first.values())), strict=True)
    )
    made = Designs(**{**low, **sizes}, sense=sense)
    for _, constraint in size_constraints_with_error_variants(problem):
        angles = rng.uniform(0.0, 2 * np.pi, possible.sum())
        with np.errstate(all="ignore"):
            value = as_quotient(
                value_and_slope(constraint.curve(made, problem.programme), ..., problem.programme.state(angles))[0]
            )
            state = problem.programme.state(angles[home])
            values = value_and_slope(constraint.curve(points, problem.programme), ..., state)[0]
        if not isinstance(value.below, float):
            continue
        ends = as_sloped_interval(value.above, sizes[free[0]]).value
        least, most = (np.broadcast_to(end, possible.sum())[home] for end in (ends.low, ends.high))
        room = 1e-11 * np.max(np.abs(values), initial=0.0) + 1e-13
        assert np.all(values >= least - room), constraint
        assert np.all(values <= most + room), constraint


def may_hold(problem, designs, angles):
    """Those designs that hold all constraints at some cam angles: what does not at one of them is not feasible."""
    designs = designs.take(problem.setup.mechanism.can_assemble(designs, problem.programme))
    for constraint in problem.constraints:
        sides = problem.programme.one_sided_angles(angles, constraint.kinds).ravel()
        each = designs.take(np.repeat(np.arange(len(designs)), sides.size))
        state = problem.programme.state(np.tile(sides, len(designs)))
        with np.errstate(all="ignore"):
            values = (
                constraint.factor(each) * value_and_slope(constraint.curve(each, problem.programme), ..., state)[0]
            )
        broken = np.any(
            [side * values > constraint.upper_bound_of_each_side() for side in constraint.side_signs], axis=0
        )
        designs = designs.take(~np.any(broken.reshape(len(designs), sides.size), axis=1))
    return designs


def feasible_ones(problem, designs):
    """Which designs are feasible, one by one; asked exactly only of those that no cam angle shows broken."""
    for angles in (COARSE, FINE):
        designs = may_hold(problem, designs, angles)
    for k in range(len(designs)):
        yield feasible_designs(problem, designs.take([k]))[0]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", CONTACTS)
@given(seed=st.integers(0, 10**6), wide=st.sampled_from([1e-3, 0.02, 0.2]))
@settings(max_examples=times(3, deep=100))
def test_no_feasible_design_is_cut_off(name, seed, wide):
    """Feasible designs of random boxes lie in boxes that are not empty, between the ends that are left."""
    problem, rng = problem_with_some_limits(name), np.random.default_rng(seed)
    low, high, free = random_boxes(problem, rng, BOXES, wide)
    box = Designs(**{n: Interval(low[n], high[n]) for n in low}, sense=problem.design.sense)
    seen = enclose_limits(problem, size_constraints_with_error_variants(problem), box, free)
    points, home = designs_inside(low, high, rng, problem.design.sense), np.repeat(np.arange(BOXES), 60)
    beyond = [(points.sizes[n] < seen.low[n][home]) | (points.sizes[n] > seen.high[n][home]) for n in free]
    assert not any(feasible_ones(problem, points.take(seen.empty[home] | np.any(beyond, axis=0))))


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", CONTACTS)
def test_boxes_of_feasible_and_of_empty_designs_are_met(name):
    """The test above has something to say: some random boxes hold feasible designs, and some are cut or empty."""
    problem, rng = problem_with_some_limits(name), np.random.default_rng(0)
    (low, high, free), (near, far, _) = (
        random_boxes(problem, rng, times(4, deep=200), 0.02, away) for away in (0.02, 0.2)
    )
    low, high = ({n: np.concatenate([a[n], b[n]]) for n in a} for a, b in ((low, near), (high, far)))
    box = Designs(**{n: Interval(low[n], high[n]) for n in low}, sense=problem.design.sense)
    seen = enclose_limits(problem, size_constraints_with_error_variants(problem), box, free)
    middles = Designs(**{n: (low[n] + high[n]) / 2 for n in low}, sense=problem.design.sense)
    assert seen.empty.any()
    assert np.any(seen.low["size"] > low["size"])
    assert not any(feasible_ones(problem, middles.take(seen.empty)))
    assert any(feasible_ones(problem, middles.take(~seen.empty)))

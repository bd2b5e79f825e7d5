"""The extremes kernel, its jets and the interval formulas against slow, obvious computations."""

from fractions import Fraction
from functools import cache
from itertools import product

import numpy as np
import pytest
from flint import arb, arb_series, ctx
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.polynomial import polynomial
from support import own
from support.balls.ball import PRECISION_BITS
from support.depth import covering_cases, times

from camopt.core.kernels import compile
from camopt.core.kernels.compile import compiled
from camopt.core.numerics import INPUT_ROUNDOFF, LARGEST, LARGEST_MAGNITUDE, LEAST, UNIT_ROUNDOFF
from camopt.core.numerics.climbing import PanelPartEnds
from camopt.core.numerics.curves import Linear, value_and_slope
from camopt.core.numerics.extremes import Precision, extremes_of_curve
from camopt.core.numerics.halving import (
    CLIMBS,
    CONCAVE,
    SETTLED,
    UNSETTLED,
    classify_and_bound_part,
)
from camopt.core.numerics.interval import LIBRARY_ERROR, Interval
from camopt.core.numerics.jet import JET_FIELDS, Jet
from camopt.core.numerics.piecewise import state_jets_over_part, state_jets_over_row
from camopt.core.numerics.state import State
from camopt.model.effects import EvaluationBlock, Setup
from camopt.model.mechanisms import MECHANISMS, Designs
from camopt.model.mechanisms.elements import ROLLER
from camopt.model.motion.programme import Programme, weighted_derivative_range
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RETURN, RISE

CURVES = ("pressure", "curvature", "profile_radius", "reach")


def programme(law: str, *, angular: bool) -> Programme:
    lift = 15.0 if angular else 30.0
    return Programme.from_segments(
        [
            ("rise", 110, lift, law),
            ("dwell", 50, 0, None),
            ("return", 95, lift, law),
            ("dwell", 105, 0, None),
        ],
        angular=angular,
        laws=own.EVERY,
    )


def designs(angular: bool, sense: float, count: int = 8, seed: int = 0) -> Designs:
    """Random designs that can be assembled, whatever the mechanism."""
    rng = np.random.default_rng(seed)
    zero = np.zeros(count)
    return Designs(
        size=rng.uniform(35, 90, count),
        roller_radius=rng.uniform(0, 15, count),
        offset=zero if angular else rng.uniform(-20, 20, count),
        arm_length=rng.uniform(100, 120, count),
        centre_distance=rng.uniform(125, 140, count),
        face_offset=rng.uniform(-5, 15, count),
        roller_spacing=zero,
        sense=sense,
    )


def cases():
    for (form, motion, flat), mechanism in MECHANISMS.items():
        for name in CURVES:
            if getattr(mechanism, name):
                yield pytest.param(mechanism, motion == "oscillating", name, id=f"{form}-{motion}-{flat}-{name}")


@cache
def sampled_motion(law, angular):
    """Some thousand cam angles of each stroke but its ends, and the motion there."""
    turn = programme(law, angular=angular)
    angles = np.concatenate([np.linspace(s.start, s.end, 20001)[1:-1] for s in turn.strokes])
    return turn, angles, turn.motion_at(angles)


WAYS = [(law, way * (-1.0) ** k) for way in (1.0, -1.0) for k, law in enumerate(own.STILL)]  # the cam's rotation


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("law", "sense"), covering_cases(WAYS, lambda way: way[:1]))
@pytest.mark.parametrize(("mechanism", "angular", "name"), list(cases()))
def test_extremes_are_those_of_dense_sampling(mechanism, angular, name, sense, law):
    turn, angles, motion = sampled_motion(law, angular)
    some = designs(angular, sense, times(4, deep=8), seed=own.STILL.index(law))
    case = EvaluationBlock(Setup(mechanism, ROLLER, relative_error=1e-13), turn, some)
    make = getattr(mechanism, name)
    questions = [(ALL_STROKES, LARGEST), (ALL_STROKES, LEAST), (RISE, LARGEST_MAGNITUDE), (RETURN, LARGEST)]
    value, where, _ = case.extremes(make, questions, exact_angles=True)
    on_rise = angles < turn.strokes[0].end
    on_return = (angles > turn.strokes[2].start) & (angles < turn.strokes[2].end)
    f = make(some, turn)
    for i in range(len(some)):
        sampled, _ = value_and_slope(f, i, State(*motion))
        sampled = np.broadcast_to(sampled, angles.shape)
        scale = np.max(np.abs(sampled)) + 1e-300
        expected = [sampled.max(), -sampled.min(), np.abs(sampled[on_rise]).max(), sampled[on_return].max()]
        found = value[:, i] * [1, -1, 1, 1]
        assert np.all(found >= np.array(expected) - 1e-13 * scale)  # never below a sample
        assert np.all(found <= np.array(expected) + 2e-3 * scale)  # one-sided values at jumps lie beyond samples
        for angle, extreme in zip(where[:2, i], value[:2, i], strict=True):
            there = [
                value_and_slope(f, i, turn.state(np.array([np.mod(angle + d, 2 * np.pi)])))[0][()]
                for d in (-1e-9, 1e-9)
            ]
            assert np.min(np.abs(np.ravel(there) - extreme)) <= 1e-6 * scale


@pytest.mark.parametrize(("mechanism", "angular", "name"), list(cases()))
@given(data=st.data())
@settings(max_examples=times(20, deep=200))
def test_interval_formulas_enclose_every_design_of_a_box(mechanism, angular, name, data):
    turn = programme("cycloidal", angular=angular)
    middle = designs(angular, 1.0, 1, seed=data.draw(st.integers(0, 99)))
    half = {n: data.draw(st.floats(0, 2)) for n in ("size", "offset", "roller_radius")}
    half["offset"] = 0.0 if angular else half["offset"]
    box = Designs(
        **{n: Interval(v - half.get(n, 0.0), v + half.get(n, 0.0)) for n, v in middle.sizes.items()},
        sense=1.0,
    )
    motion = turn.motion_at(np.array([data.draw(st.floats(0, 6.28))]))
    value, slope = value_and_slope(getattr(mechanism, name)(box, turn), ..., State(*motion))
    share = {n: data.draw(st.floats(-1, 1)) for n in half}
    inside = Designs(**{n: v + share.get(n, 0.0) * half.get(n, 0.0) for n, v in middle.sizes.items()}, sense=1.0)
    point, point_slope = value_and_slope(getattr(mechanism, name)(inside, turn), 0, State(*motion))
    for interval, number in ((value, point), (slope, point_slope)):
        interval = (
            interval if isinstance(interval, Interval) else Interval(np.asarray(interval), np.asarray(interval))
        )
        room = 1e-9 * (1 + np.abs(number))
        assert np.all(interval.low <= number + room)
        assert np.all(number <= interval.high + room)


@pytest.mark.parametrize("law", list(own.EVERY))
@pytest.mark.parametrize("weights", [(0, 1), (0, 0, 1), (-0.5, 1), (1, 0, 1)])
def test_span_of_a_combination_of_derivatives(law, weights):
    turn, _, motion = sampled_motion(law, False)
    sampled = np.tensordot(weights, motion[: len(weights)], axes=1)
    least, largest = weighted_derivative_range(turn, weights, ALL_STROKES)
    scale = np.abs(sampled).max()
    assert least <= sampled.min() + 1e-13 * scale
    assert largest >= sampled.max() - 1e-13 * scale
    assert least == pytest.approx(sampled.min(), abs=2e-3 * scale)
    assert largest == pytest.approx(sampled.max(), abs=2e-3 * scale)


@pytest.mark.parametrize("rows", [1, 255, 256, 257, 1000])
def test_an_answer_does_not_depend_on_its_place_in_a_block(rows):
    turn = programme("poly345", angular=False)
    mechanism = MECHANISMS["disc", "translating", False]
    setup = Setup(mechanism, ROLLER, relative_error=1e-13)
    many = designs(False, 1.0, 1000)
    whole, _, _ = EvaluationBlock(setup, turn, many).extremes(mechanism.curvature, [(ALL_STROKES, LARGEST)])
    part, _, _ = EvaluationBlock(setup, turn, many.take(slice(1000 - rows, None))).extremes(
        mechanism.curvature, [(ALL_STROKES, LARGEST)]
    )
    assert np.array_equal(whole[:, 1000 - rows :], part)


def test_a_peak_narrower_than_a_panel_is_found():
    """s₀ → 0: the pitch curve has a near-cusp far narrower than the table's panels."""
    turn = programme("harmonic", angular=False)
    mechanism = MECHANISMS["disc", "translating", False]
    setup = Setup(mechanism, ROLLER, relative_error=1e-13)
    zero = np.zeros(1)
    for height in (1.0, 0.1, 0.01):
        e = 10.0
        some = Designs(np.array([np.hypot(e, height)]), zero, np.array([e]), zero, zero, zero, zero, 1.0)
        value, where, _ = EvaluationBlock(setup, turn, some).extremes(
            mechanism.curvature, [(ALL_STROKES, LARGEST), (ALL_STROKES, LEAST)]
        )
        f = mechanism.curvature(some, turn)
        for at, extreme, sign in zip(where[:, 0], value[:, 0], (1, -1), strict=True):
            near = np.concatenate([np.linspace(1e-9, 6.28, 400001), at + np.linspace(-1e-3, 1e-3, 20001)])
            sampled = sign * value_and_slope(f, 0, turn.state(np.mod(near, 2 * np.pi)))[0]
            assert sign * extreme >= sampled.max() * (1 - 1e-12)
            assert sign * extreme == pytest.approx(sampled.max(), rel=1e-3)


def largest_by_zoom(f, i, sign, turn):
    """The largest oriented value of a curve: a grid, dense next to the ends of strokes, and zooms into its best."""
    hairs = np.concatenate([np.geomspace(1e-12, 1e-2, 300), np.linspace(1e-2, 0.5, 700)])
    best = -np.inf
    for stroke in turn.strokes:
        x, room = np.concatenate([hairs, 1 - hairs]), 0.1
        for _ in range(5):
            values = sign * value_and_slope(f, i, turn.state(stroke.start + stroke.angle * x))[0]
            values = np.broadcast_to(values, x.shape)
            best, centre = max(best, values.max()), x[values.argmax()]
            room = min(room, 0.5 * min(centre, 1 - centre))
            x, room = centre + np.linspace(-room, room, 401), room / 50
    return best


@pytest.mark.one_in(4)
@pytest.mark.parametrize("law", ["cycloidal", "parabolic", "poly345", "modified-sine"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-9])
def test_narrow_peaks_of_many_cams_next_to_the_limit(law, tolerance):
    """s₀ → 0 at random: each extreme within its tolerance, and none beyond its enclosure."""
    turn, rng, count = programme(law, angular=False), np.random.default_rng(8), 12
    mechanism, zero = MECHANISMS["disc", "translating", False], np.zeros(count)
    size = rng.uniform(1, 40, count)
    offset = rng.choice([-1, 1], count) * size * (1 - 10 ** rng.uniform(-6, -0.5, count))
    some = Designs(size, zero, offset, zero, zero, zero, zero, 1.0)
    case = EvaluationBlock(Setup(mechanism, ROLLER, tolerance), turn, some)
    for make in (mechanism.pressure, mechanism.curvature):
        value, _, width = case.extremes(make, [(ALL_STROKES, LARGEST), (ALL_STROKES, LEAST)])
        f = make(some, turn)
        for i in range(count):
            for k, sign in enumerate((1.0, -1.0)):
                expected, found = largest_by_zoom(f, i, sign, turn), sign * value[k, i]
                largest = np.abs(value[:, i]).max()
                assert expected <= found + width[k, i] + 1e-11 * largest
                assert found <= expected + 1e-5 * largest
                assert width[k, i] <= (tolerance + 1e-10) * largest


def test_an_enclosure_holds_the_exact_value_of_a_line():
    """a·y + constant is largest on the dwell at the top: in fractions. Its value rounds, and its width says so."""
    turn, rng, count = programme("cycloidal", angular=False), np.random.default_rng(4), 400
    f = Linear(rng.uniform(0.1, 1, count), *np.zeros((2, count)), rng.uniform(-9, 9, count))
    value, _, width = extremes_of_curve(f, count, turn.table, [(DWELL, LARGEST)], Precision(1e-9, np.inf))
    rounded = 0
    for i in range(count):
        exact = Fraction(f.displacement[i]) * 30 + Fraction(f.constant[i])
        error = abs(Fraction(value[0, i]) - exact)
        assert error <= Fraction(width[0, i]) <= Fraction(2e-13)
        rounded += error > 0
    assert rounded > count / 10


def test_lines_have_the_extremes_of_their_polynomials():
    """Random combinations of y, y' and y'', against the roots of each panel's derivative."""
    turn, rng, count = programme("poly4567", angular=False), np.random.default_rng(6), 8
    f = Linear(*rng.normal(size=(3, count)), np.zeros(count))
    value, _, width = extremes_of_curve(
        f, count, turn.table, [(ALL_STROKES, LEAST), (ALL_STROKES, LARGEST)], Precision(1e-13, np.inf)
    )
    for i in range(count):
        exact = weighted_derivative_range(turn, (f.displacement[i], f.velocity[i], f.acceleration[i]), ALL_STROKES)
        assert value[:, i] == pytest.approx(exact, rel=1e-12)
        assert np.all(width[:, i] <= 1e-12 * np.abs(exact).max())


@pytest.mark.parametrize(("designs", "compilation"), [(8, np.inf), (700, 0.0)])
@pytest.mark.parametrize("goal", [LEAST, LARGEST, LARGEST_MAGNITUDE])
def test_no_extreme_is_below_a_floor(goal, designs, compilation, monkeypatch):
    """Random lines with floors near their extremes, against the roots of each panel's derivative."""
    monkeypatch.setattr(compile, "COMPILATION", compilation)
    turn, rng = programme("poly4567", angular=False), np.random.default_rng(7)
    f = Linear(*rng.normal(size=(3, designs)), np.zeros(designs))
    ends = [weighted_derivative_range(turn, tuple(float(x[i]) for x in f[:3]), ALL_STROKES) for i in range(8)]
    extreme = {
        LEAST: lambda end: -end[0],
        LARGEST: lambda end: end[1],
        LARGEST_MAGNITUDE: lambda end: max(-end[0], end[1]),
    }
    exact = np.array([extreme[goal](end) for end in ends])
    for floor in (*exact[:4] * (1 + 1e-6), *exact[4:] * (1 - 1e-6), -np.inf, 1e3):
        value, _, width = extremes_of_curve(
            f, designs, turn.table, [(ALL_STROKES, goal)], Precision(1e-9, np.inf, floor)
        )
        found, expected = (-value if goal == LEAST else value)[0, :8], np.maximum(exact, floor)
        assert np.all(expected <= found + width[0, :8] + 1e-12 * expected)
        assert np.all(found <= expected * (1 + 1e-12))
        assert np.all(width[0, :8] <= 2e-9 * expected)


def test_a_curve_that_is_nothing_is_known_exactly():
    turn, zero = programme("cycloidal", angular=False), np.zeros(1)
    questions = [(ALL_STROKES, LARGEST), (ALL_STROKES, LEAST), (ALL_STROKES, LARGEST_MAGNITUDE)]
    value, _, width = extremes_of_curve(
        Linear(zero, zero, zero, zero), 1, turn.table, questions, Precision(1e-9, np.inf)
    )
    assert np.all(value == 0.0)
    assert np.all(width == 0.0)


@compiled
def operate(a, b, found):
    """Every operation on jets a and b, and on a and the number b[0]; rows as in EXACT, columns as in FIELDS."""
    p, q, x = Jet(a[0], a[1], a[2], a[3], a[4], a[5]), Jet(b[0], b[1], b[2], b[3], b[4], b[5]), b[0]
    jets = (
        -p, np.square(p), np.sin(p), np.cos(p), np.sqrt(p),
        p + q, p - q, p * q, p / q,
        p + x, p - x, p * x, p / x,
        x + p, x - p, x * p, x / p,
    )  # fmt: skip
    for k, z in enumerate(jets):
        row = found[k]
        row[0], row[1], row[2], row[3], row[4], row[5] = z.low, z.high, z.error, z.first, z.second, z.third


UNARY = {
    "-a": lambda a: -a,
    "a²": lambda a: a * a,
    "sin a": lambda a: a.sin(),
    "cos a": lambda a: a.cos(),
    "√a": lambda a: a.sqrt(),
}
BINARY = {
    "a + b": lambda a, b: a + b,
    "a - b": lambda a, b: a - b,
    "a · b": lambda a, b: a * b,
    "a / b": lambda a, b: a / b,
}
EXACT = (
    *((name, lambda a, b, exact=exact: exact(a), "") for name, exact in UNARY.items()),
    *((name, exact, "jet") for name, exact in BINARY.items()),
    *((name.replace("b", "x"), exact, "number") for name, exact in BINARY.items()),
    *((f"x {name[2]} a", lambda a, x, exact=exact: exact(x, a), "number") for name, exact in BINARY.items()),
)


def random_jet(rng, width):
    """Either side of zero or, if wide, across it; half of them around a crest of a sine or cosine."""
    middle = rng.integers(1, 5) * np.pi / 2 if rng.random() < 0.5 else rng.uniform(0.3, 4)
    low, high = np.sort(rng.choice([-1, 1]) * np.array([middle - width / 2, middle + width / 2]))
    return np.array([low, high, rng.choice([0, 1e-15, 1e-13]), *rng.uniform(0.1, 4, 3)])


def points_of(jet, inner=0):
    """What a jet allows at a point: values at its ends and between, derivatives as large as it says; as series."""
    low, high, _, first, second, third = jet
    values = {low, high, *np.linspace(low, high, inner + 2), *([0.0] if low < 0.0 < high else [])}
    return [
        arb_series([arb(v), arb(first * i), arb(second * j) / 2, arb(third * k) / 6], prec=4)
        for v in values
        for i, j, k in product((-1, 1), repeat=3)
    ]


def with_value_error(series, error):
    """The value alone, off by an error to one side or the other."""
    return [arb_series([series[0] + side * arb(error)], prec=1) for side in (-1, 1)]


OWN_ROUNDING = {"-a": 0.0, "sin a": 2.0, "cos a": 2.0}  # in units, else 1


@pytest.mark.one_in(5)
@pytest.mark.parametrize("width", [1e-6, 1e-3, 0.5, 3.0])
@pytest.mark.parametrize("seed", range(12))
@ctx.workprec(PRECISION_BITS)
def test_jets_hold_all_that_they_may_and_no_more(width, seed):
    """Each operation, in 200 bits at the corners of its operands: nothing outside its bounds, and they are met."""
    rng = np.random.default_rng(seed)
    a, b = random_jet(rng, width), random_jet(rng, min(width, 0.4))
    found = np.empty((len(EXACT), len(JET_FIELDS)))
    with np.errstate(all="ignore"):
        operate(a, b, found)
    for (name, exact, other), bounds in zip(EXACT, found, strict=True):
        if (name == "√a" and a[0] <= 0.0) or (name == "x / a" and a[0] <= 0.0 <= a[1]):
            continue
        others = points_of(b) if other == "jet" else [arb_series([arb(b[0])], prec=4)]
        brought = {"": 0.0, "jet": b[2], "number": INPUT_ROUNDOFF * abs(b[0])}[other]
        results = [(p, q, exact(p, q)) for p in points_of(a, 0 if other else 3) for q in others]
        values = [float(z[0]) for *_, z in results]
        worst = [max(abs(float(z[k])) for *_, z in results) * factor for k, factor in ((1, 1), (2, 2), (3, 6))]
        rounding = max(
            float(abs(exact(p1, q1)[0] - z[0])) + OWN_ROUNDING.get(name, 1.0) * UNIT_ROUNDOFF * abs(float(z[0]))
            for p, q, z in results[::8]
            for p1 in with_value_error(p, a[2])
            for q1 in with_value_error(q, brought)
        )
        low, high, error, *derivatives = bounds
        close = 1e-14 * max(abs(low), abs(high))
        assert low <= min(values) + close, name
        assert max(values) - close <= high, name
        assert np.all(np.array(derivatives) >= np.array(worst) * (1 - 1e-12)), name
        assert error >= rounding * (1 - 1e-6), name
        wave = name in ("sin a", "cos a")  # bounded by curvature: only nearly met
        if wave:
            assert -1.0 <= low <= high <= 1.0
            assert derivatives[0] <= min(a[3], worst[0] + a[3] * width * width)
        room = width * width if wave else close
        assert low >= min(values) - room, name
        assert max(values) + room >= high, name
        if width < 0.1:
            loose = 5 * width if wave else 1e-12
            assert np.all(np.array(derivatives) <= np.array(worst) * (1 + loose) + (loose if wave else 0.0)), name
            largest = a[2] + 2 * UNIT_ROUNDOFF if wave else rounding * (1.7 if other == "number" else 1.01)
            assert error <= largest * (1 + 1e-12), name


@pytest.mark.parametrize("b", [(-1.0, 2.0), (0.0, 1.0), (-1.0, 0.0)])
def test_a_quotient_by_what_may_be_zero_has_no_bounds(b):
    for a in ([1.0, 2.0, 1e-16, 1.0, 1.0, 1.0], [0.0] * 6):
        found = np.empty((len(EXACT), len(JET_FIELDS)))
        with np.errstate(all="ignore"):
            operate(np.array(a), np.array([*b, 0.0, 0.0, 0.0, 0.0]), found)
        quotient = found[[name for name, *_ in EXACT].index("a / b")]
        assert not np.isfinite(quotient).any()


@compiled
def jets_of_parts(table, middle, reach, found):
    """What is known of y … over panels, or parts of them: found[panel, order], columns as in FIELDS."""
    for panel in range(middle.size):
        whole = reach[panel] == 1.0
        at = (
            state_jets_over_row(table, panel)
            if whole
            else state_jets_over_part(table, panel, middle[panel], reach[panel])
        )
        jets = (at.y, at.y1, at.y2, at.y3, at.y4)
        for order in range(5):
            z, row = jets[order], found[panel, order]
            row[0], row[1], row[2], row[3], row[4], row[5] = z.low, z.high, z.error, z.first, z.second, z.third


@pytest.mark.parametrize("law", ["cycloidal", "poly345", "uniform", "modified-trapezoid"])
@pytest.mark.parametrize("reach", [1.0, 0.999, 0.3, 1e-3])
def test_jets_of_a_part_of_a_panel_hold_the_motion_there(law, reach):
    """Against the derivatives of the panels' polynomials, taken by numpy at points of each part."""
    turn = programme(law, angular=False)
    table, rng = turn.table, np.random.default_rng(1)
    middle = rng.uniform(reach - 1, 1 - reach, table.centre.size) if reach < 1 else np.zeros(table.centre.size)
    found = np.empty((middle.size, 5, len(JET_FIELDS)))
    jets_of_parts(table, middle, np.full(middle.size, reach), found)
    points = middle[:, None] + reach * np.linspace(-1, 1, 33)
    derivatives = np.array([
        [polynomial.polyval(u, polynomial.polyder(c, k)) / h**k for k in range(7)]
        for c, h, u in zip(table.coefficients, table.half_width, points, strict=True)
    ])  # fmt: skip
    most_of_panel = table.most[: middle.size]  # the other rows are of groups
    scale = np.abs(derivatives).max(axis=(0, 2))
    arc = reach * table.half_width
    for order in range(5):
        low, high, error, *most = found[:, order].T
        values, room = derivatives[:, order], 1e-9 * scale[order]
        assert np.all(low <= values.min(axis=1) + 1e-14 * scale[order])
        assert np.all(values.max(axis=1) - 1e-14 * scale[order] <= high)
        assert np.array_equal(error, table.error[: middle.size, order])
        for k, bound in enumerate(most, order + 1):
            if k > 6:
                assert np.isinf(bound).all()
                continue
            largest = np.abs(derivatives[:, k]).max(axis=1)
            assert np.all(bound >= largest * (1 - 1e-12))
            beyond = 4 * arc * most_of_panel[:, k + 1] if k < 4 else np.inf
            assert np.all(bound <= np.minimum(largest + beyond, most_of_panel[:, k]) + room + 1e-9 * scale[k])
        if reach == 1.0:
            spread = values.max(axis=1) - values.min(axis=1)
            assert np.all(high - low <= 1.5 * spread + room)
        elif order < 3:
            assert np.all(high - low <= 2 * arc * most[0] * (1 + 1e-12) + room)
            assert np.all(np.abs(high + low - 2 * values[:, 16]) <= room)


def brief(low, high):
    return Interval(np.asarray(low, dtype=float), np.asarray(high, dtype=float))


@pytest.mark.parametrize("name", ["add", "subtract", "multiply", "divide", "maximum", "minimum", "arctan2"])
@given(ends=st.tuples(*[st.integers(-99, 99).map(lambda k: k / 11)] * 4))
@example((1.0, 2.0, -0.5, 0.0))
@example((1.0, 2.0, -0.5, 0.5))
@example((1.0, 2.0, 0.0, 0.5))
@example((1.0, 2.0, 0.0, 0.0))
@example((1.0, 2.0, -2.0, -0.5))
def test_interval_operations_are_the_range_over_a_grid(name, ends):
    (a, b), (c, d) = sorted(ends[:2]), sorted(ends[2:])
    if name == "arctan2":
        a, b, c, d = *sorted(map(abs, (a, b))), *sorted(map(abs, (c, d)))
    found = getattr(np, name)(brief(a, b), brief(c, d))
    if name == "divide" and c == 0.0 < d:  # by what is above 0
        ends = (a / d, b / d, *(np.copysign(np.inf, each) for each in (a, b) if each))
        values = np.array([*ends, 0.0] if a <= 0.0 <= b else ends)
    elif name == "divide" and c <= 0.0 <= d:
        values = np.array([-np.inf, np.inf])
    else:
        values = getattr(np, name)(*np.meshgrid([a, b, (a + b) / 2], [c, d, (c + d) / 2]))
    assert_tight(found, values.min(), values.max())


def assert_tight(found, least, most):
    """An interval encloses a range and is larger than it by no more than the room for rounding."""
    room = INPUT_ROUNDOFF + LIBRARY_ERROR + 4 * UNIT_ROUNDOFF
    for low, high in ((found.low, least), (most, found.high)):
        assert low <= high
        assert low == pytest.approx(high, rel=room, abs=1e-300)


@pytest.mark.parametrize("name", ["negative", "square", "sqrt", "sin", "cos", "arcsin"])
@given(middle=st.floats(-9, 9), width=st.sampled_from([0.0, 0.3, 1.5, 4.0, 7.0]))
def test_interval_functions_are_the_range_over_a_grid(name, middle, width):
    if name == "arcsin":
        middle, width = middle / 10, min(width, 0.2)
        width = min(width, 2 - 2 * abs(middle))
    low, high = middle - width / 2, middle + width / 2
    found = getattr(np, name)(brief(low, high))
    if name == "sqrt":  # of what is not below zero
        low, high = max(low, 0.0), max(high, 0.0)
    points = np.append(np.linspace(low, high, 2001), 0.0 if low <= 0.0 <= high else low)
    values, step = getattr(np, name)(points), width / 2000
    room = (INPUT_ROUNDOFF + LIBRARY_ERROR + 4 * UNIT_ROUNDOFF) * max(1.0, np.max(np.abs(values)))
    assert values.min() - step**2 - room <= found.low <= values.min()
    assert values.max() <= found.high <= values.max() + step**2 + room


def test_an_interval_times_itself_is_its_square():
    x = brief([-2.0, 1.0], [1.0, 3.0])
    assert (x * x).low == pytest.approx([0.0, 1.0])
    assert (x * x).high == pytest.approx([4.0, 9.0])
    assert (x * brief(x.low, x.high)).low == pytest.approx([-2.0, 1.0])
    assert [x.least_magnitude.tolist(), x.largest_magnitude.tolist()] == [[0.0, 1.0], [2.0, 3.0]]


@compiled
def look(parts, found):
    """``looked_at`` for rows of its arguments: (verdict, bound, concavity)."""
    for k in range(parts.shape[0]):
        part = parts[k]
        verdict, bound, concavity = classify_and_bound_part(
            PanelPartEnds(part[0], part[1], part[2], part[3], part[4], part[5]), part[6], part[7], part[8]
        )
        found[k, 0], found[k, 1], found[k, 2] = verdict, bound, concavity


def test_what_is_said_of_a_part_is_the_truth_of_a_cubic():
    """Of a cubic the second derivative is least and largest at the ends: a bound from it, in closed form."""
    rng, seen = np.random.default_rng(5), set()
    for _ in range(2000):
        f = polynomial.Polynomial(rng.normal(size=4) * [1, 1, rng.choice([0.1, 1, 3]), rng.choice([0, 0.1, 1])])
        (low, high), half_width = np.sort(rng.uniform(-1, 1, 2)), rng.choice([0.01, 1.0, 3.0])
        slope, bend = f.deriv() / half_width, f.deriv(2) / half_width**2
        third = abs(f.coef[3]) * 6 / half_width**3
        width, ends = (high - low) * half_width, max(f(low), f(high))
        least, most = sorted((bend(low), bend(high)))
        largest = f(np.linspace(low, high, 1001)).max()
        enough = ends + rng.choice([0.0, 0.05, 1.0])
        found = np.empty((1, 3))
        part = [low, high, f(low), slope(low), f(high), slope(high), third, half_width, enough]
        look(np.array([part]), found)
        verdict, bound, concavity = found[0]
        seen.add(verdict)
        one = PanelPartEnds(low, high, *np.array(part[2:6])[:, None])
        with np.errstate(divide="ignore", invalid="ignore"):  # as in a search
            many = classify_and_bound_part(one, np.array([third]), half_width, enough)
        assert np.array_equal(np.ravel(many), found[0])
        if abs(most) < 1e-9 * (third * width + abs(least)):
            continue  # rounding decides
        if most < 0.0:
            assert verdict == (CLIMBS if slope(low) > 0.0 > slope(high) else CONCAVE)
            assert concavity == pytest.approx(-most, rel=1e-6)
            assert verdict == CLIMBS or bound == ends >= largest - 1e-12
        else:
            simple = ends + max(-least, 0.0) * width**2 / 8
            assert largest - 1e-12 <= bound <= simple * (1 + np.sign(simple) * 1e-9)
            if simple <= enough:
                assert bound == pytest.approx(simple, rel=1e-9)
            elif f.coef[3] < 0.0:  # then the slope is what it may be at most
                assert bound == pytest.approx(largest, abs=1e-5 * np.abs(f.coef).sum())
            assert verdict == (SETTLED if bound <= enough else UNSETTLED)
    assert seen == {CLIMBS, CONCAVE, SETTLED, UNSETTLED}

"""The extremes kernel and the interval formulas against slow, obvious computations."""

import numpy as np
import own
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camopt.effects import Case, Subject
from camopt.mechanisms import MECHANISMS, Designs
from camopt.motion.programme import Programme, span
from camopt.motion.table import RETURN, RISE, TURN
from camopt.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST
from camopt.numerics.curves import curve
from camopt.numerics.interval import Interval

SMOOTH = [law for law in own.EVERY if law != "uniform"]
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


def designs(angular: bool, sense: float, count: int = 40, seed: int = 0) -> Designs:
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
        sense=sense,
    )


def cases():
    for (form, motion, flat), mechanism in MECHANISMS.items():
        for name in CURVES:
            if getattr(mechanism, name):
                yield pytest.param(mechanism, motion == "oscillating", name, id=f"{form}-{motion}-{flat}-{name}")


@pytest.mark.parametrize("law", SMOOTH)
@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize(("mechanism", "angular", "name"), list(cases()))
def test_extremes_are_those_of_dense_sampling(mechanism, angular, name, sense, law):
    turn, some = programme(law, angular=angular), designs(angular, sense)
    case = Case(Subject(mechanism, angular, False, None, None, tolerance=1e-13), turn, some)
    make = getattr(mechanism, name)
    questions = [(TURN, LARGEST), (TURN, LEAST), (RISE, LARGEST_MAGNITUDE), (RETURN, LARGEST)]
    value, where, _ = case.extremes(make, questions, located=True)
    angles = np.concatenate([np.linspace(s.start, s.end, 20001)[1:-1] for s in turn.strokes])
    motion = turn.at(angles)
    on_rise = angles < turn.strokes[0].end
    on_return = (angles > turn.strokes[2].start) & (angles < turn.strokes[2].end)
    f = make(some, turn)
    for i in range(len(some)):
        sampled, _ = curve(f, i, *motion)
        sampled = np.broadcast_to(sampled, angles.shape)
        scale = np.max(np.abs(sampled)) + 1e-300
        expected = [sampled.max(), -sampled.min(), np.abs(sampled[on_rise]).max(), sampled[on_return].max()]
        found = value[:, i] * [1, -1, 1, 1]
        assert np.all(found >= np.array(expected) - 1e-13 * scale)  # never below a sample
        assert np.all(found <= np.array(expected) + 2e-3 * scale)  # one-sided values at jumps lie beyond samples
        for angle, extreme in zip(where[:2, i], value[:2, i], strict=True):
            there = [curve(f, i, *turn.at(np.array([np.mod(angle + d, 2 * np.pi)])))[0][()] for d in (-1e-9, 1e-9)]
            assert np.min(np.abs(np.ravel(there) - extreme)) <= 1e-6 * scale


@pytest.mark.parametrize(("mechanism", "angular", "name"), list(cases()))
@given(data=st.data())
@settings(max_examples=20, deadline=None)
def test_interval_formulas_enclose_every_design_of_a_box(mechanism, angular, name, data):
    turn = programme("cycloidal", angular=angular)
    middle = designs(angular, 1.0, 1, seed=data.draw(st.integers(0, 99)))
    half = {n: data.draw(st.floats(0, 2)) for n in ("size", "offset", "roller_radius")}
    half["offset"] = 0.0 if angular else half["offset"]
    box = Designs(
        **{n: Interval(v - half.get(n, 0.0), v + half.get(n, 0.0)) for n, v in middle.sizes.items()},
        sense=1.0,
    )
    motion = turn.at(np.array([data.draw(st.floats(0, 6.28))]))
    value, slope = curve(getattr(mechanism, name)(box, turn), ..., *motion)
    share = {n: data.draw(st.floats(-1, 1)) for n in half}
    inside = Designs(**{n: v + share.get(n, 0.0) * half.get(n, 0.0) for n, v in middle.sizes.items()}, sense=1.0)
    point, point_slope = curve(getattr(mechanism, name)(inside, turn), 0, *motion)
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
    turn = programme(law, angular=False)
    angles = np.concatenate([np.linspace(s.start, s.end, 20001)[1:-1] for s in turn.strokes])
    sampled = np.tensordot(weights, turn.at(angles)[: len(weights)], axes=1)
    least, largest = span(turn, weights, TURN)
    scale = np.abs(sampled).max()
    assert least <= sampled.min() + 1e-13 * scale
    assert largest >= sampled.max() - 1e-13 * scale
    assert least == pytest.approx(sampled.min(), abs=2e-3 * scale)
    assert largest == pytest.approx(sampled.max(), abs=2e-3 * scale)


@pytest.mark.parametrize("rows", [1, 255, 256, 257, 1000])
def test_an_answer_does_not_depend_on_its_place_in_a_block(rows):
    turn = programme("poly345", angular=False)
    mechanism = MECHANISMS["disc", "translating", False]
    subject = Subject(mechanism, False, False, None, None, tolerance=1e-13)
    many = designs(False, 1.0, 1000)
    whole, _, _ = Case(subject, turn, many).extremes(mechanism.curvature, [(TURN, LARGEST)])
    part, _, _ = Case(subject, turn, many.take(slice(1000 - rows, None))).extremes(
        mechanism.curvature, [(TURN, LARGEST)]
    )
    assert np.array_equal(whole[:, 1000 - rows :], part)


def test_a_peak_narrower_than_a_panel_is_found():
    """s₀ → 0: the pitch curve has a near-cusp far narrower than the table's panels."""
    turn = programme("harmonic", angular=False)
    mechanism = MECHANISMS["disc", "translating", False]
    subject = Subject(mechanism, False, False, None, None, tolerance=1e-13)
    zero = np.zeros(1)
    for height in (1.0, 0.1, 0.01):
        e = 10.0
        some = Designs(np.array([np.hypot(e, height)]), zero, np.array([e]), zero, zero, zero, 1.0)
        value, where, _ = Case(subject, turn, some).extremes(mechanism.curvature, [(TURN, LARGEST), (TURN, LEAST)])
        f = mechanism.curvature(some, turn)
        for at, extreme, sign in zip(where[:, 0], value[:, 0], (1, -1), strict=True):
            near = np.concatenate([np.linspace(1e-9, 6.28, 400001), at + np.linspace(-1e-3, 1e-3, 20001)])
            sampled = sign * curve(f, 0, *turn.at(np.mod(near, 2 * np.pi)))[0]
            assert sign * extreme >= sampled.max() * (1 - 1e-12)
            assert sign * extreme == pytest.approx(sampled.max(), rel=1e-3)

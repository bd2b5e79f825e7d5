"""The proof of a band, in 60 digits: against balls of 200 bits, with the polynomials of splines from the oracle."""

import numpy as np
import pytest
from flint import arb, fmpq
from support.balls.ball import precisely
from support.balls.laws import pieces_of

from camopt.model.motion.programme import Programme
from camopt.model.motion.spline import SplineLaw
from camopt.solve.measured.band_certificate import certify_band
from camopt.solve.measured.measured_points import MeasuredPoints

DEGREE, SAMPLES = 5, 40


def law_at_random(rng, name):
    """A clamped quintic from 0 to 1."""
    inner = np.sort(rng.uniform(0.1, 0.9, rng.integers(0, 4))).tolist()
    count = DEGREE + 1 + len(inner)
    coefficients = np.sort(rng.uniform(0.0, 1.0, count - 6)).tolist()
    knots = (*[0.0] * (DEGREE + 1), *inner, *[1.0] * (DEGREE + 1))
    return SplineLaw(name, DEGREE, knots, (0.0, 0.0, 0.0, *coefficients, 1.0, 1.0, 1.0))


def motion_of(programme, angle):
    """The displacement at a cam angle (deg, exact) in balls."""
    start, level = fmpq(0), arb(0)
    for stroke in programme.strokes:
        length, change = exact(stroke.given.angle), arb(stroke.given.change)
        if angle <= start + length:
            x = arb((angle - start) / length)
            if stroke.law is None:
                return level
            piece = next(each for each in pieces_of(stroke.law) if not x > each.end)
            return level + change * piece.derivative(0, x)
        start, level = start + length, level + change
    raise AssertionError(angle)


def exact(value):
    return fmpq(*float(value).as_integer_ratio())


@precisely()
def wrong(seed):
    """What is wrong with the proof of a random band, if anything."""
    rng = np.random.default_rng(seed)
    laws = {name: law_at_random(rng, name) for name in ("up", "down")}
    rise, fall = (float(each) for each in rng.uniform(60.0, 150.0, 2))
    segments = [
        ("rise", rise, 20.0, "up"),
        ("return", fall, 20.0, "down"),
        ("dwell", 360.0 - rise - fall, 0.0, None),
    ]
    programme = Programme.from_segments(segments, angular=False, laws=laws)
    angles = np.sort(rng.uniform(0.0, 359.0, 12))
    near = np.array([float(motion_of(programme, exact(angle))) for angle in angles])
    lifts = near + rng.uniform(-0.01, 0.01, angles.size)
    points = MeasuredPoints("random", angles, lifts, np.arange(angles.size), 0.0)
    off = [motion_of(programme, exact(angle)) - arb(float(lift)) for angle, lift in zip(angles, lifts, strict=True)]
    largest = max((abs(each) for each in off), key=lambda each: float(each.mid()))
    for share, held in ((1e-12, True), (-1e-12, False)):
        found = certify_band(programme, points, 0.0, 0.0, float(largest) * (1.0 + share))
        if found.held is not held or not largest <= found.largest * (1 + 1e-15):
            return f"{seed}: the band is {held}"
        if any(abs(arb(one) - each) > 1e-15 for one, each in zip(found.at_points, off, strict=True)):
            return f"{seed}: a point"
    for low, high, one, other in zip(angles, angles[1:], lifts, lifts[1:], strict=False):
        for share in np.linspace(0.0, 1.0, SAMPLES):
            place = exact(low) + (exact(high) - exact(low)) * exact(share)
            line = arb(float(one)) + (arb(float(other)) - arb(float(one))) * arb(float(share))
            if abs(motion_of(programme, place) - line) > found.between:
                return f"{seed}: between points"
    return ""


@pytest.mark.parametrize("seed", range(6))
def test_a_band_is_proved_as_balls_have_it(seed):
    assert wrong(seed) == ""


@pytest.mark.long
def test_ten_thousand_bands_are_proved_as_balls_have_them():
    assert [text for seed in range(10_000) if (text := wrong(1_000 + seed))] == []

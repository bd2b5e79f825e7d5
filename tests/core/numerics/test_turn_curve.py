"""Piecewise polynomials over a turn: arithmetic against values at random angles, ranges against dense samples."""

import numpy as np
import pytest

from camopt.core.numerics.turn_curve import TURN, TurnCurve, sum_curves

SEEDS = range(12)


def random_curve(rng: np.random.Generator) -> TurnCurve:
    """A curve with jumps, on panels of random widths."""
    panels, powers = int(rng.integers(1, 9)), int(rng.integers(1, 14))
    ends = np.concatenate([[0.0], np.sort(rng.uniform(0.0, TURN, panels - 1)), [TURN]])
    return TurnCurve(ends, rng.normal(size=(powers, panels)) / (1.0 + np.arange(powers))[:, None] ** 2)


def difference(a, b) -> float:
    """Largest difference of values, but for one in a thousand, which may lie at jumps."""
    return float(np.quantile(np.abs(a - b), 0.999))


@pytest.mark.parametrize("seed", SEEDS)
def test_arithmetic_is_that_of_the_values(seed):
    rng = np.random.default_rng(seed)
    a, b, angles = random_curve(rng), random_curve(rng), rng.uniform(-9.0, 15.0, 5000)
    phase, turns, factor = rng.uniform(-9.0, 9.0), int(rng.integers(1, 5)), rng.normal()
    assert difference(a.shifted(phase).value(angles), a.value(angles - phase)) < 1e-11
    assert difference(a.sped_up(turns).value(angles), a.value(turns * angles)) < 1e-11
    assert difference((a * factor + b).value(angles), factor * a.value(angles) + b.value(angles)) < 1e-11
    assert difference((a * b).value(angles), a.value(angles) * b.value(angles)) < 1e-11
    assert difference(sum_curves([a, b, a]).value(angles), 2.0 * a.value(angles) + b.value(angles)) < 1e-11


@pytest.mark.parametrize("seed", SEEDS)
def test_ranges_enclose_all_values_closely(seed):
    rng = np.random.default_rng(seed)
    curve = random_curve(rng).shifted(rng.uniform(0.0, TURN))
    low = rng.uniform(-10.0, 10.0, 2000)
    high = low + rng.uniform(0.0, 1.0, 2000) ** 3 * TURN
    values = curve.value(low + np.linspace(0.0, 1.0, 101)[:, None] * (high - low))
    found = curve.range_over(low, high)
    assert (found.low <= values.min(axis=0) + 1e-13).all()
    assert (found.high >= values.max(axis=0) - 1e-13).all()
    narrow = curve.range_over(low, low + 1e-6)
    assert np.median(narrow.high - narrow.low) < 1e-4


@pytest.mark.parametrize("seed", SEEDS)
def test_extremes_mean_and_integral_agree_with_samples(seed):
    rng = np.random.default_rng(seed)
    curve = random_curve(rng).shifted(rng.uniform(0.0, TURN)) + random_curve(rng)
    angles = (np.arange(400_000) + 0.5) / 400_000 * TURN
    values, most, least = curve.value(angles), curve.largest(), curve.least()
    assert -1e-12 <= most.value - values.max() < 1e-3
    assert -1e-12 <= values.min() - least.value < 1e-3
    near = curve.value(np.array([most.angle - 1e-9, most.angle + 1e-9]))
    assert np.abs(near - most.value).min() < 1e-6
    assert curve.mean == pytest.approx(values.mean(), abs=1e-4)
    assert curve.rms == pytest.approx(np.sqrt(np.mean(values**2)), abs=1e-3)
    work = curve.plus_number(-curve.mean).integral_from_start()
    assert work.value(np.array([0.0, TURN - 1e-12])) == pytest.approx([0.0, 0.0], abs=1e-9)
    assert difference(work.derivative.value(angles), values - curve.mean) < 1e-10


def test_extreme_at_a_jump_is_found_from_either_side():
    step = TurnCurve(np.array([0.0, 1.0, TURN]), np.array([[0.0, 0.5], [1.0, 0.0]]))  # rises to 1, then 0.5
    found = step.shifted(0.3).largest()
    assert found.value == 1.0
    assert found.angle == pytest.approx(1.3)


@pytest.mark.parametrize("seed", SEEDS)
def test_extremes_over_a_range_agree_with_samples(seed):
    rng = np.random.default_rng(seed)
    curve, start, width = random_curve(rng), rng.uniform(-9.0, 9.0), rng.uniform(0.01, TURN)
    values = curve.value(start + width * (np.arange(200_000) + 0.5) / 200_000)
    most, least = curve.largest(start, width), curve.least(start, width)
    assert -1e-11 <= most.value - values.max() < 1e-3
    assert -1e-11 <= values.min() - least.value < 1e-3
    for extreme in (most, least):
        assert start <= extreme.angle <= start + width
        assert np.abs(curve.value(extreme.angle + np.array([-1e-9, 1e-9])) - extreme.value).min() < 1e-6


def test_the_extreme_of_a_part_is_at_its_end_however_near_an_end_of_a_panel():
    """A line from 0 to 1 in half a turn, and back."""
    saw = TurnCurve(np.array([0.0, np.pi, TURN]), np.array([[0.5, 0.5], [0.5, -0.5]]))
    for before in (1e-3, 1e-8, 1e-13, 0.0, -1e-13, -1e-8):
        most = saw.largest(1.0, np.pi - before - 1.0)
        assert most.value == pytest.approx(1.0 - max(before, 0.0) / np.pi, abs=1e-15)
        assert most.angle == pytest.approx(np.pi - max(before, 0.0), abs=1e-14)


@pytest.mark.parametrize("room", [0.0, 1e-16, 1e-15, 1e-14, 1e-13])
def test_a_curve_can_be_shifted_so_that_its_start_is_almost_an_end_of_a_panel(room):
    curve = random_curve(np.random.default_rng(3))
    angles = np.linspace(0.1, 6.0, 1000)
    for shift in (room, -room, *(curve.ends + room), *(room - curve.ends)):
        shifted = curve.shifted(shift)
        assert (shifted.half_width > 0.0).all()
        assert np.isfinite(shifted.error)
        assert difference(shifted.value(angles), curve.value(angles - shift)) < 1e-11

"""The climb to the maximum of a concave part of a panel: false position on the slope.

Where a curve is concave its maximum is at an end or at a root of the slope. Steps follow the Illinois method of
false position (Dowell and Jarratt, BIT 11, 1971), and end once slope²/(2·|f''|), a bound of what is still to be
gained, is small enough. Many designs climb at once, and begin at the peak of a cubic; one alone begins where the
chord of the slope is zero.
"""

from typing import NamedTuple

import numpy as np

from camopt.core.kernels.address_calls import call
from camopt.core.kernels.marks import called_by_kernels, inline_in_kernels
from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST
from camopt.core.numerics.jet import larger, select, smaller
from camopt.core.numerics.workspace import (
    AT,
    BEST,
    BOUND,
    CONCAVITY,
    EXACT,
    FALLING,
    GAIN,
    GRADIENT,
    HIGH,
    LOW,
    NEXT,
    RISING,
    SIDE,
    SLOPE,
    STATES,
    VALUE,
)

CLIMB_STEPS = 60


class PeakQuery(NamedTuple):
    """A question: the largest of sign·f, its allowed relative error, and that of its cam angle, rad, or inf.

    ``blur`` is the rounding error allowed of a part of a panel, relative; inf where that of the panel is as good.
    """

    sign: float
    relative_error: float
    location: float
    blur: float


class PanelPartEnds(NamedTuple):
    """A part of a panel, low ≤ u ≤ high: oriented values at its left and right end, and the slopes there."""

    low: float
    high: float
    left: float
    rising: float
    right: float
    falling: float


class Bracket(NamedTuple):
    """Where a slope falls through zero: its values at both ends as the Illinois method weighs them.

    ``side`` is 1 if the low end was moved last, −1 if the high one was, and 0 at first.
    """

    low: float
    high: float
    rising: float
    falling: float
    side: float


class ClimbGoal(NamedTuple):
    """When a climb may end: the value to beat, the gain and the slope that may remain."""

    best: float
    gain: float
    slope: float


@inline_in_kernels
def sign_range(goal):
    """The signs of ``PeakQuery`` that a goal needs: of (1, −1), first and last."""
    return (1 if goal == LEAST else 0), (1 if goal == LARGEST else 2)


@inline_in_kernels
def orient(value, goal):
    """The number whose maximum is the extreme asked for."""
    if goal == LARGEST_MAGNITUDE:
        return abs(value)
    return -value if goal == LEAST else value


@inline_in_kernels
def allowed_gain(best, relative_error, error):
    """The gain that may remain: below it an extreme is exact enough. At least rounding, if that is known."""
    return larger(0.5 * relative_error * abs(best), select(error < np.inf, error, 0.0))


@inline_in_kernels
def chord_root(bracket):
    """Where the chord of the slope passes through zero."""
    return bracket.low + (bracket.high - bracket.low) * (bracket.rising / (bracket.rising - bracket.falling))


@inline_in_kernels
def shrink_bracket(bracket, u, slope):
    """The bracket with u as one of its ends; if that end was moved before, the slope at the other one is halved."""
    up = slope > 0.0
    rising = select(bracket.side < 0.0, 0.5 * bracket.rising, bracket.rising)
    falling = select(bracket.side > 0.0, 0.5 * bracket.falling, bracket.falling)
    return Bracket(
        select(up, u, bracket.low),
        select(up, bracket.high, u),
        select(up, slope, rising),
        select(up, falling, slope),
        select(up, 1.0, -1.0),
    )


@inline_in_kernels
def remaining_gain(grade, bracket, half_width, concavity):
    """A bound of what the maximum is above a value whose slope has this magnitude."""
    return grade * smaller((bracket.high - bracket.low) * half_width, 0.5 * grade / concavity)


@inline_in_kernels
def cubic_peak(left, rising, right, falling, width):
    """The place in [0, 1] where the cubic through both ends and slopes is largest, given rising > 0 > falling."""
    mean = (right - left) / width
    linear, square = 6.0 * mean - 4.0 * rising - 2.0 * falling, 3.0 * (rising + falling - 2.0 * mean)
    return 2.0 * rising / (np.sqrt(larger(linear * linear - 4.0 * square * rising, 0.0)) - linear)


@called_by_kernels
def begin_climb(climbs, j, design, ends, half_width, concavity):
    """Fill a column of the table of climbs; uncompiled, some."""
    low, high, left, rising, right, falling = ends
    share = cubic_peak(left, rising, right, falling, (high - low) * half_width)
    hidden = (share <= 0.0) | (share >= 1.0) | (share != share)  # the cubic, by rounding of the values
    share = select(hidden, rising / (rising - falling), share)
    climbs.design[j] = design
    state = climbs.state
    state[NEXT, j] = low + (high - low) * share
    state[LOW, j], state[HIGH, j] = low, high
    state[RISING, j], state[FALLING, j], state[CONCAVITY, j] = rising, falling, concavity
    state[SIDE, j], state[BEST, j], state[AT, j] = 0.0, -np.inf, 0.0
    state[BOUND, j], state[SLOPE, j], state[EXACT, j] = np.inf, np.inf, 0.0


@called_by_kernels
def step_climbs(many, half_width, state):
    """One step of every climb, from the values and slopes just evaluated; no branches."""
    low, high, rising, falling, side = state[LOW], state[HIGH], state[RISING], state[FALLING], state[SIDE]
    best, at, bound, values, slopes = state[BEST], state[AT], state[BOUND], state[VALUE], state[GRADIENT]
    concavity, gain, steep, following = state[CONCAVITY], state[GAIN], state[SLOPE], state[NEXT]
    for j in range(np.uint64(many)):
        u, value, slope = following[j], values[j], slopes[j]
        bracket, grade = Bracket(low[j], high[j], rising[j], falling[j], side[j]), abs(slope)
        gain[j] = remaining_gain(grade, bracket, half_width, concavity[j])
        bound[j] = min(bound[j], value + gain[j])
        best[j] = max(value, best[j])
        at[j] = u if grade < steep[j] else at[j]  # values no longer tell points apart where the slope still does
        steep[j] = min(grade, steep[j])
        bracket = shrink_bracket(bracket, u, slope)
        low[j], high[j], rising[j], falling[j], side[j] = bracket
        following[j] = chord_root(bracket)


@step_climbs.array_version
def _step_climbs_in_python(many, half_width, state):
    u, value, slope, concavity = (state[row, :many] for row in (NEXT, VALUE, GRADIENT, CONCAVITY))
    bracket, grade = Bracket(*(state[row, :many] for row in (LOW, HIGH, RISING, FALLING, SIDE))), abs(slope)
    best, at, bound, steep = (state[row, :many] for row in (BEST, AT, BOUND, SLOPE))
    state[GAIN, :many] = gain = remaining_gain(grade, bracket, half_width, concavity)
    bound[:] = smaller(bound, value + gain)
    best[:] = larger(value, best)
    at[:] = select(grade < steep, u, at)
    steep[:] = smaller(grade, steep)
    bracket = shrink_bracket(bracket, u, slope)
    for row, values in zip((LOW, HIGH, RISING, FALLING, SIDE), bracket, strict=True):
        state[row, :many] = values
    state[NEXT, :many] = chord_root(bracket)


@called_by_kernels
def update_climbs(many, place, errors, last, ask, found, climbs):
    """Take the results of climbs, and keep the unfinished ones; returns their number.

    ``place`` is (centre, half-width) of the panel, ``errors`` those of the designs in it.
    """
    still, state = 0, climbs.state
    for j in range(many):
        i = climbs.design[j]
        if state[BEST, j] >= found.best[i] - errors[i]:  # the place is better known than that of a node
            found.best[i] = found.best[i] if state[EXACT, j] else max(found.best[i], state[BEST, j])
            found.at[i] = place[0] + place[1] * state[AT, j]
        near = state[SLOPE, j] <= ask.location * state[CONCAVITY, j]
        exact = state[EXACT, j] > 0.0 or state[GAIN, j] <= allowed_gain(
            found.best[i], ask.relative_error, errors[i]
        )
        lost = state[BOUND, j] < found.best[i] - errors[i]
        if (exact and near) or lost or last:
            found.top[i] = max(found.top[i], state[BOUND, j])
        else:
            state[EXACT, j] = exact
            for k in range(STATES):
                state[k, still] = state[k, j]
            climbs.design[still] = i
            still += 1
    return still


@update_climbs.array_version
def _update_climbs_in_python(many, place, errors, last, ask, found, climbs):
    i, state = climbs.design[:many], climbs.state[:STATES, :many]
    if np.any(i[1:] == i[:-1]):  # both halves of a panel: the second is held against what the first has found
        return update_climbs.py_func(many, place, errors, last, ask, found, climbs)
    error, better = errors[i], state[BEST] >= found.best[i] - errors[i]
    best = np.where(better & (state[EXACT] == 0.0), larger(found.best[i], state[BEST]), found.best[i])
    found.best[i], found.at[i] = best, np.where(better, place[0] + place[1] * state[AT], found.at[i])
    near = state[SLOPE] <= ask.location * state[CONCAVITY]
    exact = (state[EXACT] > 0.0) | (state[GAIN] <= allowed_gain(best, ask.relative_error, error))
    ended = (exact & near) | (state[BOUND] < best - error) | last
    top, still = larger(found.top[i], state[BOUND]), np.flatnonzero(~ended)
    found.top[i[ended]], state[EXACT] = top[ended], exact
    climbs.design[: still.size], state[:, : still.size] = i[still], state[:, still]
    return still.size


@inline_in_kernels
def climb_all(curve, first, many, panels, panel, ask, work):
    """Climb to the maximum of every concave part at once. The table loses what has ended.

    A value that is exact enough stays as it is while the climb goes on to find its place: whether somebody asks for
    the place does not change a digit of the value.
    """
    place, errors, climbs = (panels.centre[panel], panels.half_width[panel]), work.bounds.error[panel], work.climbs
    state = climbs.state
    for step in range(CLIMB_STEPS):
        if many == 0:
            break
        there = (curve.made, panel, state[NEXT], ask.sign, first, climbs.design, many, state[VALUE:])
        call(curve.panel, there)
        step_climbs(many, place[1], state)
        many = update_climbs(many, place, errors, step == CLIMB_STEPS - 1, ask, work.found, climbs)


@inline_in_kernels
def climb(curve, design, panels, panel, ends, concavity, sign, aim):
    """As ``climb_all``, for one design: (largest value, where in the panel, bound of the maximum)."""
    bracket = Bracket(ends.low, ends.high, ends.rising, ends.falling, 0.0)
    largest, at, bound, flattest, exact = -np.inf, ends.low, np.inf, np.inf, False
    half_width = panels.half_width[panel]
    for _ in range(CLIMB_STEPS):
        u = chord_root(bracket)
        value, slope = call(curve.point, (curve.made, panel, u, sign, design))
        largest = largest if exact else max(largest, value)
        grade = abs(slope)
        if grade < flattest:
            flattest, at = grade, u
        gain = remaining_gain(grade, bracket, half_width, concavity)
        bound = min(bound, value + gain)
        exact = exact or gain <= aim.gain
        if bound < aim.best or (exact and grade <= aim.slope):
            break
        bracket = shrink_bracket(bracket, u, slope)
    return largest, at, max(bound, largest)

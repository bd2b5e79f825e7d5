"""The climb to the maximum of a concave part of a panel, by false position on the slope.

In a concave part the maximum is at an end or at a root of the slope. Steps follow the Illinois method of false
position (Dowell and Jarratt, BIT 11, 1971). They end when slope²/(2·|f''|), a bound of the remaining gain, is small
enough. Many designs climb at once, from the peak of a cubic; a single design starts where the chord of the slope is
zero.
"""

from typing import NamedTuple

import numpy as np

from camopt.core.kernels.address_calls import call_by_address
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
    """A question: the largest sign·f, its allowed relative error, and that of its cam angle [rad], or inf.

    ``blur`` is the allowed relative rounding error of a part of a panel, or inf if the panel's own is good enough.
    """

    sign: float
    relative_error: float
    location: float
    blur: float


class PanelPartEnds(NamedTuple):
    """A part low ≤ u ≤ high of a panel: oriented values at its left and right ends, and the slopes there."""

    low: float
    high: float
    left: float
    rising: float
    right: float
    falling: float


class Bracket(NamedTuple):
    """An interval in which a slope falls through zero, and the slopes at its ends, weighted by the Illinois method.

    ``side`` is 1 if the low end was moved last, −1 if the high end was, and 0 at first.
    """

    low: float
    high: float
    rising: float
    falling: float
    side: float


class ClimbGoal(NamedTuple):
    """End of a climb: the value to beat, and the gain and slope that may remain."""

    best: float
    gain: float
    slope: float


@inline_in_kernels
def range_of_search_signs(extreme_kind):
    """Range of the signs (1, −1) of ``PeakQuery`` that a goal needs."""
    return (1 if extreme_kind == LEAST else 0), (1 if extreme_kind == LARGEST else 2)


@inline_in_kernels
def orient_to_maximum(value, extreme_kind):
    """The value with the sign with which the goal is a maximum."""
    if extreme_kind == LARGEST_MAGNITUDE:
        return abs(value)
    return -value if extreme_kind == LEAST else value


@inline_in_kernels
def allowed_gain(best, relative_error, rounding_error):
    """Gain that may remain at an extreme that is exact enough; at least the rounding error, if known."""
    return larger(0.5 * relative_error * abs(best), select(rounding_error < np.inf, rounding_error, 0.0))


@inline_in_kernels
def chord_root(bracket):
    """The u at which the chord of the slope is zero."""
    return bracket.low + (bracket.high - bracket.low) * (bracket.rising / (bracket.rising - bracket.falling))


@inline_in_kernels
def shrink_illinois_bracket(bracket, u, slope):
    """The bracket with u as an end. If the same end was moved before, the slope at the other end is halved."""
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
def remaining_gain_bound(slope_magnitude, bracket, half_width, concavity):
    """Bound of the maximum less a value whose slope has the magnitude ``slope_magnitude``."""
    return slope_magnitude * smaller((bracket.high - bracket.low) * half_width, 0.5 * slope_magnitude / concavity)


@inline_in_kernels
def cubic_peak_place(left, rising, right, falling, width):
    """Place in [0, 1] of the maximum of the cubic through both ends and slopes, with rising > 0 > falling."""
    mean = (right - left) / width
    linear, square = 6.0 * mean - 4.0 * rising - 2.0 * falling, 3.0 * (rising + falling - 2.0 * mean)
    return 2.0 * rising / (np.sqrt(larger(linear * linear - 4.0 * square * rising, 0.0)) - linear)


@called_by_kernels
def begin_climb(climbs, column, design, ends, half_width, concavity):
    """Fill a column of the table of climbs; uncompiled, several columns."""
    low, high, left, rising, right, falling = ends
    share = cubic_peak_place(left, rising, right, falling, (high - low) * half_width)
    hidden = (share <= 0.0) | (share >= 1.0) | (share != share)  # rounding of the values hides the cubic's peak
    share = select(hidden, rising / (rising - falling), share)
    climbs.design[column] = design
    state = climbs.state
    state[NEXT, column] = low + (high - low) * share
    state[LOW, column], state[HIGH, column] = low, high
    state[RISING, column], state[FALLING, column], state[CONCAVITY, column] = rising, falling, concavity
    state[SIDE, column], state[BEST, column], state[AT, column] = 0.0, -np.inf, 0.0
    state[BOUND, column], state[SLOPE, column], state[EXACT, column] = np.inf, np.inf, 0.0


@called_by_kernels
def step_climbs(climb_count, half_width, climb_states):
    """Do one step of every climb, from new values and slopes, without branches."""
    low, high, rising, falling, side = (
        climb_states[LOW],
        climb_states[HIGH],
        climb_states[RISING],
        climb_states[FALLING],
        climb_states[SIDE],
    )
    best, at, bound, values, slopes = (
        climb_states[BEST],
        climb_states[AT],
        climb_states[BOUND],
        climb_states[VALUE],
        climb_states[GRADIENT],
    )
    concavity, gain, steep, following = (
        climb_states[CONCAVITY],
        climb_states[GAIN],
        climb_states[SLOPE],
        climb_states[NEXT],
    )
    for j in range(np.uint64(climb_count)):
        u, value, slope = following[j], values[j], slopes[j]
        bracket, grade = Bracket(low[j], high[j], rising[j], falling[j], side[j]), abs(slope)
        gain[j] = remaining_gain_bound(grade, bracket, half_width, concavity[j])
        bound[j] = min(bound[j], value + gain[j])
        best[j] = max(value, best[j])
        at[j] = u if grade < steep[j] else at[j]  # near the top the slope tells points apart, values do not
        steep[j] = min(grade, steep[j])
        bracket = shrink_illinois_bracket(bracket, u, slope)
        low[j], high[j], rising[j], falling[j], side[j] = bracket
        following[j] = chord_root(bracket)


@step_climbs.array_version
def _step_climbs_in_python(climb_count, half_width, climb_states):
    u, value, slope, concavity = (climb_states[row, :climb_count] for row in (NEXT, VALUE, GRADIENT, CONCAVITY))
    bracket, grade = (
        Bracket(*(climb_states[row, :climb_count] for row in (LOW, HIGH, RISING, FALLING, SIDE))),
        abs(slope),
    )
    best, at, bound, steep = (climb_states[row, :climb_count] for row in (BEST, AT, BOUND, SLOPE))
    climb_states[GAIN, :climb_count] = gain = remaining_gain_bound(grade, bracket, half_width, concavity)
    bound[:] = smaller(bound, value + gain)
    best[:] = larger(value, best)
    at[:] = select(grade < steep, u, at)
    steep[:] = smaller(grade, steep)
    bracket = shrink_illinois_bracket(bracket, u, slope)
    for row, values in zip((LOW, HIGH, RISING, FALLING, SIDE), bracket, strict=True):
        climb_states[row, :climb_count] = values
    climb_states[NEXT, :climb_count] = chord_root(bracket)


@called_by_kernels
def keep_unfinished_climbs(climb_count, centre_and_half_width, errors, is_last_step, query, tile_extremes, climbs):
    """Store the results of climbs and keep the unfinished ones; return their number.

    ``centre_and_half_width`` is (centre, half-width) of the panel; ``errors`` are the designs' rounding errors in
    it.
    """
    still, state = 0, climbs.state
    for j in range(climb_count):
        i = climbs.design[j]
        if state[BEST, j] >= tile_extremes.best[i] - errors[i]:  # its place is more exact than a node
            tile_extremes.best[i] = (
                tile_extremes.best[i] if state[EXACT, j] else max(tile_extremes.best[i], state[BEST, j])
            )
            tile_extremes.at[i] = centre_and_half_width[0] + centre_and_half_width[1] * state[AT, j]
        near = state[SLOPE, j] <= query.location * state[CONCAVITY, j]
        exact = state[EXACT, j] > 0.0 or state[GAIN, j] <= allowed_gain(
            tile_extremes.best[i], query.relative_error, errors[i]
        )
        lost = state[BOUND, j] < tile_extremes.best[i] - errors[i]
        if (exact and near) or lost or is_last_step:
            tile_extremes.top[i] = max(tile_extremes.top[i], state[BOUND, j])
        else:
            state[EXACT, j] = exact
            for k in range(STATES):
                state[k, still] = state[k, j]
            climbs.design[still] = i
            still += 1
    return still


@keep_unfinished_climbs.array_version
def _keep_unfinished_climbs_in_python(
    climb_count, centre_and_half_width, errors, is_last_step, query, tile_extremes, climbs
):
    i, state = climbs.design[:climb_count], climbs.state[:STATES, :climb_count]
    if np.any(i[1:] == i[:-1]):  # both halves of a panel climb: the second needs the result of the first
        return keep_unfinished_climbs.py_func(
            climb_count, centre_and_half_width, errors, is_last_step, query, tile_extremes, climbs
        )
    error, better = errors[i], state[BEST] >= tile_extremes.best[i] - errors[i]
    best = np.where(
        better & (state[EXACT] == 0.0), larger(tile_extremes.best[i], state[BEST]), tile_extremes.best[i]
    )
    tile_extremes.best[i], tile_extremes.at[i] = (
        best,
        np.where(better, centre_and_half_width[0] + centre_and_half_width[1] * state[AT], tile_extremes.at[i]),
    )
    near = state[SLOPE] <= query.location * state[CONCAVITY]
    exact = (state[EXACT] > 0.0) | (state[GAIN] <= allowed_gain(best, query.relative_error, error))
    ended = (exact & near) | (state[BOUND] < best - error) | is_last_step
    top, still = larger(tile_extremes.top[i], state[BOUND]), np.flatnonzero(~ended)
    tile_extremes.top[i[ended]], state[EXACT] = top[ended], exact
    climbs.design[: still.size], state[:, : still.size] = i[still], state[:, still]
    return still.size


@inline_in_kernels
def climb_all_concave_parts(curve, first_design, climb_count, panels, panel, query, workspace):
    """Climb to the maxima of all concave parts at once. Finished climbs leave the table.

    A value that is exact enough is fixed, while the climb goes on to find its place. So the value has the same
    digits whether its place is wanted or not.
    """
    place, errors, climbs = (
        (panels.centre[panel], panels.half_width[panel]),
        workspace.bounds.error[panel],
        workspace.climbs,
    )
    state = climbs.state
    for step in range(CLIMB_STEPS):
        if climb_count == 0:
            break
        there = (
            curve.source,
            panel,
            state[NEXT],
            query.sign,
            first_design,
            climbs.design,
            climb_count,
            state[VALUE:],
        )
        call_by_address(curve.panel, there)
        step_climbs(climb_count, place[1], state)
        climb_count = keep_unfinished_climbs(
            climb_count, place, errors, step == CLIMB_STEPS - 1, query, workspace.found, climbs
        )


@inline_in_kernels
def climb_concave_part(curve, design, panels, panel, ends, concavity, sign, climb_goal):
    """Climb for one design; return the largest value, its u in the panel, and a bound of the maximum."""
    bracket = Bracket(ends.low, ends.high, ends.rising, ends.falling, 0.0)
    largest, at, bound, flattest, exact = -np.inf, ends.low, np.inf, np.inf, False
    half_width = panels.half_width[panel]
    for _ in range(CLIMB_STEPS):
        u = chord_root(bracket)
        value, slope = call_by_address(curve.point, (curve.source, panel, u, sign, design))
        largest = largest if exact else max(largest, value)
        grade = abs(slope)
        if grade < flattest:
            flattest, at = grade, u
        gain = remaining_gain_bound(grade, bracket, half_width, concavity)
        bound = min(bound, value + gain)
        exact = exact or gain <= climb_goal.gain
        if bound < climb_goal.best or (exact and grade <= climb_goal.slope):
            break
        bracket = shrink_illinois_bracket(bracket, u, slope)
    return largest, at, max(bound, largest)

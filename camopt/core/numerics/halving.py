"""Classify parts of a panel: a part that is not settled is halved."""

import numpy as np

from camopt.core.kernels.address_calls import call_by_address
from camopt.core.kernels.marks import called_by_kernels, inline_in_kernels
from camopt.core.numerics.climbing import ClimbGoal, PanelPartEnds, allowed_gain, climb_concave_part
from camopt.core.numerics.jet import infinite_if_nan, larger, select, smaller
from camopt.core.numerics.workspace import DEPTH

PANEL_PARTS = 4096  # most parts of one panel, before it stays undecided
POINT_WIDTH = 2.0**-40  # share of a panel that is so short that its rounding error is that of a point
CONCAVE, CLIMBS, SETTLED, UNSETTLED = 0, 1, 2, 3


@inline_in_kernels
def largest_gain_by_quadratic_slope(slope, bend, curl, width):
    """Largest gain over the end of a part, where the slope is at most slope + bend·t − curl·t².

    A slope differs from its chord by at most |f'''|·t·(width − t)/2. Where a curve starts level, as at the end of a
    dwell, this bound is far closer than that by the second derivative.
    """
    root, falls = np.sqrt(larger(bend * bend + 4.0 * curl * slope, 0.0)), bend < 0.0
    t = select(falls, 2.0 * slope, bend + root) / select(falls, root - bend, 2.0 * curl)
    t = smaller(larger(t, 0.0), width)
    gain = t * (slope + t * (0.5 * bend - t * curl / 3.0))
    return select((curl < np.inf) & (gain == gain), larger(gain, 0.0), np.inf)


@called_by_kernels
def classify_and_bound_part(ends, third_derivative_bound, half_width, settling_bound):
    """Classify a part by end values, slopes and |f'''|; return verdict, bound of values, lower bound of −f''.

    Uncompiled, it takes many parts.
    """
    low, high, left, rising, right, falling = ends
    width = (high - low) * half_width
    bend = (falling - rising) / width  # a mean of f''
    room = 0.5 * third_derivative_bound * width  # largest difference of f'' from the mean
    concave, most, curl = bend + room <= 0.0, larger(left, right), 0.5 * third_derivative_bound
    climbs = select((rising > 0.0) & (falling < 0.0), CLIMBS, CONCAVE)
    if np.all(concave):
        return climbs, most, -(bend + room)
    bound = select(concave, most, most + 0.125 * larger(room - bend, 0.0) * width * width)
    if np.any(bound > settling_bound):
        ascent = largest_gain_by_quadratic_slope(rising, bend + room, curl, width)
        descent = largest_gain_by_quadratic_slope(-falling, bend + room, curl, width)
        bound = select(
            bound > settling_bound,
            smaller(bound, larger(most, smaller(left + ascent, right + descent))),
            bound,
        )
    verdict = select(concave, climbs, select(bound <= settling_bound, SETTLED, UNSETTLED))
    return verdict, bound, select(concave, -(bend + room), 0.0)


@called_by_kernels
def write_part_ends(row, ends):
    """Write the ends of a part into a row of a table."""
    row[0], row[1], row[2], row[3], row[4], row[5] = ends


@called_by_kernels
def read_part_ends(row):
    """Read the ends of a part from a row of a table."""
    return PanelPartEnds(row[0], row[1], row[2], row[3], row[4], row[5])


@called_by_kernels
def upper_bound_by_slope(bounds, ends, sign, half_width):
    """Bound of the values in a part from the range of its slope; close where the curve is level or monotone."""
    rise = infinite_if_nan((bounds.most_slope if sign > 0.0 else -bounds.least_slope) + bounds.slope_error)
    drop = infinite_if_nan((-bounds.least_slope if sign > 0.0 else bounds.most_slope) + bounds.slope_error)
    width = (ends.high - ends.low) * half_width
    most = max(ends.left, ends.right)
    return min(max(most, ends.left + rise * width), max(most, ends.right + drop * width))


@inline_in_kernels
def closer_upper_bound_by_jet(bound, bounds, ends, sign, half_width):
    """Closer bound of the values in a part from its own jet."""
    width, ends_most = 0.5 * (ends.high - ends.low) * half_width, larger(ends.left, ends.right)
    bound = smaller(bound, ends_most + 0.5 * infinite_if_nan(bounds.second) * (width * width))
    most = bounds.high if sign > 0.0 else -bounds.low  # at a corner of the curve only its range is known
    return select(bound < np.inf, bound, select(most == most, most, np.inf))


@called_by_kernels
def has_excess_rounding_error(rounding_error, bound, best, query):
    """Whether a part may exceed the best value and has a larger rounding error than allowed."""
    return (query.blur < np.inf) & (rounding_error > query.blur * abs(best)) & (bound + rounding_error > best)


@called_by_kernels
def search_part_by_halving(curve, design, panels, panel, error, query, best, stack):
    """Halve a part until it is settled; return its largest value, the place, a bound of its values, their error.

    The part is the first row of the stack. The range of its slope is tried first, then its jets, then its halves
    and so on. ``error`` is the rounding error of the panel, infinite where a denominator may be zero in it; the
    error of a part replaces it. If one part has no bound, the whole has none, and halving stops. With
    ``query.blur``, parts are also halved until their rounding error is small enough, as far as halving helps. Only
    the errors of parts that may exceed the best value count.
    """
    half_width = panels.half_width[panel]
    whole = call_by_address(curve.part, (curve.source, panel, 0.0, 1.0, design))
    bound = upper_bound_by_slope(whole, read_part_ends(stack[0]), query.sign, half_width)
    if bound <= best + allowed_gain(best, query.relative_error, error) and not has_excess_rounding_error(
        error, bound, best, query
    ):
        return -np.inf, 0.0, bound, error if bound + error > best else 0.0
    largest, at, top, rounding = -np.inf, 0.0, best, 0.0
    depth, parts = 1, 0
    while depth > 0:
        depth, parts = depth - 1, parts + 1
        ends = read_part_ends(stack[depth])
        middle = 0.5 * (ends.low + ends.high)
        bounds = call_by_address(curve.part, (curve.source, panel, middle, 0.5 * (ends.high - ends.low), design))
        part_error = min(error, bounds.error)
        gain = allowed_gain(best, query.relative_error, part_error)
        verdict, bound, concavity = classify_and_bound_part(ends, bounds.third, half_width, best + gain)
        if verdict == UNSETTLED:
            bound = closer_upper_bound_by_jet(bound, bounds, ends, query.sign, half_width)
        more = verdict == UNSETTLED and bound > best + gain
        if not more and has_excess_rounding_error(part_error, np.inf if verdict == CLIMBS else bound, best, query):
            # halving reduces the error only where it is far larger than that of a point
            more = (
                part_error
                > 2.0 * call_by_address(curve.part, (curve.source, panel, middle, POINT_WIDTH, design)).error
            )
        if more and parts < PANEL_PARTS and depth + 2 <= DEPTH and top < np.inf:
            value, slope = call_by_address(curve.point, (curve.source, panel, middle, query.sign, design))
            if value > best:
                best, largest, at = value, value, middle
            write_part_ends(stack[depth], PanelPartEnds(ends.low, middle, ends.left, ends.rising, value, slope))
            write_part_ends(
                stack[depth + 1], PanelPartEnds(middle, ends.high, value, slope, ends.right, ends.falling)
            )
            depth += 2
            continue
        if verdict == CLIMBS:
            aim = ClimbGoal(best, gain, query.location * concavity)
            value, u, bound = climb_concave_part(curve, design, panels, panel, ends, concavity, query.sign, aim)
            if value > best:
                best, largest, at = value, value, u
        top = max(top, bound)
        rounding = max(rounding, part_error) if bound + part_error > best else rounding
    return largest, at, top, rounding

"""Within one panel: whether a part is settled, the climb to a maximum, and the last resort of halving.

Where the curve is concave its maximum is at an end or at a root of the slope; a bracketed secant climbs to it until
slope²/(2·|f''|), which bounds what is still to be gained, is small enough.
"""

import numpy as np

from camopt.numerics import LARGEST_MAGNITUDE, LEAST
from camopt.numerics.compile import called, inlined
from camopt.numerics.curves import curve
from camopt.numerics.jet import known
from camopt.numerics.piecewise import motion, part_jets, row_jets

DEPTH = 50  # halvings of a panel
MOST_PARTS = 4096  # looked at in one panel, before it stays undecided
MOST_STEPS = 60

# rows of the scratch table, one column for each climb that goes on
LOW, HIGH, RISING, FALLING, SIDE, BEST, AT, BOUND, CONCAVITY, GAIN, SLOPE, NEXT, EXACT, SCRATCH = range(14)
CONCAVE, CLIMBS, SETTLED, OPEN = 0, 1, 2, 3


@inlined
def orient(value, goal):
    """The number whose maximum is the extreme asked for."""
    if goal == LARGEST_MAGNITUDE:
        return abs(value)
    return -value if goal == LEAST else value


@inlined
def oriented(f, i, y, y1, y2, y3, sign):
    """Oriented value and slope of design i."""
    value, slope = curve(f, i, y, y1, y2, y3)
    return sign * value, sign * slope


@inlined
def allowed(best, tolerance, error):
    """The gain that may be left: below it an extreme is exact enough. No less than rounding where that is known."""
    return max(0.5 * tolerance * abs(best), error if error < np.inf else 0.0)


@inlined
def most_ascent(slope, bend, curl, width):
    """The largest gain over an end of a part from which the slope is at most slope + bend·t − curl·t².

    The slope of a curve leaves its chord by no more than |f'''|·t·(width − t)/2. Where a curve starts level, as
    at the end of a dwell, this is far closer than what the second derivative says.
    """
    if not curl < np.inf:
        return np.inf
    root = np.sqrt(max(bend * bend + 4.0 * curl * slope, 0.0))
    t = 2.0 * slope / (root - bend) if bend < 0.0 else (bend + root) / (2.0 * curl)
    t = min(max(t, 0.0), width)
    gain = t * (slope + t * (0.5 * bend - t * curl / 3.0))
    return max(gain, 0.0) if gain == gain else np.inf


@inlined
def looked_at(low, high, left, rising, right, falling, third, half_width, enough):
    """What end values, slopes and |f'''| say of a part: (verdict, bound of its values, lower bound of −f'')."""
    width = (high - low) * half_width
    bend = (falling - rising) / width  # a mean of f''
    room = 0.5 * third * width  # and how far f'' may be from it
    ends = max(left, right)
    if bend + room <= 0.0:
        return (CLIMBS if rising > 0.0 and falling < 0.0 else CONCAVE), ends, -(bend + room)
    bound = ends + 0.125 * max(room - bend, 0.0) * width * width
    if bound > enough:
        ascent = most_ascent(rising, bend + room, 0.5 * third, width)
        descent = most_ascent(-falling, bend + room, 0.5 * third, width)
        bound = min(bound, max(ends, min(left + ascent, right + descent)))
    return (SETTLED if bound <= enough else OPEN), bound, 0.0


@inlined
def cubic_peak(left, rising, right, falling, width):
    """Where in [0, 1] the cubic through both ends and their slopes is largest, given rising > 0 > falling."""
    mean = (right - left) / width
    linear, square = 6.0 * mean - 4.0 * rising - 2.0 * falling, 3.0 * (rising + falling - 2.0 * mean)
    return 2.0 * rising / (np.sqrt(max(linear * linear - 4.0 * square * rising, 0.0)) - linear)


@inlined
def begin_climb(scratch, j, part, half_width, concavity):
    """Fill a column of the scratch table."""
    low, high, left, rising, right, falling = part
    share = cubic_peak(left, rising, right, falling, (high - low) * half_width)
    if not 0.0 < share < 1.0:  # rounding of the values hides the cubic
        share = rising / (rising - falling)
    scratch[NEXT, j] = low + (high - low) * share
    scratch[LOW, j], scratch[HIGH, j] = low, high
    scratch[RISING, j], scratch[FALLING, j], scratch[CONCAVITY, j] = rising, falling, concavity
    scratch[SIDE, j], scratch[BEST, j], scratch[AT, j] = 0.0, -np.inf, 0.0
    scratch[BOUND, j], scratch[SLOPE, j], scratch[EXACT, j] = np.inf, np.inf, 0.0


@inlined
def step_all(f, first, index, many, table, panel, sign, scratch):
    """One step of every climb: to the peak of a cubic, then Illinois false position on the slope; no branches."""
    half_width = table.half_width[panel]
    low, high, rising, falling = scratch[LOW], scratch[HIGH], scratch[RISING], scratch[FALLING]
    side, best, at, bound = scratch[SIDE], scratch[BEST], scratch[AT], scratch[BOUND]
    concavity, gain, steep, following = scratch[CONCAVITY], scratch[GAIN], scratch[SLOPE], scratch[NEXT]
    for j in range(np.uint64(many)):
        u = following[j]
        y, y1, y2, y3 = motion(table, panel, u)
        value, slope = oriented(f, np.uint64(first + index[j]), y, y1, y2, y3, sign)
        grade = abs(slope)
        gain[j] = grade * min((high[j] - low[j]) * half_width, 0.5 * grade / concavity[j])
        bound[j] = min(bound[j], value + gain[j])
        best[j] = max(value, best[j])
        at[j] = u if grade < steep[j] else at[j]  # values no longer tell points apart where the slope still does
        steep[j] = min(grade, steep[j])
        up = slope > 0.0
        low[j] = u if up else low[j]
        high[j] = high[j] if up else u
        # twice the same side: the weight of the other halves
        rising_left = 0.5 * rising[j] if side[j] < 0.0 else rising[j]
        falling_left = 0.5 * falling[j] if side[j] > 0.0 else falling[j]
        rising[j] = slope if up else rising_left
        falling[j] = falling_left if up else slope
        side[j] = 1.0 if up else -1.0
        following[j] = low[j] + (high[j] - low[j]) * (rising[j] / (rising[j] - falling[j]))


@inlined
def climb_all(f, first, index, many, table, panel, error, sign, tolerance, location, best, at, top, scratch):
    """Climb to the maximum of every concave part at once. ``index`` and the scratch table lose what has ended.

    A value that is exact enough stays as it is while the climb goes on to find its place: whether somebody asks for
    the place does not change a digit of the value.
    """
    for step in range(MOST_STEPS):
        if many == 0:
            break
        step_all(f, first, index, many, table, panel, sign, scratch)
        still = 0
        for j in range(many):
            i = index[j]
            if scratch[BEST, j] >= best[i] - error[panel, i]:  # the place is better known than that of a node
                best[i] = best[i] if scratch[EXACT, j] else max(best[i], scratch[BEST, j])
                at[i] = table.centre[panel] + table.half_width[panel] * scratch[AT, j]
            near = scratch[SLOPE, j] <= location * scratch[CONCAVITY, j]
            exact = scratch[EXACT, j] > 0.0 or scratch[GAIN, j] <= allowed(best[i], tolerance, error[panel, i])
            lost = scratch[BOUND, j] < best[i] - error[panel, i]
            if (exact and near) or lost or step == MOST_STEPS - 1:
                top[i] = max(top[i], scratch[BOUND, j])
            else:
                scratch[EXACT, j] = exact
                for k in range(SCRATCH):
                    scratch[k, still] = scratch[k, j]
                index[still] = i
                still += 1
        many = still


@called
def climb(f, i, table, panel, part, concavity, sign, best, allowance, location):
    """As ``climb_all``, for one design: (largest value, where in the panel, bound of the maximum)."""
    low, high, _, rising, _, falling = part
    side, largest, at, bound, flattest, exact = 0, -np.inf, low, np.inf, np.inf, False
    half_width = table.half_width[panel]
    for _ in range(MOST_STEPS):
        u = low + (high - low) * (rising / (rising - falling))
        y, y1, y2, y3 = motion(table, panel, u)
        value, slope = oriented(f, i, y, y1, y2, y3, sign)
        largest = largest if exact else max(largest, value)
        if abs(slope) < flattest:
            flattest, at = abs(slope), u
        gain = abs(slope) * min((high - low) * half_width, 0.5 * abs(slope) / concavity)
        bound = min(bound, value + gain)
        exact = exact or gain <= allowance
        if bound < best or (exact and abs(slope) <= location * concavity):
            break
        if slope > 0.0:
            low, rising, falling = u, slope, 0.5 * falling if side == 1 else falling
            side = 1
        else:
            high, falling, rising = u, slope, 0.5 * rising if side == -1 else rising
            side = -1
    return largest, at, max(bound, largest)


@inlined
def bound_by_slope(slope, part, sign, half_width):
    """A bound of the values in a part from the range of the slope: close where the curve is level or monotone."""
    low, high, left, _, right, _ = part
    rise = known((slope.high if sign > 0.0 else -slope.low) + slope.error)
    drop = known((-slope.low if sign > 0.0 else slope.high) + slope.error)
    width = (high - low) * half_width
    return min(max(left, right, left + rise * width), max(left, right, right + drop * width))


@called
def split(f, i, table, panel, part, error, sign, tolerance, location, best, stack):
    """Largest value found in a part that is not settled at once, where, a bound of all its values, and their error.

    The range of its slope comes first, then jets of its own, then its halves, and theirs. ``error`` is that of the
    panel; infinite where a denominator may be zero somewhere in it. The error of a part takes its place.
    Once a part is left without a bound, so are all, and nothing more is halved.
    """
    y, y1, y2, y3 = row_jets(table, panel)
    bound = bound_by_slope(curve(f, i, y, y1, y2, y3)[1], part, sign, table.half_width[panel])
    if bound <= best + allowed(best, tolerance, error):
        return -np.inf, 0.0, bound, error
    largest, at, top, rounding = -np.inf, 0.0, best, 0.0
    half_width = table.half_width[panel]
    stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3], stack[0, 4], stack[0, 5] = part
    depth, parts = 1, 0
    while depth > 0:
        depth -= 1
        parts += 1
        low, high, left, rising, right, falling = (
            stack[depth, 0], stack[depth, 1], stack[depth, 2], stack[depth, 3], stack[depth, 4], stack[depth, 5],
        )  # fmt: skip
        middle, reach = 0.5 * (low + high), 0.5 * (high - low)
        y, y1, y2, y3 = part_jets(table, panel, middle, reach)
        jet = curve(f, i, y, y1, y2, y3)[0]
        own = min(error, known(jet.error))
        allowance = allowed(best, tolerance, own)
        verdict, bound, concavity = looked_at(
            low, high, left, rising, right, falling, known(jet.third), half_width, best + allowance
        )
        if verdict == CLIMBS:
            part = (low, high, left, rising, right, falling)
            value, u, bound = climb(f, i, table, panel, part, concavity, sign, best, allowance, location)
            if value > best:
                best, largest, at = value, value, u
        elif verdict == OPEN:
            bound = min(bound, max(left, right) + 0.5 * known(jet.second) * (reach * half_width) ** 2)
            if not bound < np.inf:  # a corner of the curve: its range is what is known
                bound = jet.high if sign > 0.0 else -jet.low
            if bound > best + allowance and parts < MOST_PARTS and depth + 2 <= DEPTH and top < np.inf:
                y, y1, y2, y3 = motion(table, panel, middle)
                value, slope = oriented(f, i, y, y1, y2, y3, sign)
                if value > best:
                    best, largest, at = value, value, middle
                one, two = stack[depth], stack[depth + 1]
                one[0], one[1], one[2], one[3], one[4], one[5] = low, middle, left, rising, value, slope
                two[0], two[1], two[2], two[3], two[4], two[5] = middle, high, value, slope, right, falling
                depth += 2
                continue
        top, rounding = max(top, bound), max(rounding, own)
    return largest, at, top, rounding

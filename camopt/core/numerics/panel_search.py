"""The search of one panel for the designs of a tile that may have their extreme there.

The slopes at both ends and a bound of the third derivative bound f''. Where the curve is concave, its maximum is at
an end or at a root of the slope, which ``climbing`` finds. Any other panel is halved once for all designs together.
Halves that are still open are split for each design alone (``halving``).
"""

import numpy as np

from camopt.core.kernels.address_calls import call_by_address
from camopt.core.kernels.marks import called_by_kernels, inline_in_kernels
from camopt.core.numerics.climbing import PanelPartEnds, allowed_gain, begin_climb, climb_all_concave_parts
from camopt.core.numerics.halving import (
    CLIMBS,
    UNSETTLED,
    classify_and_bound_part,
    read_part_ends,
    search_part_by_halving,
    write_part_ends,
)
from camopt.core.numerics.jet import larger


@called_by_kernels
def classify_panel_for_designs(design_count, panel, half_width, query, work):
    """Settle a panel for each design, begin a climb, or leave it open; count the climbs and the open designs."""
    found, (left, right) = work.found, (work.sides[0], work.sides[1])
    third, errors = work.bounds.third[panel], work.bounds.error[panel]
    climbs = opened = np.int64(0)
    for j in range(design_count):
        i = work.chosen[j]
        found.rounding[i] = max(found.rounding[i], errors[i] if errors[i] < np.inf else 0.0)
        ends = PanelPartEnds(-1.0, 1.0, left[0, j], left[1, j], right[0, j], right[1, j])
        enough = found.best[i] + allowed_gain(found.best[i], query.relative_error, errors[i])
        verdict, bound, concavity = classify_and_bound_part(ends, third[i], half_width, enough)
        if verdict == CLIMBS:
            begin_climb(work.climbs, climbs, i, ends, half_width, concavity)
            climbs += 1
        elif verdict == UNSETTLED:
            work.opened[opened] = i
            for side in (left, right):
                side[0, opened], side[1, opened] = side[0, j], side[1, j]
            opened += 1
        else:
            found.top[i] = max(found.top[i], bound)
    return climbs, opened


@classify_panel_for_designs.array_version
def _classify_panel_in_python(design_count, panel, half_width, query, work):
    found, i, sides = work.found, work.chosen[:design_count], work.sides[:2, :, :design_count]
    third, errors = work.bounds.third[panel, i], work.bounds.error[panel, i]
    found.rounding[i] = larger(found.rounding[i], np.where(errors < np.inf, errors, 0.0))
    enough = found.best[i] + allowed_gain(found.best[i], query.relative_error, errors)
    verdict, bound, concavity = classify_and_bound_part(
        PanelPartEnds(-1.0, 1.0, *sides[0], *sides[1]), third, half_width, enough
    )
    climbing, opened = np.flatnonzero(verdict == CLIMBS), np.flatnonzero(verdict == UNSETTLED)
    settled = np.flatnonzero((verdict != CLIMBS) & (verdict != UNSETTLED))
    found.top[i[settled]] = larger(found.top[i[settled]], bound[settled])
    ends = PanelPartEnds(-1.0, 1.0, *sides[0][:, climbing], *sides[1][:, climbing])
    begin_climb(work.climbs, slice(climbing.size), i[climbing], ends, half_width, concavity[climbing])
    work.opened[: opened.size], sides[:, :, : opened.size] = i[opened], sides[:, :, opened]
    return climbing.size, opened.size


@called_by_kernels
def classify_halves_of_open_panels(open_count, climb_count, panel, place, query, work):
    """Classify the halves of open panels; return the numbers of climbs so far and of parts to be split.

    ``place`` is (centre, half-width) of the panel.
    """
    found, (left, right, middle) = work.found, (work.sides[0], work.sides[1], work.sides[2])
    third, errors = work.bounds.third[panel], work.bounds.error[panel]
    parts = np.int64(0)
    for j in range(open_count):
        i, value, slope = work.opened[j], middle[0, j], middle[1, j]
        enough = found.best[i] + allowed_gain(found.best[i], query.relative_error, errors[i])
        if value > found.best[i]:
            found.best[i], found.at[i] = value, place[0]
        for half in range(2):
            ends = PanelPartEnds(-1.0, 0.0, left[0, j], left[1, j], value, slope)
            if half == 1:
                ends = PanelPartEnds(0.0, 1.0, value, slope, right[0, j], right[1, j])
            verdict, bound, concavity = classify_and_bound_part(ends, third[i], place[1], enough)
            if verdict == CLIMBS:
                begin_climb(work.climbs, climb_count, i, ends, place[1], concavity)
                climb_count += 1
            elif verdict == UNSETTLED:
                work.parts.design[parts] = i
                write_part_ends(work.parts.ends[parts], ends)
                parts += 1
            else:
                found.top[i] = max(found.top[i], bound)
    return climb_count, parts


@called_by_kernels
def split_open_parts(curve, first, part_count, panels, panel, query, work):
    """Split the parts that are still open, one by one."""
    found, errors, parts = work.found, work.bounds.error[panel], work.parts
    for k in range(part_count):
        i = parts.design[k]
        write_part_ends(parts.stack[0], read_part_ends(parts.ends[k]))
        value, u, bound, blur = search_part_by_halving(
            curve, first + i, panels, panel, errors[i], query, found.best[i], parts.stack
        )
        if value > found.best[i] + (
            blur if query.blur < np.inf else 0.0
        ):  # a second search keeps a value that is equal up to rounding
            found.best[i], found.at[i] = value, panels.centre[panel] + panels.half_width[panel] * u
        found.rounding[i], found.top[i] = max(found.rounding[i], blur), max(found.top[i], bound)


@split_open_parts.array_version
def _split_open_parts_in_python(curve, first, part_count, panels, panel, query, work):
    if part_count:
        parts = np.vstack((first + work.parts.design[:part_count], work.parts.ends[:part_count].T))
        curve.begin_halving(panel, parts, query, (first, work.found.best, work.bounds.error[panel]))
        split_open_parts.py_func(curve, first, part_count, panels, panel, query, work)


@called_by_kernels
def restart_inexact_designs(count, precision, work):
    """Restart the designs whose extremes are not exact enough; return their number."""
    found, many = work.found, np.int64(0)
    for i in range(count):
        width = max(found.top[i] - found.best[i], 0.0) + 2.0 * found.rounding[i]
        work.again[many] = i
        if width > precision.value * abs(found.best[i]):
            found.top[i], found.rounding[i] = found.best[i], 0.0
            many += 1
    return many


@restart_inexact_designs.array_version
def _restart_inexact_designs_in_python(count, precision, work):
    best, top, rounding = (column[:count] for column in (work.found.best, work.found.top, work.found.rounding))
    again = np.flatnonzero(larger(top - best, 0.0) + 2.0 * rounding > precision.value * abs(best))
    work.again[: again.size], top[again], rounding[again] = again, best[again], 0.0
    return again.size


@called_by_kernels
def choose_open_inexact_designs(inexact_count, panel, node, query, work):
    """Choose the blurred designs for which jets leave a panel open; return their number."""
    before, after, excess = work.values[node], work.values[node + 1], work.bounds.excess[panel]
    chosen = np.int64(0)
    for j in range(inexact_count):
        i = work.again[j]
        work.chosen[chosen] = i
        chosen += max(query.sign * before[i], query.sign * after[i]) + excess[i] > work.found.best[i]
    return chosen


@inline_in_kernels
def search_panel_for_inexact_designs(curve, first, inexact_count, panels, panel, node, query, work):
    """Search a panel again for blurred designs, in parts with their own rounding errors.

    A jet bounds the rounding error of the whole panel. If a denominator comes near zero somewhere in it, this bound
    is far too large at the extreme.
    """
    left, right, parts = work.sides[0], work.sides[1], work.parts
    inexact_count = choose_open_inexact_designs(inexact_count, panel, node, query, work)
    if inexact_count:
        for side in range(2):
            call_by_address(
                curve.node,
                (curve.source, node + side, query.sign, first, work.chosen, inexact_count, work.sides[side]),
            )
        for j in range(inexact_count):
            parts.design[j] = work.chosen[j]
            write_part_ends(
                parts.ends[j], PanelPartEnds(-1.0, 1.0, left[0, j], left[1, j], right[0, j], right[1, j])
            )
        split_open_parts(curve, first, inexact_count, panels, panel, query, work)


@inline_in_kernels
def search_panel_for_chosen_designs(curve, first, design_count, panels, panel, node, query, work):
    """Search one panel, which begins at ``node``, for all designs in ``work.chosen``."""
    place = (panels.centre[panel], panels.half_width[panel])
    for side in range(2):
        call_by_address(
            curve.node, (curve.source, node + side, query.sign, first, work.chosen, design_count, work.sides[side])
        )
    climbs, opened = classify_panel_for_designs(design_count, panel, place[1], query, work)
    if opened:
        there = (curve.source, panel, work.middle, query.sign, first, work.opened, opened, work.sides[2])
        call_by_address(curve.panel, there)
        climbs, parts = classify_halves_of_open_panels(opened, climbs, panel, place, query, work)
        split_open_parts(curve, first, parts, panels, panel, query, work)
    climb_all_concave_parts(curve, first, climbs, panels, panel, query, work)

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
def classify_panel_for_designs(design_count, panel, half_width, query, workspace):
    """Settle a panel for each design, begin a climb, or leave it open; count the climbs and the open designs."""
    found, (left, right) = workspace.found, (workspace.sides[0], workspace.sides[1])
    third, errors = workspace.bounds.third[panel], workspace.bounds.error[panel]
    climbs = opened = np.int64(0)
    for j in range(design_count):
        i = workspace.chosen[j]
        found.rounding[i] = max(found.rounding[i], errors[i] if errors[i] < np.inf else 0.0)
        ends = PanelPartEnds(-1.0, 1.0, left[0, j], left[1, j], right[0, j], right[1, j])
        enough = found.best[i] + allowed_gain(found.best[i], query.relative_error, errors[i])
        verdict, bound, concavity = classify_and_bound_part(ends, third[i], half_width, enough)
        if verdict == CLIMBS:
            begin_climb(workspace.climbs, climbs, i, ends, half_width, concavity)
            climbs += 1
        elif verdict == UNSETTLED:
            workspace.opened[opened] = i
            for side in (left, right):
                side[0, opened], side[1, opened] = side[0, j], side[1, j]
            opened += 1
        else:
            found.top[i] = max(found.top[i], bound)
    return climbs, opened


@classify_panel_for_designs.array_version
def _classify_panel_in_python(design_count, panel, half_width, query, workspace):
    found, i, sides = workspace.found, workspace.chosen[:design_count], workspace.sides[:2, :, :design_count]
    third, errors = workspace.bounds.third[panel, i], workspace.bounds.error[panel, i]
    found.rounding[i] = larger(found.rounding[i], np.where(errors < np.inf, errors, 0.0))
    enough = found.best[i] + allowed_gain(found.best[i], query.relative_error, errors)
    verdict, bound, concavity = classify_and_bound_part(
        PanelPartEnds(-1.0, 1.0, *sides[0], *sides[1]), third, half_width, enough
    )
    climbing, opened = np.flatnonzero(verdict == CLIMBS), np.flatnonzero(verdict == UNSETTLED)
    settled = np.flatnonzero((verdict != CLIMBS) & (verdict != UNSETTLED))
    found.top[i[settled]] = larger(found.top[i[settled]], bound[settled])
    ends = PanelPartEnds(-1.0, 1.0, *sides[0][:, climbing], *sides[1][:, climbing])
    begin_climb(workspace.climbs, slice(climbing.size), i[climbing], ends, half_width, concavity[climbing])
    workspace.opened[: opened.size], sides[:, :, : opened.size] = i[opened], sides[:, :, opened]
    return climbing.size, opened.size


@called_by_kernels
def classify_halves_of_open_panels(open_count, climb_count, panel, centre_and_half_width, query, workspace):
    """Classify the halves of open panels; return the numbers of climbs so far and of parts to be split.

    ``centre_and_half_width`` is (centre, half-width) of the panel.
    """
    found, (left, right, middle) = workspace.found, (workspace.sides[0], workspace.sides[1], workspace.sides[2])
    third, errors = workspace.bounds.third[panel], workspace.bounds.error[panel]
    parts = np.int64(0)
    for j in range(open_count):
        i, value, slope = workspace.opened[j], middle[0, j], middle[1, j]
        enough = found.best[i] + allowed_gain(found.best[i], query.relative_error, errors[i])
        if value > found.best[i]:
            found.best[i], found.at[i] = value, centre_and_half_width[0]
        for half in range(2):
            ends = PanelPartEnds(-1.0, 0.0, left[0, j], left[1, j], value, slope)
            if half == 1:
                ends = PanelPartEnds(0.0, 1.0, value, slope, right[0, j], right[1, j])
            verdict, bound, concavity = classify_and_bound_part(ends, third[i], centre_and_half_width[1], enough)
            if verdict == CLIMBS:
                begin_climb(workspace.climbs, climb_count, i, ends, centre_and_half_width[1], concavity)
                climb_count += 1
            elif verdict == UNSETTLED:
                workspace.parts.design[parts] = i
                write_part_ends(workspace.parts.ends[parts], ends)
                parts += 1
            else:
                found.top[i] = max(found.top[i], bound)
    return climb_count, parts


@called_by_kernels
def split_open_parts(curve, first_design, part_count, panels, panel, query, workspace):
    """Split the parts that are still open, one by one."""
    found, errors, parts = workspace.found, workspace.bounds.error[panel], workspace.parts
    for k in range(part_count):
        i = parts.design[k]
        write_part_ends(parts.stack[0], read_part_ends(parts.ends[k]))
        value, u, bound, blur = search_part_by_halving(
            curve, first_design + i, panels, panel, errors[i], query, found.best[i], parts.stack
        )
        if value > found.best[i] + (
            blur if query.blur < np.inf else 0.0
        ):  # a second search keeps a value that is equal up to rounding
            found.best[i], found.at[i] = value, panels.centre[panel] + panels.half_width[panel] * u
        found.rounding[i], found.top[i] = max(found.rounding[i], blur), max(found.top[i], bound)


@split_open_parts.array_version
def _split_open_parts_in_python(curve, first_design, part_count, panels, panel, query, workspace):
    if part_count:
        parts = np.vstack((first_design + workspace.parts.design[:part_count], workspace.parts.ends[:part_count].T))
        curve.begin_halving(
            panel, parts, query, (first_design, workspace.found.best, workspace.bounds.error[panel])
        )
        split_open_parts.py_func(curve, first_design, part_count, panels, panel, query, workspace)


@called_by_kernels
def restart_inexact_designs(count, precision, workspace):
    """Restart the designs whose extremes are not exact enough; return their number."""
    found, many = workspace.found, np.int64(0)
    for i in range(count):
        width = max(found.top[i] - found.best[i], 0.0) + 2.0 * found.rounding[i]
        workspace.again[many] = i
        if width > precision.value * abs(found.best[i]):
            found.top[i], found.rounding[i] = found.best[i], 0.0
            many += 1
    return many


@restart_inexact_designs.array_version
def _restart_inexact_designs_in_python(count, precision, workspace):
    best, top, rounding = (
        column[:count] for column in (workspace.found.best, workspace.found.top, workspace.found.rounding)
    )
    again = np.flatnonzero(larger(top - best, 0.0) + 2.0 * rounding > precision.value * abs(best))
    workspace.again[: again.size], top[again], rounding[again] = again, best[again], 0.0
    return again.size


@called_by_kernels
def choose_open_inexact_designs(inexact_count, panel, node, query, workspace):
    """Choose the blurred designs for which jets leave a panel open; return their number."""
    before, after, excess = workspace.values[node], workspace.values[node + 1], workspace.bounds.excess[panel]
    chosen = np.int64(0)
    for j in range(inexact_count):
        i = workspace.again[j]
        workspace.chosen[chosen] = i
        chosen += max(query.sign * before[i], query.sign * after[i]) + excess[i] > workspace.found.best[i]
    return chosen


@inline_in_kernels
def evaluate_panel_ends(curve, first_design, design_count, node, query, workspace):
    """Evaluate the designs in ``workspace.chosen`` at both ends of the panel that begins at ``node``."""
    for side in range(2):
        ends = (
            curve.source,
            node + side,
            query.sign,
            first_design,
            workspace.chosen,
            design_count,
            workspace.sides[side],
        )
        call_by_address(curve.node, ends)


@inline_in_kernels
def search_panel_for_inexact_designs(curve, first_design, inexact_count, panels, panel, node, query, workspace):
    """Search a panel again for blurred designs, in parts with their own rounding errors.

    A jet bounds the rounding error of the whole panel. If a denominator comes near zero somewhere in it, this bound
    is far too large at the extreme.
    """
    left, right, parts = workspace.sides[0], workspace.sides[1], workspace.parts
    inexact_count = choose_open_inexact_designs(inexact_count, panel, node, query, workspace)
    if inexact_count:
        evaluate_panel_ends(curve, first_design, inexact_count, node, query, workspace)
        for j in range(inexact_count):
            parts.design[j] = workspace.chosen[j]
            write_part_ends(
                parts.ends[j], PanelPartEnds(-1.0, 1.0, left[0, j], left[1, j], right[0, j], right[1, j])
            )
        split_open_parts(curve, first_design, inexact_count, panels, panel, query, workspace)


@inline_in_kernels
def search_panel_for_chosen_designs(curve, first_design, design_count, panels, panel, node, query, workspace):
    """Search one panel, which begins at ``node``, for all designs in ``workspace.chosen``."""
    place = (panels.centre[panel], panels.half_width[panel])
    evaluate_panel_ends(curve, first_design, design_count, node, query, workspace)
    climbs, opened = classify_panel_for_designs(design_count, panel, place[1], query, workspace)
    if opened:
        there = (
            curve.source,
            panel,
            workspace.middle,
            query.sign,
            first_design,
            workspace.opened,
            opened,
            workspace.sides[2],
        )
        call_by_address(curve.panel, there)
        climbs, parts = classify_halves_of_open_panels(opened, climbs, panel, place, query, workspace)
        split_open_parts(curve, first_design, parts, panels, panel, query, workspace)
    climb_all_concave_parts(curve, first_design, climbs, panels, panel, query, workspace)

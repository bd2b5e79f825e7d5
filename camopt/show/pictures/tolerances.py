"""Pictures of tolerances.

Motion errors: worst case and root sum square over the turn, the worst cam, contributions of tolerances. A batch of
cams: histograms of the largest errors and of the quantities of limits.
"""

from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.effects.error_response import RESPONSE_ORDERS
from camopt.model.effects.motion import motion_unit_factor
from camopt.scene.problem.problem import resolve_design
from camopt.show.drawing.style import (
    ALARM,
    INK,
    LIMIT_STYLE,
    MUTED,
    PAGE_TITLE,
    SERIES,
    WHITE_BACKGROUND,
    Figure,
    Target,
    add_grid,
    new_figure,
)
from camopt.solve.tables.cells import column_suffix_of_unit, number_text
from camopt.solve.tolerances.errors import repeat_cam_errors
from camopt.solve.tolerances.real_cam import RealCam
from camopt.solve.tolerances.turn_errors import (
    BAND_NAME,
    MOTION_NAMES,
    TurnErrors,
    root_sum_square_range,
    worst_case_range,
)

if TYPE_CHECKING:
    from camopt.solve.tolerances.batch import Batch
    from camopt.solve.tolerances.tolerance import MotionError, MotionErrors

LIGHT, DARK = "#d9e6f2", "#9fc0dd"
ERROR_ANGLES = 1441
"""Cam angles at which the error of the worst cam is drawn."""


def draw(what: Any, path: Target = None) -> "Figure":
    """Draw motion errors, or a batch of cams."""
    return _draw_batch(what, path) if hasattr(what, "samples") else _draw_errors(what, path)


def _draw_errors(what: "MotionErrors", path: Target) -> "Figure":
    """Draw errors of displacement, velocity and acceleration over the turn, with contributions of tolerances."""
    turn = TurnErrors(what.scene, resolve_design(what.scene))
    with new_figure(path, (12.5, 9.0), layout="constrained") as figure:
        title = f"{what.scene.name}: motion errors within the tolerances"
        figure.suptitle(title, x=0.01, ha="left", fontsize=PAGE_TITLE, fontweight="bold")
        panels = figure.subplots(RESPONSE_ORDERS, 2, width_ratios=[2.2, 1.0])
        keys = sorted(what.errors[0].shares, key=what.errors[0].shares.__getitem__)
        for order, error in enumerate(what.errors):
            _draw_error_range(panels[order, 0], turn, order, error)
            _draw_worst_cam(panels[order, 0], turn, order, what)
            _draw_contributions(panels[order, 1], keys, error)
        panels[-1, 0].set_xlabel("cam angle, deg")
        figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower left", ncols=4)
    return figure


def draw_main_diagram(axes: Any, what: "MotionErrors") -> None:
    """Draw the displacement error over the turn in axes."""
    turn = TurnErrors(what.scene, resolve_design(what.scene))
    _draw_error_range(axes, turn, 0, what.errors[0])
    _draw_worst_cam(axes, turn, 0, what)
    axes.set_xlabel("cam angle, deg")
    axes.legend()


def _draw_error_range(axes: Any, turn: TurnErrors, order: int, error: "MotionError") -> None:
    """Draw the range of an error over the turn."""
    angles, unit = np.degrees(turn.nodes), to_shown_unit(motion_unit_factor(turn.problem.setup, order), error.unit)
    axes.set_title(f"{MOTION_NAMES[order].capitalize()} error, {unit_in_shown_system(error.unit)}", loc="left")
    axes.set(xlim=(0.0, 360.0), xticks=np.arange(0, 361, 60))
    bounded = bool(np.isfinite(worst_case_range(turn.node_contributions, order).magnitude).all())
    if not turn.node_contributions:
        axes.text(0.5, 0.5, "no tolerance moves the tool", transform=axes.transAxes, ha="center", color=MUTED)
    elif bounded:
        bands = (
            (worst_case_range(turn.node_contributions, order), LIGHT, "worst case"),
            (root_sum_square_range(turn.node_contributions, order), DARK, BAND_NAME),
        )
        for ends, colour, label in sorted(
            bands, key=lambda band: -band[0].magnitude.max()
        ):  # the wider band behind
            axes.fill_between(angles, unit * ends.lower, unit * ends.upper, color=colour, lw=0, label=label)
        if error.at_deg is not None:
            axes.axvline(error.at_deg, color=MUTED, lw=0.8, ls=":", label="cam angle of the largest worst case")
    if np.isinf(error.worst) and bounded:
        where = f"between jumps; infinite at {turn.impulse_angles_text(order)}"
        axes.set_title(where, loc="right", color=MUTED, fontsize="small", fontweight="normal")
    elif np.isinf(error.worst):
        keys = [key for key, at in turn.angles_of_unbounded_tolerances(order).items() if at is None]
        waves = "unbounded: the profile error may have any slope\n(set tolerances.waves)"
        text = waves if "profile" in keys else f"no bound: {', '.join(keys)}"
        axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=MUTED)
    if not bounded:
        axes.set_yticks([])
    add_grid(axes)


def _draw_worst_cam(axes: Any, turn: TurnErrors, order: int, what: "MotionErrors") -> None:
    """Draw the error of the cam with the largest displacement error, by exact contact."""
    if turn.problem.setup.mechanism.further_contacts and turn.problem.setup.train is not None:
        return  # with two contacts only the motion of the follower is known, not of the tool
    places = np.union1d(turn.nodes, np.linspace(0.0, turn.nodes[-1], ERROR_ANGLES))
    errors = repeat_cam_errors(what.worst_case.errors, places.size)
    cams, unit = (
        RealCam(turn.problem, 0),
        to_shown_unit(motion_unit_factor(turn.problem.setup, order), what.errors[order].unit),
    )
    with np.errstate(all="ignore"):
        angles = cams.angles_in_turn(cams.contact_angles(errors, places))
        values = unit * cams.motion_errors(errors, places, order)
    if not np.isfinite(worst_case_range(turn.node_contributions, order).magnitude).all():
        return
    ends, first = axes.get_ylim(), np.argsort(angles, kind="stable")
    axes.plot(np.degrees(angles[first]), values[first], color=ALARM, lw=1.0, label="the worst cam of displacement")
    axes.set_ylim(ends)


def _draw_contributions(axes: Any, keys: list[str], error: "MotionError") -> None:
    """Draw the contribution of each tolerance to the worst case, in the same order in all panels."""
    values = to_shown_unit(np.array([error.shares[key] for key in keys]), error.unit)
    axes.set_title(
        f"Worst case, {unit_in_shown_system(error.unit)}" if np.isfinite(error.worst) else "Worst case: infinite",
        loc="left",
    )
    axes.set_yticks(range(len(keys)), labels=[key.removeprefix("follower.").replace("_", " ") for key in keys])
    axes.set_ylim(-0.8, max(len(keys), 4) - 0.2)
    if np.isfinite(values).all():
        axes.barh(range(len(keys)), values, color=SERIES[0], height=0.6, zorder=3)
        for place, value in enumerate(values):
            axes.text(value, place, f" {value:.3g}", va="center", ha="left")
        axes.set_xlim(0.0, 1.25 * float(values.max(initial=0.0) or 1.0))
        axes.locator_params(axis="x", nbins=4)
    else:
        axes.set(xlim=(0.0, 1.0), xticks=[])
        for place, value in enumerate(values):
            axes.text(0.02, place, "∞" if np.isinf(value) else f"{value:.3g}", va="center")
    add_grid(axes)


HISTOGRAM_BINS, HISTOGRAM_COLUMNS = 60, 3
TAIL_SHARE = 0.0005
"""Share of cams on each side beyond the range of a histogram; they are in its outermost bins."""
THREE_SIGMA_SHARE = 0.9973
EQUAL_VALUES = 1e-9
"""Relative difference; closer numbers are equal."""


def _draw_batch(what: "Batch", path: Target) -> "Figure":
    """Draw a histogram of each motion error, and of the quantity of each limit, with the limit."""
    columns = [(name, each) for name, each in what.samples.items() if "_off_" not in name]
    bounds = what.bounds
    rows = ceil(len(columns) / HISTOGRAM_COLUMNS)
    with new_figure(path, (12.5, 1.0 + 2.4 * rows), layout="constrained") as figure:
        title = f"{what.scene.name}: {what.cams:,} random cams, {what.outside:,} of them outside the tolerances"
        figure.suptitle(title, x=0.01, ha="left", fontsize=PAGE_TITLE, fontweight="bold")
        panels = figure.subplots(rows, HISTOGRAM_COLUMNS, squeeze=False).ravel()
        for axes, (name, column) in zip(panels, columns, strict=False):
            _draw_histogram(axes, name, column, bounds.get(name))
        for axes in panels[: len(columns) : HISTOGRAM_COLUMNS]:
            axes.set_ylabel("cams")
        for axes in panels[len(columns) :]:
            axes.set_axis_off()
        pairs = (zip(*axes.get_legend_handles_labels(), strict=True) for axes in panels)
        handles = {label: handle for each in pairs for handle, label in each}
        figure.legend(handles.values(), handles.keys(), loc="outside lower left", ncols=4)
    return figure


def _draw_histogram(axes: Any, name: str, column: Any, bound: float | None) -> None:
    """Draw the histogram of one number of the cams."""
    values = to_shown_unit(column.values[np.isfinite(column.values)], column.unit)
    words = name.removesuffix(column_suffix_of_unit(column.unit)).replace("_", " ").capitalize()
    axes.set_title(f"{words}, {unit_in_shown_system(column.unit)}", loc="left")
    low, high = np.quantile(values, [TAIL_SHARE, 1.0 - TAIL_SHARE]) if values.size else (0.0, 0.0)
    if high - low <= EQUAL_VALUES * max(abs(low), abs(high), EQUAL_VALUES):
        what = f"{number_text(float(high))} for all" if values.size else "no cam can be assembled"
        axes.text(0.5, 0.5, what, transform=axes.transAxes, ha="center", va="center", color=MUTED)
        axes.set(xticks=[], yticks=[])
    else:
        axes.hist(np.clip(values, low, high), HISTOGRAM_BINS, range=(low, high), color=SERIES[0], zorder=3)
        least = name in QUANTITIES and QUANTITIES[name].limit_sign < 0.0
        share, label = (
            (1.0 - THREE_SIGMA_SHARE, "99.73 % are above") if least else (THREE_SIGMA_SHARE, "99.73 % are below")
        )
        median, nearly_all = np.quantile(values, [0.5, share])
        axes.axvline(median, color=INK, lw=1.0, label="median of the cams", zorder=4)
        axes.axvline(nearly_all, color=MUTED, lw=1.0, ls=":", label=label, zorder=4)
        axes.locator_params(axis="y", nbins=4, integer=True)
    if bound is not None:
        limit_style = {"transform": axes.transAxes, "va": "top", "color": ALARM, **WHITE_BACKGROUND}
        bound = to_shown_unit(bound, column.unit)
        text = number_text(float(bound))
        if low - (high - low) < bound < high + (high - low):
            axes.axvline(bound, **LIMIT_STYLE, label="limit", zorder=5)
        elif bound < low:
            axes.text(0.02, 0.95, f"← limit {text}", ha="left", **limit_style)
        else:
            axes.text(0.98, 0.95, f"limit {text} →", ha="right", **limit_style)
    axes.locator_params(axis="x", nbins=5)
    add_grid(axes)

"""The picture of a fit: points and motion, deviations in their band, acceleration of points and motion.

A measured profile is drawn on that of the fitted cam, with magnified deviations along the normal.
"""

from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.motion.stroke import RISE
from camopt.scene.problem.problem import resolve
from camopt.show.drawing.diagrams import short_number_factor_and_unit
from camopt.show.drawing.picture import (
    Picture,
    draw_circle,
    draw_line,
    fit_axes,
    four_digit_text,
    round_down_to_1_2_5,
    value_with_unit,
)
from camopt.show.drawing.style import (
    ALARM,
    COLOURS,
    DOT_STYLE,
    FAINT,
    FILL,
    INK,
    LIMIT_STYLE,
    MUTED,
    PAGE_TITLE,
    PROFILE_WIDTH,
    REFERENCE_COLOUR,
    TITLE_SIZE,
    Figure,
    Target,
    add_grid,
    new_figure,
)
from camopt.solve.measured.fit_result import Fit
from camopt.solve.measured.measured_points import forward_angle_deg

RAW_COLOUR, FIT_COLOUR = MUTED, COLOURS[RISE]
DIAGRAM_AREAS = ((0.09, 0.66, 0.88, 0.22), (0.09, 0.375, 0.88, 0.19), (0.09, 0.07, 0.88, 0.22))
PAGE_SIZE, WIDE_PAGE, PROFILE_AREA = (11.0, 8.5), (17.0, 8.5), (0.67, 0.16, 0.31, 0.70)
RANGES_SHOWN = 2.0  # ranges of the fitted acceleration shown of the differences of points
BANDS_SHOWN = 1.4  # end of the diagram of deviations, in bands
LARGEST_SHOWN = 0.12  # largest drawn deviation, as share of the radius of the cam


def draw(result: Fit, path: Target = None) -> "Figure":
    """Draw a fit: points and motion, deviations in their band, acceleration of points and motion."""
    picture = Picture(result.scene, resolve(result.scene))
    size = WIDE_PAGE if result.profile else PAGE_SIZE
    with new_figure(path, size) as figure:
        noise, band = (value_with_unit(value, result.unit) for value in (result.noise, result.band))
        figure.text(0.03, 0.96, result.scene.name, fontsize=PAGE_TITLE, fontweight="bold")
        about = f"{result.points.angles.size} points, noise {noise}, band ±{band}"
        figure.text(0.03, 0.935, about, fontsize=TITLE_SIZE - 1.0, color=MUTED)
        part = PAGE_SIZE[0] / size[0]
        lift, deviation, acceleration = (
            figure.add_axes((part * x, y, part * w, h)) for x, y, w, h in DIAGRAM_AREAS
        )
        _draw_lift(lift, result, picture)
        _draw_deviations(deviation, result)
        _draw_acceleration(acceleration, result, picture)
        for axes in (lift, deviation, acceleration):
            axes.set(xlim=(0, 360), xticks=range(0, 361, 30))
            add_grid(axes)
        acceleration.set_xlabel("cam angle, deg")
        if result.profile:
            _draw_profile_and_deviations(figure.add_axes(PROFILE_AREA), result, picture)
    return figure


def _derivative_over_turn(picture: Picture, order: int) -> tuple[FloatArray, FloatArray]:
    """Cam angles [deg] and a derivative of the motion over the turn, with gaps between pieces."""
    angles = np.concatenate([np.append(np.degrees(each), np.nan) for each in picture.angles_of_pieces])
    motions = [picture.problem.given_motion.motion_at(each) for each in picture.angles_of_pieces]
    return angles, np.concatenate([np.append(motion[order], np.nan) for motion in motions])


def _draw_lift(axes: Any, result: Fit, picture: Picture) -> None:
    angles, values = _derivative_over_turn(picture, 0)
    one = to_shown_unit(1.0, result.unit)
    values = values * one * (np.degrees(1.0) if picture.problem.given_motion_is_angle else 1.0)
    axes.plot(angles, values, color=FIT_COLOUR, lw=1.4, label="motion")
    axes.fill_between(
        angles, values - one * result.band, values + one * result.band, color=FIT_COLOUR, alpha=0.15, lw=0
    )
    measured = forward_angle_deg(result.start, result.points.angles), one * (result.points.lifts - result.zero)
    axes.plot(*measured, color=INK, label="points", **DOT_STYLE)
    if result.outliers.rows.size:
        left_out = forward_angle_deg(result.start, result.outliers.angles)
        axes.plot(
            left_out,
            (one * (result.outliers.lifts - result.zero)),
            ls="none",
            marker="x",
            ms=6.0,
            color=ALARM,
            label="left out",
        )
    axes.set_title(f"Lift, {unit_in_shown_system(result.unit)}", loc="left")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.2)


def _draw_deviations(axes: Any, result: Fit) -> None:
    """Draw deviations of the points from the motion; outliers at the edge, with their rows."""
    one = to_shown_unit(1.0, result.unit)
    band = one * result.band
    axes.axhline(0.0, color=FIT_COLOUR, lw=1.0)
    for side in (-band, band):
        axes.axhline(side, **LIMIT_STYLE)
    off = -one * np.array(result.deviation.at_points)
    axes.plot(forward_angle_deg(result.start, result.points.angles), off, color=INK, **DOT_STYLE)
    for each in result.left_out:
        side = BANDS_SHOWN * band * (1.0 if each.deviation < 0.0 else -1.0)
        angle = float(forward_angle_deg(result.start, each.angle))
        axes.plot([angle], [0.93 * side], ls="none", marker="x", ms=6.0, color=ALARM)
        place = {"textcoords": "offset points", "xytext": (6, 0), "va": "center", "color": ALARM}
        axes.annotate(f"row {each.row}: {four_digit_text(-one * each.deviation)}", (angle, 0.93 * side), **place)
    axes.set_ylim(-BANDS_SHOWN * band, BANDS_SHOWN * band)
    axes.set_title(f"Deviation of the points, {unit_in_shown_system(result.unit)}", loc="left")


def _draw_acceleration(axes: Any, result: Fit, picture: Picture) -> None:
    angles, values = _derivative_over_turn(picture, 2)
    values = values * result.scale(2)
    at, before = result.differences["acceleration"]
    order = np.argsort(at)
    unit = QUANTITIES[result.quantity("acceleration")].unit
    values, before, unit = to_shown_unit(values, unit), to_shown_unit(before, unit), unit_in_shown_system(unit)
    factor, unit = short_number_factor_and_unit([values[~np.isnan(values)]], unit)
    low, high = float(np.nanmin(values)) * factor, float(np.nanmax(values)) * factor
    axes.plot(
        at[order], before[order] * factor, color=RAW_COLOUR, lw=0.6, alpha=0.7, label="differences of the points"
    )
    axes.plot(angles, values * factor, color=FIT_COLOUR, lw=1.6, label="motion")
    axes.axhline(0.0, color=FAINT, lw=0.8, zorder=1)
    room = RANGES_SHOWN * (high - low)
    bottom, top = max(low - room, before.min() * factor * 1.05), min(high + room, before.max() * factor * 1.05)
    axes.set_ylim(min(bottom, low * 1.1), max(top, high * 1.1))
    axes.set_title(f"Acceleration, {unit}", loc="left")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2)


def _draw_profile_and_deviations(axes: Any, result: Fit, picture: Picture) -> None:
    """Draw the profile of the scene at cam angle 0, and the measured points."""
    assert result.profile is not None
    problem, profile = picture.problem, result.profile
    outline = np.concatenate([curve.profile[0] for curve in picture.curves])
    normals = np.concatenate([curve.normal for curve in picture.curves])
    axes.fill(outline.real, outline.imag, color=FILL, lw=0)
    draw_line(axes, np.append(outline, outline[0]), color=FIT_COLOUR, lw=PROFILE_WIDTH)
    draw_circle(
        axes, float(problem.design.size[0]), color=REFERENCE_COLOUR, lw=0.7, ls=(0, (5, 4)), label="base circle"
    )
    axes.plot([0.0], [0.0], ls="none", marker="+", ms=9.0, color=INK, mew=0.8)
    most = LARGEST_SHOWN * float(np.abs(outline).max())
    times = round_down_to_1_2_5(most / float(np.abs(result.distances).max()))
    shown = [outline]
    for rows, style in (
        (result.points.rows, {"color": INK, "label": "points"}),
        (profile.unreached, {"color": ALARM, "label": "not reached"}),
    ):
        if rows.size:
            centres = profile.probe_centres_at(problem, result.start, rows)
            foot = np.array([np.abs(outline - centre).argmin() for centre in centres])
            off = np.clip(times * profile.distances_outside_profile(problem, result.start, rows), -most, most)
            places = outline[foot] + off * normals[foot]
            axes.plot(places.real, places.imag, **style, **DOT_STYLE)
            shown.append(places)
    fit_axes(axes, np.concatenate(shown), 0.04)
    axes.set_axis_off()
    furthest = value_with_unit(float(np.abs(result.distances).max()))
    axes.set_title(f"Profile; deviations of points magnified {times:g} times (at most {furthest})", loc="left")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.0), ncols=3, borderaxespad=0.2)

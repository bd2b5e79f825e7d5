"""A measured profile beside that of the fitted cam, with its deviations along the normal magnified."""

from math import floor, log10
from typing import Any

import numpy as np

from camopt.drawing.picture import Picture, draw_circle, draw_line, fit_axes, told
from camopt.drawing.style import ALARM, DOT, FILL, INK, PROFILE, REFERENCE_COLOUR
from camopt.measured.fitted import Fit

LARGEST_SHOWN = 0.12  # of the radius of the cam: how far the furthest point is shown off it


def draw_profile(axes: Any, result: Fit, picture: Picture, colour: str) -> None:
    """The profile of the scene at cam angle 0, and the points of the measured one."""
    assert result.profile is not None
    problem, profile = picture.problem, result.profile
    outline = np.concatenate([curve.profile[0] for curve in picture.curves])
    normals = np.concatenate([curve.normal for curve in picture.curves])
    axes.fill(outline.real, outline.imag, color=FILL, lw=0)
    draw_line(axes, np.append(outline, outline[0]), color=colour, lw=PROFILE)
    draw_circle(
        axes, float(problem.design.size[0]), color=REFERENCE_COLOUR, lw=0.7, ls=(0, (5, 4)), label="base circle"
    )
    axes.plot([0.0], [0.0], ls="none", marker="+", ms=9.0, color=INK, mew=0.8)
    most = LARGEST_SHOWN * float(np.abs(outline).max())
    times = _times(most / float(np.abs(result.distances).max()))
    shown = [outline]
    for rows, style in (
        (result.points.rows, {"color": INK, "label": "points"}),
        (profile.unreached, {"color": ALARM, "label": "not reached"}),
    ):
        if rows.size:
            centres = profile.centres_at(problem, result.start, rows)
            foot = np.array([np.abs(outline - centre).argmin() for centre in centres])
            off = np.clip(times * profile.distances(problem, result.start, rows), -most, most)
            places = outline[foot] + off * normals[foot]
            axes.plot(places.real, places.imag, **style, **DOT)
            shown.append(places)
    fit_axes(axes, np.concatenate(shown), 0.04)
    axes.set_axis_off()
    furthest = told(float(np.abs(result.distances).max()))
    axes.set_title(f"Profile; points {times:g} times as far off it (at most {furthest})", loc="left")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.0), ncols=3, borderaxespad=0.2)


def _times(most: float) -> float:
    """The largest 1, 2 or 5 times a power of ten that is not above a value."""
    power = 10.0 ** floor(log10(most))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= most)

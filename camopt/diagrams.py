"""Diagrams over the cam angle: motion, pressure angle and curvature, with exact peaks, breaks and impulses."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from math import floor, isfinite, log10
from typing import Any

import numpy as np

from camopt.effects.motion import scale
from camopt.motion.table import DWELL, RETURN, RISE, TURN
from camopt.numerics import FloatArray
from camopt.picture import ALARM, COLOURS, FAINT, INK, MUTED, NAMES, PITCH, REFERENCE, Picture, number
from camopt.quantities import DERIVATIVES, QUANTITIES, motion_quantity

SHADES = {RISE: "#e9f1f8", RETURN: "#faefe6", DWELL: "white"}
DEGREES_A_LETTER = 4.0  # that a letter above the diagrams takes
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
SAME = 1e-6  # jumps below this share of the range are none, samples this near the peak are the peak
CLIP = 4.0  # times the usual pitch curvature: where the diagram of curvature is cut off

Values = list[FloatArray]


@dataclass
class Peak:
    """A marked point: cam angle in deg, value, text, and whether it is the pitch point."""

    angle: float
    value: float
    text: str
    colour: str = INK


@dataclass
class Panel:
    """One diagram: values piece by piece, and what is said about them. Values, peaks and limits in ``unit``."""

    title: str
    unit: str
    values: Values
    peaks: list[Peak] = field(default_factory=list)
    limits: list[tuple[int, float]] = field(default_factory=list)
    impulses: list[tuple[float, float]] = field(default_factory=list)  # cam angle in deg, size
    pitch: Values | None = None  # of the pitch curve, dash-dot
    other: Values | None = None  # of the other flank, thin
    note: str = ""
    alarm: Values | None = None  # where this is true, piece by piece, the cam is undercut
    span: tuple[float, float] | None = None


def draw(axes: Sequence[Any], picture: Picture, heads: Iterable[int], feet: Iterable[int]) -> None:
    """The six diagrams into six axes; stroke names above the ``heads``, cam angles below the ``feet``."""
    motion = [_derivative(picture, name, order) for order, name in enumerate(DERIVATIVES, start=1)]
    panels = [_displacement(picture), *motion, _pressure(picture), _curvature(picture)]
    for number, (each, panel) in enumerate(zip(axes, panels, strict=True)):
        _draw_panel(each, picture, panel)
        if number in heads:
            _name_strokes(each, picture)
        if number in feet:
            each.set_xlabel("cam angle, deg", labelpad=2)
        else:
            each.tick_params(labelbottom=False)


def _displacement(picture: Picture) -> Panel:
    angular = picture.question.subject.angular
    factor = np.degrees(1.0) if angular else 1.0
    values = [rows[0] * factor for rows in picture.motion]
    lift = picture.question.programme.lift * factor
    peaks = _peaks(picture, values, {TURN: lift})
    return Panel("Displacement", "deg" if angular else "mm", values, peaks)


def _derivative(picture: Picture, name: str, order: int) -> Panel:
    """Velocity, acceleration or jerk; impulses where the derivative below it jumps."""
    subject, programme = picture.question.subject, picture.question.programme
    timed, factor = subject.omega is not None, scale(subject, order)
    values = [rows[order] * factor for rows in picture.motion]
    found = {
        kind: motion_quantity(name, NAMES[kind], angular=subject.angular, timed=timed) for kind in (RISE, RETURN)
    }
    exact = {kind: picture.values[key] for kind, key in found.items()}
    panel = Panel(name.capitalize(), QUANTITIES[found[RISE]].unit, values, _peaks(picture, values, exact))
    panel.impulses = [(np.degrees(j.at), j.size * factor) for j in programme.jumps if j.order == order - 1]
    if panel.impulses:
        below = list(DERIVATIVES)[order - 2]
        panel.note = f"arrows: impulses, where the {below} jumps"
    if order == 3 and programme.corners:
        panel.note = "no jerk at the corners, where the velocity jumps"
    bound = getattr(picture.question.scene.limits, name)
    panel.limits = [] if bound is None else [(TURN, bound)]
    return panel


def _pressure(picture: Picture) -> Panel:
    """Signed pressure angle; for a face square to the motion, which has none, the contact on the face."""
    mechanism, design = picture.question.subject.mechanism, picture.question.design
    programme, exact = picture.question.programme, picture.values
    if exact["pressure_angle_max_deg"] == 0.0 and mechanism.reach is not None:
        reach = picture.curve_values(mechanism.reach(design, programme))
        peaks = _extremes(picture, reach, (exact["face_reach_max_mm"], exact["face_reach_min_mm"]))
        return Panel("Contact on the face", "mm", reach, peaks, note="pressure angle 0 throughout")
    tangent = picture.curve_values(mechanism.pressure(design, programme))
    values = [np.degrees(np.arctan(t)) for t in tangent]
    bounds = {kind: exact[f"pressure_angle_max_{NAMES[kind]}_deg"] for kind in (RISE, RETURN)}
    panel = Panel("Pressure angle", "deg", values, _peaks(picture, values, bounds, "°"))
    _mark_pitch_point(panel, exact)
    limits = picture.question.scene.limits
    asked = {RISE | DWELL: limits.pressure_angle, RETURN: limits.pressure_angle_return}
    panel.limits = [(kinds, bound) for kinds, bound in asked.items() if bound is not None]
    return panel


def _mark_pitch_point(panel: Panel, exact: dict[str, Any]) -> None:
    """The pitch point takes the place of the peak it is; in a dwell it is a peak of its own."""
    largest, at = exact["pressure_angle_max_deg"], exact["pressure_angle_max_at_deg"]
    for peak in panel.peaks:
        if abs(peak.value) >= largest * (1 - SAME):
            peak.angle, peak.text, peak.colour = at, f"pitch point {peak.text}", REFERENCE
            return
    every = np.concatenate(panel.values)
    value = float(every[np.argmax(np.abs(every))])
    panel.peaks.append(Peak(at, value, f"pitch point {number(np.copysign(largest, value))}°", REFERENCE))


def _curvature(picture: Picture) -> Panel:
    """Curvature of pitch curve and profile; for a flat face the radius of curvature, which may pass through 0."""
    mechanism, design = picture.question.subject.mechanism, picture.question.design
    programme, least = picture.question.programme, picture.values["profile_radius_min_mm"]
    if mechanism.profile_radius is not None:
        values = picture.curve_values(mechanism.profile_radius(design, programme))
        peaks = [p for p in _extremes(picture, values, (np.nan, least)) if isfinite(least)]
        panel = Panel("Radius of curvature of the profile", "mm", values, peaks)
        panel.alarm = [v <= 0.0 for v in values]
        panel.limits = _curvature_limit(picture, lambda radius: radius)
    else:
        assert mechanism.curvature is not None
        panel = _trace_curvature(picture, picture.curve_values(mechanism.curvature(design, programme)))
    if programme.corners:
        panel.note = "corners, where the velocity jumps, left out"
    return panel


def _trace_curvature(picture: Picture, pitch: Values) -> Panel:
    radius, grooved = float(picture.question.design.roller_radius[0]), picture.question.subject.mechanism.grooved
    every = np.abs(np.concatenate(pitch))
    cap = CLIP * float(np.percentile(every[np.isfinite(every)], 95))
    sides = (1.0, -1.0) if grooved and radius else (1.0,)
    profiles = [[_offset_curvature(k, side * radius, cap) for k in pitch] for side in sides]
    panel = Panel(f"Curvature of the {'flanks' if grooved else 'profile'}", "1/mm", profiles[0])
    if radius > 0.0:
        panel.pitch = pitch
        panel.other = profiles[1] if grooved else None
        panel.alarm = [(np.abs(k) if grooved else k) * radius >= 1.0 for k in pitch]
        panel.note = "thin: left flank  ·  dash-dot: pitch curve" if grooved else "dash-dot: pitch curve"
    finite = np.concatenate([*pitch, *(values for side in profiles for values in side)])
    finite = finite[np.isfinite(finite) & (np.abs(finite) <= cap)]
    panel.span = (float(finite.min(initial=0.0)), float(finite.max(initial=0.0)))
    least = picture.values["profile_radius_min_mm"]
    if isfinite(least) and least > 0.0 and not grooved:
        peaks = _extremes(picture, profiles[0], (1.0 / least, np.nan))
        panel.peaks = [Peak(p.angle, p.value, f"ρ {number(least)} mm") for p in peaks if abs(p.value) <= cap]
    panel.limits = _curvature_limit(picture, lambda bound: 1.0 / bound)
    return panel


def _offset_curvature(pitch: FloatArray, radius: float, cap: float) -> FloatArray:
    """κ/(1 − κ·R), left out where it is cut away or beyond the cap."""
    share = 1.0 - pitch * radius
    with np.errstate(all="ignore"):
        curvature = pitch / share
    return np.where((share > 0.0) & (np.abs(curvature) <= cap), curvature, np.nan)


def _curvature_limit(picture: Picture, of: Any) -> list[tuple[int, float]]:
    bound = picture.question.scene.limits.curvature_radius
    return [] if bound is None else [(0, of(bound))]


def _peaks(picture: Picture, values: Values, exact: dict[int, float], sign: str = "") -> list[Peak]:
    """The largest magnitude over strokes of some kinds: where it is from the samples, its value exact."""
    found = []
    for kinds, largest in exact.items():
        chosen = [k for k, kind in enumerate(picture.kinds) if kind & kinds]
        if chosen and isfinite(largest) and largest > 0.0:
            every = np.concatenate([values[k] for k in chosen])
            at = float(np.nanargmax(np.abs(every)))
            direction = np.sign(every[int(at)])
            angle = _middle_of_peak(np.concatenate([picture.pieces[k] for k in chosen]), every * direction)
            found.append(Peak(angle, direction * largest, f"{number(direction * largest)}{sign}"))
    return found


def _extremes(picture: Picture, values: Values, exact: tuple[float, float]) -> list[Peak]:
    """The greatest and the least value, where they are given."""
    angles, every = np.concatenate(picture.pieces), np.concatenate(values)
    sides = [(sign, value) for sign, value in zip((1.0, -1.0), exact, strict=True) if isfinite(value)]
    return [Peak(_middle_of_peak(angles, every * sign), value, number(value)) for sign, value in sides]


def _middle_of_peak(angles: FloatArray, values: FloatArray) -> float:
    """Cam angle in deg of the greatest value; the middle of the first plateau."""
    top = float(np.nanmax(values))
    near = np.flatnonzero(values >= top - SAME * abs(top))
    ends = np.flatnonzero(np.diff(near) > 1)
    last = near[ends[0]] if ends.size else near[-1]
    return float(np.degrees(angles[near[0]] + angles[last]) / 2)


def _draw_panel(axes: Any, picture: Picture, panel: Panel) -> None:
    factor, unit = _power(panel)
    angles = [np.degrees(piece) for piece in picture.pieces]
    for stroke in picture.question.programme.strokes:
        axes.axvspan(*np.degrees([stroke.start, stroke.end]), color=SHADES[stroke.kind], lw=0, zorder=0)
    axes.axhline(0.0, color=FAINT, lw=0.8, zorder=1)
    for angle, value in zip(angles, panel.pitch or [], strict=panel.pitch is not None):
        axes.plot(angle, value * factor, color=PITCH, lw=1.0, ls=(0, (9, 2.5, 1.5, 2.5)), zorder=2)
    for kind, angle, value in zip(picture.kinds, angles, panel.other or [], strict=panel.other is not None):
        axes.plot(angle, value * factor, color=COLOURS[kind], lw=0.8, zorder=2.2)
    for kind, angle, value in zip(picture.kinds, angles, panel.values, strict=True):
        axes.plot(angle, value * factor, color=COLOURS[kind], lw=1.7, zorder=3, solid_capstyle="butt")
    span = _limits(axes, panel, factor)
    _draw_risers(axes, angles, [v * factor for v in panel.values], span)
    _draw_limits(axes, picture, panel, factor)
    _draw_impulses(axes, panel)
    _draw_alarm(axes, angles, panel)
    for peak in panel.peaks:
        _draw_peak(axes, peak, factor)
    axes.set_title(f"{panel.title}, {unit}", loc="left", fontsize=8.5, pad=2.5, color=INK)
    axes.set_title(panel.note, loc="right", fontsize=7.5, pad=2.5, color=MUTED)
    axes.set(xlim=(0, 360), xticks=range(0, 361, 30))
    axes.tick_params(length=2.5)
    axes.spines[["top", "right"]].set_visible(False)


def _power(panel: Panel) -> tuple[float, str]:
    """A factor that keeps the numbers short, and the unit with its power of ten."""
    every = np.abs(np.concatenate(panel.values))
    largest = float(np.nanmax(np.append(every[np.isfinite(every)], 0.0)))
    if largest == 0.0 or 1e-2 <= largest < 1e4:
        return 1.0, panel.unit
    power = 3 * floor(log10(largest) / 3)
    for peak in panel.peaks:
        if peak.text[-1:].isdigit():
            peak.text = number(peak.value / 10.0**power)
    return 10.0**-power, f"10{str(power).translate(SUPERSCRIPT)} {panel.unit}"


def _limits(axes: Any, panel: Panel, factor: float) -> float:
    """Limits of the vertical axis, with room for what is written at the peaks; the range of the values."""
    every = np.concatenate(panel.values) * factor
    every = every[np.isfinite(every)]
    low, high = min(every.min(initial=0.0), 0.0), max(every.max(initial=0.0), 0.0)
    if panel.span is not None:
        low, high = panel.span[0] * factor, panel.span[1] * factor
    reach = max(-low, high)
    near = [bound * factor for kinds, bound in panel.limits if kinds and bound * factor <= 2.5 * reach]
    low, high = min([low, *(-n for n in near)]), max([high, *near])
    if panel.impulses or high == low:
        high = max(high, -low) or 1.0
        low = -high
        axes.set_yticks([0.0]) if reach == 0.0 else None
    room = 0.26 * (high - low)
    axes.set_ylim(low - (room if low < 0 else room / 4), high + room)
    axes.locator_params(axis="y", nbins=5) if reach else None
    return float(high - low)


def _draw_risers(axes: Any, angles: Values, values: Values, span: float) -> None:
    """A dotted line where a value jumps, also from the end of the turn to its start."""
    for k, value in enumerate(values):
        before, after = values[k - 1][-1], value[0]
        if abs(after - before) > SAME * span:
            for at in {round(float(angles[k][0]), 6), round(float(angles[k - 1][-1]), 6)}:
                axes.plot([at, at], [before, after], color=MUTED, lw=0.9, ls=(0, (1, 1.6)), zorder=2.5)


def _draw_limits(axes: Any, picture: Picture, panel: Panel, factor: float) -> None:
    low, high = axes.get_ylim()
    for kinds, bound in panel.limits:
        level = bound * factor
        if kinds == 0 and low < level < high:
            axes.axhline(level, color=ALARM, lw=0.9, ls=(0, (5, 3)), zorder=2)
        for stroke in picture.question.programme.strokes:
            if stroke.kind & kinds and level < high:
                ends = np.degrees([stroke.start, stroke.end])
                axes.hlines([level, -level], *ends, color=ALARM, lw=0.9, ls=(0, (5, 3)), zorder=2)
    shown = [f"{bound:g}" for kinds, bound in panel.limits if kinds and bound * factor < high]
    if shown:
        words = f"red: limit {' and '.join(dict.fromkeys(shown))} {panel.unit}"
        panel.note = f"{panel.note}  ·  {words}" if panel.note else words


def _draw_impulses(axes: Any, panel: Panel) -> None:
    """An arrow for each impulse, as long as its share of the largest."""
    top = axes.get_ylim()[1]
    largest = max([abs(size) for _, size in panel.impulses], default=0.0)
    style = {"arrowstyle": "-|>", "color": INK, "lw": 1.2, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 9}
    for at, size in panel.impulses:
        length = (0.35 + 0.5 * abs(size) / largest) * top * np.sign(size)
        axes.annotate("", (at, length), (at, 0.0), arrowprops=style, zorder=4, annotation_clip=False)


def _draw_alarm(axes: Any, angles: Values, panel: Panel) -> None:
    """Where the cam is undercut; said once."""
    low, high = axes.get_ylim()
    style = {"fontsize": 7.5, "color": ALARM, "ha": "center", "va": "top"}
    found = []
    for angle, bad in zip(angles, panel.alarm or [], strict=panel.alarm is not None):
        if np.any(bad):
            axes.fill_between(angle, low, high, where=bad, color=ALARM, alpha=0.15, lw=0, zorder=0.5)
            found.append(float(np.mean(angle[bad])))
    if found:
        axes.text(min(max(found[0], 18.0), 342.0), high - 0.04 * (high - low), "undercut", **style)


def _draw_peak(axes: Any, peak: Peak, factor: float) -> None:
    value = peak.value * factor
    above = value >= 0.0
    axes.plot([peak.angle], [value], marker="o", ms=3.2, color=peak.colour, zorder=5, clip_on=False)
    width = 2.0 * len(peak.text)
    side = "left" if peak.angle < width else "right" if peak.angle > 360 - width else "center"
    place = {"ha": side, "va": "bottom" if above else "top", "fontsize": 7.5, "color": peak.colour, "zorder": 5}
    axes.annotate(peak.text, (peak.angle, value), (0, 3.5 if above else -3.5), textcoords="offset points", **place)


def _name_strokes(axes: Any, picture: Picture) -> None:
    """Name, angle and law of each stroke above a diagram, as far as there is room."""
    for stroke in picture.question.programme.strokes:
        start, angle = np.degrees([stroke.start, stroke.angle])
        name, size = NAMES[stroke.kind], f"{angle:.4g}°"
        lines = [f"{name} {size}", stroke.law or ""]
        if len(lines[0]) * DEGREES_A_LETTER > angle:
            lines = [name, size]
        lines = [text for text in lines if text and len(text) * DEGREES_A_LETTER <= angle * 1.15]
        style = {"ha": "center", "va": "top", "fontsize": 7.5, "color": COLOURS[stroke.kind]}
        place = {"textcoords": "offset points", "xycoords": ("data", "axes fraction")}
        axes.annotate("\n".join(lines), (start + angle / 2, 1.0), (0, 34), **place, **style)

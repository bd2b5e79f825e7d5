"""The contents of each diagram: values piece by piece, exact peaks, limits, impulses and notes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import isfinite, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import BoolArray, FloatArray
from camopt.core.quantities import DERIVATIVE_UNITS, QUANTITIES, motion_quantity
from camopt.core.quantities.unit_systems import shown_unit, to_shown_unit
from camopt.model.effects.motion import motion_scale
from camopt.model.motion.stroke import ALL_STROKES, RETURN, RISE
from camopt.show.drawing.limit_lines import limit_lines
from camopt.show.drawing.picture import STROKE_NAMES, Picture, four_digits, value_with_unit
from camopt.show.drawing.style import INK, REFERENCE_COLOUR

NEGLIGIBLE = 1e-6  # jumps below this share of the range are none, samples this near the peak are the peak
CURVATURE_CLIP = 4.0  # times the usual pitch curvature: where the diagram of curvature is cut off

PieceValues = list[FloatArray]
Curve = Callable[[FloatArray], FloatArray]


class MoveMark(NamedTuple):
    """A condition on a motion: from one cam angle to another, deg, and from one value to another."""

    start: float
    end: float
    low: float
    high: float


PITCH_POINT_TEXT = "pitch point "
"""Before the value of a peak that it is."""


@dataclass
class MarkedPeak:
    """A marked point: cam angle in deg, value, text, colour, and whether it is the least value."""

    angle: float
    value: float
    text: str
    colour: str = INK
    least: bool = False

    def with_factor(self, factor: float) -> "MarkedPeak":
        """The peak in another unit, with its text if that is the value alone."""
        value = factor * self.value
        return replace(self, value=value, text=four_digits(value) if self.text[-1:].isdigit() else self.text)


@dataclass
class Panel:
    """One diagram: values piece by piece, with notes. Values, peaks and limits are in ``unit``."""

    title: str
    unit: str
    values: PieceValues
    peaks: list[MarkedPeak] = field(default_factory=list)
    limits: list[tuple[int, float]] = field(default_factory=list)
    impulses: list[tuple[float, float]] = field(default_factory=list)  # cam angle in deg, size
    reference: PieceValues | None = None  # what the values are seen against, dash-dot
    other: PieceValues | None = None  # of the other flank, thin
    note: str = ""
    alarm: list[BoolArray] | None = None  # where this is true, piece by piece, the cam is undercut
    span: tuple[float, float] | None = None
    bands: list[tuple[float, float]] = field(default_factory=list)  # from where to where on the axis of values
    marks: list[MoveMark] = field(default_factory=list)
    quantity: str = ""  # that is an extreme of the values, of a load
    value_at: Curve | None = None  # the values at any cam angles, rad, of the diagrams that an animation shows

    def in_shown_units(self) -> "Panel":
        """The diagram in the unit in which results are shown; numbers in notes are so already."""
        one, at = to_shown_unit(1.0, self.unit), self.value_at
        if one == 1.0:
            return self
        return replace(
            self,
            unit=shown_unit(self.unit),
            values=[one * values for values in self.values],
            peaks=[each.with_factor(one) for each in self.peaks],
            limits=[(kinds, one * bound) for kinds, bound in self.limits],
            impulses=[(angle, one * size) for angle, size in self.impulses],
            reference=self.reference and [one * values for values in self.reference],
            other=self.other and [one * values for values in self.other],
            span=self.span and (one * self.span[0], one * self.span[1]),
            bands=[(one * low, one * high) for low, high in self.bands],
            marks=[mark._replace(low=one * mark.low, high=one * mark.high) for mark in self.marks],
            value_at=at and (lambda angles: one * at(angles)),
        )


def motion_panels(picture: Picture) -> list[Panel]:
    """The six diagrams of a design: displacement and its derivatives, pressure angle, curvature."""

    def panels_of_contact(each: Picture) -> list[Panel]:
        motion = [_derivative_panel(each, name, order) for order, name in enumerate(DERIVATIVE_UNITS, start=1)]
        return [_displacement_panel(each), *motion, _pressure_panel(each), _curvature_panel(each)]

    return merge_contacts(picture, panels_of_contact)


def merge_contacts(picture: Picture, made: Callable[[Picture], list[Panel]]) -> list[Panel]:
    """Diagrams of the first contact of a follower, with what they are of a second one as thin lines."""
    first, *further = (made(each) for each in picture.contacts)
    for others in further:
        first = [merge_second_contact(panel, other) for panel, other in zip(first, others, strict=True)]
    return first


def merge_second_contact(panel: Panel, other: Panel) -> Panel:
    """A diagram with the values of a second contact, where they differ, and the worse of their peaks."""
    if all(np.array_equal(one, two) for one, two in zip(panel.values, other.values, strict=True)):
        return panel
    every = np.concatenate([*panel.values, *other.values])
    span = (
        panel.span and (min(panel.span[0], other.span[0]), max(panel.span[1], other.span[1]))
        if other.span
        else None
    )
    usual = (float(np.nanmin(every)), float(np.nanmax(every))) if np.isfinite(every).any() else None
    note = "  ·  ".join(filter(None, ("thin: second contact", panel.note)))
    return replace(
        panel, other=other.values, span=span or usual, note=note, peaks=_worse_peaks(panel.peaks, other.peaks)
    )


def _worse_peaks(peaks: list[MarkedPeak], others: list[MarkedPeak]) -> list[MarkedPeak]:
    """Of the peaks of two contacts, if they have the same ones, the worse of each."""
    if len(peaks) != len(others):
        return peaks
    pairs = zip(peaks, others, strict=True)
    found = [(min if one.least else max)(one, two, key=lambda peak: abs(peak.value)) for one, two in pairs]
    pitch_points = [peak for peak in found if peak.text.startswith(PITCH_POINT_TEXT)]
    for other in sorted(pitch_points, key=lambda peak: -abs(peak.value))[1:]:  # the steepest contact has the one
        other.text, other.colour = other.text.removeprefix(PITCH_POINT_TEXT), INK
    return found


def _displacement_panel(picture: Picture) -> Panel:
    setup, tool = picture.problem.setup, picture.problem.programme.tool
    factor, unit = (np.degrees(1.0), "deg") if setup.tool_turns else (1.0, "mm")
    values = [rows[0] * factor for rows in picture.tool_motion]
    panel = Panel(_motion_title("Displacement", picture), unit, values)
    panel.peaks = _stroke_peaks(picture, picture.tool_kinds, values, {ALL_STROKES: tool.lift * factor})
    panel.marks, panel.value_at = move_marks(picture, 0, factor), lambda angles: tool.motion_at(angles)[0] * factor
    notes = ["squares: asked of moves"] if panel.marks else []
    if setup.train is not None:
        panel.reference, note = _follower_displacement(picture, tool.lift * factor)
        notes.append(note)
    if any(each.end > each.start for stroke in tool.strokes for each in stroke.through):
        notes = ["squares and bands: asked of moves"]
    if picture.problem.programme.radii:
        notes = ["squares: where arcs and lines meet"]
    dynamics = setup.dynamics
    if dynamics.lash is not None:
        low, high = ((dynamics.lash + side * dynamics.lash_variation) * factor for side in (-1, 1))
        panel.bands = [(low, high)]
        one, shown_as = to_shown_unit(1.0, panel.unit), shown_unit(panel.unit)
        ends = f"{one * low:.4g}" + (f" to {one * high:.4g} {shown_as}" if high > low else "")
        notes.append(f"grey: lash {ends}")
    panel.note = "  ·  ".join(notes)
    return panel


def _follower_displacement(picture: Picture, tool: float) -> tuple[PieceValues, str]:
    """The displacement of the follower beside that of a tool; in another unit as high as that."""
    setup, lift = picture.problem.setup, picture.problem.programme.lift
    factor, unit = (np.degrees(1.0), "deg") if setup.angular else (1.0, "mm")
    alike = setup.angular == setup.tool_turns
    as_high = factor if alike else tool / lift
    scaled = "" if alike else f" {shown_unit(unit)}, scaled to the same height"
    note = f"dash-dot: of the follower, up to {four_digits(to_shown_unit(lift * factor, unit))}{scaled}"
    return [rows[0] * as_high for rows in picture.motion], note


def move_marks(picture: Picture, order: int, factor: float) -> list[MoveMark]:
    """The conditions of the scene's moves on a derivative."""
    strokes = picture.problem.programme.tool.strokes
    every = [
        each for stroke in strokes for each in stroke.required_conditions(strokes[0].low) if each.order == order
    ]
    per = 180 / pi
    return [MoveMark(each.start * per, each.end * per, each.low * factor, each.high * factor) for each in every]


def _derivative_panel(picture: Picture, name: str, order: int) -> Panel:
    """Velocity, acceleration or jerk; impulses where the derivative below it jumps."""
    setup, programme = picture.problem.setup, picture.problem.programme.tool
    timed, factor = setup.omega is not None, motion_scale(setup, order)
    values = [rows[order] * factor for rows in picture.tool_motion]
    found = {
        kind: motion_quantity(name, STROKE_NAMES[kind], angular=setup.tool_turns, timed=timed)
        for kind in (RISE, RETURN)
    }
    exact = {kind: picture.values[key] for kind, key in found.items()}
    panel = Panel(_motion_title(name.capitalize(), picture), QUANTITIES[found[RISE]].unit, values)
    panel.peaks = _stroke_peaks(picture, picture.tool_kinds, values, exact)
    panel.marks, panel.value_at = (
        move_marks(picture, order, factor),
        lambda angles: programme.motion_at(angles)[order] * factor,
    )
    panel.impulses = [(np.degrees(j.at), j.size * factor) for j in programme.jumps if j.order == order - 1]
    if panel.impulses:
        panel.note = f"arrows: impulses, where the {list(DERIVATIVE_UNITS)[order - 2]} jumps"
    if order == 3 and programme.corners:
        panel.note = "no jerk at the corners, where the velocity jumps"
    panel.limits = limit_lines(picture, motion_quantity(name, "", angular=setup.tool_turns, timed=timed))
    return panel


def _pressure_panel(picture: Picture) -> Panel:
    """Signed pressure angle; for a face square to the motion, which has none, the contact on the face."""
    mechanism, design = picture.problem.setup.mechanism, picture.problem.design
    programme, exact = picture.problem.programme, picture.values
    if exact["pressure_angle_max_deg"] == 0.0 and mechanism.reach is not None:
        reach = partial(picture.curve_at, mechanism.reach(design, programme))
        values = [reach(angles) for angles in picture.pieces]
        peaks = quantity_peaks(picture, values, "face_reach_max_mm", "face_reach_min_mm")
        limits, note = limit_lines(picture, "face_reach_max_mm"), "pressure angle 0 throughout"
        return Panel("Contact on the face", "mm", values, peaks, limits, note=note, value_at=reach)
    tangent = partial(picture.curve_at, mechanism.pressure(design, programme))
    values = [np.degrees(np.arctan(tangent(angles))) for angles in picture.pieces]
    bounds = {kind: exact[f"pressure_angle_max_{STROKE_NAMES[kind]}_deg"] for kind in (RISE, RETURN)}
    panel = Panel("Pressure angle", "deg", values, _stroke_peaks(picture, picture.kinds, values, bounds, "°"))
    panel.value_at = lambda angles: np.degrees(np.arctan(tangent(angles)))
    _mark_pitch_point(panel, exact)
    panel.limits = limit_lines(picture, "pressure_angle_max_deg")
    return panel


def _mark_pitch_point(panel: Panel, exact: dict[str, Any]) -> None:
    """Mark the pitch point in place of the peak that it is; in a dwell it is a peak of its own."""
    largest, at = exact["pressure_angle_max_deg"], exact["pressure_angle_max_at_deg"]
    alike = [peak for peak in panel.peaks if abs(peak.value) >= largest * (1 - NEGLIGIBLE)]
    if alike:
        peak = min(alike, key=lambda peak: abs((peak.angle - at + 180.0) % 360.0 - 180.0))
        peak.angle, peak.text, peak.colour = at, f"{PITCH_POINT_TEXT}{peak.text}", REFERENCE_COLOUR
        return
    every = np.concatenate(panel.values)
    value = float(every[np.argmax(np.abs(every))])
    panel.peaks.append(
        MarkedPeak(at, value, f"{PITCH_POINT_TEXT}{four_digits(np.copysign(largest, value))}°", REFERENCE_COLOUR)
    )


def _curvature_panel(picture: Picture) -> Panel:
    """Curvature of pitch curve and profile; for a flat face the radius of curvature, which may pass through 0."""
    mechanism, design = picture.problem.setup.mechanism, picture.problem.design
    programme, least = picture.problem.programme, picture.values["profile_radius_min_mm"]
    if mechanism.profile_radius is not None:
        values = picture.curve_values(mechanism.profile_radius(design, programme))
        peaks = extreme_peaks(picture, values, (np.nan, least)) if isfinite(least) else []
        limits, alarm = limit_lines(picture, "profile_radius_min_mm"), [v <= 0.0 for v in values]
        panel = Panel("Radius of curvature of the profile", "mm", values, peaks, limits, alarm=alarm)
    else:
        assert mechanism.curvature is not None
        panel = _trace_curvature_panel(picture, picture.curve_values(mechanism.curvature(design, programme)))
    if programme.corners:
        panel.note = "corners, where the velocity jumps, left out"
    return panel


def _trace_curvature_panel(picture: Picture, pitch: PieceValues) -> Panel:
    mechanism, radius = picture.problem.setup.mechanism, picture.problem.half_width
    both, flanks = mechanism.two_sided, mechanism.flanks[: None if radius else 1]
    every = np.concatenate(pitch)
    finite = [k[np.isfinite(k)] for k in (every, _offset_curvature(every, radius, np.inf))]
    usual = [np.percentile(np.abs(k), q) for k, q in zip(finite, (95, 50), strict=True) if k.size]
    cap = CURVATURE_CLIP * float(max(usual, default=1.0))  # so that a cusp does not flatten all the rest
    profiles = [[_offset_curvature(k, flank.bulge * radius, cap) for k in pitch] for flank in flanks]
    panel = Panel(f"Curvature of the {'flanks' if both else 'profile'}", "1/mm", profiles[0])
    if radius > 0.0:
        panel.reference = pitch
        panel.other = profiles[1] if both else None
        panel.alarm = [(np.abs(k) if both else k) * radius >= 1.0 for k in pitch]
        thin = f"thin: {flanks[1].words}  ·  " if both else ""
        panel.note = f"{thin}dash-dot: pitch curve"
    every = np.concatenate([*pitch, *(values for side in profiles for values in side)])
    every = every[np.isfinite(every) & (np.abs(every) <= cap)]
    panel.span = (float(every.min(initial=0.0)), float(every.max(initial=0.0)))
    least = picture.values["profile_radius_min_mm"]
    if isfinite(least) and least > 0.0 and not both:
        peaks = extreme_peaks(picture, profiles[0], (1.0 / least, np.nan))
        panel.peaks = [
            MarkedPeak(p.angle, p.value, f"ρ {value_with_unit(least)}") for p in peaks if abs(p.value) <= cap
        ]
    panel.limits = [(kinds, 1.0 / bound) for kinds, bound in limit_lines(picture, "profile_radius_min_mm")]
    return panel


def _offset_curvature(pitch: FloatArray, radius: float, cap: float) -> FloatArray:
    """κ/(1 − κ·R), without the parts that are cut away or beyond the cap."""
    share = 1.0 - pitch * radius
    with np.errstate(all="ignore"):
        curvature = pitch / share
    return np.where((share > 0.0) & (np.abs(curvature) <= cap), curvature, np.nan)


def has_quantities(picture: Picture, *names: str) -> bool:
    """Whether quantities were computed, and are finite."""
    return all(isfinite(picture.values.get(name, np.inf)) for name in names)


def _motion_title(title: str, picture: Picture) -> str:
    """The title of a diagram of the motion that is asked."""
    return title if picture.problem.setup.train is None else f"{title} of the tool"


def _stroke_peaks(
    picture: Picture, kinds_of: Sequence[int], values: PieceValues, exact: dict[int, float], sign: str = ""
) -> list[MarkedPeak]:
    """The largest magnitude over strokes of given kinds: its place from the samples, its value exact."""
    found = []
    for kinds, largest in exact.items():
        chosen = [k for k, kind in enumerate(kinds_of) if kind & kinds]
        if chosen and isfinite(largest) and largest > 0.0:
            every = np.concatenate([values[k] for k in chosen])
            at = float(np.nanargmax(np.abs(every)))
            direction = np.sign(every[int(at)])
            angle = _middle_of_peak(np.concatenate([picture.pieces[k] for k in chosen]), every * direction)
            found.append(MarkedPeak(angle, direction * largest, f"{four_digits(direction * largest)}{sign}"))
    return found


def quantity_peaks(picture: Picture, values: PieceValues, greatest: str, least: str) -> list[MarkedPeak]:
    """The peaks of the greatest and the least value, by their quantities; none for an empty name."""
    return extreme_peaks(picture, values, tuple(picture.values.get(name, np.nan) for name in (greatest, least)))


def extreme_peaks(picture: Picture, values: PieceValues, exact: tuple[float, ...]) -> list[MarkedPeak]:
    """The peaks of the greatest and the least value, if these are finite."""
    angles, every = np.concatenate(picture.pieces), np.concatenate(values)
    if not np.isfinite(every).any():
        return []
    sides = [(sign, value) for sign, value in zip((1.0, -1.0), exact, strict=True) if isfinite(value)]
    return [
        MarkedPeak(_middle_of_peak(angles, every * sign), value, four_digits(value), least=sign < 0.0)
        for sign, value in sides
    ]


def magnitude_peak(picture: Picture, values: PieceValues, name: str, *, least: bool = False) -> MarkedPeak:
    """The largest magnitude, or the least, by the name of its quantity."""
    angles, every = np.concatenate(picture.pieces), np.concatenate(values)
    at = int(np.nanargmin(np.abs(every)) if least else np.nanargmax(np.abs(every)))
    sign = float(np.copysign(1.0, every[at]))
    exact = sign * picture.values[name]
    return MarkedPeak(
        _middle_of_peak(angles, -np.abs(every) if least else sign * every), exact, four_digits(exact), least=least
    )


def load_panel(
    picture: Picture,
    title: str,
    name: str,
    values: PieceValues,
    *,
    least: bool = False,
    kinds: int = 0,
    **more: Any,
) -> Panel:
    """The diagram of a load whose largest magnitude, or least, is a quantity, with the limits on that."""
    peaks, limits = [magnitude_peak(picture, values, name, least=least)], limit_lines(picture, name, kinds)
    return Panel(title, QUANTITIES[name].unit, values, peaks, limits, quantity=name, **more)


def _middle_of_peak(angles: FloatArray, values: FloatArray) -> float:
    """Cam angle in deg of the greatest value; the middle of the first plateau."""
    top = float(np.nanmax(values))
    near = np.flatnonzero(values >= top - NEGLIGIBLE * abs(top))
    ends = np.flatnonzero(np.diff(near) > 1)
    last = near[ends[0]] if ends.size else near[-1]
    return float(np.degrees(angles[near[0]] + angles[last]) / 2)

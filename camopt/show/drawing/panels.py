"""Contents of diagrams over the cam angle: values by smooth pieces, exact peaks, limits, impulses and notes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import isfinite, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import BoolArray, FloatArray
from camopt.core.quantities import DERIVATIVE_UNITS, QUANTITIES, motion_peak_name
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.motion.stroke import ALL_STROKES, RETURN, RISE
from camopt.show.drawing.limit_lines import stroke_kinds_and_limit_levels
from camopt.show.drawing.picture import STROKE_NAMES, Picture, four_digit_text, value_with_unit
from camopt.show.drawing.style import INK, REFERENCE_COLOUR

NEGLIGIBLE = 1e-6  # share of the range: smaller jumps are not drawn, samples this near a peak belong to it
CURVATURE_CLIP = 4.0  # times the usual pitch curvature: larger curvature is cut off in the diagram

PieceValues = list[FloatArray]
Curve = Callable[[FloatArray], FloatArray]


class MoveMark(NamedTuple):
    """A condition of the scene on the motion: a range of cam angles [deg] and a range of values."""

    start: float
    end: float
    low: float
    high: float


PITCH_POINT_TEXT = "pitch point "
"""Start of the text at the pitch point."""


@dataclass
class MarkedPeak:
    """A marked peak: cam angle [deg], value, text, colour, and whether it is the smallest value."""

    angle: float
    value: float
    text: str
    colour: str = INK
    least: bool = False

    def with_factor(self, factor: float) -> "MarkedPeak":
        """The peak in another unit; a text that ends in a digit is replaced by the new value."""
        value = factor * self.value
        return replace(self, value=value, text=four_digit_text(value) if self.text[-1:].isdigit() else self.text)


@dataclass
class Panel:
    """One diagram: values by smooth pieces, with notes. Values, peaks and limits are in ``unit``."""

    title: str
    unit: str
    values: PieceValues
    peaks: list[MarkedPeak] = field(default_factory=list)
    limits: list[tuple[int, float]] = field(default_factory=list)
    impulses: list[tuple[float, float]] = field(default_factory=list)  # cam angle in deg, size
    reference: PieceValues | None = None  # values for comparison, dash-dot
    other: PieceValues | None = None  # values of the other flank or contact, thin
    note: str = ""
    alarm: list[BoolArray] | None = None  # true where the cam is undercut, by pieces
    span: tuple[float, float] | None = None
    bands: list[tuple[float, float]] = field(default_factory=list)  # ranges of values shaded over the turn
    marks: list[MoveMark] = field(default_factory=list)
    quantity: str = ""  # of a load: the quantity that is an extreme of the values
    value_at: Curve | None = None  # values at any cam angles [rad], for diagrams in animations

    def in_shown_units(self) -> "Panel":
        """The diagram in the unit in which results are shown. Notes already use it."""
        factor, at = to_shown_unit(1.0, self.unit), self.value_at
        if factor == 1.0:
            return self
        return replace(
            self,
            unit=unit_in_shown_system(self.unit),
            values=[factor * values for values in self.values],
            peaks=[peak.with_factor(factor) for peak in self.peaks],
            limits=[(kinds, factor * bound) for kinds, bound in self.limits],
            impulses=[(angle, factor * size) for angle, size in self.impulses],
            reference=self.reference and [factor * values for values in self.reference],
            other=self.other and [factor * values for values in self.other],
            span=self.span and (factor * self.span[0], factor * self.span[1]),
            bands=[(factor * low, factor * high) for low, high in self.bands],
            marks=[mark._replace(low=factor * mark.low, high=factor * mark.high) for mark in self.marks],
            value_at=at and (lambda angles: factor * at(angles)),
        )


def motion_panels(picture: Picture) -> list[Panel]:
    """The six diagrams of a design: displacement and its derivatives, pressure angle, curvature."""

    def panels_of_contact(contact: Picture) -> list[Panel]:
        motion = [_derivative_panel(contact, name, order) for order, name in enumerate(DERIVATIVE_UNITS, start=1)]
        return [_displacement_panel(contact), *motion, _pressure_panel(contact), _curvature_panel(contact)]

    return merge_contact_panels(picture, panels_of_contact)


def merge_contact_panels(picture: Picture, panels_of: Callable[[Picture], list[Panel]]) -> list[Panel]:
    """The diagrams of the first contact of a follower, with those of a second contact as thin lines."""
    first, *further = (panels_of(contact) for contact in picture.contacts)
    for others in further:
        first = [merge_second_contact(panel, other) for panel, other in zip(first, others, strict=True)]
    return first


def merge_second_contact(panel: Panel, second_panel: Panel) -> Panel:
    """A diagram with the values of a second contact, if they differ, and the larger peaks of both."""
    if all(np.array_equal(one, two) for one, two in zip(panel.values, second_panel.values, strict=True)):
        return panel
    every = np.concatenate([*panel.values, *second_panel.values])
    span = (
        panel.span and (min(panel.span[0], second_panel.span[0]), max(panel.span[1], second_panel.span[1]))
        if second_panel.span
        else None
    )
    usual = (float(np.nanmin(every)), float(np.nanmax(every))) if np.isfinite(every).any() else None
    note = "  ·  ".join(filter(None, ("thin: second contact", panel.note)))
    return replace(
        panel,
        other=second_panel.values,
        span=span or usual,
        note=note,
        peaks=_larger_peaks(panel.peaks, second_panel.peaks),
    )


def _larger_peaks(peaks: list[MarkedPeak], second_peaks: list[MarkedPeak]) -> list[MarkedPeak]:
    """The larger of each pair of peaks of two contacts; those of the first if the numbers of peaks differ."""
    if len(peaks) != len(second_peaks):
        return peaks
    pairs = zip(peaks, second_peaks, strict=True)
    worse = [(min if one.least else max)(one, two, key=lambda peak: abs(peak.value)) for one, two in pairs]
    pitch_points = [peak for peak in worse if peak.text.startswith(PITCH_POINT_TEXT)]
    for other in sorted(pitch_points, key=lambda peak: -abs(peak.value))[
        1:
    ]:  # only the steepest contact has a pitch point
        other.text, other.colour = other.text.removeprefix(PITCH_POINT_TEXT), INK
    return worse


def _displacement_panel(picture: Picture) -> Panel:
    setup, tool = picture.problem.setup, picture.problem.programme.tool
    factor, unit = (np.degrees(1.0), "deg") if setup.tool_turns else (1.0, "mm")
    values = [rows[0] * factor for rows in picture.tool_motion]
    panel = Panel(_motion_title("Displacement", picture), unit, values)
    panel.peaks = _stroke_peaks(
        picture, picture.tool_stroke_kind_of_each_piece, values, {ALL_STROKES: tool.lift * factor}
    )
    panel.marks, panel.value_at = (
        move_condition_marks(picture, 0, factor),
        lambda angles: tool.motion_at(angles)[0] * factor,
    )
    notes = ["squares: conditions of moves"] if panel.marks else []
    if setup.train is not None:
        panel.reference, note = _scaled_follower_displacement(picture, tool.lift * factor)
        notes.append(note)
    if any(each.end > each.start for stroke in tool.strokes for each in stroke.through):
        notes = ["squares and bands: conditions of moves"]
    if picture.problem.programme.radii:
        notes = ["squares: where arcs and lines meet"]
    dynamics = setup.dynamics
    if dynamics.lash is not None:
        low, high = ((dynamics.lash + side * dynamics.lash_variation) * factor for side in (-1, 1))
        panel.bands = [(low, high)]
        scale, unit_name = to_shown_unit(1.0, panel.unit), unit_in_shown_system(panel.unit)
        ends = f"{scale * low:.4g}" + (f" to {scale * high:.4g} {unit_name}" if high > low else "")
        notes.append(f"grey: lash {ends}")
    panel.note = "  ·  ".join(notes)
    return panel


def _scaled_follower_displacement(picture: Picture, tool_lift: float) -> tuple[PieceValues, str]:
    """The displacement of the follower for the diagram of its tool, and a note.

    If their units differ, it is scaled to the height of the tool's displacement.
    """
    setup, lift = picture.problem.setup, picture.problem.programme.lift
    factor, unit = (np.degrees(1.0), "deg") if setup.angular else (1.0, "mm")
    same_unit = setup.angular == setup.tool_turns
    scale = factor if same_unit else tool_lift / lift
    scaled = "" if same_unit else f" {unit_in_shown_system(unit)}, scaled to the same height"
    note = f"dash-dot: follower, up to {four_digit_text(to_shown_unit(lift * factor, unit))}{scaled}"
    return [rows[0] * scale for rows in picture.motion], note


def move_condition_marks(picture: Picture, order: int, factor: float) -> list[MoveMark]:
    """The conditions of the scene's moves on a derivative of the motion."""
    strokes = picture.problem.programme.tool.strokes
    conditions = [
        each for stroke in strokes for each in stroke.conditions_in_mm_or_rad(strokes[0].low) if each.order == order
    ]
    per = 180 / pi
    return [MoveMark(c.start * per, c.end * per, c.low * factor, c.high * factor) for c in conditions]


def _derivative_panel(picture: Picture, name: str, order: int) -> Panel:
    """Velocity, acceleration or jerk; impulses where the derivative below it jumps."""
    setup, programme = picture.problem.setup, picture.problem.programme.tool
    timed, factor = setup.omega is not None, motion_unit_factor(setup, order)
    values = [rows[order] * factor for rows in picture.tool_motion]
    names = {
        kind: motion_peak_name(name, STROKE_NAMES[kind], angular=setup.tool_turns, timed=timed)
        for kind in (RISE, RETURN)
    }
    exact = {kind: picture.quantity_values[key] for kind, key in names.items()}
    panel = Panel(_motion_title(name.capitalize(), picture), QUANTITIES[names[RISE]].unit, values)
    panel.peaks = _stroke_peaks(picture, picture.tool_stroke_kind_of_each_piece, values, exact)
    panel.marks, panel.value_at = (
        move_condition_marks(picture, order, factor),
        lambda angles: programme.motion_at(angles)[order] * factor,
    )
    panel.impulses = [(np.degrees(j.at), j.size * factor) for j in programme.jumps if j.order == order - 1]
    if panel.impulses:
        panel.note = f"arrows: impulses, where the {list(DERIVATIVE_UNITS)[order - 2]} jumps"
    if order == 3 and programme.corners:
        panel.note = "no jerk at the corners, where the velocity jumps"
    panel.limits = stroke_kinds_and_limit_levels(
        picture, motion_peak_name(name, "", angular=setup.tool_turns, timed=timed)
    )
    return panel


def _pressure_panel(picture: Picture) -> Panel:
    """Signed pressure angle; the contact on the face if the pressure angle is 0 throughout."""
    mechanism, design = picture.problem.setup.mechanism, picture.problem.design
    programme, exact = picture.problem.programme, picture.quantity_values
    if exact["pressure_angle_max_deg"] == 0.0 and mechanism.reach is not None:
        reach = partial(picture.curve_values_at, mechanism.reach(design, programme))
        values = [reach(angles) for angles in picture.angles_of_pieces]
        peaks = extreme_quantity_peaks(picture, values, "face_reach_max_mm", "face_reach_min_mm")
        limits, note = stroke_kinds_and_limit_levels(picture, "face_reach_max_mm"), "pressure angle 0 throughout"
        return Panel("Contact on the face", "mm", values, peaks, limits, note=note, value_at=reach)
    tangent = partial(picture.curve_values_at, mechanism.pressure(design, programme))
    values = [np.degrees(np.arctan(tangent(angles))) for angles in picture.angles_of_pieces]
    bounds = {kind: exact[f"pressure_angle_max_{STROKE_NAMES[kind]}_deg"] for kind in (RISE, RETURN)}
    panel = Panel(
        "Pressure angle",
        "deg",
        values,
        _stroke_peaks(picture, picture.stroke_kind_of_each_piece, values, bounds, "°"),
    )
    panel.value_at = lambda angles: np.degrees(np.arctan(tangent(angles)))
    _mark_pitch_point(panel, exact)
    panel.limits = stroke_kinds_and_limit_levels(picture, "pressure_angle_max_deg")
    return panel


def _mark_pitch_point(panel: Panel, exact_values: dict[str, Any]) -> None:
    """Mark the pitch point: at the peak where it lies, or as a further peak in a dwell."""
    largest, at = exact_values["pressure_angle_max_deg"], exact_values["pressure_angle_max_at_deg"]
    candidates = [peak for peak in panel.peaks if abs(peak.value) >= largest * (1 - NEGLIGIBLE)]
    if candidates:
        peak = min(candidates, key=lambda peak: abs((peak.angle - at + 180.0) % 360.0 - 180.0))
        peak.angle, peak.text, peak.colour = at, f"{PITCH_POINT_TEXT}{peak.text}", REFERENCE_COLOUR
        return
    every = np.concatenate(panel.values)
    value = float(every[np.argmax(np.abs(every))])
    panel.peaks.append(
        MarkedPeak(
            at, value, f"{PITCH_POINT_TEXT}{four_digit_text(np.copysign(largest, value))}°", REFERENCE_COLOUR
        )
    )


def _curvature_panel(picture: Picture) -> Panel:
    """Curvature of pitch curve and profile; for a flat face the radius of curvature, which may cross 0."""
    mechanism, design = picture.problem.setup.mechanism, picture.problem.design
    programme, least = picture.problem.programme, picture.quantity_values["profile_radius_min_mm"]
    if mechanism.profile_radius is not None:
        values = picture.curve_values(mechanism.profile_radius(design, programme))
        peaks = extreme_peaks(picture, values, (np.nan, least)) if isfinite(least) else []
        limits, alarm = stroke_kinds_and_limit_levels(picture, "profile_radius_min_mm"), [v <= 0.0 for v in values]
        panel = Panel("Radius of curvature of the profile", "mm", values, peaks, limits, alarm=alarm)
    else:
        assert mechanism.curvature is not None
        panel = _trace_curvature_panel(picture, picture.curve_values(mechanism.curvature(design, programme)))
    if programme.corners:
        panel.note = "without corners, where the velocity jumps"
    return panel


def _trace_curvature_panel(picture: Picture, pitch: PieceValues) -> Panel:
    mechanism, radius = picture.problem.setup.mechanism, picture.problem.wall_distance_from_pitch_curve
    both, flanks = mechanism.has_flanks_on_both_sides, mechanism.flanks[: None if radius else 1]
    every = np.concatenate(pitch)
    finite = [k[np.isfinite(k)] for k in (every, _profile_curvature_from_pitch(every, radius, np.inf))]
    usual = [np.percentile(np.abs(k), q) for k, q in zip(finite, (95, 50), strict=True) if k.size]
    cap = CURVATURE_CLIP * float(max(usual, default=1.0))  # so that a cusp does not flatten the rest
    profiles = [[_profile_curvature_from_pitch(k, flank.bulge * radius, cap) for k in pitch] for flank in flanks]
    panel = Panel(f"Curvature of the {'flanks' if both else 'profile'}", "1/mm", profiles[0])
    if radius > 0.0:
        panel.reference = pitch
        panel.other = profiles[1] if both else None
        panel.alarm = [(np.abs(k) if both else k) * radius >= 1.0 for k in pitch]
        thin = f"thin: {flanks[1].display_name}  ·  " if both else ""
        panel.note = f"{thin}dash-dot: pitch curve"
    every = np.concatenate([*pitch, *(values for side in profiles for values in side)])
    every = every[np.isfinite(every) & (np.abs(every) <= cap)]
    panel.span = (float(every.min(initial=0.0)), float(every.max(initial=0.0)))
    least = picture.quantity_values["profile_radius_min_mm"]
    if isfinite(least) and least > 0.0 and not both:
        peaks = extreme_peaks(picture, profiles[0], (1.0 / least, np.nan))
        panel.peaks = [
            MarkedPeak(p.angle, p.value, f"ρ {value_with_unit(least)}") for p in peaks if abs(p.value) <= cap
        ]
    panel.limits = [
        (kinds, 1.0 / bound) for kinds, bound in stroke_kinds_and_limit_levels(picture, "profile_radius_min_mm")
    ]
    return panel


def _profile_curvature_from_pitch(pitch: FloatArray, radius: float, cap: float) -> FloatArray:
    """Curvature κ/(1 − κ·R) of the profile; NaN where it is cut away or beyond the cap."""
    share = 1.0 - pitch * radius
    with np.errstate(all="ignore"):
        curvature = pitch / share
    return np.where((share > 0.0) & (np.abs(curvature) <= cap), curvature, np.nan)


def has_finite_quantities(picture: Picture, *names: str) -> bool:
    """Whether quantities were computed and are finite."""
    return all(isfinite(picture.quantity_values.get(name, np.inf)) for name in names)


def _motion_title(title: str, picture: Picture) -> str:
    """The title of a diagram of the motion that the scene gives."""
    return title if picture.problem.setup.train is None else f"{title} of the tool"


def _stroke_peaks(
    picture: Picture,
    kind_of_each_piece: Sequence[int],
    values: PieceValues,
    exact_peaks_by_kinds: dict[int, float],
    unit_sign: str = "",
) -> list[MarkedPeak]:
    """Peaks of the magnitude, one for each key of ``exact_peaks_by_kinds``: angles from samples, values exact."""
    peaks = []
    for kinds, largest in exact_peaks_by_kinds.items():
        chosen = [k for k, kind in enumerate(kind_of_each_piece) if kind & kinds]
        if chosen and isfinite(largest) and largest > 0.0:
            every = np.concatenate([values[k] for k in chosen])
            at = float(np.nanargmax(np.abs(every)))
            direction = np.sign(every[int(at)])
            angle = _peak_middle_angle_deg(
                np.concatenate([picture.angles_of_pieces[k] for k in chosen]), every * direction
            )
            peaks.append(
                MarkedPeak(angle, direction * largest, f"{four_digit_text(direction * largest)}{unit_sign}")
            )
    return peaks


def extreme_quantity_peaks(
    picture: Picture, values: PieceValues, largest_quantity: str, smallest_quantity: str
) -> list[MarkedPeak]:
    """Peaks of the largest and smallest value, by the names of their quantities; "" for none."""
    return extreme_peaks(
        picture,
        values,
        tuple(picture.quantity_values.get(name, np.nan) for name in (largest_quantity, smallest_quantity)),
    )


def extreme_peaks(picture: Picture, values: PieceValues, exact_extremes: tuple[float, ...]) -> list[MarkedPeak]:
    """Peaks of the largest and smallest value, if ``exact_extremes`` has finite values for them."""
    angles, every = np.concatenate(picture.angles_of_pieces), np.concatenate(values)
    if not np.isfinite(every).any():
        return []
    sides = [(sign, value) for sign, value in zip((1.0, -1.0), exact_extremes, strict=True) if isfinite(value)]
    return [
        MarkedPeak(_peak_middle_angle_deg(angles, every * sign), value, four_digit_text(value), least=sign < 0.0)
        for sign, value in sides
    ]


def magnitude_peak(picture: Picture, values: PieceValues, quantity_name: str, *, least: bool = False) -> MarkedPeak:
    """The peak of the largest magnitude, or the smallest, by the name of its quantity."""
    angles, every = np.concatenate(picture.angles_of_pieces), np.concatenate(values)
    at = int(np.nanargmin(np.abs(every)) if least else np.nanargmax(np.abs(every)))
    sign = float(np.copysign(1.0, every[at]))
    exact = sign * picture.quantity_values[quantity_name]
    return MarkedPeak(
        _peak_middle_angle_deg(angles, -np.abs(every) if least else sign * every),
        exact,
        four_digit_text(exact),
        least=least,
    )


def load_panel(
    picture: Picture,
    title: str,
    quantity_name: str,
    values: PieceValues,
    *,
    least: bool = False,
    stroke_kinds: int = 0,
    **panel_fields: Any,
) -> Panel:
    """The diagram of a load whose largest (or smallest) magnitude is a quantity, with the limits on it."""
    peaks, limits = (
        [magnitude_peak(picture, values, quantity_name, least=least)],
        stroke_kinds_and_limit_levels(picture, quantity_name, stroke_kinds),
    )
    return Panel(
        title, QUANTITIES[quantity_name].unit, values, peaks, limits, quantity=quantity_name, **panel_fields
    )


def _peak_middle_angle_deg(angles: FloatArray, values: FloatArray) -> float:
    """Cam angle of the largest value [deg]; on a plateau its middle."""
    top = float(np.nanmax(values))
    near = np.flatnonzero(values >= top - NEGLIGIBLE * abs(top))
    ends = np.flatnonzero(np.diff(near) > 1)
    last = near[ends[0]] if ends.size else near[-1]
    return float(np.degrees(angles[near[0]] + angles[last]) / 2)

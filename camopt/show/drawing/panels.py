"""Contents of diagrams over the cam angle: values by smooth pieces, exact peaks, limits, impulses and notes."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import isfinite, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LARGEST_MAGNITUDE, BoolArray, FloatArray
from camopt.core.quantities import DERIVATIVE_UNITS, QUANTITIES, motion_peak_name
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.effects.peak import DOUBLES, Peak
from camopt.model.motion.stroke import ALL_STROKES, RETURN, RISE, WAYS
from camopt.scene.problem.constraints import Constraint, QuantityBound
from camopt.scene.problem.limits import peak_at_first_contact
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
    """A diagram with the values of a second contact, if they differ, and the larger peaks of both.

    If the numbers of peaks differ, the peaks are those of the first contact.
    """
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
    peaks = panel.peaks
    if len(peaks) == len(second_panel.peaks):
        pairs = zip(peaks, second_panel.peaks, strict=True)
        peaks = [(min if one.least else max)(one, two, key=lambda peak: abs(peak.value)) for one, two in pairs]
        pitch_points = [peak for peak in peaks if peak.text.startswith(PITCH_POINT_TEXT)]
        pitch_points.sort(key=lambda peak: -abs(peak.value))
        for other in pitch_points[1:]:  # only the steepest contact has a pitch point
            other.text, other.colour = other.text.removeprefix(PITCH_POINT_TEXT), INK
    return replace(panel, other=second_panel.values, span=span or usual, note=note, peaks=peaks)


def _displacement_panel(picture: Picture) -> Panel:
    setup, tool = picture.problem.setup, picture.problem.programme.tool
    factor, unit = (np.degrees(1.0), "deg") if setup.tool_turns else (1.0, "mm")
    values = [rows[0] * factor for rows in picture.tool_motion]
    exact = {ALL_STROKES: tool.lift * factor}
    marks, bands, reference = move_condition_marks(picture, 0, factor), [], None
    notes = ["squares: conditions of moves"] if marks else []
    if setup.train is not None:
        reference, note = _scaled_follower_displacement(picture, tool.lift * factor)
        notes.append(note)
    if any(each.end > each.start for stroke in tool.strokes for each in stroke.through):
        notes = ["squares and bands: conditions of moves"]
    if picture.problem.programme.radii:
        notes = ["squares: where arcs and lines meet"]
    dynamics = setup.dynamics
    if dynamics.lash is not None:
        low, high = ((dynamics.lash + side * dynamics.lash_variation) * factor for side in (-1, 1))
        bands = [(low, high)]
        scale, unit_name = to_shown_unit(1.0, unit), unit_in_shown_system(unit)
        ends = f"{scale * low:.4g}" + (f" to {scale * high:.4g} {unit_name}" if high > low else "")
        notes.append(f"grey: lash {ends}")
    return Panel(
        _motion_title("Displacement", picture),
        unit,
        values,
        _stroke_peaks(picture, picture.tool_stroke_kind_of_each_piece, values, exact),
        reference=reference,
        note="  ·  ".join(notes),
        bands=bands,
        marks=marks,
        value_at=lambda angles: tool.motion_at(angles)[0] * factor,
    )


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
    impulses = [(np.degrees(j.at), j.size * factor) for j in programme.jumps if j.order == order - 1]
    note = f"arrows: impulses, where the {list(DERIVATIVE_UNITS)[order - 2]} jumps" if impulses else ""
    if order == 3 and programme.corners:
        note = "no jerk at the corners, where the velocity jumps"
    whole_turn = motion_peak_name(name, "", angular=setup.tool_turns, timed=timed)
    return Panel(
        _motion_title(name.capitalize(), picture),
        QUANTITIES[names[RISE]].unit,
        values,
        _stroke_peaks(picture, picture.tool_stroke_kind_of_each_piece, values, exact),
        stroke_kinds_and_limit_levels(picture, whole_turn),
        impulses,
        note=note,
        marks=move_condition_marks(picture, order, factor),
        value_at=lambda angles: programme.motion_at(angles)[order] * factor,
    )


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
    peaks = _stroke_peaks(picture, picture.stroke_kind_of_each_piece, values, bounds, "°")
    # the pitch point is at the peak where it lies, or a further peak in a dwell
    largest, at = exact["pressure_angle_max_deg"], exact["pressure_angle_max_at_deg"]
    candidates = [peak for peak in peaks if abs(peak.value) >= largest * (1 - NEGLIGIBLE)]
    if candidates:
        peak = min(candidates, key=lambda peak: abs((peak.angle - at + 180.0) % 360.0 - 180.0))
        peak.angle, peak.text, peak.colour = at, f"{PITCH_POINT_TEXT}{peak.text}", REFERENCE_COLOUR
    else:
        every = np.concatenate(values)
        value = float(every[np.argmax(np.abs(every))])
        text = f"{PITCH_POINT_TEXT}{four_digit_text(np.copysign(largest, value))}°"
        peaks.append(MarkedPeak(at, value, text, REFERENCE_COLOUR))
    limits = stroke_kinds_and_limit_levels(picture, "pressure_angle_max_deg")
    return Panel(
        "Pressure angle",
        "deg",
        values,
        peaks,
        limits,
        value_at=lambda angles: np.degrees(np.arctan(tangent(angles))),
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
    every = np.concatenate([*pitch, *(values for side in profiles for values in side)])
    every = every[np.isfinite(every) & (np.abs(every) <= cap)]
    least, peaks = picture.quantity_values["profile_radius_min_mm"], []
    if isfinite(least) and least > 0.0 and not both:
        peaks = extreme_peaks(picture, profiles[0], (1.0 / least, np.nan))
    limits = stroke_kinds_and_limit_levels(picture, "profile_radius_min_mm")
    rolls = radius > 0.0
    thin = f"thin: {flanks[1].display_name}  ·  " if rolls and both else ""
    return Panel(
        f"Curvature of the {'flanks' if both else 'profile'}",
        "1/mm",
        profiles[0],
        [MarkedPeak(p.angle, p.value, f"ρ {value_with_unit(least)}") for p in peaks if abs(p.value) <= cap],
        [(kinds, 1.0 / bound) for kinds, bound in limits],
        reference=pitch if rolls else None,
        other=profiles[1] if rolls and both else None,
        note=f"{thin}dash-dot: pitch curve" if rolls else "",
        alarm=[(np.abs(k) if both else k) * radius >= 1.0 for k in pitch] if rolls else None,
        span=(float(every.min(initial=0.0)), float(every.max(initial=0.0))),
    )


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
            direction = np.sign(every[np.nanargmax(np.abs(every))])
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


def stroke_kinds_and_limit_levels(
    picture: Picture, quantity_name: str, stroke_kinds: int = 0
) -> list[tuple[int, float]]:
    """The lines of all limits on the curve whose extreme is the quantity ``quantity_name``, in its unit.

    They are pairs of kinds of stroke and level. Kinds 0 are one line over the turn; else ± the level is drawn over
    these strokes. If the quantity is not an extreme of a curve, its limit is one line at its bound.
    """
    limits = [limit for limit in picture.problem.limits if limit.set_by_scene]
    peak = peak_at_first_contact(quantity_name, picture.problem.setup)
    if peak is None:
        return [(stroke_kinds, limit.bound) for limit in limits if quantity_name in limit.shown_quantities]
    shown = {_curve_identity(make) for make, _ in peak.curves}
    constraints = [
        constraint
        for limit in limits
        for constraint in limit.constraints
        if _curve_identity(constraint.curve) in shown
    ]
    return list(dict.fromkeys(_stroke_kinds_and_level(constraint, peak, picture) for constraint in constraints))


def _curve_identity(curve_maker: Any) -> Hashable:
    """A key that is equal for equal curves of one setup."""
    return (
        (curve_maker.func, frozenset(curve_maker.keywords.items()))
        if isinstance(curve_maker, partial)
        else curve_maker
    )


def _stroke_kinds_and_level(constraint: Constraint, peak: Peak, picture: Picture) -> tuple[int, float]:
    """The line of a constraint in the unit of the quantity of a peak, over the strokes that it bounds.

    Kinds are 0 if only one sign is bounded.
    """
    kinds = constraint.kinds if constraint.goal == LARGEST_MAGNITUDE else 0
    if kinds & WAYS or kinds & (RISE | RETURN) == RISE | RETURN:
        kinds = ALL_STROKES
    if isinstance(constraint.bound, QuantityBound) and constraint.bound.scale == peak.scale:
        return kinds, constraint.bound.quantity
    design = picture.problem.design
    with np.errstate(divide="ignore"):  # the bound may be infinite
        extreme = constraint.bound.curve_extreme_at_bound(DOUBLES) / np.asarray(constraint.factor(design))
        return kinds, float(np.squeeze(peak.scale.quantity_from_extreme(extreme, design)))

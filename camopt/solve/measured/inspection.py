"""Inspection of a measured profile against its scene: the error of motion of this cam, and the causes of it.

The follower of the scene touches each measured point at one cam angle θ and in one position, by exact contact
(``measured.profile``). This position less the nominal one is the error of motion e. The cam is turned on its shaft
to the best fit; the angle of that turn is its phase. The deviation of the profile along the normal is δn = e/g,
with the response g of the motion to the profile (``tolerances.response``). By least squares

    e(θ) ≈ y'·phase + g·size + b₁·ε₁ + b₂·ε₂

with the responses b to the axis of the bore, ε: the first harmonic of the deviation. The rest are waves
(``measured.waves``). Smooth errors are those of the smoothing spline. Its residuals are noise, except for points
more than eight times further away. These points, the outliers that were left out and the points that the follower
does not reach are reported with their distances from the drawing, and count for the profile tolerance.

Source: G. Wahba, Spline Models for Observational Data, ch. 4.
"""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, inf, isfinite, sqrt
from typing import Any, ClassVar, NamedTuple

import numpy as np
from scipy.linalg import block_diag

from camopt.core.mistakes import BadInput, Mistake, Unsolved
from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.core.numerics.neighbours import NORMAL_MEDIAN
from camopt.core.numerics.taylor import Taylor
from camopt.model.effects.motion import motion_table_unit, motion_unit_factor
from camopt.model.mechanisms.design import FIELDS
from camopt.model.mechanisms.elements import DISC
from camopt.model.motion.tool_drive import tool_position
from camopt.scene.arguments import SceneSource, allow_positional_options, scene_from
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.scene import Scene
from camopt.scene.tolerances import tolerance_zone
from camopt.solve.contour.curve import Disc, cam_discs
from camopt.solve.measured.columns import MM_PER_UNIT, TableReadingOptions
from camopt.solve.measured.fit import follow_measured_profile
from camopt.solve.measured.measured_points import (
    TURN_DEG,
    MeasuredPoints,
    forward_angle_deg,
    read_points,
    shortened_list,
)
from camopt.solve.measured.noise import OUTLIER_OFF, noise_from_neighbours
from camopt.solve.measured.outline import ANGLE_DIGITS, places_before_gaps
from camopt.solve.measured.profile import FollowedProfile, MeasuredProfile, follower_position_on_base_circle
from camopt.solve.measured.smoothing import SmoothingFit, smoothing_residuals_and_leverages
from camopt.solve.measured.waves import ProfileHarmonics, ProfileWave, significant_harmonics
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Result, Table
from camopt.solve.tolerances.errors import contact_problems
from camopt.solve.tolerances.response import ToolResponse
from camopt.solve.tolerances.turn_errors import TurnErrors, tolerance_contributions
from camopt.solve.tolerances.worst_case import make_worst_cam_search

PHASE_TRIALS, PHASE_FITS = 1440, 6
"""Number of trial angles of the cam on its shaft, and of refinements of the best one."""
LEAST_POINT_ERROR = 1e-4
"""Points with smaller errors are not reported [mm]."""
LIKELY_MISTAKES = {
    (0, 0): "its points fit after a turn of the cam: their angle 0 differs from the scene's",
    (0, 1): "its mirrored points (x to -x) fit: they were measured from behind, or cam.rotation is wrong",
    (1, 0): "the points of the other disc fit: the two files are swapped",
    (1, 1): "the mirrored points (x to -x) of the other disc fit: the two files are swapped",
}
"""Likely mistakes of measurement, by whether points of the other disc fit and whether mirrored points fit."""
SETTINGS_TO_CHECK = "rotation, probe, unit, and the angle 0 if aligned"
WRONG_CAM_SHARE = 0.02
"""A cam with a larger error, as a share of the stroke, is not the one of the drawing or was read wrongly."""


class ToleranceUse(NamedTuple):
    """The part of a tolerance that a measured cam uses.

    Examples
    --------
    >>> turn = np.radians(np.arange(0, 360, 2))
    >>> circle = np.column_stack([20 * np.cos(turn), 20 * np.sin(turn)])
    >>> camopt.inspect(camopt.MeasuredProfile(circle, "xy"), camopt.find_scene("bucket-valve")).used[0].key
    'profile'
    """

    key: str
    """Key of ``[tolerances]``, or ``motion``: the proved largest error of motion of all cams within the tolerances.
    """
    unit: str
    found: float
    allowed: float | None
    """End of the tolerance zone; None if the scene has no such tolerance."""
    moves: float | None
    """Its contribution to the tool error where that is largest [mm or deg]."""

    @property
    def share(self) -> float | None:
        """Value found, as a share of the allowed value."""
        return None if self.allowed is None else self.found / self.allowed if self.allowed else inf


class OutlyingPoint(NamedTuple):
    """A point far from its neighbours: its row, and its distance outside the profile of the drawing [mm]."""

    row: int
    off: float


@dataclass(frozen=True)
class Inspection(Result):
    """A measured cam compared with its drawing.

    Attributes
    ----------
    scene : Scene
        The drawing.
    phase_deg : float
        By how much the cam is ahead of the angles of the points at the best fit.
    file : str
        The file of the points.
    error : float
        The largest error of the tool, mm (deg), with its sign; at ``at_deg``.
    at_deg : float
        The cam angle of the largest error.
    unit : str
        Unit of tool errors: mm or deg.
    noise : float
        Standard deviation of the points along the normal, mm.
    used : tuple of ToleranceUse
        The part of each tolerance that is used.
    waves : tuple of ProfileWave
        Waves that noise does not explain, the largest first; without the mean and the first harmonic.
    eccentricity : tuple of float
        From the axis of the bore to that of the profile, x and y in the frame of the cam at cam angle 0, mm.
    size : float
        Mean distance of the profile outside the drawing, mm.
    angles, errors : ndarray
        Cam angles of the points, deg, and smooth errors of the tool there.
    outliers : tuple of OutlyingPoint
        Points far from their neighbours, or not reached, the furthest first: ``row`` and ``off``, the distance
        outside the profile of the drawing, mm, below 0 in a dent. They count for the profile only, unless outliers
        are kept.
    gaps : tuple of (float, float)
        Cam angles between which points are missing, deg.
    unreached : tuple of int
        Rows of points in hollows that the follower does not reach.
    not_counted : tuple of str
        Tolerances that are not part of the allowed motion, because the follower is nominal here.
    far : bool
        Whether the error is so large that this is hardly a cam of the drawing.
    likely : str
        The likely mistake if ``far``: mirrored points, or those of the other disc, fit.
    mover : str
        Whose errors these are: ``tool``, or ``follower`` for one disc of a pair that drives a train.

    Examples
    --------
    >>> scene = camopt.find_scene("bucket-valve")
    >>> points = camopt.cam_points(scene, range(0, 360, 2))
    >>> profile = np.column_stack([points["profile_x_mm"], points["profile_y_mm"]])
    >>> abs(camopt.inspect(camopt.MeasuredProfile(profile, "xy"), scene).error) < 1e-4
    True
    """

    scene: Scene
    phase_deg: float
    file: str
    error: float
    at_deg: float
    unit: str
    noise: float
    used: tuple[ToleranceUse, ...]
    waves: tuple[ProfileWave, ...]
    eccentricity: tuple[float, float]
    size: float
    angles: FloatArray
    errors: FloatArray
    outliers: tuple[OutlyingPoint, ...] = ()
    gaps: tuple[tuple[float, float], ...] = ()
    unreached: tuple[int, ...] = ()
    not_counted: tuple[str, ...] = ()
    far: bool = False
    likely: str = ""
    mover: str = "tool"
    main_rows: ClassVar[str] = "used"

    @property
    def within(self) -> bool | None:
        """Whether no tolerance is exceeded at the points; None if the scene has no such tolerance."""
        shares = [use.share for use in self.used if use.share is not None]
        return None if not shares else max(shares) <= 1.0

    def table(self) -> Table:
        """A table of the value found for each tolerance, beside the allowed value."""
        heads = ["", "allowed", "found", "used", f"moves the {self.mover}"]
        rows = []
        for use in self.used:
            allowed = "" if use.allowed is None else with_unit(use.allowed, use.unit)
            share = "" if use.share is None else f"{100.0 * use.share:.3g} %"
            moves = "" if use.moves is None else with_unit(use.moves, self.unit)
            rows.append([use.key, allowed, with_unit(use.found, use.unit), share, moves])
        kinds = [Cell(head, NUMERIC if head else "") for head in heads]
        return Table.from_texts(f"{os.path.basename(self.file)} against {self.scene.name}", kinds, rows, self._note)

    @property
    def _note(self) -> str:
        """The sentences below the table."""
        within = f"Within all tolerances{' where points are' if self.gaps else ''}"
        verdicts = {None: "The scene has no tolerances", True: within, False: "Beyond a tolerance"}
        ahead = "ahead of" if self.phase_deg >= 0.0 else "behind"
        sentences = [
            verdicts[self.within],
            f"The {self.mover} is off by {with_unit(self.error, self.unit)} at {number_text(self.at_deg)} deg; "
            f"noise of the points {with_unit(self.noise, 'mm')}",
            f"The cam is {ahead} the angles of the points by {number_text(abs(self.phase_deg))} deg",
            self._waves_in_words,
        ]
        if self.far:
            likely = f", but {self.likely}" if self.likely else f": check {SETTINGS_TO_CHECK}"
            sentences.append(f"The cam does not match this drawing{likely}")
        if self.outliers:
            distances = [f"row {item.row} by {with_unit(item.off, 'mm')}" for item in self.outliers]
            sentences.append(
                f"Points far from their neighbours, counted for the profile only: {shortened_list(distances)}"
            )
        if self.gaps:
            ends = [f"from {low:.4g} to {high:.4g} deg" for low, high in self.gaps]
            sentences.append(f"No points {shortened_list(ends)}: the profile and its waves are unknown there")
        if self.unreached:
            sentences.append(
                f"The follower does not reach {len(self.unreached)} points: rows {shortened_list(self.unreached)}"
            )
        if self.not_counted:
            sentences.append(f"Not part of the allowed motion: {', '.join(self.not_counted)}")
        return "".join(f"{item}. " for item in sentences).rstrip()

    @property
    def _waves_in_words(self) -> str:
        """A sentence on the waves of the profile."""
        waves = [f"{item.number} of {with_unit(item.amplitude, 'mm')}" for item in self.waves]
        if not waves:
            return "No waves beyond noise"
        wave_use = next((item for item in self.used if item.key == "waves" and item.allowed is not None), None)
        zone = f", as steep or curved as {wave_use.found:.4g} waves of the zone's height" if wave_use else ""
        return f"Waves in a turn: {shortened_list(waves)}{zone}"

    def values_for_json(self) -> dict[str, Any]:
        """The error, the deviations of the cam, and a record for each tolerance, wave and outlier."""
        return {
            "scene": self.scene.name,
            "error": self.error,
            "at_deg": self.at_deg,
            "unit": self.unit,
            "within": self.within,
            "noise": self.noise,
            "phase_deg": self.phase_deg,
            "size": self.size,
            "eccentricity": self.eccentricity,
            "used": self.records(),
            "waves": self.waves,
            "outliers": self.outliers,
            "gaps_deg": self.gaps,
            "unreached_rows": self.unreached,
            "not_counted": self.not_counted,
        }

    def records(self) -> list[dict[str, Any]]:
        """A mapping for each tolerance."""
        return [{**use._asdict(), "share": use.share} for use in self.used]


@allow_positional_options
def inspect(
    profile: MeasuredProfile,
    scene: SceneSource,
    *,
    columns: Sequence[str | int] | None = None,
    angle_unit: str = "deg",
    lift_unit: str | None = None,
    turn: float | None = None,
    keep_outliers: bool = False,
    aligned: bool = False,
) -> Inspection:
    """Find the error of motion of a measured cam against its drawing, and the tolerance that causes it.

    The follower of the scene is put on the measured profile by exact contact, with nominal sizes. The axis of the
    bore is that of the points. The cam is turned on its shaft to the least error, unless it is aligned.

    Parameters
    ----------
    profile : MeasuredProfile
        Points of the profile of a disc cam, as for ``fit``.
    scene : Scene, str or os.PathLike
        The drawing: a scene with fixed sizes; its ``[tolerances]`` are the allowed deviations.
    columns : sequence of str or int, optional
        Names or numbers (from 1) of the columns, as for ``fit``.
    angle_unit : str, default "deg"
        "deg" or "rad".
    lift_unit : str, optional
        "mm" or "inch", of the lengths.
    turn : float, optional
        The angle of one turn of the cam in the file.
    keep_outliers : bool, default False
        Whether single points far from their neighbours count for the tool error and the waves too.
    aligned : bool, default False
        Whether the angle 0 of the points is that of the scene, as measured from the keyway. The phase then counts.

    Returns
    -------
    Inspection
        The tool error, the use of each tolerance, and the waves of the profile.

    Raises
    ------
    BadInput
        If the points are no profile that the follower can run on, with the row; if the scene is no disc cam, or a
        pair of discs (``inspect_pair``).
    Unsolved
        If the convex solver fails.
    OSError
        If a file cannot be read.

    References
    ----------
    G. Wahba, Spline Models for Observational Data, ch. 4.

    Examples
    --------
    >>> scene = camopt.find_scene("bucket-valve").replace(**{"tolerances.profile": 0.02})
    >>> points = camopt.cam_points(scene, range(0, 360, 2))
    >>> profile = np.column_stack([points["profile_x_mm"] + 0.01, points["profile_y_mm"]])  # the bore is off
    >>> found = camopt.inspect(camopt.MeasuredProfile(profile, "xy"), scene)
    >>> round(abs(complex(*found.eccentricity)), 4), found.within
    (0.01, True)
    """
    scene = scene_from(scene)
    table_columns = TableReadingOptions(columns, angle_unit, lift_unit, turn)
    (disc,) = inspect_discs([profile], scene, table_columns, keep_outliers, aligned)
    return disc.build_inspection()


def inspect_discs(
    profiles: Sequence[MeasuredProfile],
    scene: Scene,
    reading_options: TableReadingOptions,
    keep_outliers: bool,
    aligned: bool,
) -> "list[InspectedDisc]":
    """The follower on the measured points of each disc of a cam, each disc at its best fit on the shaft."""
    problem = resolve_design(scene)
    if problem.setup.mechanism.body != DISC:
        raise BadInput(
            [Mistake(problem.file, "cam.form", scene.cam.form, "disc: a measured profile needs a disc cam")]
        )
    if reading_options.lift_unit not in (*MM_PER_UNIT, None):
        raise BadInput([Mistake("camopt", "lift_unit", reading_options.lift_unit, "mm or inch for a profile")])
    discs = cam_discs(problem)
    if len(discs) > 1:  # one disc moves the follower, not the tool that both drive
        discs = tuple(
            each._replace(problem=alone) for each, alone in zip(discs, contact_problems(problem), strict=True)
        )
    if len(profiles) != len(discs):
        why = f"{len(discs)}: a file, or an array, of points for each disc of the cam"
        raise BadInput([Mistake("camopt", "measured", len(profiles), why)])
    points = [read_points(each.points, each.with_profile_kind_and_layer(reading_options)) for each in profiles]
    measured = list(zip(profiles, points, strict=True))
    followed = [
        _follow_points(disc, scene, keep_outliers, *points_of_disc, aligned)
        for disc, points_of_disc in zip(discs, measured, strict=True)
    ]
    zero = _best_trial_zero_angle(followed)
    fitted = [replace(each, zero=refine_zero_angle([each], zero)) for each in followed]
    if len(fitted) > 1 and any(each.is_far_from_drawing for each in fitted):  # no common angle fits all discs
        fitted = [
            replace(each, zero=refine_zero_angle([each], _best_trial_zero_angle([each]))) for each in followed
        ]
    return [
        replace(each, likely=each.likely_mistake(measured[number:] + measured[:number]))
        if each.is_far_from_drawing
        else each
        for number, each in enumerate(fitted)
    ]


def _follow_points(
    disc: Disc,
    scene: Scene,
    keep_outliers: bool,
    profile: MeasuredProfile,
    points: MeasuredPoints,
    aligned: bool,
) -> "InspectedDisc":
    """The follower of a drawing on measured points of one disc; points of a second disc are mirrored."""
    measured = profile.mirrored(points) if disc.mirror < 0.0 else points
    problem, tables = disc.problem, scene.to_dict()
    keys = scene.mechanism.follower_size_keys(scene.tip)
    sizes = {key: float(getattr(problem.design, FIELDS[key])[0]) for key in keys}
    tables["cam"] = {**tables["cam"], "rotation": "ccw" if problem.design.sense > 0.0 else "cw"}
    tables["follower"] = {**tables["follower"], **sizes}
    followed = follow_measured_profile(profile, measured, tables, problem.file, keep_outliers, gaps_anywhere=True)
    return InspectedDisc(disc, scene, measured, followed, aligned, keep_outliers)


def _best_trial_zero_angle(discs: "Sequence[InspectedDisc]") -> float:
    """The best of many trial angles of the points at which the cam angle is 0 [rad], for all discs together."""
    if discs[0].aligned:
        return 0.0
    trials = np.linspace(0.0, discs[0].turn_angle, PHASE_TRIALS + 1)
    nominal_motions = [disc.problem.programme.motion_at(trials % disc.turn_angle)[0] for disc in discs]
    variances = [
        sum(
            float(np.var(disc.measured_follower_positions - np.interp(disc.cam_angles_at(zero), trials, motion)))
            for disc, motion in zip(discs, nominal_motions, strict=True)
        )
        for zero in trials[:-1]
    ]
    return float(trials[int(np.argmin(variances))])


def refine_zero_angle(discs: "Sequence[InspectedDisc]", zero_angle: float) -> float:
    """The angle near ``zero_angle`` that fits all discs best [rad]."""
    for _ in range(PHASE_FITS):
        all_columns = [disc.responses_to_phase_size_and_bore(zero_angle) for disc in discs]
        own_columns = block_diag(*(columns[:, 1:] for columns in all_columns))
        columns = np.column_stack([np.concatenate([columns[:, 0] for columns in all_columns]), own_columns])
        errors = np.concatenate([disc.raw_motion_errors_at(zero_angle) for disc in discs])
        zero_angle -= float(np.linalg.lstsq(columns, errors, rcond=None)[0][0])
    return zero_angle


@dataclass(frozen=True)
class InspectedDisc:
    """Positions of the follower on a measured profile, by cam angle."""

    disc: Disc
    scene: Scene
    measured: MeasuredPoints
    followed_profile: FollowedProfile
    aligned: bool
    keep_outliers: bool
    zero: float = 0.0
    """Angle of the points at which the cam angle is 0 [rad]."""
    likely: str = ""

    @property
    def problem(self) -> Problem:
        """The problem of this disc alone."""
        return self.disc.problem

    @cached_property
    def smooth_motion_errors(self) -> FloatArray:
        """Smooth errors of the follower's motion on this disc at ``cam_angles`` [mm or rad]."""
        return self.smooth_motion_errors_at(0.0 if self.aligned else self.zero)

    def smooth_motion_errors_at(self, zero_angle: float) -> FloatArray:
        """The same, with the disc turned on its shaft to another zero."""
        return np.asarray(
            self.smooth_normal_deviations * self.profile_and_bore_responses[0]
            + self.raw_motion_errors_at(zero_angle)
            - self.raw_motion_errors_at(self.zero)
        )

    @cached_property
    def is_far_from_drawing(self) -> bool:
        """Whether the error is so large that this is hardly a cam of the drawing."""
        return float(np.abs(self.smooth_motion_errors).max()) > WRONG_CAM_SHARE * float(
            np.ptp(self.problem.programme.motion_at(self.cam_angles)[0])
        )

    def likely_mistake(self, measured: Sequence[tuple[MeasuredProfile, MeasuredPoints]]) -> str:
        """The likely mistake that would make points of this disc, or of the other one, fit; empty if none."""
        for case, sentence in LIKELY_MISTAKES.items():
            disc_number, is_mirrored = case
            if disc_number < len(measured) and (self.aligned or any(case)):
                profile, points = measured[disc_number]
                points = profile.mirrored(points) if is_mirrored else points
                try:
                    disc = _follow_points(self.disc, self.scene, self.keep_outliers, profile, points, False)
                    zero = refine_zero_angle([disc], _best_trial_zero_angle([disc]))
                    if not replace(disc, zero=zero).is_far_from_drawing:
                        return sentence
                except (BadInput, Unsolved):
                    continue  # the follower cannot run on them
        return ""

    def build_inspection(self) -> Inspection:
        errors = self.smooth_motion_errors
        place = int(np.abs(errors).argmax())
        unit = motion_unit_factor(self.problem.setup, 0)
        tool_errors, train_ratios = self._tool_errors_and_ratios(errors)
        tool_error, largest = unit * float(tool_errors[place]), unit * float(np.abs(tool_errors).max())
        used = tuple(self._tolerance_uses(place, tool_error, largest, float(train_ratios[place]) * float(unit)))
        outliers = zip(*self._outlier_rows_and_distances[:2], strict=True)
        counted = self._scene_with_profile_tolerances.tolerances
        contributions = tolerance_contributions(self.scene, self.problem, np.zeros(1))
        return Inspection(
            self.scene,
            self.phase_deg,
            self.kept_points.file,
            tool_error,
            float(np.degrees(self.cam_angles[place])),
            motion_table_unit(self.problem.setup, 0),
            self.noise,
            used,
            self.waves.waves,
            (
                float(self.fitted_phase_size_and_bore[2]),
                self.disc.mirror * float(self.fitted_phase_size_and_bore[3]),
            ),
            float(self.fitted_phase_size_and_bore[1]),
            np.degrees(self.cam_angles),
            unit * tool_errors,
            tuple(OutlyingPoint(int(row), float(distance)) for row, distance in outliers),
            tuple(self._missing_angle_ranges_deg()),
            tuple(self.followed_profile.unreached.tolist()),
            tuple(each.key for each in contributions if getattr(counted, each.key, None) is None),
            self.is_far_from_drawing,
            self.likely,
            "follower" if self.scene.train and self.problem.setup.train is None else "tool",
        )

    def _tolerance_uses(
        self, point_index: int, tool_error: float, largest_tool_error: float, rate: float
    ) -> Iterator[ToleranceUse]:
        """The use of each tolerance.

        ``tool_error`` is the tool error at ``point_index``, ``largest_tool_error`` the largest one. ``rate`` is the
        change of the shown tool error with the follower's there.
        """
        tolerances = self.scene.tolerances
        response, bore = self.profile_and_bore_responses[0][point_index], self.motion_errors_caused_by_bore_axis
        is_bore_separate = bool(tolerances.bore_eccentricity)
        deviations = (
            self.smooth_normal_deviations - bore / self.profile_and_bore_responses[0]
            if is_bore_separate
            else self.smooth_normal_deviations
        )
        outlier_distances = (
            self._outlier_rows_and_distances[1] - self._outlier_rows_and_distances[2] * is_bore_separate
        )
        largest = float(np.abs([*deviations, *outlier_distances]).max())
        most = self.scene.whole_part.profile_tolerance
        yield ToleranceUse("profile", "mm", largest, most, rate * float(deviations[point_index] * response))
        if tolerances.profile and (self.waves.waves or tolerances.waves):
            allowed = None if tolerances.waves is None else float(tolerances.waves)
            yield ToleranceUse("waves", "", self.waves.equivalent_wave_count(tolerances.profile), allowed, None)
        if is_bore_separate:
            yield ToleranceUse(
                "bore_eccentricity",
                "mm",
                float(np.hypot(*self.fitted_phase_size_and_bore[2:])),
                tolerances.bore_eccentricity,
                rate * float(bore[point_index]),
            )
        if tolerances.phase is not None and self.aligned:
            zone = tolerance_zone(tolerances.phase, "phase", 0.0)
            end = zone.upper if self.phase_deg >= 0.0 else -zone.lower
            phase_errors = self.raw_motion_errors_at(0.0) - self.raw_motion_errors_at(self.zero)
            yield ToleranceUse("phase", "deg", abs(self.phase_deg), end, rate * float(phase_errors[point_index]))
        if tolerances.profile or is_bore_separate:
            bound = (
                make_worst_cam_search(TurnErrors(self._scene_with_profile_tolerances, self.problem))
                .find_worst_cam()
                .bound
            )
            allowed, tool_unit = (bound if isfinite(bound) else None), motion_table_unit(self.problem.setup, 0)
            yield ToleranceUse("motion", tool_unit, largest_tool_error, allowed, tool_error)

    @cached_property
    def kept_points(self) -> MeasuredPoints:
        """The points without the outliers that are left out."""
        return self.followed_profile.positions.drop_places(self.followed_profile.outlier_places)

    @cached_property
    def measured_follower_positions(self) -> FloatArray:
        """Positions of the follower [mm or rad]."""
        lifts = self.kept_points.lifts
        return np.radians(lifts) if self.problem.setup.angular else lifts

    def raw_motion_errors_at(self, zero_angle: float) -> FloatArray:
        """Measured less nominal positions [mm or rad], with cam angle 0 at ``zero_angle`` of the points."""
        return np.asarray(
            self.measured_follower_positions
            - float(follower_position_on_base_circle(self.problem, self.problem.design)[0])
            - self.problem.programme.motion_at(self.cam_angles_at(zero_angle))[0]
        )

    @property
    def turn_angle(self) -> float:
        return self.problem.programme.strokes[-1].end

    def responses_to_phase_size_and_bore(self, zero_angle: float) -> FloatArray:
        """Responses of the errors to phase, size and the two directions of the bore (points, 4)."""
        without_train = replace(self.problem, setup=replace(self.problem.setup, train=None))
        response = ToolResponse(without_train, self.cam_angles_at(zero_angle))
        return np.column_stack(
            [
                self.problem.programme.motion_at(response.angles)[1],
                response.profile_response[0],
                *(column[0] for column in response.bore_responses_in_two_directions),
            ]
        )

    @property
    def phase_deg(self) -> float:
        """Angle by which the cam is ahead of the points [deg]."""
        return (180.0 - degrees(self.zero)) % 360.0 - 180.0

    @cached_property
    def fitted_phase_size_and_bore(self) -> FloatArray:
        """Causes of the errors: phase, size and the two directions of the bore."""
        return np.asarray(
            np.linalg.lstsq(
                self.responses_to_phase_size_and_bore(self.zero), self.raw_motion_errors_at(self.zero), rcond=None
            )[0]
        )

    @cached_property
    def cam_angles(self) -> FloatArray:
        """Cam angles of the points [rad]."""
        return self.cam_angles_at(self.zero)

    def cam_angles_at(self, zero_angle: float) -> FloatArray:
        """The same, with the disc turned on its shaft to another zero."""
        return np.asarray(np.mod(np.radians(self.kept_points.angles) - zero_angle, self.turn_angle))

    @cached_property
    def profile_and_bore_responses(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Response of the follower to the profile, and to the two directions of the bore."""
        _, *columns = self.responses_to_phase_size_and_bore(self.zero).T
        return columns[0], columns[1], columns[2]

    @cached_property
    def motion_errors_caused_by_bore_axis(self) -> FloatArray:
        """Errors that the axis of the bore causes [mm or rad]."""
        return np.asarray(
            self.profile_and_bore_responses[1] * self.fitted_phase_size_and_bore[2]
            + self.profile_and_bore_responses[2] * self.fitted_phase_size_and_bore[3]
        )

    @cached_property
    def raw_normal_deviations(self) -> FloatArray:
        """Deviations along the normal with their noise [mm]."""
        return self.raw_motion_errors_at(self.zero) / self.profile_and_bore_responses[0]

    @cached_property
    def smooth_normal_deviations(self) -> FloatArray:
        """Smooth deviations along the normal, with those of outliers that are kept [mm]."""
        return np.asarray(
            self.raw_normal_deviations
            - np.where(self.is_outlying & self.keep_outliers, 0.0, self.smoothing_curve.residuals)
        )

    @cached_property
    def smoothing_curve(self) -> SmoothingFit:
        return smoothing_residuals_and_leverages(replace(self.kept_points, lifts=self.raw_normal_deviations))

    @cached_property
    def is_outlying(self) -> BoolArray:
        """Which points are further from the smooth deviation than noise explains."""
        return np.asarray(np.abs(self.smoothing_curve.residuals) > self._largest_noise_residual)

    @cached_property
    def _largest_noise_residual(self) -> float:
        """Largest residual that noise explains [mm]."""
        usual = float(np.median(np.abs(self.smoothing_curve.residuals))) / NORMAL_MEDIAN
        angles = np.round(
            self.kept_points.angles, ANGLE_DIGITS
        )  # the first point may be measured again as the last
        return max(
            OUTLIER_OFF
            * max(
                noise_from_neighbours(replace(self.kept_points, angles=angles, lifts=self.raw_normal_deviations)),
                usual,
            ),
            LEAST_POINT_ERROR,
        )

    @cached_property
    def noise(self) -> float:
        """Standard deviation of the points along the normal [mm]."""
        residuals = self.smoothing_curve.residuals[~self.is_outlying]
        return sqrt(float(residuals @ residuals) / (residuals.size - self.smoothing_curve.freedom))

    @cached_property
    def _outlier_rows_and_distances(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Rows of points that are left out, not reached or beyond noise, the furthest first.

        With their distances outside the profile of the drawing, and the part of the bore's axis in these [mm].
        """
        measured, kept = self.measured, np.isin(self.measured.rows, self.kept_points.rows[~self.is_outlying])
        rows = measured.rows[~kept]
        if not rows.size:
            return rows, np.empty(0), np.empty(0)
        distances = self.followed_profile.distances_outside_profile(self.problem, degrees(self.zero), rows)
        by_row = dict(
            zip(
                self.kept_points.rows.tolist(),
                self.motion_errors_caused_by_bore_axis / self.profile_and_bore_responses[0],
                strict=True,
            )
        )
        is_followed = np.isin(measured.rows, self.kept_points.rows)
        bore_parts = np.array([by_row[row] for row in measured.rows[is_followed].tolist()])
        bore_distances = np.interp(
            measured.angles[~kept], measured.angles[is_followed], bore_parts, period=TURN_DEG
        )
        shown = [
            k
            for k in np.argsort(-np.abs(distances - bore_distances))
            if abs(distances - bore_distances)[k] > self._largest_noise_residual
        ]
        return rows[shown], distances[shown], bore_distances[shown]

    @cached_property
    def waves(self) -> ProfileHarmonics:
        """Waves of the deviation, without the axis of the bore."""
        deviations = (
            np.where(self.is_outlying, self.smooth_normal_deviations, self.raw_normal_deviations)
            - self.motion_errors_caused_by_bore_axis / self.profile_and_bore_responses[0]
        )
        return significant_harmonics(np.radians(self.kept_points.angles), deviations, self.noise)

    def _missing_angle_ranges_deg(self) -> Iterator[tuple[float, float]]:
        """Cam angles between which points are missing [deg]."""
        angle_of_row = dict(zip(self.kept_points.rows.tolist(), np.degrees(self.cam_angles).tolist(), strict=True))
        kept = self.measured.pick_places(
            np.flatnonzero(np.isin(self.measured.rows, self.kept_points.rows)).tolist()
        )
        for k in places_before_gaps(kept):
            ends = [angle_of_row[int(kept.rows[place % kept.rows.size])] for place in (k, k + 1)]
            low, high = ends if forward_angle_deg(*ends) < forward_angle_deg(*ends[::-1]) else ends[::-1]
            yield low, high

    def _tool_errors_and_ratios(self, follower_errors: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Errors of the tool for errors of the follower, and the ratio of the train, at each cam angle."""
        train, ones = self.problem.setup.train, np.ones(self.cam_angles.size)
        if train is None:
            return follower_errors, ones
        # from the start of the train
        nominal = train.follower_displacement_at(tool_position(self.problem.programme, self.cam_angles))
        positions = (nominal, nominal + follower_errors)
        first, second = (np.asarray(train.tool_displacement(Taylor([each])).terms[0]) for each in positions)
        return second - first, np.asarray(train.tool_displacement(Taylor([nominal, ones])).terms[1])

    @property
    def _scene_with_profile_tolerances(self) -> Scene:
        """The scene with only the tolerances that concern the measured profile."""
        tolerances = self.scene.tolerances
        names = ["profile", "waves", "bore_eccentricity", *(["phase"] if self.aligned else [])]
        kept = {name: getattr(tolerances, name) for name in names}
        return self.scene.replace(
            tolerances={key: tolerance for key, tolerance in kept.items() if tolerance is not None}
        )

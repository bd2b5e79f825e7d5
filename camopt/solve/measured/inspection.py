"""A measured profile against the drawing of its scene: the error of motion that this cam has, and what makes it.

The follower of the scene touches each measured point at one cam angle θ and with one position, by exact contact
(``measured.profile``): less the one that is asked there, this is the error of the motion e. The cam is put on its
shaft as it fits best; what it has to be turned by is its phase. Along the normal the profile is off by δn = e/g,
with the answer g of the motion to the profile (``tolerances.response``). By least squares

    e(θ) ≈ y'·phase + g·size + b₁·ε₁ + b₂·ε₂

with the answers b to the axis of the bore, ε: the first harmonic of the deviation. What is left are waves
(``measured.waves``). Smooth errors are those of the smoothing spline; what it leaves is noise, but for points that
are off by more than eight times as much. These, outliers that were left out, and what the follower does not reach
are told with their distances from the drawing, and count for the tolerance of the profile.

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
from camopt.model.effects.motion import motion_scale, motion_table_unit
from camopt.model.mechanisms.design import FIELDS
from camopt.model.mechanisms.elements import DISC
from camopt.model.motion.tool_drive import tool_position
from camopt.scene.arguments import SceneSource, options_by_keyword, scene_from
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.scene import Scene
from camopt.scene.tolerances import tolerance_zone
from camopt.solve.contour.curve import Disc, cam_discs
from camopt.solve.measured.columns import MM_PER_UNIT, PROFILE_KINDS, TableColumns
from camopt.solve.measured.fit import follow_measured_profile
from camopt.solve.measured.measured_points import TURN_DEG, MeasuredPoints, angle_from, read_points
from camopt.solve.measured.noise import OUTLIER_OFF, point_noise
from camopt.solve.measured.outline import ANGLE_DIGITS, find_gaps
from camopt.solve.measured.profile import FollowedProfile, MeasuredProfile, base_circle_position
from camopt.solve.measured.smoothing import smoothing_spline
from camopt.solve.measured.waves import ProfileHarmonics, ProfileWave, find_waves
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Result, Table
from camopt.solve.tolerances.errors import contact_problems
from camopt.solve.tolerances.response import ToolResponse
from camopt.solve.tolerances.turn_errors import TurnErrors, contributions
from camopt.solve.tolerances.worst_case import worst_search

PHASE_TRIALS, PHASE_FITS = 1440, 6
"""In how many ways the cam is put on its shaft at first, and how often this is made better."""
SHOWN_ROWS = 6
LEAST_POINT_ERROR = 1e-4
"""Points that are off by less, mm, are not told."""
LIKELY_MISTAKES = {
    (0, 0): "turned on its shaft its points fit: their angle 0 is another one",
    (0, 1): "in the mirror, x to -x, its points fit: measured from behind, or cam.rotation is the other one",
    (1, 0): "the points of the other disc fit: the files are the wrong way round",
    (1, 1): "in the mirror, x to -x, the points of the other disc fit: the files are the wrong way round",
}
"""What makes points fit, by whether they are of the other disc and in the mirror."""
SETTINGS_TO_CHECK = "rotation, probe, unit, and the angle 0 if aligned"
WRONG_CAM_SHARE = 0.02
"""Of the stroke: a cam that is further off is not the one of the drawing, or was read wrongly."""


class ToleranceUse(NamedTuple):
    """How much of a tolerance a measured cam uses.

    Examples
    --------
    >>> turn = np.radians(np.arange(0, 360, 2))
    >>> circle = np.column_stack([20 * np.cos(turn), 20 * np.sin(turn)])
    >>> camopt.inspect(camopt.MeasuredProfile(circle, "xy"), camopt.find_scene("bucket-valve")).used[0].key
    'profile'
    """

    key: str
    """Of ``[tolerances]``, or ``motion``, of which all cams within the tolerances have at most so much, proved."""
    unit: str
    found: float
    allowed: float | None
    """The end of its zone; None where the scene has no such tolerance."""
    moves: float | None
    """What it contributes to the error of the tool where that is largest, mm (deg)."""

    @property
    def share(self) -> float | None:
        """Of what is allowed."""
        return None if self.allowed is None else self.found / self.allowed if self.allowed else inf


class OutlyingPoint(NamedTuple):
    """A point far off its neighbours: its row, and its distance outside the profile of the drawing, mm."""

    row: int
    off: float


@dataclass(frozen=True)
class Inspection(Result):
    """A measured cam against its drawing.

    Attributes
    ----------
    scene : Scene
        The drawing.
    phase_deg : float
        By how much the cam is ahead of the angles of the points, as it fits best.
    file : str
        Where the points are from.
    error : float
        The largest error of the tool, mm (deg), with its sign; at ``at_deg``.
    at_deg : float
        The cam angle of it.
    unit : str
        Of errors of the tool: mm or deg.
    noise : float
        Standard deviation of the points along the normal, mm.
    used : tuple of ToleranceUse
        What is found of each tolerance.
    waves : tuple of ProfileWave
        Those that noise does not explain, the largest first; the first harmonic and the mean are not among them.
    eccentricity : tuple of float
        From the axis of the bore to that of the profile, x and y in the frame of the cam at cam angle 0, mm.
    size : float
        By how much the profile stands out all over, mm.
    angles, errors : ndarray
        Cam angles of the points, deg, and smooth errors of the tool there.
    outliers : tuple of OutlyingPoint
        Points far off their neighbours, or not reached, the furthest first: ``row`` and ``off``, the distance
        outside the profile of the drawing, mm, below 0 in a dent. They count for the profile, and for nothing else
        unless outliers are kept.
    gaps : tuple of (float, float)
        Cam angles between which points are missing, deg.
    unreached : tuple of int
        Rows of points in hollows that the follower does not reach.
    not_counted : tuple of str
        Tolerances that have no part in what is allowed of the motion: the follower is nominal here.
    far : bool
        Whether it is so far off that it is hardly a cam of this drawing.
    likely : str
        Why it is ``far``, if other points were tried and fit: its own in the mirror, or those of the other disc.
    mover : str
        Whose errors these are: ``tool``, or of one disc of a pair that drives a train ``follower``.

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
        """Whether no tolerance is exceeded where points are; None if the scene has none of what was found."""
        shares = [each.share for each in self.used if each.share is not None]
        return None if not shares else max(shares) <= 1.0

    def table(self) -> Table:
        """What is found of each tolerance, beside what is allowed."""
        heads = ["", "allowed", "found", "used", f"moves the {self.mover}"]
        rows = []
        for each in self.used:
            allowed = "" if each.allowed is None else with_unit(each.allowed, each.unit)
            share = "" if each.share is None else f"{100.0 * each.share:.3g} %"
            moves = "" if each.moves is None else with_unit(each.moves, self.unit)
            rows.append([each.key, allowed, with_unit(each.found, each.unit), share, moves])
        kinds = [Cell(head, NUMERIC if head else "") for head in heads]
        return Table.from_texts(f"{os.path.basename(self.file)} against {self.scene.name}", kinds, rows, self._note)

    @property
    def _note(self) -> str:
        """What the table does not say, a sentence each."""
        within = f"Within all tolerances{' where points are' if self.gaps else ''}"
        said = {None: "The scene has no tolerances", True: within, False: "Beyond a tolerance"}
        ahead = "ahead of" if self.phase_deg >= 0.0 else "behind"
        told = [
            said[self.within],
            f"The {self.mover} is off by {with_unit(self.error, self.unit)} at {number_text(self.at_deg)} deg; "
            f"noise of the points {with_unit(self.noise, 'mm')}",
            f"The cam is {ahead} the angles of the points by {number_text(abs(self.phase_deg))} deg",
            self._waves_in_words,
        ]
        if self.far:
            likely = f", but {self.likely}" if self.likely else f": check {SETTINGS_TO_CHECK}"
            told.append(f"That is no cam of this drawing{likely}")
        if self.outliers:
            off = [f"row {each.row} by {with_unit(each.off, 'mm')}" for each in self.outliers]
            told.append(f"Points far off their neighbours, which count for the profile: {_shortened_list(off)}")
        if self.gaps:
            ends = [f"from {low:.4g} to {high:.4g} deg" for low, high in self.gaps]
            told.append(
                f"No points {_shortened_list(ends)}: what the profile is there, and waves there, are not known"
            )
        if self.unreached:
            told.append(
                f"The follower does not reach {len(self.unreached)} points: rows {_shortened_list(self.unreached)}"
            )
        if self.not_counted:
            told.append(f"Not in the motion that is allowed: {', '.join(self.not_counted)}")
        return "".join(f"{each}. " for each in told).rstrip()

    @property
    def _waves_in_words(self) -> str:
        some = [f"{each.number} of {with_unit(each.amplitude, 'mm')}" for each in self.waves]
        if not some:
            return "No waves but those of noise"
        alike = next((each for each in self.used if each.key == "waves" and each.allowed is not None), None)
        zone = f", as steep or curved as {alike.found:.4g} of the height of the zone" if alike else ""
        return f"Waves in a turn: {_shortened_list(some)}{zone}"

    def document(self) -> dict[str, Any]:
        """The error, where the cam is off, and a record for each tolerance, wave and outlier."""
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
        return [{**each._asdict(), "share": each.share} for each in self.used]


def _shortened_list(words: Sequence[Any]) -> str:
    """The first of some words."""
    return ", ".join(map(str, words[:SHOWN_ROWS])) + (" and others" if len(words) > SHOWN_ROWS else "")


@options_by_keyword
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
    """Find the error of motion that a measured cam has against its drawing, and which tolerance makes it.

    The follower of the scene is put on the measured profile by exact contact, with nominal sizes. The axis of the
    bore is that of the points. The cam is turned on its shaft to where the error is least, unless it is aligned.

    Parameters
    ----------
    profile : MeasuredProfile
        Points of the profile of a disc cam, as for ``fit``.
    scene : Scene, str or os.PathLike
        The drawing: a scene with sizes of its own; its ``[tolerances]`` are what is allowed.
    columns : sequence of str or int, optional
        Names or numbers (from 1) of the columns, as for ``fit``.
    angle_unit : str, default "deg"
        "deg" or "rad".
    lift_unit : str, optional
        "mm" or "inch", of the lengths.
    turn : float, optional
        The angle of one turn of the cam in the file.
    keep_outliers : bool, default False
        Whether single points that are far off their neighbours count for the error of the tool and the waves too.
    aligned : bool, default False
        Whether the angle 0 of the points is that of the scene, as measured from the keyway: phase counts then.

    Returns
    -------
    Inspection
        The error of the tool, how much of each tolerance is used, and the waves of the profile.

    Raises
    ------
    BadInput
        If the points are no profile that the follower can run on, with the row; or of a scene that is no disc cam,
        or a pair of discs (``inspect_pair``).
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
    columns_ = TableColumns(columns, angle_unit, lift_unit or "mm", turn)
    (found,) = inspect_discs([profile], scene, columns_, keep_outliers, aligned)
    return found.build_inspection()


def inspect_discs(
    profiles: Sequence[MeasuredProfile], scene: Scene, columns: TableColumns, keep_outliers: bool, aligned: bool
) -> "list[InspectedDisc]":
    """The follower on measured points of each disc of a cam, in order, each as it fits best on the shaft."""
    problem = resolve_design(scene)
    if problem.setup.mechanism.body != DISC:
        raise BadInput([Mistake(problem.file, "cam.form", scene.cam.form, "disc: a profile is that of a disc cam")])
    if columns.lift_unit not in MM_PER_UNIT:
        raise BadInput([Mistake("camopt", "lift_unit", columns.lift_unit, "mm or inch for a profile")])
    discs = cam_discs(problem)
    if len(discs) > 1:  # each alone tells of the follower, not of a tool that both drive
        discs = tuple(
            each._replace(problem=alone) for each, alone in zip(discs, contact_problems(problem), strict=True)
        )
    if len(profiles) != len(discs):
        why = f"{len(discs)}: a file, or an array, of points for each disc of the cam"
        raise BadInput([Mistake("camopt", "measured", len(profiles), why)])
    points = [read_points(each.points, replace(columns, kind=PROFILE_KINDS[each.form])) for each in profiles]
    sides = [_DrawnDisc(disc, scene, keep_outliers) for disc in discs]
    taken = list(zip(profiles, points, strict=True))
    met = [side.follow_points(*given, aligned) for side, given in zip(sides, taken, strict=True)]
    zero = _best_trial_zero(met)
    found = [replace(each, zero=refine_zero([each], zero)) for each in met]
    if len(found) > 1 and any(each.is_far_off for each in found):  # one angle does not fit them all
        found = [replace(each, zero=refine_zero([each], _best_trial_zero([each]))) for each in met]
    return [
        replace(each, likely=side.likely_mistake(taken[place:] + taken[:place], aligned))
        if each.is_far_off
        else each
        for place, (side, each) in enumerate(zip(sides, found, strict=True))
    ]


class _DrawnDisc(NamedTuple):
    """A disc of a drawing, which points are put against."""

    disc: Disc
    scene: Scene
    keep_outliers: bool

    def follow_points(self, profile: MeasuredProfile, points: MeasuredPoints, aligned: bool) -> "InspectedDisc":
        """The follower on measured points; those of a second disc are taken as they are in the mirror."""
        measured = profile.mirrored(points) if self.disc.mirror < 0.0 else points
        file, tables = self.disc.problem.file, _disc_tables(self.disc, self.scene)
        seen = follow_measured_profile(profile, measured, tables, file, self.keep_outliers, gaps_anywhere=True)
        return InspectedDisc(self.disc, self.scene, measured, seen, aligned, self.keep_outliers)

    def likely_mistake(self, taken: Sequence[tuple[MeasuredProfile, MeasuredPoints]], aligned: bool) -> str:
        """What would make points fit, the own ones first and then those of the other disc; "" if nothing does."""
        for way, said in LIKELY_MISTAKES.items():
            other, behind = way
            if other < len(taken) and (aligned or any(way)):
                profile, points = taken[other]
                try:
                    disc = self.follow_points(profile, profile.mirrored(points) if behind else points, False)
                    if not replace(disc, zero=refine_zero([disc], _best_trial_zero([disc]))).is_far_off:
                        return said
                except (BadInput, Unsolved):
                    continue  # the follower cannot run on them
        return ""


def _disc_tables(disc: Disc, scene: Scene) -> dict[str, Any]:
    """The tables of a scene, with the sizes of the follower at one disc, and the way that this turns."""
    tables, design = scene.to_dict(), disc.problem.design
    sizes = {key: float(getattr(design, FIELDS[key])[0]) for key in scene.mechanism.follower_keys(scene.tip)}
    tables["cam"] = {**tables["cam"], "rotation": "ccw" if design.sense > 0.0 else "cw"}
    tables["follower"] = {**tables["follower"], **sizes}
    return tables


def _best_trial_zero(discs: "Sequence[InspectedDisc]") -> float:
    """The angle of the points where the cam angle is 0, rad, at which all of some discs fit best of many."""
    if discs[0].aligned:
        return 0.0
    tried = np.linspace(0.0, discs[0].turn_angle, PHASE_TRIALS + 1)
    asked = [disc.problem.programme.motion_at(tried % disc.turn_angle)[0] for disc in discs]
    off = [
        sum(
            float(np.var(disc.positions - np.interp(disc.cam_angles_at(zero), tried, motion)))
            for disc, motion in zip(discs, asked, strict=True)
        )
        for zero in tried[:-1]
    ]
    return float(tried[int(np.argmin(off))])


def refine_zero(discs: "Sequence[InspectedDisc]", zero: float) -> float:
    """An angle near ``zero`` at which all of some discs fit best."""
    for _ in range(PHASE_FITS):
        each = [disc.response_columns(zero) for disc in discs]
        own = block_diag(*(columns[:, 1:] for columns in each))
        columns = np.column_stack([np.concatenate([columns[:, 0] for columns in each]), own])
        errors = np.concatenate([disc.raw_errors_at(zero) for disc in discs])
        zero -= float(np.linalg.lstsq(columns, errors, rcond=None)[0][0])
    return zero


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
    """The angle of the points where the cam angle is 0, rad."""
    likely: str = ""

    @property
    def problem(self) -> Problem:
        """Of this disc alone."""
        return self.disc.problem

    @cached_property
    def smooth_errors(self) -> FloatArray:
        """Smooth errors of the follower's own motion on this disc, mm (rad), at ``places``."""
        return self.smooth_errors_at(0.0 if self.aligned else self.zero)

    def smooth_errors_at(self, zero: float) -> FloatArray:
        """The same of the disc as it is turned on its shaft."""
        return np.asarray(
            self.smooth_deviations * self.responses[0] + self.raw_errors_at(zero) - self.raw_errors_at(self.zero)
        )

    @cached_property
    def is_far_off(self) -> bool:
        """Whether it is so far off that it is hardly a cam of this drawing."""
        return float(np.abs(self.smooth_errors).max()) > WRONG_CAM_SHARE * float(
            np.ptp(self.problem.programme.motion_at(self.cam_angles)[0])
        )

    def build_inspection(self) -> Inspection:
        """What is told of the disc."""
        errors = self.smooth_errors
        place = int(np.abs(errors).argmax())
        unit, tool = motion_scale(self.problem.setup, 0), self._errors_at_tool(errors)
        used = tuple(self._tolerance_uses(place, unit * float(tool[place]), unit * float(np.abs(tool).max())))
        return Inspection(
            self.scene,
            self.phase_deg,
            self.points.file,
            unit * float(tool[place]),
            float(np.degrees(self.cam_angles[place])),
            motion_table_unit(self.problem.setup, 0),
            self.noise,
            used,
            self.waves.waves,
            (float(self.error_parts[2]), self.disc.mirror * float(self.error_parts[3])),
            float(self.error_parts[1]),
            np.degrees(self.cam_angles),
            unit * tool,
            self.outliers,
            tuple(self._missing_ranges()),
            tuple(self.followed_profile.unreached.tolist()),
            tuple(self._uncounted_keys()),
            self.is_far_off,
            self.likely,
            "follower" if self.scene.train and self.problem.setup.train is None else "tool",
        )

    def _tolerance_uses(self, place: int, moves: float, most_moved: float) -> Iterator[ToleranceUse]:
        given, unit = self.scene.tolerances, float(motion_scale(self.problem.setup, 0))
        answer, bore = self.responses[0][place], self.bore_errors
        apart = bool(given.bore_eccentricity)
        rest = self.smooth_deviations - bore / self.responses[0] if apart else self.smooth_deviations
        rate = float(self._train_ratios[place]) * unit
        found = self._outlier_arrays[1] - self._outlier_arrays[2] * apart
        largest = float(np.abs([*rest, *found]).max())
        most = self.scene.whole_part.profile_tolerance
        yield ToleranceUse("profile", "mm", largest, most, rate * float(rest[place] * answer))
        if given.profile and (self.waves.waves or given.waves):
            allowed = None if given.waves is None else float(given.waves)
            yield ToleranceUse("waves", "", self.waves.wave_count_within(given.profile), allowed, None)
        if apart:
            away = float(np.hypot(*self.error_parts[2:]))
            yield ToleranceUse("bore_eccentricity", "mm", away, given.bore_eccentricity, rate * float(bore[place]))
        if given.phase is not None and self.aligned:
            zone = tolerance_zone(given.phase, "phase", 0.0)
            end = zone.upper if self.phase_deg >= 0.0 else -zone.lower
            of_phase = self.raw_errors_at(0.0) - self.raw_errors_at(self.zero)
            yield ToleranceUse("phase", "deg", abs(self.phase_deg), end, rate * float(of_phase[place]))
        if given.profile or apart:
            bound = worst_search(TurnErrors(self._scene_of_measured, self.problem)).run().bound
            allowed, of_tool = (bound if isfinite(bound) else None), motion_table_unit(self.problem.setup, 0)
            yield ToleranceUse("motion", of_tool, most_moved, allowed, moves)

    @cached_property
    def points(self) -> MeasuredPoints:
        """Those without the outliers that are left out."""
        return self.followed_profile.positions.drop_places(self.followed_profile.outlier_places)

    @cached_property
    def base_position(self) -> float:
        """The position on the base circle of the drawing."""
        return float(base_circle_position(self.problem, self.problem.design)[0])

    @cached_property
    def positions(self) -> FloatArray:
        """Positions of the follower, mm (rad)."""
        lifts = self.points.lifts
        return np.radians(lifts) if self.problem.setup.angular else lifts

    def raw_errors_at(self, zero: float) -> FloatArray:
        """Positions less those of a cam that is turned on its shaft."""
        return np.asarray(
            self.positions - self.base_position - self.problem.programme.motion_at(self.cam_angles_at(zero))[0]
        )

    @property
    def turn_angle(self) -> float:
        return self.problem.programme.strokes[-1].end

    def response_columns(self, zero: float) -> FloatArray:
        """How the errors answer to phase, size and the axis of the bore."""
        alone = replace(self.problem, setup=replace(self.problem.setup, train=None))
        answers = ToolResponse(alone, self.cam_angles_at(zero))
        slope = self.problem.programme.motion_at(answers.angles)[1]
        return np.column_stack([slope, answers.profile_response[0], *(each[0] for each in answers.bore_responses)])

    @property
    def phase_deg(self) -> float:
        """By how much the cam is ahead, deg."""
        return (180.0 - degrees(self.zero)) % 360.0 - 180.0

    @cached_property
    def error_parts(self) -> FloatArray:
        """What makes the errors: phase, size and bore."""
        return np.asarray(
            np.linalg.lstsq(self.response_columns(self.zero), self.raw_errors_at(self.zero), rcond=None)[0]
        )

    @cached_property
    def cam_angles(self) -> FloatArray:
        """Cam angles, rad."""
        return self.cam_angles_at(self.zero)

    def cam_angles_at(self, zero: float) -> FloatArray:
        """The same of the disc as it is turned on its shaft."""
        return np.asarray(np.mod(np.radians(self.points.angles) - zero, self.turn_angle))

    @cached_property
    def responses(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Of the follower to the profile, and to the two directions of the bore."""
        _, *found = self.response_columns(self.zero).T
        return found[0], found[1], found[2]

    @cached_property
    def bore_errors(self) -> FloatArray:
        """What the axis of the bore makes of the errors."""
        return np.asarray(self.responses[1] * self.error_parts[2] + self.responses[2] * self.error_parts[3])

    @cached_property
    def raw_deviations(self) -> FloatArray:
        """Deviations along the normal with their noise, mm."""
        return self.raw_errors_at(self.zero) / self.responses[0]

    @cached_property
    def smooth_deviations(self) -> FloatArray:
        """Smooth deviations along the normal, mm, and those of outliers that are kept."""
        return np.asarray(
            self.raw_deviations
            - np.where(self.is_outlying & self.keep_outliers, 0.0, self.smoothing_curve.residuals)
        )

    @cached_property
    def smoothing_curve(self) -> Any:
        return smoothing_spline(replace(self.points, lifts=self.raw_deviations))

    @cached_property
    def is_outlying(self) -> BoolArray:
        """Which points the smooth deviation leaves off by more than noise does."""
        return np.asarray(np.abs(self.smoothing_curve.residuals) > self._noise_limit)

    @cached_property
    def _noise_limit(self) -> float:
        """What noise leaves of points, mm."""
        usual = float(np.median(np.abs(self.smoothing_curve.residuals))) / NORMAL_MEDIAN
        angles = np.round(self.points.angles, ANGLE_DIGITS)  # the first point may be measured again as the last
        return max(
            OUTLIER_OFF * max(point_noise(replace(self.points, angles=angles, lifts=self.raw_deviations)), usual),
            LEAST_POINT_ERROR,
        )

    @cached_property
    def noise(self) -> float:
        left = self.smoothing_curve.residuals[~self.is_outlying]
        return sqrt(float(left @ left) / (left.size - self.smoothing_curve.freedom))

    @cached_property
    def _outlier_arrays(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Rows of points that were left out, not reached or beyond noise, the furthest first.

        With their distances outside the profile of the drawing, mm, and what the axis of the bore makes of these.
        """
        every, kept = self.measured, np.isin(self.measured.rows, self.points.rows[~self.is_outlying])
        rows = every.rows[~kept]
        if not rows.size:
            return rows, np.empty(0), np.empty(0)
        off = self.followed_profile.distances(self.problem, degrees(self.zero), rows)
        of_row = dict(zip(self.points.rows.tolist(), self.bore_errors / self.responses[0], strict=True))
        known = np.isin(every.rows, self.points.rows)
        made = np.array([of_row[row] for row in every.rows[known].tolist()])
        axis = np.interp(every.angles[~kept], every.angles[known], made, period=TURN_DEG)
        told = [k for k in np.argsort(-np.abs(off - axis)) if abs(off - axis)[k] > self._noise_limit]
        return rows[told], off[told], axis[told]

    @property
    def outliers(self) -> tuple[OutlyingPoint, ...]:
        """With their distances."""
        return tuple(
            OutlyingPoint(int(row), float(off)) for row, off in zip(*self._outlier_arrays[:2], strict=True)
        )

    @cached_property
    def waves(self) -> ProfileHarmonics:
        """Those of the deviation, without the axis of the bore."""
        off = (
            np.where(self.is_outlying, self.smooth_deviations, self.raw_deviations)
            - self.bore_errors / self.responses[0]
        )
        return find_waves(np.radians(self.points.angles), off, self.noise)

    def _missing_ranges(self) -> Iterator[tuple[float, float]]:
        """Cam angles between which points are missing, deg."""
        at = dict(zip(self.points.rows.tolist(), np.degrees(self.cam_angles).tolist(), strict=True))
        kept = self.measured.pick_places(np.flatnonzero(np.isin(self.measured.rows, self.points.rows)).tolist())
        for k in find_gaps(kept):
            ends = [at[int(kept.rows[place % kept.rows.size])] for place in (k, k + 1)]
            low, high = ends if angle_from(*ends) < angle_from(*ends[::-1]) else ends[::-1]
            yield low, high

    def _uncounted_keys(self) -> Iterator[str]:
        """The keys of tolerances that are about nothing of what was measured."""
        counted = self._scene_of_measured.tolerances
        for each in contributions(self.scene, self.problem, np.zeros(1)):
            if getattr(counted, each.key, None) is None:
                yield each.key

    def _errors_at_tool(self, errors: FloatArray) -> FloatArray:
        """What errors of the follower are at the tool."""
        train = self.problem.setup.train
        if train is None:
            return errors
        ends = (self._follower_positions, self._follower_positions + errors)
        first, moved = (np.asarray(train.tool(Taylor([each])).terms[0]) for each in ends)
        return np.asarray(moved - first)

    @cached_property
    def _train_ratios(self) -> FloatArray:
        """The ratio of the train."""
        train = self.problem.setup.train
        if train is None:
            return np.ones(self.cam_angles.size)
        return np.asarray(train.tool(Taylor([self._follower_positions, np.ones(self.cam_angles.size)])).terms[1])

    @cached_property
    def _follower_positions(self) -> FloatArray:
        """Where the follower is asked to be, from where the train starts."""
        assert self.problem.setup.train is not None
        return np.asarray(
            self.problem.setup.train.follower_at(tool_position(self.problem.programme, self.cam_angles))
        )

    @property
    def _scene_of_measured(self) -> Scene:
        """The scene with those tolerances alone that are about what was measured."""
        given = self.scene.tolerances
        names = ["profile", "waves", "bore_eccentricity", *(["phase"] if self.aligned else [])]
        kept = {name: getattr(given, name) for name in names}
        return self.scene.replace(tolerances={key: each for key, each in kept.items() if each is not None})

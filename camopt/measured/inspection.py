"""A measured profile against the drawing of its scene: the error of motion that this cam has, and what makes it.

The follower of the scene touches each measured point at one cam angle θ and with one position, by exact contact
(``measured.profile``): less the one that is asked there, this is the error of the motion e. The cam is put on its
shaft as it fits best; what it has to be turned by is its phase. Along the normal the profile is off by δn = e/g,
with the answer g of the motion to the profile (``tolerances.response``). By least squares

    e(θ) ≈ y'·phase + g·size + b₁·ε₁ + b₂·ε₂

with the answers b to the axis of the bore, ε: the first harmonic of the deviation. What is left are waves. Smooth
errors are those of the smoothing spline; what it leaves is noise.

A wave of amplitude 2σ·√(ln(20·K)/n) is met by the noise σ of n points among K waves in one file of twenty.

Source: G. Wahba, Spline Models for Observational Data, ch. 4; Rayleigh's distribution of amplitudes of noise.
"""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, inf, isfinite, log, sqrt
from typing import Any, NamedTuple

import numpy as np

from camopt.effects.motion import scale, unit_of
from camopt.measured.columns import PROFILES, TableColumns
from camopt.measured.contact import position_of
from camopt.measured.fit import met_by_follower
from camopt.measured.profile import MeasuredProfile
from camopt.measured.reading import MeasuredPoints, read_points
from camopt.measured.smoothing import smoothed
from camopt.mechanisms.body import DISC
from camopt.mistakes import BadInput, Mistake
from camopt.motion.driven import tool_position
from camopt.numerics import FloatArray
from camopt.numerics.taylor import Taylor
from camopt.problem.problem import Problem, resolve_design
from camopt.quantities.shown import HasHtml
from camopt.scene.scene import Scene
from camopt.scene.tolerances import zone_of
from camopt.tables.cells import number, with_unit
from camopt.tables.layout import NUMERIC, Cell, Table
from camopt.tolerances.response import Responses
from camopt.tolerances.turn import TurnErrors
from camopt.tolerances.worst_case import WorstSearch

TURNS, FITS = 1440, 6
"""In how many ways the cam is put on its shaft at first, and how often this is made better."""
MOST_WAVES = 120
PER_WAVE = 4
"""Points of a wave, at least."""
ONE_IN = 20.0
"""Files in which noise looks like a wave."""
SHOWN_WAVES = 6


class ProfileWave(NamedTuple):
    """A harmonic of the deviation of a profile along its normal.

    Examples
    --------
    >>> turn = np.radians(np.arange(0, 360, 2))
    >>> rough = (20 + 0.01 * np.cos(7 * turn)) * np.exp(1j * turn)
    >>> points = camopt.MeasuredProfile(np.column_stack([rough.real, rough.imag]), "xy")
    >>> camopt.inspect(points, camopt.find_scene("bucket-valve")).waves[0].number > 0
    True
    """

    number: int
    """In a turn."""
    amplitude: float
    """mm."""


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


@dataclass(frozen=True)
class Inspection(HasHtml):
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

    @property
    def within(self) -> bool | None:
        """Whether no tolerance is exceeded; None if the scene has none of what was found."""
        shares = [each.share for each in self.used if each.share is not None]
        return None if not shares else max(shares) <= 1.0

    def table(self) -> Table:
        """What is found of each tolerance, beside what is allowed."""
        heads = ["", "allowed", "found", "used", "moves the tool"]
        rows = []
        for each in self.used:
            allowed = "" if each.allowed is None else with_unit(each.allowed, each.unit)
            share = "" if each.share is None else f"{100.0 * each.share:.3g} %"
            moves = "" if each.moves is None else with_unit(each.moves, self.unit)
            rows.append([each.key, allowed, with_unit(each.found, each.unit), share, moves])
        kinds = [Cell(head, NUMERIC if head else "") for head in heads]
        said = {None: "The scene has no tolerances", True: "Within all tolerances", False: "Beyond a tolerance"}
        off = f"The tool is off by {with_unit(self.error, self.unit)} at {number(self.at_deg)} deg"
        noise = f"noise of the points {with_unit(self.noise, 'mm')}"
        turned = f"The cam is ahead of the angles of the points by {number(self.phase_deg)} deg"
        note = f"{said[self.within]}. {off}; {noise}. {turned}. {self._of_waves}"
        return Table.of(f"{os.path.basename(self.file)} against {self.scene.name}", kinds, rows, note)

    @property
    def _of_waves(self) -> str:
        some = ", ".join(f"{each.number} of {with_unit(each.amplitude, 'mm')}" for each in self.waves[:SHOWN_WAVES])
        return f"Waves in a turn: {some}." if some else "No waves but those of noise."

    def records(self) -> list[dict[str, Any]]:
        """A mapping for each tolerance."""
        return [{**each._asdict(), "share": each.share} for each in self.used]

    @property
    def shown_cam(self) -> Scene:
        """The drawing."""
        return self.scene


def inspect(
    profile: MeasuredProfile,
    scene: Scene,
    columns: Sequence[str | int] | None = None,
    angle_unit: str = "deg",
    lift_unit: str | None = None,
    turn: float | None = None,
    keep_outliers: bool = False,
    *,
    aligned: bool = False,
) -> Inspection:
    """Find the error of motion that a measured cam has against its drawing, and which tolerance makes it.

    The follower of the scene is put on the measured profile by exact contact, with nominal sizes. The axis of the
    bore is that of the points. The cam is turned on its shaft to where the error is least, unless it is aligned.

    Parameters
    ----------
    profile : MeasuredProfile
        Points of the profile of a disc cam, as for ``fit``.
    scene : Scene
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
        Whether single points that are far off their neighbours count too.
    aligned : bool, default False
        Whether the angle 0 of the points is that of the scene, as measured from the keyway: phase counts then.

    Returns
    -------
    Inspection
        The error of the tool, how much of each tolerance is used, and the waves of the profile.

    Raises
    ------
    BadInput
        If the points are no profile that the follower can run on, with the row; or of a scene that is no disc cam.
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
    problem = resolve_design(scene)
    if problem.setup.mechanism.body != DISC:
        raise BadInput([Mistake(problem.file, "cam.form", scene.cam.form, "disc: a profile is that of a disc cam")])
    if lift_unit not in (None, "mm", "inch"):
        raise BadInput([Mistake("camopt", "lift_unit", lift_unit, "mm or inch for a profile")])
    read = TableColumns(columns, angle_unit, lift_unit or "mm", turn, PROFILES[profile.form])
    measured = read_points(profile.points, read)
    seen = met_by_follower(profile, measured, scene.to_dict(), problem.file, keep_outliers)
    return _Inspected(problem, scene, seen.positions.without(seen.lost), aligned).found()


@dataclass(frozen=True)
class _Inspected:
    """Positions of the follower on a measured profile, by cam angle."""

    problem: Problem
    scene: Scene
    points: MeasuredPoints
    aligned: bool

    def found(self) -> Inspection:
        """What is told of the cam."""
        errors = self.off * self.answers[0]
        if self.aligned:
            errors = errors + self._errors(0.0) - self._errors(self.zero)
        place = int(np.abs(errors).argmax())
        unit, tool = scale(self.problem.setup, 0), self._at_tool(errors)
        used = tuple(self._used(place, unit * float(np.abs(tool).max())))
        return Inspection(
            self.scene,
            self.phase,
            self.points.file,
            unit * float(tool[place]),
            float(np.degrees(self.places[place])),
            unit_of(self.problem.setup, 0),
            self.noise,
            used,
            self.waves,
            (float(self.parts[2]), float(self.parts[3])),
            float(self.parts[1]),
            np.degrees(self.places),
            unit * tool,
        )

    def _used(self, place: int, moved: float) -> Iterator[ToleranceUse]:
        given, unit = self.scene.tolerances, float(scale(self.problem.setup, 0))
        answer, bore = self.answers[0][place], self.bore
        apart = given.bore_eccentricity is not None
        rest = self.off - bore / self.answers[0] if apart else self.off
        waves = None if given.waves is None else float(given.waves)
        rate = float(self._rate[place]) * unit
        yield ToleranceUse(
            "profile", "mm", float(np.abs(rest).max()), given.profile, rate * float(rest[place] * answer)
        )
        if self.waves or waves:
            yield ToleranceUse("waves", "", float(max((w.number for w in self.waves), default=0)), waves, None)
        if apart:
            found = float(np.hypot(*self.parts[2:]))
            yield ToleranceUse("bore_eccentricity", "mm", found, given.bore_eccentricity, rate * float(bore[place]))
        if given.phase is not None and self.aligned:
            zone = zone_of(given.phase, "phase", 0.0)
            yield ToleranceUse(
                "phase", "deg", abs(self.phase), zone.upper if self.phase >= 0.0 else -zone.lower, None
            )
        if given.profile is not None or apart:
            bound = WorstSearch.of(TurnErrors(self._drawing, self.problem)).run().bound
            yield ToleranceUse(
                "motion", unit_of(self.problem.setup, 0), moved, bound if isfinite(bound) else None, moved
            )

    @cached_property
    def positions(self) -> FloatArray:
        """Positions of the follower, mm (rad)."""
        lifts = self.points.lifts
        return np.radians(lifts) if self.problem.setup.angular else lifts

    @cached_property
    def start(self) -> float:
        """The position on the base circle of the drawing."""
        return float(position_of(self.problem, self.problem.design)[0])

    def _errors(self, zero: float) -> FloatArray:
        """Positions less those of a cam that is turned on its shaft."""
        there = np.mod(np.radians(self.points.angles) - zero, self.turn)
        return np.asarray(self.positions - self.start - self.problem.programme.at(there)[0])

    @property
    def turn(self) -> float:
        return self.problem.programme.strokes[-1].end

    @cached_property
    def fitted(self) -> tuple[float, FloatArray]:
        """The angle of the points where the cam angle is 0, rad, and what makes the errors: phase, size, bore."""
        tried = np.linspace(0.0, self.turn, 1 if self.aligned else TURNS, endpoint=False)
        zero = tried[int(np.argmin([float(np.var(self._errors(each))) for each in tried]))]
        for _ in range(FITS):
            parts = np.asarray(np.linalg.lstsq(self._columns(zero), self._errors(zero), rcond=None)[0])
            zero -= parts[0]
        return float(zero), parts

    def _columns(self, zero: float) -> FloatArray:
        """How the errors answer to phase, size and the axis of the bore."""
        alone = replace(self.problem, setup=replace(self.problem.setup, train=None))
        answers = Responses(alone, np.mod(np.radians(self.points.angles) - zero, self.turn))
        slope = self.problem.programme.at(answers.angles)[1]
        return np.column_stack([slope, answers.to_profile[0], *(each[0] for each in answers.to_bore)])

    @property
    def zero(self) -> float:
        return self.fitted[0]

    @property
    def phase(self) -> float:
        """By how much the cam is ahead, deg."""
        return (180.0 - degrees(self.zero)) % 360.0 - 180.0

    @property
    def parts(self) -> FloatArray:
        return self.fitted[1]

    @cached_property
    def places(self) -> FloatArray:
        """Cam angles, rad."""
        return np.mod(np.radians(self.points.angles) - self.zero, self.turn)

    @cached_property
    def answers(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Of the follower to the profile, and to the two directions of the bore."""
        _, *found = self._columns(self.zero).T
        return found[0], found[1], found[2]

    @cached_property
    def bore(self) -> FloatArray:
        """What the axis of the bore makes of the errors."""
        return np.asarray(self.answers[1] * self.parts[2] + self.answers[2] * self.parts[3])

    @cached_property
    def raw(self) -> FloatArray:
        """Deviations along the normal with their noise, mm."""
        return self._errors(self.zero) / self.answers[0]

    @cached_property
    def off(self) -> FloatArray:
        """Smooth deviations along the normal, mm."""
        return np.asarray(self.raw - self.curve.off)

    @cached_property
    def curve(self) -> Any:
        return smoothed(replace(self.points, lifts=self.raw))

    @cached_property
    def noise(self) -> float:
        count = self.raw.size
        return sqrt(float(self.curve.off @ self.curve.off) / (count - self.curve.freedom))

    @cached_property
    def waves(self) -> tuple[ProfileWave, ...]:
        """Harmonics of the deviation from the second on, which noise does not explain."""
        rest, most = self.raw - self.bore / self.answers[0], min(MOST_WAVES, self.raw.size // PER_WAVE)
        orders = np.arange(1, most + 1)
        turned = np.outer(np.radians(self.points.angles), orders)
        columns = np.hstack([np.ones((rest.size, 1)), np.cos(turned), np.sin(turned)])
        found = np.linalg.lstsq(columns, rest, rcond=None)[0][1:]
        sizes = np.hypot(found[:most], found[most:])
        least = 2.0 * self.noise * sqrt(log(ONE_IN * most) / rest.size)
        waves = [
            ProfileWave(int(k), float(size))
            for k, size in zip(orders, sizes, strict=True)
            if k > 1 and size > least
        ]
        return tuple(sorted(waves, key=lambda wave: -wave.amplitude))

    def _at_tool(self, errors: FloatArray) -> FloatArray:
        """What errors of the follower are at the tool."""
        train = self.problem.setup.train
        if train is None:
            return errors
        stands = train.follower_at(tool_position(self.problem.programme, self.places))
        first, moved = (np.asarray(train.tool(Taylor([each])).terms[0]) for each in (stands, stands + errors))
        return np.asarray(moved - first)

    @cached_property
    def _rate(self) -> FloatArray:
        """The ratio of the train."""
        small = 1e-6
        return np.asarray(self._at_tool(np.full(self.places.size, small)) / small)

    @property
    def _drawing(self) -> Scene:
        """The scene with those tolerances alone that are about what was measured."""
        given = self.scene.tolerances
        names = ["profile", "waves", "bore_eccentricity", *(["phase"] if self.aligned else [])]
        kept = {name: getattr(given, name) for name in names}
        return self.scene.replace(tolerances={key: each for key, each in kept.items() if each is not None})

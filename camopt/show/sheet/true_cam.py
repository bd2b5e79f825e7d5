"""The subject of a sheet: one disc of a cam, its part, and its curves as polylines of proved deviation."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import degrees
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.model.effects import EvaluationBlock, available_quantities
from camopt.model.effects.solid import MASS
from camopt.model.mechanisms.geometry import CamCurves, cam_curves, mirror_curves
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import Stroke
from camopt.scene.part import Part
from camopt.scene.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.show.drawing.picture import END_SHARE, STROKE_NAMES, Picture
from camopt.show.sheet.languages import LANGUAGES, with_decimal_sign
from camopt.show.sheet.marks import Mark, Words, decimal_text
from camopt.solve.contour.curve import CamCurve, Disc, cam_discs, disc_curves
from camopt.solve.contour.path import ArcPath
from camopt.solve.contour.path_fitting import LONGEST_CHORD, SHORTEST_CHORD, FittedPath, fit_path
from camopt.solve.verdicts.effect_runs import run_effects

FINENESS = 2e-5  # of the cam's size: how far lines may be off its curves
LEAST_RAY_OFFSET = 1e-5  # rad: what is no further aside is rounding
POINT_STEP = 0.005  # of the cam's size: from one point that is drawn to the next


class Polyline(NamedTuple):
    """A curve as straight lines from point to point, and their largest deviation, mm."""

    points: ComplexArray
    deviation: float


def flatten_path(found: FittedPath, step: float) -> Polyline:
    """The arcs of a path as chords of at most a length, mm."""
    path = found.path
    assert isinstance(path, ArcPath)
    chords, sweeps = path.chords, path.sweeps
    counts = np.maximum(np.ceil(np.abs(chords) / np.cos(sweeps / 4) / step), 1.0).astype(int)
    fine = path.divide_arcs(counts)
    sagitta = np.abs(fine.chords * fine.bulges).max() / 2
    return Polyline(fine.vertices, found.deviation + float(sagitta))


def _segment_name(stroke: Stroke, steady: bool, stretches: Iterable[tuple[str, float, float]]) -> str:
    """The name of a segment, ``steady`` at constant velocity: rise or return for a move that goes one way only."""
    if not stroke.is_move:
        return STROKE_NAMES[stroke.kind]
    if steady:
        return "constant velocity"
    room = END_SHARE * stroke.angle
    ways = {name for name, begin, end in stretches if begin < stroke.end - room and end > stroke.start + room}
    return ways.pop() if len(ways) == 1 else "move"


def constant_velocity_strokes(programme: Programme) -> list[Stroke]:
    """The stretches at constant velocity of a motion as it is asked."""
    return [stroke for stroke in programme.strokes if stroke.is_move and not stroke.is_free]


@dataclass(frozen=True)
class TrueCam:
    """A cam of true size, by one of its discs: mm in its own frame."""

    scene: Scene
    problem: Problem
    place: int = 0
    """Which disc of a pair the sheet is of."""
    followed: dict[str, Polyline] = field(default_factory=dict, compare=False, repr=False)
    """Curves that the sheets of one cam have in common, as they are found, by name."""

    @cached_property
    def discs(self) -> tuple[Disc, ...]:
        """All discs on the shaft."""
        return cam_discs(self.problem)

    @property
    def is_ribbed(self) -> bool:
        """Whether both rollers are beside a rib."""
        return self.problem.setup.mechanism.has_rib

    @property
    def is_disc_pair(self) -> bool:
        """Whether there are two discs on the shaft, each with a sheet of its own."""
        return len(self.discs) > 1 and not self.is_ribbed

    @property
    def sheets(self) -> "list[TrueCam]":
        """The same cam by each disc that has a sheet."""
        return [replace(self, place=place) for place in range(len(self.discs) if self.is_disc_pair else 1)]

    @property
    def sheet(self) -> str:
        """The number of the sheet, and how many there are."""
        return f"{self.disc.number}/{len(self.sheets)}"

    @property
    def disc(self) -> Disc:
        """The disc of the sheet."""
        return self.discs[self.place]

    @property
    def disc_problem(self) -> Problem:
        """The problem of this disc alone; that of a second one as it is seen in the mirror."""
        return self.disc.problem

    def curves_at(self, angles: FloatArray) -> CamCurves:
        """The curves of this disc at cam angles (rad)."""
        own = self.disc_problem
        found = cam_curves(own.setup.mechanism, own.design, own.programme, angles)
        return found if self.disc.mirror > 0.0 else mirror_curves(found)

    @cached_property
    def picture(self) -> Picture:
        return Picture(self.scene, self.problem)

    @cached_property
    def part(self) -> Part:
        return self.scene.whole_part.disc_part(self.disc.number if self.is_disc_pair else None)

    @property
    def title(self) -> str:
        """The name of the part, and which disc of a pair without a hub it is."""
        name = self.part.name or ""
        return self.translate("{}, disc {}").format(name, self.disc.number) if name and self.is_loose_disc else name

    @property
    def is_loose_disc(self) -> bool:
        """Whether the sheet is of one disc of a pair that no hub joins to the other, a part of its own."""
        return self.is_disc_pair and not self.part.hub_diameter

    @property
    def translate(self) -> Callable[[str], str]:
        """What a text is in the language of the drawing."""
        return LANGUAGES[self.part.language]

    def localise_mark(self, mark: Mark) -> Mark:
        """A mark with the decimal sign of the language of the drawing."""
        return (
            mark._replace(text=with_decimal_sign(mark.text, self.part.language))
            if isinstance(mark, Words)
            else mark
        )

    @property
    def size(self) -> float:
        """Base radius, or mean radius of a cylindrical cam."""
        return float(self.disc_problem.design.size[0])

    @property
    def roller_radius(self) -> float:
        """The radius of the roller or of a spherical face; 0 if there is none."""
        return float(self.disc_problem.design.roller_radius[0])

    @property
    def sense(self) -> float:
        """+1 for a cam that turns ccw, −1 for cw."""
        return self.problem.design.sense

    @cached_property
    def curves(self) -> dict[str, Polyline]:
        """The curves of all discs by name; pitch curves only where they are paths of a roller's centre."""
        rolls = self.problem.setup.rolls
        for name, curve in disc_curves(self.problem).items():
            if name not in self.followed and (rolls or not name.endswith("pitch")):
                self.followed[name] = self._polyline_of(curve)
        return self.followed

    def _polyline_of(self, curve: CamCurve) -> Polyline:
        fine = float(np.clip(FINENESS * self.size, SHORTEST_CHORD, LONGEST_CHORD))
        return flatten_path(fit_path(curve, "arcs", fine), POINT_STEP * self.size)

    @cached_property
    def trace(self) -> ComplexArray:
        """The points of the pitch curve, even if it is not drawn because no roller's centre follows it."""
        drawn = self.curve("pitch")
        return drawn if drawn.size else self._polyline_of(self.disc.curves()["pitch"]).points

    def curve(self, name: str) -> ComplexArray:
        """The points of a curve of this disc; empty for one that is not drawn."""
        drawn = self.curves.get(f"{self.disc.prefix}{name}")
        return drawn.points if drawn else np.zeros(0, dtype=complex)

    @cached_property
    def other_profiles(self) -> list[ComplexArray]:
        """The profiles of the other discs; flanks of a rib are on one."""
        return (
            []
            if self.is_ribbed
            else [
                self.curves[f"{disc.prefix}profile"].points
                for disc in self.discs
                if disc.number != self.disc.number
            ]
        )

    @cached_property
    def segments(self) -> list[tuple[str, float, float]]:
        """The follower's motions and their cam angles, rad: the segments of the scene, if it has any."""
        found = [(STROKE_NAMES[kind], begin, end) for kind, begin, end in self.picture.stretches]
        if self.problem.segments:
            strokes, steady = self.problem.programme.strokes, self.steady_strokes
            found = [(_segment_name(each, each in steady, found), each.start, each.end) for each in strokes]
        return [
            (f"{self.translate(name)} {decimal_text(degrees(end - begin), 2)}°", begin, end)
            for name, begin, end in found
        ]

    @property
    def flank_height(self) -> float | None:
        """The depth of the groove of a cylinder, or the height of its rib, mm; None if it is not known."""
        found: float | None = getattr(self.part, self.problem.setup.mechanism.body.flank_height)
        return found

    @property
    def steady_strokes(self) -> list[Stroke]:
        """The follower's stretches at constant velocity; a tool's are none of the follower behind a train."""
        programme = self.problem.programme
        return constant_velocity_strokes(programme) if programme.tool is programme else []

    @cached_property
    def start_direction(self) -> float:
        """The direction of the trace point at cam angle 0, rad: from there the ring counts cam angles."""
        return float(np.angle(self.curves_at(self.picture.pieces[0][:1]).pitch[0]))

    @cached_property
    def ray_offsets(self) -> list[float]:
        """By how much (rad) the profile is touched beside the direction of the cam angle where each segment begins.

        Not at all where the trace point is in the direction that it had at cam angle 0, straight above its contact.
        """
        angles = np.array([begin for _, begin, _ in self.segments])
        found = np.angle(
            self.curves_at(angles).profile[0] * np.exp(1j * (self.sense * angles - self.start_direction))
        )
        return [float(aside) if abs(aside) > LEAST_RAY_OFFSET else 0.0 for aside in found]

    def quantity(self, name: str) -> float | None:
        """One quantity of this disc; None if the scene lacks a value that it needs."""
        return design_quantity(self.disc_problem if self.is_disc_pair else self.problem, name)

    @property
    def mass(self) -> float | None:
        """The mass of the part, kg: one disc of a pair, or both where a hub joins them; None if it is not known."""
        return design_quantity(self.disc_problem if self.is_loose_disc else self.problem, MASS)


def design_quantity(problem: Problem, name: str) -> float | None:
    """One quantity of a problem's own design; None if the scene lacks a value that it needs."""
    if name not in available_quantities(problem.setup):
        return None
    return float(
        run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), [name]).column(name)[0]
    )

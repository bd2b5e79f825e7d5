"""The subject of a sheet: one disc of a cam, its part, and its curves as polylines with proven deviation."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import degrees
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.model.effects import EvaluationBlock, available_quantities
from camopt.model.effects.solid import MASS
from camopt.model.mechanisms.geometry import CamCurves, cam_curves
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import Stroke
from camopt.scene.part import Part
from camopt.scene.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.show.drawing.picture import END_SHARE, STROKE_NAMES, Picture
from camopt.show.sheet.languages import LANGUAGES, with_decimal_sign
from camopt.show.sheet.marks import Mark, Words, decimal_text
from camopt.show.sheet.standards import sheet_standard
from camopt.solve.contour.curve import CamCurve, Disc, cam_discs, disc_curves
from camopt.solve.contour.path import ArcPath
from camopt.solve.contour.path_fitting import LONGEST_CHORD, SHORTEST_CHORD, fit_path
from camopt.solve.verdicts.effect_runs import run_effects

FINENESS = 2e-5  # share of the size of the cam: largest deviation of lines from its curves
LEAST_RAY_OFFSET = 1e-5  # rad: a smaller offset is rounding
POINT_STEP = 0.005  # share of the size of the cam: distance of drawn points


class Polyline(NamedTuple):
    """A curve as straight lines between points, with a bound of their deviation [mm]."""

    points: ComplexArray
    deviation: float


def _segment_name(
    stroke: Stroke, is_constant_velocity: bool, stroke_spans: Iterable[tuple[str, float, float]]
) -> str:
    """The name of a segment: "constant velocity", or "rise" or "return" for a move in one direction."""
    if not stroke.is_move:
        return STROKE_NAMES[stroke.kind]
    if is_constant_velocity:
        return "constant velocity"
    room = END_SHARE * stroke.angle
    ways = {name for name, begin, end in stroke_spans if begin < stroke.end - room and end > stroke.start + room}
    return ways.pop() if len(ways) == 1 else "move"


def constant_velocity_strokes(programme: Programme) -> list[Stroke]:
    """The strokes of a motion at constant velocity, as the scene gives them; none with a given profile."""
    if programme.radii:  # its arcs and lines give motions that no law of the scene has
        return []
    return [stroke for stroke in programme.strokes if stroke.is_move and not stroke.is_law_replaceable]


@dataclass(frozen=True)
class TrueCam:
    """A cam of true size, seen from one of its discs; lengths in mm, in its own frame."""

    scene: Scene
    problem: Problem
    place: int = 0
    """Index of the disc of the sheet."""
    followed: dict[str, Polyline] = field(default_factory=dict, compare=False, repr=False)
    """Cache of curves by name, shared by the sheets of a cam."""

    @cached_property
    def discs(self) -> tuple[Disc, ...]:
        """All discs on the shaft."""
        return cam_discs(self.problem)

    @property
    def is_ribbed(self) -> bool:
        """Whether two rollers touch a rib."""
        return self.problem.setup.mechanism.has_rib

    @property
    def is_disc_pair(self) -> bool:
        """Whether there are two discs on the shaft, each with its own sheet."""
        return len(self.discs) > 1 and not self.is_ribbed

    @property
    def cam_of_each_sheet(self) -> "list[TrueCam]":
        """The same cam for each sheet."""
        return [replace(self, place=place) for place in range(len(self.discs) if self.is_disc_pair else 1)]

    @property
    def disc(self) -> Disc:
        """The disc of the sheet, with its problem alone; a second disc is mirrored."""
        return self.discs[self.place]

    def curves_at(self, angles: FloatArray) -> CamCurves:
        """The curves of this disc at cam angles [rad]."""
        problem = self.disc.problem
        curves = cam_curves(problem.setup.mechanism, problem.design, problem.programme, angles)
        return curves if self.disc.mirror > 0.0 else CamCurves(*(each.conj() for each in curves))

    @cached_property
    def picture(self) -> Picture:
        return Picture(self.scene, self.problem)

    @cached_property
    def part(self) -> Part:
        return self.scene.whole_part.disc_part(self.disc.number if self.is_disc_pair else None)

    @property
    def title(self) -> str:
        """The name of the part, with the number of a disc of a pair without a hub."""
        name = self.part.name or ""
        return self.translate("{}, disc {}").format(name, self.disc.number) if name and self.is_loose_disc else name

    @property
    def is_loose_disc(self) -> bool:
        """Whether the disc of the sheet is its own part: no hub joins it to the other disc."""
        return self.is_disc_pair and not self.part.hub_diameter

    @property
    def translate(self) -> Callable[[str], str]:
        """A function that translates a text into the language of the drawing."""
        return LANGUAGES[self.language]

    @property
    def language(self) -> str:
        """The language of the drawing."""
        return "en" if sheet_standard().is_english else self.part.language

    def localise_mark(self, mark: Mark) -> Mark:
        """A mark with the decimal sign of the language of the drawing."""
        return mark._replace(text=with_decimal_sign(mark.text, self.language)) if isinstance(mark, Words) else mark

    @property
    def base_or_mean_radius(self) -> float:
        """Base radius, or mean radius of a cylindrical cam [mm]."""
        return float(self.disc.problem.design.size[0])

    @property
    def roller_radius(self) -> float:
        """Radius of the roller or spherical face [mm]; 0 without one."""
        return float(self.disc.problem.design.roller_radius[0])

    @property
    def sense(self) -> float:
        """+1 for a cam that turns ccw, −1 for cw."""
        return self.problem.design.sense

    @cached_property
    def curves(self) -> dict[str, Polyline]:
        """Curves of all discs by name; pitch curves only if they are paths of roller centres."""
        for name, curve in disc_curves(self.problem).items():
            if name not in self.followed and (self.problem.setup.rolls or not name.endswith("pitch")):
                self.followed[name] = self._polyline_of(curve)
        return self.followed

    def _polyline_of(self, curve: CamCurve) -> Polyline:
        """A curve as chords of fitted arcs."""
        fine = float(np.clip(FINENESS * self.base_or_mean_radius, SHORTEST_CHORD, LONGEST_CHORD))
        fitted = fit_path(curve, "arcs", fine)
        arcs, step = fitted.path, POINT_STEP * self.base_or_mean_radius
        assert isinstance(arcs, ArcPath)
        counts = np.maximum(np.ceil(np.abs(arcs.chords) / np.cos(arcs.sweeps / 4) / step), 1.0).astype(int)
        chords = arcs.divide_arcs(counts)
        sagitta = np.abs(chords.chords * chords.bulges).max() / 2
        return Polyline(chords.vertices, fitted.deviation + float(sagitta))

    @cached_property
    def pitch_curve_points(self) -> ComplexArray:
        """Points of the pitch curve, also if it is not drawn because there is no roller."""
        drawn = self.curve("pitch")
        return drawn if drawn.size else self._polyline_of(self.disc.curves()["pitch"]).points

    def curve(self, name: str) -> ComplexArray:
        """Points of a curve of this disc; empty if it is not drawn."""
        drawn = self.curves.get(f"{self.disc.curve_name_prefix}{name}")
        return drawn.points if drawn else np.zeros(0, dtype=complex)

    @cached_property
    def other_profiles(self) -> list[ComplexArray]:
        """Profiles of the other discs; none for a rib, whose flanks are on one disc."""
        return (
            []
            if self.is_ribbed
            else [
                self.curves[f"{disc.curve_name_prefix}profile"].points
                for disc in self.discs
                if disc.number != self.disc.number
            ]
        )

    @cached_property
    def segments(self) -> list[tuple[str, float, float]]:
        """Names of the follower's strokes with their cam angles [rad]; those of the scene's segments, if any."""
        found = [(STROKE_NAMES[kind], begin, end) for kind, begin, end in self.picture.stroke_kind_spans]
        if self.problem.segments:
            programme = self.problem.programme  # with a train only the tool has a constant velocity
            steady = constant_velocity_strokes(programme) if programme.tool is programme else []
            found = [(_segment_name(s, s in steady, found), s.start, s.end) for s in programme.strokes]
        return [
            (f"{self.translate(name)} {decimal_text(degrees(end - begin), 2)}°", begin, end)
            for name, begin, end in found
        ]

    @property
    def flank_height(self) -> float | None:
        """Depth of the groove of a cylinder, or height of its rib [mm]; None if unknown."""
        height: float | None = getattr(self.part, self.problem.setup.mechanism.body.flank_height)
        return height

    @cached_property
    def start_direction(self) -> float:
        """Direction of the trace point at cam angle 0 [rad]: the zero of the ring of cam angles."""
        return float(np.angle(self.curves_at(self.picture.angles_of_pieces[0][:1]).pitch[0]))

    @cached_property
    def contact_direction_offsets_from_rays(self) -> list[float]:
        """Angle from the ray of each segment start to the contact point on the profile [rad].

        It is 0 if the trace point has its direction of cam angle 0 and lies straight above its contact.
        """
        angles = np.array([begin for _, begin, _ in self.segments])
        offsets = np.angle(
            self.curves_at(angles).profile[0] * np.exp(1j * (self.sense * angles - self.start_direction))
        )
        return [float(offset) if abs(offset) > LEAST_RAY_OFFSET else 0.0 for offset in offsets]

    def quantity(self, name: str) -> float | None:
        """A quantity of this disc; None if the scene lacks a value that it needs."""
        return design_quantity(self.disc.problem if self.is_disc_pair else self.problem, name)

    @property
    def mass(self) -> float | None:
        """Mass of the part [kg]: one disc of a pair, or both with a hub; None if unknown."""
        return design_quantity(self.disc.problem if self.is_loose_disc else self.problem, MASS)


def design_quantity(problem: Problem, name: str) -> float | None:
    """A quantity of the design of a problem; None if the scene lacks a value that it needs."""
    if name not in available_quantities(problem.setup):
        return None
    return float(
        run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), [name]).column(name)[0]
    )

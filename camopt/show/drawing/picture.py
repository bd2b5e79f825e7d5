"""The contents of a picture: the problem sampled piece by piece, and its exact values."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.core.numerics.curves import value_of
from camopt.core.quantities import GEOMETRY
from camopt.core.quantities.unit_systems import shown_unit, to_shown_unit
from camopt.model.effects import EvaluationBlock, available_quantities, find_quantity, with_read_quantities
from camopt.model.effects.contacts import follower_contacts
from camopt.model.mechanisms.geometry import CamCurves, cam_curves
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RETURN, RISE
from camopt.scene.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.solve.verdicts.effect_runs import run_effects

STROKE_NAMES = {RISE: "rise", RETURN: "return", DWELL: "dwell"}
END_SHARE = 1e-9  # share of a piece that samples keep from its ends, to be on its side of a jump


@dataclass(frozen=True)
class Picture:
    """A scene's problem, sampled piece by piece so that no sample lies on a jump."""

    scene: Scene
    problem: Problem
    per_degree: ClassVar[float] = 4.0
    """Samples a degree."""

    @cached_property
    def pieces(self) -> list[FloatArray]:
        """Cam angles (rad) of each smooth piece of the motion."""
        table = self.problem.programme.table
        first, last = table.first_panel[:-1], table.first_panel[1:] - 1
        starts = table.centre[first] - table.half_width[first]
        ends = table.centre[last] + table.half_width[last]
        counts = np.maximum(25, np.degrees(ends - starts) * self.per_degree).astype(int)
        return [
            a + (b - a) * np.clip(np.linspace(0.0, 1.0, n), END_SHARE, 1.0 - END_SHARE)
            for a, b, n in zip(starts, ends, counts, strict=True)
        ]

    @cached_property
    def kinds(self) -> list[int]:
        """RISE, RETURN or DWELL of each piece."""
        return [int(kind) & ALL_STROKES for kind in self.problem.programme.table.kind]

    @cached_property
    def stretches(self) -> list[tuple[int, float, float]]:
        """RISE, RETURN or DWELL with its ends (rad); neighbouring pieces of one kind are joined."""
        starts = self.problem.programme.starts
        first = [k for k, kind in enumerate(self.kinds) if k == 0 or kind != self.kinds[k - 1]]
        ends = [*(float(starts[k]) for k in first[1:]), self.problem.programme.strokes[-1].end]
        return [(self.kinds[k], float(starts[k]), end) for k, end in zip(first, ends, strict=True)]

    @cached_property
    def motion(self) -> list[FloatArray]:
        """(y, y', y'', y''') of each piece, (4, samples)."""
        return [self.problem.programme.motion_at(angles) for angles in self.pieces]

    @cached_property
    def tool_motion(self) -> list[FloatArray]:
        """As ``motion``, of what is asked: the tool, or without a train the follower itself."""
        return [self.problem.programme.tool.motion_at(angles) for angles in self.pieces]

    @cached_property
    def tool_kinds(self) -> list[int]:
        """RISE, RETURN or DWELL of what is asked on each piece."""
        middles = np.array([(angles[0] + angles[-1]) / 2 for angles in self.pieces])
        return [int(kind) & ALL_STROKES for kind in self.problem.programme.tool.kinds_at(middles)]

    @cached_property
    def start_displacement(self) -> float:
        """The displacement at cam angle 0, mm or rad: 0, unless moves go lower."""
        return float(self.problem.programme.motion_at(np.zeros(1))[0, 0])

    @property
    def wanted_quantities(self) -> frozenset[str]:
        """The names of the quantities of the effects that the scene calls for, and of those of its geometry."""
        setup = self.problem.setup
        effects = {
            *GEOMETRY,
            *(
                find_quantity(name, setup).effect
                for name in with_read_quantities(self.problem.evaluated_quantities, setup)
            ),
        }
        return frozenset(
            name for name in available_quantities(setup) if find_quantity(name, setup).effect in effects
        )

    @cached_property
    def values(self) -> dict[str, Any]:
        """These quantities, exact."""
        case = EvaluationBlock(self.problem.setup, self.problem.programme, self.problem.design)
        with np.errstate(all="ignore"):
            rows = run_effects(case, self.wanted_quantities)
        return rows.records()[0]

    @cached_property
    def exists(self) -> bool:
        """Whether the mechanism can be put together at every cam angle."""
        return bool(self.problem.setup.mechanism.can_assemble(self.problem.design, self.problem.programme)[0])

    @cached_property
    def curves(self) -> list[CamCurves]:
        """The cam's curves of each piece, in the cam's own frame."""
        problem = self.problem
        with np.errstate(all="ignore"):
            return [
                cam_curves(problem.setup.mechanism, problem.design, problem.programme, angles)
                for angles in self.pieces
            ]

    @cached_property
    def contacts(self) -> "list[Picture]":
        """A picture of each contact of the follower, as that of an ordinary cam; of one contact itself."""
        if not self.problem.setup.mechanism.further_contacts:
            return [self]
        setup, design = self.problem.setup, self.problem.design
        return [
            replace(
                self,
                problem=replace(
                    self.problem, setup=replace(setup, mechanism=each.mechanism), design=each.local_designs(design)
                ),
            )
            for each in follower_contacts(setup)
        ]

    @property
    def steepest_contact(self) -> "Picture":
        """The picture of the contact with the largest pressure angle; of one disc alone always the first."""
        every = self.contacts if self.problem.setup.mechanism.two_profiles else self.contacts[:1]
        return max(every, key=lambda each: float(each.values["pressure_angle_max_deg"]))

    @property
    def body_contacts(self) -> "list[Picture]":
        """The pictures of those contacts that are on the first disc with a flank of their own: of a rib both."""
        return self.contacts if self.problem.setup.mechanism.has_rib else self.contacts[:1]

    @cached_property
    def reach(self) -> float:
        """The largest radius of all pitch curves, mm."""
        return float(max(np.abs(piece.pitch).max() for each in self.contacts for piece in each.curves))

    def curve_values(self, record: Any) -> list[FloatArray]:
        """One of the mechanism's curves on each piece."""
        return [self.curve_at(record, angles) for angles in self.pieces]

    def curve_at(self, record: Any, angles: FloatArray) -> FloatArray:
        """One of the mechanism's curves at cam angles (rad)."""
        with np.errstate(all="ignore"):
            return np.broadcast_to(value_of(record, 0, self.problem.programme.state(angles)), angles.shape)

    @property
    def undercut(self) -> bool:
        """Whether a part of the theoretical profile is cut away; a knife edge leaves every corner as it is."""
        return not self.problem.setup.is_knife and bool(
            self.values["undercut"] or self.values.get("self_crossing", False)
        )


def draw_line(axes: Any, points: Any, **style: Any) -> None:
    points = np.asarray(points, dtype=complex)
    axes.plot(points.real, points.imag, **style)


def fill_area(axes: Any, points: Any, **style: Any) -> None:
    points = np.asarray(points, dtype=complex)
    axes.fill(points.real, points.imag, **style)


def draw_circle(axes: Any, radius: float, centre: complex = 0.0, **style: Any) -> None:
    draw_line(axes, centre + radius * np.exp(1j * np.linspace(0.0, 2 * np.pi, 361)), **style)


def four_digits(value: float) -> str:
    """A number in four digits, or all of a larger whole number, with a real minus sign."""
    text = f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value + 0.0:.4g}"  # + 0.0: no −0
    return text.replace("-", "−")


def length_in_digits(length: float) -> str:
    """A length in mm in four digits, in the unit in which it is shown."""
    return four_digits(to_shown_unit(length, "mm"))


def value_with_unit(value: float, unit: str = "mm") -> str:
    """A number in a unit in four digits, with the unit, as they are shown."""
    return f"{four_digits(to_shown_unit(value, unit))} {shown_unit(unit)}"


def fit_axes(axes: Any, points: ComplexArray, margin: float) -> tuple[complex, float]:
    """Equal scales and limits round the points; the lower left corner and the mm to an inch."""
    box = axes.get_position()
    width, height = axes.figure.get_size_inches() * (box.width, box.height)
    points = points[np.isfinite(points)]
    low, high = complex(points.real.min(), points.imag.min()), complex(points.real.max(), points.imag.max())
    middle, extent = (low + high) / 2, (high - low) * (1 + 2 * margin)
    unit = max(extent.real / width, extent.imag / height)
    corner = middle - unit * complex(width, height) / 2
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(corner.real, corner.real + unit * width)
    axes.set_ylim(corner.imag, corner.imag + unit * height)
    return corner, unit


def round_length(length: float) -> float:
    """The largest of 1, 2, 5, 10, … that is no longer."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(max(step * power for step in (1, 2, 5) if step * power <= length))

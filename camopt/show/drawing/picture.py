"""Contents of a picture: the motion and curves of a design, sampled by smooth pieces, and its exact quantities."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from camopt.core.numerics import ComplexArray, Curve, FloatArray
from camopt.core.numerics.curves import curve_value
from camopt.core.quantities import GEOMETRY
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.effects import (
    EvaluationBlock,
    available_quantities,
    find_quantity,
    quantities_with_expression_inputs,
)
from camopt.model.effects.contacts import all_follower_contacts
from camopt.model.mechanisms.geometry import CamCurves, cam_curves
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RETURN, RISE
from camopt.scene.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.solve.verdicts.effect_runs import run_effects

STROKE_NAMES = {RISE: "rise", RETURN: "return", DWELL: "dwell"}
END_SHARE = 1e-9  # samples keep this share of a piece from its ends, so that none lies on a jump


@dataclass(frozen=True)
class Picture:
    """A scene with its problem, sampled by smooth pieces so that no sample lies on a jump."""

    scene: Scene
    problem: Problem
    per_degree: ClassVar[float] = 4.0
    """Samples per degree."""

    @property
    def is_developed(self) -> bool:
        """Whether the cam is drawn as the developed surface of a cylinder."""
        return self.problem.setup.mechanism.body.developed

    @cached_property
    def angles_of_pieces(self) -> list[FloatArray]:
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
    def stroke_kind_of_each_piece(self) -> list[int]:
        """RISE, RETURN or DWELL of each piece."""
        return [int(kind) & ALL_STROKES for kind in self.problem.programme.table.kind]

    @cached_property
    def stroke_kind_spans(self) -> list[tuple[int, float, float]]:
        """RISE, RETURN or DWELL with its ends (rad); neighbouring pieces of one kind are joined."""
        starts = self.problem.programme.piece_starts
        first = [
            k
            for k, kind in enumerate(self.stroke_kind_of_each_piece)
            if k == 0 or kind != self.stroke_kind_of_each_piece[k - 1]
        ]
        ends = [*(float(starts[k]) for k in first[1:]), self.problem.programme.strokes[-1].end]
        return [
            (self.stroke_kind_of_each_piece[k], float(starts[k]), end) for k, end in zip(first, ends, strict=True)
        ]

    @cached_property
    def motion(self) -> list[FloatArray]:
        """(y, y', y'', y''') of each piece, (4, samples)."""
        return [self.problem.programme.motion_at(angles) for angles in self.angles_of_pieces]

    @cached_property
    def tool_motion(self) -> list[FloatArray]:
        """(y, y', y'', y''') of the tool on each piece, (4, samples); of the follower without a train."""
        return [self.problem.programme.tool.motion_at(angles) for angles in self.angles_of_pieces]

    @cached_property
    def tool_stroke_kind_of_each_piece(self) -> list[int]:
        """RISE, RETURN or DWELL of the tool on each piece."""
        middles = np.array([(angles[0] + angles[-1]) / 2 for angles in self.angles_of_pieces])
        return [int(kind) & ALL_STROKES for kind in self.problem.programme.tool.kinds_at(middles)]

    @cached_property
    def start_displacement(self) -> float:
        """Displacement at cam angle 0 [mm or rad]; 0 unless moves go lower."""
        return float(self.problem.programme.motion_at(np.zeros(1))[0, 0])

    @property
    def quantities_to_evaluate(self) -> frozenset[str]:
        """Names of all quantities of geometry and of the effects that the scene needs."""
        setup = self.problem.setup
        effects = {
            *GEOMETRY,
            *(
                find_quantity(name, setup).effect
                for name in quantities_with_expression_inputs(self.problem.evaluated_quantities, setup)
            ),
        }
        return frozenset(
            name for name in available_quantities(setup) if find_quantity(name, setup).effect in effects
        )

    @cached_property
    def quantity_values(self) -> dict[str, Any]:
        """The wanted quantities, exact."""
        case = EvaluationBlock(self.problem.setup, self.problem.programme, self.problem.design)
        with np.errstate(all="ignore"):
            rows = run_effects(case, self.quantities_to_evaluate)
        return rows.records()[0]

    @cached_property
    def can_assemble(self) -> bool:
        """Whether the mechanism can be assembled at every cam angle."""
        return bool(self.problem.setup.mechanism.can_assemble(self.problem.design, self.problem.programme)[0])

    @cached_property
    def curves(self) -> list[CamCurves]:
        """Curves of the cam on each piece, in the frame of the cam."""
        problem = self.problem
        with np.errstate(all="ignore"):
            return [
                cam_curves(problem.setup.mechanism, problem.design, problem.programme, angles)
                for angles in self.angles_of_pieces
            ]

    @cached_property
    def contacts(self) -> "list[Picture]":
        """A picture of each contact of the follower, as of a cam with one contact; with one contact, itself."""
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
            for each in all_follower_contacts(setup)
        ]

    @property
    def steepest_contact(self) -> "Picture":
        """The contact with the largest pressure angle; with one disc always the first contact."""
        contacts = self.contacts if self.problem.setup.mechanism.has_two_profiles else self.contacts[:1]
        return max(contacts, key=lambda contact: float(contact.quantity_values["pressure_angle_max_deg"]))

    @property
    def first_disc_contacts(self) -> "list[Picture]":
        """The contacts whose flanks are drawn on the first disc: both contacts of a rib, else the first."""
        return self.contacts if self.problem.setup.mechanism.has_rib else self.contacts[:1]

    @cached_property
    def largest_pitch_radius(self) -> float:
        """Largest radius of all pitch curves [mm]."""
        return float(max(np.abs(piece.pitch).max() for each in self.contacts for piece in each.curves))

    def curve_values(self, curve: Curve) -> list[FloatArray]:
        """A curve of the mechanism on each piece."""
        return [self.curve_values_at(curve, angles) for angles in self.angles_of_pieces]

    def curve_values_at(self, curve: Curve, angles: FloatArray) -> FloatArray:
        """A curve of the mechanism at cam angles [rad]."""
        with np.errstate(all="ignore"):
            return np.broadcast_to(curve_value(curve, 0, self.problem.programme.state(angles)), angles.shape)

    @property
    def undercut(self) -> bool:
        """Whether a part of the theoretical profile is cut away; false for a knife edge, which cuts no corner."""
        return not self.problem.setup.is_knife and bool(
            self.quantity_values["undercut"] or self.quantity_values.get("self_crossing", False)
        )


def draw_line(axes: Any, points: Any, **style: Any) -> None:
    points = np.asarray(points, dtype=complex)
    axes.plot(points.real, points.imag, **style)


def fill_area(axes: Any, points: Any, **style: Any) -> None:
    points = np.asarray(points, dtype=complex)
    axes.fill(points.real, points.imag, **style)


def draw_circle(axes: Any, radius: float, centre: complex = 0.0, **style: Any) -> None:
    draw_line(axes, centre + radius * np.exp(1j * np.linspace(0.0, 2 * np.pi, 361)), **style)


def four_digit_text(value: float) -> str:
    """A number with four digits, or all digits before the point, and a real minus sign."""
    text = f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value + 0.0:.4g}"  # + 0.0: no −0
    return text.replace("-", "−")


def four_digit_length_text(length: float) -> str:
    """A length given in mm, as text with four digits in the shown unit."""
    return four_digit_text(to_shown_unit(length, "mm"))


def value_with_unit(value: float, unit: str = "mm") -> str:
    """A number with four digits and its unit, converted to the shown unit."""
    return f"{four_digit_text(to_shown_unit(value, unit))} {unit_in_shown_system(unit)}".rstrip()


def fit_axes(axes: Any, points: ComplexArray, margin: float) -> tuple[complex, float]:
    """Set equal scales and limits around points; return the lower left corner and the mm per inch."""
    box = axes.get_position()
    width, height = axes.figure.get_size_inches() * (box.width, box.height)
    points = points[np.isfinite(points)]
    low, high = complex(points.real.min(), points.imag.min()), complex(points.real.max(), points.imag.max())
    middle, extent = (low + high) / 2, (high - low) * (1 + 2 * margin)
    unit = max(extent.real / width, extent.imag / height)
    corner = middle - unit * complex(width, height) / 2
    axes.set_aspect("equal", adjustable="box")
    axes.set(xlim=(corner.real, corner.real + unit * width), ylim=(corner.imag, corner.imag + unit * height))
    return corner, unit


def round_down_to_1_2_5(value: float) -> float:
    """The largest of …, 1, 2, 5, 10, … that is not above ``value``."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step * power for step in (1, 2, 5) if step * power <= value))

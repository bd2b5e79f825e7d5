"""The views of a cylindrical cam: groove or rib developed at the mean radius, its section, the hole for the shaft.

The groove (rib) is drawn over one turn, with cam angle 0 on the left: as seen from outside where the cam turns
clockwise (as seen from above, where the lift goes), else from inside. Its middle is in the middle of the
cylinder's length. The section goes through the axis, at the cam angles of the keyway and opposite to it; the
groove (rib) is as wide in it as its flanks at the mean radius are apart along the axis.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import degrees, pi
from typing import Any

import numpy as np
from shapely import LineString, box, union_all

from camopt.core.numerics import ComplexArray
from camopt.scene.part import Part
from camopt.show.sheet import symbols
from camopt.show.sheet.dimensions import (
    ARROW_LENGTH,
    CELL,
    DATUM_REACH,
    FIRST_LEVEL,
    LEVEL_STEP,
    STEM,
    TEXT_ABOVE_LINE,
    VALUE_GAP,
    arrowhead,
    datum_symbol,
    distance_dimension,
)
from camopt.show.sheet.marks import (
    CHAIN,
    DOUBLE_CHAIN,
    LARGE,
    MEDIUM,
    THICK,
    Line,
    Marks,
    Pen,
    Words,
    decimal_text,
    line_mark,
    marks_box,
    rectangle_line,
    shift_marks,
    text_width,
)
from camopt.show.sheet.section import Gap, hatch_lines, keyway_edge_behind_section, outline_lines
from camopt.show.sheet.sizes import (
    bore_and_keyway_outline,
    bore_text,
    groove_width_text,
    keyway_depth_text,
    profile_symbols,
    size_text_with_fit,
)
from camopt.show.sheet.standards import length_text, size_text
from camopt.show.sheet.true_cam import POINT_STEP, TrueCam
from camopt.solve.contour.curve import centred_cylinder_ends, pitch_curve_axial_extent
from camopt.solve.contour.hole import keyway_direction_angle

GROOVE_MARGIN = 0.15  # share of the height of the groove drawn beside it if the length is unknown
VIEW_GAP = 12.0  # mm between views
LEADER_LENGTH = 12.0  # mm from a frame to the end of its leader


@dataclass(frozen=True)
class DevelopedView:
    """Views of a cylindrical cam; lengths in mm on the paper, at one scale."""

    cam: TrueCam
    scale: float

    @property
    def part(self) -> Part:
        return self.cam.part

    @property
    def mean_radius(self) -> float:
        return self.cam.base_or_mean_radius * self.scale

    @property
    def circumference(self) -> float:
        return 2 * pi * self.mean_radius

    @cached_property
    def pitch(self) -> ComplexArray:
        """The developed path of the roller's centre, or of another trace point."""
        return self.cam.pitch_curve_points * self.scale

    @cached_property
    def axial_ends(self) -> tuple[float, float]:
        """Ends of the cylinder along its axis."""
        low, high = pitch_curve_axial_extent(self.cam.problem)
        shown = (1.0 + 2 * GROOVE_MARGIN) * (high - low + 2 * self.cam.roller_radius)
        bottom, top = centred_cylinder_ends(self.cam.problem, self.part.thickness or shown)
        return bottom * self.scale, top * self.scale

    def developed_cylinder_marks(self) -> Marks:
        """The developed cylinder from its lower left corner at x = 0, with the names of strokes above it."""
        (bottom, top), end = self.axial_ends, self.circumference
        marks: Marks = [
            rectangle_line(1j * bottom, complex(end, top), THICK),
            *self._visible_lines(self._curves_over_turns("profile"), THICK),
            *self._visible_lines(self._curves_over_turns("pitch"), DOUBLE_CHAIN),
        ]
        room = {LARGE: VALUE_GAP + ARROW_LENGTH, MEDIUM: VALUE_GAP}  # large letters reach down to the arrows
        foot = top + FIRST_LEVEL + 2.0
        for name, begin, after in self.cam.segments:
            x, to = begin * self.mean_radius, after * self.mean_radius
            height = next((h for h, beside in room.items() if text_width(name, h) + 2 * beside <= to - x), None)
            if height is None:
                marks.append(Words(complex((x + to + MEDIUM) / 2, foot + 3.0), name, MEDIUM, 0.0, pi / 2))
            else:
                ends = complex(x, foot), complex(to, foot)
                marks.append(line_mark(*ends))
                marks += [arrowhead(ends[0], -1.0), arrowhead(ends[1], 1.0)] if to - x > 8.0 else []
                marks.append(Words(complex((x + to) / 2, foot + TEXT_ABOVE_LINE), name, height, 0.5))
            marks.append(line_mark(complex(x, top + 1.0), complex(x, top + FIRST_LEVEL + 4.0)))
            marks += [line_mark(complex(x, bottom), complex(x, top), pen=CHAIN)] if x else []
        marks.append(line_mark(complex(end, top + 1.0), complex(end, top + FIRST_LEVEL + 4.0)))
        low = end + 1j * bottom
        marks += distance_dimension(1j * bottom, low, 1.0, -FIRST_LEVEL, self._circumference_text)
        if length := self.part.thickness:
            marks += distance_dimension(low, low + 1j * (top - bottom), 1j, -FIRST_LEVEL, size_text(length))
        return [*marks, *self._groove_width_marks(), *self._surface_motion_and_flank_marks()]

    def _curves_over_turns(self, name_part: str) -> list[ComplexArray]:
        """The flanks, or the paths of rollers, over this turn and both neighbouring turns."""
        found = [curve.points * self.scale for name, curve in self.cam.curves.items() if name_part in name]
        return [np.concatenate([each - self.circumference, each, each + self.circumference]) for each in found]

    def _visible_lines(self, curves: list[ComplexArray], pen: Pen) -> Iterator[Line]:
        """The parts of curves that are on the cylinder."""
        bottom, top = self.axial_ends
        face = box(0.0, bottom, self.circumference, top)
        for curve in curves:
            inside = LineString(np.column_stack([curve.real, curve.imag])).intersection(face)
            for piece in getattr(inside, "geoms", [inside]):
                if piece.geom_type == "LineString" and not piece.is_empty:
                    x, y = np.asarray(piece.coords.xy)
                    yield Line(x + 1j * y, pen)

    @property
    def _circumference_text(self) -> str:
        size = self.cam.base_or_mean_radius
        return f"{length_text(2 * pi * size)} (2π · R{length_text(size)})"

    def _groove_width_marks(self) -> Marks:
        """Dimensions of the width of groove or rib at cam angle 0, and of its middle from the lower face."""
        bottom, (low, high) = 1j * self.axial_ends[0], self._both_flank_heights(0.0)
        if self.cam.is_ribbed:  # along the axis
            start, half = 0.5j * (low + high), (high - low) / 2
        else:  # across the groove
            start, half = (
                1j * float(self.pitch[0].imag),
                self.cam.problem.wall_distance_from_pitch_curve * self.scale,
            )
        text = length_text(2 * half / self.scale) if self.cam.is_ribbed else groove_width_text(self.cam)
        marks = distance_dimension(start - 1j * half, start + 1j * half, 1j, FIRST_LEVEL, text)
        if self.part.thickness:
            far = length_text(abs(start - bottom) / self.scale)
            marks += distance_dimension(bottom, start, 1j, FIRST_LEVEL + LEVEL_STEP, far)
        datum = symbols.datums_of(self.part, self.has_section).face
        return marks + datum_symbol(bottom - FIRST_LEVEL - LEVEL_STEP / 2, -1j, STEM, datum)

    def _surface_motion_and_flank_marks(self) -> Marks:
        """Below the surface: its direction of motion; tolerance and roughness of the flanks with a leader."""
        level = self.axial_ends[0] - FIRST_LEVEL
        tip = complex(self.circumference * 0.02, level - 8.0)
        marks: Marks = [
            line_mark(tip + 15.0, tip + symbols.ROTATION_ARROW[0], pen=THICK),
            arrowhead(tip, -1.0, *symbols.ROTATION_ARROW),
            Words(tip + complex(17.0, -MEDIUM / 2), self.cam.translate("the surface moves"), MEDIUM),
        ]
        frame = profile_symbols(self.part, self.has_section)
        if not frame:
            return marks
        corner = complex(self.circumference, level - 2.0) - marks_box(frame).high
        # end of the leader, if there is room
        end = self.circumference / 2 + text_width(self._circumference_text, LARGE) / 2 + VALUE_GAP
        corner += max(0.0, end + LEADER_LENGTH - corner.real) if end <= self.circumference else 0.0
        place = int(np.argmin(np.abs(self.pitch.real - (corner.real - LEADER_LENGTH))))
        x, flanks = float(self.pitch.real[place]), np.concatenate(self._curves_over_turns("profile"))
        low = x + 1j * float(flanks.imag[np.abs(flanks.real - x) <= POINT_STEP * self.mean_radius].min())
        shelf = corner + 0.5j * CELL
        knee = shelf - 4.0
        leader = [line_mark(shelf, knee, low), arrowhead(low, (low - knee) / abs(low - knee))]
        return [*marks, *shift_marks(frame, corner), *leader]

    @property
    def has_section(self) -> bool:
        """Whether the sizes of a section are known."""
        return bool(self.part.thickness and self.cam.flank_height)

    @property
    def _flank_height(self) -> float:
        """Depth of the groove, or height of the rib, on the paper."""
        return (self.cam.flank_height or 0.0) * self.scale

    @property
    def outer_radius(self) -> float:
        return self.mean_radius + self._flank_height / 2

    @property
    def _cylinder_radius(self) -> float:
        """Radius of the cylinder without its rib."""
        return self.outer_radius - self._flank_height if self.cam.is_ribbed else self.outer_radius

    def section_and_bore_marks(self) -> Marks:
        """Section and hole side by side, if the scene gives their sizes."""
        section = self.axial_section_marks() if self.has_section else []
        hole = self.bore_marks() if self.part.bore else []
        shift = marks_box(section).high.real + VIEW_GAP - marks_box(hole).low.real if section and hole else 0.0
        return [*section, *shift_marks(hole, shift)]

    def axial_section_marks(self) -> Marks:
        """The section through the axis at y = 0, with the lower end of the developed view on the left."""
        length, solid = (self.part.thickness or 0.0) * self.scale, self._section_solid()
        round_, radius = self._cylinder_radius, (self.part.bore or 0.0) / 2 * self.scale
        marks: Marks = [
            *outline_lines(solid),
            *hatch_lines(solid),
            line_mark(-4.0 + 0j, length + 4.0 + 0j, pen=CHAIN),
            *(line_mark(-1j * round_ + x, 1j * round_ + x, pen=THICK) for x in (0.0, length)),
            *keyway_edge_behind_section(self.part, self.scale, length),
            *self._rib_edges_behind_section(),
            *(line_mark(complex(0.0, y), complex(length, y), pen=THICK) for y in (-round_, round_)),
        ]
        low, beyond = -1j * round_, self.outer_radius - round_ + FIRST_LEVEL
        marks += distance_dimension(low, low + length, 1.0, -beyond, size_text(self.part.thickness or 0.0))
        marks += self._diameter_marks()
        if radius:
            marks += distance_dimension(
                length - 1j * radius, length + 1j * radius, 1j, -FIRST_LEVEL, bore_text(self.part)
            )
        feet = self.outer_radius + VALUE_GAP, -self.outer_radius - FIRST_LEVEL - VALUE_GAP - MEDIUM
        for gap, turn, foot in zip(self._groove_ranges_in_section, self._section_angles, feet, strict=True):
            text = f"{decimal_text(degrees(turn % (2 * pi)))}°"  # cam angle of the section
            marks.append(Words(complex(sum(gap) / 2, foot), text, MEDIUM, 0.5))
        corner, far = (
            complex(self._groove_ranges_in_section[0][1], self.outer_radius),
            length + FIRST_LEVEL + LEVEL_STEP * bool(radius),
        )
        ends = corner - 1j * self._flank_height, complex(length, self.outer_radius)
        ends = (ends[1] - 1j * self._flank_height, corner) if self.cam.is_ribbed else ends
        marks += distance_dimension(*ends, 1j, ends[0].real - far, size_text(self._flank_height / self.scale))
        datum = symbols.datums_of(self.part, self.has_section).bore
        return marks + datum_symbol(complex(length + FIRST_LEVEL, -radius), -1j, STEM, datum)

    def _diameter_marks(self) -> Marks:
        """Dimensions of the outer diameter, and of the cylinder below a rib."""
        outer = f"Ø{size_text_with_fit(2 * self.outer_radius / self.scale, self.part.outer_fit)}"
        if not self.cam.is_ribbed:
            return distance_dimension(-1j * self.outer_radius, 1j * self.outer_radius, 1j, FIRST_LEVEL, outer)
        above, below = self._groove_ranges_in_section
        foot = self._cylinder_radius
        marks = distance_dimension(-1j * foot, 1j * foot, 1j, FIRST_LEVEL, f"Ø{size_text(2 * foot / self.scale)}")
        ends = complex(below[0], -self.outer_radius), complex(above[0], self.outer_radius)
        return marks + distance_dimension(*ends, 1j, ends[0].real + FIRST_LEVEL + LEVEL_STEP, outer)

    def _rib_edges_behind_section(self) -> Iterator[Line]:
        """The edges of a rib behind the section, outside of the cylinder."""
        if not self.cam.is_ribbed:
            return
        first, _ = self._section_angles
        for flank in self._curves_over_turns("profile"):
            turned = flank.real / self.mean_radius - first
            level = self.outer_radius * np.cos(turned)
            seen = (
                (self.cam.sense * np.sin(turned) >= 0.0)
                & (np.abs(level) >= self._cylinder_radius)
                & (np.abs(turned) < pi)
            )
            pieces = np.split(np.flatnonzero(seen), np.flatnonzero(np.diff(np.flatnonzero(seen)) > 1) + 1)
            lines = flank.imag - self.axial_ends[0] + 1j * level
            yield from (Line(lines[piece], THICK) for piece in pieces if piece.size > 1)

    @property
    def _section_angles(self) -> tuple[float, float]:
        """Cam angles of the section [rad]: in the direction of the keyway and opposite."""
        first = self.cam.sense * (pi / 2 - keyway_direction_angle(self.part))
        return first, first + pi

    @cached_property
    def _groove_ranges_in_section(self) -> tuple[Gap, Gap]:
        """Ranges of the groove along the axis, in the direction of the keyway and opposite."""
        above, below = (
            (low - self.axial_ends[0], high - self.axial_ends[0])
            for low, high in map(self._both_flank_heights, self._section_angles)
        )
        return above, below

    def _both_flank_heights(self, cam_angle: float) -> Gap:
        """Heights of both flanks at a cam angle [rad], where they cross its vertical."""
        x, heights = cam_angle % (2 * pi) * self.mean_radius, []
        for flank in self._curves_over_turns("profile"):
            beside, y = flank.real - x, flank.imag
            before = np.flatnonzero((beside[:-1] < 0.0) != (beside[1:] < 0.0))
            share = beside[before] / (beside[before] - beside[before + 1])
            heights.append(y[before] + share * (y[before + 1] - y[before]))
        found = np.concatenate(heights)
        return float(found.min()), float(found.max())

    def _section_solid(self) -> Any:
        """The cut material, as a shape of shapely."""
        length, depth, round_ = (self.part.thickness or 0.0) * self.scale, self._flank_height, self._cylinder_radius
        radius = (self.part.bore or 0.0) / 2 * self.scale
        key = (self.part.keyway_depth or 0.0) * self.scale
        above, below = self._groove_ranges_in_section
        body = box(0.0, -round_, length, round_)
        beyond = 0.0 if self.cam.is_ribbed else 1.0
        cut = union_all(
            [
                box(above[0], self.outer_radius - depth, above[1], self.outer_radius + beyond),
                box(below[0], -self.outer_radius - beyond, below[1], depth - self.outer_radius),
            ]
        )
        whole = body.union(cut) if self.cam.is_ribbed else body.difference(cut)
        return whole.difference(box(-1.0, -radius, length + 1.0, radius + key)) if radius else whole

    def bore_marks(self) -> Marks:
        """The bore with its keyway on top, seen along the axis."""
        part, radius = self.part, (self.part.bore or 0.0) / 2 * self.scale
        over = radius + 4.0
        marks: Marks = [
            Line(bore_and_keyway_outline(part, pi / 2) * self.scale, THICK),
            *(line_mark(-over * along, over * along, pen=CHAIN) for along in (1.0, 1j)),
        ]
        if not self.has_section:
            marks += distance_dimension(1j * radius, -1j * radius, -1j, radius + FIRST_LEVEL, bore_text(part))
        if part.keyway_width and part.keyway_depth:
            half, top = part.keyway_width / 2 * self.scale, radius + part.keyway_depth * self.scale
            width = size_text_with_fit(part.keyway_width, part.keyway_fit)
            datum = symbols.datums_of(part, self.has_section).keyway
            marks += distance_dimension(complex(-half, top), complex(half, top), 1.0, FIRST_LEVEL, width, datum)
            aside = max(radius + FIRST_LEVEL, half + DATUM_REACH + VALUE_GAP) if datum else radius + FIRST_LEVEL
            marks += distance_dimension(-1j * radius, 1j * top, 1j, aside, keyway_depth_text(part))
        return marks

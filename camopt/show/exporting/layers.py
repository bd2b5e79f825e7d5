"""The plan of a cam in layers, in its own frame [mm]: curves, circles, bore, centre marks, follower and train.

Follower and train are drawn with the tool lowest, halfway and highest. Each position has its own layer, named by
its cam angle; the fixed parts have another. The cam of the plan is at cam angle 0. In each position a line shows
where the timing line of the cam is: from its centre, or along the axis of a developed cylinder.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from camopt.model.motion.tool_drive import tool_position
from camopt.model.trains.sketch import Member
from camopt.scene.problem.linkage import follower_pivot, linkage_sketch
from camopt.scene.problem.problem import Problem
from camopt.show.exporting.cam_points import check_cutter
from camopt.show.exporting.workpiece import Workpiece
from camopt.solve.contour.curve import centred_cylinder_ends
from camopt.solve.contour.hole import bore_with_keyway
from camopt.solve.contour.path import ArcPath, CubicPath
from camopt.solve.contour.path_fitting import FittedPath, check_path_options, fit_path

MARK_OVERRUN = 0.06  # share of the size that centre marks extend
VISIBLE, THIN_LINE, CHAIN_LINE, DASHED = "visible", "thin", "chain", "dashed"
"""Kinds of lines (ISO 128): outlines, thin lines, centre lines, and paths of tools."""


class Circle(NamedTuple):
    """A circle, by default about the centre of the cam."""

    radius: float
    centre: complex = 0j


@dataclass(frozen=True)
class Layer:
    """Paths, circles and straight lines in one kind of line."""

    name: str
    line: str
    paths: tuple[ArcPath | CubicPath, ...] = ()
    circles: tuple[Circle, ...] = ()
    lines: tuple[tuple[complex, complex], ...] = ()

    def with_factor(self, factor: float) -> "Layer":
        """The layer in another unit of length."""
        paths = tuple(path.scale_length(factor) for path in self.paths)
        circles = tuple(Circle(factor * radius, factor * centre) for radius, centre in self.circles)
        return replace(
            self, paths=paths, circles=circles, lines=tuple((factor * a, factor * b) for a, b in self.lines)
        )


@dataclass(frozen=True)
class Plan:
    """All layers, and the paths fitted to the curves of the cam by name, with proven deviations."""

    layers: tuple[Layer, ...]
    followed: dict[str, FittedPath]
    reach: tuple[complex, complex]
    """Corners of the rectangle around all layers [mm]."""


def plan_of(work: Workpiece, chord: float, curves: str, cutter_radius: float | None) -> Plan:
    """The plan of a cam, with curves within ``chord`` [mm] as arcs, a spline or a polyline."""
    problem = work.problem
    check_path_options(curves, chord)
    check_cutter(problem, cutter_radius)
    drawn = work.curves(cutter_radius)
    if not problem.design.roller_radius[0]:  # for a knife edge it equals the profile
        drawn.pop("pitch", None)
    followed = {name: fit_path(curve, curves, chord) for name, curve in drawn.items()}
    layers = []
    for name, each in followed.items():
        kind = name.removeprefix("second_")
        line = VISIBLE if kind.startswith("profile") else CHAIN_LINE if kind == "pitch" else DASHED
        layers.append(Layer(name, line, (each.path,)))
    corners = np.concatenate([_hull_points(each.path) for each in followed.values()])
    layers += (
        _developed_cylinder_layers(work, corners)
        if problem.setup.mechanism.body.developed
        else _disc_circles_and_centre_marks(work, corners)
    )
    ends = [end for layer in layers for line in layer.lines for end in line]
    every = np.concatenate([corners, np.array(ends, dtype=complex)])
    low, high = complex(every.real.min(), every.imag.min()), complex(every.real.max(), every.imag.max())
    return Plan(tuple(layers), followed, (low, high))


def _hull_points(path: ArcPath | CubicPath) -> np.ndarray:
    """Points whose hull contains a path: control points, or vertices and corners around the bulges."""
    if isinstance(path, CubicPath):
        return path.controls.ravel()
    inner = path.vertices[:-1] + path.chords * np.array([[0.0], [1.0]]) - 0.5j * path.bulges * path.chords
    return np.concatenate([path.vertices, inner.ravel()])


def _disc_circles_and_centre_marks(work: Workpiece, corners: np.ndarray) -> Iterator[Layer]:
    """Circles and centre marks of a disc cam."""
    part = work.part
    round_ = max(part.hub_diameter or 0.0, part.outer_diameter or 0.0) / 2
    left, low = (min(float(each.min()), -round_) for each in (corners.real, corners.imag))
    right, high = (max(float(each.max()), round_) for each in (corners.real, corners.imag))
    beyond = MARK_OVERRUN * max(right - left, high - low)
    for disc in work.discs:
        design, flank = disc.problem.design, disc.problem.setup.mechanism.flanks[0]
        prime = float(design.prime_radius[0])
        base = float((design.size + (1.0 + flank.side) * design.roller_radius)[0])  # smallest circle of the flank
        yield Layer(f"{disc.curve_name_prefix}base-circle", CHAIN_LINE, circles=(Circle(base),))
        if prime != base and not disc.problem.setup.mechanism.flat_faced:
            yield Layer(f"{disc.curve_name_prefix}prime-circle", CHAIN_LINE, circles=(Circle(prime),))
    round_bore = None if part.keyway_width else part.bore
    for name, diameter in ("hub", part.hub_diameter), ("edge", part.outer_diameter), ("bore", round_bore):
        if diameter:
            yield Layer(name, VISIBLE, circles=(Circle(diameter / 2),))
    if part.bore and part.keyway_width:
        yield Layer("bore", VISIBLE, (bore_with_keyway(part),))
    across = complex(left - beyond), complex(right + beyond)
    up = complex(0.0, low - beyond), complex(0.0, high + beyond)
    yield Layer("centre", CHAIN_LINE, lines=(across, up))
    yield Layer("timing", THIN_LINE, lines=((0j, up[1] + 1j * beyond),))


def _developed_cylinder_layers(work: Workpiece, corners: np.ndarray) -> Iterator[Layer]:
    """Layers of a cylindrical cam: one turn at the mean radius, with the lines of cam angle 0 and of zero lift.

    If its length is known, also the edges of the developed cylinder.
    """
    turn = 2.0 * np.pi * float(work.problem.design.size[0])
    low, high = corners.imag.min(), corners.imag.max()
    if work.part.thickness:
        low, high = centred_cylinder_ends(work.problem, work.part.thickness)
        foot, top = 1j * low, 1j * high
        sides = (foot, foot + turn), (foot + turn, top + turn), (top + turn, top), (top, foot)
        yield Layer("edges", VISIBLE, lines=sides)
    beyond = MARK_OVERRUN * turn
    middle = complex(0.0, (low + high) / 2)
    yield Layer("centre", CHAIN_LINE, lines=((middle, middle + turn),))
    yield Layer("zero", CHAIN_LINE, lines=((0j, complex(turn)),))
    yield Layer(
        "timing", THIN_LINE, lines=tuple((x + 1j * (low - beyond), x + 1j * (high + beyond)) for x in (0.0, turn))
    )


TRAIN_ANGLES_DEG = np.arange(361.0)
PIN_RADIUS, PIVOT_RADIUS, STEM_LENGTH, FACE_LENGTH = 0.02, 0.03, 0.3, 0.3
"""Radii of joints and pivots, length of a stem and half length of a flat face, in sizes of the cam."""


def train_layers(problem: Problem) -> Iterator[Layer]:
    """Layers of a follower and its train; none without a train."""
    mechanism, programme = problem.setup.mechanism, problem.programme
    if problem.setup.train is None:
        return
    radius = float(problem.design.roller_radius[0])
    tool = tool_position(programme, np.radians(TRAIN_ANGLES_DEG % 360.0))
    places = [int(np.abs(tool - each).argmin()) for each in (tool.min(), (tool.min() + tool.max()) / 2, tool.max())]
    angles = np.radians(TRAIN_ANGLES_DEG[places])
    travel, moved = (
        mechanism.trace_and_normal(problem.design, programme, angles),
        float(problem.design.size[0]) * angles,
    )
    if mechanism.body.developed:  # its surface moves past the follower
        traces, size, stem = travel.trace - moved, float(problem.design.size[0]), programme.lift + radius
        low, high = (1j * end for end in (traces.imag.min() - radius, traces.imag.max() + radius))
        marks = [(low - x, high - x) for x in moved.tolist()]
    else:
        traces, size, stem = travel.trace, float(np.abs(travel.trace).max()), 0.0
        marks = [(0j, 1j * size * complex(np.exp(1j * problem.design.sense * angle))) for angle in angles]
    carriers = (
        traces * 0.0 + follower_pivot(problem)
        if problem.setup.angular
        else traces + 1j * (stem + STEM_LENGTH * size)
    )
    sketch = linkage_sketch(problem, angles, complex(carriers[0]), size)
    assert sketch is not None
    pivots = [Circle(PIVOT_RADIUS * size, each.at) for each in sketch.supports if each.ground == "pivot"]
    guides = [(each.at - each.way, each.at + each.way) for each in sketch.supports if each.ground == "guide"]
    yield Layer("linkage-ground", THIN_LINE, circles=tuple(pivots), lines=tuple(guides))
    for k in range(len(places)):
        trace, face = complex(traces[k]), FACE_LENGTH * 1j * size * complex(travel.normal[k])
        circles, lines = [Circle(radius, trace)], [(complex(carriers[k]), trace)]
        if mechanism.flat_faced:
            circles, lines = [], [*lines, (trace - face, trace + face)]
        lines.append(marks[k])
        for member in sketch.members:
            round_parts, straight = _member_circles_and_lines(member, k, PIN_RADIUS * size)
            circles, lines = circles + round_parts, lines + straight
        circles = [each for each in circles if each.radius]
        yield Layer(
            f"linkage-{TRAIN_ANGLES_DEG[places[k]]:.0f}deg", THIN_LINE, circles=tuple(circles), lines=tuple(lines)
        )


def _member_circles_and_lines(
    member: Member, position_index: int, pin_radius: float
) -> tuple[list[Circle], list[tuple[complex, complex]]]:
    """A rigid part in one position: a wheel as circle, a bar as line between pins, others as outlines."""
    at = complex(member.at[position_index])
    points = [at + complex(each) for each in member.points * np.exp(1j * member.turned[position_index])]
    if member.shape in ("wheel", "roller"):
        return [Circle(float(abs(member.points[0])), at)], []
    if member.shape in ("bar", "belt"):
        pins = [Circle(pin_radius, each) for each in points if member.shape == "bar"]
        return pins, [(points[0], points[-1])]
    return [], list(zip(points, [*points[1:], points[0]], strict=True))

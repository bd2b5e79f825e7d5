"""The layout of follower and train: where their parts are with the tool lowest, halfway and highest.

Each position is a layer of its own, named by its cam angle, and so is what stands still. The cam of the plan is at
cam angle 0; a line from its centre, or along the axis of a cylinder that is developed, shows where its line of cam
angle 0 is then. Links are put one after the other (``problem.linkage``).
"""

from collections.abc import Iterator

import numpy as np

from camopt.exporting.layers import THIN_LINE, Circle, Layer
from camopt.motion.driven import tool_position
from camopt.problem.linkage import linkage_at, pivot_of
from camopt.problem.problem import Problem
from camopt.trains.sketch import Member

DEGREES = np.arange(361.0)
PIN, PIVOT, STEM, FACE = 0.02, 0.03, 0.3, 0.3
"""Radii of joints and pivots, the length of a stem and half that of a flat face, in sizes of the cam."""
Parts = tuple[list[Circle], list[tuple[complex, complex]]]


def layout_of(problem: Problem) -> Iterator[Layer]:
    """The layers of a follower and its train; none without a train."""
    mechanism, programme = problem.setup.mechanism, problem.programme
    if problem.setup.train is None:
        return
    radius = float(problem.design.roller_radius[0])
    tool = tool_position(programme, np.radians(DEGREES % 360.0))
    places = [int(np.abs(tool - each).argmin()) for each in (tool.min(), (tool.min() + tool.max()) / 2, tool.max())]
    angles = np.radians(DEGREES[places])
    travel, moved = mechanism.travel(problem.design, programme, angles), float(problem.design.size[0]) * angles
    if mechanism.body.developed:  # its surface moves past the follower
        traces, size, stem = travel.trace - moved, float(problem.design.size[0]), programme.lift + radius
        low, high = (1j * end for end in (traces.imag.min() - radius, traces.imag.max() + radius))
        marks = [(low - x, high - x) for x in moved.tolist()]
    else:
        traces, size, stem = travel.trace, float(np.abs(travel.trace).max()), 0.0
        marks = [(0j, 1j * size * complex(np.exp(1j * problem.design.sense * angle))) for angle in angles]
    carriers = traces * 0.0 + pivot_of(problem) if problem.setup.angular else traces + 1j * (stem + STEM * size)
    sketch = linkage_at(problem, angles, complex(carriers[0]), size)
    assert sketch is not None
    pivots = [Circle(PIVOT * size, each.at) for each in sketch.standing if each.ground == "pivot"]
    guides = [(each.at - each.way, each.at + each.way) for each in sketch.standing if each.ground == "guide"]
    yield Layer("linkage-ground", THIN_LINE, circles=tuple(pivots), lines=tuple(guides))
    for k in range(len(places)):
        trace, face = complex(traces[k]), FACE * 1j * size * complex(travel.normal[k])
        circles, lines = [Circle(radius, trace)], [(complex(carriers[k]), trace)]
        if mechanism.flat_faced:
            circles, lines = [], [*lines, (trace - face, trace + face)]
        lines.append(marks[k])
        for member in sketch.members:
            round_parts, straight = _parts(member, k, PIN * size)
            circles, lines = circles + round_parts, lines + straight
        circles = [each for each in circles if each.radius]
        yield Layer(f"linkage-{DEGREES[places[k]]:.0f}deg", THIN_LINE, circles=tuple(circles), lines=tuple(lines))


def _parts(member: Member, position: int, pin: float) -> Parts:
    """A rigid part in one position: a wheel as a circle, a bar as a line between pins, others by their edges."""
    at = complex(member.at[position])
    points = [at + complex(each) for each in member.points * np.exp(1j * member.turned[position])]
    if member.shape in ("wheel", "roller"):
        return [Circle(float(abs(member.points[0])), at)], []
    if member.shape in ("bar", "belt"):
        pins = [Circle(pin, each) for each in points if member.shape == "bar"]
        return pins, [(points[0], points[-1])]
    return [], list(zip(points, [*points[1:], points[0]], strict=True))

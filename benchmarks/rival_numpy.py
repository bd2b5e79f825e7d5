"""What an engineer would write in numpy: a roller follower's pressure angle and curvature, for many cams at once.

Closed forms of the laws, an array (designs, angles) for each stroke, and the largest sample. ``polished`` takes
few samples and then refines the best of each half of a stroke by parabolas, until it agrees with camopt to 1e-9;
``sampled`` takes many and stops there. Nothing of camopt is used, so that the two answers are independent.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Motion = tuple[Array, Array, Array]
Peak = tuple[Array, Array]

TILE = 1024  # designs at once, the best of those tried: fewer calls against samples that stay in the cache
STEPS = (1 / 4, 1 / 64)  # of a sample's spacing: the half widths of the parabolas, one after the other


def harmonic(x: Array) -> Motion:
    return (1 - np.cos(np.pi * x)) / 2, np.pi / 2 * np.sin(np.pi * x), np.pi**2 / 2 * np.cos(np.pi * x)


def cycloidal(x: Array) -> Motion:
    turn = 2 * np.pi * x
    return x - np.sin(turn) / (2 * np.pi), 1 - np.cos(turn), 2 * np.pi * np.sin(turn)


def poly345(x: Array) -> Motion:
    s = x**3 * (10 - 15 * x + 6 * x**2)
    return s, 30 * x**2 * (1 - x) ** 2, 60 * x * (1 - x) * (1 - 2 * x)


def poly4567(x: Array) -> Motion:
    s = x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3)
    return s, 140 * x**3 * (1 - x) ** 3, 420 * x**2 * (1 - x) ** 2 * (1 - 2 * x)


LAWS: dict[str, Callable[[Array], Motion]] = {
    "harmonic": harmonic,
    "cycloidal": cycloidal,
    "poly345": poly345,
    "poly4567": poly4567,
}


@dataclass(frozen=True)
class Stroke:
    """A rise (lift > 0) or return (lift < 0) over an angle (rad), from a height (mm)."""

    law: Callable[[Array], Motion]
    angle: float
    start: float
    lift: float

    def motion(self, x: Array) -> Motion:
        """y, y', y'' by cam angle, in mm."""
        s, v, a = self.law(x)
        return self.start + self.lift * s, self.lift / self.angle * v, self.lift / self.angle**2 * a


def turn_of(law: str) -> tuple[Stroke, ...]:
    """The 1000 rpm cam: 50 mm up in 120°, a dwell, down in 90°, a dwell. Each dwell is one constant sample."""
    verbs = LAWS[law]
    rise, fall = Stroke(verbs, np.radians(120), 0.0, 50.0), Stroke(verbs, np.radians(90), 50.0, -50.0)
    return rise, Stroke(verbs, 1.0, 50.0, 0.0), fall, Stroke(verbs, 1.0, 0.0, 0.0)


@dataclass(frozen=True)
class Cams:
    """Radial or offset roller cams; ``lead`` is the offset, positive where it eases the rise. Lengths in mm."""

    prime_radius: Array
    lead: Array

    def tile(self, first: int) -> "Cams":
        """The next few designs."""
        return Cams(self.prime_radius[first : first + TILE], self.lead[first : first + TILE])


def pressure(cams: Cams, motion: Motion) -> Array:
    """tan β, (designs, angles)."""
    y, y1, _ = motion
    height = np.sqrt(cams.prime_radius**2 - cams.lead**2)[:, None]
    return (y1 - cams.lead[:, None]) / (height + y)


def curvature(cams: Cams, motion: Motion) -> Array:
    """Curvature of the pitch curve, 1/mm, positive where convex, (designs, angles)."""
    y, y1, y2 = motion
    s = np.sqrt(cams.prime_radius**2 - cams.lead**2)[:, None] + y
    w = y1 - cams.lead[:, None]
    square = s**2 + w**2
    return (square + w * y1 - s * y2) / (square * np.sqrt(square))


Extremes = dict[str, Array]
QUESTIONS = {  # the answers of a stroke: a curve, and +1 for its largest or −1 for its least value
    "tangent_max": (pressure, 1.0),
    "tangent_min": (pressure, -1.0),
    "curvature_max": (curvature, 1.0),
    "curvature_min": (curvature, -1.0),
}


def sampled(cams: Cams, law: str, angles: int) -> Extremes:
    """The extremes over a turn of so many samples; never too large, and most often too small."""
    return _over_the_turn(cams, law, angles, refine=False)


def polished(cams: Cams, law: str, angles: int) -> Extremes:
    """The extremes over a turn, refined from the best sample of each half of a stroke."""
    return _over_the_turn(cams, law, angles, refine=True)


def _over_the_turn(cams: Cams, law: str, angles: int, refine: bool) -> Extremes:
    found = []
    for stroke in turn_of(law):
        count = round(angles * stroke.angle / (4 * np.pi)) + 1
        halves = (np.linspace(0.0, 0.5, count), np.linspace(0.5, 1.0, count)) if stroke.lift else (np.zeros(1),)
        found += [_over_samples(cams, stroke, x, refine) for x in halves]
    most = {name: np.max([each[name] for each in found], axis=0) for name in QUESTIONS}
    return {
        "pressure_angle_max_deg": np.degrees(np.arctan(np.maximum(most["tangent_max"], most["tangent_min"]))),
        "pitch_curvature_max_per_mm": most["curvature_max"],
        "pitch_curvature_min_per_mm": -most["curvature_min"],
    }


def _over_samples(cams: Cams, stroke: Stroke, x: Array, refine: bool) -> Extremes:
    """The answers of a half of a stroke, each with the sign that makes it a maximum."""
    motion = stroke.motion(x)
    tops: dict[str, list[Peak]] = {name: [] for name in QUESTIONS}
    for first in range(0, cams.prime_radius.size, TILE):
        some = cams.tile(first)
        curves = {curve: curve(some, motion) for curve in (pressure, curvature)}
        for name, (curve, sign) in QUESTIONS.items():
            tops[name].append(_peak(sign * curves[curve], x))
    found = {}
    for name, (curve, sign) in QUESTIONS.items():
        at, best = (np.concatenate(column) for column in zip(*tops[name], strict=True))
        found[name] = _refined(cams, stroke, curve, sign, x, at, best) if refine and x.size > 2 else best
    return found


def _peak(values: Array, x: Array) -> Peak:
    """Where the largest sample of each design suggests its maximum, and the sample's value."""
    node = values.argmax(axis=1)
    best = np.take_along_axis(values, node[:, None], axis=1)[:, 0]
    if x.size < 3:
        return x[node], best
    inner = np.clip(node, 1, x.size - 2)
    near = np.take_along_axis(values, inner[:, None] + np.array([-1, 0, 1]), axis=1)
    return np.where(node == inner, _vertex(x[inner], x[1] - x[0], near), x[node]), best


def _refined(
    cams: Cams,
    stroke: Stroke,
    curve: Callable[[Cams, Motion], Array],
    sign: float,
    x: Array,
    at: Array,
    best: Array,
) -> Array:
    """The largest value near a point, by finer and finer parabolas; never below the best sample."""
    step = x[1] - x[0]
    for share in STEPS:
        width = share * step
        at = np.clip(at, x[0] + width, x[-1] - width)
        near = sign * curve(cams, stroke.motion(at[:, None] + width * np.array([-1.0, 0.0, 1.0])))
        at = _vertex(at, width, near)
        best = np.maximum(best, near.max(axis=1))
    return np.maximum(best, sign * curve(cams, stroke.motion(at[:, None]))[:, 0])


def _vertex(middle: Array, step: float, near: Array) -> Array:
    """The vertex of a parabola through three points, no further than a step from the middle one."""
    left, here, right = near.T
    bend = left - 2 * here + right
    shift = np.divide(left - right, 2 * bend, out=np.zeros_like(bend), where=bend < 0)
    return middle + step * np.clip(shift, -1.0, 1.0)

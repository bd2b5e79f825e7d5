"""Global self-crossing: whether parts of the profile far apart along the turn cross, proved over the whole turn.

An undercut profile crosses itself where it is undercut. What is nowhere undercut crosses itself nowhere

- if the face is flat: the profile is convex, since its tangent turns one way, and once.
- if a knife edge draws it: two of its points at one distance from the centre are at one displacement, and so at one
  cam angle, since the distance grows with the displacement.
- if the profile's normal points away from the centre all along, P·n > 0: it then goes once round the centre, always
  forwards. So do nearly all cams.
- if no two parts of the turn meet (``effects.parts``). Two do not if their discs or strips are apart, or if the
  tangent turns by less than π from the one to the other, so that the profile goes one way. Pairs left are halved.

That two parts do meet is shown if the ends of each lie on opposite sides of the strip round the other (Poincaré and
Miranda: two functions, each of which changes sign across a square, have a common zero in it). Corners of the motion
need no care: their jumps of y' add up to nothing, so one of them is convex, and a round body undercuts it.
"""

from typing import Any, NamedTuple

import numpy as np

from camopt.effects import curvature
from camopt.effects.case import Case, Effect, Subject
from camopt.effects.parts import Cover, IntArray, cover, first_parts
from camopt.geometry import profile_points
from camopt.mechanisms.design import BoolArray, ComplexArray, Designs
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray

AT_ONCE = 256  # designs, so that memory stays bounded
HALVINGS = 24
MOST_PAIRS = 200_000


class Crossing(NamedTuple):
    """Whether a profile crosses itself, None if neither is proved.

    Where it does, ``at`` has the two cam angles in rad, to ± ``within``.
    """

    shown: bool | None
    at: tuple[float, ...] = ()
    within: float = 0.0


def offers(subject: Subject) -> tuple[str, ...]:
    return () if subject.mechanism.grooved else ("self_crossing",)


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    crossing, parts = _perhaps_undercut(case), first_parts(case.programme)
    if case.subject.mechanism.curvature is not None:
        for some in np.array_split(np.flatnonzero(~crossing), 1 + len(case.designs) // AT_ONCE):
            column = case.designs.take((some, None))
            for i in some[~_goes_round(cover(case.subject, column, case.programme, parts))]:
                found = find_crossing(case.subject, case.designs.take([i]), case.programme)
                crossing[i] = found.shown is not False
    return {"self_crossing": crossing}


def _perhaps_undercut(case: Case) -> BoolArray:
    """Which designs are undercut, or so near to it that the enclosure does not tell."""
    found = curvature.run(case, frozenset())
    radius = found["profile_radius_min_mm"]
    blunt = (case.designs.roller_radius > 0.0) | (case.subject.mechanism.curvature is None)
    return np.asarray(found["undercut"] | (blunt & (radius.value + radius.outward <= 0.0)))


def find_crossing(subject: Subject, design: Designs, programme: Programme) -> Crossing:
    """Whether the profile of one disc cam that is not undercut, with a trace point, crosses itself."""
    if design.roller_radius[0] == 0.0:
        return Crossing(False)
    parts = first_parts(programme)
    first, second = np.triu_indices(parts.middle.size)
    for _ in range(HALVINGS):
        found = cover(subject, design, programme, parts)
        left = ~(_one_way(found, first, second) | _apart(found.take(first), found.take(second)))
        first, second = first[left], second[left]
        if first.size == 0 or _goes_round(found):
            return Crossing(False)
        if first.size > MOST_PAIRS:
            break
        starts, ends = parts.middle - parts.half, parts.middle + parts.half
        tips = [profile_points(subject.mechanism, design, programme, angles) for angles in (starts, ends)]
        shown = np.flatnonzero(_across(found, tips, first, second) & _across(found, tips, second, first))
        if shown.size:
            pair = [first[shown[0]], second[shown[0]]]
            return Crossing(True, tuple(parts.middle[pair].tolist()), float(parts.half[pair].max()))
        into = np.ones(parts.middle.size, dtype=int)
        into[first] = into[second] = 2
        start = np.cumsum(into) - into
        parts, first, second = parts.split(into), *_halves(start[first], start[second])
    return Crossing(None)


def _halves(first: IntArray, second: IntArray) -> tuple[IntArray, IntArray]:
    """The pairs of halves of pairs of parts, from the first half of each; each pair once."""
    first, second = first + np.array([[0], [0], [1], [1]]), second + np.array([[0], [1], [0], [1]])
    once = first <= second
    return first[once], second[once]


def _goes_round(found: Cover) -> BoolArray:
    """Whether P·n > 0 over all parts: over one, P moves by its radius, at most 2δ from square to n."""
    outwards = (found.point.conj() * found.normal).real
    needed = (np.abs(found.point) + 2.0 * found.radius) * found.spread + found.rounding
    return np.asarray(np.all(outwards > needed, axis=-1))


def _one_way(found: Cover, first: IntArray, second: IntArray) -> BoolArray:
    """Whether the tangent turns by less than π from one part to the end of another, or from that on to the one."""
    turned = np.concatenate([[0.0], np.cumsum(2.0 * found.spread)])
    between = turned[second + 1] - turned[first]
    around = turned[-1] - turned[second] + turned[first + 1]
    return np.asarray(np.minimum(between, around) < np.pi)


def _apart(a: Cover, b: Cover) -> BoolArray:
    """Whether two parts are apart: their discs, or the one's strip along its tangent from the other."""
    gap, slant = b.point - a.point, np.abs(_cross(a.tangent, b.tangent))
    discs = np.abs(gap) > a.radius + b.radius
    along_a = np.abs(_cross(a.tangent, gap)) > a.bulge + b.bulge + b.radius * slant
    along_b = np.abs(_cross(b.tangent, gap)) > a.bulge + b.bulge + a.radius * slant
    return np.asarray(discs | along_a | along_b)


def _across(found: Cover, tips: list[ComplexArray], first: IntArray, second: IntArray) -> BoolArray:
    """Whether the ends of one part lie on opposite sides of the strip round another."""
    start, end = (_cross(found.tangent[second], tip[first] - found.point[second]) for tip in tips)
    far = np.minimum(np.abs(start), np.abs(end)) > found.bulge[second] + found.rounding[first]
    return np.asarray((start * end < 0.0) & far)


def _cross(a: ComplexArray, b: ComplexArray) -> FloatArray:
    return np.asarray((a.conj() * b).imag)


EFFECT = Effect("crossing", offers, run)

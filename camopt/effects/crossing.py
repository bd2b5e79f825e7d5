"""Global self-crossing: whether parts of the profile far apart along the turn cross, proved over the whole turn.

An undercut profile crosses itself where it is undercut. What is nowhere undercut crosses itself nowhere

- if the face is flat: the profile is convex, since its tangent turns one way, and once.
- if a knife edge draws it: two of its points at one distance from the centre are at one displacement, and so at one
  cam angle, since the distance grows with the displacement.
- if the profile's normal points away from the centre all along, P·n > 0: it then goes once round the centre, always
  forwards. So do nearly all cams, and of most the largest pressure angle tells.
- if no two parts of the turn meet (``effects.parts``). Two do not if their discs or strips are apart, or if the
  tangent turns by less than π from the one to the other, so that the profile goes one way. Pairs left are halved.

That two parts do meet is shown if the ends of each lie on opposite sides of the strip round the other (Poincaré and
Miranda: two functions, each of which changes sign across a square, have a common zero in it). Corners of the motion
need no care: their jumps of y' add up to nothing, so one of them is convex, and a round body undercuts it.
"""

from typing import Any, NamedTuple

import numpy as np

from camopt.effects.case import Bounded, Case, Effect, Subject
from camopt.effects.parts import ROUNDING, Cover, Ends, IntArray, cover, ends_of, first_parts
from camopt.mechanisms.design import BoolArray, ComplexArray, Designs
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.numerics.curves import curve

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


def reads(subject: Subject) -> tuple[str, ...]:
    if subject.pointed:
        return ()
    round_body = subject.mechanism.curvature is not None
    return ("undercut", "profile_radius_min_mm", *(("pressure_angle_max_deg",) if round_body else ()))


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    if case.subject.pointed:
        return {"self_crossing": False}
    trace_point = case.subject.mechanism.curvature is not None
    sharp = trace_point & (case.designs.roller_radius == 0.0)
    crossing = np.array(case.found["undercut"])
    undecided = ~crossing & ~sharp & (case.far("profile_radius_min_mm") <= 0.0)
    if trace_point:
        for i in _perhaps(case, np.flatnonzero(~(crossing | undecided | surely_round(case)))):
            shown = find_crossing(case.subject, case.designs.take([i]), case.programme).shown
            crossing[i], undecided[i] = shown is True, shown is None
    return {"self_crossing": Bounded(crossing | undecided, undecided.astype(float), np.inf)}


def surely_round(case: Case) -> BoolArray:
    """For which designs the largest pressure angle shows that P·n > 0.

    Seen from the direction in which the trace point T moves, the normal is at the pressure angle β, and T is at the
    angle β₀ that β would be with y' = 0: P·n = |T|·cos(β − β₀) − R_r. With the largest |β|, |T|·cos(|β| + |β₀|) is
    linear in y (translating) or a sine less a constant (oscillating): least at an end of the lift. And |T| ≥ R_p.
    """
    designs, strokes = case.designs, case.programme.strokes
    levels = [y for stroke in strokes for y in (stroke.low, stroke.high)]
    record = case.subject.mechanism.pressure(designs, case.programme)
    standing = [np.abs(curve(record, ..., y, 0.0, 0.0, 0.0)[0]) for y in (min(levels), max(levels))]
    slant = np.radians(case.far("pressure_angle_max_deg")) + np.arctan(np.maximum(*standing))
    share = np.cos(np.minimum(slant, np.pi / 2)) - ROUNDING
    return np.asarray(designs.prime_radius * share > designs.roller_radius)


def _perhaps(case: Case, index: IntArray) -> IntArray:
    """Those of some designs, none of them undercut, whose normal does not point away from the centre all along."""
    parts, left = first_parts(case.programme), [index[:0]]
    for some in np.array_split(index, 1 + index.size // AT_ONCE) if index.size else ():
        column = case.designs.take((some, None))
        left.append(some[~_goes_round(cover(case.subject, column, case.programme, parts))])
    return np.concatenate(left)


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
        ends = ends_of(subject, design, programme, parts)
        one, other = ([tip[index] for tip in ends] for index in (first, second))
        shown = np.flatnonzero(meet(found.take(first), found.take(second), one, other))
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
    gap, slant = b.point - a.point, np.abs(cross(a.tangent, b.tangent))
    discs = np.abs(gap) > a.radius + b.radius
    along_a = np.abs(cross(a.tangent, gap)) > a.bulge + b.bulge + b.radius * slant
    along_b = np.abs(cross(b.tangent, gap)) > a.bulge + b.bulge + a.radius * slant
    return np.asarray(discs | along_a | along_b)


def meet(found: Cover, other: Cover, ends: Ends, other_ends: Ends, moved: FloatArray | float = 0.0) -> BoolArray:
    """Whether parts surely meet others, though the points of both may move, by so much (mm) in all."""
    return _across(ends, found, other, moved) & _across(other_ends, other, found, moved)


def _across(ends: Ends, found: Cover, other: Cover, moved: FloatArray | float) -> BoolArray:
    """Whether the ends of a part lie on opposite sides of the strip round another, wherever both may move to."""
    start, end = (cross(other.tangent, tip - other.point) for tip in ends)
    far = np.minimum(np.abs(start), np.abs(end)) > other.bulge + found.rounding + moved
    return np.asarray((start * end < 0.0) & far)


def cross(a: ComplexArray, b: ComplexArray) -> FloatArray:
    return np.asarray((a.conj() * b).imag)


EFFECT = Effect("crossing", offers, run, reads=reads, last=True)

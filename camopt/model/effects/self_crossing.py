"""Global self-crossing: a proof over the whole turn that distant parts of the profile cross, or that none do.

An undercut profile crosses itself where it is undercut. What is nowhere undercut crosses itself nowhere

- if the face is flat: the profile is convex, since its tangent turns one way, and once.
- if a knife edge draws it: two of its points at one distance from the centre are at one displacement, and so at one
  cam angle, since the distance grows with the displacement.
- if the profile's normal points away from the centre all along, P·n > 0: it then goes once round the centre, always
  forwards. So do nearly all cams, and of most the largest pressure angle tells.
- if no two parts of the turn meet (``effects.profile_parts``). Two do not if their discs or strips are apart, or if
  the tangent turns by less than π from the one to the other, so that the profile goes one way. Pairs left are
  halved.

That two parts do meet is shown if the ends of each lie on opposite sides of the strip round the other (Poincaré and
Miranda: two functions, each of which changes sign across a square, have a common zero in it). A groove has two
walls: if the normal of the inner one points away from the centre, so does that of the outer one. Walls of a groove
do not cross each other unless one of them crosses itself: the shortest line from the pitch curve to itself that is
square to it at both ends runs on one side of it. Corners of the motion
need no care: their jumps of y' add up to nothing, so one of them is convex, and a round body undercuts it.
"""

from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import BoolArray, ComplexArray, FloatArray, IntArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.state import State
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup
from camopt.model.effects.profile_parts import (
    PART_ERROR,
    PartEnds,
    ProfileEnclosure,
    TurnParts,
    enclose_profile,
    initial_parts,
    part_ends,
)
from camopt.model.mechanisms.design import Designs
from camopt.model.mechanisms.elements import INNER_SIDE
from camopt.model.motion.programme import Programme

CROSSING_BLOCK, PAIR_BLOCK = 256, 16  # designs, so that memory stays bounded
PART_CUTS, CUT_ROUNDS = 4, 12  # a part is cut into four, at most so often
MOST_PART_PAIRS = 200_000
CROSSING_RANKS = (False, None, True)  # of a crossing of a wall: what tells of all walls comes last


class ProfileCrossing(NamedTuple):
    """Whether a profile crosses itself, or a wall of a groove, None if neither is proved.

    Where one does, ``at`` has the two cam angles in rad, to ± ``within``.
    """

    crosses: bool | None
    angles: tuple[float, ...] = ()
    within: float = 0.0
    side: float = INNER_SIDE
    """Of the trace point, on which the wall is that does."""


def offers(setup: Setup) -> tuple[str, ...]:
    return ("self_crossing",) if setup.mechanism.body.closed else ()


def reads(setup: Setup) -> tuple[str, ...]:
    if setup.is_knife:
        return ()
    round_body = not setup.mechanism.flat_faced
    return ("undercut", "profile_radius_min_mm", *(("pressure_angle_max_deg",) if round_body else ()))


def run(case: EvaluationBlock, wanted: frozenset[str]) -> dict[str, Any]:
    if case.setup.is_knife:
        return {"self_crossing": False}
    trace_point = not case.setup.mechanism.flat_faced
    sharp = trace_point & (case.designs.roller_radius == 0.0)
    crossing = np.array(case.columns["undercut"])
    undecided = ~crossing & ~sharp & (case.outer_bound("profile_radius_min_mm") <= 0.0)
    if trace_point:
        left = _unproved_designs(case, np.flatnonzero(~(crossing | undecided | is_provably_round(case))))
        found = find_crossings(case.setup, case.designs.take(left), case.programme) if left.size else []
        for design, each in zip(left, found, strict=True):
            crossing[design], undecided[design] = each.crosses is True, each.crosses is None
    return {"self_crossing": EnclosedValue(crossing | undecided, undecided.astype(float), np.inf)}


def is_provably_round(case: EvaluationBlock) -> BoolArray:
    """For which designs the largest pressure angle shows that P·n > 0."""
    return np.asarray(round_radius_limit(case) > case.setup.half_width(case.designs))


def round_radius_limit(case: EvaluationBlock) -> Any:
    """Below which R_r the largest pressure angle shows that P·n > 0; the same for all designs of a pitch curve.

    Of designs that are ranges of sizes, a range.

    Seen from the direction in which the trace point T moves, the normal is at the pressure angle β, and T is at the
    angle β₀ that β would be with y' = 0: P·n = |T|·cos(β − β₀) − R_r. With the largest |β|, |T|·cos(|β| + |β₀|) is
    linear in y (translating) or a sine less a constant (oscillating): least at an end of the lift. And |T| ≥ R_p.
    """
    designs = case.designs
    record = case.setup.mechanism.pressure(designs, case.programme)
    with np.errstate(divide="ignore", invalid="ignore"):  # arm and centres in line: no angle shows anything
        standing = [np.abs(value_of(record, ..., State(y, 0.0, 0.0, 0.0))) for y in case.programme.levels]
    slant = np.radians(case.outer_bound("pressure_angle_max_deg")) + np.arctan(np.maximum(*standing))
    share = np.cos(np.minimum(slant, np.pi / 2)) - PART_ERROR
    return designs.prime_radius * share


def _unproved_designs(case: EvaluationBlock, index: IntArray) -> IntArray:
    """The designs, of some without undercut, whose normal does not point away from the centre everywhere."""
    if not index.size:
        return index
    programme = case.setup.mechanism.contact_programme(case.programme)
    parts, left = initial_parts(programme), []
    for some in np.array_split(index, 1 + index.size // CROSSING_BLOCK):
        column = case.designs.take((some, None))
        left.append(some[~np.all(_faces_outward(enclose_profile(case.setup, column, programme, parts)), axis=-1)])
    return np.concatenate(left)


def find_crossing(setup: Setup, design: Designs, programme: Programme) -> ProfileCrossing:
    """Whether a wall of one disc cam that is not undercut, with a trace point, crosses itself."""
    return find_crossings(setup, design, programme)[0]


def find_crossings(setup: Setup, designs: Designs, programme: Programme) -> list[ProfileCrossing]:
    """Of each of some disc cams that are not undercut, with a trace point, whether a wall of it crosses itself."""
    sides = dict.fromkeys(flank.side for flank in setup.mechanism.flanks)
    walls = [find_wall_crossings(setup, designs, programme, side) for side in sides]
    return [max(each, key=lambda one: CROSSING_RANKS.index(one.crosses)) for each in zip(*walls, strict=True)]


def find_wall_crossings(setup: Setup, designs: Designs, programme: Programme, side: float) -> list[ProfileCrossing]:
    """The same of the wall on one side of the trace point, if that is not undercut."""
    programme = setup.mechanism.contact_programme(programme)
    found = [ProfileCrossing(None if radius > 0.0 else False) for radius in designs.roller_radius]
    rounded = np.flatnonzero(designs.roller_radius > 0.0)
    for some in np.array_split(rounded, 1 + rounded.size // PAIR_BLOCK) if rounded.size else ():
        pairs = PartPairs.all_pairs(some, initial_parts(programme))
        for _ in range(CUT_ROUNDS):
            pairs = pairs.undecided_pairs(setup, designs, programme, found, side).split()
            if not pairs.first.size:
                break
    return found


class PartPairs(NamedTuple):
    """Parts of the profiles of designs, and the pairs of parts that are still undecided."""

    parts: TurnParts
    owner: IntArray
    """The design of each part."""
    first: IntArray
    """Of each pair the part that comes first, and then the other."""
    second: IntArray

    @classmethod
    def all_pairs(cls, designs: IntArray, parts: TurnParts) -> "PartPairs":
        """All pairs of parts of the turn, of each design."""
        count = parts.middle.size
        starts = np.repeat(count * np.arange(designs.size), count * (count + 1) // 2)
        first, second = (starts + np.tile(index, designs.size) for index in np.triu_indices(count))
        tiled = TurnParts(*(np.tile(x, designs.size) for x in parts))
        return cls(tiled, np.repeat(designs, count), first, second)

    def undecided_pairs(
        self, setup: Setup, designs: Designs, programme: Programme, found: list[ProfileCrossing], side: float
    ) -> "PartPairs":
        """The pairs that may meet, of undecided designs; ``found`` takes the verdicts of the others."""
        each = designs.take(self.owner)
        covered = enclose_profile(setup, each, programme, self.parts, side)
        pairs = self.select_pairs(~_turns_one_way(covered, self.owner, self.first, self.second))
        pairs = pairs.select_pairs(~_discs_disjoint(covered, pairs.first, pairs.second))
        pairs = pairs.select_pairs(~_strips_disjoint(covered.take(pairs.first), covered.take(pairs.second)))
        met = _parts_meet(covered, part_ends(setup, each, programme, self.parts, side), pairs.first, pairs.second)
        for pair in np.flatnonzero(met)[::-1]:
            both = [pairs.first[pair], pairs.second[pair]]
            within = float(self.parts.half[both].max())
            found[self.owner[both[0]]] = ProfileCrossing(
                True, tuple(self.parts.middle[both].tolist()), within, side
            )
        count = np.bincount(self.owner[pairs.first], minlength=len(designs))
        done = (count == 0) | _encircles_axis(covered, self.owner, len(designs))
        for i in np.unique(self.owner[done[self.owner]]):
            found[i] = ProfileCrossing(False)
        left = ~done & (count <= MOST_PART_PAIRS) & [each.crosses is None for each in found]
        return pairs.select_pairs(left[self.owner[pairs.first]])

    def select_pairs(self, kept: BoolArray) -> "PartPairs":
        """Some of the pairs."""
        return self._replace(first=self.first[kept], second=self.second[kept])

    def split(self) -> "PartPairs":
        """The pairs after each part is cut; designs without pairs drop out."""
        into = np.zeros(self.owner.size, dtype=int)
        into[np.isin(self.owner, self.owner[self.first])] = 1
        into[self.first] = into[self.second] = PART_CUTS
        start = np.cumsum(into) - into
        one, other = (part.ravel()[:, None] for part in np.indices((PART_CUTS, PART_CUTS)))
        first, second = start[self.first] + one, start[self.second] + other
        once = first <= second  # of a part with itself
        return PartPairs(self.parts.split(into), np.repeat(self.owner, into), first[once], second[once])


def _faces_outward(found: ProfileEnclosure) -> BoolArray:
    """The parts over which P·n > 0: within a part, P moves by its radius, at most 2δ from square to n."""
    outwards = (found.point.conj() * found.normal).real
    needed = (np.abs(found.point) + 2.0 * found.radius) * found.spread + found.rounding
    return np.asarray(outwards > needed)


def _encircles_axis(found: ProfileEnclosure, owner: IntArray, count: int) -> BoolArray:
    """The designs with P·n > 0 over all parts."""
    return np.asarray(np.bincount(owner[~_faces_outward(found)], minlength=count) == 0)


def _turns_one_way(found: ProfileEnclosure, owner: IntArray, first: IntArray, second: IntArray) -> BoolArray:
    """Whether the tangent turns by less than π from one part to the end of the other, either way round."""
    turned = np.concatenate([[0.0], np.cumsum(2.0 * found.spread)])
    between = turned[second + 1] - turned[first]
    around = np.bincount(owner, 2.0 * found.spread)[owner[first]] - turned[second] + turned[first + 1]
    return np.asarray(np.minimum(between, around) < np.pi)


def _discs_disjoint(found: ProfileEnclosure, first: IntArray, second: IntArray) -> BoolArray:
    gap = np.abs(found.point[second] - found.point[first])
    return np.asarray(gap > found.radius[first] + found.radius[second])


def _strips_disjoint(a: ProfileEnclosure, b: ProfileEnclosure) -> BoolArray:
    """Whether the strip of one part along its tangent is apart from the other."""
    gap, slant = b.point - a.point, np.abs(cross_product(a.tangent, b.tangent))
    along_a = np.abs(cross_product(a.tangent, gap)) > a.bulge + b.bulge + b.radius * slant
    along_b = np.abs(cross_product(b.tangent, gap)) > a.bulge + b.bulge + a.radius * slant
    return np.asarray(along_a | along_b)


def _parts_meet(found: ProfileEnclosure, ends: PartEnds, first: IntArray, second: IntArray) -> BoolArray:
    """The pairs of parts that surely meet."""
    one, other = ((found.take(index), [tip[index] for tip in ends]) for index in (first, second))
    beyond = straddle_distance(*one, other[0]) - other[0].bulge, straddle_distance(*other, one[0]) - one[0].bulge
    return np.asarray(np.minimum(*beyond) > 0.0)


def straddle_distance(found: ProfileEnclosure, ends: PartEnds, other: ProfileEnclosure) -> FloatArray:
    """Distance of the ends of parts, on opposite sides, from the tangents of others, mm; −∞ if on one side."""
    start, end = (cross_product(other.tangent, tip - other.point) for tip in ends)
    far = np.minimum(np.abs(start), np.abs(end)) - found.rounding
    return np.where(start * end < 0.0, far, -np.inf)


def cross_product(a: ComplexArray, b: ComplexArray) -> FloatArray:
    return np.asarray((a.conj() * b).imag)


EFFECT = Effect("crossing", offers, run, reads=reads, last=True, is_per_contact=True)

"""Global self-crossing: a proof over the whole turn that distant parts of the profile cross, or that none do.

An undercut profile crosses itself where it is undercut. A profile that is nowhere undercut does not cross itself

- if the face is flat: the tangent turns in one direction, and once, so the profile is convex.
- if a knife edge draws it: the distance from the centre grows with the displacement. So two points at one distance
  have one displacement, and one cam angle.
- if the profile's normal points away from the centre everywhere, P·n > 0: the profile then goes once round the
  centre, always forwards. Nearly all cams do; for most of them the largest pressure angle proves it.
- if no two parts of the turn meet (``effects.profile_parts``). Two parts do not meet if their discs or strips are
  disjoint. Nor do they if the tangent turns by less than π from one to the other, so that the profile goes in one
  direction. Undecided pairs are cut into smaller ones.

Two parts do meet if the ends of each are on opposite sides of the strip round the other (Poincaré and Miranda: two
functions, each of which changes its sign across a square, have a common zero in it).

A groove has two walls. If the normal of the inner wall points away from the centre, so does that of the outer wall.
The walls of a groove do not cross each other unless one of them crosses itself: the shortest line from the pitch
curve to itself that is square to it at both ends runs on one side of it.

Corners of the motion need no further check. Their jumps of y' add up to 0, so at least one corner is convex, and a
round body undercuts it.
"""

from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import BoolArray, ComplexArray, FloatArray, IntArray, Number
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.state import State
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup
from camopt.model.effects.profile_parts import (
    PART_ERROR,
    ProfileEnclosure,
    TurnParts,
    enclose_profile,
    initial_turn_parts,
    wall_points,
)
from camopt.model.mechanisms.design import Designs
from camopt.model.mechanisms.elements import INNER_SIDE
from camopt.model.motion.programme import Programme

CROSSING_BLOCK, PAIR_BLOCK = 256, 16  # designs computed together, so that memory is bounded
PART_CUTS, CUT_ROUNDS = 4, 12  # a part is cut into so many, at most so often
MOST_PART_PAIRS = 200_000
CROSSING_RANKS = (False, None, True)  # verdicts on a wall; the last one among all walls is that of the cam


class ProfileCrossing(NamedTuple):
    """Whether a profile, or a wall of a groove, crosses itself; None if neither is proved.

    If it does, ``angles`` has the two cam angles [rad], to ± ``within``.
    """

    crosses: bool | None
    angles: tuple[float, ...] = ()
    within: float = 0.0
    side: float = INNER_SIDE
    """The side of the trace point on which the crossing wall is."""


def input_quantities(setup: Setup) -> tuple[str, ...]:
    if setup.is_knife:
        return ()
    round_body = not setup.mechanism.flat_faced
    return ("undercut", "profile_radius_min_mm", *(("pressure_angle_max_deg",) if round_body else ()))


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    if case.setup.is_knife:
        return {"self_crossing": False}
    trace_point = not case.setup.mechanism.flat_faced
    sharp = trace_point & (case.designs.roller_radius == 0.0)
    crossing = np.array(case.columns["undercut"])
    undecided = ~crossing & ~sharp & (case.outer_end_of_column_enclosure("profile_radius_min_mm") <= 0.0)
    if trace_point:
        unproved = _designs_without_proved_outward_normals(
            case, np.flatnonzero(~(crossing | undecided | pressure_angle_proves_no_crossing(case)))
        )
        verdicts = (
            self_crossing_verdicts(case.setup, case.designs.take(unproved), case.programme) if unproved.size else []
        )
        for design, verdict in zip(unproved, verdicts, strict=True):
            crossing[design], undecided[design] = verdict.crosses is True, verdict.crosses is None
    return {"self_crossing": EnclosedValue(crossing | undecided, undecided.astype(float), np.inf)}


def pressure_angle_proves_no_crossing(case: EvaluationBlock) -> BoolArray:
    """Mask of designs whose largest pressure angle proves that the profile does not cross itself (P·n > 0)."""
    return np.asarray(proved_uncrossed_roller_radius(case) > case.setup.pitch_to_flank_distance(case.designs))


def proved_uncrossed_roller_radius(case: EvaluationBlock) -> Number:
    """R_r below which the largest pressure angle proves P·n > 0 [mm]; the same for all designs of a pitch curve.

    For ranges of sizes it is a range.

    Measured from the direction in which the trace point T moves, the normal is at the pressure angle β, and T at
    the angle β₀ that β would have with y' = 0: P·n = |T|·cos(β − β₀) − R_r. With the largest |β|, |T|·cos(|β| +
    |β₀|) is linear in y (translating) or a sine minus a constant (oscillating), and so least at an end of the lift.
    And |T| ≥ R_p.
    """
    designs = case.designs
    curve = case.setup.mechanism.pressure(designs, case.programme)
    with np.errstate(divide="ignore", invalid="ignore"):  # with arm and centres in line, no angle proves anything
        standing = [
            np.abs(curve_value(curve, ..., State(y, 0.0, 0.0, 0.0)))
            for y in case.programme.lowest_and_highest_displacement
        ]
    slant = np.radians(case.outer_end_of_column_enclosure("pressure_angle_max_deg")) + np.arctan(
        np.maximum(*standing)
    )
    share = np.cos(np.minimum(slant, np.pi / 2)) - PART_ERROR
    return designs.prime_radius * share


def _designs_without_proved_outward_normals(case: EvaluationBlock, index: IntArray) -> IntArray:
    """The designs among some without undercut for which P·n > 0 is not proved everywhere."""
    if not index.size:
        return index
    programme = case.setup.mechanism.contact_programme(case.programme)
    parts, unproved = initial_turn_parts(programme), []
    for block in np.array_split(index, 1 + index.size // CROSSING_BLOCK):
        column = case.designs.take((block, None))
        outward = np.all(_normals_point_outward(enclose_profile(case.setup, column, programme, parts)), axis=-1)
        unproved.append(block[~outward])
    return np.concatenate(unproved)


def self_crossing_verdict(setup: Setup, design: Designs, programme: Programme) -> ProfileCrossing:
    """The verdict on one disc cam with a trace point and without undercut."""
    return self_crossing_verdicts(setup, design, programme)[0]


def self_crossing_verdicts(setup: Setup, designs: Designs, programme: Programme) -> list[ProfileCrossing]:
    """The verdicts on disc cams with a trace point and without undercut; the worst of all walls counts."""
    sides = dict.fromkeys(flank.side for flank in setup.mechanism.flanks)
    walls = [wall_crossing_verdicts(setup, designs, programme, side) for side in sides]
    return [
        max(verdicts, key=lambda verdict: CROSSING_RANKS.index(verdict.crosses))
        for verdicts in zip(*walls, strict=True)
    ]


def wall_crossing_verdicts(
    setup: Setup, designs: Designs, programme: Programme, wall_side: float
) -> list[ProfileCrossing]:
    """The verdicts on the walls on one side of the trace point, which are not undercut."""
    programme = setup.mechanism.contact_programme(programme)
    verdicts = [ProfileCrossing(None if radius > 0.0 else False) for radius in designs.roller_radius]
    rounded = np.flatnonzero(designs.roller_radius > 0.0)
    for block in np.array_split(rounded, 1 + rounded.size // PAIR_BLOCK) if rounded.size else ():
        pairs = PartPairs.all_pairs(block, initial_turn_parts(programme))
        for _ in range(CUT_ROUNDS):
            pairs = pairs.decide_designs_and_keep_open_pairs(setup, designs, programme, verdicts, wall_side).split()
            if not pairs.first.size:
                break
    return verdicts


class PartPairs(NamedTuple):
    """Parts of the profiles of designs, and the pairs of parts that are still undecided."""

    parts: TurnParts
    owner: IntArray
    """The design of each part."""
    first: IntArray
    """The earlier part of each pair."""
    second: IntArray
    """The later part of each pair."""

    @classmethod
    def all_pairs(cls, designs: IntArray, parts: TurnParts) -> "PartPairs":
        """All pairs of parts of the turn, of each design."""
        count = parts.middle.size
        starts = np.repeat(count * np.arange(designs.size), count * (count + 1) // 2)
        first, second = (starts + np.tile(index, designs.size) for index in np.triu_indices(count))
        return cls(TurnParts(*(np.tile(x, designs.size) for x in parts)), np.repeat(designs, count), first, second)

    def decide_designs_and_keep_open_pairs(
        self, setup: Setup, designs: Designs, programme: Programme, verdicts: list[ProfileCrossing], side: float
    ) -> "PartPairs":
        """The pairs of undecided designs that may meet; sets the ``verdicts`` on decided designs."""
        owners = designs.take(self.owner)
        enclosures = enclose_profile(setup, owners, programme, self.parts, side)
        pairs = self.select_pairs(~_tangent_turns_below_half_turn(enclosures, self.owner, self.first, self.second))
        gap = np.abs(enclosures.point[pairs.second] - enclosures.point[pairs.first])
        pairs = pairs.select_pairs(~(gap > enclosures.radius[pairs.first] + enclosures.radius[pairs.second]))
        pairs = pairs.select_pairs(~_strips_disjoint(enclosures.take(pairs.first), enclosures.take(pairs.second)))
        end_angles = np.stack([self.parts.middle - self.parts.half, self.parts.middle + self.parts.half])
        ends = wall_points(setup, owners, programme, end_angles, side)
        for pair in np.flatnonzero(_parts_surely_meet(enclosures, ends, pairs.first, pairs.second))[::-1]:
            both = [pairs.first[pair], pairs.second[pair]]
            within = float(self.parts.half[both].max())
            verdicts[self.owner[both[0]]] = ProfileCrossing(
                True, tuple(self.parts.middle[both].tolist()), within, side
            )
        count = np.bincount(self.owner[pairs.first], minlength=len(designs))
        inward_parts = np.bincount(self.owner[~_normals_point_outward(enclosures)], minlength=len(designs))
        done = (count == 0) | (inward_parts == 0)
        for i in np.unique(self.owner[done[self.owner]]):
            verdicts[i] = ProfileCrossing(False)
        undecided = ~done & (count <= MOST_PART_PAIRS) & [verdict.crosses is None for verdict in verdicts]
        return pairs.select_pairs(undecided[self.owner[pairs.first]])

    def select_pairs(self, pair_mask: BoolArray) -> "PartPairs":
        """The pairs of a mask."""
        return self._replace(first=self.first[pair_mask], second=self.second[pair_mask])

    def split(self) -> "PartPairs":
        """The pairs after each part is cut; designs without pairs are left out."""
        into = np.zeros(self.owner.size, dtype=int)
        into[np.isin(self.owner, self.owner[self.first])] = 1
        into[self.first] = into[self.second] = PART_CUTS
        start = np.cumsum(into) - into
        one, other = (part.ravel()[:, None] for part in np.indices((PART_CUTS, PART_CUTS)))
        first, second = start[self.first] + one, start[self.second] + other
        once = first <= second  # a pair of a part with itself gives each new pair only once
        return PartPairs(self.parts.split(into), np.repeat(self.owner, into), first[once], second[once])


def _normals_point_outward(parts: ProfileEnclosure) -> BoolArray:
    """The parts over which P·n > 0: within a part, P moves by its radius, at most 2δ from square to n."""
    outwards = (parts.point.conj() * parts.normal).real
    return np.asarray(outwards > ((np.abs(parts.point) + 2.0 * parts.radius) * parts.spread + parts.rounding))


def _tangent_turns_below_half_turn(
    parts: ProfileEnclosure, design_of_part: IntArray, first_part: IntArray, second_part: IntArray
) -> BoolArray:
    """Whether the tangent turns by less than π from one part to the end of the other, either way round."""
    turn = np.concatenate([[0.0], np.cumsum(2.0 * parts.spread)])
    between = turn[second_part + 1] - turn[first_part]
    around = (
        np.bincount(design_of_part, 2.0 * parts.spread)[design_of_part[first_part]]
        - turn[second_part]
        + turn[first_part + 1]
    )
    return np.asarray(np.minimum(between, around) < np.pi)


def _strips_disjoint(a: ProfileEnclosure, b: ProfileEnclosure) -> BoolArray:
    """Whether the strip of one part along its tangent is disjoint from the other part."""
    gap, slant = b.point - a.point, np.abs(cross_product(a.tangent, b.tangent))
    along_a = np.abs(cross_product(a.tangent, gap)) > a.bulge + b.bulge + b.radius * slant
    along_b = np.abs(cross_product(b.tangent, gap)) > a.bulge + b.bulge + a.radius * slant
    return np.asarray(along_a | along_b)


def _parts_surely_meet(
    parts: ProfileEnclosure, ends: ComplexArray, first_part: IntArray, second_part: IntArray
) -> BoolArray:
    """The pairs of parts that surely meet; ``ends`` are the points at which parts start and end (2, parts)."""
    one, other = ((parts.take(index), ends[:, index]) for index in (first_part, second_part))
    beyond = straddle_distance(*one, other[0]) - other[0].bulge, straddle_distance(*other, one[0]) - one[0].bulge
    return np.asarray(np.minimum(*beyond) > 0.0)


def straddle_distance(parts: ProfileEnclosure, ends: ComplexArray, other_parts: ProfileEnclosure) -> FloatArray:
    """Distance of the ends of parts, on opposite sides, from the tangents of others [mm]; −∞ if on one side."""
    start, end = (cross_product(other_parts.tangent, tip - other_parts.point) for tip in ends)
    far = np.minimum(np.abs(start), np.abs(end)) - parts.rounding
    return np.where(start * end < 0.0, far, -np.inf)


def cross_product(a: ComplexArray, b: ComplexArray) -> FloatArray:
    return np.asarray((a.conj() * b).imag)


EFFECT = Effect(
    "crossing",
    lambda setup: ("self_crossing",) if setup.mechanism.body.closed else (),
    evaluate_columns,
    input_quantities=input_quantities,
    last=True,
    is_per_contact=True,
)

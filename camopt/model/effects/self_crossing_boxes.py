"""Boxes of designs that all cross themselves, and designs that cross near known cam angles.

A cam that is not undercut has the profile P = C − R_r·n. It crosses itself if the roller at some cam angle b, with
its centre C(b) on the pitch curve, cuts into the profile at another cam angle a: |P(a) − C(b)| < R_r. Proof: assume
that it does not cross itself.

- C does not meet itself: two points of it at one distance from the centre have one displacement, and so one cam
  angle. P' has the direction of C', so both curves turn once, forwards. Each winds once round the points inside it,
  and not round others: w = 1 or 0.
- F(a, r) = P(a) + r·n(a), with r from 0 to R_r, folds nowhere, since ∂F/∂a, between P'(a) and C'(a), keeps their
  direction. So F covers a point q as often as its border winds round q: w(C, q) − w(P, q) times. This is 1 between
  the two curves, and 0 elsewhere.
- Let P(a) be the nearest point of the profile to C(b); then C(b) = P(a) ± d·n(a). If d < R_r, either F covers the
  points near C(b) twice, from (a, d) and from (b, R_r), or C(b) is on the profile or inside, where F covers
  nothing. Both contradict the step before.

Conversely, where one part of a profile crosses another at P(a) = P(b), it enters the roller at b, since
|P(a) − C(b)|² changes with a at the rate −2·R_r·n(b)·P'(a), which is not 0.

The same holds for the outer wall of a groove, C + R_r·n, with −R_r in place of R_r and inside and outside
exchanged. With a clearance j the walls are R_r + j/2 away, as those of a roller of that radius.

With Δ = C(a) − C(b) the condition is 2·R_r·Δ·n(a) − |Δ|² > 0, one inequality for each pair of cam angles. Ranges
with slopes (``numerics.sloped_interval``) bound it over a box. The pair of largest overlap changes little from box
to box, and Newton's method finds it from known pairs.

Source for winding and turning numbers: M. P. do Carmo, Differential Geometry of Curves and Surfaces, ch. 5-7.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy

from camopt.core.numerics import INPUT_ROUNDOFF, BoolArray, FloatArray, Number
from camopt.core.numerics.interval import Interval, as_interval, widen
from camopt.core.numerics.sloped_interval import SlopedInterval, apply_chain_rule, box_variables
from camopt.model.effects.effect import Setup
from camopt.model.effects.profile_parts import (
    designs_with_wall_as_profile,
    displacement_and_velocity_at,
    start_height_or_arm_angle,
    trace_point_and_velocity,
)
from camopt.model.effects.self_crossing import self_crossing_verdict
from camopt.model.mechanisms.design import Designs
from camopt.model.mechanisms.elements import INNER_SIDE
from camopt.model.motion.programme import Programme

MOST_KNOWN_CROSSINGS = 4
NEWTON_OFFSETS = 1e-3, 3e-4, 1e-4, 1e-4, 1e-4  # rad: distances of the values for Newton's steps
NEWTON_STENCIL = np.array([(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1)])
LARGEST_ANGLE_STEP = np.pi / 45  # rad: largest change in one step
STEP_SHARES = np.array([0.0, 0.0625, 0.25, 1.0])  # shares of a step that are tried
HEIGHT_ERROR = 16.0 * INPUT_ROUNDOFF  # relative rounding error of the height or angle at displacement 0
SIZE_AXIS = "size"


class KnownCrossings:
    """Known pairs of cam angles at which profiles of a programme cross."""

    def __init__(self, setup: Setup, programme: Programme) -> None:
        self._setup, self._programme = setup, programme
        self._known: list[tuple[FloatArray, float]] = []
        """Pairs of cam angles [rad], each with the side of the wall; the latest first."""

    def crossing_excess(self, box: Designs, inside_designs: Designs, free_sizes: Sequence[str]) -> SlopedInterval:
        """A quantity over boxes (Intervals) that is positive only where a design crosses itself or is undercut.

        ``inside_designs`` is one design of each box that can be assembled. If no known crossing shows that it
        crosses itself, a new crossing is searched, in the box of the smallest cams.
        """
        excess = self._crossing_excess_at_known_angles(box, inside_designs, free_sizes)
        unseen = np.flatnonzero(excess.at.low <= 0.0)
        if unseen.size and self.learn_crossing(
            inside_designs.take(unseen[[np.argmin(as_interval(box.size).low[unseen])]])
        ):
            excess = self._crossing_excess_at_known_angles(box, inside_designs, free_sizes)
        return excess

    def designs_crossing_at_known_angles(self, designs: Designs) -> BoolArray:
        """The designs that cross themselves at known cam angles, up to rounding."""
        pairs, sides = self._largest_overlap_angles(designs)
        return np.asarray(
            profile_overlaps(self._setup, designs, self._programme, pairs[:, None], sides[:, None])[:, 0] > 0.0
        )

    def learn_crossing(self, design: Designs) -> bool:
        """Whether a design crosses itself; if so, its cam angles are added to the known ones."""
        crossing = self_crossing_verdict(self._setup, design, self._programme)
        if crossing.crosses:
            pair = largest_overlap_angles(self._setup, design, self._programme, crossing.angles, crossing.side)
            self._known = [(pair, crossing.side), *self._known][:MOST_KNOWN_CROSSINGS]
        return crossing.crosses is True

    def _crossing_excess_at_known_angles(
        self, box: Designs, inside_designs: Designs, free_sizes: Sequence[str]
    ) -> SlopedInterval:
        return box_overlap(
            self._setup,
            box,
            inside_designs,
            free_sizes,
            self._programme,
            *self._largest_overlap_angles(inside_designs),
        )

    def _largest_overlap_angles(self, designs: Designs) -> tuple[FloatArray, FloatArray]:
        """Cam angles (n, 2) [rad] of the largest overlap of each design, near known ones, with the walls' sides."""
        pairs, sides = map(np.array, zip(*(self._known or [(np.zeros(2), INNER_SIDE)]), strict=True))
        best = profile_overlaps(self._setup, designs, self._programme, pairs[None], sides[None]).argmax(axis=1)
        return refine_overlap_angles(self._setup, designs, self._programme, pairs[best], sides[best]), sides[best]


def profile_overlaps(
    setup: Setup, designs: Designs, programme: Programme, angles: FloatArray, wall_side: Any = INNER_SIDE
) -> FloatArray:
    """Overlap of n designs (n, m) [mm³/rad] at pairs of cam angles (n or 1, m, 2) [rad], on one side."""
    column, table = designs.take((slice(None), None)), programme.table
    motion, (other, _) = (
        displacement_and_velocity_at(table, angles[..., 0]),
        displacement_and_velocity_at(table, angles[..., 1]),
    )
    start = start_height_or_arm_angle(setup, column)
    return np.asarray(
        profile_overlap_formula(
            setup, designs_with_wall_as_profile(setup, column, wall_side), start, angles, motion, other
        )
    )


def largest_overlap_angles(
    setup: Setup,
    design: Designs,
    programme: Programme,
    start_angles: Sequence[float],
    wall_side: float = INNER_SIDE,
) -> FloatArray:
    """Pair of cam angles (2,) [rad] with the largest overlap of one design, uphill from a pair."""

    def negative_overlap(pair: FloatArray) -> float:
        return -float(profile_overlaps(setup, design, programme, pair[None, None], wall_side)[0, 0])

    return np.asarray(scipy.optimize.minimize(negative_overlap, start_angles, method="Nelder-Mead").x)


def refine_overlap_angles(
    setup: Setup, designs: Designs, programme: Programme, start_angles: FloatArray, wall_sides: Any = INNER_SIDE
) -> FloatArray:
    """Pairs of cam angles (n, 2) [rad] with the largest overlap of n designs, by Newton's method from near ones."""
    numbers, pairs, walls = np.arange(len(designs)), start_angles, np.reshape(wall_sides, (-1, 1))
    for away in NEWTON_OFFSETS:
        values = profile_overlaps(setup, designs, programme, pairs[:, None] + away * NEWTON_STENCIL, walls)
        step = np.clip(away * _newton_step(values), -LARGEST_ANGLE_STEP, LARGEST_ANGLE_STEP)
        trials = pairs[:, None] + STEP_SHARES[:, None] * step[:, None]
        pairs = trials[numbers, profile_overlaps(setup, designs, programme, trials, walls).argmax(axis=1)]
    return pairs


def _newton_step(stencil_values: FloatArray) -> FloatArray:
    """Newton's step (n, 2) from values (n, 7) at ``NEWTON_STENCIL``, always uphill."""
    middle, right, left, above, below, *slanting = stencil_values.T
    a, b = (right - left) / 2.0, (above - below) / 2.0
    aa, bb = right + left - 2.0 * middle, above + below - 2.0 * middle
    ab = (sum(slanting) - 2.0 * middle - aa - bb) / 2.0
    bent = aa * bb - ab * ab
    step = np.array([ab * b - bb * a, ab * a - aa * b]) / np.where(bent == 0.0, np.inf, bent)
    return np.asarray(np.where(step[0] * a + step[1] * b < 0.0, -step, step).T)


def profile_overlap_formula(
    setup: Setup,
    designs: Designs,
    start_position: Any,
    angles: FloatArray,
    displacement_and_velocity: Any,
    other_displacement: Any,
) -> Number:
    """Overlap (2·R_r·Δ·n(a) − |Δ|²)·|C'(a)| [mm³/rad]; numbers, ranges or ranges with slopes.

    The designs are the ``designs_with_wall_as_profile`` of a wall. ``start_position`` is the height or angle at
    displacement 0, ``angles`` are pairs (a, b) [rad], (..., 2), ``displacement_and_velocity`` is (y, y') at a, and
    ``other_displacement`` is y at b. Vectors are in the ground frame at a.
    """
    assert setup.mechanism.trace_point is not None
    (x, z), (along, up) = trace_point_and_velocity(
        setup, designs, start_position + displacement_and_velocity[0], displacement_and_velocity[1]
    )
    u, w = setup.mechanism.trace_point(designs, start_position + other_displacement)
    turn = designs.sense * (angles[..., 1] - angles[..., 0])
    cosine, sine = np.cos(turn), np.sin(turn)
    gap_x, gap_z = x - (u * cosine + w * sine), z - (w * cosine - u * sine)
    outwards = designs.sense * (gap_z * along - gap_x * up)
    speed = np.sqrt(np.square(along) + np.square(up))
    return 2.0 * designs.roller_radius * outwards - (np.square(gap_x) + np.square(gap_z)) * speed


def box_overlap(
    setup: Setup,
    box: Designs,
    inside_designs: Designs,
    free_sizes: Sequence[str],
    programme: Programme,
    angle_pairs: FloatArray,
    wall_sides: Any = INNER_SIDE,
) -> SlopedInterval:
    """Overlap over boxes of designs, at one pair of cam angles each, with its slopes by the free sizes.

    Slopes are taken by the follower's height or angle at displacement 0, and by the chain rule from that to the
    cam's size: where a follower can only just be assembled, the height changes with the size without bounds.
    """
    error = programme.table.error.max(axis=0)
    (y, y1), (y_b, _) = (displacement_and_velocity_at(programme.table, angles) for angles in angle_pairs.T)
    motion, other = (_error_interval(y, error[0]), _error_interval(y1, error[1])), _error_interval(y_b, error[0])
    sizes: dict[str, Any] = box.sizes
    sides = {name: (as_interval(sizes[name]), inside_designs.sizes[name]) for name in free_sizes}
    with np.errstate(all="ignore"):
        by_size = _sloped_size_variables(sides)
        start = start_height_or_arm_angle(setup, inside_designs.with_values(by_size))
        sides[SIZE_AXIS] = (
            widen(as_interval(start_height_or_arm_angle(setup, box)), HEIGHT_ERROR),
            start_height_or_arm_angle(setup, inside_designs),
        )
        by_start = _sloped_size_variables(sides)
        by_start[SIZE_AXIS] = replace(by_start[SIZE_AXIS], at=start.at)
        designs = inside_designs.with_values({**by_start, SIZE_AXIS: inside_designs.size})
        over = profile_overlap_formula(
            setup,
            designs_with_wall_as_profile(setup, designs, wall_sides),
            by_start[SIZE_AXIS],
            angle_pairs,
            motion,
            other,
        )
        partials = [Interval(*ends) for ends in zip(over.slopes.low, over.slopes.high, strict=True)]
        operands = [start if name == SIZE_AXIS else by_size[name] for name in by_size]
        return apply_chain_rule(over.value, over.at, list(zip(operands, partials, strict=True)))


def _sloped_size_variables(ranges_and_points: dict[str, tuple[Interval, FloatArray]]) -> dict[str, Any]:
    return dict(zip(ranges_and_points, box_variables(*zip(*ranges_and_points.values(), strict=True)), strict=True))


def _error_interval(value: FloatArray, error: float) -> Interval:
    return Interval(value - error, value + error)

"""The turns of a scene whose freed segments share a fixed total of degrees."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import MotionSegment, segment_positions
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.search_space import LawPair
from camopt.scene.problem.variables import Variable
from camopt.solve.smallest.result import SmallestCam

SAME_POSITION = 1e-9  # mm or deg of displacement


class AngleRanges(NamedTuple):
    """A box of turns: the freed segments' angles from ``low`` to ``high``, deg."""

    low: FloatArray
    high: FloatArray


@dataclass(frozen=True)
class SegmentAngles:
    """The turns of a scene under one choice of laws, by the angles (deg) of its freed segments."""

    problem: Problem
    laws: LawPair
    skipped_dwells: tuple[int, ...] = ()
    """Freed dwells that are absent in these turns."""
    budget: Budget = UNLIMITED

    @property
    def segments(self) -> tuple[MotionSegment, ...]:
        return self.problem.segments

    @property
    def variables(self) -> list[Variable]:
        """The free angles of ``[search]``."""
        return self.problem.search_space.angles

    @property
    def freed_segments(self) -> tuple[int, ...]:
        """The indices of the segments with a free angle."""
        return tuple(each.segment for each in self.variables)

    @property
    def scene_angles(self) -> FloatArray:
        """The angles of the freed segments in the scene itself [deg]."""
        return np.array([self.segments[i].angle for i in self.freed_segments])

    @property
    def angle_box(self) -> AngleRanges:
        """The box of all turns: without angles that the other segments cannot complete."""
        low, high = np.array([each.range_ends for each in self.variables], dtype=float).reshape(-1, 2).T
        high[[i in self.skipped_dwells for i in self.freed_segments]] = 0.0
        total, low_sum, high_sum = self.scene_angles.sum(), low.sum(), high.sum()
        low, high = np.maximum(low, total - (high_sum - high)), np.minimum(high, total - (low_sum - low))
        return AngleRanges(np.minimum(low, high), high)

    @property
    def with_and_without_lowest_dwell(self) -> list["SegmentAngles"]:
        """The turns with a dwell at the lowest position, and, if possible, those without one.

        However short, such a dwell is an arc of the base circle, and has its curvature.
        """
        ends = segment_positions(self.segments)
        lowest = min(ends)
        dwells = [
            i for i, s in enumerate(self.segments) if s.segment == "dwell" and ends[i] - lowest <= SAME_POSITION
        ]
        without = replace(self, skipped_dwells=tuple(i for i in dwells if i in self.freed_segments))
        least = dict(zip(self.freed_segments, self.angle_box.low, strict=True))
        may_vanish = all(least.get(i, self.segments[i].angle) == 0.0 for i in dwells)
        fits = without.angle_box.high.sum() >= self.scene_angles.sum()
        return [self, without] if dwells and may_vanish and fits else [self]

    @property
    def corner_turn_angles(self) -> Iterator[FloatArray]:
        """Turns whose first segments, in each of a few orders, are as long as possible, and the rest short."""
        box, count = self.angle_box, len(self.freed_segments)
        for first in range(count):
            for direction in (1, -1):
                freed, remaining = box.low.copy(), self.scene_angles.sum() - box.low.sum()
                for k in (first + direction * np.arange(count)) % count:
                    more = min(remaining, box.high[k] - box.low[k])
                    freed[k], remaining = freed[k] + more, remaining - more
                yield freed

    def all_segment_angles(self, freed_angles: FloatArray) -> list[float]:
        """The angles of all segments of a turn [deg]."""
        angles = dict(zip(self.freed_segments, map(float, freed_angles), strict=True))
        return [angles.get(i, s.angle) for i, s in enumerate(self.segments)]

    def programme_with_angles(self, freed_angles: FloatArray) -> Programme:
        """The programme of the turn with these freed angles."""
        segments = [
            segment._replace(angle=angle)
            for segment, angle in zip(self.segments, self.all_segment_angles(freed_angles), strict=True)
        ]
        angular, laws, load = self.problem.given_motion_is_angle, self.problem.laws, self.problem.programme.load
        programme = Programme.from_segments(segments, angular=angular, laws=laws, load=load)
        return self.problem.with_programme(self.problem.follower_motion(programme)).follower_motion_with_laws(
            *self.laws
        )

    def problem_with_angles(self, freed_angles: FloatArray) -> Problem:
        """The problem with the turn of these freed angles."""
        return self.problem.with_programme(self.programme_with_angles(freed_angles))

    def turn_near_angles(self, angles: FloatArray, box: AngleRanges) -> FloatArray:
        """A turn of a box near these angles of its segments, which give way to keep the total."""
        excess = angles.sum() - self.scene_angles.sum()
        room = angles - box.low if excess > 0.0 else box.high - angles
        return np.asarray(np.clip(angles - excess * room / (room.sum() or 1.0), box.low, box.high))


class TurnOptimum(NamedTuple):
    """The smallest cam of the turns tried, and the angles of its freed segments, deg."""

    answer: SmallestCam
    freed_angles: FloatArray


def better_turn(best: TurnOptimum, other: TurnOptimum) -> TurnOptimum:
    return other if other.answer.size < best.answer.size else best

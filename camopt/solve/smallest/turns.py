"""The turns of a scene whose freed segments share out the degrees that they have together."""

from dataclasses import dataclass, replace
from math import inf
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import MotionSegment, segment_positions
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.search_space import LawPair
from camopt.scene.problem.variables import Variable
from camopt.solve.smallest.result import SmallestCam

SAME_POSITION = 1e-9  # mm or deg of displacement


class AngleRanges(NamedTuple):
    """Angles of the freed segments from ``low`` to ``high``, deg, of the turns among them."""

    low: FloatArray
    high: FloatArray


@dataclass(frozen=True)
class SegmentAngles:
    """The turns of a scene under one choice of laws, by the angles (deg) of its freed segments."""

    problem: Problem
    laws: LawPair
    skipped_dwells: tuple[int, ...] = ()
    """Freed dwells that these turns go without."""
    until: float = inf
    """When the search among them is to stop (``clock.now``)."""

    @property
    def segments(self) -> tuple[MotionSegment, ...]:
        """The segments of the scene's turn."""
        return self.problem.segments

    @property
    def variables(self) -> list[Variable]:
        """The angles that ``[search]`` frees."""
        return self.problem.search_space.angles

    @property
    def freed_segments(self) -> tuple[int, ...]:
        """The segments that have them."""
        return tuple(each.segment for each in self.variables)

    @property
    def scene_angles(self) -> FloatArray:
        """The angles of the freed segments in the scene itself."""
        return np.array([self.segments[i].angle for i in self.freed_segments])

    @property
    def box(self) -> AngleRanges:
        """All angles."""
        low, high = np.array([each.range_ends for each in self.variables], dtype=float).reshape(-1, 2).T
        high[[i in self.skipped_dwells for i in self.freed_segments]] = 0.0
        return self.tighten_ranges(AngleRanges(low, high))

    @property
    def turn_kinds(self) -> list["SegmentAngles"]:
        """The turns in which the follower rests at its lowest, and, where they may, those in which it does not.

        However short, such a rest is an arc of the base circle, and has its curvature.
        """
        ends = segment_positions(self.segments)
        lowest = min(ends)
        rests = [
            i for i, s in enumerate(self.segments) if s.segment == "dwell" and ends[i] - lowest <= SAME_POSITION
        ]
        without = replace(self, skipped_dwells=tuple(i for i in rests if i in self.freed_segments))
        least = dict(zip(self.freed_segments, self.box.low, strict=True))
        gone = all(least.get(i, self.segments[i].angle) == 0.0 for i in rests)
        room = without.box.high.sum() >= self.scene_angles.sum()
        return [self, without] if rests and gone and room else [self]

    @property
    def corner_turns(self) -> list[FloatArray]:
        """Turns whose segments, one after the other in a few orders, are as long as they can be, the rest short."""
        box, count, found = self.box, len(self.freed_segments), []
        for first in range(count):
            for way in (1, -1):
                freed, left = box.low.copy(), self.scene_angles.sum() - box.low.sum()
                for k in (first + way * np.arange(count)) % count:
                    more = min(left, box.high[k] - box.low[k])
                    freed[k], left = freed[k] + more, left - more
                found.append(freed)
        return found

    def tighten_ranges(self, box: AngleRanges) -> AngleRanges:
        """The least box of the same turns: what others cannot take or give is no choice."""
        total = self.scene_angles.sum()
        low = np.maximum(box.low, total - (box.high.sum() - box.high))
        high = np.minimum(box.high, total - (box.low.sum() - box.low))
        return AngleRanges(np.minimum(low, high), high)

    def all_angles(self, freed: FloatArray) -> list[float]:
        """The angles of all segments of a turn."""
        given = dict(zip(self.freed_segments, map(float, freed), strict=True))
        return [given.get(i, s.angle) for i, s in enumerate(self.segments)]

    def programme_of(self, freed: FloatArray) -> Programme:
        """The turn with these angles of its freed segments."""
        angles = self.all_angles(freed)
        segments = [s._replace(angle=angle) for s, angle in zip(self.segments, angles, strict=True)]
        angular, laws, load = self.problem.given_turns, self.problem.laws, self.problem.programme.load
        asked = Programme.from_segments(segments, angular=angular, laws=laws, load=load)
        return self.problem.with_programme(self.problem.follower_motion(asked)).follower_motion_with_laws(
            *self.laws
        )

    def problem_of(self, freed: FloatArray) -> Problem:
        """The problem of the turn with these angles of its freed segments."""
        return self.problem.with_programme(self.programme_of(freed))

    def turn_at_shares(self, share: FloatArray, box: AngleRanges) -> FloatArray:
        """A turn of a box by the share of each segment's range that it takes, more or less: the total is kept."""
        wanted, total = box.low + share * (box.high - box.low), self.scene_angles.sum()
        over = wanted.sum() - total
        room = wanted - box.low if over > 0.0 else box.high - wanted
        return np.asarray(np.clip(wanted - over * room / (room.sum() or 1.0), box.low, box.high))


class TurnOptimum(NamedTuple):
    """The smallest cam of the turns looked at, and the angles of its freed segments."""

    answer: SmallestCam
    freed_angles: FloatArray


def better_turn(best: TurnOptimum, other: TurnOptimum) -> TurnOptimum:
    return other if other.answer.size < best.answer.size else best

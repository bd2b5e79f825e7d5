"""The turns of a scene whose freed segments share out the degrees that they have together."""

from dataclasses import dataclass, replace
from math import inf
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import GivenSegment, positions_of
from camopt.scene.problem.choices import LawPair
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import Variable
from camopt.solve.smallest.result import Smallest

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
    without: tuple[int, ...] = ()
    """Freed dwells that these turns go without."""
    until: float = inf
    """When the search among them is to stop (``clock.now``)."""

    @property
    def segments(self) -> tuple[GivenSegment, ...]:
        """The segments of the scene's turn."""
        return self.problem.segments

    @property
    def variables(self) -> list[Variable]:
        """The angles that ``[search]`` frees."""
        return self.problem.choices.angles

    @property
    def freed(self) -> tuple[int, ...]:
        """The segments that have them."""
        return tuple(each.segment for each in self.variables)

    @property
    def scene_angles(self) -> FloatArray:
        """The angles of the freed segments in the scene itself."""
        return np.array([self.segments[i].angle for i in self.freed])

    @property
    def box(self) -> AngleRanges:
        """All angles."""
        low, high = np.array([each.ends for each in self.variables], dtype=float).reshape(-1, 2).T
        high[[i in self.without for i in self.freed]] = 0.0
        return self.tightened(AngleRanges(low, high))

    @property
    def kinds(self) -> list["SegmentAngles"]:
        """The turns in which the follower rests at its lowest, and, where they may, those in which it does not.

        However short, such a rest is an arc of the base circle, and has its curvature.
        """
        ends = positions_of(self.segments)
        lowest = min(ends)
        rests = [
            i for i, s in enumerate(self.segments) if s.segment == "dwell" and ends[i] - lowest <= SAME_POSITION
        ]
        without = replace(self, without=tuple(i for i in rests if i in self.freed))
        least = dict(zip(self.freed, self.box.low, strict=True))
        gone = all(least.get(i, self.segments[i].angle) == 0.0 for i in rests)
        room = without.box.high.sum() >= self.scene_angles.sum()
        return [self, without] if rests and gone and room else [self]

    @property
    def corners(self) -> list[FloatArray]:
        """Turns whose segments, one after the other in a few orders, are as long as they can be, the rest short."""
        box, count, found = self.box, len(self.freed), []
        for first in range(count):
            for way in (1, -1):
                freed, left = box.low.copy(), self.scene_angles.sum() - box.low.sum()
                for k in (first + way * np.arange(count)) % count:
                    more = min(left, box.high[k] - box.low[k])
                    freed[k], left = freed[k] + more, left - more
                found.append(freed)
        return found

    def tightened(self, box: AngleRanges) -> AngleRanges:
        """The least box of the same turns: what others cannot take or give is no choice."""
        total = self.scene_angles.sum()
        low = np.maximum(box.low, total - (box.high.sum() - box.high))
        high = np.minimum(box.high, total - (box.low.sum() - box.low))
        return AngleRanges(np.minimum(low, high), high)

    def angles(self, freed: FloatArray) -> list[float]:
        """The angles of all segments of a turn."""
        given = dict(zip(self.freed, map(float, freed), strict=True))
        return [given.get(i, s.angle) for i, s in enumerate(self.segments)]

    def programme(self, freed: FloatArray) -> Programme:
        """The turn with these angles of its freed segments."""
        angles = self.angles(freed)
        segments = [s._replace(angle=angle) for s, angle in zip(self.segments, angles, strict=True)]
        angular, laws, load = self.problem.given_turns, self.problem.laws, self.problem.programme.load
        asked = Programme.from_segments(segments, angular=angular, laws=laws, load=load)
        return self.problem.with_programme(self.problem.driving(asked)).with_laws(*self.laws)

    def problem_of(self, freed: FloatArray) -> Problem:
        """The problem of the turn with these angles of its freed segments."""
        return self.problem.with_programme(self.programme(freed))

    def at(self, share: FloatArray, box: AngleRanges) -> FloatArray:
        """A turn of a box by the share of each segment's range that it takes, more or less: the total is kept."""
        wanted, total = box.low + share * (box.high - box.low), self.scene_angles.sum()
        over = wanted.sum() - total
        room = wanted - box.low if over > 0.0 else box.high - wanted
        return np.asarray(np.clip(wanted - over * room / (room.sum() or 1.0), box.low, box.high))


class BestTurn(NamedTuple):
    """The smallest cam of the turns looked at, and the angles of its freed segments."""

    answer: Smallest
    freed: FloatArray


def better(best: BestTurn, other: BestTurn) -> BestTurn:
    return other if other.answer.size < best.answer.size else best

"""The motion of followers over boxes of trains: at a cam angle the tool is where it is asked, whatever the train.

The formulas of the links, run on ranges with slopes (``numerics.sloped_interval.LinkageInterval``), take the tool's
position and its derivatives there to the follower's, y = f⁻¹(z), for all trains of a box, as they do for one. So a
limit on a curve of the cam bounds the excess of all cams with all trains of a box (``enclosure``). Run on arrays,
they give the motions of single trains.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, IntArray
from camopt.core.numerics.interval import Interval, widen
from camopt.core.numerics.sloped_interval import LinkageInterval, SlopedInterval, range_of
from camopt.core.numerics.state import Load, State, TrainForces
from camopt.core.numerics.taylor import Taylor
from camopt.model.mechanisms import Designs
from camopt.model.motion.load import ExternalLoad, TrainLoad
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import motion_ways, reversed_kinds
from camopt.model.motion.tool_drive import tool_position, tool_travel
from camopt.model.trains.carried_load import FollowerLoad
from camopt.model.trains.joint_forces import WeightedForce
from camopt.model.trains.link import position_at
from camopt.model.trains.train import Train
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import is_train_key

MOTION_TERMS = (
    3  # of series: up to the acceleration, the highest derivative that values of curves take; of jerk one more
)
SERIES_FACTORIALS = 2.0, 6.0


LoadAt = Callable[[ExternalLoad], tuple[Any, Any]]
"""What a load that changes over the turn is at some cam angles, with its slope by the cam angle."""


def refuse_load(load: ExternalLoad) -> tuple[Any, Any]:
    """Where no load is asked for."""
    raise NotImplementedError


class ToolPlaces(NamedTuple):
    """Cam angles, and the motion that is asked of the tool there."""

    angles: FloatArray
    """(places,)"""
    motion: FloatArray
    """Position, from the start position of trains, and as many derivatives by the cam angle (terms, places)."""
    kinds: IntArray
    """Of the pieces, and the ways in which the tool moves (places,)."""
    against: IntArray
    """Those of a follower that goes in as the tool goes out."""

    @classmethod
    def at_angles(cls, turn: Programme, angles: FloatArray, terms: int) -> "ToolPlaces":
        """The places at cam angles of a turn that drives a tool."""
        motion, kinds = turn.tool.motion_at(angles)[:terms], turn.tool.kinds_at(angles)
        motion[0] = tool_position(turn, angles)
        return cls(angles, motion, kinds, reversed_kinds(kinds))


@dataclass(frozen=True)
class TrainLinks:
    """What the links of some trains do at cam angles (``effects.train_peak.TrainMotion``)."""

    train: Train
    follower: Taylor
    load: ExternalLoad | TrainLoad | None
    load_at: LoadAt
    ways: Any
    """Which way followers move: 1, −1, or 0 at rest."""

    def transmission(self, link: int) -> Any:
        """The acute angle of a link's coupler, rad."""
        links, start = self.train.links[:link], self.follower.terms[0]
        moved = reduce(lambda at, each: position_at(each.forward, at), links, start)
        coupler = self.train.links[link].couplers[0]
        assert coupler is not None
        return _drop_radicands(coupler.angle(moved))

    def force(self, parts: Sequence[WeightedForce], speed: Any) -> Any:
        """A sum of forces of links at a speed, rad/s, N."""
        assert isinstance(self.load, TrainLoad)
        found = self._forces_at_follower(replace(self.load, parts=tuple(parts)))
        return _drop_radicands(found.still.terms[0] + found.carried.terms[0] * speed**2)

    @property
    def state(self) -> Any:
        """What curves take of the loads over the turn, and of what comes through trains."""
        if isinstance(self.load, ExternalLoad):
            return Load(*self.load_at(self.load))
        if self.load is None:
            return None
        found = self._forces_at_follower(self.load)
        return TrainForces(_drop_radicands(found.still.terms[0]), 0.0, _drop_radicands(found.carried.terms[0]), 0.0)

    def _forces_at_follower(self, load: TrainLoad) -> FollowerLoad:
        loads = {joint: Taylor([*self.load_at(each), 0.0]) for joint, each in load.loads}
        return replace(load, train=self.train).follower_load(self.train, self.follower, self.ways, loads)


@dataclass(frozen=True)
class DrivenMotion:
    """The motion of the followers of some trains at cam angles; what curves ask of a motion.

    Arrays, or ranges with slopes.
    """

    tool: Programme
    load: ExternalLoad | TrainLoad | None
    state: State
    lift: Any
    moved: Any
    """How far the follower goes as the tool goes from its lowest to its highest position."""
    sense: Any
    """1 if the follower goes out with the tool, −1 if against it; 0 where trains of both kinds are in a box."""
    links: TrainLinks
    """Of all of them."""

    def part(self, some: slice) -> "DrivenMotion":
        """That of some of them."""
        y, y1, y2, y3, load, _ = self.state
        y, y1, y2, y3 = (_index_number(each, some) for each in (y, y1, y2, y3))
        if load is not None:
            load = type(load)(*(_index_number(each, some) for each in load))
        state = State(y, y1, y2, y3, load)
        return replace(
            self,
            state=state,
            lift=_index_number(self.lift, some),
            moved=_index_number(self.moved, some),
            sense=self.sense[some],
        )

    @property
    def levels(self) -> tuple[Any, Any]:
        """The lowest and the highest displacement of the follower."""
        return self.lift * 0.0, self.lift

    def least_speed(self, sense: float) -> float:
        """Of a least velocity nothing is known but at the places."""
        return inf


def driven_motion(problem: Problem, designs: Designs, at: LoadAt, motion: Sequence[Any], ways: Any) -> DrivenMotion:
    """The motion that trains of designs give at cam angles, with which go the tool's motion and its ways."""
    turn = problem.programme
    train = _trains_of_designs(problem, designs)
    z, z1, *higher = motion
    follower = train.follower(
        Taylor([z, z1, *(each / by for each, by in zip(higher, SERIES_FACTORIALS, strict=False))])
    )
    one, other = (position_at(train.follower, _travel_end(motion[0], end)) for end in tool_travel(turn))
    sense = _follower_sense(other - one)
    lowest, highest = np.minimum(one, other), np.maximum(one, other)
    y, y1, *higher = follower.terms
    links = TrainLinks(train, Taylor(follower.terms[:MOTION_TERMS]), turn.load, at, ways * sense)
    y2, y3, *_ = (*(each * by for each, by in zip(higher, SERIES_FACTORIALS, strict=False)), 0.0)
    state = State(
        _drop_radicands(y - lowest), _drop_radicands(y1), _drop_radicands(y2), _drop_radicands(y3), links.state
    )
    return DrivenMotion(
        turn.tool, turn.load, state, _drop_radicands(highest - lowest), _drop_radicands(other - one), sense, links
    )


def motion_at_places(problem: Problem, designs: Designs, places: ToolPlaces) -> DrivenMotion:
    """The motion of the followers of single designs, arrays (places, designs)."""
    angles, motion, kinds = places.angles[:, None], places.motion[..., None], places.kinds[:, None]
    return driven_motion(
        problem, designs, lambda load: load.load_and_slope(angles), tuple(motion), motion_ways(kinds)
    )


def motion_over_boxes(
    problem: Problem, boxes: Designs, places: ToolPlaces, where: IntArray, radicands: list[SlopedInterval]
) -> DrivenMotion:
    """That of all designs of boxes, each at a place of its own; adds the radicands that have to be positive."""
    error = problem.programme.tool.table.error.max(axis=0)[:4]
    rows = zip(places.motion[:, where], error, strict=False)
    motion = tuple(widen(Interval(row - e, row + e)) for row, e in rows)
    trains = _with_linkage_intervals(problem, boxes, radicands)
    ways = motion_ways(places.kinds[where])
    return driven_motion(problem, trains, lambda load: load.load_and_slope(places.angles[where]), motion, ways)


def motion_over_ranges(
    problem: Problem, boxes: Designs, motion: Sequence[Interval], kinds: IntArray
) -> DrivenMotion:
    """That of all designs of boxes, each over a range of cam angles, where the tool has a range of motions.

    Of loads that are the same all over the turn.
    """
    trains = _with_linkage_intervals(problem, boxes, [])
    return driven_motion(problem, trains, refuse_load, tuple(map(widen, motion)), motion_ways(kinds))


def _with_linkage_intervals(problem: Problem, boxes: Designs, radicands: list[SlopedInterval]) -> Designs:
    """Boxes with the numbers of their trains as those of linkages."""
    own: dict[str, Any] = {key: boxes.numbers[key] for key in train_keys(problem)}
    ranges = {
        key: LinkageInterval.from_interval(each, radicands)
        for key, each in own.items()
        if isinstance(each, SlopedInterval)
    }
    return boxes.with_values(ranges)


def _trains_of_designs(problem: Problem, designs: Designs) -> Train:
    """The trains that designs bring."""
    return problem.trains_with_numbers({key: each for key, each in designs.numbers.items() if is_train_key(key)})


def train_keys(problem: Problem) -> list[str]:
    """The keys of the numbers of the train of which ``[search]`` gives a range."""
    return [each.key for each in problem.search_space.trains if each.has_range]


def _travel_end(like: Any, end: float) -> Any:
    """An end of the travel, as the positions of the tool are given."""
    return widen(Interval(np.full(like.size, end), np.full(like.size, end))) if isinstance(like, Interval) else end


def _follower_sense(moved: Any) -> Any:
    """Which way the follower goes if the tool goes up; 0 where it is not known."""
    if not isinstance(moved, Interval | SlopedInterval):
        return np.sign(moved)
    ends = range_of(moved)
    return (ends.low > 0.0) * 1.0 - (ends.high < 0.0)


def _drop_radicands(number: Any) -> Any:
    return number.sloped_interval if isinstance(number, LinkageInterval) else number


def _index_number(number: Any, index: slice) -> Any:
    return number if isinstance(number, float) else number[index]

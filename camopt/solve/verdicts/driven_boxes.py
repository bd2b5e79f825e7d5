"""The motion of followers over boxes of trains. The tool moves as the scene asks, whatever the train.

The formulas of the links, run on ranges with slopes (``numerics.sloped_interval.LinkageInterval``), convert the
tool's position and derivatives to those of the follower, y = f⁻¹(z), for all trains of a box. So a limit on a curve
of the cam is decided for all cams with all trains of the box. Run on arrays, the formulas give the motions of
single trains.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, IntArray, Number
from camopt.core.numerics.interval import Interval, widen
from camopt.core.numerics.sloped_interval import LinkageInterval, SlopedInterval, range_of
from camopt.core.numerics.state import Load, State, TrainForces
from camopt.core.numerics.taylor import Taylor
from camopt.model.mechanisms import Designs
from camopt.model.motion.load import ExternalLoad, TrainLoad
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import motion_directions, reversed_kinds
from camopt.model.motion.tool_drive import tool_position, tool_travel_range
from camopt.model.trains.carried_load import FollowerLoad
from camopt.model.trains.joint_forces import WeightedForce
from camopt.model.trains.link import formula_value_at
from camopt.model.trains.train import Train
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import is_train_key

MOTION_TERMS = (
    3  # terms of series, up to the acceleration, the highest derivative that curves read; jerk needs one more
)
SERIES_FACTORIALS = 2.0, 6.0


LoadAt = Callable[[ExternalLoad], tuple[Number, Number]]
"""A changing load at some cam angles, with its slope by the cam angle."""


def refuse_load(load: ExternalLoad) -> tuple[Number, Number]:
    """Refuse a load where none may occur."""
    raise NotImplementedError


class ToolPlaces(NamedTuple):
    """Cam angles with the tool's motion there."""

    angles: FloatArray
    """(places,)"""
    motion: FloatArray
    """Position from the start position of trains, and derivatives by the cam angle (terms, places)."""
    kinds: IntArray
    """Kinds of the pieces, with the direction of the tool's motion (places,)."""
    against: IntArray
    """Kinds for a follower that moves in as the tool moves out."""

    @classmethod
    def at_angles(cls, turn: Programme, angles: FloatArray, term_count: int) -> "ToolPlaces":
        """The tool's motion at some cam angles of a turn."""
        motion, kinds = turn.tool.motion_at(angles)[:term_count], turn.tool.kinds_at(angles)
        motion[0] = tool_position(turn, angles)
        return cls(angles, motion, kinds, reversed_kinds(kinds))


@dataclass(frozen=True)
class TrainLinks:
    """The links of some trains at cam angles (``effects.peak.TrainMotion``)."""

    train: Train
    follower: Taylor
    load: ExternalLoad | TrainLoad | None
    load_at: LoadAt
    ways: Number
    """Directions in which followers move: 1 out, −1 in, 0 at rest."""

    def transmission_angle(self, link: int) -> Number:
        """Acute transmission angle of a link's coupler [rad]."""
        links, start = self.train.links[:link], self.follower.terms[0]
        position = reduce(lambda at, each: formula_value_at(each.driven_displacement, at), links, start)
        coupler = self.train.links[link].couplers_by_driving_side[0]
        assert coupler is not None
        return _drop_radicands(coupler.angle(position))

    def link_force_sum(self, parts: Sequence[WeightedForce], speed: Number) -> Number:
        """Sum of forces of links [N] at a speed [rad/s]."""
        assert isinstance(self.load, TrainLoad)
        forces = self._forces_at_follower(replace(self.load, parts=tuple(parts)))
        return _drop_radicands(forces.still.terms[0] + forces.carried.terms[0] * speed**2)

    @property
    def state(self) -> Load | TrainForces | None:
        """Loads over the turn and forces through trains, as curves read them."""
        if isinstance(self.load, ExternalLoad):
            return Load(*self.load_at(self.load))
        if self.load is None:
            return None
        forces = self._forces_at_follower(self.load)
        return TrainForces(
            _drop_radicands(forces.still.terms[0]), 0.0, _drop_radicands(forces.carried.terms[0]), 0.0
        )

    def _forces_at_follower(self, load: TrainLoad) -> FollowerLoad:
        loads = {joint: Taylor([*self.load_at(each), 0.0]) for joint, each in load.loads}
        return replace(load, train=self.train).follower_load(self.train, self.follower, self.ways, loads)


@dataclass(frozen=True)
class DrivenMotion:
    """Motion of the followers of some trains at cam angles, as curves read it, in arrays or ranges with slopes."""

    tool: Programme
    load: ExternalLoad | TrainLoad | None
    state: State
    lift: Number
    moved: Number
    """Displacement of the follower as the tool moves from its lowest to its highest position."""
    sense: Number
    """1 if the follower moves out with the tool, −1 if against it; 0 if a box has trains of both kinds."""
    links: TrainLinks
    """Links of all the trains."""

    def take_trains(self, index: slice) -> "DrivenMotion":
        """The motion for some of the trains."""
        y, y1, y2, y3, load, _ = self.state
        y, y1, y2, y3 = (_take_items_unless_float(term, index) for term in (y, y1, y2, y3))
        if load is not None:
            load = type(load)(*(_take_items_unless_float(term, index) for term in load))
        return replace(
            self,
            state=State(y, y1, y2, y3, load),
            lift=_take_items_unless_float(self.lift, index),
            moved=_take_items_unless_float(self.moved, index),
            sense=self.sense[index],
        )

    @property
    def lowest_and_highest_displacement(self) -> tuple[Number, Number]:
        """Lowest and highest displacement of the follower."""
        return self.lift * 0.0, self.lift

    def least_speed(self, sense: float) -> float:
        """Infinity: the smallest velocity is known only at the cam angles."""
        return inf


def motion_of_driven_followers(
    problem: Problem, designs: Designs, load_at_angles: LoadAt, tool_motion: Sequence[Any], tool_directions: Any
) -> DrivenMotion:
    """Motion of the followers of designs with trains, from the tool's motion and directions at cam angles."""
    turn = problem.programme
    train = problem.trains_with_numbers({key: x for key, x in designs.numbers.items() if is_train_key(key)})
    z, z1, *higher = tool_motion
    follower = train.follower_displacement(
        Taylor([z, z1, *(each / by for each, by in zip(higher, SERIES_FACTORIALS, strict=False))])
    )
    ends: Any = tool_travel_range(turn)
    if isinstance(z, Interval):
        ends = [widen(Interval(np.full(z.size, end), np.full(z.size, end))) for end in ends]
    one, other = (formula_value_at(train.follower_displacement, end) for end in ends)
    travel = other - one
    if isinstance(travel, Interval | SlopedInterval):
        reach = range_of(travel)
        sense: Any = (reach.low > 0.0) * 1.0 - (reach.high < 0.0)
    else:
        sense = np.sign(travel)
    lowest, highest = np.minimum(one, other), np.maximum(one, other)
    y, y1, *higher = follower.terms
    links = TrainLinks(
        train, Taylor(follower.terms[:MOTION_TERMS]), turn.load, load_at_angles, tool_directions * sense
    )
    y2, y3, *_ = (*(each * by for each, by in zip(higher, SERIES_FACTORIALS, strict=False)), 0.0)
    state = State(
        _drop_radicands(y - lowest), _drop_radicands(y1), _drop_radicands(y2), _drop_radicands(y3), links.state
    )
    return DrivenMotion(
        turn.tool, turn.load, state, _drop_radicands(highest - lowest), _drop_radicands(travel), sense, links
    )


def driven_motion_at_places(problem: Problem, designs: Designs, places: ToolPlaces) -> DrivenMotion:
    """Motion of the followers of single designs at some places, in arrays (places, designs)."""
    angles, motion, kinds = places.angles[:, None], places.motion[..., None], places.kinds[:, None]
    return motion_of_driven_followers(
        problem, designs, lambda load: load.load_and_slope(angles), tuple(motion), motion_directions(kinds)
    )


def driven_motion_over_boxes(
    problem: Problem,
    boxes: Designs,
    places: ToolPlaces,
    box_place_numbers: IntArray,
    radicands: list[SlopedInterval],
) -> DrivenMotion:
    """Motion of the followers of boxes, each at its own place; appends radicands that must be positive."""
    error = problem.programme.tool.table.error.max(axis=0)[:4]
    rows = zip(places.motion[:, box_place_numbers], error, strict=False)
    motion = tuple(widen(Interval(row - e, row + e)) for row, e in rows)
    trains = _with_linkage_intervals(problem, boxes, radicands)
    ways = motion_directions(places.kinds[box_place_numbers])
    return motion_of_driven_followers(
        problem, trains, lambda load: load.load_and_slope(places.angles[box_place_numbers]), motion, ways
    )


def driven_motion_over_ranges(
    problem: Problem, boxes: Designs, tool_motion: Sequence[Interval], kinds: IntArray
) -> DrivenMotion:
    """Motion of the followers of boxes, each over a range of cam angles with a range of the tool's motion.

    Loads must be constant over the turn.
    """
    trains = _with_linkage_intervals(problem, boxes, [])
    return motion_of_driven_followers(
        problem, trains, refuse_load, tuple(map(widen, tool_motion)), motion_directions(kinds)
    )


def _with_linkage_intervals(problem: Problem, boxes: Designs, radicands: list[SlopedInterval]) -> Designs:
    """Boxes with the numbers of their trains as linkage intervals."""
    numbers: dict[str, Any] = {key: boxes.numbers[key] for key in searched_train_keys(problem)}
    ranges = {
        key: LinkageInterval.from_sloped_interval(number, radicands)
        for key, number in numbers.items()
        if isinstance(number, SlopedInterval)
    }
    return boxes.with_values(ranges)


def searched_train_keys(problem: Problem) -> list[str]:
    """Keys of the train's numbers that ``[search]`` gives as ranges."""
    return [choice.key for choice in problem.search_space.trains if choice.has_range]


def _drop_radicands(number: Number) -> Number:
    return number.sloped_interval if isinstance(number, LinkageInterval) else number


def _take_items_unless_float(number: Number, index: slice) -> Number:
    return number if isinstance(number, float) else number[index]

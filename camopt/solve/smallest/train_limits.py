"""What limits say of boxes of sizes and trains: each holds at every cam angle, whatever the train.

Limits on means over the turn are as ``verdicts.mean_boxes`` has those of sizes alone. On each panel of its turn the
tool's motion has a range, which links take to one of the followers of all trains of a box (``driven_boxes``), and
the formula of the curve to its range and slopes. At one design of each box the mean is far better known, by Gauss's
rule; with the slopes, that narrows the range.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from math import pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LARGEST, LEAST, FloatArray, IntArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.sloped_interval import (
    Quotient,
    SlopedInterval,
    as_quotient,
    as_sloped_interval,
    narrow_by_mean_value,
    value_at_point,
)
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.mean import Mean
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.load import ExternalLoad, TrainLoad
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES
from camopt.model.motion.tool_drive import tool_travel
from camopt.scene.problem.constraints import Constraint, TurnMeanConstraint
from camopt.scene.problem.problem import Problem, strictest_constraints
from camopt.scene.problem.tolerance_zones import NumberErrors, add_errors
from camopt.solve.smallest.enclosure import curve_of_designs, present_constraints
from camopt.solve.smallest.excesses import UNBOUNDED_SLOPE, Excesses
from camopt.solve.smallest.motion_boxes import BoxExcesses
from camopt.solve.verdicts.constraint_boxes import excess_of
from camopt.solve.verdicts.driven_boxes import (
    MOTION_TERMS,
    DrivenMotion,
    ToolPlaces,
    motion_at_places,
    motion_over_boxes,
    motion_over_ranges,
)
from camopt.solve.verdicts.mean_boxes import excess_of_mean, weighted_sums
from camopt.solve.verdicts.train_means import has_chosen_kind, mean_of_designs

TRAIN_IDLE_EXCESS = -0.5  # a limit that no point of a box exceeds by more, relative, is not looked at more closely
STROKE_PLACES = 17  # in a stroke at which every box is looked at, even
SCAN_ANGLES, SCAN_ZOOMS = (
    256,
    4,
)  # cam angles at which a derivative is looked for where it is largest, and how often closer
ADDED_ANGLES = 96  # and so many more at most, where cams that were looked at exceed a limit the most


def _angle_of_largest(look: Callable[[FloatArray], FloatArray]) -> float:
    """The cam angle at which a function of cam angles is largest over the turn."""
    middle, half = pi, pi
    for _ in range(SCAN_ZOOMS):
        angles = (middle + half * np.linspace(-1.0, 1.0, SCAN_ANGLES)) % (2 * pi)
        middle, half = angles[np.argmax(look(angles))], half * 2.0 / SCAN_ANGLES
    return float(middle)


def _derivative_order(constraint: Constraint) -> int:
    """Of the derivative of the follower's motion that a constraint is about; 0 if it is about another curve."""
    made: Any = constraint.curve
    return made.order if isinstance(made, Derivative) and made.at_follower else 0


def _largest_derivative_angle(turn: Programme, order: int, side: float, kinds: int) -> float:
    """The cam angle at which a derivative of a follower's motion, times a side, is largest over some strokes."""
    return _angle_of_largest(
        lambda at: np.where(turn.kinds_at(at) & kinds, side * turn.motion_at(at)[order], -np.inf)
    )


class WorstPlaces(NamedTuple):
    """Where boxes are looked at for one side of a constraint."""

    constraint: Constraint
    side: float
    place: IntArray
    """Of each box."""


@dataclass
class TrainLimits:
    """The constraints of limits, and the cam angles at which boxes are looked at."""

    problem: Problem
    """With designs that bring the numbers of the train which have ranges."""
    constraints: list[Constraint]
    train_constraints: list[Constraint]
    """Those on curves of trains."""
    mean_constraints: list[TurnMeanConstraint]
    even_angles: FloatArray
    added_angles: list[float] = field(default_factory=list)

    @classmethod
    def from_problem(cls, problem: Problem) -> "TrainLimits":
        """The limits of a problem."""
        strokes = problem.programme.tool.strokes
        even = [
            each.start + each.angle * np.linspace(0.0, 1.0, STROKE_PLACES if each.law else 1) for each in strokes
        ]
        of_train = [constraint for limit in problem.limits for constraint in limit.train_constraints]
        constraints = [
            each if _derivative_order(each) else each._replace(curve=curve_of_designs(each.curve, each.kinds))
            for each in strictest_constraints(
                constraint for limit in problem.limits for constraint in limit.constraints
            )
        ]
        return cls(problem, constraints, of_train, train_mean_constraints(problem), np.concatenate(even))

    @property
    def tool_places(self) -> ToolPlaces:
        """Both sides of those cam angles."""
        angles = np.array([*self.even_angles, *self.added_angles[-ADDED_ANGLES:]])
        both = self.problem.programme.one_sided_angles(angles, ALL_STROKES)
        terms = max([MOTION_TERMS, *(_derivative_order(each) + 1 for each in self.constraints)])
        return ToolPlaces.at_angles(self.problem.programme, both.ravel(), terms)

    def learn_worst_places(self, design: Designs, problem: Problem) -> None:
        """Add the places at which one cam of a train exceeds limits the most, and those that hold them with it."""
        for own, cam in problem.all_variants(design):
            if own.setup.mechanism.can_assemble(cam, own.programme)[0]:
                for constraint in present_constraints(own, self.constraints):
                    if order := _derivative_order(constraint):
                        found = [
                            _largest_derivative_angle(own.programme, order, side, constraint.kinds)
                            for side in constraint.sides
                        ]
                    else:
                        goals = [(constraint.kinds, LARGEST if side > 0.0 else LEAST) for side in constraint.sides]
                        extremes = EvaluationBlock(own.setup, own.programme, cam).extremes(constraint.curve, goals)
                        found = extremes.where.ravel().tolist()
                    self.added_angles += [each for each in found if each not in self.added_angles]
                for constraint, side in self._train_constraint_sides:
                    self.added_angles.append(
                        _angle_of_largest(partial(self._train_excess_at_angles, constraint, side, cam))
                    )

    @property
    def _train_constraint_sides(self) -> list[tuple[Constraint, float]]:
        return [(constraint, side) for constraint in self.train_constraints for side in constraint.sides]

    def _train_excess_at_angles(
        self, constraint: Constraint, side: float, design: Designs, angles: FloatArray
    ) -> FloatArray:
        """The excess of one design over a constraint on its train at cam angles."""
        places = ToolPlaces.at_angles(self.problem.programme, angles, MOTION_TERMS)
        with np.errstate(all="ignore"):
            motion = motion_at_places(self.problem, design, places)
            over = _train_excess(constraint, side, motion, design) + np.zeros((angles.size, 1))
        return np.asarray(np.nan_to_num(over[:, 0], nan=-np.inf))

    def box_excesses(self, boxes: Designs, inside: Designs, like: SlopedInterval) -> BoxExcesses:
        """The excess where one design of each box exceeds a limit the most, for each limit that is near.

        And what is above 0 where no train, or no cam, can be put together. Where it is not known which way
        followers of a box go, nothing is known of limits. So of all cams that have to hold limits with these.
        """
        every = [
            self._excesses_of_cam(self._designs_with_error(boxes, off), self._designs_with_error(inside, off), like)
            for off in self.cam_errors
        ]
        return BoxExcesses(*(list(chain.from_iterable(part)) for part in zip(*every, strict=True)))

    @property
    def cam_errors(self) -> tuple[NumberErrors, ...]:
        """By how much cams are off that have to hold the limits."""
        return {}, *self.problem.robust_errors

    def _designs_with_error(self, designs: Designs, off: NumberErrors) -> Designs:
        """Designs that are off, with their trains."""
        lacking = {
            key: np.full(len(designs), self.problem.nominal_numbers[key])
            for key in off.keys() - designs.values.keys()
        }
        return add_errors(designs.with_values(lacking), off)

    def _excesses_of_cam(self, boxes: Designs, inside: Designs, like: SlopedInterval) -> BoxExcesses:
        places, count = self.tool_places, like.size
        near = list(self._worst_places(inside, places))
        where = np.array([each.place for each in near] or [np.zeros(count, dtype=int)])
        radicands, every = list[SlopedInterval](), boxes.take(np.tile(np.arange(count), len(where)))
        driven = motion_over_boxes(self.problem, every, places, where.ravel(), radicands)
        found = []
        for number, (constraint, side, place) in enumerate(near):
            here = driven.part(slice(number * count, (number + 1) * count))
            excess = Excesses.from_sloped_value(
                as_sloped_interval(_motion_excess(constraint, side, here, boxes), like)
            )
            kinds = np.where(here.sense > 0.0, places.kinds[place], places.against[place])
            kinds = np.where(here.sense == 0.0, 0, kinds)  # it is not known which way followers go
            found.append(_mask_unknown(excess, kinds & constraint.kinds != 0))
        motion: Any = driven.part(slice(0, count))
        margins = self.problem.setup.mechanism.assembly_margins(boxes, motion)
        lacking = [_assembly_excess(each, 1) for each in margins if isinstance(each, SlopedInterval)]
        lacking += [_assembly_excess(each, len(where)) for each in radicands]
        for constraint, side, place in self._worst_train_places(inside, places):
            asked = list[SlopedInterval]()
            here = motion_over_boxes(self.problem, boxes, places, place, asked)
            excess = Excesses.from_sloped_value(
                as_sloped_interval(_train_excess(constraint, side, here, boxes), like)
            )
            found.append(_mask_unknown(excess, here.sense != 0.0))
            lacking += [_assembly_excess(each, 1) for each in asked]
        for mean in self.mean_constraints:
            over, known = mean_excesses(self.problem, mean, boxes, inside, like)
            found.append(_mask_unknown(over, known))
        # boxes are first cut until it is known which way their followers go
        unknown = np.where(motion.sense == 0.0, UNBOUNDED_SLOPE, -np.inf)[None]
        return BoxExcesses(
            found,
            lacking,
            [Excesses.from_sloped_value(as_sloped_interval(motion.moved, like))._replace(at=unknown)],
        )

    def _worst_places(self, inside: Designs, places: ToolPlaces) -> Iterator[WorstPlaces]:
        """Of constraints that are near, the place where one design of each box exceeds them most; either side."""
        motion = motion_at_places(self.problem, inside, places)
        kinds = np.where(motion.sense > 0.0, places.kinds[:, None], places.against[:, None])
        for constraint in self.constraints:
            for side in constraint.sides:
                over = _motion_excess(constraint, side, motion, inside) + np.zeros(kinds.shape)
                over = np.where(kinds & constraint.kinds, np.nan_to_num(over, nan=-np.inf), -np.inf)
                if np.max(over) > TRAIN_IDLE_EXCESS:
                    yield WorstPlaces(constraint, side, np.argmax(over, axis=0))

    def _worst_train_places(self, inside: Designs, places: ToolPlaces) -> Iterator[WorstPlaces]:
        """The same of constraints on trains."""
        if not self.train_constraints:
            return
        motion = motion_at_places(self.problem, inside, places)
        for constraint, side in self._train_constraint_sides:
            over = _train_excess(constraint, side, motion, inside) + np.zeros((places.angles.size, len(inside)))
            over = np.nan_to_num(over, nan=-np.inf)
            if np.max(over) > TRAIN_IDLE_EXCESS:
                yield WorstPlaces(constraint, side, np.argmax(over, axis=0))


def _train_excess(constraint: Constraint, side: Any, motion: DrivenMotion, designs: Designs) -> Any:
    """What is above 0 where the trains of designs exceed a constraint on one side."""
    return excess_of(constraint, side, as_quotient(constraint.curve(designs, motion.links)), designs)


def _motion_excess(constraint: Constraint, side: Any, motion: DrivenMotion, designs: Designs) -> Any:
    """What is above 0 where designs exceed a constraint on one side."""
    made: Any = constraint.curve
    order = _derivative_order(constraint)
    value = motion.state[order] if order else value_of(made(designs, motion), ..., motion.state)
    return excess_of(constraint, side, as_quotient(value), designs)


def _mask_unknown(over: Excesses, known: Any) -> Excesses:
    """Excesses that tell nothing of other boxes."""
    none = np.full(known.shape, np.inf)
    ends = (np.where(known, each, -none) for each in (over.least, over.at))
    return over._replace(least=next(ends), at=next(ends), most=np.where(known, over.most, none))


def _assembly_excess(margin: SlopedInterval, rows: int) -> Excesses:
    """The excess of what has to be above 0, so many times one after the other."""
    scale = value_at_point(margin).largest_magnitude
    return Excesses.from_sloped_value(-margin / np.where(scale > 0.0, scale, 1.0), rows)


def train_mean_constraints(problem: Problem) -> list[TurnMeanConstraint]:
    """The constraints on means that differ between cams and trains, for loads that are constant over the turn."""
    load = problem.programme.load
    if isinstance(load, ExternalLoad) or (isinstance(load, TrainLoad) and load.loads):
        return []
    means = [limit.mean_constraint for limit in problem.limits if limit.mean_constraint is not None]
    return [
        each for each in means if each.mean.smooth is None and not isinstance(each.mean.curves[0][0], Derivative)
    ]


def mean_excesses(
    problem: Problem, constraint: TurnMeanConstraint, boxes: Designs, inside: Designs, like: SlopedInterval
) -> tuple[Excesses, FloatArray]:
    """The excess over a limit on a mean, and of which boxes it is known: where the followers go one way."""
    turn, count = problem.programme, like.size
    table = turn.tool.table
    every = np.tile(np.arange(count), len(table.centre))
    designs, panels = boxes.take(every), np.repeat(np.arange(len(table.centre)), count)
    zero = (
        tool_travel(turn)[0] - turn.tool.levels[0]
    )  # panels are those of the tool's motion, from the start of trains
    low, high, error = (rows[panels, :MOTION_TERMS].T.copy() for rows in (table.low, table.high, table.error))
    low[0], high[0] = low[0] + zero, high[0] + zero
    ranges = [Interval(a - off, b + off) for a, b, off in zip(low, high, error, strict=True)]
    driven = motion_over_ranges(problem, designs, ranges, _panel_kinds(problem)[panels])
    known = np.all(driven.sense.reshape(-1, count) != 0.0, axis=0)
    parts = [
        _mean_share(problem, constraint.mean, number, designs, driven, like[every], count)
        for number in range(len(constraint.mean.curves))
    ]
    value, slopes = (sum((part[k] for part in parts[1:]), parts[0][k]) for k in (0, 1))
    at = mean_of_designs(problem, constraint.mean, inside, table.centre, table.half_width, _panel_kinds(problem))
    found = narrow_by_mean_value(value, at, slopes, like)
    return Excesses.from_sloped_value(excess_of_mean(constraint, found, boxes)), known


def _panel_kinds(problem: Problem) -> Any:
    """Of each panel of the tool's turn."""
    table = problem.programme.tool.table
    return np.repeat(table.kind, np.diff(table.first_panel))


def _mean_share(
    problem: Problem,
    mean: Mean,
    number: int,
    designs: Designs,
    driven: DrivenMotion,
    like: SlopedInterval,
    count: int,
) -> tuple[Interval, Interval]:
    """The share of the pieces of one curve of a mean: its range (n,) and its slopes (d, n)."""
    make: Any
    make, kinds = mean.curves[number]
    value = value_of(make(designs, driven), ..., driven.state)
    made = value.divide() if isinstance(value, Quotient) else as_sloped_interval(value, like)
    power = np.square(made) if mean.power == 2 else made
    weights = np.repeat(problem.programme.tool.table.half_width / np.pi, count)
    of = np.repeat(_panel_kinds(problem), count)
    shares = np.where(has_chosen_kind(of, kinds, driven.sense), weights, 0.0).reshape(-1, count)
    return weighted_sums(shares, power.value), weighted_sums(shares, power.slopes)

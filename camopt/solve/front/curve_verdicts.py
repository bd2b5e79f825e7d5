"""Verdicts on designs from their pitch curves; a pitch curve that designs share is searched once, for all rollers.

The pitch curve of a disc cam depends only on the sum of base radius and roller radius; that of a cylindrical cam
does not depend on the roller at all. So a space that varies both has fewer pitch curves than designs. The curves of
a motion are searched when a block of designs first needs them, and kept until the next motion.
"""

from dataclasses import replace
from math import prod
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.core.numerics.block_filter import (
    DesignBlock,
    PitchVerdicts,
    RadiusRanges,
    block_counts_and_least_costs,
    gather_feasible_designs,
)
from camopt.model.effects import find_effect
from camopt.model.effects.peak import RadiusRange
from camopt.model.mechanisms.design import unreduced_designs
from camopt.scene.problem.limit import FeasibleBodies, Limit, quantities_of_limits
from camopt.scene.problem.problem import Problem, strictest_constraints
from camopt.scene.problem.rows import DesignRows, QuantityColumns
from camopt.scene.problem.space import DesignSpace
from camopt.solve.front.curve_numbers import CURVES_AT_ONCE, CurveNumbers, OwnCurves
from camopt.solve.front.pareto import is_non_dominated, row_costs
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.feasible_filter import (
    Candidates,
    FilteredRows,
    filter_by_pitch_curve_limits,
    filter_by_remaining_limits,
    filter_designs,
    unfiltered_candidates,
)
from camopt.solve.verdicts.limit_verdicts import relative_excesses_by_limit

NO_BODIES = RadiusRange(np.inf, -np.inf)


class CurveDesigns(NamedTuple):
    """Designs of a motion by number, with the places of their pitch curves in the stored results."""

    designs: IntArray
    places: IntArray

    def __len__(self) -> int:
        return int(self.designs.size)

    def take(self, index: Any) -> "CurveDesigns":
        return CurveDesigns(self.designs[index], self.places[index])


class BlockVerdicts(NamedTuple):
    """The verdicts on the designs of a block."""

    existing: int
    """Number of designs that can be assembled."""
    held_count: int
    """Number of designs that surely meet all limits."""
    held_designs: CurveDesigns
    """These designs, perhaps without some dominated ones."""
    compared: BoolArray
    """Which held designs may be on the front: all non-dominated ones, and perhaps others."""
    open_designs: CurveDesigns
    """The designs that may or may not meet all limits."""


class CurveVerdicts:
    """Verdicts on the designs of one motion from their pitch curves."""

    def __init__(
        self,
        space: DesignSpace,
        problem: Problem,
        curve_numbers: CurveNumbers | OwnCurves,
        wanted_quantities: frozenset[str],
    ) -> None:
        self._space, self._problem, self._numbers = space, problem, curve_numbers
        count = len(curve_numbers)
        self._locks = [Lock() for _ in range(0, count, curve_numbers.part)]
        self._known = np.zeros(len(self._locks), dtype=bool)
        self._exists = np.zeros(count, dtype=bool)
        self._places = np.full(
            count, count
        )  # in the stored results; the last place is for curves that break limits
        self._held, self._costs = np.empty(count + 1, dtype=bool), np.zeros(count + 1)
        self._half_width, *ends = np.empty((5, count + 1))
        self._sure_bodies, self._possible_bodies = RadiusRanges(*ends[:2]), RadiusRanges(*ends[2:])
        for bodies in (self._sure_bodies, self._possible_bodies):
            bodies.least[count], bodies.most[count] = np.inf, -np.inf
        self._columns: QuantityColumns = {}
        self._extreme_share: QuantityColumns = {}
        self._exact = True  # whether all curves so far have the requested accuracy
        self._pending = problem.limits
        self._later = (
            () if problem.programme.radii else limits_decided_by_pitch_curves(problem.limits, wanted_quantities)
        )
        named = wanted_quantities.union(*(limit.deciding_pitch_curve_quantities or () for limit in self._later))
        self._of_pitch = frozenset[str]() if problem.setup.mechanism.profile else named
        """The quantities that are computed from a pitch curve, for all designs that share it."""

    def block_verdicts(self, first: int, last: int, keep_dominated: bool) -> BlockVerdicts:
        """The verdicts on designs first … last − 1.

        Without ``keep_dominated``, some dominated designs are left out.
        """
        curves, bodies, parts = self._numbers.pitch_curves_of_block(first, last)
        self._search_unsearched_parts(parts, last - first)
        cost, sizes = self._single_objective_curve_costs(), self._numbers.shape[-1]
        costs = np.zeros_like(self._costs) if cost is None else cost
        pitch = PitchVerdicts(self._exists, self._places, self._sure_bodies, self._possible_bodies, costs)
        start, end = first % sizes, first % sizes + last - first
        window = slice(start, end) if end <= sizes else slice(0, sizes)  # the block's sizes: a run of them, or all
        block = DesignBlock(curves, bodies, start - window.start)
        counts, least = block_counts_and_least_costs(pitch, block, window.stop - window.start)
        most = np.full(least.size, np.inf) if cost is None else self._non_dominated_cost_ceilings(least, window)
        held, compared, open_ = gather_feasible_designs(pitch, block, counts, most, keep_dominated)
        held_designs, open_designs = (CurveDesigns(first + i, self._places[curves[i]]) for i in (held, open_))
        if cost is None and not keep_dominated and len(held_designs):
            objectives = self._problem.objectives
            front = is_non_dominated(
                row_costs(self.evaluate_held_designs(held_designs, frozenset(objectives)), objectives)
            )
            held_designs, compared = held_designs.take(front), compared[front]
        return BlockVerdicts(counts.existing, counts.held, held_designs, compared, open_designs)

    def _single_objective_curve_costs(self) -> FloatArray | None:
        """The curves' costs by the only objective in which designs of one size differ; None if several differ."""
        objectives, setup = self._problem.objectives, self._problem.setup
        others = [name for name in objectives if name not in self._columns]
        effects = [find_effect(name, setup) for name in others if name != self._problem.size_quantity_name]
        of_size_alone = all(
            effect is not None and effect.is_of_motion(setup) and not setup.free for effect in effects
        )
        return self._costs if self._exact and len(objectives) - len(others) <= 1 and of_size_alone else None

    def _non_dominated_cost_ceilings(self, least_costs: FloatArray, size_slice: slice) -> FloatArray:
        """The largest cost of a non-dominated design of each size, from the least cost of each size; −∞ if none."""
        sizes = self._space.axes["size"][size_slice] if "size" in self._space.axes else np.zeros(least_costs.size)
        costs = self._problem.objectives.get(self._problem.size_quantity_name, 0.0) * sizes
        order = slice(None) if np.all(costs[:-1] <= costs[1:]) else np.argsort(costs, kind="stable")
        costs = costs[order]
        is_new = np.append(True, costs[1:] != costs[:-1])
        all_differ = np.all(is_new)  # otherwise sizes of equal cost form groups
        lowest = (
            least_costs[order] if all_differ else np.minimum.reduceat(least_costs[order], np.flatnonzero(is_new))
        )
        before = np.full(lowest.size, np.inf)
        np.minimum.accumulate(lowest[:-1], out=before[1:])
        allowed = np.where((lowest < before) | (before == np.inf), lowest, -np.inf)
        most = np.empty(least_costs.size)
        most[order] = allowed if all_differ else allowed[np.cumsum(is_new) - 1]
        return most

    def evaluate_held_designs(self, held_designs: CurveDesigns, names: frozenset[str]) -> DesignRows:
        """Quantities and verdicts of designs that surely meet all limits."""
        return self._filter_by_remaining_limits(
            held_designs, np.ones(len(held_designs), dtype=bool), (), names
        ).rows

    def filter_undecided_designs(self, undecided_designs: CurveDesigns, names: frozenset[str]) -> FilteredRows:
        """The feasible designs among open ones."""
        if self._later:
            return filter_designs(self._problem, self._space.designs(undecided_designs.designs), names)
        held = self._held[undecided_designs.places]
        return self._filter_by_remaining_limits(undecided_designs, held, self._pending, names)

    def _filter_by_remaining_limits(
        self, curve_designs: CurveDesigns, held: BoolArray, pending_limits: tuple[Limit, ...], names: frozenset[str]
    ) -> FilteredRows:
        """The feasible ones of some designs, with the needed quantities from their pitch curves."""
        (numbers, places), count = curve_designs, len(curve_designs)
        designs, no_rows = self._space.designs(numbers), DesignRows({}, count)
        candidates = Candidates(self._problem, designs, np.arange(count), no_rows, held, pending_limits)
        plan, setup = candidates.plan_of_pending_effects(names), self._problem.setup
        needed = {name for _, quantities in plan for name in quantities}
        limited = quantities_of_limits(candidates.pending).union(
            *(effect.input_quantities(setup) for effect, _ in plan)
        )
        half_width = self._half_width[places]
        # intervals narrow quantities that are not accurate enough, and then need the outer ends of all of them
        outer = needed & limited if np.all(half_width <= self._problem.accuracy) else needed
        columns, outward = (
            {name: values[places] for name, values in stored.items() if name in wanted}
            for stored, wanted in ((self._columns, needed), (self._extreme_share, outer))
        )
        rows = DesignRows(columns, count, outward, half_width)
        return filter_by_remaining_limits(replace(candidates, rows=rows), names)

    def _search_unsearched_parts(self, parts: IntArray, design_count: int) -> None:
        """Search parts that are not known yet: first those that no other thread searches, then the others."""
        # together: the share of all parts that the block has of all designs, but not too many curves
        share = max(round(len(self._locks) * design_count / prod(self._numbers.shape)), 1)
        parts_together = min(share, max(CURVES_AT_ONCE // self._numbers.part, 1))
        for blocking in (False, True):
            while locked := self._lock_consecutive_unsearched_parts(
                parts[~self._known[parts]].tolist(), parts_together, blocking
            ):
                try:
                    self._evaluate_and_store_curve_parts(locked[0], locked[-1] + 1)
                finally:
                    for part in locked:
                        self._locks[part].release()

    def _lock_consecutive_unsearched_parts(
        self, unsearched_parts: list[int], most_parts: int, blocking: bool
    ) -> list[int]:
        """Consecutive unknown parts, locked for this thread; at most ``most_parts``."""
        locked: list[int] = []
        for part in unsearched_parts:
            if locked and (len(locked) == most_parts or part > locked[-1] + 1):
                break
            if self._locks[part].acquire(blocking=blocking and not locked):
                if self._known[part]:
                    self._locks[part].release()
                else:
                    locked.append(part)
        return locked

    def _evaluate_and_store_curve_parts(self, first_part: int, end_part: int) -> None:
        first = first_part * self._numbers.part
        exists, designs = self._numbers.assemblable_mask_and_designs((first_part, end_part), self._problem)
        filtered = filter_by_pitch_curve_limits(
            unfiltered_candidates(self._problem, designs), self._of_pitch, self._later
        )
        places = slice(first, first + filtered.which.size)
        self._exists[first : first + exists.size] = exists
        self._places[first + np.flatnonzero(exists)[filtered.which]] = np.arange(places.start, places.stop)
        self._held[places] = filtered.held
        for stored, columns in (
            (self._columns, filtered.rows.columns),
            (self._extreme_share, filtered.rows.outward),
        ):
            for name, values in columns.items():
                if name not in stored:
                    stored.setdefault(name, np.zeros(self._places.size + 1))  # one array, whichever thread is first
                stored[name][places] = values
        for name, sign in self._problem.objectives.items():
            if name in filtered.rows.columns:
                self._costs[places] = sign * filtered.rows.columns[name]
        self._half_width[places], self._pending = filtered.rows.half_width, filtered.pending
        if np.any(filtered.rows.half_width > self._problem.accuracy):
            self._exact = False
        ranges = feasible_body_radii(filtered, self._numbers.bodies)
        for bodies, radii in zip((self._sure_bodies, self._possible_bodies), ranges, strict=True):
            bodies.least[places], bodies.most[places] = radii
        self._known[first_part:end_part] = True


def limits_decided_by_pitch_curves(
    limits: tuple[Limit, ...], wanted_quantities: frozenset[str]
) -> tuple[Limit, ...]:
    """The limits that pitch curves decide without their quantities, where no table wants these.

    There are none unless pitch curves decide every other limit too.
    """
    if any(
        limit.deciding_pitch_curve_quantities is None and not limit.is_decided_by_motion_alone for limit in limits
    ):
        return ()
    decided = (
        limit
        for limit in limits
        if limit.is_decided_by_motion_alone or limit.deciding_pitch_curve_quantities != limit.required_quantities
    )
    return tuple(limit for limit in decided if not wanted_quantities.issuperset(limit.required_quantities))


def pitch_curves_decide_all_limits(problem: Problem, wanted_quantities: frozenset[str]) -> bool:
    """Whether pitch curves decide all limits, and some of these without their own quantities."""
    mechanism = problem.setup.mechanism
    own = mechanism.standard_profile_reduction is unreduced_designs or mechanism.profile or problem.programme.radii
    return not own and bool(limits_decided_by_pitch_curves(problem.limits, wanted_quantities))


def feasible_body_radii(candidates: Candidates, radius_range: RadiusRange) -> FeasibleBodies:
    """The ranges of body radii with which designs on each curve surely meet all limits, and may meet them."""
    block = replace(candidates.case, columns=candidates.rows.columns, outward=candidates.rows.outward)
    constraints = strictest_constraints(candidates.pending_constraints)
    limits = [
        limit
        for limit in candidates.pending
        if not limit.constraints or any(constraint in constraints for constraint in limit.constraints)
    ]
    by_limit = [
        all_or_no_radii_for_motion_limit(candidates, limit)
        if limit.is_decided_by_motion_alone
        else limit.sure_and_possible_body_radii(block, radius_range)
        for limit in limits
    ]
    feasible = FeasibleBodies()
    for limit_bodies in filter(None, by_limit):
        feasible = feasible.intersection(limit_bodies)
    if None in by_limit:
        return feasible._replace(sure_bodies=NO_BODIES)
    most = np.where(candidates.held, feasible.sure_bodies.most, -np.inf)
    return feasible._replace(sure_bodies=feasible.sure_bodies._replace(most=most))


def all_or_no_radii_for_motion_limit(candidates: Candidates, limit: Limit) -> FeasibleBodies:
    """The feasible bodies for a limit on the motion alone: all or none, as evaluated for the first curve."""
    if not len(candidates.designs):
        return FeasibleBodies()
    first = candidates.take(np.arange(1))
    rows = run_effects(first.case, limit.required_quantities)
    held = (
        np.all(
            relative_excesses_by_limit((limit,), rows.columns_shifted_by_width_share(side), first.designs) <= 0.0
        )
        for side in (1.0, -1.0)
    )
    return FeasibleBodies(*(RadiusRange() if is_held else NO_BODIES for is_held in held))

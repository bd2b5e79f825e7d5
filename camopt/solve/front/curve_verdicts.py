"""What pitch curves tell of designs; those that designs of a space share are searched once, for all rollers.

The pitch curve of a disc cam depends on base radius and roller radius by their sum alone, that of a cylindrical cam
not on the roller at all. So a space that varies both has fewer pitch curves than designs. Those of one motion are
searched when a block of designs first needs them, some at a time, and kept while that motion lasts.
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
    count_designs,
    gather_designs,
)
from camopt.model.effects import find_effect
from camopt.model.effects.peak import RadiusRange
from camopt.model.mechanisms.design import unshared_pitch
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
    filter_beyond_pitch,
    filter_by_pitch,
    filter_designs,
    unfiltered_candidates,
)
from camopt.solve.verdicts.limit_verdicts import excesses

NO_BODIES = RadiusRange(np.inf, -np.inf)


class CurveDesigns(NamedTuple):
    """Designs of a motion by number, and where what is known of their pitch curves is kept."""

    designs: IntArray
    places: IntArray

    def __len__(self) -> int:
        return int(self.designs.size)

    def take(self, index: Any) -> "CurveDesigns":
        """Those at an index or mask."""
        return CurveDesigns(self.designs[index], self.places[index])


class BlockVerdicts(NamedTuple):
    """The verdicts on the designs of a block."""

    existing: int
    """How many can be assembled."""
    held_count: int
    """How many hold all limits for certain."""
    held_designs: CurveDesigns
    """These, or such of them as no other of them is known to dominate."""
    compared: BoolArray
    """Some of the latter, with all that no other dominates."""
    open_designs: CurveDesigns
    """Those that may hold all limits."""


class CurveVerdicts:
    """Verdicts on the designs of one motion from their pitch curves."""

    def __init__(
        self, space: DesignSpace, problem: Problem, numbers: CurveNumbers | OwnCurves, wanted: frozenset[str]
    ) -> None:
        self._space, self._problem, self._numbers = space, problem, numbers
        count = len(numbers)
        self._locks = [Lock() for _ in range(0, count, numbers.part)]
        self._known = np.zeros(len(self._locks), dtype=bool)
        self._exists = np.zeros(count, dtype=bool)
        self._places = np.full(count, count)  # in what is kept; the last is that of curves that break limits
        self._held, self._costs = np.empty(count + 1, dtype=bool), np.zeros(count + 1)
        self._half_width, *ends = np.empty((5, count + 1))
        self._surely, self._perhaps = RadiusRanges(*ends[:2]), RadiusRanges(*ends[2:])
        for bodies in (self._surely, self._perhaps):
            bodies.least[count], bodies.most[count] = np.inf, -np.inf
        self._columns: QuantityColumns = {}
        self._extreme_share: QuantityColumns = {}
        self._exact = True  # whether what is known of curves is as exact as asked
        self._pending = problem.limits
        self._later = () if problem.programme.radii else limits_of_curves(problem.limits, wanted)
        named = wanted.union(*(limit.pitch_curve_quantities or () for limit in self._later))
        self._of_pitch = frozenset[str]() if problem.setup.mechanism.profile else named
        """The quantities that are found of pitch curves, for all designs that share one."""

    def verdicts(self, first: int, last: int, every: bool) -> BlockVerdicts:
        """The verdicts on designs first … last − 1.

        Unless ``every`` one is wanted, those that hold all limits are left without some that others dominate.
        """
        curves, bodies, parts = self._numbers.curves_of_block(first, last)
        self._search_unknown(parts, self._parts_at_once(last - first))
        cost, window = self._curve_costs(), self._size_window(first, last)
        costs = np.zeros_like(self._costs) if cost is None else cost
        known = PitchVerdicts(self._exists, self._places, self._surely, self._perhaps, costs)
        sizes = window.stop - window.start
        block = DesignBlock(curves, bodies, first % self._numbers.shape[-1] - window.start)
        counts, least = count_designs(known, block, sizes)
        most = np.full(sizes, np.inf) if cost is None else self._cost_ceilings(least, window)
        held, compared, open_ = gather_designs(known, block, counts, most, every)
        surely, perhaps = (CurveDesigns(first + i, self._places[curves[i]]) for i in (held, open_))
        if cost is None and not every and len(surely):
            objectives = self._problem.objectives
            left = is_non_dominated(row_costs(self.feasible_rows(surely, frozenset(objectives)), objectives))
            surely, compared = surely.take(left), compared[left]
        return BlockVerdicts(counts.existing, counts.held, surely, compared, perhaps)

    def _curve_costs(self) -> FloatArray | None:
        """Costs of curves by the one objective in which designs of a size may differ; None if there are more."""
        objectives = self._problem.objectives
        others = [name for name in objectives if name not in self._columns]
        if not self._exact or len(objectives) - len(others) > 1 or not all(map(self._is_shared, others)):
            return None
        return self._costs

    def _size_window(self, first: int, last: int) -> slice:
        """The sizes of the cam that designs first … last − 1 have: the run of them, or all."""
        sizes = self._numbers.shape[-1]
        start = first % sizes
        return slice(start, start + last - first) if start + last - first <= sizes else slice(0, sizes)

    def _cost_ceilings(self, least: FloatArray, window: slice) -> FloatArray:
        """What designs of each size may cost with none of any size that is better, from the least cost of each."""
        sizes = self._space.axes["size"][window] if "size" in self._space.axes else np.zeros(least.size)
        costs = self._problem.objectives.get(self._problem.size_name, 0.0) * sizes
        order = slice(None) if np.all(costs[:-1] <= costs[1:]) else np.argsort(costs, kind="stable")
        costs = costs[order]
        fresh = np.append(True, costs[1:] != costs[:-1])
        apart = np.all(fresh)  # or sizes of equal cost are taken together
        lowest = least[order] if apart else np.minimum.reduceat(least[order], np.flatnonzero(fresh))
        before = np.full(lowest.size, np.inf)
        np.minimum.accumulate(lowest[:-1], out=before[1:])
        allowed = np.where((lowest < before) | (before == np.inf), lowest, -np.inf)
        most = np.empty(least.size)
        most[order] = allowed if apart else allowed[np.cumsum(fresh) - 1]
        return most

    def _is_shared(self, name: str) -> bool:
        """Whether a quantity is the same for designs of the motion that have the same size of the cam."""
        setup, effect = self._problem.setup, find_effect(name, self._problem.setup)
        of_motion = effect is not None and effect.is_of_motion(setup)
        return name == self._problem.size_name or (of_motion and not setup.free)

    def feasible_rows(self, held: CurveDesigns, names: frozenset[str]) -> DesignRows:
        """Quantities of designs that surely hold all limits, with their verdict."""
        nothing_open = self._candidates(held, np.ones(len(held), dtype=bool), ())
        return filter_beyond_pitch(self._with_curve_columns(nothing_open, held.places, names), names).rows

    def filter_open(self, open_: CurveDesigns, names: frozenset[str]) -> FilteredRows:
        """The feasible ones of designs that may hold all limits."""
        if self._later:
            return filter_designs(self._problem, self._space.designs(open_.designs), names)
        candidates = self._candidates(open_, self._held[open_.places], self._pending)
        return filter_beyond_pitch(self._with_curve_columns(candidates, open_.places, names), names)

    def _candidates(self, some: CurveDesigns, held: BoolArray, pending: tuple[Limit, ...]) -> Candidates:
        designs, count = self._space.designs(some.designs), len(some)
        return Candidates(self._problem, designs, np.arange(count), DesignRows({}, count), held, pending)

    def _with_curve_columns(self, candidates: Candidates, places: IntArray, names: frozenset[str]) -> Candidates:
        """With what their curves say of the quantities that are called for."""
        plan, setup = candidates.plan(names), self._problem.setup
        called = {name for _, needed in plan for name in needed}
        judged = quantities_of_limits(candidates.pending).union(*(effect.reads(setup) for effect, _ in plan))
        half_width = self._half_width[places]
        far = called & judged if np.all(half_width <= self._problem.accuracy) else called  # which intervals narrow
        columns, outward = (
            {name: values[places] for name, values in kept.items() if name in some}
            for kept, some in ((self._columns, called), (self._extreme_share, far))
        )
        rows = DesignRows(columns, candidates.rows.count, outward, half_width)
        return replace(candidates, rows=rows)

    def _parts_at_once(self, designs: int) -> int:
        """How many parts a block of designs searches together: its share of them, but not too many curves."""
        most = max(CURVES_AT_ONCE // self._numbers.part, 1)
        return min(max(round(len(self._locks) * designs / prod(self._numbers.shape)), 1), most)

    def _search_unknown(self, parts: IntArray, share: int) -> None:
        """Search what is not known yet: first what no other thread is at, then what one was."""
        for blocking in (False, True):
            while taken := self._lock_parts(parts[~self._known[parts]].tolist(), share, blocking):
                try:
                    self._search_parts(taken[0], taken[-1] + 1)
                finally:
                    for part in taken:
                        self._locks[part].release()

    def _lock_parts(self, unknown: list[int], most: int, blocking: bool) -> list[int]:
        """Consecutive ones of parts that are unknown, for this thread alone."""
        taken: list[int] = []
        for part in unknown:
            if taken and (len(taken) == most or part > taken[-1] + 1):
                break
            if self._locks[part].acquire(blocking=blocking and not taken):
                if self._known[part]:
                    self._locks[part].release()
                else:
                    taken.append(part)
        return taken

    def _search_parts(self, number: int, end: int) -> None:
        first = number * self._numbers.part
        exists, designs = self._numbers.existing_designs((number, end), self._problem)
        found = filter_by_pitch(unfiltered_candidates(self._problem, designs), self._of_pitch, self._later)
        kept_at = slice(first, first + found.which.size)
        self._exists[first : first + exists.size] = exists
        self._places[first + np.flatnonzero(exists)[found.which]] = np.arange(kept_at.start, kept_at.stop)
        self._held[kept_at] = found.held
        for kept, columns in ((self._columns, found.rows.columns), (self._extreme_share, found.rows.outward)):
            for name, values in columns.items():
                if name not in kept:
                    kept.setdefault(name, np.zeros(self._places.size + 1))  # one, whoever comes first
                kept[name][kept_at] = values
        for name, sign in self._problem.objectives.items():
            if name in found.rows.columns:
                self._costs[kept_at] = sign * found.rows.columns[name]
        self._half_width[kept_at], self._pending = found.rows.half_width, found.pending
        if np.any(found.rows.half_width > self._problem.accuracy):
            self._exact = False
        for bodies, told in zip(
            (self._surely, self._perhaps), bodies_within_limits(found, self._numbers.bodies), strict=True
        ):
            bodies.least[kept_at], bodies.most[kept_at] = told
        self._known[number:end] = True


def limits_of_curves(limits: tuple[Limit, ...], wanted: frozenset[str]) -> tuple[Limit, ...]:
    """Limits of which pitch curves tell everything without the quantities that they need, if these are not wanted.

    None unless of every other limit the quantities of pitch curves tell everything too.
    """
    if any(limit.pitch_curve_quantities is None and not limit.is_of_motion for limit in limits):
        return ()
    found = (
        limit for limit in limits if limit.is_of_motion or limit.pitch_curve_quantities != limit.required_quantities
    )
    return tuple(limit for limit in found if not wanted.issuperset(limit.required_quantities))


def curves_decide_limits(problem: Problem, wanted: frozenset[str]) -> bool:
    """Whether pitch curves tell of all limits, and of some without the quantities that they need."""
    mechanism = problem.setup.mechanism
    own = mechanism.profile_or_pitch is unshared_pitch or mechanism.profile or problem.programme.radii
    return not own and bool(limits_of_curves(problem.limits, wanted))


def bodies_within_limits(curves: Candidates, bodies: RadiusRange) -> FeasibleBodies:
    """Which of some bodies designs of some curves hold all limits with for certain, and with which they may."""
    case = replace(curves.case, columns=curves.rows.columns, outward=curves.rows.outward)
    constraints = strictest_constraints(curves.pending_constraints)
    limits = [
        each
        for each in curves.pending
        if not each.constraints or any(constraint in constraints for constraint in each.constraints)
    ]
    told = [
        bodies_of_motion_limit(curves, each) if each.is_of_motion else each.feasible_bodies(case, bodies)
        for each in limits
    ]
    found = FeasibleBodies()
    for each in filter(None, told):
        found = found.intersection(each)
    if None in told:
        return found._replace(sure_bodies=NO_BODIES)
    most = np.where(curves.held, found.sure_bodies.most, -np.inf)
    return found._replace(sure_bodies=found.sure_bodies._replace(most=most))


def bodies_of_motion_limit(curves: Candidates, limit: Limit) -> FeasibleBodies:
    """The same for a limit that the motion decides: as the first of the curves has it."""
    if not len(curves.designs):
        return FeasibleBodies()
    one = curves.take(np.arange(1))
    rows = run_effects(one.case, limit.required_quantities)
    held = (np.all(excesses((limit,), rows.shifted_columns(side), one.designs) <= 0.0) for side in (1.0, -1.0))
    return FeasibleBodies(*(RadiusRange() if each else NO_BODIES for each in held))

"""Pitch curves that designs of a space share: each is searched once, for all rollers.

The pitch curve of a disc cam depends on base radius and roller radius by their sum alone, that of a cylindrical cam
not on the roller at all. So a space that varies both has fewer pitch curves than designs. Those of one motion are
searched when a block of designs first needs them, some at a time, and kept while that motion lasts.
"""

from dataclasses import replace
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from camopt.effects import EFFECTS
from camopt.effects.peak import Bodies
from camopt.front.curve_numbers import CurveNumbers
from camopt.front.pareto import row_costs, undominated
from camopt.mechanisms.design import BoolArray
from camopt.numerics import IntArray
from camopt.problem.limit import Limit, OnCurves
from camopt.problem.problem import Problem, strictest
from camopt.problem.rows import Columns, Rows
from camopt.problem.space import Space
from camopt.quantities import QUANTITIES
from camopt.verdicts.judging import excesses
from camopt.verdicts.running import run_effects
from camopt.verdicts.screening import (
    Candidates,
    Screened,
    begun,
    screened,
    screened_beyond_pitch,
    screened_by_pitch,
)

NONE = Bodies(np.inf, -np.inf)


class Sharing(NamedTuple):
    """Designs of a motion and their pitch curves, by number."""

    designs: IntArray
    curves: IntArray

    def __len__(self) -> int:
        return int(self.designs.size)

    def take(self, index: Any) -> "Sharing":
        """Those at an index or mask."""
        return Sharing(self.designs[index], self.curves[index])


class SharedCurves:
    """Verdicts on the designs of one motion from their pitch curves."""

    def __init__(self, space: Space, problem: Problem, numbers: CurveNumbers, wanted: frozenset[str]) -> None:
        self._space, self._problem, self._numbers, self._wanted = space, problem, numbers, wanted
        count = len(numbers)
        self._locks = [Lock() for _ in range(0, count, numbers.part)]
        self._known = np.zeros(len(self._locks), dtype=bool)
        self._exists, self._held = np.zeros((2, count), dtype=bool)
        self._surely, self._perhaps = (Bodies(*np.tile([[np.inf], [-np.inf]], count)) for _ in range(2))
        self._from_below = False  # whether any body is too small
        self._columns: Columns = {}
        self._outward: Columns = {}
        self._half_width = np.zeros(count)
        self._pending = problem.limits
        self._later = () if problem.programme.radii else told_by_curves(problem.limits, wanted)
        self._wanted = wanted.union(*(limit.of_curves or () for limit in self._later))

    def verdicts(self, first: int, last: int) -> tuple[int, Sharing, Sharing]:
        """Of designs first … last − 1: how many can be assembled, which surely hold all limits, and which may."""
        curves, bodies, parts = self._numbers.of_block(first, last)
        self._search(parts)
        surely, perhaps = (
            Bodies(each.least[curves] if self._from_below else -np.inf, each.most[curves]).hold(bodies)
            for each in (self._surely, self._perhaps)
        )
        existing = int(np.count_nonzero(self._exists[curves]))
        some = (np.flatnonzero(each) for each in (surely, perhaps & ~surely))
        one, other = (Sharing(first + each, curves[each]) for each in some)
        return existing, one, other

    def promising(self, held: Sharing, cheaply: bool) -> BoolArray:
        """Which of designs that surely hold all limits are left without some that others of them dominate.

        ``cheaply``: without such as cost next to nothing to find.
        """
        objectives = self._problem.objectives
        of_curves = [name for name in objectives if name in self._columns]
        others = [name for name in objectives if name not in of_curves]
        exact = np.all(self._half_width <= self._problem.accuracy)
        if not exact or len(of_curves) != 1 or not all(map(self._is_shared, others)):
            if cheaply or not len(held):
                return np.ones(len(held), dtype=bool)
            return undominated(row_costs(self.feasible(held, frozenset(objectives)), objectives))
        (name,) = of_curves
        cost, sizes = objectives[name] * self._columns[name][held.curves], self._numbers.shape[-1]
        place = held.designs - held.designs[:1] // sizes * sizes
        by_size = np.full(-(-(place.max(initial=-1) + 1) // sizes) * sizes, np.inf)
        by_size[place] = cost
        least = by_size.reshape(-1, sizes).min(axis=0, initial=np.inf)
        found: BoolArray = cost <= least[place % sizes]
        return found

    def _is_shared(self, name: str) -> bool:
        """Whether a quantity is the same for designs of the motion that have the same size of the cam."""
        setup, effect = self._problem.setup, EFFECTS[QUANTITIES[name].effect]
        return name == self._problem.size_name or (effect.is_of_motion(setup) and not setup.free)

    def feasible(self, held: Sharing, names: frozenset[str]) -> Rows:
        """Quantities of designs that surely hold all limits, with their verdict."""
        nothing_open = self._candidates(held, np.ones(len(held), dtype=bool), ())
        return screened_beyond_pitch(self._known_of(nothing_open, held.curves, names), names).rows

    def judged(self, open_: Sharing, names: frozenset[str]) -> Screened:
        """The feasible ones of designs that may hold all limits."""
        if self._later:
            return screened(self._problem, self._space.designs(open_.designs), names)
        candidates = self._candidates(open_, self._held[open_.curves], self._pending)
        return screened_beyond_pitch(self._known_of(candidates, open_.curves, names), names)

    def _candidates(self, some: Sharing, held: BoolArray, pending: tuple[Limit, ...]) -> Candidates:
        designs, count = self._space.designs(some.designs), len(some)
        return Candidates(self._problem, designs, np.arange(count), Rows({}, count), held, pending)

    def _known_of(self, candidates: Candidates, curves: IntArray, names: frozenset[str]) -> Candidates:
        """With what their curves say of the quantities that are called for."""
        called = {name for _, needed in candidates.plan(names) for name in needed}
        columns, outward = (
            {name: values[curves] for name, values in kept.items() if name in called}
            for kept in (self._columns, self._outward)
        )
        rows = Rows(columns, candidates.rows.count, outward, self._half_width[curves])
        return replace(candidates, rows=rows)

    def _search(self, parts: IntArray) -> None:
        """Search what is not known yet: first what no other thread is at, then what one was."""
        for blocking in (False, True):
            for part in parts[~self._known[parts]]:
                if self._locks[part].acquire(blocking=blocking):
                    try:
                        if not self._known[part]:
                            self._search_part(part)
                    finally:
                        self._locks[part].release()

    def _search_part(self, part: int) -> None:
        curves = np.arange(part * self._numbers.part, min((part + 1) * self._numbers.part, len(self._numbers)))
        designs = self._numbers.designs.take(slice(curves[0], curves[-1] + 1))
        exists = self._problem.setup.mechanism.exists(designs, self._problem.programme)
        found = screened_by_pitch(begun(self._problem, designs.take(exists)), self._wanted, self._later)
        where = curves[exists][found.which]
        self._exists[curves], self._held[where] = exists, found.held
        for kept, columns in ((self._columns, found.rows.columns), (self._outward, found.rows.outward)):
            for name, values in columns.items():
                kept.setdefault(name, np.zeros(len(self._numbers)))[where] = values  # one, whoever comes first
        self._half_width[where], self._pending = found.rows.half_width, found.pending
        for bodies, told in zip((self._surely, self._perhaps), bodies_of(found, self._numbers.bodies), strict=True):
            bodies.least[where], bodies.most[where] = told
            self._from_below |= bool(np.any(told.least > -np.inf))
        self._known[part] = True


def told_by_curves(limits: tuple[Limit, ...], wanted: frozenset[str]) -> tuple[Limit, ...]:
    """Limits of which pitch curves tell everything without the quantities that they need, if these are not wanted.

    None unless of every other limit the quantities of pitch curves tell everything too.
    """
    if any(limit.of_curves is None and not limit.is_of_motion for limit in limits):
        return ()
    found = (limit for limit in limits if limit.is_of_motion or limit.of_curves != limit.needs)
    return tuple(limit for limit in found if not wanted.issuperset(limit.needs))


def bodies_of(curves: Candidates, bodies: Bodies) -> OnCurves:
    """Which of some bodies designs of some curves hold all limits with for certain, and with which they may."""
    case = replace(curves.case, found=curves.rows.columns, outward=curves.rows.outward)
    claims = strictest(curves.claims)
    limits = [each for each in curves.pending if not each.claims or any(claim in claims for claim in each.claims)]
    told = [of_motion(curves, each) if each.is_of_motion else each.on_curves(case, bodies) for each in limits]
    found = OnCurves()
    for each in filter(None, told):
        found = found.both(each)
    if None in told:
        return found._replace(surely=NONE)
    most = np.where(curves.held, found.surely.most, -np.inf)
    return found._replace(surely=found.surely._replace(most=most))


def of_motion(curves: Candidates, limit: Limit) -> OnCurves:
    """The same for a limit that the motion decides: as the first of the curves has it."""
    if not len(curves.designs):
        return OnCurves()
    one = curves.take(np.arange(1))
    rows = run_effects(one.case, limit.needs)
    held = (np.all(excesses((limit,), rows.shifted(side), one.designs) <= 0.0) for side in (1.0, -1.0))
    return OnCurves(*(Bodies() if each else NONE for each in held))

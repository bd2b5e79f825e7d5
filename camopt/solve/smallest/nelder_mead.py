"""A small cam over the angles of a turn as well, by the simplex method of Nelder and Mead; no proof.

Source: J. A. Nelder, R. Mead, A simplex method for function minimization, Computer Journal 7 (1965).
"""

from collections.abc import Callable
from functools import partial
from itertools import permutations
from math import inf
from typing import Any

import numpy as np
import scipy

from camopt.core.numerics import FloatArray, IndexArray
from camopt.core.numerics.clock import now
from camopt.model.mechanisms.design import SizeBounds
from camopt.solve.smallest.closed_form import closed_form
from camopt.solve.smallest.result import Smallest, gap_of
from camopt.solve.smallest.smallest import small
from camopt.solve.smallest.turns import BestTurn, SegmentAngles, better

DEAR = 1e9  # mm, what is without a feasible design costs a descent
NARROW_TRADE = 1e-9  # deg
MOVES = 80  # of a descent, for each angle
LEAST_TRADE, TRADE_GAIN = 1e-3, 1e-7  # of trades between segments: deg, and share of the size
ROUGH_END, FINE_END = 1e-6, 1e-10  # where a descent ends, mm and shares of a range


def descend(
    cost: Callable[[FloatArray], float],
    start: FloatArray,
    steps: FloatArray,
    closest: tuple[float, float],
    moves: int,
    until: float,
    ends: tuple[float, float] | None = None,
) -> FloatArray:
    """Where a simplex of a start and a step along each variable comes to by so many moves for each, or ``until``.

    It ends where steps and costs differ by no more than ``closest``; ``ends`` are those of all variables.
    """

    def stop(intermediate_result: Any) -> None:
        if now() > until:
            raise StopIteration

    corners = start + np.vstack([np.zeros(start.size), np.diag(steps)])
    step, change = closest
    options = {"initial_simplex": corners, "xatol": step, "fatol": change, "maxfev": moves * start.size}
    bounds = None if ends is None else [ends] * start.size
    return np.asarray(
        scipy.optimize.minimize(cost, start, bounds=bounds, method="Nelder-Mead", callback=stop, options=options).x
    )


class NelderMead:
    """A descent over the angles from the best turn so far; no proof, but most often the optimum."""

    def __init__(self, turns: SegmentAngles, bounds: SizeBounds, best: BestTurn | None = None) -> None:
        self.turns, self.bounds, self.box = turns, bounds, turns.box
        self.free = np.flatnonzero(self.box.high - self.box.low > NARROW_TRADE)
        self.best = best or BestTurn(Smallest(None, 0.0), turns.at(np.full(len(turns.freed), 0.5), self.box))

    def few_turns(self) -> BestTurn:
        """The best turn by the closed form, if it decides; else the best of the middle, corners and the scene."""
        self.looked_at(self.best.freed)
        if self.free.size > 1 and self.down_by_closed_form():
            return self.best
        scene = self.turns.scene_angles
        inside = np.all((scene >= self.box.low) & (scene <= self.box.high))
        for freed in [*self.turns.corners, *([scene] if inside else [])]:
            if now() < self.turns.until:
                self.looked_at(freed)
        return self.best

    def run(self) -> BestTurn:
        """The turn that descents reach from the best one so far."""
        if self.free.size > 1 and self.best.answer.design is not None:
            self.down(self.size, 0.05, ROUGH_END)
            self.traded(self.size, self.best.freed)
            self.down(partial(self.size, closely=True), 1e-3, FINE_END)
        return self.best

    def looked_at(self, freed: FloatArray, *, closely: bool = False) -> Smallest:
        """A small cam for a turn."""
        best, problem = self.best.answer.design, self.turns.problem_of(freed)
        answer = small(problem, self.bounds, best, self.turns.until, closely=closely)
        if answer.design is None and best is None:
            self.best = BestTurn(answer, freed)
        self.best = better(self.best, BestTurn(answer, freed))
        return answer

    def size(self, freed: FloatArray, *, closely: bool = False) -> float:
        """The size of a small cam for a turn; none is found when the time is over."""
        if now() > self.turns.until:
            return DEAR
        return min(self.looked_at(freed, closely=closely).size, DEAR)

    def by_closed_form(self, freed: FloatArray) -> float:
        """The size by the closed form alone; most often no other limit asks for more."""
        design = closed_form(self.turns.problem_of(freed), self.bounds)
        return DEAR if design is None else float(design.size[0])

    def down_by_closed_form(self) -> bool:
        """Descend by the closed form; whether the cam that it ends at holds all other limits too."""
        for reach in (0.05, 1e-3):
            turn = self.traded(self.by_closed_form, self.down(self.by_closed_form, reach, FINE_END))
            least, reached = self.by_closed_form(turn), self.looked_at(turn)
            decided = least < DEAR and reached.design is not None and reached.size <= least + gap_of(reached.design)
        return decided

    def moved(self, start: FloatArray, order: IndexArray, steps: FloatArray) -> FloatArray:
        """A turn whose free segments but the last, in some order, are longer by shares of their ranges."""
        wanted, lengths = start.copy(), steps * (self.box.high - self.box.low)[order[:-1]]
        wanted[order[:-1]] += lengths
        wanted[order[-1]] -= lengths.sum()
        return wanted

    def traded(self, cost: Callable[[FloatArray], float], turn: FloatArray) -> FloatArray:
        """From a turn, give degrees of one segment to another as long as that helps, up to their ends.

        Two segments at a time are the edges of the box of turns: those at an end of their range stay exactly there.
        """
        least, step = cost(turn), float(np.max(self.box.high - self.box.low)) / 4.0
        while step > LEAST_TRADE and now() < self.turns.until:
            before = least
            for longer, shorter in permutations(self.free, 2):
                taken, given = self.box.high[longer] - turn[longer], turn[shorter] - self.box.low[shorter]
                room = min(taken, given)
                moved = min(step, room)
                other = turn.copy()
                other[longer] = self.box.high[longer] if moved == taken else turn[longer] + moved
                other[shorter] = self.box.low[shorter] if moved == given else turn[shorter] - moved
                size = cost(other) if room > 0.0 else inf
                if size < least:
                    turn, least = other, size
            step = step if least < before * (1.0 - TRADE_GAIN) else step / 4.0
        return turn

    def down(self, cost: Callable[[FloatArray], float], reach: float, closest: float) -> FloatArray:
        """The turn of least cost that a simplex of a given reach finds from the best one."""
        start = self.best.freed
        room = np.minimum(start - self.box.low, self.box.high - start)[self.free]
        order = self.free[np.argsort(room, kind="stable")]
        inwards = np.where(self.box.high - start >= start - self.box.low, reach, -reach)[order[:-1]]

        def at(steps: FloatArray) -> float:
            wanted = self.moved(start, order, steps)
            outside = float(np.maximum(self.box.low - wanted, wanted - self.box.high).max(initial=0.0))
            return cost(wanted) if outside <= 0.0 else DEAR * (1.0 + outside)

        steps = descend(at, np.zeros(inwards.size), inwards, (closest, closest), MOVES, self.turns.until)
        return self.moved(start, order, steps)

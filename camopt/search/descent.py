"""A small cam over the angles of a turn as well, by the simplex method of Nelder and Mead; no proof."""

from collections.abc import Callable
from functools import partial

import numpy as np

from camopt.numerics import FloatArray
from camopt.search.answer import Bounds, Smallest, gap_of
from camopt.search.closed_form import closed_form
from camopt.search.smallest import small
from camopt.search.turns import Found, Turns, better

STARTS = 8  # for each freed segment, turns from which the descent starts
NARROW = 1e-9  # deg
DEAR = 1e9  # mm, what a turn without a feasible design costs a descent
MOVES = 80  # of a descent, for each angle
ROUGH, EXACT = 1e-6, 1e-10  # where a descent ends, mm and shares of a range


class Descent:
    """A descent over the angles from the best turn so far; no proof, but most often the optimum."""

    def __init__(self, turns: Turns, bounds: Bounds) -> None:
        self.turns, self.bounds, self.box = turns, bounds, turns.box
        self.free = np.flatnonzero(self.box.high - self.box.low > NARROW)
        self.best = Found(Smallest(None, 0.0), turns.at(np.full(len(turns.freed), 0.5), self.box))
        self.looked_at(self.best.freed)

    def looked_at(self, freed: FloatArray, *, closely: bool = False) -> Smallest:
        """A small cam for a turn."""
        best = self.best.answer.design
        answer = small(self.turns.question, self.turns.programme(freed), self.bounds, best, closely=closely)
        if answer.design is None and best is None:
            self.best = Found(answer, freed)
        self.best = better(self.best, Found(answer, freed))
        return answer

    def size(self, freed: FloatArray, *, closely: bool = False) -> float:
        """The size of a small cam for a turn."""
        return min(self.looked_at(freed, closely=closely).size, DEAR)

    def by_closed_form(self, freed: FloatArray) -> float:
        """The size by the closed form alone; most often no other limit asks for more."""
        design = closed_form(self.turns.question, self.turns.programme(freed), self.bounds)
        return DEAR if design is None else float(design.size[0])

    def down_by_closed_form(self) -> bool:
        """Descend by the closed form; whether the cam that it ends at holds all other limits too."""
        for reach in (0.05, 1e-3) if self.free.size > 2 else (0.05,):
            turn = self.down(self.by_closed_form, reach, EXACT)
            least, reached = self.by_closed_form(turn), self.looked_at(turn)
            decided = least < DEAR and reached.design is not None and reached.size <= least + gap_of(reached.design)
        return decided

    def moved(self, start: FloatArray, steps: FloatArray) -> FloatArray:
        """A turn whose free segments but the last are longer by shares of their ranges."""
        wanted, lengths = start.copy(), steps * (self.box.high - self.box.low)[self.free[:-1]]
        wanted[self.free[:-1]] += lengths
        wanted[self.free[-1]] -= lengths.sum()
        return wanted

    def down(self, cost: Callable[[FloatArray], float], reach: float, closest: float) -> FloatArray:
        """The turn of least cost that a simplex of a given reach finds from the best one."""
        from scipy.optimize import minimize

        start = self.best.freed

        def at(steps: FloatArray) -> float:
            wanted = self.moved(start, steps)
            outside = float(np.maximum(self.box.low - wanted, wanted - self.box.high).max(initial=0.0))
            return cost(wanted) if outside <= 0.0 else DEAR * (1.0 + outside)

        corners = np.vstack([np.zeros(self.free.size - 1), np.diag(np.full(self.free.size - 1, reach))])
        most = MOVES * (self.free.size - 1)
        options = {"initial_simplex": corners, "xatol": closest, "fatol": closest, "maxfev": most}
        return self.moved(start, minimize(at, corners[0], method="Nelder-Mead", options=options).x)


def descended(turns: Turns, bounds: Bounds) -> Found:
    """The best turn by descents: from the middle where the closed form decides, else from the best of a few."""
    descent = Descent(turns, bounds)
    several = descent.free.size > 1
    if several and descent.down_by_closed_form():
        return descent.best
    shares = np.random.default_rng(0).uniform(size=(STARTS * (len(turns.freed) - 1), len(turns.freed)))
    starts = [turns.at(share, descent.box) for share in shares]
    if np.all((turns.scene_angles >= descent.box.low) & (turns.scene_angles <= descent.box.high)):
        starts.append(turns.scene_angles)
    for freed in starts:
        descent.looked_at(freed)
    if several and descent.best.answer.design is not None and not descent.down_by_closed_form():
        descent.down(descent.size, 0.05, ROUGH)
        descent.down(partial(descent.size, closely=True), 1e-3, EXACT)
    return descent.best

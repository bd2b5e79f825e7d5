"""The price of each bound that free laws hold: multipliers of the convex programme.

At the optimum x of a programme, with multipliers λ of its constraints c ≤ 0 and c = 0, the least objective f
changes with a bound b as the Lagrangian does, df/db = ∂(f + Σ λ·c)/∂b at the same x and λ (envelope theorem). The
derivatives by b are central differences of the programmes of two scenes that differ in b alone: neither is solved.

Sources: S. Boyd, L. Vandenberghe, Convex Optimization, 5.6; J. Nocedal, S. J. Wright, Numerical Optimization,
ch. 12.
"""

from collections.abc import Iterator
from math import inf
from typing import NamedTuple

import numpy as np

from camopt.mistakes import BadInput, Unsolved
from camopt.motion.programme import PEAKS, law_peaks
from camopt.motion.table import RETURN, RISE
from camopt.numerics import FloatArray
from camopt.problem.problem import resolve
from camopt.quantities import QUANTITIES
from camopt.scene.scene import Scene
from camopt.smallest.freedom import Freedom
from camopt.smallest.prices import Price
from camopt.synthesis.convex import Convex, convex
from camopt.synthesis.from_scene import by_offset, default_peaks, demand_of
from camopt.synthesis.spline_motion import SplineMotion
from camopt.synthesis.synthesise import MARGINS, tightened
from camopt.synthesis.synthesised import Synthesised

STEP = 1e-4  # of a bound, in differences
NOTHING = 1e-5  # of the objective: what a bound that does not bind may cost, by a solver's error


class Given(NamedTuple):
    """A bound of a scene that free laws may hold."""

    key: str
    value: float
    unit: str
    relation: str

    def at(self, scene: Scene, value: float) -> Scene:
        """The scene with another value of the bound."""
        *names, last = self.key.split(".")
        if not last.isdecimal():
            return scene.replace(**{self.key: value})
        name = ".".join(names)
        pair = list(scene.numbers([name])[name])
        pair[int(last) - 1] = value
        return scene.replace(**{name: pair})


def synthesis_prices(result: Synthesised) -> list[Price]:
    """Find what each bound costs that holds the free laws of a synthesis.

    A price is the derivative of the least objective, with other laws for each value of the bound: mm of size per
    unit of the bound where the size is minimised. Bounds are those of ``[limits]``, the peaks of ``[synthesis]``
    (also if taken by default), the diameter of the shaft, and the ends of ranges in ``[search]``. With the
    multipliers λ of the constraints c of the convex programme, a bound b costs df/db = ∂(f + Σ λ·c)/∂b.

    Parameters
    ----------
    result
        What ``synthesise`` found.

    Returns
    -------
    list
        A ``Price`` for each bound that binds, with ``tightened`` as ``price``. Empty where the laws are a local
        optimum (``convex`` is False), as what holds them is not in the convex programme, and if its solver fails.

    Raises
    ------
    BadInput
        If the scene that was asked is one that ``synthesise`` does not take.

    Examples
    --------
    >>> coarse = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
    >>> found = camopt.synthesis_prices(camopt.synthesise(coarse))
    >>> [(price.key, round(price.price, 2)) for price in found][:2]
    [('limits.pressure_angle', -1.47), ('limits.pressure_angle_return', -1.71)]

    References
    ----------
    S. Boyd, L. Vandenberghe, Convex Optimization, 5.6.
    """
    scene = _in_numbers(result.asked)
    solved = _solved(scene) if result.convex else None
    if solved is None:
        return []
    found = []
    for each in _given(scene):
        cost = _cost(solved, scene, each)
        if abs(cost) * (abs(each.value) or 1.0) > NOTHING * (abs(result.objective) + solved.model.unit):
            found.append(Price(each.key, each.value, each.unit, each.relation, cost, cost))
    return found


class Solved(NamedTuple):
    """A programme that is solved: one of those of its scene, with its number and the margin of its limits."""

    model: Convex
    number: int
    margin: float

    def beside(self, scene: Scene) -> Convex:
        """The same programme of another scene, not solved."""
        return _programmes(scene, self.margin)[self.number]


def _programmes(scene: Scene, margin: float) -> list[Convex]:
    """The programme of a scene, for each offset that it lists."""
    return [convex(tightened(each, margin), SplineMotion) for each in by_offset(demand_of(resolve(scene)))]


def _solved(scene: Scene) -> Solved | None:
    """The programme of a scene whose optimum is the least; None if the solver fails."""
    for margin in MARGINS:
        models = _programmes(scene, margin)
        try:
            values = [model.solve() for model in models]
        except Unsolved:
            continue  # with other numbers it may not fail
        if min(values) < inf:
            number = values.index(min(values))
            return Solved(models[number], number, margin)
    return None


def _cost(solved: Solved, scene: Scene, given: Given) -> float:
    """The derivative of the Lagrangian by a bound, at the optimum of a programme: one-sided if need be."""
    step, model = STEP * (abs(given.value) or 1.0), solved.model
    sides = []
    for k in (1.0, 0.0, -1.0):
        try:
            sides.append((k * step, _values(solved.beside(given.at(scene, given.value + k * step)), model)))
        except BadInput:  # the bound may not be so
            continue
    (last, (above, over)), (first, (below, under)) = sides[0], sides[-1]
    change = above - below
    for limit, more, less in zip(model.problem.constraints, over, under, strict=True):
        change += model.unit * float(np.sum(limit.dual_value * (more - less)))
    return change / (last - first) if last > first else 0.0


def _values(side: Convex, model: Convex) -> tuple[float, list[FloatArray]]:
    """The objective and the constraints of a programme at the optimum of another."""
    for own, solved in zip(side.problem.variables(), model.problem.variables(), strict=True):
        own.value = solved.value
    return side.unit * float(side.goal.value), [limit.expr.value for limit in side.problem.constraints]


def _in_numbers(scene: Scene) -> Scene:
    """The scene with a number for each peak that its rises and returns take from a law, or by default."""
    problem = resolve(scene)
    if not any(stroke.kind in (RISE, RETURN) for stroke in problem.programme.strokes):
        return scene
    given = {name: getattr(scene.synthesis, name) for name in PEAKS}
    peaks = {name: law_peaks(problem.laws[law])[name] for name, law in given.items() if isinstance(law, str)}
    return scene.replace(**{f"synthesis.{name}": peak for name, peak in (peaks | default_peaks(scene)).items()})


def _given(scene: Scene) -> Iterator[Given]:
    """The bounds of a scene that free laws may hold."""
    problem = resolve(scene)
    for limit in problem.limits:
        if limit.asked and not limit.given_by.startswith("limits."):
            unit = QUANTITIES[limit.shown[0]].unit if limit.shown else "mm"
            yield Given(limit.key, limit.bound, unit, limit.relation)
    for name in PEAKS:
        peak = getattr(scene.synthesis, name)
        if isinstance(peak, tuple):
            for number, (end, relation) in enumerate(zip(peak, "≥≤", strict=True), start=1):
                if end:  # 0 makes the laws monotone
                    yield Given(f"synthesis.{name}.{number}", end, "", relation)
        elif peak is not None:
            yield Given(f"synthesis.{name}", peak, "", "±")
    for end in Freedom.of(problem).ends:
        yield Given(end.key, end.value, end.unit, end.relation)

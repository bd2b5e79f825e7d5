"""The frontier: what free laws trade between size, acceleration, jerk and more, beside the known laws.

One term is minimised for each value that the others are held at. The convex programme is built once in each worker
and solved for all values; each of its solutions becomes a cam, as in ``synthesise``, with a bound of its own.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from math import inf
from typing import Any

import cvxpy as cp
import numpy as np

from camopt.mistakes import BadInput, Mistake, Unmet, Unsolved, nearest
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.quantities import QUANTITIES
from camopt.question import resolve
from camopt.scene import Scene
from camopt.scene_tables import TERMS
from camopt.search.answer import Progress
from camopt.synthesis.convex import Convex, convex
from camopt.synthesis.curvature import Iterate, iterate_of, sharpest_allowed, steps
from camopt.synthesis.demand import Demand, demand_of
from camopt.synthesis.free import FreeMotion
from camopt.synthesis.relaxation import RelaxedMotion
from camopt.synthesis.synthesise import (
    MARGINS,
    PANELS,
    SOLVER_ERROR,
    WORSE,
    bound_of,
    cam_for,
    gentlest,
    known_laws,
    lowered,
    programme_with,
    term_of,
    tightened,
    within,
)

ENDS = 1e-5  # by which an end is widened, relative, so that a solver finds its laws
PROXY = "acceleration"  # is traded for a quantity that is not convex in the motion


@dataclass(frozen=True)
class Frontier:
    """A trade between two or three axes. A term is minimised; a quantity has its own direction, down.

    ``rows`` are free laws that no other row betters, by the first axis: the axes' values, the quantities of the
    cam, ``bound`` (the least of the first axis for any motion that holds the others' values; None where none was
    computed) and ``scene`` (TOML, with the laws). ``known`` are the known laws, ``within`` the limits that all rows
    hold or not. ``least`` is how far down each traded term goes, and what no motion within them can pass.
    """

    scene: Scene
    axes: tuple[str, ...]
    rows: list[dict[str, Any]]
    known: list[dict[str, Any]]
    least: dict[str, tuple[float, float | None]]


def frontier(
    scene: Scene,
    axes: Sequence[str] = ("size", "acceleration"),
    points: int = 24,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Frontier:
    """The trade between two or three axes over free laws.

    Parameters
    ----------
    axes
        Terms of the objective (as in ``[synthesis] minimise``) or quantities of the scene's cams, such as
        ``torque_peak_N_m``. Laws are found for the terms, with acceleration beside them if an axis is a quantity:
        the trade in a quantity is then what these laws have, not an optimum.
    points
        Values that each held term takes between its ends.
    workers
        Processes; one a core if not given.

    Raises
    ------
    BadInput
        For other axes, or a scene that ``synthesise`` does not take.
    Unmet
        If no free law holds all limits.
    """
    scene, terms = _checked(scene, axes)
    demand = replace(demand_of(resolve(scene)), objective={terms[0]: 1.0})
    ends = {term: _ends(demand, terms, term) for term in terms}
    held = terms[1:]
    grids = [_grid(ends[t][t] * (1 + ENDS), max(ends[other][t] for other in terms), points) for t in held]
    values = [dict(zip(held, map(float, pick), strict=True)) for pick in product(*grids)]
    rows = []
    for done, row in enumerate(_in_parallel(scene, terms, values, workers), start=1):
        rows += [row] if row else []
        if progress:
            progress(done, len(values))
    known = [_known(demand, axes, cam) for cam in known_laws(scene).values()]
    least = {t: (ends[t][t], bound_of(replace(demand, objective={t: 1.0}))) for t in terms}
    return Frontier(scene, tuple(axes), _front(rows, axes), known, least)


def _checked(scene: Scene, axes: Sequence[str]) -> tuple[Scene, tuple[str, ...]]:
    """The scene that minimises the axes, and the terms that are traded."""
    question = resolve(scene)
    quantities = sorted(name for name in question.wanted if _less_is_better(name))
    mistakes = []
    if not 2 <= len(axes) <= 3 or len(set(axes)) < len(axes):
        mistakes.append(Mistake("camopt", "--axes", ",".join(axes), "two or three different axes"))
    for axis in axes:
        if axis not in TERMS and axis not in quantities:
            quantity = "a quantity that the scene calls for and less of is better"
            what = f"{', '.join(TERMS)} or {quantity}; {nearest(axis, [*TERMS, *quantities])}"
            mistakes.append(Mistake("camopt", "--axes", axis, what))
    if mistakes:
        raise BadInput(mistakes)
    terms = tuple(axis for axis in axes if axis in TERMS)
    if len(terms) < len(axes):
        terms = tuple(dict.fromkeys((*(terms or ("size",)), PROXY)))
    return scene.replace(**{"synthesis.minimise": dict.fromkeys(terms, 1.0)}), terms


def _less_is_better(name: str) -> bool:
    """Whether a quantity can be an axis: a largest value, such as a peak or a load."""
    return QUANTITIES[name].kind is float and any(
        part in name for part in ("_max_", "_peak_", "_rms_", "_required_")
    )


def _ends(demand: Demand, terms: Sequence[str], first: str) -> dict[str, float]:
    """The least value of one term, and the least that the others have there."""
    least = _least(demand, {first: 1.0}, {})
    found = {first: least}
    for other in terms:
        if other != first:
            found[other] = _least(demand, {other: 1.0}, {first: least + ENDS * abs(least)})
    return found


def _grid(low: float, high: float, points: int) -> FloatArray:
    """Values closer together where a frontier bends most, near the least."""
    return np.asarray(low * (high / low) ** np.linspace(0.0, 1.0, points) ** 2)


def _least(demand: Demand, objective: dict[str, float], held: Mapping[str, float]) -> float:
    value = convex(tightened(replace(demand, objective=objective), MARGINS[0]), FreeMotion, held).solve()
    if value == inf:
        raise Unmet("no free law of this kind holds all limits; more pieces may")
    return value


# --------------------------------------------------------------------------------------------------- the points


def _in_parallel(
    scene: Scene, terms: tuple[str, ...], values: list[dict[str, float]], workers: int | None
) -> Iterator[dict[str, Any] | None]:
    """The row of each point, in order, from several processes if there are points for them."""
    from os import cpu_count

    from joblib import Parallel, delayed

    count = min(workers or cpu_count() or 1, len(values))
    yield from Parallel(n_jobs=count, return_as="generator", batch_size=1)(
        delayed(_point)(scene.to_toml(), terms, value) for value in values
    )


class Worker:
    """What a process keeps: the programme of free laws and its relaxation, with parameters for the held terms."""

    def __init__(self, scene: Scene, terms: Sequence[str]) -> None:
        self.demand = replace(demand_of(resolve(scene)), objective={terms[0]: 1.0})
        self.held = {term: cp.Parameter(nonneg=True) for term in terms[1:]}
        self.free = convex(tightened(self.demand, MARGINS[0]), FreeMotion, self.held)
        wider = tightened(self.demand, -SOLVER_ERROR)
        self.relaxed = convex(wider, partial(RelaxedMotion, PANELS[0]), self.held)

    def solve(self, model: Convex, value: Mapping[str, float], margin: float = 0.0) -> float:
        """The least objective with the terms held at a value; infinite if there is none, or the solver fails."""
        for term, parameter in self.held.items():
            parameter.value = value[term] * (1.0 - margin)
        try:
            return model.solve()
        except Unsolved:
            return inf

    def iterates(self, value: Mapping[str, float]) -> Iterator[Iterate]:
        """Free laws for a value: what the programme gives, and bent to the curvature if need be."""
        least = self.solve(self.free, value, MARGINS[0])
        if least == inf:
            return
        plain = iterate_of(self.free)
        calm = gentlest(self.free, least)
        yield from (each for each in (calm, plain) if each is not None)
        sharpest = sharpest_allowed(self.demand)
        if sharpest is not None:
            yield steps(self.free, plain, sharpest)

    def holds(self, found: Iterate, value: Mapping[str, float]) -> bool:
        """Whether laws hold the ranges of their derivatives and the values, exactly."""
        motion = (term for term in self.held if term != "size")
        programme = programme_with(self.demand, found)
        return within(self.demand, programme) and all(
            term_of(self.demand, programme, t, 0.0) <= value[t] for t in motion
        )


_WORKERS: dict[Any, Worker] = {}


def _point(toml: str, terms: tuple[str, ...], value: dict[str, float]) -> dict[str, Any] | None:
    """The row of one point: the least first term with the others held at a value; None if no cam is found."""
    import tomllib

    worker = _WORKERS.get((toml, terms))
    if worker is None:
        _WORKERS.clear()
        worker = _WORKERS[toml, terms] = Worker(Scene.from_dict(tomllib.loads(toml)), terms)
    best = None
    for found in worker.iterates(value):
        cam = cam_for(worker.demand, found) if worker.holds(found, value) else None
        if cam and (best is None or cam.objective < best.objective):
            best = cam
        least = worker.free.unit * worker.free.problem.value
        if best and best.objective <= least + WORSE * (least + worker.free.unit):
            break
    if best is None:
        return None
    bound = lowered(worker.relaxed, worker.solve(worker.relaxed, value, -SOLVER_ERROR))
    lowest = bound if worker.relaxed.exact and bound <= best.objective else None
    row = _row(worker.demand, resolve(best.scene).programme, terms, best.design)
    return {**row, "bound": lowest, "scene": best.scene.to_toml()}


def _row(demand: Demand, programme: Programme, axes: Sequence[str], design: dict[str, Any]) -> dict[str, Any]:
    """The axes' values of a cam, and its quantities."""
    size = design[demand.question.size_name]
    return {**{axis: term_of(demand, programme, axis, size) for axis in axes if axis in TERMS}, **design}


def _known(demand: Demand, axes: Sequence[str], design: dict[str, Any]) -> dict[str, Any]:
    """The row of a cam of known laws, and whether they are within the limits on derivatives that are not traded."""
    question = demand.question
    names = [design[f"law_{kind}"] for kind in ("rise", "return")]
    programme = question.with_laws(*(name if name in question.laws else None for name in names))
    smooth = all(jump.order > demand.rest for jump in programme.jumps)
    return {**_row(demand, programme, axes, design), "within": within(demand, programme) and smooth}


def _front(rows: list[dict[str, Any]], axes: Sequence[str]) -> list[dict[str, Any]]:
    """The rows that no other betters, by the first axis."""
    import moocore

    if not rows:
        return []
    costs: FloatArray = np.nan_to_num(np.array([[row[axis] for axis in axes] for row in rows], dtype=float))
    kept = moocore.is_nondominated(costs, keep_weakly=False)
    return sorted((row for row, keep in zip(rows, kept, strict=True) if keep), key=lambda row: float(row[axes[0]]))

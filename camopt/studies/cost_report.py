"""The cost report: which effects a scene calls for, what called for each, and what each costs."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from time import perf_counter

from camopt.effects import EFFECTS, Case, called, lacking
from camopt.problem.problem import Problem, resolve
from camopt.problem.rows import Rows
from camopt.quantities import EVERYTHING, QUANTITIES
from camopt.scene.scene import Scene
from camopt.studies.accuracy.subjects import designs_of
from camopt.verdicts.judging import extended

RUNS = 3


@dataclass(frozen=True)
class Entry:
    """One effect that runs."""

    effect: str
    called_by: tuple[str, ...]
    """Limits, objectives, outputs and effects that ask for its quantities."""
    reads: tuple[str, ...]
    """Quantities of other effects, or of its own pitch curves."""
    writes: tuple[str, ...]
    ns_per_design: float
    share: float
    """Of the time of all effects."""


@dataclass(frozen=True)
class CostReport:
    """What runs, in order; what does not, with the keys that the scene would have to give for it."""

    scene: Scene
    designs: int
    entries: tuple[Entry, ...]
    idle: dict[str, tuple[str, ...]]


def cost_report(scene: Scene) -> CostReport:
    """Measure every effect that a scene calls for, on up to 4096 designs of its space, one thread.

    A scene without a space has its own design with sizes varied a little. Times are the least of a few runs,
    compilation apart.
    """
    problem = resolve(scene)
    setup, designs = problem.setup, designs_of(problem)
    rows, times = Rows({}, len(designs)), {}
    asked = called(problem.wanted, setup)
    for name, names in asked.items():
        case = Case(setup, problem.programme, designs)
        rows, times[name] = _timed(partial(extended, rows, case, EFFECTS[name], frozenset(names)))
    whole = sum(times.values())
    entries = tuple(
        Entry(
            name,
            tuple(_callers(problem, asked, names)),
            EFFECTS[name].reads(setup),
            tuple(n for n in QUANTITIES if n in names),
            times[name] / len(designs) * 1e9,
            times[name] / whole,
        )
        for name, names in asked.items()
    )
    lacks = lacking(setup)
    idle = {}
    for name, effect in EFFECTS.items():
        offers = effect.offers(setup)
        if name not in asked and offers:
            keys = [lacks.get(quantity, ()) for quantity in offers]
            idle[name] = () if () in keys else min(keys, key=len)
    return CostReport(scene, len(designs), entries, idle)


def _timed(work: Callable[[], Rows]) -> tuple[Rows, float]:
    """What some work gives, and the least time of a few runs in seconds, the first of them apart."""
    found, times = work(), []
    for _ in range(RUNS):
        start = perf_counter()
        work()
        times.append(perf_counter() - start)
    return found, min(times)


def _callers(problem: Problem, asked: dict[str, set[str]], names: set[str]) -> list[str]:
    """What asks for any of some quantities."""
    scene, search = problem.scene, problem.scene.search
    found = [f"limits.{limit.name}" for limit in problem.limits if names & set(limit.needs)]
    for key, objectives in (("search.minimise", search.minimise), ("search.maximise", search.maximise)):
        found += [f"{key} {name}" for name in objectives if name in names]
    effect = QUANTITIES[next(iter(names))].effect
    found += [f"outputs {name}" for name in scene.outputs if name in (*names, effect, EVERYTHING)]
    if not scene.outputs and names & (problem.wanted - problem.needed):
        found.append("the default outputs (motion and geometry)")
    found += [f"effect {name}" for name in asked if set(EFFECTS[name].reads(problem.setup)) & names]
    return found

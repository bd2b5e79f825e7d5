"""The cost report: which effects a scene calls for, what called for each, and what each costs."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from time import perf_counter

from camopt.effects import EFFECTS, Case, lacking
from camopt.problem.problem import resolve
from camopt.problem.rows import Rows
from camopt.scene.scene import Scene
from camopt.studies.accuracy.subjects import designs_of
from camopt.studies.called import Called, what_runs
from camopt.verdicts.judging import extended

RUNS = 3


@dataclass(frozen=True)
class Entry(Called):
    """One effect that runs, and what it costs."""

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
    asked = what_runs(problem)
    for each in asked:
        case = Case(setup, problem.programme, designs)
        rows, times[each.effect] = _timed(
            partial(extended, rows, case, EFFECTS[each.effect], frozenset(each.writes))
        )
    whole = sum(times.values())
    entries = tuple(
        Entry(**vars(each), ns_per_design=time / len(designs) * 1e9, share=time / whole)
        for each, time in ((each, times[each.effect]) for each in asked)
    )
    lacks = lacking(setup)
    idle = {}
    for name, effect in EFFECTS.items():
        offers = effect.offers(setup)
        if name not in times and offers:
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

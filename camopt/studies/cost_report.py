"""The cost report: which effects a scene calls for, what called for each, and what each costs."""

from dataclasses import dataclass
from functools import partial

from camopt.effects import EFFECTS, Case, lacking
from camopt.mechanisms import Designs
from camopt.mistakes import BadInput
from camopt.numerics.clock import timed
from camopt.problem.problem import Problem, resolve
from camopt.problem.rows import Rows
from camopt.scene.scene import Scene
from camopt.smallest.sized import sized
from camopt.studies.accuracy.subjects import designs_of
from camopt.studies.called import Called, what_runs
from camopt.verdicts.running import extended

COST_RUNS = 3


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

    A scene without a space has its own design with sizes varied a little, and one whose sizes only ``optimise``
    finds has the smallest cam so. Times are the least of a few runs, compilation apart.

    Raises
    ------
    BadInput, Unmet
        As ``optimise``, where the scene leaves a size open that no sweep has.
    """
    problem, designs = _timed_on(scene)
    setup, asked = problem.setup, what_runs(resolve(scene))
    rows, times = Rows({}, len(designs)), {}
    for each in asked:
        case = Case(setup, problem.programme, designs)
        work = partial(extended, rows, case, EFFECTS[each.effect], frozenset(each.writes))
        rows, times[each.effect] = timed(work, COST_RUNS)
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


def _timed_on(scene: Scene) -> tuple[Problem, Designs]:
    """What effects are timed on: the designs of a sweep, or, of a scene for ``optimise``, those near one cam."""
    problem = resolve(scene)
    try:
        return problem, designs_of(problem)
    except BadInput:
        one = resolve(sized(scene).replace(search=None))
        return one, designs_of(one)

"""Which effects a scene calls for, what called for each, and what each costs."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from camopt.core.mistakes import BadInput
from camopt.core.numerics.clock import time_runs
from camopt.core.quantities import EVERYTHING, in_column_order
from camopt.core.quantities.own_quantity import OWN_EFFECT
from camopt.core.quantities.unit_systems import shown_unit
from camopt.model.effects import (
    EFFECTS,
    EvaluationBlock,
    missing_keys_by_quantity,
    plan_effects,
    require_effect,
    setup_effects,
)
from camopt.model.mechanisms import Designs
from camopt.scene.numbers_with_units import numbers_with_units
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.problem.rows import DesignRows
from camopt.scene.scene import Scene
from camopt.show.studies.accuracy.subjects import designs_of
from camopt.solve.smallest.complete_scene import with_all_sizes
from camopt.solve.tables.result import Branch, Result
from camopt.solve.verdicts.effect_runs import with_effect
from camopt.solve.verdicts.evaluation import scene_number_text


@dataclass(frozen=True)
class EffectRun:
    """One effect that runs."""

    effect: str
    called_by: tuple[str, ...]
    """Limits, objectives, outputs and effects that ask for its quantities."""
    reads: tuple[str, ...]
    """Quantities of other effects."""
    writes: tuple[str, ...]


def effects_run(problem: Problem) -> list[EffectRun]:
    """The effects that a scene calls for, in the order in which they run."""
    asked, effects = plan_effects(problem.evaluated_quantities, problem.setup), setup_effects(problem.setup)
    return [
        EffectRun(
            name,
            tuple(_effect_callers(problem, asked, names)),
            tuple(quantity for quantity in effects[name].reads(problem.setup) if quantity not in names),
            tuple(in_column_order(names)),
        )
        for name, names in asked.items()
    ]


def _effect_callers(problem: Problem, asked: Mapping[str, frozenset[str]], names: frozenset[str]) -> list[str]:
    """What asks for any of some quantities."""
    found = [f"limits.{limit.name}" for limit in problem.limits if names & set(limit.required_quantities)]
    signs = problem.objectives.items()
    found += [f"search.{'minimise' if sign > 0 else 'maximise'} {name}" for name, sign in signs if name in names]
    effect = require_effect(next(iter(names)), problem.setup).name
    own = problem.setup.own_quantities.keys()
    found += [f"outputs {name}" for name in problem.outputs if name in (*names, effect, EVERYTHING)]
    found += [f"{OWN_EFFECT}.{name}" for name in own if name in names]
    if not problem.outputs and names & (problem.evaluated_quantities - problem.required_quantities - own):
        found.append("the default outputs (motion and geometry)")
    others = {name: each for name, each in setup_effects(problem.setup).items() if name in asked and name != effect}
    found += [f"effect {name}" for name, each in others.items() if set(each.reads(problem.setup)) & names]
    return found


COST_RUNS = 3


@dataclass(frozen=True)
class EffectCost(EffectRun):
    """One effect that runs, and what it costs."""

    ns_per_design: float
    share: float
    """Of the time of all effects."""


@dataclass(frozen=True)
class CostReport(Result):
    """What runs, in order; what does not, with the keys that the scene would have to give for it."""

    scene: Scene
    designs: int
    entries: tuple[EffectCost, ...]
    idle: dict[str, tuple[str, ...]]
    main_rows: ClassVar[str] = "effects"

    def sections(self) -> tuple[Branch]:
        """The effects that run as a tree, what called for each, and what it costs."""
        branches: list[Branch] = []
        if read := numbers_with_units(self.scene):
            given = (f"{each.key} = {scene_number_text(each)} {shown_unit(each.unit)}".rstrip() for each in read)
            branches.append(Branch.from_texts("read from the scene", *given))
        for entry in self.entries:
            lines = [f"called for by {', '.join(entry.called_by)}"]
            lines += [f"reads {', '.join(entry.reads)}"] if entry.reads else []
            lines += [f"writes {', '.join(entry.writes)}"]
            cost = f"{entry.ns_per_design:,.0f} ns per design, {entry.share:.1%}"
            branches.append(Branch.from_texts(f"{entry.effect}  {cost}", *lines))
        for name, keys in self.idle.items():
            needs = f", and needs {', '.join(keys)}" if keys else ""
            branches.append(Branch.from_texts(f"{name}  not called for{needs}"))
        whole = sum(entry.ns_per_design for entry in self.entries)
        head = f"{self.scene.name}: {whole:,.0f} ns per design, over {self.designs:,} designs, one thread"
        return (Branch.from_texts(head, *branches),)

    def document(self) -> dict[str, Any]:
        """A record for each effect that runs, and the effects that nothing called for."""
        entries = [{**vars(entry), "share": round(entry.share, 6)} for entry in self.entries]
        return {"scene": self.scene.name, "effects": entries, "not_called_for": self.idle}


def cost_report(scene: Scene) -> CostReport:
    """Measure every effect that a scene calls for, on up to 4096 designs of its space, one thread.

    A scene without a space has its own design with sizes varied a little, and one whose sizes only ``optimise``
    finds has the smallest cam so. Times are the least of a few runs, compilation apart.

    Raises
    ------
    BadInput, Unmet
        As ``optimise``, where the scene leaves a size open that no sweep has.
    """
    problem, designs = _timing_designs(scene)
    setup, asked = problem.setup, effects_run(resolve(scene))
    rows, times = DesignRows({}, len(designs)), {}
    for each in asked:
        case = EvaluationBlock(setup, problem.programme, designs)
        work = partial(with_effect, rows, case, setup_effects(setup)[each.effect], frozenset(each.writes))
        rows, times[each.effect] = time_runs(work, COST_RUNS)
    whole = sum(times.values())
    entries = tuple(
        EffectCost(**vars(each), ns_per_design=time / len(designs) * 1e9, share=time / whole)
        for each, time in ((each, times[each.effect]) for each in asked)
    )
    lacks = missing_keys_by_quantity(setup)
    idle = {}
    for name, effect in EFFECTS.items():
        offers = effect.offers(setup)
        if name not in times and offers:
            keys = [lacks.get(quantity, ()) for quantity in offers]
            idle[name] = () if () in keys else min(keys, key=len)
    return CostReport(scene, len(designs), entries, idle)


def _timing_designs(scene: Scene) -> tuple[Problem, Designs]:
    """What effects are timed on: the designs of a sweep, or, of a scene for ``optimise``, those near one cam."""
    problem = resolve(scene)
    try:
        return problem, designs_of(problem)
    except BadInput:
        one = resolve(with_all_sizes(scene).replace(search=None))
        return one, designs_of(one)

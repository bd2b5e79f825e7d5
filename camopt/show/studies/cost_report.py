"""The effects that a scene needs: why each runs, and its computing time."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from camopt.core.mistakes import BadInput
from camopt.core.numerics.clock import time_runs
from camopt.core.quantities import EVERYTHING, in_column_order
from camopt.core.quantities.own_quantity import OWN_EFFECT
from camopt.core.quantities.unit_systems import unit_in_shown_system
from camopt.model.effects import (
    EFFECTS,
    EvaluationBlock,
    missing_keys_by_quantity,
    quantities_to_compute_by_effect,
    require_effect,
    setup_effects,
)
from camopt.scene.numbers_with_units import numbers_with_units
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.problem.rows import DesignRows
from camopt.scene.scene import Scene
from camopt.show.studies.accuracy.subjects import random_designs
from camopt.solve.smallest.optimise import with_all_sizes
from camopt.solve.tables.result import Branch, Result
from camopt.solve.verdicts.effect_runs import with_quantities_of_effect
from camopt.solve.verdicts.evaluation import scene_number_text


@dataclass(frozen=True)
class EffectRun:
    """An effect that runs."""

    effect: str
    called_by: tuple[str, ...]
    """Limits, objectives, outputs and effects that need its quantities."""
    reads: tuple[str, ...]
    """Quantities of other effects that it reads."""
    writes: tuple[str, ...]


def needed_effect_runs(problem: Problem) -> list[EffectRun]:
    """The effects that a scene needs, in the order in which they run."""
    planned, effects = (
        quantities_to_compute_by_effect(problem.evaluated_quantities, problem.setup),
        setup_effects(problem.setup),
    )
    return [
        EffectRun(
            name,
            tuple(_effect_callers(problem, planned, names)),
            tuple(quantity for quantity in effects[name].input_quantities(problem.setup) if quantity not in names),
            tuple(in_column_order(names)),
        )
        for name, names in planned.items()
    ]


def _effect_callers(
    problem: Problem, planned: Mapping[str, frozenset[str]], effect_quantities: frozenset[str]
) -> list[str]:
    """The limits, objectives, outputs and effects that need any of these quantities."""
    callers = [
        f"limits.{limit.name}" for limit in problem.limits if effect_quantities & set(limit.required_quantities)
    ]
    callers += [
        f"search.{'minimise' if sign > 0 else 'maximise'} {name}"
        for name, sign in problem.objectives.items()
        if name in effect_quantities
    ]
    effect = require_effect(next(iter(effect_quantities)), problem.setup).name
    own = problem.setup.own_quantities.keys()
    callers += [f"outputs {name}" for name in problem.outputs if name in (*effect_quantities, effect, EVERYTHING)]
    callers += [f"{OWN_EFFECT}.{name}" for name in own if name in effect_quantities]
    if not problem.outputs and effect_quantities & (
        problem.evaluated_quantities - problem.required_quantities - own
    ):
        callers.append("the default outputs (motion and geometry)")
    for name, each in setup_effects(problem.setup).items():
        reads = effect_quantities.intersection(each.input_quantities(problem.setup))
        callers += [f"effect {name}"] if name in planned and name != effect and reads else []
    return callers


COST_RUNS = 3


@dataclass(frozen=True)
class EffectCost(EffectRun):
    """An effect that runs, with its computing time."""

    ns_per_design: float
    share: float
    """Share of the time of all effects."""


@dataclass(frozen=True)
class CostReport(Result):
    """Effects that run, in order; and idle effects, with the keys that they need in the scene."""

    scene: Scene
    designs: int
    entries: tuple[EffectCost, ...]
    idle: dict[str, tuple[str, ...]]
    main_rows: ClassVar[str] = "effects"

    def sections(self) -> tuple[Branch]:
        """A tree of the effects, with the reasons why they run, and their times."""
        branches: list[Branch] = []
        if read := numbers_with_units(self.scene):
            inputs = (
                f"{each.key} = {scene_number_text(each)} {unit_in_shown_system(each.unit)}".rstrip()
                for each in read
            )
            branches.append(Branch.from_texts("read from the scene", *inputs))
        for entry in self.entries:
            reads = [f"reads {', '.join(entry.reads)}"] if entry.reads else []
            lines = [f"needed by {', '.join(entry.called_by)}", *reads, f"writes {', '.join(entry.writes)}"]
            cost = f"{entry.ns_per_design:,.0f} ns per design, {entry.share:.1%}"
            branches.append(Branch.from_texts(f"{entry.effect}  {cost}", *lines))
        for name, keys in self.idle.items():
            needs = f"; needs {', '.join(keys)} in the scene" if keys else ""
            branches.append(Branch.from_texts(f"{name}  not run{needs}"))
        whole = sum(entry.ns_per_design for entry in self.entries)
        head = f"{self.scene.name}: {whole:,.0f} ns per design, over {self.designs:,} designs, one thread"
        return (Branch.from_texts(head, *branches),)

    def values_for_json(self) -> dict[str, Any]:
        """A record for each effect that runs, and the idle effects with the keys that they need."""
        entries = [{**vars(entry), "share": round(entry.share, 6)} for entry in self.entries]
        return {"scene": self.scene.name, "effects": entries, "not_called_for": self.idle}


def cost_report(scene: Scene) -> CostReport:
    """Measure the time of each effect of a scene, on up to 4096 designs of its search space, in one thread.

    Without a search space, the sizes of the scene's design are varied a little. If only ``optimise`` can find the
    sizes, those of the smallest cam are varied. Times are the smallest of a few runs, without compilation.

    Raises
    ------
    BadInput, Unmet
        As ``optimise``, if the scene lacks a size that it does not sweep.
    """
    problem = resolve(scene)
    try:
        designs = random_designs(problem)
    except BadInput:  # the scene has neither sizes nor a sweep
        problem = resolve(with_all_sizes(scene).replace(search=None))
        designs = random_designs(problem)
    setup, planned = problem.setup, needed_effect_runs(resolve(scene))
    rows, times = DesignRows({}, len(designs)), {}
    for each in planned:
        case = EvaluationBlock(setup, problem.programme, designs)
        work = partial(
            with_quantities_of_effect, rows, case, setup_effects(setup)[each.effect], frozenset(each.writes)
        )
        rows, times[each.effect] = time_runs(work, COST_RUNS)
    whole = sum(times.values())
    entries = tuple(
        EffectCost(**vars(each), ns_per_design=time / len(designs) * 1e9, share=time / whole)
        for each, time in ((each, times[each.effect]) for each in planned)
    )
    missing = missing_keys_by_quantity(setup)
    idle = {}
    for name, effect in EFFECTS.items():
        offers = effect.applicable_quantities(setup)
        if name not in times and offers:
            keys = [missing.get(quantity, ()) for quantity in offers]
            idle[name] = () if () in keys else min(keys, key=len)
    return CostReport(scene, len(designs), entries, idle)

"""Which effects a scene calls for, what called for each, and what each costs."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from camopt.core.mistakes import BadInput
from camopt.core.numerics.clock import timed
from camopt.core.quantities import EVERYTHING, in_order
from camopt.core.quantities.own import OWN
from camopt.core.quantities.unit_systems import shown_unit
from camopt.model.effects import EFFECTS, Case, effect_of, effects_needed, effects_of, lacking
from camopt.model.mechanisms import Designs
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.problem.rows import Rows
from camopt.scene.read import numbers_read
from camopt.scene.scene import Scene
from camopt.show.studies.accuracy.subjects import designs_of
from camopt.solve.smallest.sized import sized
from camopt.solve.tables.result import Branch, Result
from camopt.solve.verdicts.evaluation import as_read
from camopt.solve.verdicts.running import extended


@dataclass(frozen=True)
class Called:
    """One effect that runs."""

    effect: str
    called_by: tuple[str, ...]
    """Limits, objectives, outputs and effects that ask for its quantities."""
    reads: tuple[str, ...]
    """Quantities of other effects."""
    writes: tuple[str, ...]


def what_runs(problem: Problem) -> list[Called]:
    """The effects that a scene calls for, in the order in which they run."""
    asked, effects = effects_needed(problem.wanted, problem.setup), effects_of(problem.setup)
    return [
        Called(
            name,
            tuple(_callers(problem, asked, names)),
            tuple(quantity for quantity in effects[name].reads(problem.setup) if quantity not in names),
            tuple(in_order(names)),
        )
        for name, names in asked.items()
    ]


def _callers(problem: Problem, asked: Mapping[str, frozenset[str]], names: frozenset[str]) -> list[str]:
    """What asks for any of some quantities."""
    found = [f"limits.{limit.name}" for limit in problem.limits if names & set(limit.needs)]
    signs = problem.objectives.items()
    found += [f"search.{'minimise' if sign > 0 else 'maximise'} {name}" for name, sign in signs if name in names]
    effect = effect_of(next(iter(names)), problem.setup).name
    own = problem.setup.own.keys()
    found += [f"outputs {name}" for name in problem.outputs if name in (*names, effect, EVERYTHING)]
    found += [f"{OWN}.{name}" for name in own if name in names]
    if not problem.outputs and names & (problem.wanted - problem.needed - own):
        found.append("the default outputs (motion and geometry)")
    others = {name: each for name, each in effects_of(problem.setup).items() if name in asked and name != effect}
    found += [f"effect {name}" for name, each in others.items() if set(each.reads(problem.setup)) & names]
    return found


COST_RUNS = 3


@dataclass(frozen=True)
class Entry(Called):
    """One effect that runs, and what it costs."""

    ns_per_design: float
    share: float
    """Of the time of all effects."""


@dataclass(frozen=True)
class CostReport(Result):
    """What runs, in order; what does not, with the keys that the scene would have to give for it."""

    scene: Scene
    designs: int
    entries: tuple[Entry, ...]
    idle: dict[str, tuple[str, ...]]
    main_rows: ClassVar[str] = "effects"

    def sections(self) -> tuple[Branch]:
        """The effects that run as a tree, what called for each, and what it costs."""
        branches: list[Branch] = []
        if read := numbers_read(self.scene):
            given = (f"{each.key} = {as_read(each)} {shown_unit(each.unit)}".rstrip() for each in read)
            branches.append(Branch.of("read from the scene", *given))
        for entry in self.entries:
            lines = [f"called for by {', '.join(entry.called_by)}"]
            lines += [f"reads {', '.join(entry.reads)}"] if entry.reads else []
            lines += [f"writes {', '.join(entry.writes)}"]
            cost = f"{entry.ns_per_design:,.0f} ns per design, {entry.share:.1%}"
            branches.append(Branch.of(f"{entry.effect}  {cost}", *lines))
        for name, keys in self.idle.items():
            needs = f", and needs {', '.join(keys)}" if keys else ""
            branches.append(Branch.of(f"{name}  not called for{needs}"))
        whole = sum(entry.ns_per_design for entry in self.entries)
        head = f"{self.scene.name}: {whole:,.0f} ns per design, over {self.designs:,} designs, one thread"
        return (Branch.of(head, *branches),)

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
    problem, designs = _timed_on(scene)
    setup, asked = problem.setup, what_runs(resolve(scene))
    rows, times = Rows({}, len(designs)), {}
    for each in asked:
        case = Case(setup, problem.programme, designs)
        work = partial(extended, rows, case, effects_of(setup)[each.effect], frozenset(each.writes))
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

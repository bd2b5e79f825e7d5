"""Which effects a scene calls for, and what called for each."""

from collections.abc import Mapping
from dataclasses import dataclass

from camopt.effects import effect_of, effects_needed, effects_of
from camopt.problem.problem import Problem
from camopt.quantities import EVERYTHING, in_order
from camopt.quantities.own import OWN


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

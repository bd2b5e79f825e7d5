"""Which effects a scene calls for, and what called for each."""

from collections.abc import Mapping
from dataclasses import dataclass

from camopt.effects import EFFECTS, effects_needed
from camopt.problem.problem import Problem
from camopt.quantities import EVERYTHING, QUANTITIES, in_order


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
    asked = effects_needed(problem.wanted, problem.setup)
    return [
        Called(
            name,
            tuple(_callers(problem, asked, names)),
            tuple(quantity for quantity in EFFECTS[name].reads(problem.setup) if quantity not in names),
            tuple(in_order(names)),
        )
        for name, names in asked.items()
    ]


def _callers(problem: Problem, asked: Mapping[str, frozenset[str]], names: frozenset[str]) -> list[str]:
    """What asks for any of some quantities."""
    found = [f"limits.{limit.name}" for limit in problem.limits if names & set(limit.needs)]
    signs = problem.objectives.items()
    found += [f"search.{'minimise' if sign > 0 else 'maximise'} {name}" for name, sign in signs if name in names]
    effect = QUANTITIES[next(iter(names))].effect
    found += [f"outputs {name}" for name in problem.outputs if name in (*names, effect, EVERYTHING)]
    if not problem.outputs and names & (problem.wanted - problem.needed):
        found.append("the default outputs (motion and geometry)")
    others = (name for name in asked if name != effect)
    found += [f"effect {name}" for name in others if set(EFFECTS[name].reads(problem.setup)) & names]
    return found

"""Quantities that sizes or the motion decide, over boxes of designs: by arithmetic on ranges."""

from camopt.model.effects import Case, Effect, Setup
from camopt.model.effects.case import Bounded
from camopt.model.mechanisms import Designs
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.rows import Columns
from camopt.solve.verdicts.running import planned


def is_ranged(effect: Effect, setup: Setup) -> bool:
    """Whether an effect runs on ranges of what designs bring."""
    return effect.is_of_sizes or (effect.is_of_motion(setup) and not setup.free)


def ranged(problem: Problem, names: set[str], designs: Designs, side: float = 0.0) -> Columns:
    """Quantities that sizes or the motion decide, of designs of numbers or of ranges.

    At side −1 they are the near sides of their enclosures.
    """
    case, found = Case(problem.setup, problem.programme, designs), {}
    for effect, wanted in planned(frozenset(names), problem.setup):
        for name, value in {**effect.of_pitch(case, wanted), **effect.run(case, wanted)}.items():
            found[name] = value.value + side * value.outward if isinstance(value, Bounded) else value
    return found

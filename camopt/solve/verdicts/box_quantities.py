"""Quantities that sizes or the motion decide, over boxes of designs: by arithmetic on ranges."""

from camopt.model.effects import Effect, EvaluationBlock, Setup
from camopt.model.effects.effect import EnclosedValue
from camopt.model.mechanisms import Designs
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.rows import QuantityColumns
from camopt.solve.verdicts.effect_runs import effect_plan


def runs_on_ranges(effect: Effect, setup: Setup) -> bool:
    """Whether an effect runs on ranges of what designs bring."""
    return effect.is_of_sizes or (effect.is_of_motion(setup) and not setup.free)


def quantities_over_box(problem: Problem, names: set[str], designs: Designs, side: float = 0.0) -> QuantityColumns:
    """Quantities that sizes or the motion decide, of designs of numbers or of ranges.

    At side −1 they are the near sides of their enclosures.
    """
    case, found = EvaluationBlock(problem.setup, problem.programme, designs), {}
    for effect, wanted in effect_plan(frozenset(names), problem.setup):
        for name, value in {**effect.run_on_pitch(case, wanted), **effect.run(case, wanted)}.items():
            found[name] = value.value + side * value.outward if isinstance(value, EnclosedValue) else value
    return found

"""Quantities that depend only on sizes or only on the motion, over boxes of designs, by interval arithmetic."""

from camopt.model.effects import Effect, EvaluationBlock, Setup
from camopt.model.effects.effect import EnclosedValue
from camopt.model.mechanisms import Designs
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.rows import QuantityColumns
from camopt.solve.verdicts.effect_runs import effect_plan


def can_effect_run_on_ranges(effect: Effect, setup: Setup) -> bool:
    """Whether an effect can run on designs whose numbers are ranges."""
    return effect.is_of_sizes or (effect.is_of_motion(setup) and not setup.free)


def quantities_over_box(
    problem: Problem, names: set[str], designs: Designs, enclosure_side: float = 0.0
) -> QuantityColumns:
    """Quantities of designs of numbers or ranges; at side −1, the near sides of their enclosures."""
    case, quantities = EvaluationBlock(problem.setup, problem.programme, designs), {}
    for effect, wanted in effect_plan(frozenset(names), problem.setup):
        for name, value in {
            **effect.evaluate_pitch_curve_columns(case, wanted),
            **effect.evaluate_columns(case, wanted),
        }.items():
            quantities[name] = (
                value.value + enclosure_side * value.outward if isinstance(value, EnclosedValue) else value
            )
    return quantities

"""Run the effects that some quantities need, in their order; an effect may read the columns of those before it."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from camopt.model.effects import Effect, EvaluationBlock, Setup, quantities_to_compute_by_effect, setup_effects
from camopt.model.effects.effect import EnclosedValue, no_columns
from camopt.model.mechanisms import Designs
from camopt.scene.problem.limit import Limit, quantities_of_limits
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.rows import DesignRows, QuantityColumns


def run_effects(case: EvaluationBlock, wanted_quantities: Iterable[str]) -> DesignRows:
    """Wanted quantities of a block of designs."""
    wanted_quantities, rows = frozenset(wanted_quantities), DesignRows({}, len(case.designs))
    for effect, names in effect_plan(wanted_quantities, case.setup):
        rows = with_quantities_of_effect(rows, case, effect, names)
    return rows.select_columns(wanted_quantities)


def columns_for_limits(problem: Problem, limits: Iterable[Limit], designs: Designs) -> QuantityColumns:
    """Quantities of designs that some limits need."""
    return run_effects(
        EvaluationBlock(problem.setup, problem.programme, designs), quantities_of_limits(limits)
    ).columns


def effect_plan(wanted_quantities: frozenset[str], setup: Setup) -> list[tuple[Effect, frozenset[str]]]:
    """Effects to run, each with the quantities that are wanted or that another effect reads."""
    effects = setup_effects(setup)
    return [
        (effects[name], frozenset(names))
        for name, names in quantities_to_compute_by_effect(wanted_quantities, setup).items()
    ]


def can_effect_run_on_ranges(effect: Effect, setup: Setup) -> bool:
    """Whether an effect can run on designs whose numbers are ranges."""
    return effect.is_of_sizes or (effect.is_of_motion(setup) and not setup.free)


def quantities_over_box(
    problem: Problem, names: set[str], designs: Designs, enclosure_side: float = 0.0
) -> QuantityColumns:
    """Quantities of designs of numbers or ranges; at side −1, the near sides of their enclosures.

    They depend only on sizes or only on the motion, so that interval arithmetic bounds them.
    """
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


def with_quantities_of_effect(
    rows: DesignRows, case: EvaluationBlock, effect: Effect, quantity_names: frozenset[str]
) -> DesignRows:
    """Add some quantities of one more effect to the rows; the effect may read the columns of the rows."""
    return with_values_beyond_pitch_curves(
        with_pitch_curve_values_of_designs(rows, case, effect, quantity_names), case, effect, quantity_names
    )


def with_pitch_curve_values_of_designs(
    rows: DesignRows, case: EvaluationBlock, effect: Effect, quantity_names: frozenset[str]
) -> DesignRows:
    """Add an effect's quantities that depend only on pitch curves; equal bits for designs with the same curve."""
    if effect.evaluate_pitch_curve_columns is no_columns:
        return rows
    return with_values_of_distinct_pitch_curves(
        rows, replace(case, designs=case.setup.mechanism.pitch(case.designs)), effect, quantity_names
    )


def with_values_of_distinct_pitch_curves(
    rows: DesignRows, case: EvaluationBlock, effect: Effect, quantity_names: frozenset[str]
) -> DesignRows:
    """Add an effect's quantities of pitch curves to rows of one design for each curve."""
    return (
        rows
        if effect.evaluate_pitch_curve_columns is no_columns
        else with_values_and_enclosures(
            rows, effect.evaluate_pitch_curve_columns(case, quantity_names), quantity_names
        )
    )


def with_values_beyond_pitch_curves(
    rows: DesignRows, case: EvaluationBlock, effect: Effect, quantity_names: frozenset[str]
) -> DesignRows:
    """Add an effect's quantities that need more than pitch curves."""
    if effect.evaluate_columns is no_columns:
        return rows
    return with_values_and_enclosures(
        rows,
        effect.evaluate_columns(replace(case, columns=rows.columns, outward=rows.outward), quantity_names),
        quantity_names,
    )


def with_values_and_enclosures(
    rows: DesignRows, values: dict[str, Any], wanted_quantities: frozenset[str]
) -> DesignRows:
    """Add the wanted quantities of an effect to the rows, with their enclosures."""
    columns, outward, half_width = dict(rows.columns), dict(rows.outward), rows.half_width
    widths = dict[int, tuple[Any, Any]]()  # largest width for each scale
    for name in (n for n in values if n in wanted_quantities):
        columns[name] = values[name]
        if isinstance(values[name], EnclosedValue):
            columns[name], width, scale = values[name]
            outward[name] = np.where(np.isinf(columns[name]), 0.0, width)  # ∞ − ∞ is no width
            _, most = widths.get(id(scale), (scale, 0.0))
            widths[id(scale)] = scale, np.maximum(most, np.abs(outward[name]))
    for scale, width in widths.values():
        # relative to the scale; to 1 where the scale is 0, or both are infinite
        least, most = (extreme.reduce(scale, axis=None, initial=1.0) for extreme in (np.minimum, np.maximum))
        if not 0.0 < least <= most < np.inf:
            scale = np.where((scale > 0.0) & ~(np.isinf(scale) & np.isinf(width)), scale, 1.0)
        half_width = np.maximum(half_width, width / scale)
    return DesignRows(columns, rows.count, outward, half_width)

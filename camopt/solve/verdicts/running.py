"""Effects on designs: those that are needed run in their order, each on the rows of those before it."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from camopt.model.effects import Case, Effect, Setup, effects_needed, effects_of
from camopt.model.effects.case import Bounded, nothing
from camopt.model.mechanisms import Designs
from camopt.scene.problem.limit import Limit, needs_of
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.rows import Columns, Rows


def run_effects(case: Case, wanted: Iterable[str]) -> Rows:
    """The wanted quantities of a block of designs."""
    wanted, rows = frozenset(wanted), Rows({}, len(case.designs))
    for effect, names in planned(wanted, case.setup):
        rows = extended(rows, case, effect, names)
    return rows.only(wanted)


def columns_for(problem: Problem, limits: Iterable[Limit], designs: Designs) -> Columns:
    """The quantities of designs that some limits call for."""
    return run_effects(Case(problem.setup, problem.programme, designs), needs_of(limits)).columns


def planned(wanted: frozenset[str], setup: Setup) -> list[tuple[Effect, frozenset[str]]]:
    """The effects to run, each with the quantities to keep: those wanted, and those that another effect reads."""
    effects = effects_of(setup)
    return [(effects[name], frozenset(names)) for name, names in effects_needed(wanted, setup).items()]


def extended(rows: Rows, case: Case, effect: Effect, names: frozenset[str]) -> Rows:
    """The rows of a case with some quantities of one more effect, which may read those that the rows have."""
    return beyond_pitch(with_pitch_values(rows, case, effect, names), case, effect, names)


def with_pitch_values(rows: Rows, case: Case, effect: Effect, names: frozenset[str]) -> Rows:
    """The rows of a case with what one more effect finds of pitch curves, the same bits for all that share one."""
    if effect.of_pitch is nothing:
        return rows
    return of_curves(rows, replace(case, designs=case.setup.mechanism.pitch(case.designs)), effect, names)


def of_curves(rows: Rows, case: Case, effect: Effect, names: frozenset[str]) -> Rows:
    """The same of designs that are drawn by a point, one of each curve."""
    return rows if effect.of_pitch is nothing else with_found(rows, effect.of_pitch(case, names), names)


def beyond_pitch(rows: Rows, case: Case, effect: Effect, names: frozenset[str]) -> Rows:
    """The rows of a case with what one more effect finds beyond that of pitch curves."""
    if effect.run is nothing:
        return rows
    return with_found(rows, effect.run(replace(case, found=rows.columns, outward=rows.outward), names), names)


def with_found(rows: Rows, found: dict[str, Any], wanted: frozenset[str]) -> Rows:
    """Rows with the wanted ones of an effect's quantities."""
    columns, outward, half_width = dict(rows.columns), dict(rows.outward), rows.half_width
    widths = dict[int, tuple[Any, Any]]()  # the largest of those that refer to one scale
    for name in (n for n in found if n in wanted):
        columns[name] = found[name]
        if isinstance(found[name], Bounded):
            columns[name], width, scale = found[name]
            outward[name] = np.where(np.isinf(columns[name]), 0.0, width)  # ∞ − ∞ is no width
            _, most = widths.get(id(scale), (scale, 0.0))
            widths[id(scale)] = scale, np.maximum(most, np.abs(outward[name]))
    for scale, width in widths.values():
        half_width = np.maximum(half_width, _relative(width, scale))
    return Rows(columns, rows.count, outward, half_width)


def _relative(width: Any, scale: Any) -> Any:
    """Widths relative to their scale; to 1 where that is 0, or infinite as they are."""
    least, most = (of.reduce(scale, axis=None, initial=1.0) for of in (np.minimum, np.maximum))
    if not 0.0 < least <= most < np.inf:
        scale = np.where((scale > 0.0) & ~(np.isinf(scale) & np.isinf(width)), scale, 1.0)
    return width / scale

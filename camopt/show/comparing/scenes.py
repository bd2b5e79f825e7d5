"""Compares two scenes: settings that differ, and quantities that differ if both are cams."""

from math import isfinite
from typing import Any, NamedTuple

from camopt.core.quantities import in_column_order
from camopt.scene.mapping import leaf_values_by_key
from camopt.scene.problem.problem import missing_variable_mistakes, resolve
from camopt.scene.scene import SCENE_TABLES, Scene
from camopt.scene.units import tables_in_shown_units, tables_with_units_for_numbers
from camopt.show.comparing.designs import ERROR_BOUND
from camopt.solve.verdicts.evaluation import evaluate

Difference = tuple[Any, Any]
"""Values in A and B; None if not set."""


def scene_differences(a: Scene, b: Scene) -> dict[str, Difference]:
    """Keys in which two scenes differ, such as ``limits.pressure_angle`` and ``motion.1.angle``.

    Segments are counted from 1. A key that only one scene sets has the default of the other.
    """
    set_keys = dict.fromkeys(key for scene in (a, b) for key, _ in leaf_values_by_key(scene.to_dict()))
    one, other = (dict(leaf_values_by_key(scene.model_dump(mode="json"))) for scene in (a, b))
    pairs = {key: (one.get(key), other.get(key)) for key in set_keys}
    return {key: (mine, others) for key, (mine, others) in pairs.items() if mine != others}


def differing_settings_in_shown_units(a: Scene, b: Scene) -> dict[str, tuple[Any, Any, str]]:
    """Keys in which two scenes differ, with the values in A and B in shown units, and these units."""
    models, tables = SCENE_TABLES, [scene.model_dump(mode="json") for scene in (a, b)]
    one, other = (dict(leaf_values_by_key(tables_in_shown_units(each, models))) for each in tables)
    units = [dict(leaf_values_by_key(tables_with_units_for_numbers(each, models))) for each in tables]
    return {
        key: (one.get(key), other.get(key), " / ".join(dict.fromkeys(u[key] for u in units if u.get(key))))
        for key in scene_differences(a, b)
    }


class ValuePair(NamedTuple):
    """A quantity of two cams."""

    a: Any
    """Value in A; None if A does not compute it."""
    b: Any
    """Value in B."""
    difference: float | None
    """B less A; None if one is infinite or not a number."""


def has_all_sizes(scene: Scene) -> bool:
    """Whether a scene gives all sizes and numbers of its cam."""
    return not missing_variable_mistakes(resolve(scene))


def differing_cam_quantities(a: Scene, b: Scene) -> dict[str, ValuePair]:
    """Quantities of either scene that differ by more than the relative errors of both."""
    one, other = evaluate(a), evaluate(b)
    pairs = {
        name: (one.get(name), other.get(name)) for name in in_column_order({**one, **other}) if name != ERROR_BOUND
    }
    errors = a.accuracy.relative_error, b.accuracy.relative_error
    return {
        name: ValuePair(*pair, _numeric_difference(*pair))
        for name, pair in pairs.items()
        if _values_differ(*pair, *errors)
    }


def _are_numbers(*values: Any) -> bool:
    return all(isinstance(value, float) and isfinite(value) for value in values)


def _numeric_difference(a: Any, b: Any) -> float | None:
    return b - a if _are_numbers(a, b) else None


def _values_differ(a: Any, b: Any, relative_error_a: float, relative_error_b: float) -> bool:
    return (
        bool(abs(b - a) > relative_error_a * abs(a) + relative_error_b * abs(b)) if _are_numbers(a, b) else a != b
    )

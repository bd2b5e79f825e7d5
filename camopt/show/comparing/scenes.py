"""Compares two scenes: settings that differ, and quantities that differ if both are cams."""

from math import isfinite
from typing import Any, NamedTuple

from camopt.core.quantities import in_column_order
from camopt.scene.mapping import leaf_values_by_key
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


def differing_cam_quantities(a: Scene, b: Scene) -> dict[str, ValuePair]:
    """Quantities of either scene that differ by more than the relative errors of both."""
    one, other = evaluate(a), evaluate(b)
    found = {}
    for name in in_column_order({**one, **other}):
        x, y = one.get(name), other.get(name)
        difference: float | None = None
        differs = x != y
        if isinstance(x, float) and isinstance(y, float) and isfinite(x) and isfinite(y):
            difference = y - x
            differs = abs(difference) > a.accuracy.relative_error * abs(x) + b.accuracy.relative_error * abs(y)
        if differs and name != ERROR_BOUND:
            found[name] = ValuePair(x, y, difference)
    return found

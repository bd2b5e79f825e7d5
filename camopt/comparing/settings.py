"""Settings of two scenes, key by key."""

from typing import Any, NamedTuple

from camopt.scene.mapping import leaves
from camopt.scene.places import tables_of
from camopt.scene.scene import Scene
from camopt.scene.units import as_shown, units_shown

Difference = tuple[Any, Any]
"""What A and B have; None for what is not set."""


def differing(a: Scene, b: Scene) -> dict[str, Difference]:
    """The keys in which two scenes differ, such as ``limits.pressure_angle`` and ``motion.1.angle``.

    Segments are counted from 1. A key that one scene leaves at its default is there with the default.
    """
    set_keys = dict.fromkeys(key for scene in (a, b) for key, _ in leaves(scene.to_dict()))
    one, other = (dict(leaves(scene.model_dump(mode="json"))) for scene in (a, b))
    pairs = {key: (one.get(key), other.get(key)) for key in set_keys}
    return {key: (mine, others) for key, (mine, others) in pairs.items() if mine != others}


class Setting(NamedTuple):
    """A key in which two scenes differ, as it is shown."""

    key: str
    a: Any
    b: Any
    unit: str


def shown_settings(a: Scene, b: Scene) -> list[Setting]:
    """The keys in which two scenes differ, with numbers in the units in which results are shown."""
    models, tables = tables_of(Scene), [scene.model_dump(mode="json") for scene in (a, b)]
    one, other = (dict(leaves(as_shown(each, models))) for each in tables)
    units = [dict(leaves(units_shown(each, models))) for each in tables]
    return [
        Setting(key, one.get(key), other.get(key), " / ".join(dict.fromkeys(u[key] for u in units if u.get(key))))
        for key in differing(a, b)
    ]

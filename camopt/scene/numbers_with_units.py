"""The numbers of a scene apart from its sizes, each in the unit in which it is read."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from camopt.core.quantities import NUMBER_COLUMNS, QUANTITIES, STAGE_NUMBER_KEYS, stage_quantity
from camopt.scene.scene import Scene
from camopt.scene.speed import CRANK_SPEED_KEY, TURNS_OF_CRANK


class NumberWithUnit(NamedTuple):
    """A number of the scene, or the rows of a load: its key, its value and the unit of that."""

    key: str
    value: Any
    unit: str


def numbers_with_units(scene: Scene) -> list[NumberWithUnit]:
    """The speed, and numbers of follower, spring, load, materials and train; of what turns moments by rad."""
    names = scene.number_quantities
    given = {key: value for key, value in scene.numbers(NUMBER_COLUMNS).items() if value is not None}
    found = [NumberWithUnit(key, value, QUANTITIES[names[key]].unit) for key, value in given.items()]
    return [*_crank_speed(scene), *found, *_stage_numbers(scene)]


def _stage_numbers(scene: Scene) -> Iterator[NumberWithUnit]:
    """The lengths and angles of each stage, and what it carries."""
    for number, stage in enumerate(scene.train, start=1):
        for key, value in stage:
            if key in STAGE_NUMBER_KEYS and value is not None:
                name = stage_quantity(number, key, turns=scene.turns_after(number))
                yield NumberWithUnit(f"train.{number}.{key}", value, QUANTITIES[name].unit)


def _crank_speed(scene: Scene) -> Iterator[NumberWithUnit]:
    """The speed as it was given, if not as that of the cam."""
    if scene.by_crank and scene.cam.rpm is not None:
        yield NumberWithUnit(CRANK_SPEED_KEY, TURNS_OF_CRANK * scene.cam.rpm, "rev/min")

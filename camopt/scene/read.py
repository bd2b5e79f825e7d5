"""The numbers of a scene apart from its sizes, each in the unit in which it is read."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from camopt.core.quantities import NUMBER_COLUMNS, OF_STAGE, QUANTITIES, stage_quantity
from camopt.scene.scene import Scene
from camopt.scene.speed import OF_CRANK, TURNS_OF_CRANK


class Read(NamedTuple):
    """A number of the scene, or the rows of a load: its key, its value and the unit of that."""

    key: str
    value: Any
    unit: str


def numbers_read(scene: Scene) -> list[Read]:
    """The speed, and numbers of follower, spring, load, materials and train; of what turns moments by rad."""
    names = scene.number_quantities
    given = {key: value for key, value in scene.numbers(NUMBER_COLUMNS).items() if value is not None}
    found = [Read(key, value, QUANTITIES[names[key]].unit) for key, value in given.items()]
    return [*_speed_of_crank(scene), *found, *_of_train(scene)]


def _of_train(scene: Scene) -> Iterator[Read]:
    """The lengths and angles of each stage, and what it carries."""
    for number, stage in enumerate(scene.train, start=1):
        for key, value in stage:
            if key in OF_STAGE and value is not None:
                name = stage_quantity(number, key, turns=scene.turns_after(number))
                yield Read(f"train.{number}.{key}", value, QUANTITIES[name].unit)


def _speed_of_crank(scene: Scene) -> Iterator[Read]:
    """The speed as it was given, if not as that of the cam."""
    if scene.by_crank and scene.cam.rpm is not None:
        yield Read(OF_CRANK, TURNS_OF_CRANK * scene.cam.rpm, "rev/min")

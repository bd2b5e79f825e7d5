"""The numbers of a scene other than sizes, each in the unit of its key."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from camopt.core.quantities import NUMBER_COLUMNS, QUANTITIES, STAGE_NUMBER_KEYS, stage_quantity_name
from camopt.scene.scene import Scene
from camopt.scene.speed import CRANK_SPEED_KEY, TURNS_OF_CRANK


class NumberWithUnit(NamedTuple):
    """A number of the scene, or the rows of a load, with its unit."""

    key: str
    value: Any
    unit: str


def numbers_with_units(scene: Scene) -> list[NumberWithUnit]:
    """Speed, and numbers of follower, spring, load, materials and train; rotary stiffness is per rad."""
    names = scene.number_quantities
    given = {key: value for key, value in scene.numbers(NUMBER_COLUMNS).items() if value is not None}
    numbers = [NumberWithUnit(key, value, QUANTITIES[names[key]].unit) for key, value in given.items()]
    return [*_crank_speed(scene), *numbers, *_stage_numbers(scene)]


def _stage_numbers(scene: Scene) -> Iterator[NumberWithUnit]:
    """The lengths, angles, masses and forces of each stage."""
    for number, stage in enumerate(scene.train, start=1):
        for key, value in stage:
            if key in STAGE_NUMBER_KEYS and value is not None:
                name = stage_quantity_name(number, key, angular=scene.output_turns_after_stages(number))
                yield NumberWithUnit(f"train.{number}.{key}", value, QUANTITIES[name].unit)


def _crank_speed(scene: Scene) -> Iterator[NumberWithUnit]:
    """The speed of the crankshaft, if the scene gives that."""
    if scene.is_speed_of_crank and scene.cam.rpm is not None:
        yield NumberWithUnit(CRANK_SPEED_KEY, TURNS_OF_CRANK * scene.cam.rpm, "rev/min")

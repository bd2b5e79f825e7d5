"""The numbers of a scene other than sizes, each in the unit of its key."""

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
    numbers, names = [], scene.number_quantities
    if scene.is_speed_of_crank and scene.cam.rpm is not None:
        numbers.append(NumberWithUnit(CRANK_SPEED_KEY, TURNS_OF_CRANK * scene.cam.rpm, "rev/min"))
    for key, value in scene.numbers(NUMBER_COLUMNS).items():
        if value is not None:
            numbers.append(NumberWithUnit(key, value, QUANTITIES[names[key]].unit))
    for number, stage in enumerate(scene.train, start=1):
        for key, value in stage:
            if key in STAGE_NUMBER_KEYS and value is not None:
                name = stage_quantity_name(number, key, angular=scene.output_turns_after_stages(number))
                numbers.append(NumberWithUnit(f"train.{number}.{key}", value, QUANTITIES[name].unit))
    return numbers

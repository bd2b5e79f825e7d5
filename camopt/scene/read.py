"""The numbers of a scene apart from its sizes, each in the unit in which it is read."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from camopt.quantities import NUMBER_COLUMNS, QUANTITIES, number_quantities
from camopt.scene.scene import Scene
from camopt.scene.speed import OF_CRANK, TURNS_OF_CRANK


class Read(NamedTuple):
    """A number of the scene, or the rows of a load: its key, its value and the unit of that."""

    key: str
    value: Any
    unit: str


def numbers_read(scene: Scene) -> list[Read]:
    """The speed, and numbers of follower, spring, load and materials; for oscillating followers moments by rad."""
    names = number_quantities(angular=scene.mechanism.motion.angular, tool_turns=scene.tool_turns)
    given = {key: value for key, value in scene.numbers(NUMBER_COLUMNS).items() if value is not None}
    found = [Read(key, value, QUANTITIES[names[key]].unit) for key, value in given.items()]
    return [*_speed_of_crank(scene), *found]


def _speed_of_crank(scene: Scene) -> Iterator[Read]:
    """The speed as it was given, if not as that of the cam."""
    if scene.by_crank and scene.cam.rpm is not None:
        yield Read(OF_CRANK, TURNS_OF_CRANK * scene.cam.rpm, "rpm")

"""A bell crank with a coupler to a slide (``trains.crank``).

What drives it lifts a roller or pad on its first arm (``trains.arm``), unless a follower that oscillates is that
arm itself; its second arm is the crank.
"""

from camopt.model.trains.crank import crank
from camopt.model.trains.link import Keys, Link, Stage
from camopt.model.trains.rocker import driven


def _links(keys: Keys, turns: bool) -> tuple[Link, ...]:
    moved = crank(keys["crank"], keys["coupler"], keys.get("offset", 0.0), keys["angle"])
    return (*driven(keys, turns), moved)


STAGE = Stage(
    "bell-crank",
    "a bell crank",
    ("crank", "coupler", "angle"),
    ("offset", "input_arm", "input_angle"),
    lambda keys, turns: False,
    _links,
)

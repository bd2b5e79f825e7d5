"""A bell crank with a coupler to a slide (``trains.crank``).

What drives it lifts a roller or pad on its first arm (``trains.arm``), unless a follower that oscillates is that
arm itself; its second arm is the crank.
"""

from camopt.model.trains.crank import crank
from camopt.model.trains.link import Keys, Link, StageKind
from camopt.model.trains.rocker import input_links


def _bell_crank_links(keys: Keys, turns: bool) -> tuple[Link, ...]:
    moved = crank(keys["crank"], keys["coupler"], keys.get("offset", 0.0), keys["angle"])
    return (*input_links(keys, turns), moved)


STAGE = StageKind(
    "bell-crank",
    "a bell crank",
    ("crank", "coupler", "angle"),
    ("offset", "input_arm", "input_angle"),
    lambda keys, turns: False,
    _bell_crank_links,
)

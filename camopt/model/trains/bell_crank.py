"""A bell crank with a coupler to a slide.

Its first arm is lifted by a roller or pad (``trains.arm``). An oscillating follower is that arm itself. The second
arm is a crank (``trains.crank``).
"""

from camopt.model.trains.arm import input_arm_links
from camopt.model.trains.crank import assemble_crank
from camopt.model.trains.link import Keys, Link, StageKind


def _bell_crank_links(keys: Keys, input_angular: bool) -> tuple[Link, ...]:
    output = assemble_crank(keys["crank"], keys["coupler"], keys.get("offset", 0.0), keys["angle"])
    return (*input_arm_links(keys, input_angular), output)


STAGE = StageKind(
    "bell-crank",
    "a bell crank",
    ("crank", "coupler", "angle"),
    ("offset", "input_arm", "input_angle"),
    lambda keys, turns: False,
    _bell_crank_links,
)

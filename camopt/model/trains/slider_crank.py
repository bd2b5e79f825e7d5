"""A slider-crank, driven from its crank, or where a length comes to it from its slide (``trains.crank``)."""

from camopt.model.trains.crank import crank
from camopt.model.trains.link import Keys, Link, Reversed, Stage


def _links(keys: Keys, turns: bool) -> tuple[Link]:
    link = crank(keys["crank"], keys["coupler"], keys.get("offset", 0.0), keys["angle"])
    return (link if turns else Reversed(link),)


NEEDS = ("crank", "coupler", "angle")
STAGE = Stage("slider-crank", "a slider-crank", NEEDS, ("offset",), lambda keys, turns: not turns, _links)

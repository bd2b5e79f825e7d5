"""A slider-crank (``trains.crank``): an angle drives its crank, or a length its slide."""

from camopt.model.trains.crank import assemble_crank
from camopt.model.trains.link import Keys, Link, ReversedLink, StageKind


def _slider_crank_links(keys: Keys, input_angular: bool) -> tuple[Link]:
    link = assemble_crank(keys["crank"], keys["coupler"], keys.get("offset", 0.0), keys["angle"])
    return (link if input_angular else ReversedLink(link),)


SLIDER_CRANK_KEYS = ("crank", "coupler", "angle")
STAGE = StageKind(
    "slider-crank",
    "a slider-crank",
    SLIDER_CRANK_KEYS,
    ("offset",),
    lambda keys, turns: not turns,
    _slider_crank_links,
)

"""A slide on an incline: a wedge that moves with what drives it, and lifts what is guided across.

    z = y·sin α/sin(γ + α)

with the incline at α to the motion that drives it, and the guide of what it lifts at γ to that motion; square to
it, γ = 90°, z = y·tan α.
"""

from math import radians, sin

from camopt.trains.constant import Constant
from camopt.trains.link import Unassembled
from camopt.trains.stage import Keys, Stage


def _links(keys: Keys, turns: bool) -> tuple[Constant]:
    if turns:
        raise Unassembled("its wedge takes a length, and what comes to it is an angle")
    incline, guide = keys["angle"], keys.get("guide", 90.0)
    if not (0.0 < abs(incline) < 90.0 and 0.0 < guide < 180.0 and 0.0 < guide + incline < 180.0):
        why = f"an incline of {incline:g} deg does not lift along a guide at {guide:g} deg: both are below 180 deg"
        raise Unassembled(why + " together, and the incline is between 0 and ±90")
    return (Constant(sin(radians(incline)) / sin(radians(guide + incline)), (False, False)),)


STAGE = Stage("incline", "a slide on an incline", ("angle",), ("guide",), lambda keys, turns: False, _links)

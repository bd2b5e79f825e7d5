"""Cams with all of a part, and the quantities that limits on it are on."""

from functools import cache

from camopt import Scene, evaluate
from camopt.core.quantities import QUANTITIES
from camopt.scene.problem.limits import PART_LIMITS, limited_quantity_name
from camopt.scene.problem.problem import resolve
from support.cams import CONTACTS, cam_with

BODY = {"thickness": 16, "bore": 25, "keyway_width": 8, "keyway_depth": 3.3, "density": 7800}
HUB = {"hub_diameter": 44, "hub_length": 32}
GROOVED = [contact for contact in CONTACTS if contact.startswith("groove")]
HOLLOW = ("knife", "roller", "offset-roller", "arm")
SMALL = 25.0  # mm: then the flanks are hollow


@cache
def scene_of(contact, law="modified-sine", rotation="ccw"):
    """A cam with all of a part, and as yet without limits."""
    part = {**BODY, **({"groove_depth": 10, "thickness": 70} if contact in GROOVED else HUB)}
    made = Scene.from_dict(cam_with(contact, law, rotation=rotation, part=part, outputs=["all"], materials={}))
    return made.replace(**{"cam.base_radius": SMALL}) if contact in HOLLOW else made


@cache
def cam_of(contact, law="modified-sine"):
    return evaluate(scene_of(contact, law))


def quantity_of(key, contact):
    """The quantity that a limit is on, and whether from above; None where the mechanism has none."""
    if key == "cutter_radius":
        return ("cutter_radius_max_mm" if contact in HOLLOW else None), -1.0
    name = limited_quantity_name(key, resolve(scene_of(contact)).setup)
    return (name if name in cam_of(contact) else None), QUANTITIES[PART_LIMITS[key]].limit_sign

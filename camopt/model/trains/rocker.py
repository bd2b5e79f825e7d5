"""A rocker with two arms, as in valve trains: its ratio changes with its angle.

What drives it lifts a roller or pad at the end of its first arm, and one at the end of the second moves the slide,
each on a face square to the motion (``trains.arm``):

    y = l₁·(sin(α₁ + φ) − sin α₁)        z = l₂·(sin(α₂ + φ) − sin α₂)

A follower that oscillates is the first arm itself.
"""

from camopt.model.trains.arm import Arm, arm
from camopt.model.trains.link import Keys, Link, Reversed, Stage, Unassembled


def driven(keys: Keys, turns: bool) -> tuple[Link, ...]:
    """The arm by which a rocker or bell crank is driven, unless it turns with the follower."""
    if turns:
        if {"input_arm", "input_angle"} & keys.keys():
            raise Unassembled("it turns with what comes to it, an angle: it has no input_arm")
        return ()
    if "input_arm" not in keys:
        raise Unassembled("what comes to it is a length: it needs an input_arm (mm)")
    return (Reversed(arm(keys["input_arm"], keys.get("input_angle", 0.0))),)


def _links(keys: Keys, turns: bool) -> tuple[Link, ...]:
    output: Arm = arm(keys["output_arm"], keys.get("output_angle", 0.0))
    return (*driven(keys, turns), output)


STAGE = Stage(
    "rocker",
    "a rocker",
    ("output_arm",),
    ("output_angle", "input_arm", "input_angle"),
    lambda keys, turns: False,
    _links,
)

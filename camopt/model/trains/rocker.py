"""A rocker with two arms, as in valve trains: its ratio changes with its angle.

What drives it lifts a roller or pad at the end of its first arm, and one at the end of the second moves the slide,
each on a face square to the motion (``trains.arm``):

    y = l₁·(sin(α₁ + φ) − sin α₁)        z = l₂·(sin(α₂ + φ) − sin α₂)

A follower that oscillates is the first arm itself.
"""

from camopt.model.trains.arm import Arm, arm
from camopt.model.trains.link import AssemblyFault, Keys, Link, ReversedLink, StageKind


def input_links(keys: Keys, turns: bool) -> tuple[Link, ...]:
    """The arm by which a rocker or bell crank is driven, unless it turns with the follower."""
    if turns:
        if {"input_arm", "input_angle"} & keys.keys():
            raise AssemblyFault("it turns with what comes to it, an angle: it has no input_arm")
        return ()
    if "input_arm" not in keys:
        raise AssemblyFault("what comes to it is a length: it needs an input_arm (mm)")
    return (ReversedLink(arm(keys["input_arm"], keys.get("input_angle", 0.0))),)


def _rocker_links(keys: Keys, turns: bool) -> tuple[Link, ...]:
    output: Arm = arm(keys["output_arm"], keys.get("output_angle", 0.0))
    return (*input_links(keys, turns), output)


STAGE = StageKind(
    "rocker",
    "a rocker",
    ("output_arm",),
    ("output_angle", "input_arm", "input_angle"),
    lambda keys, turns: False,
    _rocker_links,
)

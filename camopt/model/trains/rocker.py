"""A rocker with two arms, as in valve trains; its ratio changes with its angle.

Each arm has a roller or pad at its end, on a face square to the motion (``trains.arm``). The driving slide lifts
the first arm, and the second arm moves the output slide:

    y = l₁·(sin(α₁ + φ) − sin α₁)        z = l₂·(sin(α₂ + φ) − sin α₂)

An oscillating follower is the first arm itself.
"""

from camopt.model.trains.arm import Arm, assemble_arm
from camopt.model.trains.link import AssemblyFault, Keys, Link, ReversedLink, StageKind


def input_arm_links(keys: Keys, input_angular: bool) -> tuple[Link, ...]:
    """The input arm of a rocker or bell crank; none if an angle drives it."""
    if input_angular:
        if {"input_arm", "input_angle"} & keys.keys():
            raise AssemblyFault("it is driven by an angle, and so has no input_arm")
        return ()
    if "input_arm" not in keys:
        raise AssemblyFault("it is driven by a length, and so needs an input_arm (mm)")
    return (ReversedLink(assemble_arm(keys["input_arm"], keys.get("input_angle", 0.0))),)


def _rocker_links(keys: Keys, input_angular: bool) -> tuple[Link, ...]:
    output: Arm = assemble_arm(keys["output_arm"], keys.get("output_angle", 0.0))
    return (*input_arm_links(keys, input_angular), output)


STAGE = StageKind(
    "rocker",
    "a rocker",
    ("output_arm",),
    ("output_angle", "input_arm", "input_angle"),
    lambda keys, turns: False,
    _rocker_links,
)

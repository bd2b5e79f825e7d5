"""The numbers of a stage of a train: each a record. As quantities there are too many to list."""

import re

from camopt.core.quantities.key import ANYWHERE, LENGTH, NOT_NEGATIVE, NumberKey
from camopt.core.quantities.quantity import Quantity, column_suffix

STAGE_NUMBERS = (
    NumberKey("Length of the crank", "mm", key="train.crank", allowed=LENGTH),
    NumberKey("Length of the coupler", "mm", key="train.coupler", allowed=LENGTH),
    NumberKey("Length of the rocker of a four-bar linkage", "mm", key="train.rocker", allowed=LENGTH),
    NumberKey("Distance between the two pivots of a four-bar linkage", "mm", key="train.ground", allowed=LENGTH),
    NumberKey(
        "Distance of the slide's line from the pivot of its crank", "mm", key="train.offset", allowed=ANYWHERE
    ),
    NumberKey(
        "Angle of the crank at the start, from the slide's motion, or from the line to the other pivot; "
        "of an incline, its slope to the motion that drives it",
        "deg",
        key="train.angle",
    ),
    NumberKey(
        "Length of the arm by which a rocker or bell crank is driven", "mm", key="train.input_arm", allowed=LENGTH
    ),
    NumberKey(
        "Angle of the input arm at the start, from the line square to the motion that drives it",
        "deg",
        key="train.input_angle",
    ),
    NumberKey("Length of the second arm of a rocker", "mm", key="train.output_arm", allowed=LENGTH),
    NumberKey(
        "Angle of the output arm at the start, from the line square to the motion that it gives",
        "deg",
        key="train.output_angle",
    ),
    NumberKey("Output by input, below 0 if they go opposite ways", "no unit", key="train.ratio", allowed=ANYWHERE),
    NumberKey(
        "Radius of a pinion or drum between an angle and a length", "mm", key="train.radius", allowed=ANYWHERE
    ),
    NumberKey(
        "Angle between the motion that drives an incline and the one that it gives, 90 if not given",
        "deg",
        key="train.guide",
    ),
    NumberKey("Mass of what the stage moves, where that slides", "kg", key="train.mass"),
    NumberKey(
        "Moment of inertia of what the stage moves about its pivot, where that turns", "kg·m²", key="train.inertia"
    ),
    NumberKey(
        "Moment of inertia about its pivot of a rocker or bell crank with an ``input_arm``",
        "kg·m²",
        key="train.arm_inertia",
    ),
    NumberKey(
        "Rate of a spring against the motion of what the stage moves",
        "N/mm",
        "N·m/rad",
        key="train.spring_rate",
        allowed=NOT_NEGATIVE,
    ),
    NumberKey(
        "Force (moment) of that spring at the start, below 0 if it acts with the motion",
        "N",
        "N·m",
        key="train.preload",
        allowed=ANYWHERE,
    ),
    NumberKey(
        "External force (moment) against the motion of what the stage moves",
        "N",
        "N·m",
        key="train.load",
        allowed=ANYWHERE,
    ),
    NumberKey(
        "Acceleration of gravity, positive if it acts against the motion of that mass",
        "m/s²",
        key="train.gravity",
        allowed=ANYWHERE,
    ),
    NumberKey(
        "Force (moment) of friction in the guide of what the stage moves",
        "N",
        "N·m",
        key="train.friction_force",
        allowed=NOT_NEGATIVE,
    ),
)
STAGE_NUMBER_KEYS = {each.name: each for each in STAGE_NUMBERS}
"""The numbers of a stage by their keys in it."""
STAGE_NUMBER = re.compile(r"train_([1-9]\d*)_([a-z_]+?)((?:_(?:mm|deg|kg|kg_m2|N|N_m|N_per_mm|N_m_per_rad|m_s2))?)")


def stage_quantity(number: int, key: str, *, turns: bool) -> str:
    """The quantity that a number of a stage is in tables, of a stage whose motion is an angle or not."""
    return f"train_{number}_{key}{column_suffix(STAGE_NUMBER_KEYS[key].column_unit(turns=turns))}"


def find_stage_quantity(name: str) -> Quantity | None:
    """The number of a stage that has a name; None if there is none."""
    found = STAGE_NUMBER.fullmatch(name)
    if found is None or found[2] not in STAGE_NUMBER_KEYS:
        return None
    units = (STAGE_NUMBER_KEYS[found[2]].column_unit(turns=turns) for turns in (False, True))
    if (unit := next((each for each in units if column_suffix(each) == found[3]), None)) is None:
        return None
    sentence = f"{found[2].replace('_', ' ').capitalize()} of stage {found[1]} of the train."
    return Quantity(name, "", unit, "sizes", sentence)

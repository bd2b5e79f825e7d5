"""Numbers of a train stage. As quantities, such as ``train_2_crank_mm``, they are too many to list."""

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
        "Angle of the crank at the start, from the slide's motion or from the line to the other pivot; "
        "slope of an incline to the motion that drives it",
        "deg",
        key="train.angle",
    ),
    NumberKey("Length of the arm that drives a rocker or bell crank", "mm", key="train.input_arm", allowed=LENGTH),
    NumberKey(
        "Angle of the input arm at the start, from the line square to the driving motion",
        "deg",
        key="train.input_angle",
    ),
    NumberKey("Length of the second arm of a rocker", "mm", key="train.output_arm", allowed=LENGTH),
    NumberKey(
        "Angle of the output arm at the start, from the line square to the motion that it drives",
        "deg",
        key="train.output_angle",
    ),
    NumberKey(
        "Ratio of output to input, below 0 if they move in opposite directions",
        "no unit",
        key="train.ratio",
        allowed=ANYWHERE,
    ),
    NumberKey(
        "Radius of a pinion or drum between an angle and a length", "mm", key="train.radius", allowed=ANYWHERE
    ),
    NumberKey(
        "Angle between the input and output motions of an incline, 90 by default",
        "deg",
        key="train.guide",
    ),
    NumberKey("Mass that the stage moves in a straight line", "kg", key="train.mass"),
    NumberKey("Moment of inertia that the stage turns, about its pivot", "kg·m²", key="train.inertia"),
    NumberKey(
        "Moment of inertia of a rocker or bell crank with an `input_arm`, about its pivot",
        "kg·m²",
        key="train.arm_inertia",
    ),
    NumberKey(
        "Rate of a spring against the stage's output motion",
        "N/mm",
        "N·m/rad",
        key="train.spring_rate",
        allowed=NOT_NEGATIVE,
    ),
    NumberKey(
        "Force (moment) of the stage's spring at the start, below 0 if it acts with the motion",
        "N",
        "N·m",
        key="train.preload",
        allowed=ANYWHERE,
    ),
    NumberKey(
        "External force (moment) against the stage's output motion",
        "N",
        "N·m",
        key="train.load",
        allowed=ANYWHERE,
    ),
    NumberKey(
        "Acceleration of gravity, positive if it acts against the motion of the stage's mass",
        "m/s²",
        key="train.gravity",
        allowed=ANYWHERE,
    ),
    NumberKey(
        "Force (moment) of friction in the guide of the stage's output",
        "N",
        "N·m",
        key="train.friction_force",
        allowed=NOT_NEGATIVE,
    ),
)
STAGE_NUMBER_KEYS = {number.name: number for number in STAGE_NUMBERS}
"""Records of a stage's numbers by their keys in the stage."""
STAGE_NUMBER = re.compile(r"train_([1-9]\d*)_([a-z_]+?)((?:_(?:mm|deg|kg|kg_m2|N|N_m|N_per_mm|N_m_per_rad|m_s2))?)")


def stage_quantity_name(stage_number: int, key: str, *, angular: bool) -> str:
    """Name of the quantity in tables for a stage's number; ``angular`` if the stage's motion is an angle."""
    return f"train_{stage_number}_{key}{column_suffix(STAGE_NUMBER_KEYS[key].column_unit(angular=angular))}"


def find_stage_quantity(name: str) -> Quantity | None:
    """The stage's number with a quantity's name; None for another name."""
    match = STAGE_NUMBER.fullmatch(name)
    if match is None or match[2] not in STAGE_NUMBER_KEYS:
        return None
    units = (STAGE_NUMBER_KEYS[match[2]].column_unit(angular=turns) for turns in (False, True))
    if (unit := next((unit for unit in units if column_suffix(unit) == match[3]), None)) is None:
        return None
    sentence = f"{match[2].replace('_', ' ').capitalize()} of stage {match[1]} of the train."
    return Quantity(name, "", unit, "sizes", sentence)

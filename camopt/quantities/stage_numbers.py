"""The numbers of a stage of a train as quantities: there are too many to list."""

import re

from camopt.quantities.quantity import Quantity

OF_STAGE = {
    **dict.fromkeys(("crank", "coupler", "rocker", "ground", "offset", "input_arm", "output_arm", "radius"), "mm"),
    **dict.fromkeys(("angle", "input_angle", "output_angle", "guide"), "deg"),
    "ratio": "",
    "mass": "kg",
    **dict.fromkeys(("inertia", "arm_inertia"), "kg·m²"),
    "spring_rate": "N/mm, N·m/rad",
    **dict.fromkeys(("preload", "load", "friction_force"), "N, N·m"),
    "gravity": "m/s²",
}
"""Units of the numbers of a stage of a train by key; of two the second where what the stage moves turns."""
SUFFIXES = {"N/mm": "N_per_mm", "N·m/rad": "N_m_per_rad", "N·m": "N_m", "kg·m²": "kg_m2", "m/s²": "m_s2"}
STAGE_NUMBER = re.compile(r"train_([1-9]\d*)_([a-z_]+?)(?:_(mm|deg|kg|kg_m2|N|N_m|N_per_mm|N_m_per_rad|m_s2))?")


def stage_quantity(number: int, key: str, *, turns: bool) -> str:
    """The quantity that a number of a stage is in tables, of a stage whose motion is an angle or not."""
    unit = OF_STAGE[key].split(", ")[-1 if turns else 0]
    return "_".join(filter(None, ("train", str(number), key, SUFFIXES.get(unit, unit))))


def of_stage(name: str) -> Quantity | None:
    """The number of a stage that has a name; None if there is none."""
    found = STAGE_NUMBER.fullmatch(name)
    if found is None or found[2] not in OF_STAGE:
        return None
    units = {SUFFIXES.get(each, each): each for each in OF_STAGE[found[2]].split(", ")}
    if (unit := units.get(found[3] or "")) is None:
        return None
    sentence = f"{found[2].replace('_', ' ').capitalize()} of stage {found[1]} of the train."
    return Quantity(name, "", unit, "sizes", sentence)

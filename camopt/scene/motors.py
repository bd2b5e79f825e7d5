"""The motors of a machine's catalogue, read from a CSV file."""

from math import isfinite
from pathlib import Path
from typing import NamedTuple

from camopt.scene.csv_columns import read_csv_columns
from camopt.scene.sources import path_beside_machine


class MotorData(NamedTuple):
    """A motor of the catalogue."""

    name: str
    rated_torque: float
    """[N·m]"""
    peak_torque: float
    """[N·m]"""
    rated_speed: float
    """[rev/min]"""
    inertia: float
    """Of the rotor [kg·m²]."""


MOTOR_COLUMNS = ("name", "rated_torque_N_m", "peak_torque_N_m", "rated_speed_rpm", "inertia_kg_m2")
"""The columns of a catalogue, in the order of ``MotorData``."""


def read_motors(folder: Path | None, name: str) -> tuple[MotorData, ...]:
    """The motors of a CSV file whose first line names ``MOTOR_COLUMNS``.

    ``name`` is relative to ``folder``, that of the machine. A ValueError says what is wrong.
    """
    path = path_beside_machine(folder, name)
    columns = read_csv_columns(path.parent, path.name, MOTOR_COLUMNS, text_column=MOTOR_COLUMNS[0])
    if not columns[MOTOR_COLUMNS[0]]:
        raise ValueError("has no motor; it must have at least one")
    for column in MOTOR_COLUMNS[1:]:
        for motor, number in zip(columns[MOTOR_COLUMNS[0]], columns[column], strict=True):
            if not (isfinite(number) and number > 0.0):
                raise ValueError(f"{column} of motor {motor} must be above 0")
    return tuple(MotorData(*row) for row in zip(*columns.values(), strict=True))

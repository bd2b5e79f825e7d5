"""The motors of a machine's catalogue, read from a CSV file."""

import csv
from math import isfinite
from pathlib import Path
from typing import NamedTuple

from camopt.core.mistakes import BadInput
from camopt.core.storage.files import decode_user_text, read_bytes
from camopt.scene.csv_columns import MOST_SPANS
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
    wanted = MOTOR_COLUMNS
    try:
        rows = csv.DictReader(decode_user_text(read_bytes(path_beside_machine(folder, name))).splitlines())
        columns = [column.strip() for column in rows.fieldnames or ()]
        if absent := [column for column in wanted if column not in columns]:
            raise ValueError(f"its first line has no {' and no '.join(absent)}")
        rows.fieldnames = columns
        motors = tuple(_motor_of_row(row, rows.line_num) for row in rows)
    except (OSError, BadInput, ValueError, csv.Error) as trouble:
        reason = trouble.strerror if isinstance(trouble, OSError) else trouble
        if isinstance(trouble, BadInput):
            reason = f"must be {trouble.mistakes[0].allowed}"
        raise ValueError(f"must be a CSV file with the columns {', '.join(wanted)}: {reason}") from None
    if not 1 <= len(motors) <= MOST_SPANS:
        raise ValueError(f"has {len(motors)} motors; it must have 1 to {MOST_SPANS}")
    return motors


def _motor_of_row(row: dict[str, str], line: int) -> MotorData:
    numbers = []
    for column in MOTOR_COLUMNS[1:]:
        try:
            number = float(row[column])
        except (TypeError, ValueError):
            raise ValueError(f"line {line} has no number in {column}") from None
        if not (isfinite(number) and number > 0.0):
            raise ValueError(f"line {line} must have a number above 0 in {column}")
        numbers.append(number)
    return MotorData(row["name"].strip(), *numbers)

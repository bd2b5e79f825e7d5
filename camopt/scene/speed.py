"""The speed of a cam, from that of the crankshaft of a four-stroke engine, which turns twice as fast."""

from collections.abc import Iterator
from typing import Any

from camopt.scene.law_forms import Fault
from camopt.scene.mapping import finite_number_or_none

CRANK_SPEED_KEY = "cam.rpm_of_crank"
TURNS_OF_CRANK = 2.0  # in one turn of the camshaft


def replace_crank_speed(tables: dict[str, Any]) -> Iterator[Fault]:
    """Replace ``cam.rpm_of_crank`` by ``cam.rpm``; a fault if both are given."""
    cam = tables.get("cam")
    crank = cam.get("rpm_of_crank") if isinstance(cam, dict) else None
    if cam is None or crank is None:
        return
    if cam.get("rpm") is not None:
        yield CRANK_SPEED_KEY, crank, "cam.rpm, half this speed, is given too: leave one of them out"
    elif (speed := finite_number_or_none(crank)) is not None and speed > 0.0:
        cam["rpm"] = speed / TURNS_OF_CRANK
        del cam["rpm_of_crank"]

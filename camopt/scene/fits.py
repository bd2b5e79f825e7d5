"""Short forms in ``[part]``: a bore with its fit, and a keyway by DIN 6885.

``bore = "30 H7"`` sets a diameter and a fit (ISO 286). ``keyway = "DIN 6885"`` sets the width, its fit JS9 and the
depth in the hub, by the diameter of the bore.

Source: DIN 6885-1 (parallel keys, deep pattern).
"""

import re
from bisect import bisect_left
from collections.abc import Iterator
from typing import Any

from camopt.scene.law_forms import Fault
from camopt.scene.mapping import finite_number_or_none, value_at_key

FIT = r"[A-Z]{1,2}\d{1,2}"
SHAFT_FIT = FIT.replace("A-Z", "a-z")
SHORT_BORE = re.compile(rf"\s*(\d.*?)\s*({FIT})\s*")
NUMBER = re.compile(r"\d+(?:\.\d+)?")
STANDARD_KEYWAY, STANDARD_FIT = "DIN 6885", "JS9"
SMALLEST_BORE = 6.0
KEYWAYS = {
    8.0: (2.0, 1.0), 10.0: (3.0, 1.4), 12.0: (4.0, 1.8), 17.0: (5.0, 2.3), 22.0: (6.0, 2.8), 30.0: (8.0, 3.3),
    38.0: (10.0, 3.3), 44.0: (12.0, 3.3), 50.0: (14.0, 3.8), 58.0: (16.0, 4.3), 65.0: (18.0, 4.4),
    75.0: (20.0, 4.9), 85.0: (22.0, 5.4), 95.0: (25.0, 5.4), 110.0: (28.0, 6.4), 130.0: (32.0, 7.4),
    150.0: (36.0, 8.4),
    170.0: (40.0, 9.4), 200.0: (45.0, 10.4), 230.0: (50.0, 11.4), 260.0: (56.0, 12.4), 290.0: (63.0, 12.4),
    330.0: (70.0, 14.4), 380.0: (80.0, 15.4), 440.0: (90.0, 17.4), 500.0: (100.0, 19.4),
}  # fmt: skip
"""Width of the keyway and its depth in the hub (t₂) [mm], by the largest bore of a range [mm]."""
DEPTH_TOLERANCES = {6.0: 0.1, 32.0: 0.2, 100.0: 0.3}
"""Upper tolerance of the depth of a keyway [mm], by the largest width of a range [mm]."""


def keyway_depth_tolerance(width: float) -> float:
    """Upper tolerance of the depth of a keyway [mm], by its width [mm]."""
    return next((allowed for most, allowed in DEPTH_TOLERANCES.items() if width <= most), 0.3)


def split_bore_into_diameter_and_fit(data: dict[str, Any]) -> None:
    """Split a bore such as "30 H7" into diameter (a number, or a text with a unit) and fit, in ``data`` itself."""
    part = data.get("part")
    if (
        isinstance(part, dict)
        and isinstance(part.get("bore"), str)
        and (found := SHORT_BORE.fullmatch(part["bore"]))
    ):
        part["bore"] = float(found[1]) if NUMBER.fullmatch(found[1]) else found[1]
        part.setdefault("bore_fit", found[2])


def expand_standard_keyway(data: dict[str, Any]) -> Iterator[Fault]:
    """Replace ``keyway`` by the sizes of the standard keyway for the bore, in ``data`` itself."""
    part = data.get("part")
    if not isinstance(part, dict) or part.get("keyway") != STANDARD_KEYWAY or isinstance(part.get("bore"), str):
        return
    for key in ("keyway_width", "keyway_depth"):
        if part.get(key) is not None:
            yield f"part.{key}", part[key], f"part.keyway = {STANDARD_KEYWAY!r} sets it: leave one of them out"
    own_bore, shaft = (value_at_key(data, key) for key in ("part.bore", "cam.shaft_diameter"))
    bore = finite_number_or_none(shaft if own_bore is None else own_bore)
    if bore is None or not SMALLEST_BORE < bore <= max(KEYWAYS):
        why = f"needs a bore above {SMALLEST_BORE:g} mm, at most {max(KEYWAYS):g} mm"
        yield "part.keyway", part["keyway"], f"{why} (part.bore, or cam.shaft_diameter)"
        return
    most = [*KEYWAYS]
    width, depth = KEYWAYS[most[bisect_left(most, bore)]]
    del part["keyway"]
    part |= {"keyway_width": width, "keyway_depth": depth}
    part.setdefault("keyway_fit", STANDARD_FIT)

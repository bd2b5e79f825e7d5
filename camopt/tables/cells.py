"""Numbers and headings as people read them in tables: on a terminal, in a notebook."""

import json
from datetime import timedelta
from math import inf
from typing import Any

from camopt.quantities import QUANTITIES

LONGEST_TIME = 1000 * 365.25 * 86400.0  # seconds: a longer time is no answer


def number(value: Any) -> str:
    """A number with six significant digits, without an exponent unless it is very large or small."""
    if isinstance(value, bool) or not isinstance(value, float):
        return {True: "yes", False: "no"}.get(value, str(value)) if isinstance(value, bool) else str(value)
    return "∞" if value == inf else "−∞" if value == -inf else f"{value + 0.0:.6g}"  # + 0.0: no −0


SHOWN_AS_ZERO = dict.fromkeys(("deg", "mm", "N"), 1e-9)
"""By unit: a quantity that is smaller is what rounding leaves of 0."""


def quantity(name: str, value: Any) -> str:
    """The value of a quantity or another column; 0 if it differs from 0 only by rounding."""
    unit = QUANTITIES[name].unit if name in QUANTITIES else ""
    nothing = isinstance(value, float) and abs(value) < SHOWN_AS_ZERO.get(unit, 0.0)
    return number(0.0 if nothing else value)


def duration(seconds: float) -> str:
    """A time as h:mm:ss, with days before it."""
    return str(timedelta(seconds=round(seconds))) if seconds < LONGEST_TIME else "more than 1,000 years"


def heading(name: str, unit: str | None = None) -> str:
    """A column's name, one word per line, then its unit: that of the quantity of this name if none is given."""
    if unit is None:
        unit = QUANTITIES[name].unit if name in QUANTITIES else ""
    stem = name.removesuffix(_suffix(unit)) if unit else name
    return "\n".join([*stem.split("_"), *([unit] if unit else [])])


def _suffix(unit: str) -> str:
    """A unit as it is written in names: m/s² is _m_s2, N/mm is _N_per_mm."""
    plain = unit.translate(str.maketrans("²³·µ", "23_u")).replace("/s", "_s")
    return "_" + plain.replace("1/", "per_").replace("/", "_per_")


def to_json(document: Any) -> str:
    """Strict JSON text (no NaN or Infinity), in ASCII: it passes any pipe."""
    return json.dumps(document, indent=2, allow_nan=False)

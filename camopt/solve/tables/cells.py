"""Text of numbers, units and headings for readers, on a terminal or in a notebook."""

import json
from datetime import timedelta
from math import inf
from typing import Any

from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system

LONGEST_TIME = 1000 * 365.25 * 86400.0  # seconds; longer times are shown as "more than 1,000 years"


def number_text(value: Any) -> str:
    """A number with six significant digits, without an exponent unless it is very large or small."""
    if isinstance(value, bool) or not isinstance(value, float):
        return {True: "yes", False: "no"}.get(value, str(value)) if isinstance(value, bool) else str(value)
    return "∞" if value == inf else "−∞" if value == -inf else f"{value + 0.0:.6g}"  # + 0.0: no −0


SHOWN_AS_ZERO = dict.fromkeys(("deg", "mm", "N"), 1e-9)
"""Quantities smaller than this, by unit, are 0 but for rounding."""


def unit_of_column(name: str, unit: str | None = None) -> str:
    """Unit of a column: ``unit``, or else that of the quantity with this name, or that at the end of the name."""
    if unit is None:
        at_end = (known for known in ("mm", "mm³", "N") if name.endswith(column_suffix_of_unit(known)))
        return QUANTITIES[name].unit if name in QUANTITIES else next(at_end, "")
    return unit


def quantity_text(name: str, value: Any, unit: str | None = None) -> str:
    """Text of a value in a column; 0 if a quantity differs from 0 only by rounding."""
    unit = unit_of_column(name, unit)
    if not isinstance(value, float):
        return number_text(value)
    least = SHOWN_AS_ZERO.get(unit, 0.0) if name in QUANTITIES else 0.0
    return number_text(0.0 if abs(value) < least else to_shown_unit(value, unit))


def shown_column_name(name: str) -> str:
    """A quantity's name with the unit in which it is shown, such as ``base_radius_in``."""
    return name_in_shown_unit(name, unit_of_column(name))


def name_in_shown_unit(name: str, unit: str) -> str:
    """A name that ends in ``unit``, with the unit in which the number is shown."""
    shown = unit_in_shown_system(unit)
    return name if shown == unit else name.removesuffix(column_suffix_of_unit(unit)) + column_suffix_of_unit(shown)


def with_unit(value: float | None, unit: str) -> str:
    """Text of a number with its unit, both as they are shown."""
    return (
        f"{number_text(value if value is None else to_shown_unit(value, unit))} {unit_in_shown_system(unit)}"
    ).rstrip()


def duration_text(seconds: float) -> str:
    """Text of a time as h:mm:ss, after the days."""
    return str(timedelta(seconds=round(seconds))) if seconds < LONGEST_TIME else "more than 1,000 years"


def column_heading(name: str, unit: str | None = None) -> str:
    """Heading of a column: its name, one word a line, then its unit as it is shown; see ``unit_of_column``."""
    unit = unit_of_column(name, unit)
    stem = name.removesuffix(column_suffix_of_unit(unit)) if unit else name
    return "\n".join([*stem.split("_"), *([unit_in_shown_system(unit)] if unit else [])])


def axis_label(name: str, unit: str | None = None) -> str:
    """Label of a diagram's axis: the name in words, then its unit as it is shown."""
    unit = unit_of_column(name, unit)
    words = column_heading(name, unit).split("\n")
    return f"{' '.join(words[:-1])}, {words[-1]}" if unit else " ".join(words)


def column_suffix_of_unit(unit: str) -> str:
    """Suffix of names for a unit: _m_s2 for m/s², _N_per_mm for N/mm, _rpm for rev/min."""
    plain = unit.replace("rev/min", "rpm").translate(str.maketrans("²³⁴·µ", "234_u")).replace("/s", "_s")
    return "_" + plain.replace("1/", "per_").replace("/", "_per_")


def to_json(document: Any) -> str:
    """Strict JSON text, without NaN and Infinity, in ASCII."""
    return json.dumps(document, indent=2, allow_nan=False)

"""Systems of units in which results are shown: mm or inch. Everything is computed and stored in mm.

Numbers in tables, texts, pictures, pages, drawings and files for machines are converted when they are written.
A unit is a product of powers, and each factor has its counterpart in ``CUSTOMARY``. Angles, times and numbers of
turns are the same in both systems. Keys and options are read in mm, or with a unit of their own.

Source: B. N. Taylor, A. Thompson, NIST Special Publication 811, appendix B.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from math import prod
from typing import Any

from camopt.core.mistakes import BadInput, Mistake

MM, INCH = "mm", "inch"
SYSTEMS = (MM, INCH)

POUND, INCH_MM = 0.45359237, 25.4
POUND_FORCE = POUND * 9.80665
KSI = POUND_FORCE * 1e3 / INCH_MM**2
CUSTOMARY = {
    "mm": ("in", INCH_MM),
    "m": ("in", INCH_MM / 1e3),
    "µm": ("µin", INCH_MM / 1e3),
    "N": ("lbf", POUND_FORCE),
    "kN": ("lbf", POUND_FORCE / 1e3),
    "MPa": ("ksi", KSI),
    "GPa": ("Mpsi", KSI),
    "Pa·s": ("µreyn", KSI / 1e3),
    "kg": ("lb", POUND),
    "g": ("oz", POUND * 1e3 / 16),
    "W": ("hp", 550 * 12 * INCH_MM / 1e3 * POUND_FORCE),
    "J": ("ft·lbf", 12 * INCH_MM / 1e3 * POUND_FORCE),
}
"""Customary counterpart of each unit, with its size in the unit."""
POWERS = {"": 1, "²": 2, "³": 3, "⁴": 4}
UNIT_FACTOR = re.compile(r"(Pa·s|[^·/²³⁴ ]+)([²³⁴]?)")

_shown_system = MM


@contextmanager
def shown_in(system: str) -> Iterator[None]:
    """Show results in a system of units within a ``with`` block, in all threads of this process.

    Parameters
    ----------
    system : str
        "mm" or "inch".

    Raises
    ------
    BadInput
        For another system.

    Examples
    --------
    >>> cam = camopt.evaluate(camopt.find_scene("uniform-knife-radial").replace(outputs=["sizes"]))
    >>> with camopt.shown_in("inch"):
    ...     [cell.text for cell in cam.table().rows[2][:3]]
    ['base_radius_in', '1.9685', 'in']
    """
    global _shown_system
    if system not in SYSTEMS:
        raise BadInput([Mistake("camopt", "system", system, " or ".join(SYSTEMS))])
    before, _shown_system = _shown_system, system
    try:
        yield
    finally:
        _shown_system = before


def shown_system() -> str:
    """The system of units in which results are shown now."""
    return _shown_system


def unit_in_shown_system(computed_unit: str) -> str:
    """The unit in which a number computed in ``unit`` is shown."""
    return computed_unit if _shown_system == MM else _customary_unit_and_size(computed_unit)[0]


def to_shown_unit(value: Any, unit: str) -> Any:
    """Convert a number or array from ``unit`` to the unit in which it is shown."""
    return value if _shown_system == MM else value / _customary_unit_and_size(unit)[1]


def from_shown_unit(value: Any, unit: str) -> Any:
    """Convert a number or array from the unit in which it is shown back to ``unit``."""
    return value if _shown_system == MM else value * _customary_unit_and_size(unit)[1]


@cache
def _customary_unit_and_size(unit: str) -> tuple[str, float]:
    """The customary unit in place of ``unit``, and its size in ``unit``."""
    above, slash, below = unit.partition("/")
    size = _size_of_customary_product(above) / _size_of_customary_product(below)
    return _customary_unit_of_product(above) + slash + _customary_unit_of_product(below), size


def _customary_unit_of_product(product: str) -> str:
    return UNIT_FACTOR.sub(lambda factor: CUSTOMARY.get(factor[1], (factor[1], 1.0))[0] + factor[2], product)


def _size_of_customary_product(product: str) -> float:
    """Size of a product's customary counterpart in the product's unit."""
    return prod(
        CUSTOMARY[name][1] ** POWERS[power] for name, power in UNIT_FACTOR.findall(product) if name in CUSTOMARY
    )

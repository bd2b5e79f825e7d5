"""Motion laws of installed packages: entry points of the group ``camopt.laws``, imported when a law is used."""

from collections.abc import Sequence
from functools import cache, cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.mistakes import BadInput, Mistake, line_of, shorten
from camopt.core.numerics import FloatArray
from camopt.model.motion.law import UNIT_SAMPLES, BySeries, Law, law_derivatives
from camopt.model.motion.polynomial import PolynomialLaw
from camopt.model.motion.scca import SCCALaw
from camopt.model.motion.spline import SplineLaw

LAW_ENTRY_POINTS = "camopt.laws"
PARTS_OF_LAW = ("TITLE", "SOURCE", "BREAKS", "displacement", "velocity", "acceleration", "jerk")
EXACT_CLASSES = (PolynomialLaw, SCCALaw, SplineLaw)
"""Classes whose laws are proved; of any other law the functions alone are known."""
END_ERROR = 1e-9  # of the displacement at the ends of the unit stroke


class InstalledLaw(BySeries):
    """The law of an entry point. Its package is imported when its first number is asked for."""

    def __init__(self, entry: EntryPoint) -> None:
        self.NAME = entry.name
        self._entry = entry

    def __reduce__(self) -> Any:
        return _installed_law, (self.NAME,)

    @cached_property
    def law(self) -> Law:
        """The law as its package has it.

        Raises
        ------
        BadInput
            If the package has none; the message names it.
        """
        try:
            found: Law = self._entry.load()
            missing = [name for name in PARTS_OF_LAW if not hasattr(found, name)]
            with np.errstate(all="ignore"):
                wrong = f"lacks {', '.join(missing)}" if missing else _law_fault(found)
        except Exception as error:  # whatever a module does when it is imported, and a law when it is called
            wrong = f"fails: {type(error).__name__}: {shorten(line_of(str(error)))}"
        if wrong:
            key = f"entry point {self.NAME} of {LAW_ENTRY_POINTS}"
            raise BadInput([Mistake(f"package {self.package}", key, None, wrong, bare=True)])
        return found

    @property
    def package(self) -> str:
        """The package and its version."""
        return f"{self._entry.dist.name} {self._entry.dist.version}" if self._entry.dist else self._entry.module

    @property
    def sampled(self) -> bool:
        """Whether nothing is proved of the law between the points at which its functions are called."""
        return type(self.law) not in EXACT_CLASSES or getattr(self.law, "sampled", False)

    @property
    def TITLE(self) -> str:  # noqa: N802
        return self.law.TITLE

    @property
    def SOURCE(self) -> str:  # noqa: N802
        return self.law.SOURCE

    @property
    def BREAKS(self) -> tuple[float, ...]:  # noqa: N802
        return tuple(self.law.BREAKS)

    def _derivatives_to_order(self, x: ArrayLike, order: int) -> Sequence[FloatArray]:
        return law_derivatives(self.law, x, order)


def _law_fault(law: Law) -> str:
    """What is wrong with the numbers of a law, or nothing."""
    breaks = tuple(law.BREAKS)
    if breaks[:1] != (0.0,) or breaks[-1:] != (1.0,) or list(breaks) != sorted({*breaks}):
        return f"has BREAKS {breaks}, which must rise from 0.0 to 1.0"
    inner = UNIT_SAMPLES[1:-1]
    if any(np.shape(each) != inner.shape or not np.isfinite(each).all() for each in law_derivatives(law, inner, 3)):
        return "must give a finite number of its displacement, velocity, acceleration and jerk for each x"
    if np.abs(np.asarray(law.displacement(np.array([0.0, 1.0]))) - [0.0, 1.0]).max() > END_ERROR:
        return "must have the displacement 0 at x = 0 and 1 at x = 1"
    return ""


@cache
def installed_laws() -> dict[str, InstalledLaw]:
    """The laws of installed packages by name, none imported; of two of a name the first on the path of imports."""
    found = reversed(tuple(entry_points(group=LAW_ENTRY_POINTS)))
    return {each.name: InstalledLaw(each) for each in found if each.name and not {*each.name} & {*"+/"}}


def _installed_law(name: str) -> InstalledLaw:
    return installed_laws()[name]

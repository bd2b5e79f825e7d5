"""Motion laws of installed packages: entry points of the group ``camopt.laws``, imported when a law is used."""

from collections.abc import Sequence
from functools import cache, cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.mistakes import BadInput, Mistake, shorten, to_terminal_line
from camopt.core.numerics import FloatArray
from camopt.model.motion.law import UNIT_SAMPLES, Law, LawBySeries, law_derivatives
from camopt.model.motion.polynomial import PolynomialLaw
from camopt.model.motion.scca import SCCALaw
from camopt.model.motion.spline import SplineLaw

LAW_ENTRY_POINTS = "camopt.laws"
PARTS_OF_LAW = ("TITLE", "SOURCE", "BREAKS", "displacement", "velocity", "acceleration", "jerk")
EXACT_CLASSES = (PolynomialLaw, SCCALaw, SplineLaw)
"""Classes of laws that proofs know between samples; of any other law only values of its functions are known."""
END_ERROR = 1e-9  # of the displacement at the ends of the unit stroke


class InstalledLaw(LawBySeries):
    """The law of an entry point; its package is imported when the law is first evaluated."""

    def __init__(self, entry: EntryPoint) -> None:
        self.NAME = entry.name
        self._entry = entry

    def __reduce__(self) -> Any:
        return _installed_law, (self.NAME,)

    @cached_property
    def law(self) -> Law:
        """The law as its package defines it.

        Raises
        ------
        BadInput
            If the package has no valid law; the message names the package.
        """
        try:
            law: Law = self._entry.load()
            missing = [name for name in PARTS_OF_LAW if not hasattr(law, name)]
            with np.errstate(all="ignore"):
                fault = f"lacks {', '.join(missing)}" if missing else _law_fault(law)
        except Exception as error:  # anything may happen in a foreign module and its functions
            fault = f"fails: {type(error).__name__}: {shorten(to_terminal_line(str(error)))}"
        if fault:
            key = f"entry point {self.NAME} of {LAW_ENTRY_POINTS}"
            raise BadInput([Mistake(f"package {self.package}", key, None, fault, bare=True)])
        return law

    @property
    def package(self) -> str:
        return f"{self._entry.dist.name} {self._entry.dist.version}" if self._entry.dist else self._entry.module

    @property
    def sampled(self) -> bool:
        """Whether the law is known only at the points where its functions are called."""
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
    """What is wrong with the numbers of a law; "" if nothing is."""
    breaks = tuple(law.BREAKS)
    if breaks[:1] != (0.0,) or breaks[-1:] != (1.0,) or list(breaks) != sorted({*breaks}):
        return f"has BREAKS {breaks}, which must rise from 0.0 to 1.0"
    inner = UNIT_SAMPLES[1:-1]
    if any(np.shape(each) != inner.shape or not np.isfinite(each).all() for each in law_derivatives(law, inner, 3)):
        return "must give a finite displacement, velocity, acceleration and jerk for each x"
    if np.abs(np.asarray(law.displacement(np.array([0.0, 1.0]))) - [0.0, 1.0]).max() > END_ERROR:
        return "must have the displacement 0 at x = 0 and 1 at x = 1"
    return ""


@cache
def installed_laws() -> dict[str, InstalledLaw]:
    """The laws of installed packages by name, not yet imported.

    Of two laws with one name, the first on the import path counts.
    """
    entries = reversed(tuple(entry_points(group=LAW_ENTRY_POINTS)))
    return {entry.name: InstalledLaw(entry) for entry in entries if entry.name and not {*entry.name} & {*"+/"}}


def _installed_law(name: str) -> InstalledLaw:
    return installed_laws()[name]

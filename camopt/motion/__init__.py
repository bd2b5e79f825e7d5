"""Motion laws (one module each, all with the same verbs) and the programme that joins them into a turn."""

from camopt.motion import (
    cubic,
    cycloidal,
    double_harmonic,
    harmonic,
    modified_sine,
    modified_trapezoid,
    parabolic,
    poly345,
    poly4567,
    poly56789,
    uniform,
)
from camopt.motion.law import Law

_ALL: tuple[Law, ...] = (
    uniform,
    parabolic,
    harmonic,
    cycloidal,
    poly345,
    poly4567,
    modified_trapezoid,
    modified_sine,
    cubic,
    double_harmonic,
    poly56789,
)

LAWS: dict[str, Law] = {law.NAME: law for law in _ALL}
"""Every built-in law by the name that scenes use."""

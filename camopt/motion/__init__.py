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

LAWS: dict[str, Law] = {
    "uniform": uniform,
    "parabolic": parabolic,
    "harmonic": harmonic,
    "cycloidal": cycloidal,
    "poly345": poly345,
    "poly4567": poly4567,
    "modified-trapezoid": modified_trapezoid,
    "modified-sine": modified_sine,
    "cubic": cubic,
    "double-harmonic": double_harmonic,
    "poly56789": poly56789,
}
"""Every law by the name that scenes use."""

"""Motion laws, one module or one member of a family each, and the programme that joins them into a turn."""

from camopt.model.motion import (
    cycloidal,
    double_harmonic,
    half_cycloidal_1,
    half_cycloidal_2,
    half_harmonic_1,
    half_harmonic_2,
    harmonic,
    parabolic,
    poly345,
    poly4567,
    poly56789,
)
from camopt.model.motion.installed_laws import installed_laws
from camopt.model.motion.law import Law
from camopt.model.motion.polynomial import cubic, poly8, uniform
from camopt.model.motion.scca import (
    cycloidal_constant_velocity,
    modified_constant_velocity,
    modified_sine,
    modified_trapezoid,
)

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
    poly8,
    modified_constant_velocity,
    cycloidal_constant_velocity,
    half_cycloidal_1,
    half_cycloidal_2,
    half_harmonic_1,
    half_harmonic_2,
)

LAWS: dict[str, Law] = {**installed_laws(), **{law.NAME: law for law in _ALL}}
"""All laws by their names in scenes; a built-in law hides a law of an installed package with the same name."""

"""Sine and cosine together, in vectorised form; and the arctangent with the same bits on every processor.

Library functions take one number at a time, which would keep the climb to a maximum from being vectorised. The
argument is reduced to |r| ≤ π/4 by a two-part π/2 (Cody and Waite, Software Manual for the Elementary Functions,
1980). There, Taylor's series err by less than a third of a unit in the last place. For |y| ≤ 1000 the error is
below one unit in the last place of 1.
"""

from math import factorial
from typing import Any

import numpy as np

from camopt.core.kernels.marks import chosen_by_type, inline_in_kernels_by_overload
from camopt.core.numerics import Number
from camopt.core.numerics.dual import Dual
from camopt.core.numerics.jet import Jet, cosine, sine

QUARTER, QUARTER_REST = 1.5707963267341256, 6.077100506506192e-11  # π/2 in two parts, the first of 33 bits
SINES = tuple(
    (-1) ** k / factorial(2 * k + 1) for k in range(7, 0, -1)
)  # coefficients of r³·(r²)ᵏ, the highest first
STEEP_TANGENT, MIDDLE_TANGENT = 2.414213562373095, 0.66  # tan 3π/8, and the tangent from which π/4 is subtracted
QUARTER_LOST = 6.123233995736766e-17  # π/2 less the nearest double
ARCTAN_NUMERATOR = (
    -0.8750608600031904,
    -16.157537187333652,
    -75.00855792314705,
    -122.88666844901361,
    -64.85021904942025,
)
ARCTAN_DENOMINATOR = (
    24.858464901423062,
    165.02700983169885,
    432.88106049129027,
    485.3903996359137,
    194.5506571482614,
)
COSINES = tuple((-1) ** k / factorial(2 * k) for k in range(8, 1, -1))  # coefficients of r⁴·(r²)ᵏ


@inline_in_kernels_by_overload
def sine_and_cosine_of_numbers(y):
    """Sine and cosine of a number or an array."""
    k = np.rint(y * (2.0 / np.pi))
    r = (y - k * QUARTER) - k * QUARTER_REST
    square = r * r
    s, c = SINES[0], COSINES[0]
    for j in range(1, 7):
        s = s * square + SINES[j]
        c = c * square + COSINES[j]
    s = r + r * square * s
    c = 1.0 + (square * square * c - 0.5 * square)
    quadrant = k - 4.0 * np.floor(0.25 * k)
    upper = np.floor(0.5 * quadrant)
    odd = quadrant - 2.0 * upper
    turn = odd + upper - 2.0 * odd * upper  # 1 in the second and third quadrant, where the cosine is negative
    return ((1.0 - odd) * s + odd * c) * (1.0 - 2.0 * upper), ((1.0 - odd) * c + odd * s) * (1.0 - 2.0 * turn)


def sine_cosine(y: Any) -> tuple[Any, Any]:
    """Sine and cosine of a number, an array, a jet or an interval."""
    return sine_and_cosine_of_numbers(y) if isinstance(y, (float, np.ndarray)) else (np.sin(y), np.cos(y))


@chosen_by_type(sine_cosine)
def _choose_sine_cosine_for_kernels(y):
    return (lambda y: (sine(y), cosine(y))) if y is Jet else (lambda y: sine_and_cosine_of_numbers(y))


def arctangent(y: Any) -> Number:
    """arctan y of a number or array, to a unit in the last place; of an interval by numpy's function.

    numpy's function has other last bits on processors with wide vectors. The rational approximation is by S. L.
    Moshier, Methods and Programs for Mathematical Functions (1989).
    """
    if not isinstance(y, (float, np.ndarray)):
        return np.arctan(y)
    size: Any = np.abs(y)
    steep, middling = size > STEEP_TANGENT, size > MIDDLE_TANGENT
    with np.errstate(all="ignore"):
        t: Any = np.where(steep, -1.0 / size, np.where(middling, (size - 1.0) / (size + 1.0), size))
    square = t * t
    over, under = ARCTAN_NUMERATOR[0], square + ARCTAN_DENOMINATOR[0]
    for p, q in zip(ARCTAN_NUMERATOR[1:], ARCTAN_DENOMINATOR[1:], strict=True):
        over, under = over * square + p, under * square + q
    quarters = 0.5 * steep + 0.5 * middling  # in half turns
    angle = quarters * (np.pi / 2.0) + ((t * square * over / under + t) + quarters * QUARTER_LOST)
    return np.copysign(angle, y)


def cosine_and_sine_of_sum(cosine: Any, sine: Any, y: Any) -> Any:
    """Cosine and sine of a constant angle plus y, from those of the angle."""
    if type(y) is not Dual:
        return _cosine_and_sine_of_number_sum(cosine, sine, y)
    cosine, sine = (part.value if type(part) is Dual else part for part in (cosine, sine))
    return _cosine_and_sine_of_dual_sum(cosine, sine, y)


def _cosine_and_sine_of_number_sum(cosine, sine, y):
    s, c = sine_cosine(y)
    return cosine * c - sine * s, sine * c + cosine * s


def _cosine_and_sine_of_dual_sum(cosine, sine, y):
    c, s = cosine_and_sine_of_sum(cosine, sine, y.value)
    return Dual(c, -(s * y.slope)), Dual(s, c * y.slope)


@chosen_by_type(cosine_and_sine_of_sum)
def _choose_angle_sum_for_kernels(cosine, sine, y):
    return _cosine_and_sine_of_dual_sum if y is Dual else _cosine_and_sine_of_number_sum

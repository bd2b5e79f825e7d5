"""Jets: bounds of a curve over a part of the turn, by the same formulas that give its values.

A jet has the range of a quantity over the part, a bound of its rounding error at any point there, and bounds of the
magnitudes of its first three derivatives by the cam angle. Formulas run on jets as on numbers. By Leibniz' rule for
a product, and for the quotient q = a/b from a = q·b,

    |(a·b)''| ≤ |a|·|b''| + 2·|a'|·|b'| + |a''|·|b|,    |q''| ≤ (|a''| + 2·|q'|·|b'| + |q|·|b''|) / min |b|

so every bound holds, and is close if the part is short. Each operation adds 2⁻⁵³ of its largest result to the
rounding errors of its operands. The error of an input is taken as 4 such units.

A quantity without bounds, such as a quotient whose denominator may be zero, is inf or NaN from there on;
``infinite_if_nan`` turns NaN into inf.

Inside kernels a jet is a value type of six registers. Uncompiled it is an object with the same operators, on
numbers or on arrays with one entry for each design.
"""

import operator

import numpy as np

from camopt.core.kernels.marks import chosen_by_type, inline_in_kernels_by_overload, value_type
from camopt.core.numerics import INPUT_ROUNDOFF, UNIT_ROUNDOFF
from camopt.core.numerics.number_type import OTHER, OWN, OperationRules, register_number_operations

FLOAT_ZERO = np.float64(0.0)  # division by it gives infinity in plain Python too
JET_FIELDS = ("low", "high", "error", "first", "second", "third")


@value_type(*JET_FIELDS)
class Jet:
    """Range, rounding error, and bounds of three derivatives by the cam angle."""

    __slots__ = JET_FIELDS

    def __init__(self, low, high, error, first, second, third):
        self.low, self.high, self.error = low, high, error
        self.first, self.second, self.third = first, second, third


class LazyJet(Jet):
    """The result of an operation, computed when it is read; often a curve's slope is never read."""

    __slots__ = ("operands", "rule")

    def __init__(self, rule, operands):
        self.rule, self.operands = rule, operands

    def __getattr__(self, name):
        if name not in JET_FIELDS:
            raise AttributeError(name)
        jet, self.operands = self.rule(*self.operands), ()
        self.low, self.high, self.error = jet.low, jet.high, jet.error
        self.first, self.second, self.third = jet.first, jet.second, jet.third
        return getattr(jet, name)


def select(condition, a, b):
    """a where the condition holds, else b; for numbers or arrays."""
    return np.where(condition, a, b) if type(condition) is np.ndarray else a if condition else b


def larger(a, b):
    """The larger of two numbers or arrays; the first where one is NaN."""
    if type(a) is np.ndarray or type(b) is np.ndarray:
        most = np.fmax(a, b)
        return np.maximum(most, a, out=most)  # a fifth of the time of np.where, with the same bits
    return b if b > a else a


def smaller(a, b):
    """The smaller of two numbers or arrays; the first where one is NaN."""
    if type(a) is np.ndarray or type(b) is np.ndarray:
        least = np.fmin(a, b)
        return np.minimum(least, a, out=least)
    return b if b < a else a


@inline_in_kernels_by_overload
def smallest_and_largest(p, q, r, s):
    """Smallest and largest of four numbers."""
    return smaller(smaller(p, q), smaller(r, s)), larger(larger(p, q), larger(r, s))


def power_of_number(a, exponent):
    """a to a power; arrays number by number, for the same last digits of the C library as in kernels."""
    if type(a) is not np.ndarray:
        return a**exponent
    return np.array([number**exponent for number in a.ravel()]).reshape(a.shape)


chosen_by_type(power_of_number)(lambda a, exponent: lambda a, exponent: a**exponent)
chosen_by_type(select)(lambda condition, a, b: lambda condition, a, b: a if condition else b)
chosen_by_type(larger)(lambda a, b: lambda a, b: max(a, b))
chosen_by_type(smaller)(lambda a, b: lambda a, b: min(a, b))


@inline_in_kernels_by_overload
def largest_magnitude(a):
    """Largest |a|."""
    return larger(abs(a.low), abs(a.high))


@inline_in_kernels_by_overload
def least_magnitude(a):
    """Smallest |a|."""
    return larger(larger(a.low, -a.high), 0.0)


@inline_in_kernels_by_overload
def infinite_if_nan(bound):
    """A bound of a jet, with inf in place of the NaN of 0·∞, which would compare as if the bound held."""
    return select(bound >= 0.0, bound, np.inf)


@inline_in_kernels_by_overload
def constant_jet(x):
    """A number as a jet."""
    return Jet(x, x, INPUT_ROUNDOFF * abs(x), 0.0, 0.0, 0.0)


@inline_in_kernels_by_overload
def negative(a):
    return Jet(-a.high, -a.low, a.error, a.first, a.second, a.third)


@inline_in_kernels_by_overload
def add(a, b):
    low, high = a.low + b.low, a.high + b.high
    error = a.error + b.error + UNIT_ROUNDOFF * larger(abs(low), abs(high))
    return Jet(low, high, error, a.first + b.first, a.second + b.second, a.third + b.third)


@inline_in_kernels_by_overload
def add_number(a, x):
    low, high = a.low + x, a.high + x
    error = a.error + INPUT_ROUNDOFF * abs(x) + UNIT_ROUNDOFF * larger(abs(low), abs(high))
    return Jet(low, high, error, a.first, a.second, a.third)


@inline_in_kernels_by_overload
def multiply(a, b):
    least, most = smallest_and_largest(a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high)
    m, n = largest_magnitude(a), largest_magnitude(b)
    return Jet(
        least,
        most,
        m * b.error + n * a.error + UNIT_ROUNDOFF * m * n,
        m * b.first + n * a.first,
        m * b.second + 2.0 * a.first * b.first + n * a.second,
        m * b.third + 3.0 * (a.first * b.second + a.second * b.first) + n * a.third,
    )


@inline_in_kernels_by_overload
def multiply_number(a, x):
    p, q, m = a.low * x, a.high * x, abs(x)
    error = m * a.error + 2.0 * INPUT_ROUNDOFF * m * largest_magnitude(a)
    return Jet(smaller(p, q), larger(p, q), error, m * a.first, m * a.second, m * a.third)


@inline_in_kernels_by_overload
def square(a):
    """a², with the range of equal factors."""
    n, m = least_magnitude(a), largest_magnitude(a)
    return Jet(
        n * n,
        m * m,
        2.0 * m * a.error + UNIT_ROUNDOFF * m * m,
        2.0 * m * a.first,
        2.0 * (m * a.second + a.first * a.first),
        2.0 * (m * a.third + 3.0 * a.first * a.second),
    )


@inline_in_kernels_by_overload
def divide(a, b):
    """a/b; without bounds where b may be zero."""
    nonzero = (b.low > 0.0) | (b.high < 0.0)
    low, high = 1.0 / select(nonzero, b.high, -FLOAT_ZERO), 1.0 / select(nonzero, b.low, FLOAT_ZERO)
    least, most = smallest_and_largest(a.low * low, a.low * high, a.high * low, a.high * high)
    inverse = 1.0 / select(nonzero, least_magnitude(b), FLOAT_ZERO)
    m = largest_magnitude(a) * inverse
    first = (a.first + m * b.first) * inverse
    second = (a.second + 2.0 * first * b.first + m * b.second) * inverse
    third = (a.third + 3.0 * (second * b.first + first * b.second) + m * b.third) * inverse
    error = (a.error + m * b.error) * inverse + UNIT_ROUNDOFF * m
    return Jet(least, most, error, first, second, third)


@inline_in_kernels_by_overload
def jet_root(a):
    """√a; without bounds where a may be zero."""
    low, high = np.sqrt(larger(a.low, 0.0)), np.sqrt(larger(a.high, 0.0))
    inverse = 1.0 / low
    first = 0.5 * a.first * inverse
    second = (0.5 * a.second + first * first) * inverse
    third = (0.5 * a.third + 3.0 * first * second) * inverse
    return Jet(low, high, 0.5 * a.error * inverse + UNIT_ROUNDOFF * high, first, second, third)


@inline_in_kernels_by_overload
def absolute(a):
    """|a|; where a may pass through zero, its slope has a bound, but its higher derivatives have none."""
    kink = select((a.low >= 0.0) | (a.high <= 0.0), 0.0, np.inf)
    return Jet(least_magnitude(a), largest_magnitude(a), a.error, a.first, a.second + kink, a.third + kink)


@inline_in_kernels_by_overload
def maximum_with_number(a, x):
    """The larger of a and a number."""
    kink = select((a.low >= x) | (a.high <= x), 0.0, np.inf)
    share = select(a.high <= x, 0.0, 1.0)
    low, high = larger(a.low, x), larger(a.high, x)
    return Jet(low, high, a.error, share * a.first, share * a.second + kink, share * a.third + kink)


@inline_in_kernels_by_overload
def sign(a):
    """−1, 0 or 1; without derivatives where a may pass through zero."""
    jump = select((a.low > 0.0) | (a.high < 0.0), 0.0, np.inf)
    return Jet(np.sign(a.low), np.sign(a.high), 0.0, jump, jump, jump)


@inline_in_kernels_by_overload
def jet_power(a, exponent):
    """a to the power of a number, for a > 0; without bounds where a may be zero or less."""
    inside = a.low > 0.0
    low, high = select(inside, a.low, FLOAT_ZERO), select(inside, a.high, np.inf)
    p, q = power_of_number(low, exponent), power_of_number(high, exponent)
    m, inverse = larger(p, q), 1.0 / low
    ratio1, ratio2, ratio3 = a.first * inverse, a.second * inverse, a.third * inverse
    one, two, three = (
        abs(exponent),
        abs(exponent * (exponent - 1.0)),
        abs(exponent * (exponent - 1.0) * (exponent - 2.0)),
    )
    # each derivative of a^p is largest at an end of the range, and at most m/aᵏ there
    return Jet(
        smaller(p, q),
        larger(p, q),
        one * m * (a.error * inverse) + 4.0 * UNIT_ROUNDOFF * m,
        one * m * ratio1,
        m * (two * ratio1 * ratio1 + one * ratio2),
        m * (three * ratio1 * ratio1 * ratio1 + 3.0 * two * ratio1 * ratio2 + one * ratio3),
    )


@inline_in_kernels_by_overload
def sine_or_cosine_jet(a, low_end_value, high_end_value, largest_derivative):
    """A sine or cosine of a, from its values at the ends of a's range and its largest derivative.

    Inside the range it exceeds the values at the ends by at most an eighth of the squared width.
    """
    width = a.high - a.low
    swell = 0.125 * width * width
    least, most = (
        larger(smaller(low_end_value, high_end_value) - swell, -1.0),
        smaller(larger(low_end_value, high_end_value) + swell, 1.0),
    )
    m = larger(abs(least), abs(most))
    square_first = a.first * a.first
    return Jet(
        least,
        most,
        a.error + 2.0 * UNIT_ROUNDOFF,
        largest_derivative * a.first,
        largest_derivative * a.second + m * square_first,
        largest_derivative * (a.third + square_first * a.first) + 3.0 * m * a.first * a.second,
    )


@inline_in_kernels_by_overload
def largest_sine_or_cosine_magnitude(low_end_value, high_end_value, width):
    """Largest magnitude of a sine or cosine over a range of arguments, from its values at the ends."""
    return smaller(larger(abs(low_end_value), abs(high_end_value)) + 0.125 * width * width, 1.0)


@inline_in_kernels_by_overload
def sine(a):
    return sine_or_cosine_jet(
        a,
        np.sin(a.low),
        np.sin(a.high),
        largest_sine_or_cosine_magnitude(np.cos(a.low), np.cos(a.high), a.high - a.low),
    )


@inline_in_kernels_by_overload
def cosine(a):
    return sine_or_cosine_jet(
        a,
        np.cos(a.low),
        np.cos(a.high),
        largest_sine_or_cosine_magnitude(np.sin(a.low), np.sin(a.high), a.high - a.low),
    )


JET_RULES: OperationRules = {
    operator.add: {
        (OWN, OWN): lambda a, b: add(a, b),
        (OWN, OTHER): lambda a, b: add_number(a, b),
        (OTHER, OWN): lambda a, b: add_number(b, a),
    },
    operator.sub: {
        (OWN, OWN): lambda a, b: add(a, negative(b)),
        (OWN, OTHER): lambda a, b: add_number(a, -b),
        (OTHER, OWN): lambda a, b: add_number(negative(b), a),
    },
    operator.mul: {
        (OWN, OWN): lambda a, b: multiply(a, b),
        (OWN, OTHER): lambda a, b: multiply_number(a, b),
        (OTHER, OWN): lambda a, b: multiply_number(b, a),
    },
    operator.truediv: {
        (OWN, OWN): lambda a, b: divide(a, b),
        (OWN, OTHER): lambda a, b: multiply_number(a, 1.0 / b),
        (OTHER, OWN): lambda a, b: divide(constant_jet(a), b),
    },
    operator.pow: {(OWN, OTHER): lambda a, b: jet_power(a, b)},
    operator.neg: {(OWN,): lambda a: negative(a)},
    np.sqrt: {(OWN,): lambda a: jet_root(a)},
    np.square: {(OWN,): lambda a: square(a)},
    np.absolute: {(OWN,): lambda a: absolute(a)},
    np.maximum: {(OWN, OTHER): lambda a, b: maximum_with_number(a, b)},
    np.sign: {(OWN,): lambda a: sign(a)},
    np.sin: {(OWN,): lambda a: sine(a)},
    np.cos: {(OWN,): lambda a: cosine(a)},
}
"""Rules of each operation for operands that are jets or numbers."""

register_number_operations(Jet, JET_RULES, LazyJet, (float, np.ndarray, np.generic, int))

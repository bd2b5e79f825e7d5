"""Functions in forms without cancellation, and sums with the same digits on every processor."""

from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.interval import Interval, as_interval, widen
from camopt.core.numerics.sloped_interval import SlopedInterval, apply_chain_rule, range_of, value_at_box_point


def angle_minus_sine(t: FloatArray) -> FloatArray:
    """t − sin t without cancellation, for any t ≥ 0.

    Below 0.5 it is the alternating series t³/3! − t⁵/5! + …, whose ninth term is under 1e-21 of the first.
    """
    t = np.asarray(t, dtype=float)
    small = np.minimum(t, 0.5)
    square = small * small
    term = small * square / 6.0
    total = np.zeros_like(small)
    for k in range(9):
        total = total + term
        term = -term * square / ((2 * k + 4) * (2 * k + 5))
    return np.where(t < 0.5, total, t - np.sin(t))


def compensated_sum(*terms: Any) -> Number:
    """A sum that is right to its last digits even if its terms cancel (Ogita, Rump and Oishi 2005, Sum2).

    The rounding error of each addition is computed exactly and added at the end. Ranges are added by their ends.
    """
    if any(isinstance(term, SlopedInterval) for term in terms):
        value, at = (compensated_sum(*map(part, terms)) for part in (range_of, value_at_box_point))
        return apply_chain_rule(value, at, [(term, 1.0) for term in terms])
    if any(isinstance(term, Interval) for term in terms):
        ends = [as_interval(term) for term in terms]
        return widen(Interval(compensated_sum(*(x.low for x in ends)), compensated_sum(*(x.high for x in ends))))
    total, lost = terms[0], 0.0
    for term in terms[1:]:
        total, more = exact_sum(total, term)
        lost = lost + more
    return total + lost


def matrix_product(a: Any, b: Any) -> FloatArray:
    """Sum of a[…, k]·b[k, …] over k, with the same bits for any shape and on any processor.

    In libraries of linear algebra, the order of the additions depends on both.
    """
    if b.ndim == 1:
        return np.asarray(np.sum(np.ascontiguousarray(a * b), axis=-1))
    total = np.zeros((*a.shape[:-1], *b.shape[1:]), np.result_type(a, b))
    for column, row in zip(np.moveaxis(a, -1, 0), b, strict=True):
        total += column.reshape(*column.shape, *[1] * row.ndim) * row
    return total


def triangle_angle(first_side: Any, second_side: Any, *opposite_terms: Any) -> Number:
    """Angle between two sides of a triangle [rad], from the third side as a sum of terms.

    The half-angle form keeps all digits of a flat triangle, where the law of cosines loses them (W. Kahan,
    Miscalculating Area and Angles of a Needle-like Triangle). If there is no such triangle, the angle is 0 or π.
    """
    near = np.maximum(
        compensated_sum(*opposite_terms, -first_side, second_side)
        * compensated_sum(*opposite_terms, first_side, -second_side),
        0.0,
    )
    far = np.maximum(
        compensated_sum(first_side, second_side, *(-term for term in opposite_terms))
        * compensated_sum(first_side, second_side, *opposite_terms),
        0.0,
    )
    return 2.0 * np.arctan2(np.sqrt(near), np.sqrt(far))


def exact_sum(a: Any, b: Any) -> tuple[Number, Number]:
    """a + b, and its rounding error (Knuth, The Art of Computer Programming, vol. 2, 4.2.2)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def difference_of_squares_root(a: Any, b: Any, added_to_a: Any = 0.0) -> Number:
    """√((a + more)² − b²) as the root of its factors, for a + more ≥ 0; 0 where |b| is larger.

    It rises with a and falls with |b|, so its ends are exact for intervals. The product of its factors would be
    wider, because both contain b.
    """
    terms = (a, b, added_to_a)
    if any(isinstance(term, SlopedInterval) for term in terms):
        value = difference_of_squares_root(*map(range_of, terms))
        at = difference_of_squares_root(*map(value_at_box_point, terms))
        longest, across = range_of(a + added_to_a), range_of(b)
        return apply_chain_rule(
            value, at, list(zip(terms, (longest / value, -across / value, longest / value), strict=True))
        )
    if isinstance(a, Interval) or isinstance(b, Interval):
        a, b, added_to_a = as_interval(a), as_interval(b), as_interval(added_to_a)
        low = difference_of_squares_root(a.low, b.largest_magnitude, added_to_a.low)
        return widen(Interval(low, difference_of_squares_root(a.high, b.least_magnitude, added_to_a.high)))
    whole, lost = exact_sum(a, added_to_a)  # each factor is a compensated sum
    factors = (exact_sum(whole, term) for term in (-b, b))
    less, longer = (total + (lost + error) for total, error in factors)
    return np.sqrt(np.maximum(less * longer, 0.0))

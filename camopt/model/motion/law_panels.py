"""Laws as polynomials on panels (``numerics.piecewise``)."""

from collections.abc import Iterable, Sequence
from functools import lru_cache, singledispatch
from itertools import pairwise

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import UNIT_ROUNDOFF, FloatArray
from camopt.core.numerics.panels import TABLE_DEGREE
from camopt.core.numerics.piecewise import sign_changes
from camopt.core.numerics.quadrature import chebyshev_nodes_and_matrix, chebyshev_nodes_and_powers_matrix
from camopt.core.numerics.stable_functions import matrix_product
from camopt.model.motion.law import Law, law_derivatives

JERK_DEGREE = TABLE_DEGREE - 3
SAME_BREAK = 1e-12  # of a stroke: a cut this near to a break is the same but for rounding
KEPT_JERK = 1e-14  # share of a law's jerk: panels whose polynomial misses more are halved
MOST_HALVINGS = 8
JERK_NODES, JERK_TO_POWERS = chebyshev_nodes_and_powers_matrix(JERK_DEGREE)
JERK_CHECK_NODES, TO_CHEBYSHEV = chebyshev_nodes_and_matrix(JERK_DEGREE + 4)


def breaks_with_cuts(breaks: tuple[float, ...], cuts: tuple[float, ...]) -> tuple[float, ...]:
    """The breaks of a unit stroke and further cuts, in order."""
    return tuple(
        sorted({*breaks, *(x for x in cuts if 0.0 < x < 1.0 and min(abs(x - b) for b in breaks) > SAME_BREAK)})
    )


def _panel_ends_centres_and_half_widths(
    pieces: Iterable[tuple[float, ...]], counts: Iterable[int]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Lower ends, centres and half widths of panels, from the ends of pieces and their counts of panels."""
    ends = [np.linspace(a, b, m + 1) for (a, b), m in zip(pieces, counts, strict=True)]
    low = np.concatenate([e[:-1] for e in ends])
    high = np.concatenate([e[1:] for e in ends])
    return low, (low + high) / 2, (high - low) / 2


def _size_and_excess_of_jerk_series(
    law: Law, breaks: tuple[float, ...], counts: list[int], pieces: Sequence[int]
) -> dict[int, tuple[float, float]]:
    """Two numbers of the Chebyshev series of the jerk on the panels of some pieces, by number of the piece.

    The first is the largest sum of the magnitudes of its coefficients, the second by how much the terms beyond the
    table's degree may exceed the effect of rounding x.
    """
    _, centre, half = _panel_ends_centres_and_half_widths(
        [breaks[k : k + 2] for k in pieces], [counts[k] for k in pieces]
    )
    series = np.abs(matrix_product(law.jerk(centre[:, None] + half[:, None] * JERK_CHECK_NODES), TO_CHEBYSHEV.T))
    slope = matrix_product(series, np.arange(series.shape[1]) ** 2) / half
    excess = series[:, JERK_DEGREE + 1 :].sum(axis=1) - UNIT_ROUNDOFF * slope
    firsts = np.cumsum([0, *(counts[k] for k in pieces[:-1])])
    rows = (np.maximum.reduceat(each, firsts).tolist() for each in (series.sum(axis=1), excess))
    return dict(zip(pieces, zip(*rows, strict=True), strict=True))


def _refined_panel_counts(law: Law, breaks: tuple[float, ...], counts: list[int]) -> list[int]:
    """Numbers of panels of the pieces, doubled until the table's degree holds the jerk up to rounding."""
    checks, coarse = dict[int, tuple[float, float]](), list(range(len(counts)))
    for _ in range(MOST_HALVINGS):
        checks |= _size_and_excess_of_jerk_series(law, breaks, counts, coarse)
        most = KEPT_JERK * max(size for size, _ in checks.values())
        coarse = [k for k, (_, excess) in checks.items() if excess > most]
        if not coarse:
            break
        counts = [2 * count if k in coarse else count for k, count in enumerate(counts)]
    return counts


@lru_cache(maxsize=256)
def law_panel_polynomials(
    law: Law, least_panel_count: int, cuts: tuple[float, ...]
) -> tuple[FloatArray, FloatArray, tuple[int, ...]]:
    """A law as polynomials on panels of the unit stroke.

    The jerk is interpolated at Chebyshev points inside each panel and integrated three times. The constants are the
    law's values at the panel's centre. So no derivative loses digits by differentiation.

    At least ``least_panel_count`` panels are made; ``cuts`` are further ends of pieces. Returns the coefficients
    (P, TABLE_DEGREE + 1) of s in powers of u, the panel ends (P + 1,), and the number of panels in each piece.
    """
    breaks = breaks_with_cuts(law.BREAKS, cuts)
    counts = [max(1, round(least_panel_count * (b - a))) for a, b in pairwise(breaks)]
    counts = _refined_panel_counts(law, breaks, counts)
    low, centre, half = _panel_ends_centres_and_half_widths(pairwise(breaks), counts)
    series = matrix_product(law.jerk(centre[:, None] + half[:, None] * JERK_NODES), JERK_TO_POWERS.T)
    for constant in reversed(law_derivatives(law, centre, 2)):
        series = polynomial.polyint(series, axis=1) * half[:, None]
        series[:, 0] = constant
    series.flags.writeable = False
    return series, np.append(low, 1.0), tuple(counts)


@singledispatch
@lru_cache(maxsize=256)
def turning_points(law: Law, panel_count: int) -> tuple[float, ...]:
    """Places where a law turns back, x from 0 to 1: its velocity changes sign there. None if it is monotone."""
    series, ends, _ = law_panel_polynomials(law, panel_count, ())
    centre, half = (ends[1:] + ends[:-1]) / 2, np.diff(ends) / 2
    turns = [centre[k] + half[k] * u for k, u in sign_changes(polynomial.polyder(series.T) / half)]
    places = np.unique(np.array([*ends, *turns]))
    signs = np.sign(np.diff(law.displacement(places)))
    return tuple(float(x) for x in places[1:-1][signs[1:] != signs[:-1]])

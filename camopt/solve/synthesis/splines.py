"""B-splines on the unit stroke, whose bounds are bounds of their coefficients.

On each part of a stroke a derivative of the spline is a polynomial. Its Bernstein coefficients enclose it and are
linear in the spline's coefficients. So a linear constraint on them holds at every cam angle, not only at samples. A
part is half a span, which makes the enclosure tight to a fraction of a per cent.

Source: de Boor, A Practical Guide to Splines, ch. IX; Farin, Curves and Surfaces for CAGD, ch. 6.
"""

from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import comb

import numpy as np
import scipy  # loads its parts on first use: pages and comparisons need no sparse matrices

from camopt.core.numerics import FloatArray, IndexArray
from camopt.core.numerics.bsplines import derivative_matrix
from camopt.model.motion.spline import SplineLaw
from camopt.model.motion.stroke import Stroke

SPAN_PARTS = 2  # parts of a span
LEAST_PIECE = 0.25  # least distance of an equally spaced end from a cut, as a share of an equal piece
LEAST_CUT = 1e-3  # least distance of a cut from other cuts and from the ends, as a share of the stroke
LEAST_PART = 1e-9  # least length of a part, as a share of the stroke
LEAST_ENTRY = 1e-12  # smaller entries of a matrix are rounding, as a share of the largest


@dataclass(frozen=True)
class Splines:
    """Clamped splines of a degree on equal pieces, with ``continuity`` continuous derivatives between pieces.

    They are also cut at ``cuts``, with ``continuity_at_cuts`` continuous derivatives there.
    """

    degree: int
    pieces: int
    continuity: int
    cuts: tuple[float, ...] = ()
    continuity_at_cuts: int = 2

    @cached_property
    def piece_ends(self) -> FloatArray:
        """Ends of the pieces: the cuts, and equally spaced ends that are not too close to a cut."""
        ends = [0.0, 1.0]
        equal_ends = np.arange(1, self.pieces) / self.pieces
        for least, places in (LEAST_CUT, self.cuts), (LEAST_PIECE / self.pieces, equal_ends):
            for x in places:
                if all(abs(x - end) > least for end in ends):
                    ends.append(float(x))
        return np.array(sorted(ends))

    @cached_property
    def _continuity_at_ends(self) -> IndexArray:
        """Number of continuous derivatives at the end of each piece but the last."""
        return np.where(
            np.isin(self.piece_ends[1:-1], self.cuts),
            min(self.continuity_at_cuts, self.continuity),
            self.continuity,
        )

    @property
    def knots(self) -> FloatArray:
        inner = np.repeat(self.piece_ends[1:-1], self.degree - self._continuity_at_ends)
        clamped = self.degree + 1
        return np.concatenate([np.zeros(clamped), inner, np.ones(clamped)])

    @property
    def count(self) -> int:
        """Number of coefficients of a spline."""
        return self.knots.size - self.degree - 1

    @property
    def coefficient_integrals(self) -> FloatArray:
        """Integral over the stroke per unit of each coefficient: its support divided by degree + 1."""
        return (self.knots[self.degree + 1 :] - self.knots[: self.count]) / (self.degree + 1)

    def value_matrix(self, x: FloatArray, order: int) -> "scipy.sparse.csr_array":
        """Matrix from coefficients to values of a derivative at x, from 0 to 1."""
        inner = self.knots[order : self.knots.size - order]
        basis = scipy.interpolate.BSpline.design_matrix(x, inner, self.degree - order, extrapolate=True)
        return drop_rounding(basis @ derivative_matrix(self.knots, self.degree, order))

    def bernstein_matrix(self, order: int, low: float = 0.0, high: float = 1.0) -> "scipy.sparse.csr_array":
        """Matrix from coefficients to Bernstein coefficients of a derivative, part by part over a range of x."""
        shares = np.arange(SPAN_PARTS) / SPAN_PARTS
        part_starts = self.piece_ends[:-1, None] + shares * np.diff(self.piece_ends)[:, None]
        inside = [x for x in part_starts.ravel().tolist() if low + LEAST_PART < x < high - LEAST_PART]
        return _bernstein_on_parts(self, order, (low, *inside, high))

    def indices_of_distinct_coefficients(self, order: int, degree: int) -> IndexArray:
        """Numbers of the Bernstein coefficients of a derivative that do not repeat the one before.

        Where the derivative is continuous, the first coefficient of a part equals the last of the part before.
        """
        count = self.piece_ends.size - 1
        part, number = np.divmod(np.arange(count * SPAN_PARTS * (degree + 1)), degree + 1)
        goes_on = np.ones(count * SPAN_PARTS, dtype=bool)
        goes_on[SPAN_PARTS::SPAN_PARTS] = order <= self._continuity_at_ends
        return np.flatnonzero((number > 0) | (part == 0) | ~goes_on[part])

    def stroke_with_law(self, stroke: Stroke, name: str, coefficients: FloatArray, scale: float) -> Stroke:
        """The stroke with a spline as its law.

        A move goes where its coefficients say: displacements in units of ``scale`` [mm or rad].
        """
        if not stroke.is_move:
            return replace(stroke, law=self.unit_stroke_law(name, coefficients))
        low, high = (scale * float(c) for c in coefficients[[0, -1]])
        law = self._spline_law(name, (coefficients - coefficients[0]) * scale / stroke.size)
        given = stroke.given and stroke.given._replace(change=law.coefficients[-1])
        return replace(stroke, law=law, low=low, high=high, given=given, named=True)

    def unit_stroke_law(self, name: str, coefficients: FloatArray) -> SplineLaw:
        """A spline as the law of a rise or return: exactly from 0 to 1."""
        return self._spline_law(name, np.array([0.0, *np.clip(coefficients[1:-1], 0.0, 1.0), 1.0]))

    def _spline_law(self, name: str, coefficients: FloatArray) -> SplineLaw:
        return SplineLaw(name, self.degree, tuple(self.knots.tolist()), tuple(coefficients.tolist()))


@cache
def _bernstein_on_parts(splines: Splines, order: int, ends: tuple[float, ...]) -> "scipy.sparse.csr_array":
    """Matrix to Bernstein coefficients of a derivative on parts that have no knot inside."""
    degree, parts = splines.degree - order, len(ends) - 1
    x = (1.0 - np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))) / 2.0  # inside a part: no knot
    power = np.arange(degree + 1)
    binomials = np.array([comb(degree, k) for k in range(degree + 1)])
    values = binomials * x[:, None] ** power * (1.0 - x[:, None]) ** (degree - power)
    nodes = (np.array(ends[:-1])[:, None] + np.diff(ends)[:, None] * x).ravel()
    return drop_rounding(
        scipy.sparse.kron(scipy.sparse.eye_array(parts), np.linalg.inv(values)) @ splines.value_matrix(nodes, order)
    )


def drop_rounding(matrix: "scipy.sparse.csr_array") -> "scipy.sparse.csr_array":
    """The matrix without entries that are rounding."""
    cleaned = scipy.sparse.csr_array(matrix)
    cleaned.data[np.abs(cleaned.data) <= LEAST_ENTRY * np.abs(cleaned.data).max(initial=0.0)] = 0.0
    cleaned.eliminate_zeros()
    return cleaned


@cache
def distinct_bernstein_matrix(splines: Splines, order: int, degree: int) -> "scipy.sparse.csr_array":
    """As ``Splines.bernstein_matrix``, with a derivative as polynomials of ``degree`` and without repeated rows."""
    own = splines.degree - order
    return elevate_degree(splines.bernstein_matrix(order), own, degree - own)[
        splines.indices_of_distinct_coefficients(order, degree)
    ]


def elevate_degree(rows: "scipy.sparse.csr_array", degree: int, added_degrees: int) -> "scipy.sparse.csr_array":
    """Bernstein coefficients of polynomials of a degree, as those of degree + ``added_degrees``."""
    for _ in range(added_degrees):
        degree += 1
        share = np.arange(degree + 1) / degree
        once = np.diag(1.0 - share)[:, :-1] + np.diag(share)[:, 1:]
        rows = (
            scipy.sparse.kron(scipy.sparse.eye_array(rows.shape[0] // degree), scipy.sparse.csr_array(once)) @ rows
        )
    return scipy.sparse.csr_array(rows)

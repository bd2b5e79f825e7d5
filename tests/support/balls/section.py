"""The section of a disc cam in balls: enclosures of the quantities of ``effects.section``.

The contact point and what is integrated of it are Taylor series by the cam angle, of K terms about the middle of a
part of the turn; the term of order K is taken over the whole part, and bounds what is left out:

    ∫f dθ over ±h ∈ Σ 2·f_k·h^(k+1)/(k + 1), even k < K, + 2·[f_K]·h^(K+1)/(K + 1)

Source: Moore, Kearfott and Cloud, Introduction to Interval Analysis, ch. 9.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import factorial
from typing import Any

import numpy as np
from flint import arb, arb_series

from camopt.core.quantities import QUANTITIES
from camopt.model.effects import EFFECTS, EvaluationBlock
from camopt.model.effects.section import AREA, CENTROID, POLAR_MOMENT, PROFILE_LENGTH
from camopt.model.mechanisms import Designs
from camopt.scene.problem.problem import Problem, with_rounding_relative_error
from camopt.scene.problem.rows import DesignRows
from camopt.solve.verdicts.effect_runs import with_quantities_of_effect
from support.balls.ball import as_arb, ball_between, precisely
from support.balls.laws import Stretch
from support.balls.motion import ExactMotion, ExactStroke

SERIES_ORDER = 10
MOTION_TERMS = SERIES_ORDER + 3  # of a motion: from its second derivative on, SERIES_ORDER is the last one's
STROKE_PARTS = (16, 32, 64, 128, 256)  # of a stroke that moves
ENCLOSURE_ERROR = 2.0**-48  # relative: of what is made of the enclosures in doubles
INTEGRATED = ("section", "solid")

BallSeries = arb_series | arb
"""A series, or a constant. Each operation keeps as many terms as are known."""


def is_integrated(names: tuple[str, ...]) -> bool:
    """Whether some quantities are integrals over the turn, which doubles do not prove."""
    return any(name in QUANTITIES and QUANTITIES[name].effect in INTEGRATED for name in names)


def integrated_rows(
    problem: Problem, motion: ExactMotion, design: Designs, exact: Designs, names: tuple[str, ...]
) -> Iterator[DesignRows]:
    """Proved enclosures of such quantities for one design (in doubles, and in balls), narrower each time.

    Nothing of grooves, and where the velocity jumps.
    """
    if not problem.setup.mechanism.body.bounded or problem.programme.corners:
        return
    case = EvaluationBlock(with_rounding_relative_error(problem).setup, problem.programme, design)
    for parts in STROKE_PARTS:
        rows = section_rows(problem, motion, exact, parts)
        if not all(np.isfinite(width) for width in rows.outward.values()):
            continue  # the parts are so wide that the contact may stand still in one
        if any(QUANTITIES[name].effect != INTEGRATED[0] for name in names):
            rows = with_quantities_of_effect(rows, case, EFFECTS[INTEGRATED[1]], frozenset(names))
        yield replace(
            rows, outward={n: w + ENCLOSURE_ERROR * np.abs(rows.columns[n]) for n, w in rows.outward.items()}
        )


@precisely()
def section_rows(problem: Problem, motion: ExactMotion, exact: Designs, parts: int) -> DesignRows:
    """The quantities of the section as doubles below their balls, with outward widths that reach beyond them."""
    length, area, x, y, polar = _integrals(problem, motion, exact, parts)
    found = {
        PROFILE_LENGTH: length,
        AREA: area,
        **dict(zip(CENTROID, (x / area, y / area), strict=True)),
        POLAR_MOMENT: polar,
    }
    low = {name: np.nextafter([float(ball.lower())], -np.inf) for name, ball in found.items()}
    high = {name: np.nextafter([float(ball.upper())], np.inf) for name, ball in found.items()}
    return DesignRows(low, 1, {name: high[name] - low[name] for name in found})


def _integrals(problem: Problem, motion: ExactMotion, exact: Designs, parts: int) -> list[arb]:
    """Length, area, first moments and polar moment."""
    contact = _contact(problem, exact)
    total, start = [arb(0)] * 5, arb(0)
    for stroke in motion.strokes:
        for piece, first, last in _pieces(stroke):
            count = parts if piece else parts // 4
            for k in range(count):
                ends = (first + (last - first) * each / count for each in (k, k + 1))
                found = _part_integrals(contact, stroke, piece, start, *ends)
                total = [a + b for a, b in zip(total, found, strict=True)]
        start = start + stroke.angle
    return [each / by for each, by in zip(total, (1, 2, 3, 3, 4), strict=True)]


def _pieces(stroke: ExactStroke) -> Iterator[tuple[Stretch | None, arb, arb]]:
    """The parts where the motion is smooth; loads do not matter to the section."""
    return ((piece, first, last) for piece, _, first, last in stroke._replace(lines=()).smooth())


def _part_integrals(
    contact: Any, stroke: ExactStroke, piece: Stretch | None, start: arb, low: arb, high: arb
) -> list[arb]:
    """The integrals over a part of a stroke, from one x to another."""
    middle, half = (low + high) / 2, (high - low) / 2 * stroke.angle
    near, whole = (
        contact(_motion(stroke, piece, x), start + stroke.angle * x) for x in (middle, ball_between(low, high))
    )
    return [
        sum((2 * f[k] * half ** (k + 1) / (k + 1) for k in range(0, SERIES_ORDER, 2)), arb(0))
        + 2 * rest[SERIES_ORDER] * half ** (SERIES_ORDER + 1) / (SERIES_ORDER + 1)
        for f, rest in zip(near, whole, strict=True)
    ]


def _motion(stroke: ExactStroke, piece: Stretch | None, x: arb) -> arb_series:
    """The displacement by the cam angle about a ball of x, longer by two for y' and the slope of the contact."""
    terms = [arb(0)]
    if piece is not None:
        rows = piece.derivatives(MOTION_TERMS, x)
        terms = [stroke.size * row / (stroke.angle**k * factorial(k)) for k, row in enumerate(rows)]
    return arb_series([stroke.low + terms[0], *terms[1:]], MOTION_TERMS)


def _contact(problem: Problem, exact: Designs) -> Any:
    """The contact point and the normal as series, from the displacement and the cam angle."""
    setup, sizes = problem.setup, {name: as_arb(value) for name, value in exact.sizes.items()}
    if not setup.mechanism.flat_faced:
        assert setup.mechanism.start is not None
        at = partial(_of_trace, setup.angular, sizes, as_arb(setup.mechanism.start(exact)))
    elif setup.angular:
        first = ((sizes["size"] - sizes["face_offset"]) / sizes["centre_distance"]).asin()
        at = partial(_of_swinging_face, sizes, first)
    else:
        at = partial(_of_face, sizes)

    def integrands(y: arb_series, angle: arb) -> list[arb_series]:
        (px, py), (nx, ny) = at(int(exact.sense), y)
        return _integrands(int(exact.sense), px, py, nx, ny, angle)

    return integrands


def _integrands(
    sense: int, x: arb_series, y: arb_series, nx: BallSeries, ny: BallSeries, angle: arb
) -> list[arb_series]:
    """The integrands of ``effects.section``, from the contact point and the normal there, as long as its slope."""
    along, up = x.derivative() + y * sense, y.derivative() - x * sense
    rate = (y * along - x * up) * sense
    sine, cosine = arb_series([angle, 1], MOTION_TERMS).sin_cos()
    sine *= sense
    length = (ny * along - nx * up) * sense
    return [length, rate, (x * cosine + y * sine) * rate, (y * cosine - x * sine) * rate, (x * x + y * y) * rate]


WallPlaces = tuple[tuple[arb_series, arb_series], tuple[BallSeries, BallSeries]]
"""The contact point and the outward normal in the ground frame."""


def _of_trace(angular: bool, sizes: dict[str, arb], start: arb, sense: int, y: arb_series) -> WallPlaces:
    """T − R_r·n with n = iσV/|V|, V the velocity of T over the cam (``effects.profile_parts``)."""
    speed = y.derivative()
    if angular:
        pivot, arm = sizes["centre_distance"], sizes["arm_length"]
        sine, cosine = (y + start).sin_cos()
        x, z = -(cosine * arm) + pivot, sine * arm
        along, up = z * speed + z * sense, (-x + pivot) * speed - x * sense
    else:
        x, z = arb_series([sizes["offset"]], MOTION_TERMS), y + start
        along, up = z * sense, speed - x * sense
    share = (along * along + up * up).rsqrt() * sense
    nx, ny = -(up * share), along * share
    radius = sizes["roller_radius"]
    return (x - nx * radius, z - ny * radius), (nx, ny)


def _of_face(sizes: dict[str, arb], sense: int, y: arb_series) -> WallPlaces:
    """(σy', R_b + y), the normal upward."""
    return (y.derivative() * sense, y + sizes["size"]), (arb(0), arb(1))


def _of_swinging_face(sizes: dict[str, arb], first: arb, sense: int, y: arb_series) -> WallPlaces:
    """c + f·n − t·e^{−iψ} with n = ie^{−iψ} and t = c·cos ψ/(1 + σψ')."""
    pivot, face = sizes["centre_distance"], sizes["face_offset"]
    sine, cosine = (y + first).sin_cos()
    reach = cosine * pivot * (y.derivative() * sense + 1).inv()
    return (sine * face - reach * cosine + pivot, cosine * face + reach * sine), (sine, cosine)

"""The exact errors of displacement, velocity and acceleration of a cam that is off, where it touches with a point.

A cam that is off touches with the point φ at θ = φ + τ, where its follower stands at y(φ) + m
(``mechanisms.rest``). Both are series in φ, so that its velocity is (y' + m')/(1 + τ') there. With a prime for the
derivative by φ, and d_k = y⁽ᵏ⁾(θ) − y⁽ᵏ⁾(φ), by what the motion that is asked differs, the errors are

    δ = m − d₀,    δ' = (m' − τ'·y'(θ) − d₁)/(1 + τ')
    δ'' = (m'' − τ''·(y'(θ) + δ') − τ'·(2 + τ')·y''(θ) − d₂)/(1 + τ')²

by the cam angle θ: a formula of all errors and of φ, for numbers and for ranges with slopes, in which nothing large
is subtracted and nothing is iterated. As φ goes round the turn, θ does: the largest error over one is the largest
over the other. The tool of a train is off by f*(y(θ) + δ) − f(y(θ)), with the f* of its own links: both count from
the start position, in which a train is set (``tolerances.off_train``).

An axis of the bore that is off by (x, y) in the ground turns with the cam: it moves by (−y, x).

A profile with at most n waves in a turn, as the follower feels it, stands out by w = x there, with w' = −ny, of
some (x, y) no longer than t: that is Szegő's inequality, w'² + n²w² ≤ n²t². It holds of w'/n too: where w'' counts,
w' is that and w'' = −n²x, with w anywhere within ±t (``LEVEL``). Of a cosine of n waves it is x as well.

Sources: the closed loop of cam and follower (Norton, Cam Design and Manufacturing Handbook, ch. 7), varied twice;
R. Boas, Entire Functions, ch. 11.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms import Designs
from camopt.numerics import FloatArray
from camopt.numerics.taylor import Taylor
from camopt.problem.problem import Problem
from camopt.tolerances.errors import BORE, BORE_WAY, LEVEL, WAY, Errors, flat, off_by
from camopt.tolerances.off_train import follower_start

FACTORIALS = 1.0, 1.0, 2.0


class Moved(NamedTuple):
    """m and τ, each a series in φ."""

    moved: Taylor
    turned: Taylor


def moved_of(
    problem: Problem, design: Designs, errors: Errors, waves: int, motion: Sequence[Any], order: int
) -> Moved:
    """Where a follower rests, from y, y', y'' and y''' where a nominal one touches; of flat errors."""
    mechanism, sense = problem.setup.mechanism, design.sense
    developed, y, slope = mechanism.body.developed, *(_series(motion[k:], order) for k in (0, 1))
    known = {key: each for key, each in errors.items() if key not in (WAY, LEVEL)}
    if WAY in errors:
        known["profile"] = _wave(errors, waves, order)
    off = off_by({key: each for key, each in known.items() if key not in (BORE, BORE_WAY)})
    if BORE in errors and not developed:
        off = off._replace(bore=_axis(errors, sense, order))
    rest = mechanism.rest(design, problem.programme.lift, y, slope, off)
    zero = y * 0.0
    moved, turned = (_plain(zero + each) for each in rest)
    if BORE in errors and developed:
        turned = _along_surface(turned, errors, design)
    return Moved(moved, turned - errors.get("phase", 0.0))


def errors_of(
    moved: Moved, motion: Sequence[Any], differs: Callable[[int], Any], jumped: Any, order: int
) -> list[Any]:
    """δ and its derivatives by the cam angle, to an order.

    ``differs`` has d_k but for the jumps of y'' between φ and θ, which are ``jumped``.
    """
    m, t = moved
    found = [m.terms[0] - differs(0)]
    if order == 0:
        return found
    speed, there = t.terms[1] + 1.0, motion[1] + differs(1)
    found.append((m.terms[1] - t.terms[1] * there - differs(1)) / speed)
    if order == 1:
        return found
    bent = differs(2) + jumped
    curved = (there + found[1]) * t.terms[2] * 2.0 + t.terms[1] * (t.terms[1] + 2.0) * (motion[2] + bent)
    return [*found, (m.terms[2] * 2.0 - curved - bent) / np.square(speed)]


class Contact(NamedTuple):
    """Where cams touch with points of their profiles, and the errors of their motion there."""

    angle: FloatArray
    """The cam angle θ, rad."""
    error: FloatArray
    """Of the tool, or of a derivative of its motion, mm (rad) by powers of rad."""


def contact_of(problem: Problem, errors: Errors, angles: FloatArray) -> Contact:
    """The contact of cams with the points that a nominal follower touches at cam angles (m,), rad.

    Errors are numbers, or arrays (m,) of a cam for each angle.
    """
    found = touched(problem, flat(errors), angles, 0)
    return at_tool(problem, errors, angles, found)


def at_tool(problem: Problem, errors: Errors, angles: FloatArray, found: "Touched") -> Contact:
    """The error of the last order at the tool, from those of a follower up to it."""
    train, there = problem.setup.train, angles + found.turned
    if train is None:
        return Contact(there, found.errors[-1])
    y = problem.programme.at(np.mod(there, problem.programme.strokes[-1].end))
    off, asked = (
        Taylor([each / part for each, part in zip(every, FACTORIALS, strict=False)])
        for every in (found.errors, y[: len(found.errors)])
    )
    asked = asked + follower_start(problem)
    moved = problem.train_off(errors).tool(asked + off) - train.tool(asked)
    return Contact(there, np.asarray(moved.derivative(len(found.errors) - 1) + np.zeros_like(there)))


class Touched(NamedTuple):
    """Cams that touch with places of their profiles."""

    turned: FloatArray
    """τ, rad."""
    errors: list[FloatArray]
    """δ and its derivatives by the cam angle θ."""


def touched(
    problem: Problem, errors: Errors, angles: FloatArray, order: int, *, waves: int = 0, jumps: bool = True
) -> Touched:
    """The contact of cams (m,) with the points that a nominal follower touches at cam angles (m,), rad.

    Without the train. A cam that touches before a jump of y'' where it should be after it, or the other way, has
    the jump for an error, unless ``jumps`` are left out.
    """
    programme = problem.programme
    turn = programme.strokes[-1].end
    base = np.mod(angles, turn)
    motion = [*programme.at(base)]
    moved = moved_of(problem, problem.design, errors, waves, motion, order)
    turned = moved.turned.terms[0] + np.zeros_like(base)
    there, passed = programme.at(np.mod(base + turned, turn)), np.zeros_like(base)
    for jump in programme.jumps if order == 2 else ():
        ahead, behind = np.mod(jump.at - base, turn), np.mod(base - jump.at, turn)
        passed += jump.size * ((turned > ahead) * 1.0 - (-turned > behind))

    def differs(k: int) -> FloatArray:
        return np.asarray(there[k] - motion[k] - (passed if k == 2 else 0.0))

    found = errors_of(moved, motion, differs, passed if jumps else 0.0, order)
    return Touched(turned, [each + np.zeros_like(base) for each in found])


def _series(motion: Sequence[Any], order: int) -> Taylor:
    return Taylor([each * (1.0, 1.0, 0.5)[k] for k, each in enumerate(motion[: order + 1])])


def _wave(errors: Errors, waves: int, order: int) -> Taylor:
    """By how much a profile stands out, as a series in φ."""
    x, y, n = errors["profile"], errors[WAY], float(waves)
    return Taylor([errors.get(LEVEL, x), y * -n, x * (-0.5 * n * n)][: order + 1])


def _axis(errors: Errors, sense: float, order: int) -> tuple[Taylor, Taylor]:
    """How far the axis of the profile of a disc is off, in the ground."""
    x, y = errors[BORE], errors.get(BORE_WAY, 0.0)
    return Taylor([x, y * -sense, x * -0.5][: order + 1]), Taylor([y, x * sense, y * -0.5][: order + 1])


def _along_surface(turned: Taylor, errors: Errors, design: Designs) -> Taylor:
    """With a cylinder whose axis is off along its surface by x, which changes as θ grows."""
    x, slope = errors[BORE] / design.size, errors.get(BORE_WAY, 0.0) / design.size * -design.sense
    terms = [turned.terms[0] + x]
    if len(turned.terms) > 1:
        rate = (turned.terms[1] + 1.0) / (1.0 - slope)
        terms.append((turned.terms[1] + slope) / (1.0 - slope))
    if len(turned.terms) > 2:
        terms.append((turned.terms[2] - x * np.square(rate) * 0.5) / (1.0 - slope))
    return Taylor(terms)


def _plain(series: Taylor) -> Taylor:
    """Ranges without kept quotients."""
    return Taylor([each.divided() if hasattr(each, "divided") else each for each in series.terms])

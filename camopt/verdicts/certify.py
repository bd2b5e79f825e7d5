"""Certify: whether a design holds each of its limits at every cam angle, decided in ball arithmetic.

A limit is a claim that a curve stays below a bound. Over a stretch of the turn the curve is below it if its ball
is, or the ball of its mean-value form, or, where the slope keeps its sign, both its ends; above it if one point is.
What is neither is halved. The formulas are those of the mechanisms, run on balls; the laws are exact
(``verdicts.exact_laws``).
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise, product
from math import inf
from typing import Any, NamedTuple, cast

from flint import arb

import camopt.verdicts.exact_point_contact  # noqa: F401  what formulas do to balls at a point contact
from camopt.effects import Case
from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.motion.table import INWARD, OUTWARD, RESTING, TURN, WAYS, ways_of
from camopt.numerics.clock import now
from camopt.numerics.curves import curve
from camopt.problem.claims import Claim, Derivative, NumberKind
from camopt.problem.limits import SELF_CROSSING, UNDERCUT, Limit
from camopt.problem.problem import Problem, exactly, resolve_design
from camopt.scene.scene import Scene
from camopt.verdicts.asked import conditions_verdict
from camopt.verdicts.ball import Ball, as_arb, between, precisely
from camopt.verdicts.exact_laws import Stretch
from camopt.verdicts.exact_load import LoadLine
from camopt.verdicts.exact_motion import ExactMotion, ExactStroke, motion_at, motion_of
from camopt.verdicts.judging import ASSEMBLY, run_effects

HELD, BROKEN, UNDECIDED = "held", "broken", "undecided"
CONDITIONS = "conditions"
FIRST_PARTS = 8  # of each piece of a law, and line of a load
MOST_PARTS = 20_000
NARROWEST = arb(2) ** -90
NEAR = (1e-14, 1e-12, 1e-9)  # shares of a lift that its double may be off
BALLS = NumberKind(arb, arb.pi, arb.tan)


class Statement(NamedTuple):
    """One side of a claim for one design in balls: factor · value ≤ bound, with ``values`` as of ``of_curve``."""

    values: Callable[[list[Ball]], tuple[Any, Any]]
    strokes: int
    factor: arb
    bound: arb

    def on(self, stroke: ExactStroke) -> "Statement | None":
        """What it says of a stroke, if anything: of a move, in terms of the way in which the follower moves."""
        if not self.strokes & (stroke.kind | WAYS):
            return None
        if stroke.kind != TURN or self.strokes & TURN == TURN:
            return self
        return self._replace(strokes=self.strokes & WAYS | ways_of(self.strokes))

    def applies(self, speed: Any) -> tuple[bool, bool]:
        """Whether it may be, and whether it is sure to be, about a motion with this y'."""
        if not self.strokes & WAYS:
            return True, True
        outward, inward = bool(speed > 0), bool(speed < 0)
        still = not outward and not inward and bool(speed == 0)
        if outward or inward or still:
            sure = bool(self.strokes & (OUTWARD if outward else INWARD if inward else RESTING))
            return sure, sure
        return bool(self.strokes & (OUTWARD * (not speed <= 0) | INWARD * (not speed >= 0))), False


@precisely()
def decide(statement: Statement, motion: ExactMotion, until: float = inf) -> str:
    """Whether a statement holds; undecided if that is not known at ``until`` (``clock.now``)."""
    verdict = HELD
    for stroke in motion.strokes:
        if (about := statement.on(stroke)) is not None:
            for part in stroke.smooth():
                found = _decide_part(about, until, stroke, *part)
                if found == BROKEN:
                    return BROKEN
                verdict = found if found == UNDECIDED else verdict
    return verdict


def _decide_part(
    statement: Statement,
    until: float,
    stroke: ExactStroke,
    piece: Stretch | None,
    line: LoadLine | None,
    start: arb,
    end: arb,
) -> str:
    def over(x: arb) -> tuple[arb, arb, tuple[bool, bool]]:
        """By how much the curve is above the bound, its slope by x, and whether the statement applies."""
        motion = motion_at(stroke, piece, x, line)
        value, slope = statement.values(motion)
        above = as_arb(value) * statement.factor - statement.bound
        return above, as_arb(slope) * statement.factor * stroke.angle, statement.applies(motion[1].arb)

    if piece is None and line is None:
        above, _, (about, _) = over(arb(0))
        return _sign(above) if about else HELD
    cuts = [start + (end - start) * k / FIRST_PARTS for k in range(FIRST_PARTS + 1)]
    stack, parts = list(pairwise(cuts)), 0
    while stack:
        parts += 1
        low, high = stack.pop()
        whole, slope, (about, everywhere) = over(between(low, high))
        if not about or whole <= 0:
            continue
        middle = (low + high) / 2
        here, _, (_, surely) = over(middle)
        if here > 0 and surely:
            return BROKEN
        if here + abs(slope) * (high - low) / 2 <= 0:
            continue
        if slope > 0 or slope < 0:
            found = _sign(over(high if slope > 0 else low)[0])
            if found == HELD:
                continue
            if everywhere:
                return found
        if high - low < NARROWEST or parts > MOST_PARTS or now() > until:
            return UNDECIDED
        stack += [(low, middle), (middle, high)]
    return HELD


@precisely()
def turn_of(programme: Programme) -> ExactMotion:
    """The turn of a programme in balls, its highest included, which is proved where it may be inside a stroke."""
    motion = motion_of(programme)
    return motion if programme.monotone else replace(motion, highest=_highest(motion, programme.lift))


def _highest(motion: ExactMotion, lift: float) -> arb:
    """A ball of the highest of a turn about its double: the follower is nowhere above it, and somewhere within."""
    for share in NEAR:
        low, high = (
            decide(
                Statement(lambda moved: (moved[0], moved[1]), TURN, arb(1), arb(lift * (1 + side * share))), motion
            )
            for side in (-1, 1)
        )
        if (low, high) == (BROKEN, HELD):
            return arb(lift, lift * share)
    raise ArithmeticError("the highest of the turn is not where the table of the motion has it")


def _displacement(moved: list[Ball]) -> tuple[Any, Any]:
    return moved[0], moved[1]


def _sign(over: arb) -> str:
    return HELD if over <= 0 else BROKEN if over > 0 else UNDECIDED


def in_balls(design: Designs) -> Designs:
    """One design with its sizes as balls, taken as exact."""
    balls: dict[str, Any] = {name: Ball(value) for name, value in design.sizes.items()}
    return Designs(**balls, sense=design.sense)


def of_curve(made: Any) -> Callable[[list[Ball]], tuple[Any, Any]]:
    """Value and slope of a curve, from the motion and its derivatives, and a load that changes."""

    def values(motion: list[Ball]) -> tuple[Any, Any]:
        if isinstance(made, Derivative):
            return motion[made.order], motion[made.order + 1]
        y, y1, y2, y3, _, *load = motion
        return curve(made, ..., y, y1, y2, (y3, *load) if load else y3)

    return values


def statements_of(claim: Claim, design: Designs, motion: ExactMotion) -> list[Statement]:
    """The sides of a claim for a design (in balls)."""
    made = claim.curve(design, cast(Programme, motion))
    factor, allowed = as_arb(claim.factor(design)), claim.allowed(BALLS)
    return [Statement(of_curve(made), claim.strokes, factor * side, allowed) for side in claim.sides]


def _verdicts(problem: Problem, claim: Claim, design: Designs, motion: ExactMotion, until: float) -> Iterator[str]:
    """The verdicts on the sides of a claim for a design (in balls)."""
    mechanism = problem.setup.mechanism
    if problem.programme.radii and claim.curve in (mechanism.curvature, mechanism.profile_radius):
        yield from _on_arcs(problem, claim, design)
        return
    for each in statements_of(claim, design, motion):
        yield decide(each, motion, until)


def _on_arcs(problem: Problem, claim: Claim, design: Designs) -> Iterator[str]:
    """The verdicts on the curvature of a cam that is given by its profile: on an arc it is the same all along.

    A limit is often just that of the sharpest arc, and is not divided by, so that this is seen.
    """
    factor, allowed = as_arb(claim.factor(design)), claim.allowed(BALLS)
    for side, element in product(claim.sides, problem.scene.profile):
        if element.radius is None:
            yield _sign(-allowed)
        elif problem.setup.mechanism.curvature is None:
            yield _sign(factor * side * element.radius - allowed)
        else:
            radius = as_arb(design.roller_radius) + element.radius
            yield _sign((factor * side - allowed * radius) * radius.sgn())


def _without_curves(problem: Problem, limit: Limit, design: Designs) -> str:
    """The verdict on a limit that is no matter of curves: a crossing, a size, what the motion alone decides."""
    if limit.decided:
        broken = limit.decided(problem.setup, design, problem.programme)
        return UNDECIDED if broken is None else BROKEN if broken else HELD
    rows = run_effects(Case(exactly(problem).setup, problem.programme, design), limit.needs)
    outer, inner = (limit.excess(rows.shifted(share), design)[0] for share in (1.0, -1.0))
    return HELD if outer <= 0.0 else BROKEN if inner > 0.0 else UNDECIDED


@precisely()
def certify_limits(problem: Problem, design: Designs, until: float = inf) -> dict[str, str]:
    """The verdict on each limit for one design: held, broken or undecided, as at ``until`` (``clock.now``)."""
    if not problem.setup.mechanism.exists(design, problem.programme)[0]:
        return {ASSEMBLY: BROKEN}
    motion = turn_of(problem.programme)
    exact = in_balls(design)
    verdicts: dict[str, str] = {}
    for limit in problem.limits:
        found = [each for claim in limit.claims for each in _verdicts(problem, claim, exact, motion, until)]
        if (presumed := verdicts.get(limit.presumes, HELD)) != HELD:
            found = [presumed]
        elif not limit.claims:
            found = [_without_curves(problem, limit, design)]
        if limit.infinite_at(problem.programme):
            found = [BROKEN]
        verdicts[limit.name] = next((v for v in (BROKEN, UNDECIDED) if v in found), HELD)
    return verdicts


def certify_design(problem: Problem, design: Designs) -> dict[str, str]:
    """As ``certify_limits``, and for a disc cam whether it is free of a self-crossing, under ``self_crossing``."""
    verdicts = certify_limits(problem, design)
    if problem.setup.mechanism.grooved or ASSEMBLY in verdicts:
        return verdicts
    undercut = verdicts.get(UNDERCUT, HELD)  # flat faces and knife edges make no other crossing
    return verdicts | {SELF_CROSSING: verdicts.get(SELF_CROSSING, undercut)}


def certify(scene: Scene) -> dict[str, str]:
    """Prove or refute each limit of a scene for its design: held, broken or undecided, by the limit's name.

    For a disc cam ``self_crossing`` is there too: held if the profile provably crosses itself nowhere, broken if it
    does; decided in double precision, with margins for rounding (``effects.crossing``). Where moves are asked for
    anything, so is ``conditions``: held if they meet it all, to a millionth of the largest displacement and
    velocity, a hundred-thousandth of the acceleration and a thousandth of the jerk.

    Numbers of the scene are taken as exact; of a profile, the centres that are found of its arcs, and the cam
    angles where they meet, are taken as they are rounded. Limits are decided at every cam angle of the continuous
    motion, in ball arithmetic of 200 bits; undecided is what lies within about 1e-27 of its limit. A law that the
    scene gives as a table is the spline through its points.

    Parameters
    ----------
    scene
        A scene with sizes of its own.

    Returns
    -------
    dict
        "held", "broken" or "undecided" for each limit. Of a design that cannot be assembled only ``assembly``.

    Raises
    ------
    BadInput
        If the scene lacks a size.

    Examples
    --------
    >>> verdicts = camopt.certify(camopt.find_scene("roller-1000rpm"))
    >>> verdicts["pressure_angle"], verdicts["undercut"]
    ('broken', 'held')
    """
    problem = resolve_design(scene)
    asked = conditions_verdict(problem.programme, motion_of(problem.programme))
    return certify_design(problem, problem.design) | ({} if asked is None else {CONDITIONS: asked})


def summary(verdicts: dict[str, str]) -> str:
    """One word for a design: broken if any limit is, undecided if any is, else held."""
    return next((v for v in (BROKEN, UNDECIDED) if v in verdicts.values()), HELD)

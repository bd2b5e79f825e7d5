"""Certify: whether a design holds each of its limits at every cam angle, decided in ball arithmetic.

A limit is a claim that a curve stays below a bound, which ``deciding`` decides. The formulas are those of the
mechanisms, run on balls; the laws are exact (``exact_laws``).
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import product
from math import inf, isinf
from typing import Any, cast

import camopt.verdicts.exact_point_contact  # noqa: F401  what formulas do to balls at a point contact
from camopt.effects import Case
from camopt.effects.peak import Derivative
from camopt.mechanisms import Designs
from camopt.mistakes import NOT_REACHED, NOTHING_FEASIBLE
from camopt.motion.programme import Programme
from camopt.numerics.clock import now
from camopt.problem.claims import Claim
from camopt.problem.limit import ASSEMBLY, SELF_CROSSING, UNDERCUT, Limit
from camopt.problem.problem import Problem, exactly, resolve_design
from camopt.problem.rows import Rows
from camopt.problem.settings import toleranced
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.scene import Scene
from camopt.tables.layout import Table, table_of
from camopt.tables.result import Result
from camopt.verdicts.asked import conditions_verdict
from camopt.verdicts.ball import as_arb, precisely
from camopt.verdicts.deciding import Largest, Side, sign_of
from camopt.verdicts.exact_curve import BALL_NUMBERS, ExactCurve, in_balls
from camopt.verdicts.exact_laws import NoExactForm
from camopt.verdicts.exact_mean import mean_verdict
from camopt.verdicts.exact_motion import ExactMotion, TurnPart, exact_motion
from camopt.verdicts.exact_section import integrated_rows, is_integrated
from camopt.verdicts.limit_boxes import ends_within, limit_over_box
from camopt.verdicts.running import run_effects
from camopt.verdicts.words import BROKEN, HELD, UNDECIDED, worst

CONDITIONS = "conditions"
HIGHEST_ERROR = 2.0**-100  # relative


@precisely()
def exact_turn(programme: Programme) -> ExactMotion:
    """The turn of a programme in balls, its highest included, which is proved where it may be inside a stroke."""
    motion = exact_motion(programme)
    if programme.monotone:
        return motion
    highest = Largest(Side(ExactCurve(Derivative(0))).parts(motion)).within(HIGHEST_ERROR)
    return replace(motion, highest=highest)


def sides_of(claim: Claim, design: Designs, motion: ExactMotion) -> Iterator[Side]:
    """The sides of a claim for a design (in balls)."""
    curve = ExactCurve(claim.curve(design, cast(Programme, motion)))
    return (Side(curve, claim.kinds, sign) for sign in claim.sides)


def largest_of(claims: Iterable[Claim], design: Designs, motion: ExactMotion) -> Largest:
    """What the curves of claims are at most, on all their sides, for a design (in balls)."""
    parts: list[tuple[Side, TurnPart]] = []
    for claim in claims:
        turn = claim.curve.of(motion) if isinstance(claim.curve, Derivative) else motion
        for side in sides_of(claim, design, motion):
            parts += side.parts(turn)
    return Largest(parts)


def claim_verdict(problem: Problem, claim: Claim, design: Designs, motion: ExactMotion, until: float = inf) -> str:
    """The verdict on a claim for a design (in balls)."""
    if on_arcs(problem, claim.curve):
        return worst(_on_arcs(problem, claim, design))
    return bounded(largest_of((claim,), design, motion), claim, design, until)


def bounded(largest: Largest, claim: Claim, design: Designs, until: float = inf) -> str:
    """The verdict on a claim for a design (in balls), from what its curves are at most."""
    return largest.verdict(claim.allowed(BALL_NUMBERS), as_arb(claim.factor(design)), until)


def on_arcs(problem: Problem, curve: Any) -> bool:
    """Whether a curve is the curvature of a cam that is given by its profile."""
    mechanism = problem.setup.mechanism
    return bool(problem.profile) and curve in (mechanism.curvature, mechanism.profile_radius)


def _on_arcs(problem: Problem, claim: Claim, design: Designs) -> Iterator[str]:
    """The verdicts on the curvature of a cam that is given by its profile: on an arc it is constant.

    A limit is often just that of the sharpest arc, and is not divided by, so that this is seen.
    """
    factor, allowed = as_arb(claim.factor(design)), claim.allowed(BALL_NUMBERS)
    for side, radius in product(claim.sides, problem.profile):
        if isinf(radius):  # a line
            yield sign_of(-allowed)
        elif problem.setup.mechanism.flat_faced:
            yield sign_of(factor * side * radius - allowed)
        else:
            of_pitch = as_arb(design.roller_radius) + radius
            yield sign_of((factor * side - allowed * of_pitch) * of_pitch.sgn())


def _without_curves(
    problem: Problem, limit: Limit, design: Designs, exact: Designs, motion: ExactMotion, until: float
) -> str:
    """The verdict on a limit without curves: a crossing, a size, an integral, or one of the motion."""
    if limit.decided:
        broken = limit.decided(problem.setup, design, problem.programme)
        return UNDECIDED if broken is None else BROKEN if broken else HELD
    if not is_integrated(limit.needs):
        case = Case(exactly(problem).setup, problem.programme, design)
        return _compared(limit, run_effects(case, limit.needs), design)
    for rows in integrated_rows(problem, motion, design, exact, limit.needs):
        found = _compared(limit, rows, design)
        if found != UNDECIDED or now() > until:
            return found
    return UNDECIDED


def _compared(limit: Limit, rows: Rows, design: Designs) -> str:
    """The verdict on a limit from the enclosures of its quantities."""
    outer, inner = (limit.excess(rows.shifted(share), design)[0] for share in (1.0, -1.0))
    return HELD if outer <= 0.0 else BROKEN if inner > 0.0 else UNDECIDED


@precisely()
def certify_limits(problem: Problem, design: Designs, until: float = inf) -> dict[str, str]:
    """The verdict on each limit for one design: held, broken or undecided, as at ``until`` (``clock.now``)."""
    if not problem.setup.mechanism.exists(design, problem.programme)[0]:
        return {ASSEMBLY: BROKEN}
    try:
        motion = exact_turn(problem.programme)
    except NoExactForm:
        return {limit.name: UNDECIDED for limit in problem.limits}
    exact = in_balls(design)
    verdicts: dict[str, str] = {}
    for limit in problem.limits:
        found = [claim_verdict(problem, claim, exact, motion, until) for claim in limit.claims]
        if (presumed := verdicts.get(limit.presumes, HELD)) != HELD:
            found = [presumed]
        elif limit.mean is not None:
            found = [mean_verdict(limit.mean, exact, motion, until)]
        elif not limit.claims:
            found = [_without_curves(problem, limit, design, exact, motion, until)]
        if limit.infinite_at(problem.programme):
            found = [BROKEN]
        verdicts[limit.name] = worst(found)
    return verdicts


def certify_design(problem: Problem, design: Designs) -> dict[str, str]:
    """As ``certify_limits``, and for a disc cam whether it is free of a self-crossing, under ``self_crossing``."""
    verdicts = certify_limits(problem, design)
    verdicts |= {limit.name: UNDECIDED for limit in problem.limits if limit.is_unproved and limit.name in verdicts}
    if not problem.setup.mechanism.body.closed or ASSEMBLY in verdicts:
        return verdicts
    undercut = verdicts.get(UNDERCUT, HELD)  # flat faces and knife edges make no other crossing
    return verdicts | {SELF_CROSSING: verdicts.get(SELF_CROSSING, undercut)}


class Certificate(Result, dict[str, str]):
    """The verdict on each limit of one cam, by the limit's name: held, broken or undecided.

    Parameters
    ----------
    verdicts : Mapping
        The verdicts by limit.
    scene : Scene
        The cam.

    Examples
    --------
    >>> found = camopt.certify(camopt.find_scene("roller-1000rpm"))
    >>> found["undercut"], found.exit_code
    ('held', 1)
    """

    def __init__(self, verdicts: Mapping[str, str], scene: Scene) -> None:
        super().__init__(verdicts)
        self.scene = scene

    def table(self) -> Table:
        """The verdict on each limit, of the cam or, with ``search.robust``, of all cams within its tolerances."""
        records = [{"limit": name, "verdict": verdict} for name, verdict in self.items()]
        robust = ", of every cam within the tolerances (search.robust)" if self.scene.search.robust else ""
        return table_of(f"At every cam angle{robust}", records, ["limit", "verdict"])

    def document(self) -> dict[str, str]:
        """The verdicts by limit."""
        return dict(self)

    @property
    def exit_code(self) -> int:
        """0 all held; 1 one is broken; 4 one is undecided."""
        return code_of_verdicts(self.values())


def code_of_verdicts(verdicts: Iterable[str]) -> int:
    """The exit code of some verdicts."""
    return {BROKEN: NOTHING_FEASIBLE, UNDECIDED: NOT_REACHED, HELD: 0}[worst(verdicts)]


def certify(scene: SceneSource) -> Certificate:
    """Prove or refute each limit of a scene for its design: held, broken or undecided, by the limit's name.

    For a disc cam ``self_crossing`` is there too: held if the profile provably crosses itself nowhere, broken
    if it does; decided in double precision, with margins for rounding (``effects.crossing``). Decided in
    doubles, too, are limits on errors by tolerances in dwells, and on others where no curve tells them (of two
    contacts, through a train of a changing ratio or with links that are off), on the jump speed, the preload and
    the spring rate that are required, the half-width of a contact, the fluctuation of energy, and quantities of the
    scene's own, by the enclosures of what they read. Limits on the mass and the like of a groove, or of a cam with
    corners, on Python functions, and on expressions of where something is, stay undecided.

    Where moves are asked for anything, ``conditions`` is there: held if they meet it all, to a millionth of the
    largest displacement and velocity, a hundred-thousandth of the acceleration and a thousandth of the jerk.

    Numbers of the scene are taken as exact; of a profile, the centres that are found of its arcs, and the cam
    angles where they meet, are taken as they are rounded. Limits are decided at every cam angle of the continuous
    motion, in ball arithmetic of 200 bits; undecided is what lies within about 1e-27 of its limit. A law that the
    scene gives as a table is the spline through its points. With a law that another package brings as functions,
    all limits stay undecided.

    With ``search.robust`` a limit is held if every cam within the tolerances of its numbers and of its train holds
    it: the nominal one in balls, all others in intervals, over the whole box of numbers and all cam angles at once.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with sizes of its own.

    Returns
    -------
    Certificate
        A dict: "held", "broken" or "undecided" for each limit. A design that cannot be assembled has ``assembly``
        alone.

    Raises
    ------
    BadInput
        If the scene lacks a size.

    References
    ----------
    F. Johansson, Arb: efficient arbitrary-precision midpoint-radius interval arithmetic, IEEE Transactions on
    Computers 66 (2017).

    Examples
    --------
    >>> verdicts = camopt.certify(camopt.find_scene("roller-1000rpm"))
    >>> verdicts["pressure_angle"], verdicts["undercut"]
    ('broken', 'held')
    """
    scene = scene_from(scene)
    return Certificate(certify_problem(resolve_design(scene)), scene)


def certify_problem(problem: Problem) -> dict[str, str]:
    """As ``certify``, for a scene already resolved."""
    try:
        asked = conditions_verdict(problem.given, exact_motion(problem.programme).given)
    except NoExactForm:
        given = problem.given.strokes
        asked = UNDECIDED if any(each.key and each.asked(given[0].low) for each in given) else None
    return certify_cams(problem) | ({} if asked is None else {CONDITIONS: asked})


def certify_cams(problem: Problem) -> dict[str, str]:
    """As ``certify_design``, of the problem's own design with all cams within its tolerances, if these count."""
    verdicts = certify_design(problem, problem.design)
    if not problem.zones or ASSEMBLY in verdicts:
        return verdicts
    return verdicts | {name: worst([verdicts[name], each]) for name, each in over_box(problem).items()}


def over_box(problem: Problem, until: float = inf) -> dict[str, str]:
    """The verdicts on limits of all cams within the tolerances of a problem's own design, in intervals."""
    every = toleranced(exactly(problem))
    ends = ends_within(every, every.design)
    return {limit.name: limit_over_box(every, limit, every.design, ends, until).verdict for limit in every.limits}


def summary(verdicts: dict[str, str]) -> str:
    """One word for a design: broken if any limit is, undecided if any is, else held."""
    return worst(verdicts.values())

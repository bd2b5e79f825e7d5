"""Certify: prove in interval arithmetic whether a design holds each of its limits at every cam angle.

A limit is a constraint that a curve stays below a bound. ``limit_boxes`` decides it, for one cam or over the box of
its tolerances.
"""

from collections.abc import Iterable, Mapping
from types import ModuleType
from typing import Any

import numpy as np

from camopt.core.mistakes import NOT_REACHED, NOTHING_FEASIBLE
from camopt.core.numerics import FloatArray, IntArray
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.core.numerics.motion_ranges import derivative_intervals_over_parts, part_middles_and_angle_intervals
from camopt.model.mechanisms import Designs
from camopt.model.motion.installed_laws import EXACT_CLASSES
from camopt.model.motion.profile_law import ProfileLaw
from camopt.model.motion.programme import Programme, weighted_derivative_range
from camopt.model.motion.stroke import ALL_STROKES, SOLVER_TOLERANCE, Condition, Stroke
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.problem.limit import ASSEMBLY, SELF_CROSSING, UNDERCUT
from camopt.scene.problem.problem import Problem, resolve_design, with_rounding_relative_error
from camopt.scene.problem.settings import with_toleranced_numbers_per_design
from camopt.scene.scene import Scene
from camopt.solve.tables.result import Result, Table, table_of
from camopt.solve.verdicts.limit_boxes import limit_verdict_over_box, tolerance_ranges
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED, worst_verdict

CONDITIONS = "conditions"
OWN_LAWS = "camopt.model.motion."
"""First letters of the names of camopt's modules of laws."""
CONDITION_PARTS = 512
"""Parts of each panel for conditions: their ranges are then far more exact than the tolerance of a condition."""
PANEL_TOLERANCE = 1e-9
"""Share of half a panel: a panel that a range of cam angles overlaps by less is ignored."""


def has_enclosable_laws(programme: Programme) -> bool:
    """Whether every law of a turn can be enclosed, and not only evaluated."""
    return all(_is_camopt_law(stroke.law) for stroke in programme.strokes)


def _is_camopt_law(law: Any) -> bool:
    """Whether a law, or the law inside it, is camopt's own."""
    if inner := getattr(law, "law", None):
        return _is_camopt_law(inner)
    exact = law is None or isinstance(law, (*EXACT_CLASSES, ProfileLaw))
    return exact or (isinstance(law, ModuleType) and law.__name__.startswith(OWN_LAWS))


def certify_limits(problem: Problem, design: Designs, budget: Budget = UNLIMITED) -> dict[str, str]:
    """Verdict on each limit for one design; limits stay undecided once the budget is spent."""
    if not problem.setup.mechanism.can_assemble(design, problem.programme)[0]:
        return {ASSEMBLY: BROKEN}
    if not has_enclosable_laws(problem.programme):
        return {limit.name: UNDECIDED for limit in problem.limits}
    exact, verdicts = with_rounding_relative_error(problem), dict[str, str]()
    for limit in exact.limits:
        presumed = verdicts.get(limit.prerequisite_limit_name, HELD)
        verdicts[limit.name] = (
            presumed if presumed != HELD else limit_verdict_over_box(exact, limit, design, {}, budget).verdict
        )
    return verdicts


class Certificate(Result, dict[str, str]):
    """Verdict on each limit of one cam, by the limit's name: held, broken or undecided.

    Parameters
    ----------
    verdicts : Mapping
        Verdicts by limit.
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
        """Verdict on each limit, for the cam or, with ``search.robust``, for all cams within its tolerances."""
        records = [{"limit": name, "verdict": verdict} for name, verdict in self.items()]
        robust = ", for every cam within the tolerances (search.robust)" if self.scene.search.robust else ""
        return table_of(f"At every cam angle{robust}", records, ["limit", "verdict"])

    def values_for_json(self) -> dict[str, str]:
        """Verdicts by limit."""
        return dict(self)

    @property
    def exit_code(self) -> int:
        """0 if all limits are held, 1 if one is broken, else 4: one is undecided."""
        return exit_code_of_verdicts(self.values())


def exit_code_of_verdicts(verdicts: Iterable[str]) -> int:
    """Exit code for some verdicts."""
    return {BROKEN: NOTHING_FEASIBLE, UNDECIDED: NOT_REACHED, HELD: 0}[worst_verdict(verdicts)]


def certify(scene: SceneSource) -> Certificate:
    """Prove or refute each limit of a scene for its design: held, broken or undecided, by the limit's name.

    Limits are decided at every cam angle of the continuous motion, in interval arithmetic with outward rounding. A
    limit is undecided if the quantity is so near to it that rounding hides the difference, mostly 1e-14 of the
    limit. An undecided design is not feasible.

    A disc cam also has the verdict ``self_crossing``: held if the profile is proved not to cross itself, else
    broken. It is decided in double precision with margins for rounding (``effects.self_crossing``). Some other
    limits are also decided in double precision, by the enclosures of their quantities: limits on means and other
    integrals over the turn, on derivatives of the motion, and on errors in dwells due to tolerances; other errors,
    if the follower has two contacts, the train's ratio changes, or its links have errors; the jump speed, the
    preload and the spring rate required; the half-width of a contact; the fluctuation of energy; and quantities
    that the scene defines. Limits on Python functions, and on expressions of the places of extremes, stay
    undecided.

    If moves have conditions, ``conditions`` is held if the motion meets all of them: within 1e-6 of the largest
    displacement and velocity, 1e-5 of the acceleration and 1e-3 of the jerk.

    Numbers of the scene are taken as double-precision numbers. A law that the scene gives as a table is the spline
    through its points. With a law that another package defines by functions, all limits stay undecided.

    With ``search.robust`` a limit is held only if every cam within the tolerances of its numbers and its train
    holds it, at all cam angles.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with sizes.

    Returns
    -------
    Certificate
        A dict: "held", "broken" or "undecided" for each limit. A design that cannot be assembled has only
        ``assembly``.

    Raises
    ------
    BadInput
        If the scene lacks a size.

    References
    ----------
    R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6 and 11.

    Examples
    --------
    >>> verdicts = camopt.certify(camopt.find_scene("roller-1000rpm"))
    >>> verdicts["pressure_angle"], verdicts["undercut"]
    ('broken', 'held')
    """
    scene = scene_from(scene)
    return Certificate(certify_limits_and_conditions(resolve_design(scene)), scene)


def certify_limits_and_conditions(problem: Problem) -> dict[str, str]:
    """Certify a scene that is already resolved to a problem."""
    conditions = verdict_on_all_move_conditions(problem.given_motion)
    if conditions and not has_enclosable_laws(problem.programme):
        conditions = UNDECIDED
    return certify_design_and_tolerance_box(problem) | ({} if conditions is None else {CONDITIONS: conditions})


def certify_design_and_tolerance_box(problem: Problem) -> dict[str, str]:
    """Certify the problem's own design and, with ``search.robust``, all cams within its tolerances.

    A disc cam also has a verdict on ``self_crossing``.
    """
    verdicts = certify_limits(problem, problem.design)
    if ASSEMBLY in verdicts:
        return verdicts
    verdicts |= {
        limit.name: UNDECIDED for limit in problem.limits if limit.lacks_enclosure and limit.name in verdicts
    }
    if problem.setup.mechanism.body.closed:  # flat faces and knife edges cross only where undercut
        verdicts[SELF_CROSSING] = verdicts.get(SELF_CROSSING, verdicts.get(UNDERCUT, HELD))
    if not problem.zones:
        return verdicts
    exact = with_toleranced_numbers_per_design(with_rounding_relative_error(problem))
    ends, names = tolerance_ranges(exact, exact.design), {limit.name for limit in problem.limits}
    for limit in exact.limits:
        if limit.name in names:
            over_box = limit_verdict_over_box(exact, limit, exact.design, ends).verdict
            verdicts[limit.name] = worst_verdict([verdicts[limit.name], over_box])
    return verdicts


def verdict_on_all_move_conditions(programme: Programme) -> str | None:
    """Verdict on all conditions of the moves together; None without conditions."""
    verdicts = [
        _verdict_on_move_condition(condition, stroke)
        for stroke in programme.strokes
        if stroke.key
        for condition in stroke.conditions_in_mm_or_rad(programme.strokes[0].low)
    ]
    return worst_verdict(verdicts) if verdicts else None


def _verdict_on_move_condition(condition: Condition, stroke: Stroke) -> str:
    part, alone = stroke.part_under_condition(condition), Programme((stroke,))
    assert part is not None
    table = alone.table
    low, high = ((stroke.start + stroke.angle * x - table.centre) / table.half_width for x in part)
    if part[0] == part[1]:  # where two pieces meet, the jerk of either may hold
        verdicts = [
            _condition_verdict_over_panel_parts(
                condition, alone, np.array([k]), *[np.clip(low[[k]], -1.0, 1.0)] * 2
            )
            for k in np.flatnonzero(np.abs(low) <= 1.0 + PANEL_TOLERANCE)
        ]
        return HELD if HELD in verdicts else verdicts[0]
    low, high = np.maximum(low, -1.0), np.minimum(high, 1.0)
    panels = np.flatnonzero(high - low > PANEL_TOLERANCE)
    ends = low[panels, None] + (high - low)[panels, None] * (np.arange(CONDITION_PARTS + 1) / CONDITION_PARTS)
    starts, ends = np.hstack([ends[:, :-1], ends[:, [0, -1]]]), np.hstack([ends[:, 1:], ends[:, [0, -1]]])
    return _condition_verdict_over_panel_parts(
        condition, alone, np.repeat(panels, CONDITION_PARTS + 2), starts.ravel(), ends.ravel()
    )


def _condition_verdict_over_panel_parts(
    condition: Condition, stroke_programme: Programme, panels: IntArray, start: FloatArray, end: FloatArray
) -> str:
    """Verdict on a condition over parts of panels: whether its derivative stays within the range."""
    order, place = condition.order, part_middles_and_angle_intervals(stroke_programme.table, panels, start, end)
    derivative = derivative_intervals_over_parts(stroke_programme.table, panels, *place, 4)[order]
    least, most = weighted_derivative_range(stroke_programme, (0.0,) * order + (1.0,), ALL_STROKES)
    room = SOLVER_TOLERANCE[order] * max(abs(least), abs(most))
    low, high = condition.low - room, condition.high + room
    if np.any(derivative.at.low > high) or np.any(derivative.at.high < low):
        return BROKEN
    return HELD if np.all((derivative.value.low >= low) & (derivative.value.high <= high)) else UNDECIDED

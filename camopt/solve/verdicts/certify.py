"""Certify: whether a design holds each of its limits at every cam angle, decided in intervals.

A limit is a constraint that a curve stays below a bound, which ``limit_boxes`` decides, over no box at all or over
that of tolerances.
"""

from collections.abc import Iterable, Mapping
from math import inf
from types import ModuleType
from typing import Any

import numpy as np

from camopt.core.mistakes import NOT_REACHED, NOTHING_FEASIBLE
from camopt.core.numerics import FloatArray, IntArray
from camopt.core.numerics.motion_ranges import angle_over, derivatives_over
from camopt.model.mechanisms import Designs
from camopt.model.motion.installed_laws import EXACT_CLASSES
from camopt.model.motion.profile_law import ProfileLaw
from camopt.model.motion.programme import Programme, weighted_range
from camopt.model.motion.stroke import ALL_STROKES, SOLVER_TOLERANCE, Condition, Stroke
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.problem.limit import ASSEMBLY, SELF_CROSSING, UNDERCUT
from camopt.scene.problem.problem import Problem, at_rounding_error, resolve_design
from camopt.scene.problem.settings import with_toleranced_numbers
from camopt.scene.scene import Scene
from camopt.solve.tables.result import Result, Table, table_of
from camopt.solve.verdicts.limit_boxes import limit_over_box, tolerance_ranges
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED, worst_verdict

CONDITIONS = "conditions"
OWN_LAWS = "camopt.model.motion."
"""How the names of modules of laws begin."""
CONDITION_PARTS = 512
"""Of each panel, for conditions: the range of a part is then too wide by far less than what a motion may miss."""
PANEL_TOLERANCE = 1e-9
"""Of half a panel: a panel that a range of cam angles enters by less is left out."""


def is_proved(programme: Programme) -> bool:
    """Whether more is known of each law of a turn than what its functions give."""
    return all(_is_own_law(stroke.law) for stroke in programme.strokes)


def _is_own_law(law: Any) -> bool:
    """Whether a law, or the one that it is made of, is of camopt's own."""
    if inner := getattr(law, "law", None):
        return _is_own_law(inner)
    known = law is None or isinstance(law, (*EXACT_CLASSES, ProfileLaw))
    return known or (isinstance(law, ModuleType) and law.__name__.startswith(OWN_LAWS))


def certify_limits(problem: Problem, design: Designs, until: float = inf) -> dict[str, str]:
    """The verdict on each limit for one design: held, broken or undecided, as at ``until`` (``clock.now``)."""
    if not problem.setup.mechanism.can_assemble(design, problem.programme)[0]:
        return {ASSEMBLY: BROKEN}
    if not is_proved(problem.programme):
        return {limit.name: UNDECIDED for limit in problem.limits}
    exact, verdicts = at_rounding_error(problem), dict[str, str]()
    for limit in exact.limits:
        presumed = verdicts.get(limit.presumed_limit, HELD)
        verdicts[limit.name] = (
            presumed if presumed != HELD else limit_over_box(exact, limit, design, {}, until).verdict
        )
    return verdicts


def certify_design(problem: Problem, design: Designs) -> dict[str, str]:
    """As ``certify_limits``, and for a disc cam whether it is free of a self-crossing, under ``self_crossing``."""
    verdicts = certify_limits(problem, design)
    verdicts |= {
        limit.name: UNDECIDED for limit in problem.limits if limit.lacks_enclosure and limit.name in verdicts
    }
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
        return exit_code_of(self.values())


def exit_code_of(verdicts: Iterable[str]) -> int:
    """The exit code of some verdicts."""
    return {BROKEN: NOTHING_FEASIBLE, UNDECIDED: NOT_REACHED, HELD: 0}[worst_verdict(verdicts)]


def certify(scene: SceneSource) -> Certificate:
    """Prove or refute each limit of a scene for its design: held, broken or undecided, by the limit's name.

    Limits are decided at every cam angle of the continuous motion, in interval arithmetic with room for every
    rounding. Undecided is what lies so near its limit that rounding hides it: mostly some 1e-14 of the limit. It is
    not feasible.

    For a disc cam ``self_crossing`` is there too: held if the profile provably crosses itself nowhere, broken if it
    does; decided in double precision, with margins for rounding (``effects.self_crossing``). Decided in doubles, by
    the enclosures of their quantities, are also limits on means and other integrals over the turn, on derivatives
    of the motion, on errors by tolerances in dwells, and on others where no curve tells them (of two contacts,
    through a train of a changing ratio or with links that are off), on the jump speed, the preload and the spring
    rate that are required, the half-width of a contact, the fluctuation of energy, and quantities of the scene's
    own. Limits on Python functions, and on expressions of where something is, stay undecided.

    Where moves are asked for anything, ``conditions`` is there: held if they meet it all, to a millionth of the
    largest displacement and velocity, a hundred-thousandth of the acceleration and a thousandth of the jerk.

    Numbers of the scene are taken as doubles have them. A law that the scene gives as a table is the spline through
    its points. With a law that another package brings as functions, all limits stay undecided.

    With ``search.robust`` a limit is held if every cam within the tolerances of its numbers and of its train holds
    it, over the whole box of numbers and all cam angles at once.

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
    R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6 and 11.

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
    asked = conditions_verdict(problem.given_motion)
    if asked and not is_proved(problem.programme):
        asked = UNDECIDED
    return certify_cams(problem) | ({} if asked is None else {CONDITIONS: asked})


def certify_cams(problem: Problem) -> dict[str, str]:
    """As ``certify_design``, of the problem's own design with all cams within its tolerances, if these count."""
    verdicts = certify_design(problem, problem.design)
    if not problem.zones or ASSEMBLY in verdicts:
        return verdicts
    return verdicts | {
        name: worst_verdict([verdicts[name], each]) for name, each in certify_tolerance_box(problem).items()
    }


def certify_tolerance_box(problem: Problem, until: float = inf) -> dict[str, str]:
    """The verdicts on limits of all cams within the tolerances of a problem's own design, in intervals."""
    every = with_toleranced_numbers(at_rounding_error(problem))
    ends = tolerance_ranges(every, every.design)
    return {limit.name: limit_over_box(every, limit, every.design, ends, until).verdict for limit in every.limits}


def verdict_of_design(verdicts: dict[str, str]) -> str:
    """One word for a design: broken if any limit is, undecided if any is, else held."""
    return worst_verdict(verdicts.values())


def conditions_verdict(programme: Programme) -> str | None:
    """Whether all conditions hold: held, broken or undecided; None if nothing is asked."""
    start = programme.strokes[0].low
    found = [
        _condition_verdict(each, stroke)
        for stroke in programme.strokes
        if stroke.key
        for each in stroke.required_conditions(start)
    ]
    return worst_verdict(found) if found else None


def _condition_verdict(condition: Condition, stroke: Stroke) -> str:
    part, alone = stroke.part_under(condition), Programme((stroke,))
    assert part is not None
    table = alone.table
    low, high = ((stroke.start + stroke.angle * x - table.centre) / table.half_width for x in part)
    if part[0] == part[1]:  # where two pieces meet either may have the jerk
        found = [
            _condition_over_parts(condition, alone, np.array([k]), *[np.clip(low[[k]], -1.0, 1.0)] * 2)
            for k in np.flatnonzero(np.abs(low) <= 1.0 + PANEL_TOLERANCE)
        ]
        return HELD if HELD in found else found[0]
    low, high = np.maximum(low, -1.0), np.minimum(high, 1.0)
    panels = np.flatnonzero(high - low > PANEL_TOLERANCE)
    ends = low[panels, None] + (high - low)[panels, None] * (np.arange(CONDITION_PARTS + 1) / CONDITION_PARTS)
    starts, ends = np.hstack([ends[:, :-1], ends[:, [0, -1]]]), np.hstack([ends[:, 1:], ends[:, [0, -1]]])
    return _condition_over_parts(
        condition, alone, np.repeat(panels, CONDITION_PARTS + 2), starts.ravel(), ends.ravel()
    )


def _condition_over_parts(
    condition: Condition, alone: Programme, panels: IntArray, start: FloatArray, end: FloatArray
) -> str:
    """Whether a condition holds over parts of panels: below one end of its range, and above the other."""
    order, place = condition.order, angle_over(alone.table, panels, start, end)
    moved = derivatives_over(alone.table, panels, *place, 4)[order]
    least, most = weighted_range(alone, (0.0,) * order + (1.0,), ALL_STROKES)
    room = SOLVER_TOLERANCE[order] * max(abs(least), abs(most))
    low, high = condition.low - room, condition.high + room
    if np.any(moved.at.low > high) or np.any(moved.at.high < low):
        return BROKEN
    return HELD if np.all((moved.value.low >= low) & (moved.value.high <= high)) else UNDECIDED

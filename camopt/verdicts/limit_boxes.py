"""Whether every design of a box of sizes holds a limit: the verdict on all of its claims (``claim_boxes``).

A limit on what sizes decide is one on a range. One without claims, as on the mass, stays undecided where no design
of the box is known that breaks it. A profile crosses itself nowhere if the largest pressure angle of all designs of
the box shows it (``effects.crossing.round_bodies``).
"""

from math import inf

import numpy as np

from camopt.effects import EFFECTS, Case
from camopt.effects.crossing import round_bodies
from camopt.effects.peak import Derivative
from camopt.mechanisms import Designs
from camopt.mechanisms.design import SECOND_SIZE
from camopt.motion.table import ALL_STROKES
from camopt.numerics import LARGEST_MAGNITUDE
from camopt.numerics.interval import Interval, as_interval
from camopt.problem.claims import AnyClaim, Claim, Plain
from camopt.problem.limit import SELF_CROSSING, Limit
from camopt.problem.problem import Problem
from camopt.quantities import QUANTITIES
from camopt.verdicts.claim_boxes import Answer, Ends, over_box
from camopt.verdicts.ranges import is_ranged, ranged
from camopt.verdicts.running import run_effects
from camopt.verdicts.words import BROKEN, HELD, UNDECIDED

OF_BODY = ("size", SECOND_SIZE)
"""The sizes of cams: a circle within the base circle is so in all, if it is in the least."""
SPEED = "cam.rpm"
STEEPER = 1.0 + 1e-6
"""How much steeper than at the corners of a box the pressure angle may be in it, as a first guess."""


def ends_within(problem: Problem, design: Designs) -> Ends:
    """Between which values numbers of the cams are that have to hold the limits with a design, by field."""
    nominal = {field: float(design.values[field][0]) for field in problem.zones}
    return {f: (nominal[f] + zone.lower, nominal[f] + zone.upper) for f, zone in problem.zones.items()}


def limit_over_box(problem: Problem, limit: Limit, design: Designs, ends: Ends, until: float = inf) -> Answer:
    """Whether all designs that differ from one by sizes between their ends hold a limit.

    One on errors by tolerances is that of the design alone.
    """
    if limit.of_errors:
        ends = {}
    if limit.of_base:
        design = design.with_values({field: np.array([ends[field][0]]) for field in OF_BODY if field in ends})
    if limit.is_of_motion or limit.of_base:
        columns = run_effects(Case(problem.setup, problem.programme, design), limit.needs).shifted(1.0)
        return Answer(HELD) if limit.excess(columns, design)[0] <= 0.0 else Answer(BROKEN, design)
    if limit.infinite_at(problem.programme):
        return Answer(BROKEN, design)
    if limit.claims and all(isinstance(each.curve, Derivative) for each in limit.claims):
        return _at_speeds(problem, limit, design, ends)
    if limit.name == SELF_CROSSING:
        return Answer(HELD if _round(problem, design, ends, until) else UNDECIDED)
    effects = [EFFECTS[QUANTITIES[name].effect] for name in limit.needs]
    if effects and all(is_ranged(each, problem.setup) for each in effects):
        box = design.with_values({n: Interval(np.array([a]), np.array([b])) for n, (a, b) in ends.items()})
        excess = as_interval(limit.excess(ranged(problem, {*limit.needs}, box, 1.0), box))
        return Answer(HELD if np.all(excess.high <= 0.0) else UNDECIDED)
    claims: list[AnyClaim] = [*limit.claims, *([] if limit.mean is None else [limit.mean])]
    found = [over_box(problem, each, design, ends, until) for each in claims]
    broken = [each for each in found if each.verdict == BROKEN]
    if broken:
        return broken[0]
    return Answer(HELD if found and all(each.verdict == HELD for each in found) else UNDECIDED)


def _at_speeds(problem: Problem, limit: Limit, design: Designs, ends: Ends) -> Answer:
    """Whether designs hold a limit on a derivative of the motion: it is a number times a power of the speed."""
    speeds = ends.get(SPEED)
    every = design
    if speeds is not None:
        every = design.take([0, 0]).with_values({SPEED: np.array(speeds)})
    columns = run_effects(Case(problem.setup, problem.programme, every), limit.needs).shifted(1.0)
    return Answer(HELD if np.all(limit.excess(columns, every) <= 0.0) else UNDECIDED)


def _round(problem: Problem, design: Designs, ends: Ends, until: float) -> bool:
    """Whether the largest pressure angle shows that no design of a box crosses itself."""
    mechanism, name = problem.setup.mechanism, "pressure_angle_max_deg"
    corners = np.array(np.meshgrid(*ends.values())).reshape(len(ends), -1)
    every = design.take(np.zeros(corners.shape[1], dtype=int))
    every = every.with_values(dict(zip(ends, corners, strict=True)))
    columns = run_effects(Case(problem.setup, problem.programme, every), [name]).shifted(1.0)
    most = float(np.max(columns[name])) * STEEPER
    if not most < 90.0:
        return False
    steepest = Claim(mechanism.pressure, ALL_STROKES, LARGEST_MAGNITUDE, Plain(float(np.tan(np.radians(most)))))
    if over_box(problem, steepest, design, ends, until).verdict != HELD:
        return False
    box = design.with_values({n: Interval(np.array([a]), np.array([b])) for n, (a, b) in ends.items()})
    bodies = round_bodies(Case(problem.setup, problem.programme, box, {name: np.array([most])}))
    return bool(np.all(as_interval(bodies).low > as_interval(box.roller_radius).high))

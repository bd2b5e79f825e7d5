"""Whether every design of a box of sizes holds a limit: the verdict on all of its claims (``claim_boxes``).

A limit on what sizes decide is one on a range. One without claims, as on the mass, stays undecided where no design
of the box is known that breaks it. A profile crosses itself nowhere, and of a pair neither does, if its largest
pressure angle of all designs of the box shows it (``effects.crossing.round_bodies``).
"""

from dataclasses import replace
from itertools import product
from math import inf
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST_MAGNITUDE
from camopt.core.numerics.interval import Interval, as_interval
from camopt.model.effects import Case, effect_of
from camopt.model.effects.contacts import SeenCurve, at_contact, contacts_of
from camopt.model.effects.crossing import round_bodies
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms.design import SECOND_SIZE, Contact, Designs
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.claims import AnyClaim, Claim, Plain
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.rows import Rows
from camopt.scene.problem.zones import Off, of_train
from camopt.solve.verdicts.claim_boxes import Answer, Ends, over_box
from camopt.solve.verdicts.ranges import is_ranged, ranged
from camopt.solve.verdicts.running import run_effects
from camopt.solve.verdicts.train_boxes import claim_over_trains, enters_train, limit_over_trains, motion_over_trains
from camopt.solve.verdicts.train_means import mean_over_trains
from camopt.solve.verdicts.words import BROKEN, HELD, UNDECIDED

OF_BODY = ("size", SECOND_SIZE)
"""The sizes of cams: a circle within the base circle is so in all, if it is in the least."""
SPEED = "cam.rpm"
ROUNDED = 1e-13
"""Relative: what doubles lose of a derivative of the motion, of which the jerk loses the most
(``piecewise.TABLE_ERRORS``)."""
STEEPER = (1e-6, 1e-3, 1e-2, 1e-1)
"""How much steeper than at the corners of a box, relative, the pressure angle may be in it: to be proved."""


def ends_within(problem: Problem, design: Designs) -> Ends:
    """Between which values numbers of the cams are that have to hold the limits with a design, by field."""
    nominal = nominal_at(problem, design)
    return {f: (nominal[f] + zone.lower, nominal[f] + zone.upper) for f, zone in problem.zones.items()}


def nominal_at(problem: Problem, design: Designs) -> Off:
    """The numbers of a design and its train that zones are about, by field."""
    own = design.values
    return {f: float(own[f][0]) if f in own else problem.nominal[f] for f in problem.zones}


def limit_over_box(problem: Problem, limit: Limit, design: Designs, ends: Ends, until: float = inf) -> Answer:
    """Whether all designs that differ from one by numbers between their ends hold a limit, trains among them.

    One on errors by tolerances is that of the design alone.
    """
    if limit.of_errors:
        ends = {}
    if limit.decided:
        return Answer(_crossing_verdict(problem, limit, design, ends, until))
    if of_train(ends):
        if enters_train(problem, limit):
            if limit.mean is not None and not limit.claims:
                return mean_over_trains(problem, limit.mean, design, ends, until)
            return limit_over_trains(problem, limit, design, ends, until)
        ends = _own(ends)
    if limit.infinite_at(problem.programme):
        return Answer(BROKEN, design)
    claims: list[AnyClaim] = [*limit.claims, *([] if limit.mean is None else [limit.mean])]
    if claims and all(map(_is_derivative, claims)):
        return _at_speeds(problem, limit, design, ends)
    if limit.of_base:
        least = {field: np.array([ends[field][0]]) for field in OF_BODY if field in ends}
        return _by_quantities(problem, limit, design.with_values(least))
    if not claims and (not ends or limit.is_of_motion):
        return _by_quantities(problem, limit, design)
    if ends and _is_ranged(problem, limit):
        return _by_ranges(problem, limit, design, ends)
    found = [over_box(problem, each, design, ends, until) for each in claims]
    broken = [each for each in found if each.verdict == BROKEN]
    if broken:
        return broken[0]
    return Answer(HELD if found and all(each.verdict == HELD for each in found) else UNDECIDED)


def _crossing_verdict(problem: Problem, limit: Limit, design: Designs, ends: Ends, until: float) -> str:
    """Whether no profile crosses itself: by the profile of one design, of a box by its largest pressure angle."""
    if ends:
        return HELD if _round(problem, design, ends, until) else UNDECIDED
    assert limit.decided is not None
    broken = limit.decided(problem.setup, design, problem.programme)
    return UNDECIDED if broken is None else BROKEN if broken else HELD


def _is_ranged(problem: Problem, limit: Limit) -> bool:
    """Whether arithmetic on ranges of sizes, or of what decides the motion, decides a limit."""
    effects = [effect_of(name, problem.setup) for name in limit.needs]
    return bool(effects) and all(is_ranged(each, problem.setup) for each in effects)


def _by_ranges(problem: Problem, limit: Limit, design: Designs, ends: Ends) -> Answer:
    """Whether designs between ends hold such a limit."""
    box = design.with_values({n: Interval(np.array([a]), np.array([b])) for n, (a, b) in ends.items()})
    excess = as_interval(limit.excess(ranged(problem, {*limit.needs}, box, 1.0), box))
    return Answer(HELD if np.all(excess.high <= 0.0) else UNDECIDED)


def _own(ends: Ends) -> Ends:
    """The ends of what designs bring, without those of trains."""
    trains = of_train(ends)
    return {field: each for field, each in ends.items() if field not in trains}


def _at_speeds(problem: Problem, limit: Limit, design: Designs, ends: Ends) -> Answer:
    """Whether designs hold a limit on a derivative of the motion: it is a number times a power of the speed."""
    if speeds := ends.get(SPEED):
        design = design.take([0, 0]).with_values({SPEED: np.array(speeds)})
    return _by_quantities(problem, limit, design, ROUNDED)


def _is_derivative(claim: AnyClaim) -> bool:
    """Whether a claim is on the motion itself."""
    curves = [claim.curve] if isinstance(claim, Claim) else [make for make, _ in claim.mean.curves]
    return all(isinstance(each, Derivative) for each in curves)


def _width(rows: Rows, name: str, rounded: float) -> Any:
    """How far the true value of a quantity may be from its column, outwards: its enclosure, and rounding."""
    outward = rows.outward.get(name, 0.0)
    value = np.where(np.isfinite(rows.columns[name]), rows.columns[name], 0.0)
    return outward + np.copysign(rounded * np.abs(value), outward)


def _by_quantities(problem: Problem, limit: Limit, designs: Designs, rounded: float = 0.0) -> Answer:
    """The verdict on a limit of some designs, from the enclosures of its quantities in doubles.

    Of quantities that sizes decide the doubles are compared as they are.
    """
    rows = run_effects(Case(problem.setup, problem.programme, designs), limit.needs)
    rows = replace(rows, outward={name: _width(rows, name, rounded) for name in rows.columns})
    outer, inner = (limit.excess(rows.shifted(share), designs) for share in (1.0, -1.0))
    if np.all(outer <= 0.0):
        return Answer(HELD)
    broken = np.flatnonzero(inner > 0.0)
    return Answer(BROKEN, designs.take(broken[:1])) if broken.size else Answer(UNDECIDED)


def _round(problem: Problem, design: Designs, ends: Ends, until: float) -> bool:
    """Whether the largest pressure angle shows that no disc of a design of a box crosses itself."""
    return all(_round_at(problem, contact, design, ends, until) for contact in contacts_of(problem.setup))


def _round_at(problem: Problem, contact: Contact, design: Designs, ends: Ends, until: float) -> bool:
    """The same of the disc at one contact."""
    name = "pressure_angle_max_deg"
    own = _own(ends)
    corners = np.array([*product(*own.values())])
    every = design.take(np.zeros(len(corners), dtype=int)).with_values(dict(zip(own, corners.T, strict=True)))
    columns = run_effects(at_contact(Case(problem.setup, problem.programme, every), contact), [name]).shifted(1.0)
    curve = SeenCurve(contact.mechanism.pressure, contact.seen)
    for steeper in STEEPER:
        most = float(np.max(columns[name])) * (1.0 + steeper)
        if not most < 90.0:
            return False
        steepest = Claim(curve, ALL_STROKES, LARGEST_MAGNITUDE, Plain(float(np.tan(np.radians(most)))))
        over = over_box if own == ends else claim_over_trains
        if over(problem, steepest, design, ends, until).verdict == HELD:
            break
    else:
        return False
    box = design.with_values({n: Interval(np.array([a]), np.array([b])) for n, (a, b) in own.items()})
    turn: Any = problem.programme if own == ends else motion_over_trains(problem, steepest, design, ends)
    if turn is None:
        return False
    seen = replace(at_contact(Case(problem.setup, turn, box), contact), found={name: np.array([most])})
    return bool(np.all(as_interval(round_bodies(seen)).low > as_interval(seen.setup.half_width(seen.designs)).high))

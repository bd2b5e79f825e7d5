"""The largest errors of the motion of the tool, of all cams within the tolerances: bounds and witnesses.

The exact error of a cam in displacement, velocity or acceleration, the orders 0 to 2, is one formula of its errors
and of the point that is touched (``tolerances.real_cam``). Run on ranges with slopes, its bound over all errors is
cut along the turn, where it is the highest (``tolerances.bound``). Of two contacts both errors are those at one cam
angle; the place of the second one is enclosed by its own equation (``tolerances.enclosures``).

Where y'' jumps, a cam that is late has the whole jump for an error of its acceleration until it is there. Within
reach of a jump, as far as any cam is late or early, the proof counts it with every cam: its bound is the jump and
what else is off. With two contacts a jump of y'' or y''' next to φ may lie between φ and θ or not, and between φ
and the place of the second contact or not. Each of these cases is proved of all cams: the motion has no jump then,
so that slopes of errors are those of one side of it.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6 and 11.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from math import degrees, inf, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import now, share
from camopt.model.effects.answers import SECOND
from camopt.model.effects.case import Case
from camopt.model.effects.curvature import CONVEX
from camopt.model.effects.motion import scale
from camopt.model.motion.programme import JUMP_SIDE, Jump, jumps_of
from camopt.scene.problem.problem import Problem
from camopt.scene.tolerances import ANGLES
from camopt.solve.tolerances.bound import (
    ROOM,
    Bound,
    BoundSearch,
    Passed,
    Quantity,
    Values,
    box_of,
    first_parts,
    late,
)
from camopt.solve.tolerances.enclosures import ContactAhead, FurtherOn, Place, through
from camopt.solve.tolerances.errors import BORE, BORE_WAY, LEVEL, WAY, Errors, ends_of, flat, is_way, polar, way_of
from camopt.solve.tolerances.real_cam import TOUCHES, Contact, RealCam, errors_of
from camopt.solve.tolerances.turn import TurnErrors, highest
from camopt.solve.verdicts.claim_boxes import Ends
from camopt.solve.verdicts.running import run_effects

GAP, RATE_GAP = 1e-5, 1e-3
"""By no more than this, relative, a cam may be worse than the worst found: in displacement, and in the others."""
SECONDS, RATE_SECONDS = 20.0, 9.0
"""For each bound."""
PROFILE_PLACES = "tolerances.profile (part.profile_tolerance)"
CORNERS = "the velocity of the motion jumps"
SLOPES = "the slope of the profile's error has no bound without tolerances.waves"
HOLLOWS = (
    "a flat face lies on the crests of waves as high and short as those of the profile, and does not follow them"
)
HALVINGS = 12
"""Of a tolerance that is too large, for the largest one that is not."""
QUARTERS = (0.0, 0.5 * pi, pi, -0.5 * pi)
TRIED = (pi, *(side * each for each in (1.0, 0.3, 0.1, 0.03, 0.01) for side in (-1.0, 1.0)))
"""By how much a way is changed to find a worse cam, rad."""
CLIMBS = 2
"""How often each error is changed for it."""
LATER = tuple(side * each for side in (1.0, -1.0) for each in (0.1, 1.0, 10.0))
"""How much it counts how late a cam is, to find the worst one at a jump."""
BESIDE = 1e-9
"""Of a jump, rad."""
FINER, ZOOMS = 9, 6
"""Cams between two that are looked at, and how often between the neighbours of the worst one."""


class WorstCase(NamedTuple):
    """The largest error of a displacement, velocity or acceleration of the tool of any cam within the tolerances.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm").replace(tolerances={"follower.offset": 0.02})
    >>> worst = camopt.tolerance(scene).worst_case
    >>> round(worst.bound, 5), round(worst.error, 5), worst.errors
    (0.01778, -0.01778, {'follower.offset': 0.02})
    """

    bound: float
    """No cam within the tolerances has a larger error, proved; infinite if that is not known. mm (deg), or in the
    unit of the velocity or the acceleration."""
    error: float
    """That of a cam which has these ``errors``, by exact contact; below 0 where the tool is too low."""
    at_deg: float
    """The cam angle at which it has it."""
    errors: dict[str, float]
    """Of that cam, by key of ``[tolerances]``, mm and deg; ``bore_eccentricity_way`` is the direction in which the
    axis of the profile is off that of the bore, in the frame of the cam that does not turn, at the cam angle 0. A
    profile with n waves stands out by ``profile`` times cos(nφ − ``profile_way``) at the cam angle φ."""
    unproved: str = ""
    """Why no bound is proved; "" if one is."""

    @property
    def gap(self) -> float:
        """By how much some cam may be worse than that one."""
        return self.bound - abs(self.error)


NOT_OFF = WorstCase(0.0, 0.0, 0.0, {})
"""That of cams with tolerances that move no tool."""


def tool_error(cam: RealCam, order: int) -> Quantity:
    """The exact error of a derivative of the tool's motion where the first contact touches, over boxes of errors.

    In mm (rad) by powers of rad.
    """
    problem = cam.problem

    def error(errors: Errors, at: Place) -> Any:
        moved = cam.rest(0, problem.design, cam.own(0, errors), at.motion, order)
        further = FurtherOn(problem.programme, at, moved.turned.terms[0], at.jumped)
        found = errors_of(moved, at.motion, further.by, at.jumped.by2, order)
        if len(cam.contacts) > 1:
            second = ContactAhead(cam, 1, errors, errors, at)
            both = zip(found, second.errors_at(further, order), strict=True)
            found = [(a + b * second.sign) * 0.5 for a, b in both]
        return through(problem, errors, found, further.motion)

    return error


def turned_on_by(cam: RealCam, number: int) -> Quantity:
    """How far from the cam angle of a place the motion counts, rad: where the cam touches, or a second contact."""

    def turned(errors: Errors, at: Place) -> Any:
        found = cam.rest(0, cam.problem.design, cam.own(0, errors), at.motion, 0).turned.terms[0]
        return ContactAhead(cam, 1, errors, errors, at).ahead(found) if number else found

    return turned


class Found(NamedTuple):
    """A cam that is off, mm and rad, with the cam angle of its profile where it is the most, and by how much."""

    errors: Values
    angle: float
    error: float


@dataclass(frozen=True)
class WorstSearch:
    """The search for the worst of the cams within tolerances, with one contact or two."""

    turn: TurnErrors
    ends: Ends
    """Between which values each error is (``errors.ends_of``)."""
    order: int = 0
    """Of the derivative of the motion that is looked at: displacement, velocity, acceleration."""

    @property
    def problem(self) -> Problem:
        return self.turn.problem

    @cached_property
    def cam(self) -> RealCam:
        """The cams; a profile without waves counts as off by a constant, and to order 0 any."""
        return RealCam(self.problem, (self.turn.scene.tolerances.waves or 0) if self.order else 0)

    def run(self) -> WorstCase:
        """The worst cam that is found, and what no cam exceeds.

        BadInput for tolerances so large that a follower has no place on its cam.
        """
        try:
            worst = self._found(self.first())
            if why := self.unbounded:
                return self._told(worst, inf, why)
            seconds = RATE_SECONDS if self.order else SECONDS
            until = now() + seconds
            bound = self.bound(abs(worst.error), RATE_GAP if self.order else GAP, until)
            if bound.cam is not None:
                worst = max(worst, self._found(self.known(bound.cam)), key=lambda each: abs(each.error))
            return self._told(worst, bound.high, late(bound.high, seconds, until))
        except FloatingPointError:
            raise self.lost() from None

    def _told(self, found: Found, bound: float, unproved: str) -> WorstCase:
        unit, (errors, angle, error) = scale(self.problem.setup, self.order), found
        there = float(self.contact(errors, np.array([angle])).angle[0])
        at = degrees(float(self.cam.within(np.array([there]))[0]))
        return WorstCase(unit * bound, unit * error, at, self.said(errors, angle, there), unproved)

    def known(self, cam: Values) -> Values:
        """The errors of a cam without other variables of a proof."""
        return {key: cam[key] for key in self.ends}

    @property
    def unbounded(self) -> str:
        """Why there is no bound; "" where there may be one."""
        given = self.turn.scene.tolerances
        if self.problem.programme.corners:
            return CORNERS
        if not self.order or not given.profile:
            return ""
        return SLOPES if given.waves is None else HOLLOWS if self._lies_on_crests(given.profile) else ""

    def _lies_on_crests(self, zone: float) -> bool:
        """Whether a flat face does not follow waves: with w the radius of the profile is ρ + w + w''."""
        problem, convex = self.problem, frozenset({CONVEX})
        if not problem.setup.mechanism.flat_faced:
            return False
        found = run_effects(Case(problem.setup, problem.programme, problem.design), convex).columns[CONVEX]
        return bool(found[0] <= (self.cam.waves**2 - 1) * zone)

    def _found(self, errors: Values) -> Found:
        return Found(errors, *self.highest(errors))

    def bound(self, least: float, gap: float, until: float, enough: float = inf) -> Bound:
        """What no cam within the tolerances exceeds, nor ``least`` times 1 + gap if that is proved until a time.

        Or a cam that exceeds what is ``enough``.
        """
        search = self.proof(tool_error(self.cam, self.order), self.reach)
        parts, found = search.parted(first_parts(self.problem, self.box)), Bound(-inf, least)
        cases = [*self.cases]
        for left, passed in zip(range(len(cases), 0, -1), cases, strict=True):
            more = replace(search, passed=passed).run(parts, found.found, gap, share(until, left), enough)
            cam = found.cam if more.cam is None else more.cam
            found = Bound(max(found.high, more.high), max(found.found, more.found), cam)
            parts = parts.take(np.flatnonzero(search.near(parts)))
            if not parts.size:
                break
        return found

    def proof(self, quantity: Quantity, reach: float = 0.0) -> BoundSearch:
        """The search for the bound of a quantity of all cams."""
        return BoundSearch(self.problem, quantity, self.ends, self.box, jumps=self.jumps, reach=reach)

    @property
    def cases(self) -> Iterable[Passed]:
        """What is proved one after the other of parts within reach of jumps."""
        if len(self.cam.contacts) == 1:
            return [(None, None)]
        return product((False, True) if self._whole else (None,), (False, True))

    @cached_property
    def box(self) -> Ends:
        """Between which values each number of an error is."""
        found = box_of(self.ends)
        level = [key for key in found if self.order == 2 and key.startswith(WAY)]
        return found | {key.replace(WAY, LEVEL): found[key] for key in level}

    @cached_property
    def jumps(self) -> tuple[Jump, ...]:
        """The jumps that count, where the motion is taken elsewhere than at the place: of y'' and of y'''."""
        orders = range(2, self.order + len(self.cam.contacts))
        return tuple(each for order in orders for each in jumps_of(self.problem.programme, (order,)))

    @cached_property
    def _whole(self) -> list[Jump]:
        """The jumps of y'' where two contacts have the whole of them for an error of the acceleration."""
        two = len(self.cam.contacts) > 1
        return [jump for jump in self.jumps if jump.order == self.order == 2 and two]

    @cached_property
    def reach(self) -> float:
        """As far as any cam is late or early, rad; 0 where no jump counts."""
        if not self.jumps:
            return 0.0
        parts = first_parts(self.problem, self.box, sides=(1.0,))
        parts = parts.cut(np.eye(1, len(parts.low)).T + np.zeros(parts.size))
        proofs = (self.proof(turned_on_by(self.cam, number)) for number in range(len(self.cam.contacts)))
        with np.errstate(all="ignore"):
            found = [proof.over(parts).value.largest_magnitude.max() for proof in proofs]
        return (1.0 + ROOM) * float(max(found))

    def contact(self, errors: Errors, angles: FloatArray, *, jumps: bool = True) -> Contact:
        """Where cams touch, and those of their motion there; or these but for what jumps of y'' make of them."""
        return self.cam.touch(flat(errors), angles, self.order, jumps=jumps)

    def first(self) -> dict[str, float]:
        """Errors that are the worst, or nearly so, at the worst cam angle: most of them at their ends.

        Where y'' jumps, both contacts have the whole jump for an error of cams that are hardly late: these are
        between late ones and those that are the worst but for it.
        """
        found = [self._furthest(side) for side in (1.0, -1.0)]
        if self.jumps:
            found += [self._at_jump(side, way) for side in (1.0, -1.0) for way in LATER]
        usual = self._climbed(max(found, key=lambda each: each.error))
        if not self._whole:
            return usual
        starts = {side: self._at_jump(side, 0.0) for side in (1.0, -1.0)}
        between = [self._between(starts[side], self._at_jump(side, way)) for side in starts for way in LATER]
        best = max(between, key=lambda each: each.error)
        return best.errors if best.error > abs(self.highest(usual)[1]) else usual

    def _furthest(self, side: float) -> Found:
        """Those that are furthest off to a side, at the worst cam angle."""

        def off(angles: FloatArray) -> FloatArray:
            return side * self.error(self.corner(angles, side), angles)

        return self._corner_at(highest(self.turn.nodes, off), side, 0.0)

    def _at_jump(self, side: float, late: float) -> Found:
        """Those at the worst side of a jump, the more of cams that are late or early the larger ``late`` is."""
        places, turn = np.array([each.at for each in self.jumps]), self.problem.programme.strokes[-1].end
        angles = np.mod(np.concatenate([places - JUMP_SIDE, places + JUMP_SIDE]), turn)
        found = np.abs(self.error(self.corner(angles, side, late), angles))
        return self._corner_at(float(angles[found.argmax()]), side, late)

    def _corner_at(self, angle: float, side: float, late: float) -> Found:
        at = np.array([angle])
        errors = self.corner(at, side, late)
        most = float(np.abs(self.error(errors, at))[0])
        return Found({key: float(each[0]) for key, each in errors.items()}, angle, most)

    def _climbed(self, found: Found) -> dict[str, float]:
        """Errors that are worse at a cam angle, each changed by itself."""
        errors, angle, most = found
        for _ in range(CLIMBS):
            for key, ends in self.ends.items():
                values = errors[key] + np.array(TRIED) if is_way(key) else np.array(ends)
                tried = {name: np.full(values.size, each) for name, each in errors.items()} | {key: values}
                off = np.abs(self.error(tried, np.full(values.size, angle)))
                if off.max() > most:
                    most, errors = float(off.max()), {**errors, key: float(values[off.argmax()])}
        return errors

    def _between(self, one: Found, other: Found) -> Found:
        """The worst of the cams between two, next to a jump."""
        ends, low, high = [flat(each.errors) for each in (one, other)], 0.0, 1.0
        for _ in range(ZOOMS):
            shares = np.linspace(low, high, FINER)
            errors = polar(
                {key: (1.0 - shares) * ends[0][key] + shares * ends[1][key] for key in ends[0]}, self.ends
            )
            places = self._beside_jumps(errors)
            every = {key: np.tile(each, len(places)) for key, each in errors.items()}
            found = np.abs(self.error(every, places.ravel())).reshape(places.shape)
            row, k = (int(each) for each in np.unravel_index(found.argmax(), found.shape))
            low, high = shares[max(k - 1, 0)], shares[min(k + 1, FINER - 1)]
        return Found(
            {key: float(each[k]) for key, each in errors.items()}, float(places[row, k]), float(found[row, k])
        )

    def _beside_jumps(self, errors: Mapping[str, FloatArray]) -> FloatArray:
        """The places next to which jumps begin and end to count for cams (m,), on both sides: (places, m)."""
        count, jumps = len(next(iter(errors.values()))), [jump.at for jump in self._whole]
        every, at = {key: np.tile(each, len(jumps)) for key, each in errors.items()}, np.repeat(jumps, count)
        found = np.reshape([at, *self._reaching(every, at)], (-1, count))
        return self.cam.within(np.concatenate([found - BESIDE, found + BESIDE]))

    def _reaching(self, errors: Mapping[str, FloatArray], angles: FloatArray) -> list[FloatArray]:
        """The places of the first contact when it touches at cam angles, and when the second one touches there."""
        known, found = flat(errors), [angles, angles]
        for _ in range(TOUCHES):
            turned = [self.cam.turned(known, each) for each in found]
            found = [angles - turned[0], angles - self.cam.ahead(known, found[1], turned[1])]
        return found

    def corner(self, angles: FloatArray, side: float, late: float = 0.0) -> dict[str, FloatArray]:
        """For each cam angle the ends of errors that move the tool furthest to a side.

        With as much of how late they make the cam, in units of what all errors of one end make of both.
        """
        rows, every = list[Values](), {key: high for key, (_, high) in self.ends.items()}
        for key, ends in self.ends.items():
            if (way := way_of(key)) in self.ends and not is_way(key):
                rows += [{key: ends[1], way: each} for each in QUARTERS]
            elif not is_way(key):
                rows += [{key: end} for end in ends]
        found, moved = dict[str, FloatArray](), iter(self._moved([*rows, every], angles, side, late))
        for key, (low, high) in self.ends.items():
            if (way := way_of(key)) in self.ends and not is_way(key):
                right, up, left, down = (next(moved) for _ in QUARTERS)
                found |= {key: np.full(angles.size, high), way: np.arctan2(up - down, right - left)}
            elif not is_way(key):
                found[key] = np.where(next(moved) > next(moved), low, high)
        return found

    def _moved(self, cams: list[Values], angles: FloatArray, side: float, late: float) -> FloatArray:
        """How far cams move the tool to a side, with so much of how late they are; in units of the last of them."""
        errors = {key: np.repeat([cam.get(key, 0.0) for cam in cams], angles.size) for key in self.ends}
        every = np.tile(angles, len(cams))
        found = self._touching(errors, every, jumps=False)
        error, ahead = (each.reshape(len(cams), -1) for each in (found.error, found.angle - every))
        weight = np.abs(error[-1]) / np.maximum(np.abs(ahead[-1]), JUMP_SIDE)
        return np.asarray(side * error + late * weight * ahead)

    def error(self, errors: Mapping[str, Any], angles: FloatArray) -> FloatArray:
        """Those of the motion of cams where they touch."""
        return self._touching(errors, angles).error

    def _touching(self, errors: Mapping[str, Any], angles: FloatArray, *, jumps: bool = True) -> Contact:
        """FloatingPointError where a follower does not touch its cam."""
        with np.errstate(invalid="ignore"):
            found = self.contact(errors, angles, jumps=jumps)
        if not np.isfinite(found.error).all():
            raise FloatingPointError
        return found

    def lost(self) -> BadInput:
        """The message on tolerances so large that a follower has no place on its cam: the first such, or all."""
        alone = [[key, way_of(key)] for key in self.ends if not is_way(key)]
        of = next((each for each in alone if not self._touched(each, 1.0)), [*self.ends])
        low, high = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._touched(of, middle) else (low, middle)
        why = "so far off, a follower does not touch its cam all over the turn, or cannot be put together"
        if of == [*self.ends] and len(alone) > 1:
            why = f"{why}: at most {100.0 * low:.3g} % of these"
            return BadInput([Mistake(self.problem.file, "tolerances", None, why, bare=True)])
        unit = degrees(1.0) if of[0] in ANGLES else 1.0
        most = unit * max(map(abs, self.ends[of[0]]))
        why = f"{why}: at most about {low * most:.3g}"
        place = PROFILE_PLACES if of[0] == "profile" else f"tolerances.{of[0]}"
        return BadInput([Mistake(self.problem.file, place, most, why, bare=True)])

    def _touched(self, keys: list[str], share: float) -> bool:
        """Whether followers touch cams all over the turn with errors of some keys alone, up to a share of each."""
        ends = {key: self.ends[key] for key in keys if key in self.ends}
        shared = {key: (low * share, high * share) for key, (low, high) in ends.items()}
        try:
            search = replace(self, ends=shared | {key: ends[key] for key in ends if is_way(key)})
            search.highest(search.first())
        except FloatingPointError:
            return False
        return True

    def highest(self, errors: Mapping[str, float]) -> tuple[float, float]:
        """Where on its profile a cam has its largest error, and this."""
        angle = highest(self.turn.nodes, lambda angles: np.abs(self.error(errors, angles)))
        usual = angle, float(self.error(errors, np.array([angle]))[0])
        if not self._whole:
            return usual
        places = self._beside_jumps({key: np.array([each]) for key, each in errors.items()}).ravel()
        found = self.error({key: np.full(places.size, each) for key, each in errors.items()}, places)
        most = np.abs(found).argmax()
        return (float(places[most]), float(found[most])) if abs(found[most]) > abs(usual[1]) else usual

    def said(self, errors: Mapping[str, float], place: float, angle: float) -> dict[str, float]:
        """Errors in mm and deg, of a cam that is touched at a place at a cam angle.

        With the direction of the bore as the cam has it, and where waves have a crest.
        """
        found, sense = dict(errors), self.problem.design.sense
        if BORE in errors:
            developed, long = self.problem.setup.mechanism.body.developed, errors[BORE]
            turned = angle + errors.get("phase", 0.0) if developed else place
            way = errors.get(BORE_WAY, 0.0 if long >= 0.0 else pi)
            found |= {BORE: abs(long), BORE_WAY: way - sense * turned}
        for key in errors:
            if key.startswith(WAY):
                found[key] = self.cam.waves * self.place_of(key, errors, place) - errors[key]
        shown = {key: degrees(each) for key, each in found.items() if is_way(key) or key in ANGLES}
        return found | {key: each % 360.0 if is_way(key) else each for key, each in shown.items()}

    def place_of(self, key: str, errors: Mapping[str, float], angle: float) -> float:
        """The cam angle of the place of the profile that an error is of, where the first contact touches at one."""
        if not key.endswith(SECOND):
            return angle
        at, known = np.array([angle]), flat(errors)
        return angle + float(self.cam.ahead(known, at, self.cam.turned(known, at))[0])


def worst_search(
    turn: TurnErrors, order: int = 0, changed: Mapping[str, tuple[float, float]] | None = None
) -> WorstSearch:
    """The search for the worst cam in displacement (0), velocity (1) or acceleration (2), within its tolerances.

    ``changed`` are other ends of errors than those of the scene.
    """
    return WorstSearch(turn, {**ends_of(turn.scene, turn.problem, order), **(changed or {})}, order)

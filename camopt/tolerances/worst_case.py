"""The largest errors of the motion of the tool, of all cams within the tolerances: bounds and witnesses.

The exact error of a cam in displacement, velocity or acceleration, the orders 0 to 2, is one formula of its errors
and of the point that is touched (``tolerances.exact``). Run on ranges with slopes, it decides by bisection of
errors and turn whether any cam at any point is beyond a bound (``verdicts.claim_boxes``, ``tolerances.vectors``):
a little more than what the worst cam that was found has. Where a cam is worse than that one, it takes its place.

Where y'' jumps, a cam that is late has the whole jump for an error of its acceleration until it is there. Within
reach of a jump, as far as any cam is late or early, the proof counts it with every cam: its bound is the jump and
what else is off.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6 and 11.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, inf, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from camopt.effects.case import Case
from camopt.effects.curvature import CONVEX
from camopt.effects.motion import scale
from camopt.mechanisms import Designs
from camopt.mistakes import BadInput, Mistake
from camopt.motion.programme import JUMP_SIDE, Jump, Programme, jumps_of
from camopt.motion.table import ALL_STROKES
from camopt.numerics import LARGEST_MAGNITUDE, FloatArray, IntArray
from camopt.numerics.clock import now
from camopt.numerics.curves import formula
from camopt.numerics.interval import Interval
from camopt.numerics.motion_ranges import by_angle
from camopt.numerics.sloped import Sloped
from camopt.numerics.stretches import over_part
from camopt.problem.claims import Claim, Plain
from camopt.problem.problem import Problem
from camopt.scene.tolerances import ANGLES
from camopt.tolerances.bounded import Bounded, Gaps, Tried, Values, bounded
from camopt.tolerances.errors import BORE, BORE_WAY, LEVEL, WAY, flat, is_way, way_of
from camopt.tolerances.exact import Contact, Moved, Touched, at_tool, errors_of, moved_of, touched
from camopt.tolerances.further_on import LAST, FurtherOn, Jumped, Place
from camopt.tolerances.off_train import through
from camopt.tolerances.turn import TurnErrors, highest
from camopt.tolerances.vectors import ROOM, VectorSearch, box_of
from camopt.verdicts.claim_boxes import Ends, Parts
from camopt.verdicts.running import run_effects
from camopt.verdicts.words import HELD

GAPS, RATE_GAPS = Gaps((1e-5, 1e-4, 1e-3, 1e-2)), Gaps((1e-1, 0.3, 1.0, 3.0), (1e-2, 1e-3))
"""Of the displacement, and of velocity and acceleration."""
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
LATE = (0.1, 1.0, 10.0)
"""How much it counts how late a cam is, to find the worst one at a jump."""


Passed = tuple[bool | None, bool | None]
"""Whether a jump within reach of a place lies between it and the cam angle at which it touches, and between it and
where a further contact touches then; None if that is not said."""


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


class ToolError(NamedTuple):
    """The exact error of a derivative of the tool's motion where a cam with errors touches, mm (rad) by powers of
    rad; on ranges with slopes alone."""

    problem: Problem
    design: Designs
    errors: Mapping[str, Any]
    """Flat."""
    order: int
    waves: int

    def moved(self, at: Place, order: int) -> Moved:
        """Where the follower rests."""
        return moved_of(self.problem, self.design, self.errors, self.waves, at.motion, order)

    def turned(self, at: Place) -> list[Sloped]:
        """How far from the cam angle of the place the motion counts."""
        return [self.moved(at, 0).turned.terms[0]]


@formula(ToolError)
def tool_error(f, i, at):  # type: ignore[no-untyped-def]
    moved = f.moved(at, f.order)
    further = FurtherOn(f.problem.programme, at, moved.turned.terms[0], at.jumped)
    found = errors_of(moved, at.motion, further.by, at.jumped.by2, f.order)
    return through(f.problem, f.errors, found, further.motion), 0.0


@dataclass(frozen=True)
class Proof(VectorSearch):
    """The search for a cam that exceeds a bound, which knows where derivatives of the motion jump."""

    jumps: tuple[Jump, ...] = ()
    """Of y'', and of y'''."""
    reach: float = 0.0
    """As far as any cam is late or early, rad."""
    passed: Passed = (None, None)

    def state(self, parts: Parts, u: FloatArray, angle: Sloped) -> Place:
        table = self.problem.programme.table
        half, found = table.half_width[parts.panel], over_part(table, parts.panel, u, angle.span.high[0])
        motion = [
            replace(angle, value=whole, at=middle, slopes=by_angle(angle, slope))
            for middle, whole, slope in zip(found.middle[: LAST + 1], found.whole, found.whole[1:], strict=False)
        ]
        low, high, middle = (each * half for each in (parts.low[0], parts.high[0], u))
        angles = table.centre[parts.panel] + middle
        jumped = (self._jumped(parts.panel, angles, each) for each in self.passed)
        return Place(motion, parts.panel, low, high, middle, *jumped)

    def _jumped(self, panel: IntArray, angles: FloatArray, passed: bool | None) -> Jumped:
        """By which jumps of y'' and of y''' a cam that touches with places on panels may be off.

        A place at a jump is on the side of it on which its panel is.
        """
        found, centre = np.zeros((2, 2, panel.size)), self.problem.programme.table.centre[panel]
        near = dict(zip(self._places, self._near(angles), strict=True))
        known = (sum(near.values(), np.zeros(panel.size)) == 1) & (passed is not None)
        for jump in self.jumps:
            size = np.where(near[jump.at], np.sign(self._ahead(jump.at, centre)) * jump.size, 0.0)
            hull = np.array([np.minimum(size, 0.0), np.maximum(size, 0.0)])
            found[jump.order - 2] += np.where(known, size * bool(passed), hull)
        return Jumped(*(Interval(*each) for each in found))

    def near(self, parts: Parts) -> NDArray[np.bool_]:
        """Which parts are within reach of a jump."""
        table, middle = self.problem.programme.table, 0.5 * (parts.low[0] + parts.high[0])
        angles = table.centre[parts.panel] + middle * table.half_width[parts.panel]
        return np.asarray(self._near(angles).any(axis=0))

    def _near(self, angles: FloatArray) -> NDArray[np.bool_]:
        """Of which places of jumps cam angles are within reach, (places, m)."""
        ahead = [np.abs(self._ahead(at, angles)) for at in self._places]
        return np.reshape(ahead, (-1, angles.size)) <= ((1.0 + ROOM) * self.reach if self.reach else -1.0)

    @cached_property
    def _places(self) -> list[float]:
        return sorted({jump.at for jump in self.jumps})

    def _ahead(self, at: float, angles: FloatArray) -> FloatArray:
        """How far ahead a jump is, within half a turn."""
        turn = self.problem.programme.strokes[-1].end
        return np.asarray(np.mod(at - angles + 0.5 * turn, turn) - 0.5 * turn)

    def parted(self, parts: Parts) -> Parts:
        """Parts that are within reach of each jump or not."""
        table = self.problem.programme.table
        for jump in self.jumps:
            for side in (-1.0, 1.0):
                ahead = self._ahead(jump.at, table.centre[parts.panel])
                parts = parts.parted((ahead + side * self.reach) / table.half_width[parts.panel])
        return parts


class Late(NamedTuple):
    """How far from the cam angle of a place the motion counts, rad: where the cam touches, or another contact."""

    of: Any
    number: int


@formula(Late)
def late(f, i, at):  # type: ignore[no-untyped-def]
    return f.of.turned(at)[f.number], 0.0


class Found(NamedTuple):
    """A cam that is off, mm and rad, with the cam angle of its profile where it is the most, and by how much."""

    errors: Values
    angle: float
    error: float


@dataclass(frozen=True)
class WorstSearch:
    """The search for the worst of the cams within tolerances."""

    turn: TurnErrors
    ends: Ends
    """Between which values each error is (``two_contacts.ends_of``)."""
    order: int = 0
    """Of the derivative of the motion that is looked at: displacement, velocity, acceleration."""

    @property
    def problem(self) -> Problem:
        return self.turn.problem

    def run(self) -> WorstCase:
        """The worst cam that is found, and what no cam exceeds.

        BadInput for tolerances so large that a follower has no place on its cam.
        """
        try:
            return self._told(self._bounded())
        except FloatingPointError:
            raise self.lost() from None

    def _bounded(self) -> Bounded[Found]:
        worst = self._found(self.first())
        if why := self.unbounded:
            return Bounded(abs(worst.error), worst, unproved=why)
        seconds, gaps = (RATE_SECONDS, RATE_GAPS) if self.order else (SECONDS, GAPS)
        return bounded(abs(worst.error), worst, self.proof, self._worse, now() + seconds, gaps, seconds)

    def _told(self, found: Bounded[Found]) -> WorstCase:
        unit, (errors, angle, error) = scale(self.problem.setup, self.order), found.cam
        there = float(self.contact(errors, np.array([angle])).angle[0])
        at = degrees(float(self.within(np.array([there]))[0]))
        return WorstCase(unit * found.bound, unit * error, at, self.said(errors, angle, there), found.unproved)

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
        return bool(found[0] <= (self.waves**2 - 1) * zone)

    def _found(self, errors: Values) -> Found:
        return Found(errors, *self.highest(errors))

    def _worse(self, errors: Values, bound: float) -> tuple[float, Found]:
        """What a cam has that was found to exceed a bound."""
        found = self._found(errors)
        return abs(found.error), found

    def proof(self, bound: float, until: float) -> Tried:
        """Whether no cam within the tolerances exceeds a bound."""
        proof = replace(self._proof, claim=self._claim(bound), until=until, reach=self._reach)
        parts = proof.parted(Parts.first(self.problem, proof.claim, self._box))
        for passed in self.cases:
            found = replace(proof, passed=passed).tried(parts)
            parts = parts.take(np.flatnonzero(proof.near(parts)))
            if found.verdict != HELD or not parts.size:
                break
        return found

    @property
    def cases(self) -> Iterable[Passed]:
        """What is proved one after the other of parts within reach of jumps."""
        return [(None, None)]

    @cached_property
    def _proof(self) -> Proof:
        names = tuple(self._box)
        return Proof(self.problem, self._claim(inf), self.problem.design, names, inf, self.ends, self.jumps)

    @cached_property
    def _box(self) -> Ends:
        """Between which values each number of an error is."""
        found = box_of(self.ends)
        level = [key for key in found if self.order == 2 and key.startswith(WAY)]
        return found | {key.replace(WAY, LEVEL): found[key] for key in level}

    def _claim(self, bound: float, late: int | None = None) -> Claim:
        def error(designs: Designs, programme: Programme) -> Any:
            found = self.curve(designs, {key: designs.numbers[key] for key in self._box})
            return found if late is None else Late(found, late)

        return Claim(error, ALL_STROKES, LARGEST_MAGNITUDE, Plain(bound))

    @property
    def last(self) -> int:
        """The order of the last derivative of the motion that is taken elsewhere than at the place."""
        return self.order

    @cached_property
    def jumps(self) -> tuple[Jump, ...]:
        """The jumps that count: of y'' and of y''', up to that order."""
        orders = range(2, self.last + 1)
        return tuple(each for order in orders for each in jumps_of(self.problem.programme, (order,)))

    @cached_property
    def _reach(self) -> float:
        """As far as any cam is late or early, rad; 0 where no jump counts."""
        if not self.jumps:
            return 0.0
        parts = Parts.first(self.problem, self._proof.claim, self._box)
        parts = parts.cut(np.eye(1, len(parts.low)).T + np.zeros(parts.size))
        proofs = (replace(self._proof, claim=self._claim(inf, late)) for late in range(self.last - self.order + 1))
        with np.errstate(all="ignore"):
            found = [proof.curve_over(parts)[0].value.largest_magnitude.max() for proof in proofs]
        return (1.0 + ROOM) * float(max(found))

    def curve(self, design: Designs, errors: Mapping[str, Any]) -> Any:
        """The exact error of the tool over the turn, of flat errors."""
        return ToolError(self.problem, design, errors, self.order, self.waves)

    def resting(self, design: Designs, errors: Mapping[str, Any], at: Place) -> Any:
        """How far a follower has moved over boxes of flat errors, in a dwell."""
        return moved_of(self.problem, design, errors, 0, at.motion, 0).moved.terms[0]

    @property
    def waves(self) -> int:
        """Of a profile that is off, in a turn; 0 where it counts as off by a constant."""
        return (self.turn.scene.tolerances.waves or 0) if self.order else 0

    def contact(self, errors: Mapping[str, Any], angles: FloatArray, *, jumps: bool = True) -> Contact:
        """Where cams touch, and those of their motion there; or these but for what jumps of y'' make of them."""
        return at_tool(self.problem, errors, angles, self.follower(flat(errors), angles, jumps))

    def follower(self, errors: Mapping[str, Any], angles: FloatArray, jumps: bool) -> Touched:
        """Where the follower touches the points of these cam angles, and its errors."""
        return touched(self.problem, errors, angles, self.order, waves=self.waves, jumps=jumps)

    def within(self, angles: FloatArray) -> FloatArray:
        """Cam angles within the turn, rad."""
        return np.asarray(np.mod(angles, self.problem.programme.strokes[-1].end))

    def first(self) -> dict[str, float]:
        """Errors that are the worst, or nearly so, at the worst cam angle: most of them at their ends."""
        found = [self._furthest(side) for side in (1.0, -1.0)]
        if self.jumps:
            ways = [side * each for side in (1.0, -1.0) for each in LATE]
            found += [self._at_jump(side, way) for side in (1.0, -1.0) for way in ways]
        return self._climbed(max(found, key=lambda each: each.error))

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
        return angle, float(self.error(errors, np.array([angle]))[0])

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
                found[key] = self.waves * self.place_of(key, errors, place) - errors[key]
        shown = {key: degrees(each) for key, each in found.items() if is_way(key) or key in ANGLES}
        return found | {key: each % 360.0 if is_way(key) else each for key, each in shown.items()}

    def place_of(self, key: str, errors: Mapping[str, float], angle: float) -> float:
        """The cam angle of the place of the profile that an error is of, where the first contact touches at one."""
        return angle

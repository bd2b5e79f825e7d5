"""The largest errors of velocity and acceleration of the tool, of all cams within the tolerances.

As of the displacement (``tolerances.worst_case``): the exact errors of a cam (``tolerances.rates``), run on ranges
with slopes, decide by bisection whether any cam at any point is beyond a bound. An axis of the bore, and a profile
with waves, is off by a vector no longer than ε: with the slopes g by both of its coordinates, over a part

    f ≤ f(p) + Σ g_k·(x_k − p_k) + ε·|g| − g·p

so that hardly more than the cam angle is cut.

Where y'' jumps, a cam that is late has the whole jump for an error of its acceleration until it is there. Within
reach of a jump, as far as any cam is late or early, the proof counts it with every cam: its bound is the jump and
what else is off.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6 and 11.
"""

from collections.abc import Callable, Iterable, Mapping
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
from camopt.motion.programme import JUMP_SIDE, Jump, Programme, jumps_of
from camopt.motion.table import ALL_STROKES
from camopt.numerics import GIVEN, LARGEST_MAGNITUDE, FloatArray, IntArray
from camopt.numerics.clock import now, share
from camopt.numerics.curves import formula
from camopt.numerics.interval import INTERVAL_RULES, Interval, as_interval
from camopt.numerics.sloped import Sloped
from camopt.numerics.stretches import over_part
from camopt.numerics.taylor import Taylor
from camopt.problem.claims import Claim, Plain
from camopt.problem.problem import Problem
from camopt.scene.tolerances import ANGLES
from camopt.tolerances.further_on import LAST, FurtherOn, Place
from camopt.tolerances.ranges import plain
from camopt.tolerances.rates import LEVEL, Touched, errors_of, moved_of, touched
from camopt.tolerances.rates_through import through
from camopt.tolerances.touching import BORE, BORE_WAY, WAY, Contact, is_way, way_of
from camopt.tolerances.turn import TurnErrors, highest
from camopt.tolerances.two_contacts import ends_of
from camopt.tolerances.worst_case import CORNERS, WORSE, WorstCase, WorstSearch, follower_start
from camopt.verdicts.claim_boxes import Answer, Parts, Search, by_angle
from camopt.verdicts.running import run_effects
from camopt.verdicts.words import BROKEN, HELD

WIDE, CLOSER, BETWEEN = (1e-1, 0.3, 1.0, 3.0), (1e-2, 1e-3), 3.0
"""Relative, of the largest error found: by no more than this a cam is worse, the first that is proved; what is
asked then; and how much more where that is not."""
SLOPES = "the slope of the profile's error has no bound without tolerances.waves"
HOLLOWS = (
    "a flat face lies on the crests of waves as high and short as those of the profile, and does not follow them"
)
QUARTERS = (0.0, 0.5 * pi, pi, -0.5 * pi)
TRIED = (pi, *(side * each for each in (1.0, 0.3, 0.1, 0.03, 0.01) for side in (-1.0, 1.0)))
"""By how much a way is changed to find a worse cam, rad."""
CLIMBS = 2
"""How often each error is changed for it."""
LATE = (0.1, 1.0, 10.0)
"""How much it counts how late a cam is, to find the worst one at a jump."""
SECONDS = 9.0
"""For the bound of one of velocity and acceleration."""
SLICES = 3
"""The share of what is left of them that is for one bound."""
TOO_LARGE = "the tolerances are too large for it"
NARROW = 0.5
"""Within which angle of the middle one slopes have to be, rad, for a vector to be taken along them."""
ROOM = 1e-9
"""Relative, for rounding of how late cams are and of how long vectors are."""


class RateError(NamedTuple):
    """The exact error of a derivative of the tool's motion where a cam with errors touches, mm (rad) by powers of
    rad; on ranges with slopes alone."""

    problem: Problem
    design: Designs
    errors: Mapping[str, Any]
    order: int
    waves: int

    def turned(self, at: Place) -> list[Sloped]:
        """How far from the cam angle of the place the motion counts."""
        found = moved_of(self.problem, self.design, self.errors, self.waves, at.motion, 0)
        return [plain(found.turned.terms[0], at.y)]


@formula(RateError)
def rate_error(f, i, at):  # type: ignore[no-untyped-def]
    moved = moved_of(f.problem, f.design, f.errors, f.waves, at.motion, f.order)
    further = FurtherOn(f.problem.programme, at, plain(moved.turned.terms[0], at.y))
    found = errors_of(moved, at.motion, further.by, at.jumped, f.order)
    return at_tool(f.problem, f.errors, found, further), 0.0


def at_tool(problem: Problem, errors: Mapping[str, Any], found: list[Sloped], further: FurtherOn) -> Any:
    """The error of the last order at the tool, from those of a follower up to it."""
    every = [plain(each, further.at.y) for each in found]
    if problem.setup.train is None:
        return every[-1]
    return through(problem, errors, every, [further.motion(order) for order in range(len(every))])


@dataclass(frozen=True)
class RateProof(Search):
    """The search for a cam that exceeds a bound, which knows where derivatives jump, and how long vectors are."""

    vectors: tuple[tuple[int, int, float], ...] = ()
    """The numbers of both coordinates among the names, and the largest length."""
    jumps: tuple[Jump, ...] = ()
    """Of y'', and of y'''."""
    reach: float = 0.0
    """As far as any cam is late or early, rad."""

    def state(self, parts: Parts, u: FloatArray, angle: Sloped) -> Place:
        table = self.problem.programme.table
        half, found = table.half_width[parts.panel], over_part(table, parts.panel, u, angle.span.high[0])
        motion = [
            replace(angle, value=whole, at=middle, slopes=by_angle(angle, slope))
            for middle, whole, slope in zip(found.middle[: LAST + 1], found.whole, found.whole[1:], strict=False)
        ]
        low, high, middle = (each * half for each in (parts.low[0], parts.high[0], u))
        return Place(motion, parts.panel, low, high, middle, *self._jumped(parts.panel, middle))

    def excess(self, parts: Parts) -> Sloped:
        """With what vectors that are no longer than they may be bring at most."""
        found = super().excess(parts)
        moved, sides = found.slopes * found.span, (found.slopes * found.span).high
        beyond, inside = np.zeros(parts.size), np.ones(parts.size, dtype=bool)
        for both, longest in self._vectors:
            nearest = np.maximum(np.maximum(parts.low[both], -parts.high[both]), 0.0)
            inside &= np.hypot(*nearest) <= longest * (1.0 + ROOM)
            along = (found.slopes[both] * _middle(parts, both)).low.sum(axis=0)
            most = longest * (1.0 + ROOM) * np.hypot(*found.slopes[both].largest_magnitude) - along
            beyond += np.fmin(most, sides[both].sum(axis=0))
            sides[both] = 0.0
        top = found.at.high + sides.sum(axis=0) + beyond
        top += GIVEN * (np.abs(found.at.high) + moved.largest_magnitude.sum(axis=0) + np.abs(beyond))
        top = np.where(inside, np.fmin(found.value.high, top), -1.0)
        at = Interval(self._least(parts, found), found.at.high)
        return replace(found, value=Interval(np.minimum(found.value.low, top), top), at=at)

    def _least(self, parts: Parts, found: Sloped) -> FloatArray:
        """The excess of a cam of each part at least (``point``)."""
        low, known = found.at.low.copy(), np.ones(parts.size, dtype=bool)
        for both, _ in self._vectors:
            to = self._end(parts, found.slopes, both)
            known &= np.all((parts.low[both] <= to) & (to <= parts.high[both]), axis=0)
            low += (found.slopes[both] * (to - _middle(parts, both))).low.sum(axis=0)
        return np.where(known, low - GIVEN * np.abs(low), -inf)

    def _end(self, parts: Parts, slopes: Interval, both: list[int]) -> FloatArray:
        """A vector of each part: in its middle, or where it brings the most if it may have any direction."""
        longest = next(each for rows, each in self._vectors if rows == both)
        middle, way = _middle(parts, both), (slopes[both].low + slopes[both].high) / 2.0
        to = np.where(self._any(parts, both), way, middle)
        size = np.hypot(*to)
        short = np.where(self._any(parts, both), longest, np.minimum(size, longest)) * (1.0 - ROOM)
        return np.asarray(to / np.where(size > 0.0, size, 1.0) * short)

    def point(self, parts: Parts, number: int) -> Designs:
        part = parts.take(np.array([number]))
        with np.errstate(all="ignore"):
            slopes, found = super().excess(part).slopes, super().point(part, 0)
        ends = dict[str, FloatArray]()
        for both, _ in self._vectors:
            ends |= dict(zip([self.names[each - 1] for each in both], self._end(part, slopes, both), strict=True))
        return found.with_values(ends)

    def narrowed(self, parts: Parts, slopes: Interval) -> Parts:
        """By the slopes of what has no way; and of vectors that may have any, with those alone that bring the most.

        That is one along the slopes, as long as it may be.
        """
        low, high = slopes.low.copy(), slopes.high.copy()
        for both, _ in self._vectors:
            low[both], high[both] = -1.0, 1.0  # neither end alone is left
        found = parts.monotone(Interval(low, high))
        low, high = found.low.copy(), found.high.copy()
        for both, longest in self._vectors:
            x, y = slopes[both[0]], slopes[both[1]]
            way = np.arctan2(y.low + y.high, x.low + x.high)
            turned = x * np.cos(way) + y * np.sin(way), y * np.cos(way) - x * np.sin(way)
            across: Any = INTERVAL_RULES[np.arctan2](turned[1], as_interval(turned[0].low))
            chosen = self._any(parts, both) & (turned[0].low > 0.0) & (across.largest_magnitude < NARROW)
            ends = Interval(across.low + way, across.high + way)
            for row, each in zip(both, (np.cos(ends), np.sin(ends)), strict=True):
                low[row] = np.where(chosen, np.maximum(low[row], longest * (each.low - ROOM)), low[row])
                high[row] = np.where(chosen, np.minimum(high[row], longest * (each.high + ROOM)), high[row])
        return replace(found, low=low, high=high)

    def steepness(self, slopes: Interval) -> FloatArray:
        """Of vectors how much their slopes change: that is what cuts take off."""
        found = slopes.largest_magnitude
        for both, _ in self._vectors:
            found[both] = slopes[both].high - slopes[both].low
        return found

    @property
    def _vectors(self) -> list[tuple[list[int], float]]:
        """The rows of both coordinates in parts, and the largest length."""
        return [([1 + first, 1 + second], longest) for first, second, longest in self.vectors]

    def _any(self, parts: Parts, both: list[int]) -> NDArray[np.bool_]:
        """Of which parts a vector may have any direction."""
        longest = next(each for rows, each in self._vectors if rows == both)
        return np.asarray(np.all((parts.low[both] <= -longest) & (parts.high[both] >= longest), axis=0))

    def _jumped(self, panel: IntArray, places: FloatArray) -> list[Interval]:
        """By which jumps of y'' and of y''' a cam that touches with places on panels may be off.

        A place at a jump is on the side of it on which its panel is.
        """
        found, centre = np.zeros((2, 2, panel.size)), self.problem.programme.table.centre[panel]
        for jump in self.jumps:
            near = (np.abs(self._ahead(jump, centre + places)) <= (1.0 + ROOM) * self.reach) & (self.reach > 0.0)
            size = np.where(near, np.sign(self._ahead(jump, centre)) * jump.size, 0.0)
            found[jump.order - 2] += np.minimum(size, 0.0), np.maximum(size, 0.0)
        return [Interval(*each) for each in found]

    def _ahead(self, jump: Jump, angles: FloatArray) -> FloatArray:
        """How far ahead a jump is, within half a turn."""
        turn = self.problem.programme.strokes[-1].end
        return np.asarray(np.mod(jump.at - angles + 0.5 * turn, turn) - 0.5 * turn)

    def parted(self, parts: Parts) -> Parts:
        """Parts that are within reach of each jump or not."""
        table = self.problem.programme.table
        for jump in self.jumps:
            for side in (-1.0, 1.0):
                ahead = self._ahead(jump, table.centre[parts.panel])
                parts = parts.parted((ahead + side * self.reach) / table.half_width[parts.panel])
        return parts


class Late(NamedTuple):
    """How far from the cam angle of a place the motion counts, rad: where the cam touches, or another contact."""

    of: Any
    number: int


@formula(Late)
def late(f, i, at):  # type: ignore[no-untyped-def]
    return f.of.turned(at)[f.number], 0.0


def _middle(parts: Parts, rows: list[int]) -> FloatArray:
    return np.asarray((parts.low[rows] + parts.high[rows]) / 2.0)


class Found(NamedTuple):
    """A cam that is off, mm and rad, with the cam angle of its profile where it is the most, and by how much."""

    errors: dict[str, float]
    angle: float
    error: float


@dataclass(frozen=True)
class RateSearch(WorstSearch):
    """The search for the cam whose velocity or acceleration is the worst of those within tolerances.

    ``ends`` are as those of the displacement; a profile with waves and an axis that is off have ways.
    """

    order: int = 1

    def _run(self) -> WorstCase:
        unit, bound, why = scale(self.problem.setup, self.order), inf, self.unbounded
        worst, until = self._found(self.first()), now() + SECONDS
        if not why:
            bound, worst = self.proved(worst, until)
            late = f"the time of {SECONDS:g} s was over"
            why = "" if bound < inf else late if now() > until else TOO_LARGE
        there = self.contact(worst.errors, np.array([worst.angle])).angle[0]
        at = degrees(float(np.mod(there, self.problem.programme.strokes[-1].end)))
        return WorstCase(unit * bound, unit * worst.error, at, self.said(worst.errors, worst.angle), why)

    @property
    def unbounded(self) -> str:
        """Why there is no bound; "" where there may be one."""
        given = self.turn.scene.tolerances
        if self.problem.programme.corners:
            return CORNERS
        if given.profile is None:
            return ""
        return SLOPES if given.waves is None else HOLLOWS if self._lies_on_crests(given.profile) else ""

    def _lies_on_crests(self, zone: float) -> bool:
        """Whether a flat face does not follow waves: with w the radius of the profile is ρ + w + w''."""
        problem, convex = self.problem, frozenset({CONVEX})
        if not problem.setup.mechanism.flat_faced:
            return False
        found = run_effects(Case(problem.setup, problem.programme, problem.design), convex).columns[CONVEX]
        return bool(found[0] <= (self.waves**2 - 1) * zone)

    def proved(self, worst: Found, until: float) -> tuple[float, Found]:
        """What no cam exceeds, and the worst cam that is found."""
        bound, worst = self.first_of(WIDE, worst, until)
        for gap in CLOSER if bound <= (1.0 + WIDE[0]) * abs(worst.error) else ():
            closer, worst = self.held(gap, worst, until)
            if closer == inf:
                closer, worst = self.held(BETWEEN * gap, worst, until)
                return min(bound, closer), worst
            bound = closer
        return bound, worst

    def first_of(self, gaps: Iterable[float], worst: Found, until: float) -> tuple[float, Found]:
        """The first bound of some that is proved, infinite if none is."""
        bound = inf
        for gap in gaps:
            bound, worst = self.held(gap, worst, until)
            if bound < inf or now() > until:
                break
        return bound, worst

    def held(self, gap: float, worst: Found, until: float) -> tuple[float, Found]:
        """The bound that is above the worst cam by a gap, if it is proved, with worse cams that are found."""
        for _ in range(WORSE):
            bound = abs(worst.error) * (1.0 + gap)
            answer = self.proof(bound, share(until, SLICES))
            if answer.verdict == HELD:
                return bound, worst
            if answer.verdict != BROKEN or answer.witness is None:
                break
            other = self._found(self._polar({key: float(answer.witness.numbers[key][0]) for key in self._box}))
            if abs(other.error) <= abs(worst.error):
                break
            worst = other
        return inf, worst

    def _found(self, errors: dict[str, float]) -> Found:
        return Found(errors, *self.highest(errors))

    def proof(self, bound: float, until: float) -> Answer:
        """Whether no cam within the tolerances exceeds a bound."""
        proof = replace(self._proof, claim=self._claim(bound), until=until, reach=self._reach)
        return proof.run(proof.parted(Parts.first(self.problem, proof.claim, self._box)))

    @cached_property
    def _proof(self) -> RateProof:
        names = (*self._box,)
        ways = [(key, way_of(key)) for key in names if not is_way(key) and way_of(key) in names]
        vectors = tuple((names.index(key), names.index(way), self.ends[key][1]) for key, way in ways)
        return RateProof(self.problem, self._claim(inf), self.problem.design, names, inf, vectors, self.jumps)

    @cached_property
    def _box(self) -> dict[str, tuple[float, float]]:
        """Between which values each number of an error is, with both coordinates of those that have a way."""
        found, order = dict[str, tuple[float, float]](), self.order
        for key, (low, high) in self.ends.items():
            if way_of(key) in self.ends and not is_way(key):
                found |= {key: (-high, high), way_of(key): (-high, high)}
                if order == 2 and key.startswith("profile"):
                    found[key.replace("profile", LEVEL)] = -high, high
            elif not is_way(key):
                found[key] = low, high
        return found

    def _polar(self, box: Mapping[str, float]) -> dict[str, float]:
        found = {key: each for key, each in box.items() if key in self.ends}
        for key in self.ends:
            if (way := way_of(key)) in self.ends and not is_way(key):
                long = float(np.hypot(box[key], box[way]))
                found |= {key: min(long, self.ends[key][1]), way: float(np.arctan2(box[way], box[key]))}
        return found

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
        return RateError(self.problem, design, errors, self.order, self.waves)

    @property
    def waves(self) -> int:
        """Of a profile that is off, in a turn; 0 where it counts as off by a constant."""
        return self.turn.scene.tolerances.waves or 0

    def contact(self, errors: Mapping[str, Any], angles: FloatArray, *, jumps: bool = True) -> Contact:
        """Where cams touch, and those of their motion there; or these but for what jumps of y'' make of them."""
        turned, found = self.follower(self.flat(errors), angles, jumps)
        return Contact(angles + turned, self._at_tool(errors, angles + turned, found))

    def flat(self, errors: Mapping[str, Any]) -> dict[str, Any]:
        """Errors with both coordinates of those that have a way."""
        found = dict(errors)
        for key in errors:
            if (way := way_of(key)) in errors and not is_way(key):
                found |= {key: errors[key] * np.cos(errors[way]), way: errors[key] * np.sin(errors[way])}
        return found

    def follower(self, errors: Mapping[str, Any], angles: FloatArray, jumps: bool) -> Touched:
        """Where the follower touches the points of these cam angles, and its errors."""
        return touched(self.problem, errors, angles, self.order, waves=self.waves, jumps=jumps)

    def _at_tool(self, errors: Mapping[str, Any], there: FloatArray, found: list[FloatArray]) -> FloatArray:
        """The error of the last order at the tool, from those of a follower up to it."""
        problem, train = self.problem, self.problem.setup.train
        if train is None:
            return found[-1]
        y = problem.programme.at(np.mod(there, problem.programme.strokes[-1].end))
        parts, start = (1.0, 1.0, 0.5), follower_start(problem)
        asked = Taylor([each * part for each, part in zip(y[: len(found)], parts, strict=False)]) + start
        off = Taylor([each * part for each, part in zip(found, parts, strict=False)])
        moved = problem.train_off(errors).tool(asked + off) - train.tool(asked)
        return np.asarray(moved.derivative(self.order) + np.zeros_like(there))

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
        moved = self._moved(angles, side, late)
        found = dict[str, FloatArray]()
        for key, ends in self.ends.items():
            low, high = (np.full(angles.size, end) for end in ends)
            if (way := way_of(key)) in self.ends and not is_way(key):
                right, up, left, down = (moved({key: high, way: np.full(angles.size, each)}) for each in QUARTERS)
                found |= {key: high, way: np.arctan2(up - down, right - left)}
            elif not is_way(key):
                found[key] = np.where(moved({key: low}) > moved({key: high}), low, high)
        return found

    def _moved(self, angles: FloatArray, side: float, late: float) -> Callable[[Mapping[str, Any]], FloatArray]:
        """How far errors move the tool to a side, with so much of how late they make the cam."""
        ends = {key: np.full(angles.size, high) for key, (_, high) in self.ends.items()}
        every = self.contact(ends, angles, jumps=False)
        weight = np.abs(every.error) / np.maximum(np.abs(every.angle - angles), JUMP_SIDE)

        def moved(errors: Mapping[str, Any]) -> FloatArray:
            found = self.contact(errors, angles, jumps=False)
            return np.asarray(side * found.error + late * weight * (found.angle - angles))

        return moved

    def said(self, errors: Mapping[str, float], angle: float) -> dict[str, float]:
        """Errors in mm and deg; with the direction of the bore as the cam has it, and where waves have a crest."""
        found, sense = dict(errors), self.problem.design.sense
        if BORE in errors:
            there = angle
            if self.problem.setup.mechanism.body.developed:
                there = float(self.contact(errors, np.array([angle])).angle[0]) + errors.get("phase", 0.0)
            found[BORE_WAY] = errors[BORE_WAY] - sense * there
        for key in errors:
            if key.startswith(WAY):
                found[key] = self.waves * self.place_of(key, errors, angle) - errors[key]
        shown = {key: degrees(each) for key, each in found.items() if is_way(key) or key in ANGLES}
        return found | {key: each % 360.0 if is_way(key) else each for key, each in shown.items()}

    def place_of(self, key: str, errors: Mapping[str, float], angle: float) -> float:
        """The cam angle of the place of the profile that an error is of, where the first contact touches at one."""
        return angle


def rate_ends(turn: TurnErrors) -> dict[str, tuple[float, float]]:
    """Between which values each error of the cams within the tolerances is, with those that have a way.

    A profile whose waves are not limited counts as one that is off by a constant: it has no bound.
    """
    found, waves = ends_of(turn.scene, turn.problem), turn.scene.tolerances.waves
    for key, (_, high) in [*found.items()]:
        if key == BORE or (waves and key.startswith("profile")):
            found |= {key: (0.0, high), way_of(key): (-pi, pi)}
    return found

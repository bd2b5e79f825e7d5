"""The largest error of the displacement of the tool, of all cams within the tolerances: a bound and a witness.

The exact error of a cam (``tolerances.touching``) is a formula of its errors and of the point that is touched. Run
on ranges with slopes, it decides by bisection of errors and turn whether any cam at any point is beyond a bound
(``verdicts.claim_boxes``). The bound is a little more than what the worst cam that was found has. Where a cam is
worse than that one, it takes its place.

Where y(θ) is off the motion at φ by the small angle a = θ − φ, that is y'·a + y''·a²/2 with y'' within the third
derivative times |a| of that at φ, and J·(a − d)²/2 for each jump J of y'' which is passed after d.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6 and 11.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import degrees, inf, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.effects.motion import scale
from camopt.mechanisms import Designs
from camopt.mechanisms.rest import Rest
from camopt.mistakes import BadInput, Mistake
from camopt.motion.driven import tool_position
from camopt.motion.programme import Programme
from camopt.motion.table import ALL_STROKES
from camopt.numerics import GIVEN, LARGEST_MAGNITUDE, FloatArray
from camopt.numerics.clock import now
from camopt.numerics.curves import formula
from camopt.numerics.interval import Interval, as_interval
from camopt.numerics.sloped import Sloped, at_point, by_chain, range_of, widened
from camopt.numerics.taylor import Taylor
from camopt.problem.claims import Claim, Plain
from camopt.problem.problem import Problem
from camopt.problem.variables import is_of_train
from camopt.scene.tolerances import ANGLES
from camopt.tolerances.ranges import along_turn, from_0, none_of, plain, still
from camopt.tolerances.touching import BORE, BORE_WAY, Contact, contact_of, error_ends, off_by
from camopt.tolerances.turn import TurnErrors, highest
from camopt.trains.carried import Joint
from camopt.verdicts.claim_boxes import Answer, Parts, Search
from camopt.verdicts.words import BROKEN, HELD

GAPS = (1e-5, 1e-4, 1e-3, 1e-2)
"""Relative, of the largest error found: by no more than this a cam is worse, the first that is proved."""
WORSE = 8
"""How often a worse cam than the worst so far is taken for it."""
SECONDS = 20.0
PROFILE_PLACES = "tolerances.profile (part.profile_tolerance)"
CORNERS = "the velocity of the motion jumps"
HALVINGS = 12
"""Of a tolerance that is too large, for the largest one that is not."""
SAME_PLACE = 1e-9
"""Cam angles this near to each other are the same, rad."""
SUMMED = 16.0 * GIVEN
"""What rounding takes off a sum of a few products, relative to their magnitudes."""


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


class Jumped(NamedTuple):
    """A jump of y'' as seen from parts of the turn."""

    size: float
    ahead: Interval
    """How far it is ahead, rad."""
    behind: Interval

    def seen(self, a: Interval) -> tuple[Interval, Interval, Interval]:
        """What it adds to y, to y' and to y'' at an angle a further on."""
        over, back = _beyond(a, self.ahead), _beyond(-a, self.behind)
        passed = _none_or_all(over) - _none_or_all(back)
        return (over * over - back * back) * (0.5 * self.size), (over + back) * self.size, passed * self.size


def _beyond(a: Interval, distance: Interval) -> Interval:
    return Interval(np.maximum(a.low - distance.high, 0.0), np.maximum(a.high - distance.low, 0.0))


def _none_or_all(beyond: Interval) -> Interval:
    """1 beyond a jump, 0 before it."""
    return Interval(np.where(beyond.low > 0.0, 1.0, 0.0), np.where(beyond.high > 0.0, 1.0, 0.0))


class Place(NamedTuple):
    """The state of the follower over parts of the turn, and at their middles, with the jumps of y''."""

    y: Sloped
    y1: Sloped
    y2: Sloped
    jumps: list[Jumped]
    of_middle: list[Jumped]


class ToolError(NamedTuple):
    """The exact error of the tool where a cam with errors touches, mm (rad); on ranges with slopes alone."""

    problem: Problem
    design: Designs
    errors: Mapping[str, Any]


@formula(ToolError)
def tool_error(f, i, at):  # type: ignore[no-untyped-def]
    setup = f.problem.setup
    moved, turned = rest_over(f.problem, f.design, f.errors, at.y, at.y1)
    change = ahead_of(f.problem.programme, at, turned).y
    if setup.train is None:
        return moved - change, 0.0
    return through(f.problem, f.errors, moved - change, at.y + change), 0.0


def rest_over(problem: Problem, design: Designs, errors: Mapping[str, Any], y: Sloped, y1: Sloped) -> Rest:
    """Where a follower rests over boxes, of errors of its cam with that of the phase."""
    found = problem.setup.mechanism.rest(design, problem.programme.lift, y, y1, off_by(errors))
    moved, turned = (plain(each, y) for each in found)
    return Rest(moved, turned - errors.get("phase", 0.0))


class FurtherOn(NamedTuple):
    """The motion at an angle further on: by how much y differs there, and y'."""

    y: Sloped
    y1: Sloped


def ahead_of(programme: Programme, at: Place, turned: Sloped) -> FurtherOn:
    """y(φ + a) − y(φ) and y'(φ + a), where a changes with the errors and with φ."""
    table, place = programme.table, replace(at.y, slopes=along_turn(at.y))
    jerk = float((table.most[:, 3] + table.error[:, 3]).max())

    def ahead(a: Interval, y1: Interval, y2: Interval, jumps: list[Jumped]) -> tuple[Interval, Interval, Interval]:
        """By how much y and y' differ at an angle a further on, and y'' there."""
        stray, seen = a.largest_magnitude * jerk + programme.unseen_jump, [jump.seen(a) for jump in jumps]
        there = Interval(y2.low - stray, y2.high + stray)
        bent = a * there
        rise, room = a * y1 + a * bent * 0.5, SUMMED * ((a * y1).largest_magnitude + (a * bent).largest_magnitude)
        smooth = Interval(rise.low - room, rise.high + room), bent, there
        rise, further, there = (sum(each, first) for first, *each in zip(smooth, *seen, strict=True))
        return rise, further, there

    a, y1, y2 = (range_of(each) for each in (turned, at.y1, at.y2))
    value, further, there = ahead(a, y1, y2, at.jumps)
    point, to_point, _ = ahead(at_point(turned), at_point(at.y1), at_point(at.y2), at.of_middle)
    y = by_chain(value, point, [(turned, y1 + further), (place, further)])
    return FurtherOn(y, by_chain(y1 + further, at_point(at.y1) + to_point, [(turned, there), (place, there)]))


class Ahead(NamedTuple):
    """How far a tool is ahead of where it should be, and its slopes by where its follower stands and is off."""

    value: Interval
    by_place: Interval
    by_error: Interval


Off = Mapping[str, Interval]
"""By how much links are off, by key of the scene."""


@dataclass(frozen=True)
class OffTrain:
    """A train whose links may be off."""

    problem: Problem

    def ahead(self, error: Interval, stands: Interval, off: Off) -> Ahead:
        """f*(stands + error) − f(stands), by Taylor's theorem to the second order in all that is off."""
        start, between = ({key: part(each) for key, each in off.items()} for part in (none_of, from_0))
        return self._along(error, stands, start, between, off)

    def between(self, error: Interval, stands: Interval, off: Off) -> Ahead:
        """f*(stands + error) − f*(stands)."""
        return self._along(error, stands, off, off, {key: none_of(each) for key, each in off.items()})

    def _along(self, error: Interval, stands: Interval, start: Off, between: Off, ways: Off) -> Ahead:
        first = self._tool(stands, error, start, ways, 2).moved.derivative(1)
        tool = self._tool(stands + from_0(error), error, between, ways, 3)
        value = widened(range_of(first) + range_of(tool.moved.derivative(2)) * 0.5, SUMMED)
        return Ahead(value, range_of(tool.ratio.derivative(1)), range_of(tool.ratio.terms[0]))

    def slope(self, key: str, places: Interval, off: Off) -> Interval:
        """∂f*/∂p of a number of the train."""
        ways = {each: none_of(by) + (1.0 if each == key else 0.0) for each, by in off.items()}
        between = {each: from_0(by) for each, by in off.items()}
        return range_of(self._tool(places, none_of(places), between, ways, 2).moved.derivative(1))

    def _tool(self, place: Interval, way: Interval, off: Off, ways: Off, terms: int) -> Joint:
        """The tool as a series along a way that follower and links go."""
        nominal, start = self.problem.nominal, follower_start(self.problem)
        made = {key: _series(nominal[key] + each, ways[key], terms) for key, each in off.items()}
        train = self.problem.trains(made) if made else self.problem.setup.train
        assert train is not None
        return train.joints(_series(start + place, way, terms))[-1]


def through(problem: Problem, errors: Mapping[str, Any], error: Sloped, stands: Sloped) -> Sloped:
    """f*(y + δ) − f(y), of a follower that should stand at y."""
    train = problem.setup.train
    links = {key: plain(each, stands) for key, each in errors.items() if is_of_train(key)}
    assert train is not None
    if not links and (ratio := train.constant_ratio) is not None:
        return by_chain(error.value * ratio, error.at * ratio, [(error, as_interval(ratio))])
    of, off = OffTrain(problem), {key: each.value for key, each in links.items()}
    whole = of.ahead(error.value, stands.value, off)
    point = of.ahead(error.at, stands.at, {key: each.at for key, each in links.items()})
    places = stands.value + from_0(error.value)
    by_links = [(each, of.slope(key, places, off)) for key, each in links.items()]
    return by_chain(whole.value, point.value, [(error, whole.by_error), (stands, whole.by_place), *by_links])


def _series(place: Interval, slope: Interval, terms: int) -> Taylor:
    """What is straight, in ranges without slopes, for the formulas of links."""
    return Taylor([still(each) for each in (place, slope, none_of(slope))[:terms]])


def follower_start(problem: Problem) -> float:
    """The displacement of the follower from the start position of its train, where that of the turn is 0."""
    programme, first, train = problem.programme, np.zeros(1), problem.setup.train
    assert train is not None
    return float((train.follower_at(tool_position(programme, first)) - programme.at(first)[0])[0])


class Proof(Search):
    """The search for a cam that exceeds a bound, which knows where y'' jumps."""

    def state(self, parts: Parts, u: FloatArray, angle: Sloped) -> Place:
        y, y1, y2, *_ = super().state(parts, u, angle)
        return Place(y, y1, y2, self._jumps(parts, parts.low[0], parts.high[0]), self._jumps(parts, u, u))

    def _jumps(self, parts: Parts, low: FloatArray, high: FloatArray) -> list[Jumped]:
        """The jumps of y'' as seen from shares of panels, from their lower to their upper ends."""
        programme = self.problem.programme
        half, middle = (each[parts.panel] for each in (programme.table.half_width, programme.table.centre))
        turn, found = programme.strokes[-1].end, list[Jumped]()
        for jump in programme.jumps:
            after, before = (_away(side * (jump.at - middle) - half, turn) for side in (1.0, -1.0))
            ahead = Interval(after + (1.0 - high) * half, after + (1.0 - low) * half)
            behind = Interval(before + (1.0 + low) * half, before + (1.0 + high) * half)
            found.append(Jumped(jump.size, ahead, behind))
        return found


def _away(angle: FloatArray, turn: float) -> FloatArray:
    """An angle from 0 to a turn, where rounding may take 0 below it."""
    return np.maximum(np.mod(angle + SAME_PLACE, turn) - SAME_PLACE, 0.0)


@dataclass(frozen=True)
class WorstSearch:
    """The search for the worst of the cams within tolerances."""

    turn: TurnErrors
    ends: Mapping[str, tuple[float, float]]
    """Between which values each error is (``touching.error_ends``)."""

    @classmethod
    def of(cls, turn: TurnErrors) -> "WorstSearch":
        """That of the tolerances of a scene."""
        return cls(turn, error_ends(turn.scene, turn.problem))

    @property
    def problem(self) -> Problem:
        return self.turn.problem

    def run(self) -> WorstCase:
        """The worst cam that is found, and what no cam exceeds.

        BadInput for tolerances so large that a follower has no place on its cam.
        """
        try:
            return self._run()
        except FloatingPointError:
            raise self.lost() from None

    def _run(self) -> WorstCase:
        unit = scale(self.problem.setup, 0)
        errors = self.first()
        angle, found = self.highest(errors)
        bound, until, gaps = inf, now() + SECONDS, iter(GAPS)
        gap = next(gaps)
        for _ in range(WORSE if not self.problem.programme.corners else 0):
            bound = abs(found) * (1.0 + gap)
            answer = self.proof(bound, until)
            if answer.verdict == HELD:
                break
            bound = inf
            if answer.verdict == BROKEN and answer.witness is not None:
                other = {key: float(answer.witness.numbers[key][0]) for key in self.ends}
                there, error = self.highest(other)
                if abs(error) > abs(found):
                    errors, angle, found = other, there, error
                    continue
            if (larger := next(gaps, None)) is None:
                break
            gap = larger
        at = float(self.within(self.contact(errors, np.array([angle])).angle)[0])
        late = f"the time of {SECONDS:g} s was over" if now() > until else "the tolerances are too large for it"
        why = "" if bound < inf else late if not self.problem.programme.corners else CORNERS
        return WorstCase(unit * bound, unit * found, degrees(at), self.said(errors, angle), why)

    def proof(self, bound: float, until: float) -> Answer:
        """Whether no cam within the tolerances exceeds a bound."""

        def error(designs: Designs, programme: Programme) -> Any:
            return self.curve(designs, {key: designs.numbers[key] for key in self.ends})

        claim = Claim(error, ALL_STROKES, LARGEST_MAGNITUDE, Plain(bound))
        parts = Parts.first(self.problem, claim, self.ends)
        return Proof(self.problem, claim, self.problem.design, tuple(self.ends), until).run(parts)

    def curve(self, design: Designs, errors: Mapping[str, Any]) -> Any:
        """The exact error of the tool over the turn."""
        return ToolError(self.problem, design, errors)

    def rest(self, design: Designs, errors: Mapping[str, Any], at: Place) -> Rest:
        """Where a follower rests over boxes, in a dwell."""
        return rest_over(self.problem, design, errors, at.y, at.y1)

    def contact(self, errors: Mapping[str, Any], angles: FloatArray) -> Contact:
        """Where cams touch that have errors, and those of their motion there."""
        return contact_of(self.problem, errors, angles)

    def within(self, angles: FloatArray) -> FloatArray:
        """Cam angles within the turn, rad."""
        return np.asarray(np.mod(angles, self.problem.programme.strokes[-1].end))

    def first(self) -> dict[str, float]:
        """Errors at their ends that are the worst, or nearly so, at the worst cam angle."""
        found = []
        for side in (1.0, -1.0):

            def outward(angles: FloatArray, side: float = side) -> FloatArray:
                return side * self.error(self.corner(angles, side), angles)

            angle = np.array([highest(self.turn.nodes, outward)])
            here = {key: float(each[0]) for key, each in self.corner(angle, side).items()}
            found.append((float(outward(angle)[0]), here))
        return max(found, key=lambda each: each[0])[1]

    def corner(self, angles: FloatArray, side: float) -> dict[str, FloatArray]:
        """For each cam angle the ends of errors that move the tool furthest to a side."""
        found = dict[str, FloatArray]()
        for key, ends in self.ends.items():
            if key == BORE_WAY:
                continue
            tried = [dict.fromkeys([key], np.full(angles.size, end)) for end in ends]
            if BORE_WAY in self.ends and key == BORE:
                tried = [{BORE: np.full(angles.size, ends[1]), BORE_WAY: each} for each in self.ways(angles)]
            first, second = (side * self.error(each, angles) for each in tried)
            found |= {name: np.where(first > second, tried[0][name], tried[1][name]) for name in tried[0]}
        return found

    def ways(self, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The two directions along the normal of the cam."""
        programme = self.problem.programme
        y, y1, *_ = programme.at(angles)
        at = self.problem.setup.mechanism.contact(self.problem.design, programme.lift, angles, y, y1)
        return np.arctan2(at.up, at.across), np.arctan2(-at.up, -at.across)

    def error(self, errors: Mapping[str, Any], angles: FloatArray) -> FloatArray:
        """FloatingPointError where a follower does not touch its cam."""
        with np.errstate(invalid="ignore"):
            found = self.contact(errors, angles).error
        if not np.isfinite(found).all():
            raise FloatingPointError
        return found

    def lost(self) -> BadInput:
        """The message on tolerances so large that a follower has no place on its cam: the first such, or all."""
        keys = [[key] for key in self.ends if key not in (BORE, BORE_WAY)]
        alone = [*keys, *([[BORE, BORE_WAY]] if BORE in self.ends else [])]
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
            search = replace(self, ends=shared | {key: ends[key] for key in ends if key == BORE_WAY})
            search.highest(search.first())
        except FloatingPointError:
            return False
        return True

    def highest(self, errors: Mapping[str, float]) -> tuple[float, float]:
        """Where on its profile a cam has its largest error, and this."""
        angle = highest(self.turn.nodes, lambda angles: np.abs(self.error(errors, angles)))
        return angle, float(self.error(errors, np.array([angle]))[0])

    def said(self, errors: Mapping[str, float], angle: float) -> dict[str, float]:
        """Errors in mm and deg, with the direction of the bore as the cam has it."""
        sense, found = self.problem.design.sense, dict(errors)
        if BORE in errors and BORE_WAY not in errors:
            there = self.contact(errors, np.array([angle])).angle[0] + errors.get("phase", 0.0)
            found |= {BORE: abs(errors[BORE]), BORE_WAY: -sense * there + (pi if errors[BORE] < 0.0 else 0.0)}
        elif BORE in errors:
            found[BORE_WAY] = errors[BORE_WAY] - sense * angle
        angles = {key: degrees(found[key]) for key in found if key in (*ANGLES, BORE_WAY)}
        if BORE in errors:
            angles[BORE_WAY] %= 360.0
        return found | angles

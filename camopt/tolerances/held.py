"""What holds a follower from both sides, of all cams within tolerances: what two contacts are apart, or the play.

Two contacts are held further apart by s (``tolerances.two_contacts``), so that the interference is δ₀ + s and the
preload k·(δ₀ + s). A roller in a groove that is wider by c along its normal moves its tool by

    c·|N|/(N·u)·f'        that is c/cos β of a follower that translates

from one wall to the other (``tolerances.response``). So do two rollers with the clearance c about a rib, less s.

The worst cam of a pair is one at ends of its zones, by exact contact with each disc at one cam angle. That none
is worse than half of what both contacts have at most, is proved of each by itself (``tolerances.worst_case``).

Source: Rothbart, Cam Design Handbook, ch. 3 and 13 (conjugate cams; clearance of grooves).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import degrees, inf
from typing import NamedTuple

import numpy as np

from camopt.effects import Case, offered
from camopt.effects.motion import scale, unit_of
from camopt.motion.driven import tool_position
from camopt.numerics import FloatArray
from camopt.numerics.taylor import Taylor
from camopt.problem.problem import Problem
from camopt.problem.variables import is_of_train
from camopt.problem.zones import number_zones, tool_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLES, Zone
from camopt.tables.cells import with_unit
from camopt.tolerances.response import Responses
from camopt.tolerances.touching import BORE, BORE_WAY, error_ends
from camopt.tolerances.turn import TurnErrors, highest, worst
from camopt.tolerances.two_contacts import (
    SECOND,
    WIDER,
    PairCams,
    PairResponses,
    contacts_of,
    errors_at,
    off_apart,
)
from camopt.tolerances.worst_case import CORNERS, WorstCase, WorstSearch
from camopt.verdicts.running import run_effects

APART = ("subtending_angle_deg", "roller_distance_mm", "breadth_mm", "roller_spacing_mm")
"""What two contacts are apart: the first of these that a mechanism has."""
UNPROVED = (
    "of two contacts it is of a train with a constant ratio alone, whose links are not off, and takes its time"
)
INTERFERENCE, BACKLASH = "interference", "backlash of the tool"
NONE = Zone(0.0, 0.0, 0.0)


class Play(NamedTuple):
    """Something that holds a follower from both sides, over the turn and all cams within the tolerances.

    Examples
    --------
    >>> scene = camopt.find_scene("press-feed-by-pair").replace(part={}, tolerances={"disc_phase": 0.01})
    >>> apart, interference, preload = camopt.tolerance(scene).plays
    >>> interference.what, interference.nominal, round(interference.least, 5), round(interference.most, 5)
    ('interference', 0.01, 0.00675, 0.01325)
    """

    what: str
    unit: str
    nominal: float
    """Of the nominal cam; of a backlash the largest over the turn."""
    least: float
    """Below 0 of an interference that is lost: the clearance that is left then."""
    most: float


def lost_within(play: Play) -> str:
    """What is lost of an interference within the tolerances, in a sentence; "" if nothing is."""
    if play.what != INTERFERENCE or not play.nominal or play.least > 0.0:
        return ""
    clearance = with_unit(-play.least, play.unit)
    return f"Not all cams within the tolerances have a preload: the worst has a clearance of {clearance}."


def preload_lost(scene: Scene, problem: Problem) -> str:
    """The same of a scene with two contacts of its follower on discs."""
    return "".join(map(lost_within, plays(TurnErrors(scene.toleranced, problem))))


def plays(turn: TurnErrors) -> Iterator[Play]:
    """Those of a scene with tolerances, to first order; none of a follower that one side holds."""
    problem = turn.problem
    zones = number_zones(turn.scene, problem.nominal)
    if problem.setup.mechanism.further:
        yield from _of_pair(turn, zones)
    elif problem.setup.mechanism.two_sided and problem.setup.given["drive.clearance"]:
        play, zone = float(problem.nominal["drive.clearance"]), zones.get("drive.clearance", NONE)
        answer = scale(problem.setup, 0) * np.abs(Responses(problem, turn.nodes).to_profile[0])
        ends = play * answer.max(), (play + zone.lower) * answer.min(), (play + zone.upper) * answer.max()
        yield Play(BACKLASH, unit_of(problem.setup, 0), *map(float, ends))


def _of_pair(turn: TurnErrors, zones: Mapping[str, Zone]) -> Iterator[Play]:
    problem, between = turn.problem, off_apart(turn.scene, turn.problem, turn.nodes)
    unit, angle = (degrees(1.0), "deg") if problem.setup.angular else (1.0, "mm")
    low, high = unit * between.least, unit * between.most
    name = next(each for each in APART if each in offered(problem.setup))
    columns = run_effects(Case(problem.setup, problem.programme, problem.design), [name]).columns
    drawn = float(np.ravel(columns[name])[0])
    yield Play(name.removesuffix(f"_{angle}").replace("_", " "), angle, drawn, drawn + low, drawn + high)
    given = problem.nominal
    if (clearance := given.get("drive.clearance")) is not None:
        zone, answers = zones.get("drive.clearance", NONE), PairResponses(problem, turn.nodes)
        wide, ratio = answers.apart(WIDER) / 2.0, scale(problem.setup, 0) * np.abs(answers.ratio)
        least = (ratio * ((clearance + zone.lower) * wide - between.high)).min()
        most = (ratio * ((clearance + zone.upper) * wide - between.low)).max()
        drawn = (ratio * clearance * wide).max()
        yield Play(BACKLASH, unit_of(problem.setup, 0), *map(float, (drawn, least, most)))
    if (interference := given.get("drive.interference")) is None:
        return
    zone = zones.get("drive.interference", NONE)
    ends = interference + zone.lower + low, interference + zone.upper + high
    yield Play(INTERFERENCE, angle, interference, *ends)
    stiffness, zone = given.get("drive.stiffness"), zones.get("drive.stiffness", NONE)
    if stiffness is not None:
        products = [(stiffness + by) * end / unit for by in (zone.lower, zone.upper) for end in ends]
        preload = stiffness * interference / unit
        yield Play("preload", "N·m" if problem.setup.angular else "N", preload, min(products), max(products))


@dataclass(frozen=True)
class PairWorst:
    """The search for the worst error of a follower with two contacts."""

    turn: TurnErrors

    def run(self) -> WorstCase:
        """The worst cam at the worst cam angle to first order, by exact contact, and what none exceeds."""
        unit, angle = scale(self.turn.problem.setup, 0), np.array([self.turn.highest(worst, 0)])
        errors = self._corner(angle)
        at = highest(self.turn.nodes, lambda angles: np.abs(self.error(errors, angles)))
        found = unit * float(self.error(errors, np.array([at]))[0])
        said = {key: degrees(each) if key in (*ANGLES, BORE_WAY) else each for key, each in errors.items()}
        bound = unit * self.bound()
        why = "" if bound < inf else CORNERS if self.turn.problem.programme.corners else UNPROVED
        return WorstCase(bound, found, degrees(at), said, why)

    def error(self, errors: Mapping[str, float], angles: FloatArray) -> FloatArray:
        """The error of the tool, mm (rad)."""
        problem, train = self.turn.problem, self.turn.problem.setup.train
        own = {key: each for key, each in errors.items() if not is_of_train(key)}
        moved, _ = PairCams(problem).at(own, angles)
        if train is None:
            return moved
        stands = train.follower_at(tool_position(problem.programme, angles))
        there = problem.train_off(errors).tool(Taylor([stands + moved])).terms[0]
        return np.asarray(there - train.tool(Taylor([stands])).terms[0])

    def bound(self) -> float:
        """Half of what both contacts may have at most, mm (rad); infinite behind a train whose ratio changes."""
        problem = self.turn.problem
        ratio = 1.0 if problem.setup.train is None else problem.setup.train.constant_ratio
        if ratio is None or any(map(is_of_train, tool_zones(self.turn.scene, problem.nominal))):
            return inf
        unit, total = degrees(1.0) if problem.setup.angular else 1.0, 0.0
        for contact, ends in zip(contacts_of(problem), self._ends(), strict=True):
            total += WorstSearch(TurnErrors(self.turn.scene, contact), ends).run().bound / unit if ends else 0.0
        return abs(ratio) * total / 2.0

    def _ends(self) -> tuple[dict[str, tuple[float, float]], dict[str, tuple[float, float]]]:
        """Between which values errors are at each contact, by their keys there."""
        problem = self.turn.problem
        found = dict[str, tuple[float, float]](), dict[str, tuple[float, float]]()
        for tolerance, (low, high) in error_ends(self.turn.scene, problem).items():
            if tolerance in (BORE, BORE_WAY):
                for ends in found:
                    ends[tolerance] = low, high
                continue
            if is_of_train(tolerance):
                continue
            for at in errors_at(problem, tolerance).values():
                for own, ends in zip(at, found, strict=True):
                    if own is not None:
                        key, sign = own
                        before = ends.get(key, (0.0, 0.0))
                        more = sorted((sign * low, sign * high))
                        ends[key] = before[0] + more[0], before[1] + more[1]
        return found

    def _corner(self, angle: FloatArray) -> dict[str, float]:
        """The ends of errors that move the tool furthest at a cam angle, mm or rad."""
        found, given, problem = self.turn.at(angle), self.turn.scene.tolerances, self.turn.problem
        side = 1.0 if sum(each.upper[0, 0] for each in found) >= -sum(each.lower[0, 0] for each in found) else -1.0
        zones, errors = tool_zones(self.turn.scene, problem.nominal), dict[str, float]()
        answers = PairResponses(problem, angle)
        for each in found:
            tolerance = each.key.removesuffix(SECOND)
            if tolerance == BORE:
                x, y = (answers.through_train((one - other) / 2.0)[0, 0] for one, other in answers.bores)
                errors |= {BORE: given.bore_eccentricity or 0.0, BORE_WAY: float(np.arctan2(side * y, side * x))}
            elif tolerance == "profile":
                answer = answers.to(errors_at(problem, "profile")[each.key])[0, 0]
                errors[each.key] = side * float(np.sign(answer)) * (given.profile or 0.0)
            else:
                zone, upwards = zones[tolerance], side * each.answer[0, 0] >= 0.0
                errors[each.key] = zone.upper if upwards else zone.lower
        return errors

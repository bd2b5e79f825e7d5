"""What holds a follower from both sides, of all cams within tolerances: what two contacts are apart, or the play.

Two contacts are held further apart by s (``tolerances.two_contacts``), so that the interference is δ₀ + s and the
preload k·(δ₀ + s). A roller in a groove that is wider by c along its normal moves its tool by

    c·|N|/(N·u)·f'        that is c/cos β of a follower that translates

from one wall to the other (``tolerances.response``). So do two rollers with the clearance c about a rib, less s.

The preload turns the camshaft by at most max (P·|s'|), with the largest of both at each cam angle.

Source: Rothbart, Cam Design Handbook, ch. 3 and 13 (conjugate cams; clearance of grooves).
"""

from collections.abc import Iterator, Mapping
from math import degrees
from typing import NamedTuple

import numpy as np

from camopt.effects import Case, offered
from camopt.effects.motion import scale, unit_of
from camopt.problem.problem import resolve_design
from camopt.problem.zones import number_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import Zone
from camopt.tables.cells import with_unit
from camopt.tolerances.response import Responses
from camopt.tolerances.turn import TurnErrors
from camopt.tolerances.two_contacts import (
    PairResponses,
    fastest_apart,
    off_apart,
    wider,
)
from camopt.verdicts.running import run_effects

APART = ("subtending_angle_deg", "roller_distance_mm", "breadth_mm", "roller_spacing_mm")
"""What two contacts are apart: the first of these that a mechanism has."""
INTERFERENCE, BACKLASH, TORQUE = "interference", "backlash of the tool", "torque of the preload"
NONE = Zone(0.0, 0.0, 0.0)


class Play(NamedTuple):
    """Something that holds a follower from both sides, over the turn and all cams within the tolerances.

    Examples
    --------
    >>> scene = camopt.find_scene("press-feed-by-pair").replace(part={}, tolerances={"disc_phase": 0.01})
    >>> apart, interference, preload, torque = camopt.tolerance(scene).plays
    >>> interference.what, interference.nominal, round(interference.least, 5), round(interference.most, 5)
    ('interference', 0.01, 0.00675, 0.01325)
    """

    what: str
    unit: str
    nominal: float
    """Of the nominal cam; of a backlash the largest over the turn."""
    least: float
    """Below 0 of an interference that is lost: the clearance that is left then; the preload is 0 then."""
    most: float


def lost_within(play: Play) -> str:
    """What is lost of an interference within the tolerances, in a sentence; "" if nothing is."""
    if play.what != INTERFERENCE or not play.nominal or play.least > 0.0:
        return ""
    clearance = with_unit(-play.least, play.unit)
    return f"Not all cams within the tolerances have a preload: the worst has a clearance of {clearance}."


def notes_on_preload(scene: Scene) -> Iterator[str]:
    """The sentence on cams within the tolerances that have no preload between two contacts."""
    if scene.mechanism.further and scene.drive.interference:
        yield from filter(None, map(lost_within, plays(TurnErrors(scene.toleranced, resolve_design(scene)))))


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
        wide, ratio = answers.apart(wider(problem)) / 2.0, scale(problem.setup, 0) * np.abs(answers.ratio)
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
        products = [(stiffness + by) * max(end, 0.0) / unit for by in (zone.lower, zone.upper) for end in ends]
        preload = stiffness * interference / unit
        yield Play("preload", "N·m" if problem.setup.angular else "N", preload, min(products), max(products))
        most = (stiffness + zone.upper) * np.maximum(ends[1] - high + unit * between.high, 0.0) / unit
        torque = float((most * fastest_apart(turn.scene, problem, turn.nodes)).max())
        torque *= 1.0 if problem.setup.angular else 1e-3
        yield Play(TORQUE, "N·m", 0.0, -torque, torque)

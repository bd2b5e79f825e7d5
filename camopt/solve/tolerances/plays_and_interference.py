"""What holds a follower from both sides, of all cams within tolerances: what two contacts are apart, or the play.

Two contacts are held further apart by s (``tolerances.response``), so that the interference is δ₀ + s and the
preload k·(δ₀ + s). A roller in a groove that is wider by c along its normal moves its tool by

    c·|N|/(N·u)·f'        that is c/cos β of a follower that translates

from one wall to the other (``tolerances.response``). So do two rollers with the clearance c about a rib, less s.

The preload turns the camshaft by at most max (P·|s'|), with the largest of both at each cam angle.

Source: Rothbart, Cam Design Handbook, ch. 3 and 13 (conjugate cams; clearance of grooves).

The interference of cams within tolerances with two contacts of their follower: of the mounting, and of errors.

It is δ₀ + s (``tolerances.response``), where s changes over the turn: of a cam with some sizes s is that of
these, with whatever other errors make of it, at the cam angle at which it is the most, or the least.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import degrees
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.effects import EvaluationBlock, available_quantities
from camopt.model.effects.error_response import SECOND_CONTACT_SUFFIX
from camopt.model.effects.motion import motion_scale, motion_table_unit
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.problem.tolerance_zones import number_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ToleranceZone, moves_tool
from camopt.solve.tables.cells import with_unit
from camopt.solve.tolerances.error_samples import map_cam_blocks, real_error_columns
from camopt.solve.tolerances.errors import CamErrors
from camopt.solve.tolerances.response import (
    BASE_RADII,
    PairResponse,
    SeparationRange,
    SeparationResponse,
    ToolResponse,
    fastest_separation,
    separation_range,
    separation_responses,
    wider_profiles,
)
from camopt.solve.tolerances.turn_errors import TurnErrors
from camopt.solve.verdicts.effect_runs import run_effects

SEPARATION_QUANTITIES = ("subtending_angle_deg", "roller_distance_mm", "breadth_mm", "roller_spacing_mm")
"""What two contacts are apart: the first of these that a mechanism has."""
INTERFERENCE_NAME, BACKLASH_NAME, TORQUE_NAME = "interference", "backlash of the tool", "torque of the preload"
ZERO_ZONE = ToleranceZone(0.0, 0.0, 0.0)


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


def lost_preload_sentence(play: Play) -> str:
    """What is lost of an interference within the tolerances, in a sentence; "" if nothing is."""
    if play.what != INTERFERENCE_NAME or not play.nominal or play.least > 0.0:
        return ""
    clearance = with_unit(-play.least, play.unit)
    return f"Not all cams within the tolerances have a preload: the worst has a clearance of {clearance}."


def notes_on_preload(scene: Scene) -> Iterator[str]:
    """The sentence on cams within the tolerances that have no preload between two contacts."""
    if scene.mechanism.further_contacts and scene.drive.interference:
        yield from filter(
            None, map(lost_preload_sentence, list_plays(TurnErrors(scene.toleranced, resolve_design(scene))))
        )


def list_plays(turn: TurnErrors) -> Iterator[Play]:
    """Those of a scene with tolerances, to first order; none of a follower that one side holds."""
    problem = turn.problem
    zones = number_zones(turn.scene, problem.nominal_numbers)
    if problem.setup.mechanism.further_contacts:
        yield from _pair_plays(turn, zones)
    elif problem.setup.mechanism.two_sided and problem.setup.given["drive.clearance"]:
        play, zone = float(problem.nominal_numbers["drive.clearance"]), zones.get("drive.clearance", ZERO_ZONE)
        answer = motion_scale(problem.setup, 0) * np.abs(ToolResponse(problem, turn.nodes).profile_response[0])
        ends = play * answer.max(), (play + zone.lower) * answer.min(), (play + zone.upper) * answer.max()
        yield Play(BACKLASH_NAME, motion_table_unit(problem.setup, 0), *map(float, ends))


def _pair_plays(turn: TurnErrors, zones: Mapping[str, ToleranceZone]) -> Iterator[Play]:
    problem, between = turn.problem, separation_range(turn.scene, turn.problem, turn.nodes)
    unit, angle = (degrees(1.0), "deg") if problem.setup.angular else (1.0, "mm")
    low, high = unit * between.lowest, unit * between.highest
    name = next(each for each in SEPARATION_QUANTITIES if each in available_quantities(problem.setup))
    columns = run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), [name]).columns
    drawn = float(np.ravel(columns[name])[0])
    yield Play(name.removesuffix(f"_{angle}").replace("_", " "), angle, drawn, drawn + low, drawn + high)
    given = problem.nominal_numbers
    if (clearance := given.get("drive.clearance")) is not None:
        zone, answers = zones.get("drive.clearance", ZERO_ZONE), PairResponse(problem, turn.nodes)
        wide, ratio = (
            answers.separation_response(wider_profiles(problem)) / 2.0,
            motion_scale(problem.setup, 0) * np.abs(answers.tool_ratio),
        )
        least = (ratio * ((clearance + zone.lower) * wide - between.high)).min()
        most = (ratio * ((clearance + zone.upper) * wide - between.low)).max()
        drawn = (ratio * clearance * wide).max()
        yield Play(BACKLASH_NAME, motion_table_unit(problem.setup, 0), *map(float, (drawn, least, most)))
    if (interference := given.get("drive.interference")) is None:
        return
    zone = zones.get("drive.interference", ZERO_ZONE)
    ends = interference + zone.lower + low, interference + zone.upper + high
    yield Play(INTERFERENCE_NAME, angle, interference, *ends)
    stiffness, zone = given.get("drive.stiffness"), zones.get("drive.stiffness", ZERO_ZONE)
    if stiffness is not None:
        products = [(stiffness + by) * max(end, 0.0) / unit for by in (zone.lower, zone.upper) for end in ends]
        preload = stiffness * interference / unit
        yield Play("preload", "N·m" if problem.setup.angular else "N", preload, min(products), max(products))
        most = (stiffness + zone.upper) * np.maximum(ends[1] - high + unit * between.high, 0.0) / unit
        torque = float((most * fastest_separation(turn.scene, problem, turn.nodes)).max())
        torque *= 1.0 if problem.setup.angular else 1e-3
        yield Play(TORQUE_NAME, "N·m", 0.0, -torque, torque)


INTERFERENCE_KEY, LEAST_INTERFERENCE = "drive.interference", 1e-12
"""The second is in place of one below 0: what a clearance does no preload tells."""
SEPARATED_CAMS_AT_ONCE = 2**8
"""Cams: what is computed of them at all cam angles stays in the cache of a processor."""
EXACT_MOUNTING = ToleranceZone(0.0, 0.0, 0.0)


def separating_errors(off: CamErrors) -> CamErrors:
    """Those of some errors that may hold two contacts further apart."""
    return {
        key: each
        for key, each in off.items()
        if key in BASE_RADII or moves_tool(key.removesuffix(SECOND_CONTACT_SUFFIX))
    }


@dataclass(frozen=True)
class Interference:
    """That of all cams within the tolerances, in the unit of its key."""

    nominal: float
    mounting_zone: ToleranceZone
    """By how much the mounting alone is off."""
    responses: tuple[SeparationResponse, ...]
    unit_factor: float

    @classmethod
    def from_scene(
        cls, scene: Scene, problem: Problem, nominal: float, mounted: ToleranceZone | None
    ) -> "Interference":
        answers = separation_responses(scene, problem, TurnErrors(scene, problem).nodes)
        return cls(nominal, mounted or EXACT_MOUNTING, (*answers,), degrees(1.0) if problem.setup.angular else 1.0)

    @property
    def zone(self) -> ToleranceZone:
        """By how much that of any cam may be off."""
        low, high = (float(end[0]) - self.nominal for end in self.interference_range({}))
        return ToleranceZone(low, high, 0.0)

    def interference_range(self, off: Mapping[str, FloatArray]) -> SeparationRange:
        """Between which values it is of cams (n,) whose sizes are off by so much, by their keys."""
        none = np.zeros((1, 1))  # of one cam, where no size is said
        low, high = (
            sum((each.separation_of_cams(off.get(each.key), end) for each in self.responses), none)
            for end in (0, 1)
        )
        ends = (
            self.nominal + self.mounting_zone.lower + self.unit_factor * low.min(axis=-1),
            self.nominal + self.mounting_zone.upper + self.unit_factor * high.max(axis=-1),
        )
        return SeparationRange(*np.maximum(ends, min(LEAST_INTERFERENCE, self.nominal)))

    def sampled_interference_range(
        self, problem: Problem, off: CamErrors, waves: int, angles: FloatArray
    ) -> SeparationRange | None:
        """Its least and its most over the turn, of cams with errors (n,); None where none of them is of it."""
        moving = separating_errors(off)
        mounted = self.nominal + off.get(INTERFERENCE_KEY, 0.0)
        if not moving:
            return None
        answers = PairResponse(problem, angles)
        rows = np.array([row for key in moving for row in answers.separation_rows(key, waves)])

        def ends(some: CamErrors) -> list[FloatArray]:
            apart = real_error_columns(some) @ rows
            return [apart.min(axis=1), apart.max(axis=1)]

        found = np.hstack([*map_cam_blocks(moving, ends, SEPARATED_CAMS_AT_ONCE)])
        low, high = np.maximum(mounted + self.unit_factor * found, min(LEAST_INTERFERENCE, self.nominal))
        return SeparationRange(low, high)

"""Interference, preload and backlash of followers that are held from both sides, over all cams within tolerances.

**Two contacts.** Errors force the contacts apart by s (``tolerances.response``). The interference is δ₀ + s, the
preload k·(δ₀ + s), with the interference δ₀ of the mounting and the stiffness k. s changes over the turn. For a cam
with given sizes, s comes from these sizes and from any values of the other errors. The interference is taken at the
cam angle at which s is largest, or least. The preload loads the camshaft with a torque up to max (P·|s'|), with the
largest P and |s'| at each cam angle.

**A groove.** A roller in a groove that is wider by the clearance c along its normal moves its tool by

    c·|N|/(N·u)·f'        that is c/cos β for a translating follower

from one wall to the other (``tolerances.response``). Two rollers with the clearance c about a rib have the same
backlash, less s.

Source: Rothbart, Cam Design Handbook, ch. 3 and 13 (conjugate cams; clearance of grooves).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import degrees
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.effects import EvaluationBlock, available_quantities
from camopt.model.effects.error_response import (
    RESPONSE_ORDERS,
    SECOND_CONTACT_SUFFIX,
)
from camopt.model.effects.motion import motion_table_unit, motion_unit_factor
from camopt.model.effects.preload import INTERFERENCE_KEY, STIFFNESS_KEY
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.problem.tolerance_zones import tolerance_zones_of_numbers
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ToleranceZone, does_error_move_tool
from camopt.solve.tables.cells import with_unit
from camopt.solve.tolerances.error_samples import map_cam_blocks, real_error_columns
from camopt.solve.tolerances.errors import CamErrors, error_keys_at_contacts
from camopt.solve.tolerances.response import (
    BASE_RADII,
    PairResponse,
    SeparationRange,
    SeparationResponse,
    ToolResponse,
    largest_separation_slope_at_angles,
    separation_range,
    separation_responses_by_tolerance,
)
from camopt.solve.tolerances.turn_errors import TurnErrors
from camopt.solve.verdicts.effect_runs import run_effects

SEPARATION_QUANTITIES = ("subtending_angle_deg", "roller_distance_mm", "breadth_mm", "roller_spacing_mm")
"""Quantities for the distance of two contacts; a mechanism uses the first that it has."""
INTERFERENCE_NAME, BACKLASH_NAME, TORQUE_NAME = "interference", "backlash of the tool", "torque of the preload"
ZERO_ZONE = ToleranceZone(0.0, 0.0, 0.0)


class Play(NamedTuple):
    """Distance, interference, preload, torque or backlash of a follower held from both sides, over all cams.

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
    """Value of the nominal cam; for a backlash the largest over the turn."""
    least: float
    """Least value over the turn and all cams within the tolerances.

    A negative interference is a clearance; the preload is then 0.
    """
    most: float
    """Largest value over the turn and all cams within the tolerances."""


def lost_preload_sentence(play: Play) -> str:
    """The sentence that some cams have a clearance instead of an interference; "" if none has."""
    if play.what != INTERFERENCE_NAME or not play.nominal or play.least > 0.0:
        return ""
    clearance = with_unit(-play.least, play.unit)
    return f"Some cams within the tolerances have no preload: the worst has a clearance of {clearance}."


def notes_on_preload(scene: Scene) -> Iterator[str]:
    """The sentence on cams within the tolerances whose two contacts have no preload, if there are any."""
    if scene.mechanism.further_contacts and scene.drive.interference:
        yield from filter(
            None,
            map(
                lost_preload_sentence,
                list_plays(TurnErrors(scene.with_profile_tolerance_moved, resolve_design(scene))),
            ),
        )


def list_plays(turn: TurnErrors) -> Iterator[Play]:
    """The plays of a scene with tolerances, to first order; none for a follower with one contact."""
    problem = turn.problem
    zones = tolerance_zones_of_numbers(turn.scene, problem.nominal_numbers)
    if problem.setup.mechanism.further_contacts:
        yield from _pair_plays(turn, zones)
    elif problem.setup.mechanism.has_flanks_on_both_sides and problem.setup.given["drive.clearance"]:
        clearance, zone = float(problem.nominal_numbers["drive.clearance"]), zones.get("drive.clearance", ZERO_ZONE)
        response = motion_unit_factor(problem.setup, 0) * np.abs(
            ToolResponse(problem, turn.nodes).profile_response[0]
        )
        least, most = (clearance + zone.lower) * response.min(), (clearance + zone.upper) * response.max()
        ends = clearance * response.max(), least, most
        yield Play(BACKLASH_NAME, motion_table_unit(problem.setup, 0), *map(float, ends))


def _pair_plays(turn: TurnErrors, zones: Mapping[str, ToleranceZone]) -> Iterator[Play]:
    problem, separation = turn.problem, separation_range(turn.scene, turn.problem, turn.nodes)
    unit, angle = (degrees(1.0), "deg") if problem.setup.angular else (1.0, "mm")
    low, high = unit * float(separation.low.min()), unit * float(separation.high.max())
    name = next(each for each in SEPARATION_QUANTITIES if each in available_quantities(problem.setup))
    columns = run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), [name]).columns
    nominal = float(np.ravel(columns[name])[0])
    yield Play(name.removesuffix(f"_{angle}").replace("_", " "), angle, nominal, nominal + low, nominal + high)
    numbers = problem.nominal_numbers
    if (clearance := numbers.get("drive.clearance")) is not None:
        zone, response = zones.get("drive.clearance", ZERO_ZONE), PairResponse(problem, turn.nodes)
        width = sum(response.separation_rows(key, 0)[0] for key in error_keys_at_contacts(problem, "profile")) / 2.0
        tool_ratio = response.tool_derivatives(np.ones((RESPONSE_ORDERS, turn.nodes.size)))[0]
        ratio = motion_unit_factor(problem.setup, 0) * np.abs(tool_ratio)
        least = (ratio * ((clearance + zone.lower) * width - separation.high)).min()
        most = (ratio * ((clearance + zone.upper) * width - separation.low)).max()
        nominal = (ratio * clearance * width).max()
        yield Play(BACKLASH_NAME, motion_table_unit(problem.setup, 0), *map(float, (nominal, least, most)))
    if (interference := numbers.get(INTERFERENCE_KEY)) is None:
        return
    zone = zones.get(INTERFERENCE_KEY, ZERO_ZONE)
    ends = interference + zone.lower + low, interference + zone.upper + high
    yield Play(INTERFERENCE_NAME, angle, interference, *ends)
    stiffness, zone = numbers.get(STIFFNESS_KEY), zones.get(STIFFNESS_KEY, ZERO_ZONE)
    if stiffness is not None:
        products = [(stiffness + by) * max(end, 0.0) / unit for by in (zone.lower, zone.upper) for end in ends]
        preload = stiffness * interference / unit
        yield Play("preload", "N·m" if problem.setup.angular else "N", preload, min(products), max(products))
        most = (stiffness + zone.upper) * np.maximum(ends[1] - high + unit * separation.high, 0.0) / unit
        slope = largest_separation_slope_at_angles(turn.scene, problem, turn.nodes)
        torque = float((most * slope).max()) * (1.0 if problem.setup.angular else 1e-3)
        yield Play(TORQUE_NAME, "N·m", 0.0, -torque, torque)


LEAST_INTERFERENCE = 1e-12
"""The interference that replaces a clearance, which has no preload."""
SEPARATED_CAMS_AT_ONCE = 2**8
"""Cams in a block whose separations at all cam angles stay in the cache of a processor."""


def separating_errors(cams: CamErrors) -> CamErrors:
    """The errors of cams that may force two contacts apart."""
    return {
        key: each
        for key, each in cams.items()
        if key in BASE_RADII or does_error_move_tool(key.removesuffix(SECOND_CONTACT_SUFFIX))
    }


@dataclass(frozen=True)
class Interference:
    """Interference of two contacts over all cams within the tolerances, in the unit of its key."""

    nominal: float
    mounting_zone: ToleranceZone
    """Tolerance zone of the mounting alone."""
    responses: tuple[SeparationResponse, ...]
    unit_factor: float

    @classmethod
    def from_scene(
        cls, scene: Scene, problem: Problem, nominal: float, mounting_zone: ToleranceZone | None
    ) -> "Interference":
        responses = (*separation_responses_by_tolerance(scene, problem, TurnErrors(scene, problem).nodes),)
        return cls(nominal, mounting_zone or ZERO_ZONE, responses, degrees(1.0) if problem.setup.angular else 1.0)

    @property
    def zone(self) -> ToleranceZone:
        """Zone of the interference of any cam about the nominal one."""
        low, high = (float(end[0]) - self.nominal for end in self.interference_range({}))
        return ToleranceZone(low, high, 0.0)

    def interference_range(self, errors: Mapping[str, FloatArray]) -> SeparationRange:
        """Least and largest interference of cams whose sizes have these errors, by key."""
        low = high = np.zeros((1, 1))  # a single cam if no errors are given
        for each in self.responses:  # with errors shape (cams, angles)
            exact = np.multiply.outer(errors[each.key], each.rows.sum(axis=0)) if each.key in errors else None
            ends = each.range_over_turn if exact is None else (exact, exact)
            low, high = low + ends[0], high + ends[1]
        ends = (
            self.nominal + self.mounting_zone.lower + self.unit_factor * low.min(axis=-1),
            self.nominal + self.mounting_zone.upper + self.unit_factor * high.max(axis=-1),
        )
        return SeparationRange(*np.maximum(ends, min(LEAST_INTERFERENCE, self.nominal)))

    def sampled_interference_range(
        self, problem: Problem, cams: CamErrors, waves: int, angles: FloatArray
    ) -> SeparationRange | None:
        """Least and largest interference over the turn of each cam; None if no error separates the contacts."""
        separating = separating_errors(cams)
        mounted = self.nominal + cams.get(INTERFERENCE_KEY, 0.0)
        if not separating:
            return None
        response = PairResponse(problem, angles)
        rows = np.array([row for key in separating for row in response.separation_rows(key, waves)])

        def separation_ends(block: CamErrors) -> list[FloatArray]:
            separation = real_error_columns(block) @ rows
            return [separation.min(axis=1), separation.max(axis=1)]

        ends = np.hstack([*map_cam_blocks(separating, separation_ends, SEPARATED_CAMS_AT_ONCE)])
        low, high = np.maximum(mounted + self.unit_factor * ends, min(LEAST_INTERFERENCE, self.nominal))
        return SeparationRange(low, high)

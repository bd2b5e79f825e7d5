"""Allocation: the loosest grades of tolerances that keep the tool within a distance of where it should be.

Each tolerance of a length has a grade, and a grade has a cost (``tolerances.allocation``). Sets of grades are tried
from the cheapest on. One that a cam within it refutes, whose error by exact contact is larger, is passed over; the
first of which no cam is, proved (``tolerances.worst_case``), is the cheapest of all. Where a set is neither refuted
nor proved, the cost that none is below is that of the cheapest such set.

Of a follower with two contacts the errors at both have the grade of their tolerance, as those of both profiles do.
Where it is mounted with an interference, sets that may take all of it are passed over too: nothing would hold the
follower in the middle.

Source: K. W. Chase, W. H. Greenwood, B. G. Loosli, L. F. Hauglund, Least cost tolerance allocation for mechanical
assemblies with automated process selection, Manufacturing Review 3, 1990 (search of discrete costs).

Grades of ISO 286 for the tolerances of a scene, and what a grade costs.

A process of some care holds one grade at all sizes: that is what the grades are made for. So what a tolerance costs
is said by its grade. Unless it is given, the model of reciprocal powers has the part of the cost that a tolerance
makes as B/Tᵏ; by grades, with k = 1 and IT7 for the unit, that is the width of IT7 over that of the grade. It is an
example, and no price of any shop.

Source: ISO 286-1:2010, table 1. K. W. Chase, W. H. Greenwood, Design issues in mechanical tolerance analysis,
Manufacturing Review 1, 1988, which has the models of Sutherland and Roth (B/Tᵏ) and of Spotts (B/T²).
"""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, partial
from heapq import heappop, heappush
from itertools import chain, pairwise
from math import degrees, fsum, inf, isfinite
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import clock_seconds
from camopt.model.effects.motion import motion_scale, motion_table_unit
from camopt.scene.arguments import SceneSource, options_by_keyword, scene_from
from camopt.scene.csv_columns import csv_column_names, read_csv_columns
from camopt.scene.iso286 import GRADE_WIDTHS, limit_deviations
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.problem.tolerance_zones import number_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import RADIUS_KEYS, moves_tool
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Result, Table
from camopt.solve.tolerances.errors import error_keys, error_ranges
from camopt.solve.tolerances.response import separation_by_key
from camopt.solve.tolerances.turn_errors import Contribution, TurnErrors, contributions, worst_case_range
from camopt.solve.tolerances.worst_case import DISPLACEMENT_GAP, WorstCase, WorstSearch, worst_search

EXAMPLE_COSTS = dict(zip(range(5, 13), (16 / 7, 1.6, 1.0, 0.64, 0.4, 0.25, 0.16, 0.1), strict=True))
"""Relative cost by grade: 16/7, 16/10, 16/16, 16/25, … of the standard's multiples of i."""
NUMBER_ZONE_LETTER = "js"
"""The letter of a tolerance that is a number."""
CostByGrade = Mapping[int, float]
"""By grade, from one to the next; less for the coarser one."""
CostsByKey = Mapping[str, CostByGrade]
"""By key of ``[tolerances]``."""
ALLOCATION_SECONDS = 60.0
"""For all proofs, unless told."""
GRADES_PROOF_SECONDS = 20.0
GradeByKey = Mapping[str, int]
"""By key of ``[tolerances]``."""


class Allotted(NamedTuple):
    """A tolerance with the grade that it is given.

    Examples
    --------
    >>> scene = camopt.find_scene("valve-rod-offset").replace(tolerances={"follower": {"offset": "js7"}})
    >>> camopt.allocate(scene, 0.02).tolerances[0].grade
    8
    """

    key: str
    """Of ``[tolerances]``."""
    grade: int
    named: str
    """As h7, or IT7 of the profile, of the diameter of the base circle."""
    lower: float
    """Of its zone, mm."""
    upper: float
    cost: float
    share: float
    """What it contributes to the worst case of first order, mm (deg)."""


@dataclass(frozen=True)
class Allocation(Result):
    """The loosest grades of tolerances that keep the tool within a distance of where it should be.

    Attributes
    ----------
    scene : Scene
        With these tolerances.
    within : float
        The distance, mm (deg).
    unit : str
        mm or deg.
    tolerances : tuple of Allotted
        Those of lengths, and of the profile.
    others : float
        What all other tolerances contribute to the worst case of first order, mm (deg).
    cost : float
        The sum of the costs.
    least_cost : float
        No grades that keep the distance cost less, proved.
    worst_case : WorstCase
        Of all cams within these tolerances.
    tried : int
        How many sets of grades were looked at.

    Examples
    --------
    >>> scene = camopt.find_scene("valve-rod-offset")
    >>> scene = scene.replace(tolerances={"follower": {"offset": "js7", "roller_radius": "h6"}})
    >>> found = camopt.allocate(scene, 0.05)
    >>> [each.named for each in found.tolerances], found.worst_case.bound < 0.05
    (['js8', 'h8'], True)
    """

    scene: Scene
    within: float
    unit: str
    tolerances: tuple[Allotted, ...]
    others: float
    cost: float
    least_cost: float
    worst_case: WorstCase
    tried: int
    main_rows: ClassVar[str] = "tolerances"

    def table(self) -> Table:
        """The tolerances with their grades, zones, costs and shares."""
        heads = ["tolerance", "grade", "from", "to", "cost", "share"]
        rows = [
            [
                each.key,
                each.named,
                *(with_unit(end, "mm") for end in (each.lower, each.upper)),
                number_text(each.cost),
                with_unit(each.share, self.unit),
            ]
            for each in self.tolerances
        ]
        bound = with_unit(self.worst_case.bound, self.unit)
        if self.others:
            rows.append(["others", "", "", "", "", with_unit(self.others, self.unit)])
        rows.append(["all", "", "", "", number_text(self.cost), bound])
        kinds = [Cell(head, NUMERIC if head in heads[2:] else "") for head in heads]
        less = (
            "nothing costs less"
            if self.least_cost >= self.cost
            else f"not less than {number_text(self.least_cost)}"
        )
        note = "Proved: no cam is off by more than the last share, "
        note += f"and of grades that keep {self._distance_text} {less}."
        return Table.from_texts(
            f"{self.scene.name}: the loosest grades within {self._distance_text}", kinds, rows, note
        )

    @property
    def _distance_text(self) -> str:
        return f"±{with_unit(self.within, self.unit)}"

    def document(self) -> dict[str, Any]:
        """Costs, the worst case, and a record for each tolerance."""
        return {
            "within": self.within,
            "tolerances": self.tolerances,
            "others": self.others,
            "cost": self.cost,
            "least_cost": self.least_cost,
            "worst_case": self.worst_case,
        }

    def records(self) -> list[dict[str, Any]]:
        """A mapping for each tolerance."""
        return [each._asdict() for each in self.tolerances]


@options_by_keyword
def allocate(
    scene: SceneSource,
    within: float,
    *,
    costs: Any = None,
    seconds: float = ALLOCATION_SECONDS,
    only: Sequence[str] = (),
) -> Allocation:
    """Find the cheapest grades of tolerances of which no cam moves the tool further off than a distance.

    Sizes of the follower that have a tolerance get another grade of ISO 286, with their letter (js in place of a
    number), and so does the profile: ± half of the grade's width at the diameter of the base circle. Two contacts
    with an interference keep a preload. Other
    tolerances, as of phase and bore, stay as they are, and so do all but those that ``only`` names.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with sizes of its own, and ``[tolerances]`` of what may be graded.
    within : float
        How far the tool may be off at any cam angle, mm (deg).
    costs : mapping or path, optional
        What each grade costs, for all keys or by key: of the grades that are offered. Or a CSV file with a column
        ``grade``, and ``cost`` or one for each key. Unless given, the relative costs of reciprocal widths, IT5 to
        IT12.
    seconds : float, default 60
        For the search.
    only : str or sequence of str, optional
        The keys of the tolerances that get other grades; all that have one unless given.

    Returns
    -------
    Allocation
        The grades, what they cost, the cost that none is below, and the worst of the cams.

    Raises
    ------
    BadInput
        If nothing of the scene has a grade; for costs that are none, or if no grades keep the distance.

    References
    ----------
    K. W. Chase, W. H. Greenwood, Design issues in mechanical tolerance analysis, Manufacturing Review 1, 1988.

    Examples
    --------
    >>> scene = camopt.find_scene("valve-rod-offset").replace(tolerances={"profile": 0.01, "phase": 0.02})
    >>> camopt.allocate(scene, 0.04).tolerances[0].named
    'IT6'
    """
    scene = scene_from(scene)
    if not (isinstance(within, int | float) and within > 0.0):
        raise BadInput([Mistake("camopt", "within", within, "a distance above 0, mm (deg)")])
    scene = scene.toleranced
    problem = resolve_design(scene)
    keys = graded_keys(scene, problem)
    only = (only,) if isinstance(only, str) else only
    if unknown := [each for each in only if each not in keys]:
        why = f"is no tolerance with a grade; {suggest_names(unknown[0], keys)}" if keys else "has no grade"
        raise BadInput([Mistake("camopt", "only", unknown[0], why, bare=True)])
    keys = tuple(key for key in keys if key in only) or keys
    if not keys:
        why = "names nothing that has a grade: give one, such as follower.offset = 'js7' or profile = 0.02"
        raise BadInput([Mistake(problem.file, "tolerances", None, why, bare=True)])
    if problem.programme.corners:
        why = "has a motion whose velocity jumps: no bound of its errors is proved"
        raise BadInput([Mistake(problem.file, "motion", None, why, bare=True)])
    return _GradeSearch(scene, problem, float(within), grade_costs(costs, keys), clock_seconds() + seconds).run()


@dataclass(frozen=True)
class _GradeSearch:
    """The search for grades."""

    scene: Scene
    problem: Problem
    within: float
    costs: CostsByKey
    deadline: float

    def run(self) -> Allocation:
        """The cheapest grades that are proved."""
        finest = {key: min(each) for key, each in self.zones.items()}
        if self.has_nested_zones and (self.is_refuted(finest) or self.largest_clearance(finest) > 0.0):
            raise self.no_grades_error(finest)
        least, tried = inf, 0
        for cost, grades in self.grades_by_cost():
            tried += 1
            if self.is_refuted(grades) or self.largest_clearance(grades) > 0.0:
                continue
            within = self.within / self.unit_factor
            found = self.worst_cam_search(grades).prove_bound(
                within / (1.0 + DISPLACEMENT_GAP), DISPLACEMENT_GAP, clock_seconds() + GRADES_PROOF_SECONDS, within
            )
            if found.high <= within:
                return self.make_allocation(grades, min(least, cost), tried)
            if found.witness_value <= within:
                least = min(least, cost)
            if clock_seconds() > self.deadline:
                break
        raise self.no_grades_error(finest)

    def no_grades_error(self, finest: GradeByKey) -> BadInput:
        """Why there are no grades."""
        unit, worst = motion_table_unit(self.problem.setup, 0), self.worst_cam_search(finest).run()
        asked, found = with_unit(self.within, unit), with_unit(abs(worst.error), unit)
        why = f"no grades that are offered keep ±{asked}: with the finest of all a cam is {found} off"
        if (loose := self.largest_clearance(finest)) > 0.0:
            why = "no grades that are offered keep the preload: with the finest of all a cam has a clearance of"
            why = f"{why} {with_unit(loose, 'deg' if self.problem.setup.angular else 'mm')}"
            why += f"; {', '.join(finest)} get grades in place of the tolerances given"
        elif clock_seconds() > self.deadline:
            why = f"no grades were proved to keep ±{asked} in the time: allow more, or offer fewer grades"
        elif abs(worst.error) <= self.within:
            why = f"no grades are proved to keep ±{asked}, though no cam is found that breaks it"
        return BadInput([Mistake(self.problem.file, "tolerances", None, why, bare=True)])

    def grades_by_cost(self) -> Iterator[tuple[float, GradeByKey]]:
        """All sets of grades with their costs, from the cheapest on."""
        offered = {key: sorted(each, reverse=True) for key, each in self.zones.items()}
        keys = [*offered]

        def cost_of_places(places: tuple[int, ...]) -> tuple[float, tuple[int, ...]]:
            named = zip(keys, places, strict=True)
            return fsum(self.costs[key][offered[key][place]] for key, place in named), places

        heap, last = [cost_of_places((0,) * len(keys))], len(keys)
        while heap:
            cost, places = heappop(heap)
            yield cost, {key: offered[key][place] for key, place in zip(keys, places, strict=True)}
            finer = max((k for k in range(last) if places[k]), default=0)  # from each set but once
            for k in range(finer, last):
                if places[k] + 1 < len(offered[keys[k]]):
                    heappush(heap, cost_of_places((*places[:k], places[k] + 1, *places[k + 1 :])))

    def is_refuted(self, grades: GradeByKey) -> bool:
        """Whether a cam is further off at the angle that is the worst to first order."""
        found = [each for key, grade in grades.items() for each in self.graded_contributions[key][grade]]
        ends = worst_case_range([*self.fixed_contributions, *found], 0)
        if not self.unit_factor * float(ends.magnitude.max()) > self.within:
            return False
        angle = self.turn_errors.nodes[[int(ends.magnitude.argmax())]]
        search = self.worst_cam_search(grades)
        errors = (search.motion_errors(search.extreme_errors(angle, side), angle)[0] for side in (1.0, -1.0))
        return bool(self.unit_factor * max(map(abs, errors)) > self.within)

    def largest_clearance(self, grades: GradeByKey) -> float:
        """What is left between two contacts of some cam in place of an interference, to first order, mm (deg).

        0 where all have a preload, and where none is meant to have one.
        """
        if not self.least_interference:
            return 0.0
        low = self.fixed_separation + sum(self.graded_separations[key][grade] for key, grade in grades.items())
        unit = degrees(1.0) if self.problem.setup.angular else 1.0
        return max(-(self.least_interference + unit * float(low.min())), 0.0)

    def worst_cam_search(self, grades: GradeByKey) -> WorstSearch:
        """The search for the worst of the cams within grades."""
        zones = {each: self.zones[key][g] for key, g in grades.items() for each in error_keys(self.problem, key)}
        return worst_search(self.turn_errors, changed=zones)

    def make_allocation(self, grades: GradeByKey, least: float, tried: int) -> Allocation:
        """What is told of grades that keep the distance."""
        found = {key: self.graded_contributions[key][grade] for key, grade in grades.items()}
        ends = worst_case_range([*self.fixed_contributions, *chain(*found.values())], 0)
        place, upwards = int(ends.magnitude.argmax()), ends.upper.max() >= -ends.lower.min()

        def share(some: list[Contribution]) -> float:
            return self.unit_factor * fsum(
                float((each.upper if upwards else -each.lower)[0, place]) for each in some
            )

        allotted = [
            Allotted(
                key,
                grade,
                grade_name(self.scene, key, grade),
                *self.zones[key][grade],
                self.costs[key][grade],
                share(found[key]),
            )
            for key, grade in grades.items()
        ]
        unit, scene = motion_table_unit(self.problem.setup, 0), with_grades(self.scene, self.problem, grades)
        cost, worst = fsum(each.cost for each in allotted), self.worst_cam_search(grades).run()
        others = share(self.fixed_contributions)
        return Allocation(scene, self.within, unit, tuple(allotted), others, cost, least, worst, tried)

    @cached_property
    def unit_factor(self) -> float:
        return float(motion_scale(self.problem.setup, 0))

    @cached_property
    def turn_errors(self) -> TurnErrors:
        return TurnErrors(self.scene, self.problem)

    @cached_property
    def graded_scenes(self) -> dict[str, dict[int, Scene]]:
        """The scene with each grade of each tolerance that the standard has, by key."""
        found = dict[str, dict[int, Scene]]()
        for key, costs in self.costs.items():
            found[key] = {}
            for grade in costs:
                with suppress(ValueError):
                    found[key][grade] = with_grades(self.scene, self.problem, {key: grade})
            if not found[key]:
                why = "the standard has none of the grades at this size"
                raise BadInput([Mistake(self.problem.file, f"tolerances.{key}", None, why, bare=True)])
        return found

    @cached_property
    def zones(self) -> dict[str, dict[int, tuple[float, float]]]:
        """The zone of each tolerance by key and grade, mm."""
        return {
            key: {grade: error_ranges(scene, self.problem)[key] for grade, scene in scenes.items()}
            for key, scenes in self.graded_scenes.items()
        }

    @cached_property
    def has_nested_zones(self) -> bool:
        """Whether the zones of coarser grades hold those of finer ones."""
        ordered = [[each[grade] for grade in sorted(each)] for each in self.zones.values()]
        return all(wide[0] <= low and high <= wide[1] for each in ordered for (low, high), wide in pairwise(each))

    @cached_property
    def graded_contributions(self) -> dict[str, dict[int, list[Contribution]]]:
        """What each tolerance contributes by key and grade."""
        return {
            key: {grade: self._contributions_of_key(scene, key) for grade, scene in scenes.items()}
            for key, scenes in self.graded_scenes.items()
        }

    @cached_property
    def least_interference(self) -> float:
        """The least between two contacts as they are mounted, mm (deg); 0 if there is none."""
        key = "drive.interference"
        if not (self.problem.setup.mechanism.further_contacts and self.problem.nominal_numbers.get(key)):
            return 0.0
        zone = number_zones(self.scene, self.problem.nominal_numbers).get(key)
        return self.problem.nominal_numbers[key] + (zone.lower if zone else 0.0)

    @cached_property
    def graded_separations(self) -> dict[str, dict[int, FloatArray]]:
        """By how much each tolerance takes them apart at least, by key and grade."""
        return {
            key: {grade: self._least_separations(scene)[key] for grade, scene in scenes.items()}
            for key, scenes in self.graded_scenes.items()
        }

    @cached_property
    def fixed_separation(self) -> FloatArray:
        """By how much all others do."""
        others = [low for key, low in self._least_separations(self.scene).items() if key not in self.costs]
        return sum(others, np.zeros(self.turn_errors.nodes.size))

    def _least_separations(self, scene: Scene) -> dict[str, FloatArray]:
        return {key: found.low for key, found in separation_by_key(scene, self.problem, self.turn_errors.nodes)}

    @cached_property
    def fixed_contributions(self) -> list[Contribution]:
        """What tolerances without another grade contribute."""
        graded = [each for key in self.costs for each in error_keys(self.problem, key)]
        return [
            each
            for each in contributions(self.scene, self.problem, self.turn_errors.nodes)
            if each.key not in graded
        ]

    def _contributions_of_key(self, scene: Scene, key: str) -> list[Contribution]:
        """Those of a tolerance of a scene."""
        own = error_keys(self.problem, key)
        return [each for each in contributions(scene, self.problem, self.turn_errors.nodes) if each.key in own]


def graded_keys(scene: Scene, problem: Problem) -> tuple[str, ...]:
    """The keys of tolerances that may have a grade: those of lengths, and the profile."""
    moving = {each.key for each in problem.variables if each.unit == "mm" and moves_tool(each.key)}
    lengths = (key for key in scene.tolerances.numbers if key in moving)
    return (*lengths, *(("profile",) if scene.tolerances.profile else ()))


def with_grades(scene: Scene, problem: Problem, grades: Mapping[str, int]) -> Scene:
    """The scene with tolerances of some grades by key; a letter that is given stays.

    ValueError for a grade that the standard does not have at that size.
    """
    changes = dict[str, Any]()
    for key, grade in grades.items():
        if key == "profile":
            changes["tolerances.profile"] = limit_deviations(
                f"{NUMBER_ZONE_LETTER}{grade}", body_diameter(problem)
            ).upper
            continue
        given = scene.tolerances.numbers[key]
        kept = given.model_dump(mode="json", exclude={"plus", "minus", "iso"}, exclude_defaults=True)
        changes[f"tolerances.{key}"] = {"iso": f"{zone_letter(given.iso)}{grade}", **kept}
        size = abs(problem.nominal_numbers[key])
        limit_deviations(
            changes[f"tolerances.{key}"]["iso"], 2.0 * size if key.rpartition(".")[2] in RADIUS_KEYS else size
        )
    return scene.replace(**changes)


def zone_letter(iso: str | None) -> str:
    """The letter of a class; that of a centred zone of a number."""
    return NUMBER_ZONE_LETTER if iso is None else re.sub(r"\d", "", iso)


def body_diameter(problem: Problem) -> float:
    """The diameter of the base circle, or of a cylinder at its mean radius, mm: that of the profile's grade."""
    return 2.0 * float(problem.design.size[0])


def grade_name(scene: Scene, key: str, grade: int) -> str:
    """How the grade of a key is written: h7, or IT7 of the profile."""
    if key == "profile":
        return f"IT{grade}"
    return f"{zone_letter(scene.tolerances.numbers[key].iso)}{grade}"


def grade_costs(given: Any, keys: tuple[str, ...]) -> CostsByKey:
    """What grades cost, by key: as they are given, from a file, or those of the example.

    Raises
    ------
    BadInput
        For costs that are none, or a finer grade that costs less.
    """
    if given is None:
        return dict.fromkeys(keys, EXAMPLE_COSTS)
    if isinstance(given, str | os.PathLike):
        return _check_grade_costs(_read_grade_costs(Path(given), keys), str(given))
    if not isinstance(given, Mapping) or not given:
        raise BadInput([Mistake("camopt", "costs", given, "a mapping of grades to costs, for all keys or by key")])
    if not any(isinstance(each, Mapping) for each in given.values()):
        return _check_grade_costs(dict.fromkeys(keys, given), "costs")
    if missing := [key for key in keys if not isinstance(given.get(key), Mapping)]:
        raise BadInput([Mistake("camopt", f"costs.{missing[0]}", given.get(missing[0]), "a cost for each grade")])
    return _check_grade_costs({key: given[key] for key in keys}, "costs")


def _read_grade_costs(file: Path, keys: tuple[str, ...]) -> CostsByKey:
    """Costs from a table with a column of grades, and one of costs, or one for each key."""
    try:
        names = csv_column_names(file.parent, file.name)
        read = partial(read_csv_columns, file.parent, file.name, prefixes={"grade": "IT"})
        found = {key: read(("grade", key if key in names else "cost")) for key in keys}
    except ValueError as trouble:
        raise BadInput([Mistake(str(file), "costs", None, str(trouble), bare=True)]) from None
    return {key: dict(zip(*columns.values(), strict=True)) for key, columns in found.items()}


def _check_grade_costs(prices: CostsByKey, file: str) -> CostsByKey:
    """Costs with whole grades, the finest first."""
    found = dict[str, CostByGrade]()
    for key, costs in prices.items():
        for grade, cost in costs.items():
            if grade not in GRADE_WIDTHS:
                raise BadInput(
                    [Mistake(file, "grade", grade, f"a grade, {min(GRADE_WIDTHS)} to {max(GRADE_WIDTHS)}")]
                )
            if not (isinstance(cost, int | float) and isfinite(cost) and cost >= 0.0):
                raise BadInput([Mistake(file, f"cost of grade {grade:g}", cost, "a number, at least 0")])
        found[key] = {int(grade): float(costs[grade]) for grade in sorted(costs)}
        for (finer, more), (coarser, less) in pairwise(found[key].items()):
            if more < less:
                why = f"must be at least that of the coarser grade {coarser}, {less:g}"
                raise BadInput([Mistake(file, f"cost of grade {finer}", more, why, bare=True)])
    return found

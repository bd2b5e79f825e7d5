"""Allocation: the cheapest tolerance grades that keep the error of the tool within a limit.

**Search.** Each tolerance of a length has a grade of ISO 286, and each grade has a cost. Sets of grades are tried
in the order of their cost. A set is rejected if the error of a cam within it, by exact contact, exceeds the limit.
The first set with a proven bound within the limit (``tolerances.worst_case``) is the answer. If a cheaper set was
neither rejected nor proved, the lower bound of the cost is that of the cheapest such set.

With two contacts, the errors at both have the grade of their tolerance, and so have both profiles. If the contacts
are mounted with an interference, sets that may use it up are rejected too: nothing would hold the follower in the
middle.

**Costs.** A process of a given care holds one grade at all sizes: this is the purpose of grades. So the cost of a
tolerance depends only on its grade. By default the cost follows the reciprocal power model B/Tᵏ with k = 1 and IT7
as the unit: the width of IT7 over that of the grade. These costs are an example, not prices of a workshop.

Sources: K. W. Chase, W. H. Greenwood, B. G. Loosli, L. F. Hauglund, Least cost tolerance allocation for mechanical
assemblies with automated process selection, Manufacturing Review 3, 1990 (search of discrete costs). ISO
286-1:2010, table 1. K. W. Chase, W. H. Greenwood, Design issues in mechanical tolerance analysis, Manufacturing
Review 1, 1988, with the models of Sutherland and Roth (B/Tᵏ) and of Spotts (B/T²).
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
from camopt.core.numerics.budget import Budget, search_budget
from camopt.model.effects.motion import motion_table_unit, motion_unit_factor
from camopt.model.effects.preload import INTERFERENCE_KEY
from camopt.scene.arguments import SceneSource, allow_positional_options, scene_from
from camopt.scene.csv_columns import csv_column_names, read_csv_columns
from camopt.scene.iso286 import GRADE_WIDTHS, limit_deviations
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.problem.tolerance_zones import tolerance_zones_of_numbers
from camopt.scene.scene import Scene
from camopt.scene.tolerances import RADIUS_KEYS, does_error_move_tool
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Result, Table
from camopt.solve.tolerances.errors import error_keys_at_contacts, error_ranges_at_one_contact
from camopt.solve.tolerances.response import separation_responses_by_tolerance
from camopt.solve.tolerances.turn_errors import Contribution, TurnErrors, tolerance_contributions, worst_case_range
from camopt.solve.tolerances.worst_case import DISPLACEMENT_GAP, WorstCase, WorstSearch, make_worst_cam_search

EXAMPLE_COSTS = dict(zip(range(5, 13), (16 / 7, 1.6, 1.0, 0.64, 0.4, 0.25, 0.16, 0.1), strict=True))
"""Relative cost by grade: 16/7, 16/10, 16/16, 16/25, … of the standard's multiples of i."""
NUMBER_ZONE_LETTER = "js"
"""ISO 286 letter for a tolerance that is a number in the scene."""
CostsByKey = Mapping[str, Mapping[int, float]]
"""Cost of each grade by key of ``[tolerances]``; a coarser grade costs no more."""
ALLOCATION_WORK = 60e6
"""Default work of the search."""
GRADES_PROOF_WORK, GRADES_WORK = 20e6, 2e3  # most work of the proof for a set of grades; work to reject a set
GradeByKey = Mapping[str, int]
"""Grade by key of ``[tolerances]``."""


class Allotted(NamedTuple):
    """A tolerance with its allocated grade.

    Examples
    --------
    >>> scene = camopt.find_scene("valve-rod-offset").replace(tolerances={"follower": {"offset": "js7"}})
    >>> camopt.allocate(scene, 0.02).tolerances[0].grade
    8
    """

    key: str
    """Key of ``[tolerances]``."""
    grade: int
    named: str
    """The grade as written, such as h7; IT7 for the profile, at the diameter of the base circle."""
    lower: float
    """Lower end of the zone [mm]."""
    upper: float
    """Upper end of the zone [mm]."""
    cost: float
    share: float
    """Contribution to the first-order worst case, mm (deg)."""


@dataclass(frozen=True)
class Allocation(Result):
    """The cheapest tolerance grades that keep the error of the tool within a limit.

    Attributes
    ----------
    scene : Scene
        The scene with these tolerances.
    within : float
        The limit of the error, mm (deg).
    unit : str
        mm or deg.
    tolerances : tuple of Allotted
        The allocated tolerances: of lengths, and of the profile.
    others : float
        Contribution of all other tolerances to the first-order worst case, mm (deg).
    cost : float
        The sum of the costs.
    least_cost : float
        Proven lower bound of the cost of grades that keep the limit.
    worst_case : WorstCase
        The worst case of all cams within these tolerances.
    tried : int
        Number of sets of grades that were tried.

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
        """Tolerances with their grades, zones, costs and shares."""
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
        cheaper = (
            "no cheaper grades keep"
            if self.least_cost >= self.cost
            else f"no grades below a cost of {number_text(self.least_cost)} keep"
        )
        limit = f"±{with_unit(self.within, self.unit)}"
        note = f"Proved: no cam has a larger error than the last share, and {cheaper} {limit}."
        return Table.from_texts(f"{self.scene.name}: the cheapest grades within {limit}", kinds, rows, note)

    def values_for_json(self) -> dict[str, Any]:
        """The allocation for ``--json``: costs, the worst case, and one record for each tolerance."""
        return {
            "within": self.within,
            "tolerances": self.tolerances,
            "others": self.others,
            "cost": self.cost,
            "least_cost": self.least_cost,
            "worst_case": self.worst_case,
        }

    def records(self) -> list[dict[str, Any]]:
        """One mapping for each tolerance."""
        return [each._asdict() for each in self.tolerances]


@allow_positional_options
def allocate(
    scene: SceneSource,
    within: float,
    *,
    costs: Any = None,
    seconds: float | None = None,
    only: Sequence[str] = (),
) -> Allocation:
    """Find the cheapest tolerance grades with which no cam exceeds an error of the tool.

    Toleranced sizes of the follower get new grades of ISO 286 and keep their letter (js for a number). The profile
    gets ± half of the grade's width at the diameter of the base circle. Two contacts with an interference keep a
    preload. Other tolerances, such as those of phase and bore, do not change; with ``only``, all tolerances but the
    named ones.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with all sizes, and ``[tolerances]`` for the sizes to grade.
    within : float
        Permitted error of the tool at any cam angle, mm (deg).
    costs : mapping or path, optional
        Cost of each permitted grade, for all keys or by key. Or a CSV file with a column ``grade``, and a column
        ``cost`` or one for each key. By default the relative costs of reciprocal widths, IT5 to IT12.
    seconds : float, optional
        Time for the search [s]. By default the search stops after a fixed amount of work, about a minute, and
        gives the same answer on every machine.
    only : str or sequence of str, optional
        Keys of the tolerances that get new grades; by default all that have a grade.

    Returns
    -------
    Allocation
        The grades, their cost, the proven lower bound of the cost, and the worst cam.

    Raises
    ------
    BadInput
        If no tolerance of the scene has a grade, the costs are invalid, or no grades keep the limit.

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
    scene = scene.with_profile_tolerance_moved
    problem = resolve_design(scene)
    moving = {each.key for each in problem.variables if each.unit == "mm" and does_error_move_tool(each.key)}
    keys = tuple(key for key in scene.tolerances.numbers if key in moving)
    keys += ("profile",) if scene.tolerances.profile else ()
    only = (only,) if isinstance(only, str) else only
    if unknown := [each for each in only if each not in keys]:
        why = f"is not a tolerance with a grade; {suggest_names(unknown[0], keys)}" if keys else "has no grade"
        raise BadInput([Mistake("camopt", "only", unknown[0], why, bare=True)])
    keys = tuple(key for key in keys if key in only) or keys
    if not keys:
        why = "has no tolerance with a grade: add one, such as follower.offset = 'js7' or profile = 0.02"
        raise BadInput([Mistake(problem.file, "tolerances", None, why, bare=True)])
    if problem.programme.corners:
        why = "has a motion whose velocity jumps: no bound of its errors is proved"
        raise BadInput([Mistake(problem.file, "motion", None, why, bare=True)])
    return _GradeSearch(
        scene, problem, float(within), grade_costs_by_key(costs, keys), search_budget(seconds, ALLOCATION_WORK)
    ).find_cheapest_grades()


@dataclass(frozen=True)
class _GradeSearch:
    """Search for the cheapest grades."""

    scene: Scene
    problem: Problem
    within: float
    costs: CostsByKey
    budget: Budget

    def find_cheapest_grades(self) -> Allocation:
        """The cheapest grades with a proven bound within the limit."""
        finest = {key: min(each) for key, each in self.zones_by_key_and_grade.items()}
        ordered = [[each[grade] for grade in sorted(each)] for each in self.zones_by_key_and_grade.values()]
        are_nested = all(a[0] <= b[0] and b[1] <= a[1] for each in ordered for b, a in pairwise(each))
        if are_nested and (  # zones of coarser grades contain those of finer ones
            self.has_cam_beyond_limit(finest) or self.largest_first_order_clearance(finest) > 0.0
        ):
            raise self.no_grades_error(finest)
        least, tried = inf, 0
        for cost, grades in self.grades_by_cost():
            if tried and self.budget.is_spent:
                break
            tried += 1
            self.budget.spend(GRADES_WORK)
            if self.has_cam_beyond_limit(grades) or self.largest_first_order_clearance(grades) > 0.0:
                continue
            within = self.within / self.displacement_unit_factor
            proof = Budget(GRADES_PROOF_WORK)
            bound = self.worst_cam_search(grades).prove_error_bound(
                within / (1.0 + DISPLACEMENT_GAP), DISPLACEMENT_GAP, proof, within
            )
            self.budget.spend(proof.meter.work)
            if bound.high <= within:
                return self.make_allocation(grades, min(least, cost), tried)
            if bound.witness_value <= within:
                least = min(least, cost)
        raise self.no_grades_error(finest)

    def no_grades_error(self, finest: GradeByKey) -> BadInput:
        unit, worst = motion_table_unit(self.problem.setup, 0), self.worst_cam_search(finest).find_worst_cam()
        limit, error = with_unit(self.within, unit), with_unit(abs(worst.error), unit)
        why = f"no permitted grades keep ±{limit}: even with the finest ones a cam has an error of {error}"
        if (clearance := self.largest_first_order_clearance(finest)) > 0.0:
            why = "no permitted grades keep the preload: even with the finest ones a cam has a clearance of"
            why = f"{why} {with_unit(clearance, 'deg' if self.problem.setup.angular else 'mm')}"
            why += f"; {', '.join(finest)} get grades instead of their own tolerances"
        elif self.budget.is_spent:
            why = f"no grades were proved to keep ±{limit} before the search stopped: permit fewer grades"
        elif abs(worst.error) <= self.within:
            why = f"no permitted grades were proved to keep ±{limit}; no cam of the finest ones was found beyond it"
        return BadInput([Mistake(self.problem.file, "tolerances", None, why, bare=True)])

    def grades_by_cost(self) -> Iterator[tuple[float, GradeByKey]]:
        """All sets of grades with their costs, the cheapest first."""
        permitted = {key: sorted(each, reverse=True) for key, each in self.zones_by_key_and_grade.items()}
        keys = [*permitted]

        def cost_and_places(places: tuple[int, ...]) -> tuple[float, tuple[int, ...]]:
            pairs = zip(keys, places, strict=True)
            return fsum(self.costs[key][permitted[key][place]] for key, place in pairs), places

        heap, last = [cost_and_places((0,) * len(keys))], len(keys)
        while heap:
            cost, places = heappop(heap)
            yield cost, {key: permitted[key][place] for key, place in zip(keys, places, strict=True)}
            first = max((k for k in range(last) if places[k]), default=0)  # so that each set is reached once
            for k in range(first, last):
                if places[k] + 1 < len(permitted[keys[k]]):
                    heappush(heap, cost_and_places((*places[:k], places[k] + 1, *places[k + 1 :])))

    def has_cam_beyond_limit(self, grades: GradeByKey) -> bool:
        """Whether a cam exceeds the limit at the cam angle that is worst to first order."""
        graded = [each for key, grade in grades.items() for each in self.contributions_by_key_and_grade[key][grade]]
        ends = worst_case_range([*self.ungraded_contributions, *graded], 0)
        if not self.displacement_unit_factor * float(ends.magnitude.max()) > self.within:
            return False
        angle = self.turn_errors.nodes[[int(ends.magnitude.argmax())]]
        search = self.worst_cam_search(grades)
        errors = (
            search.motion_errors(search.part_errors_moving_tool_furthest(angle, side), angle)[0]
            for side in (1.0, -1.0)
        )
        return bool(self.displacement_unit_factor * max(map(abs, errors)) > self.within)

    def largest_first_order_clearance(self, grades: GradeByKey) -> float:
        """Largest clearance between two contacts that should have an interference, to first order [mm or deg].

        0 if every cam has a preload, or none should have one.
        """
        if not self.interference_at_lower_deviation:
            return 0.0
        low = self.least_ungraded_separation + sum(
            self.least_contact_separations_by_key_and_grade[key][grade] for key, grade in grades.items()
        )
        unit = degrees(1.0) if self.problem.setup.angular else 1.0
        return max(-(self.interference_at_lower_deviation + unit * float(low.min())), 0.0)

    def worst_cam_search(self, grades: GradeByKey) -> WorstSearch:
        zones = {
            each: self.zones_by_key_and_grade[key][g]
            for key, g in grades.items()
            for each in error_keys_at_contacts(self.problem, key)
        }
        return make_worst_cam_search(self.turn_errors, changed_error_ranges=zones)

    def make_allocation(self, grades: GradeByKey, least_cost: float, tried: int) -> Allocation:
        graded = {key: self.contributions_by_key_and_grade[key][grade] for key, grade in grades.items()}
        ends = worst_case_range([*self.ungraded_contributions, *chain(*graded.values())], 0)
        place, upwards = int(ends.magnitude.argmax()), ends.upper.max() >= -ends.lower.min()

        def contributed_error_at_worst_place(parts: list[Contribution]) -> float:
            return self.displacement_unit_factor * fsum(
                float((each.upper if upwards else -each.lower)[0, place]) for each in parts
            )

        letters = {key: zone_letter(each.iso) for key, each in self.scene.tolerances.numbers.items()}
        allotted = [
            Allotted(
                key,
                grade,
                f"{letters.get(key, 'IT')}{grade}",
                *self.zones_by_key_and_grade[key][grade],
                self.costs[key][grade],
                contributed_error_at_worst_place(graded[key]),
            )
            for key, grade in grades.items()
        ]
        unit, scene = motion_table_unit(self.problem.setup, 0), with_grades(self.scene, self.problem, grades)
        cost, worst = fsum(each.cost for each in allotted), self.worst_cam_search(grades).find_worst_cam()
        others = contributed_error_at_worst_place(self.ungraded_contributions)
        return Allocation(scene, self.within, unit, tuple(allotted), others, cost, least_cost, worst, tried)

    @cached_property
    def displacement_unit_factor(self) -> float:
        return float(motion_unit_factor(self.problem.setup, 0))

    @cached_property
    def turn_errors(self) -> TurnErrors:
        return TurnErrors(self.scene, self.problem)

    @cached_property
    def scenes_by_key_and_grade(self) -> dict[str, dict[int, Scene]]:
        """The scene with each grade of each tolerance, by key and grade; grades that ISO 286 lacks are left out."""
        scenes = dict[str, dict[int, Scene]]()
        for key, costs in self.costs.items():
            scenes[key] = {}
            for grade in costs:
                with suppress(ValueError):
                    scenes[key][grade] = with_grades(self.scene, self.problem, {key: grade})
            if not scenes[key]:
                why = "ISO 286 has none of the permitted grades at this size"
                raise BadInput([Mistake(self.problem.file, f"tolerances.{key}", None, why, bare=True)])
        return scenes

    @cached_property
    def zones_by_key_and_grade(self) -> dict[str, dict[int, tuple[float, float]]]:
        """Zone of each tolerance by key and grade [mm]."""
        return {
            key: {grade: error_ranges_at_one_contact(scene, self.problem)[key] for grade, scene in scenes.items()}
            for key, scenes in self.scenes_by_key_and_grade.items()
        }

    @cached_property
    def contributions_by_key_and_grade(self) -> dict[str, dict[int, list[Contribution]]]:
        """Contributions of each graded tolerance, by key and grade."""
        return {
            key: {grade: self._contributions_of_key(scene, key) for grade, scene in scenes.items()}
            for key, scenes in self.scenes_by_key_and_grade.items()
        }

    @cached_property
    def interference_at_lower_deviation(self) -> float:
        """Least interference of two contacts from the mounting alone [mm or deg]; 0 without an interference."""
        interference = self.problem.nominal_numbers.get(INTERFERENCE_KEY)
        if not (self.problem.setup.mechanism.further_contacts and interference):
            return 0.0
        zone = tolerance_zones_of_numbers(self.scene, self.problem.nominal_numbers).get(INTERFERENCE_KEY)
        return interference + (zone.lower if zone else 0.0)

    @cached_property
    def least_contact_separations_by_key_and_grade(self) -> dict[str, dict[int, FloatArray]]:
        """Least separation that each graded tolerance makes, by key and grade."""
        return {
            key: {grade: self._least_contact_separation_by_key(scene)[key] for grade, scene in scenes.items()}
            for key, scenes in self.scenes_by_key_and_grade.items()
        }

    @cached_property
    def least_ungraded_separation(self) -> FloatArray:
        """Least separation that all other tolerances make."""
        others = [
            low for key, low in self._least_contact_separation_by_key(self.scene).items() if key not in self.costs
        ]
        return sum(others, np.zeros(self.turn_errors.nodes.size))

    def _least_contact_separation_by_key(self, scene: Scene) -> dict[str, FloatArray]:
        responses = separation_responses_by_tolerance(scene, self.problem, self.turn_errors.nodes)
        return {each.key: each.range_over_turn.low for each in responses}

    @cached_property
    def ungraded_contributions(self) -> list[Contribution]:
        """Contributions of tolerances that get no grade."""
        graded = [each for key in self.costs for each in error_keys_at_contacts(self.problem, key)]
        return [each for each in self.turn_errors.node_contributions if each.key not in graded]

    def _contributions_of_key(self, scene: Scene, key: str) -> list[Contribution]:
        keys = error_keys_at_contacts(self.problem, key)
        return [
            each
            for each in tolerance_contributions(scene, self.problem, self.turn_errors.nodes)
            if each.key in keys
        ]


def with_grades(scene: Scene, problem: Problem, grades: Mapping[str, int]) -> Scene:
    """The scene with tolerances of these grades, by key; a tolerance keeps its letter.

    Raises ValueError for a grade that ISO 286 does not have at that size.
    """
    changes = dict[str, Any]()
    for key, grade in grades.items():
        if key == "profile":
            diameter = 2.0 * float(problem.design.size[0])  # of the base circle, or of a cylinder in its middle
            changes["tolerances.profile"] = limit_deviations(f"{NUMBER_ZONE_LETTER}{grade}", diameter).upper
            continue
        tolerance = scene.tolerances.numbers[key]
        others = tolerance.model_dump(mode="json", exclude={"plus", "minus", "iso"}, exclude_defaults=True)
        changes[f"tolerances.{key}"] = {"iso": f"{zone_letter(tolerance.iso)}{grade}", **others}
        size = abs(problem.nominal_numbers[key])
        limit_deviations(
            changes[f"tolerances.{key}"]["iso"], 2.0 * size if key.rpartition(".")[2] in RADIUS_KEYS else size
        )
    return scene.replace(**changes)


def zone_letter(iso: str | None) -> str:
    """The letter of an ISO 286 class; js for a number."""
    return NUMBER_ZONE_LETTER if iso is None else re.sub(r"\d", "", iso)


def grade_costs_by_key(costs: Any, keys: tuple[str, ...]) -> CostsByKey:
    """Costs of grades by key: from a mapping or a file, or the example costs for None.

    Raises
    ------
    BadInput
        If the costs are invalid, or a finer grade costs less than a coarser one.
    """
    if costs is None:
        return dict.fromkeys(keys, EXAMPLE_COSTS)
    if isinstance(costs, str | os.PathLike):
        return _check_grade_costs(_read_grade_costs(Path(costs), keys), str(costs))
    if not isinstance(costs, Mapping) or not costs:
        raise BadInput(
            [Mistake("camopt", "costs", costs, "a mapping of grades to costs, or of keys to such mappings")]
        )
    if not any(isinstance(each, Mapping) for each in costs.values()):
        return _check_grade_costs(dict.fromkeys(keys, costs), "costs")
    if missing := [key for key in keys if not isinstance(costs.get(key), Mapping)]:
        raise BadInput([Mistake("camopt", f"costs.{missing[0]}", costs.get(missing[0]), "a cost for each grade")])
    return _check_grade_costs({key: costs[key] for key in keys}, "costs")


def _read_grade_costs(file: Path, keys: tuple[str, ...]) -> CostsByKey:
    """Costs from a CSV file with a column of grades, and one of costs or one for each key."""
    try:
        names = csv_column_names(file.parent, file.name)
        read = partial(read_csv_columns, file.parent, file.name, allowed_prefixes={"grade": "IT"})
        by_key = {key: read(("grade", key if key in names else "cost")) for key in keys}
    except ValueError as trouble:
        raise BadInput([Mistake(str(file), "costs", None, str(trouble), bare=True)]) from None
    return {key: dict(zip(*columns.values(), strict=True)) for key, columns in by_key.items()}


def _check_grade_costs(costs_by_key: CostsByKey, file: str) -> CostsByKey:
    """The costs with whole grades, the finest first; raises BadInput if they are invalid."""
    checked = dict[str, Mapping[int, float]]()
    for key, costs in costs_by_key.items():
        for grade, cost in costs.items():
            if grade not in GRADE_WIDTHS:
                raise BadInput(
                    [Mistake(file, "grade", grade, f"a grade, {min(GRADE_WIDTHS)} to {max(GRADE_WIDTHS)}")]
                )
            if not (isinstance(cost, int | float) and isfinite(cost) and cost >= 0.0):
                raise BadInput([Mistake(file, f"cost of grade {grade:g}", cost, "a number, at least 0")])
        checked[key] = {int(grade): float(costs[grade]) for grade in sorted(costs)}
        for (finer, more), (coarser, less) in pairwise(checked[key].items()):
            if more < less:
                why = f"must be at least the cost of the coarser grade {coarser}, {less:g}"
                raise BadInput([Mistake(file, f"cost of grade {finer}", more, why, bare=True)])
    return checked

"""Grades of ISO 286 for the tolerances of a scene, and what a grade costs.

A process of some care holds one grade at all sizes: that is what the grades are made for. So what a tolerance costs
is said by its grade. Unless it is given, the model of reciprocal powers has the part of the cost that a tolerance
makes as B/Tᵏ; by grades, with k = 1 and IT7 for the unit, that is the width of IT7 over that of the grade. It is an
example, and no price of any shop.

Source: ISO 286-1:2010, table 1. K. W. Chase, W. H. Greenwood, Design issues in mechanical tolerance analysis,
Manufacturing Review 1, 1988, which has the models of Sutherland and Roth (B/Tᵏ) and of Spotts (B/T²).
"""

import os
import re
from collections.abc import Mapping
from functools import partial
from itertools import pairwise
from math import isfinite
from pathlib import Path
from typing import Any

from camopt.mistakes import BadInput, Mistake
from camopt.problem.problem import Problem
from camopt.scene.csv_columns import column_names, read_columns
from camopt.scene.iso286 import GRADES, deviations
from camopt.scene.scene import Scene
from camopt.scene.tolerances import RADII, moves_tool

EXAMPLE = dict(zip(range(5, 13), (16 / 7, 1.6, 1.0, 0.64, 0.4, 0.25, 0.16, 0.1), strict=True))
"""Relative cost by grade: 16/7, 16/10, 16/16, 16/25, … of the standard's multiples of i."""
CENTRED = "js"
"""The letter of a tolerance that is a number."""
Costs = Mapping[int, float]
"""By grade, from one to the next; less for the coarser one."""
Prices = Mapping[str, Costs]
"""By key of ``[tolerances]``."""


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
            changes["tolerances.profile"] = deviations(f"{CENTRED}{grade}", body_diameter(problem)).upper
            continue
        given = scene.tolerances.numbers[key]
        kept = given.model_dump(mode="json", exclude={"plus", "minus", "iso"}, exclude_defaults=True)
        changes[f"tolerances.{key}"] = {"iso": f"{letter_of(given.iso)}{grade}", **kept}
        size = abs(problem.nominal[key])
        deviations(changes[f"tolerances.{key}"]["iso"], 2.0 * size if key.rpartition(".")[2] in RADII else size)
    return scene.replace(**changes)


def letter_of(iso: str | None) -> str:
    """The letter of a class; that of a centred zone of a number."""
    return CENTRED if iso is None else re.sub(r"\d", "", iso)


def body_diameter(problem: Problem) -> float:
    """The diameter of the base circle, or of a cylinder at its mean radius, mm: that of the profile's grade."""
    return 2.0 * float(problem.design.size[0])


def class_of(scene: Scene, key: str, grade: int) -> str:
    """How the grade of a key is written: h7, or IT7 of the profile."""
    if key == "profile":
        return f"IT{grade}"
    return f"{letter_of(scene.tolerances.numbers[key].iso)}{grade}"


def costs_for(given: Any, keys: tuple[str, ...]) -> Prices:
    """What grades cost, by key: as they are given, from a file, or those of the example.

    Raises
    ------
    BadInput
        For costs that are none, or a finer grade that costs less.
    """
    if given is None:
        return dict.fromkeys(keys, EXAMPLE)
    if isinstance(given, str | os.PathLike):
        return _checked(_read(Path(given), keys), str(given))
    if not isinstance(given, Mapping) or not given:
        raise BadInput([Mistake("camopt", "costs", given, "a mapping of grades to costs, for all keys or by key")])
    if not any(isinstance(each, Mapping) for each in given.values()):
        return _checked(dict.fromkeys(keys, given), "costs")
    if missing := [key for key in keys if not isinstance(given.get(key), Mapping)]:
        raise BadInput([Mistake("camopt", f"costs.{missing[0]}", given.get(missing[0]), "a cost for each grade")])
    return _checked({key: given[key] for key in keys}, "costs")


def _read(file: Path, keys: tuple[str, ...]) -> Prices:
    """Costs from a table with a column of grades, and one of costs, or one for each key."""
    try:
        names = column_names(file.parent, file.name)
        read = partial(read_columns, file.parent, file.name, prefixes={"grade": "IT"})
        found = {key: read(("grade", key if key in names else "cost")) for key in keys}
    except ValueError as trouble:
        raise BadInput([Mistake(str(file), "costs", None, str(trouble), bare=True)]) from None
    return {key: dict(zip(*columns.values(), strict=True)) for key, columns in found.items()}


def _checked(prices: Prices, file: str) -> Prices:
    """Costs with whole grades, the finest first."""
    found = dict[str, Costs]()
    for key, costs in prices.items():
        for grade, cost in costs.items():
            if grade not in GRADES:
                raise BadInput([Mistake(file, "grade", grade, f"a grade, {min(GRADES)} to {max(GRADES)}")])
            if not (isinstance(cost, int | float) and isfinite(cost) and cost >= 0.0):
                raise BadInput([Mistake(file, f"cost of grade {grade:g}", cost, "a number, at least 0")])
        found[key] = {int(grade): float(costs[grade]) for grade in sorted(costs)}
        for (finer, more), (coarser, less) in pairwise(found[key].items()):
            if more < less:
                why = f"must be at least that of the coarser grade {coarser}, {less:g}"
                raise BadInput([Mistake(file, f"cost of grade {finer}", more, why, bare=True)])
    return found

"""Tolerance zones of the numbers of a scene, and the errors at which a robust search checks designs."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import product
from math import radians
from typing import TypeVar

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.model.mechanisms import Designs
from camopt.scene.problem.variables import Variable, is_train_key
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLE_TOLERANCES, ToleranceZone, does_error_move_tool, tolerance_zone

MOST_CORNER_NUMBERS, MOST_CORNER_LINKS = 8, 4
"""Largest numbers of tolerances, in all and on the train, for which all corners of the zones are checked.

Corners double with every number, and each corner of a train needs a motion of its own.
"""
NumberErrors = Mapping[str, float]
"""Errors of numbers, by field of ``Designs``; those of a train by key."""
EntryT = TypeVar("EntryT")


def collect_nominal_numbers(
    variables: Iterable[Variable], design: Designs, other_numbers: Mapping[str, float | None]
) -> Mapping[str, float]:
    """The nominal numbers of a scene, by key: those of its design, and ``other_numbers``."""
    own = {each.key: float(design.values[each.field][0]) for each in variables if each.field in design.values}
    return {key: value for key, value in other_numbers.items() if value is not None} | own


def tolerance_zones_of_numbers(scene: Scene, nominal_by_key: Mapping[str, float]) -> dict[str, ToleranceZone]:
    """The zone of each number with a tolerance, by key and in the unit of the scene."""
    return {
        key: tolerance_zone(tolerance, key.rpartition(".")[2], nominal_by_key[key])
        for key, tolerance in scene.tolerances.numbers.items()
    }


def tolerance_zones_of_numbers_and_angles(
    scene: Scene, nominal_by_key: Mapping[str, float]
) -> dict[str, ToleranceZone]:
    """The zones of numbers, and of the angles of cam and face in rad, by key of ``[tolerances]``."""
    return tolerance_zones_of_numbers(scene, nominal_by_key) | {
        key: tolerance_zone(each, key, 0.0).scale_by(radians(1.0))
        for key, each in scene.tolerances.number_and_angle_tolerances.items()
        if key in ANGLE_TOLERANCES
    }


def tolerance_zones_that_move_tool(scene: Scene, nominal_by_key: Mapping[str, float]) -> dict[str, ToleranceZone]:
    """The zones that move the tool: of sizes of the follower, links of the train, and angles."""
    return {
        key: zone
        for key, zone in tolerance_zones_of_numbers_and_angles(scene, nominal_by_key).items()
        if does_error_move_tool(key)
    }


def tolerance_zones_of_robust_search(
    scene: Scene, variables: Iterable[Variable], nominal_by_key: Mapping[str, float]
) -> dict[str, ToleranceZone]:
    """The zones within which cams must meet the limits, by field; empty unless ``search.robust``.

    Raises
    ------
    BadInput
        If no number has a tolerance.
    """
    if not scene.search.robust:
        return {}
    zones, fields = tolerance_zones_of_numbers(scene, nominal_by_key), {each.key: each for each in variables}
    if not zones:
        why = "needs a tolerance of a size, such as tolerances.follower.offset = 0.02"
        raise BadInput([Mistake(scene.file, "search.robust", True, why, bare=True)])
    return {fields[key].field: zone for key, zone in zones.items() if zone.has_width}


def entries_of_train_numbers(entries_by_key: Mapping[str, EntryT]) -> dict[str, EntryT]:
    """The entries for numbers of the train, which designs do not carry."""
    return {key: each for key, each in entries_by_key.items() if is_train_key(key)}


def initial_robust_errors(zones: Mapping[str, ToleranceZone]) -> tuple[NumberErrors, ...]:
    """The errors that a robust search checks first: the corners of the zones."""
    return tuple(
        corner_errors(
            zones, MOST_CORNER_NUMBERS if len(entries_of_train_numbers(zones)) <= MOST_CORNER_LINKS else 0
        )
    )


def corner_errors(
    zones: Mapping[str, ToleranceZone], most_zones_for_corners: int = MOST_CORNER_NUMBERS
) -> Iterator[NumberErrors]:
    """The errors at the corners of zones, by field.

    With more than ``most_zones_for_corners`` zones, at their ends one at a time.

    Zones without a width give no errors.
    """
    ends = {field: {zone.lower, zone.upper} for field, zone in zones.items()}
    if len(ends) > most_zones_for_corners:
        yield from ({field: end} for field, each in ends.items() for end in sorted(each) if end)
        return
    for corner in product(*(sorted(each) for each in ends.values())):
        if any(corner):
            yield dict(zip(ends, corner, strict=True))


def with_added_errors(designs: Designs, errors: NumberErrors) -> Designs:
    """Designs with errors added to their numbers, of any kind."""
    return designs.with_values({field: designs.values[field] + by for field, by in errors.items()})


def design_copies_with_errors(design: Designs, variants: list[NumberErrors]) -> Designs:
    """Copies of a design, each with its own errors."""
    fields = {field for errors in variants for field in errors}
    copies = design.take(np.zeros(len(variants), dtype=int))
    return copies.with_values(
        {n: copies.values[n] + np.array([errors.get(n, 0.0) for errors in variants]) for n in fields}
    )

"""The numbers that designs may have which are within the tolerances of a scene."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import product
from math import radians
from typing import TypeVar

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.model.mechanisms import Designs
from camopt.scene.problem.variables import Variable, is_train_key
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLE_TOLERANCES, ToleranceZone, moves_tool, tolerance_zone

MOST_CORNER_NUMBERS, MOST_CORNER_LINKS = 8, 4
"""Of more numbers there are too many corners; of more of a train too, of each of which a motion is made."""
NumberErrors = Mapping[str, float]
"""By how much numbers are off, by field of ``Designs``; those of a train by key."""
EntryT = TypeVar("EntryT")


def collect_nominal_numbers(
    variables: Iterable[Variable], design: Designs, others: Mapping[str, float | None]
) -> Mapping[str, float]:
    """The numbers of a scene, by key: those of its design, and others that it gives."""
    own = {each.key: float(design.values[each.field][0]) for each in variables if each.field in design.values}
    return {key: value for key, value in others.items() if value is not None} | own


def number_zones(scene: Scene, nominal: Mapping[str, float]) -> dict[str, ToleranceZone]:
    """The zone of each number that has a tolerance, by its key in the scene, in its unit."""
    return {
        key: tolerance_zone(tolerance, key.rpartition(".")[2], nominal[key])
        for key, tolerance in scene.tolerances.numbers.items()
    }


def number_and_angle_zones(scene: Scene, nominal: Mapping[str, float]) -> dict[str, ToleranceZone]:
    """Those, and of the angles of a cam and its face in rad, by key of ``[tolerances]``."""
    angles = {
        key: each for key, each in scene.tolerances.number_and_angle_tolerances.items() if key in ANGLE_TOLERANCES
    }
    return number_zones(scene, nominal) | {
        key: tolerance_zone(each, key, 0.0).scale_by(radians(1.0)) for key, each in angles.items()
    }


def tool_zones(scene: Scene, nominal: Mapping[str, float]) -> dict[str, ToleranceZone]:
    """Those that move the tool: of sizes of the follower, links of the train, and angles."""
    return {key: zone for key, zone in number_and_angle_zones(scene, nominal).items() if moves_tool(key)}


def robust_zones(
    scene: Scene, variables: Iterable[Variable], nominal: Mapping[str, float]
) -> dict[str, ToleranceZone]:
    """The zones within which cams have to hold the limits too, by field; none unless ``search.robust``.

    Raises
    ------
    BadInput
        If no number has a tolerance.
    """
    if not scene.search.robust:
        return {}
    zones, fields = number_zones(scene, nominal), {each.key: each for each in variables}
    if not zones:
        why = "needs a tolerance of a size, such as tolerances.follower.offset = 0.02"
        raise BadInput([Mistake(scene.file, "search.robust", True, why, bare=True)])
    return {fields[key].field: zone for key, zone in zones.items() if zone.has_width}


def train_entries(off: Mapping[str, EntryT]) -> dict[str, EntryT]:
    """What of some numbers is of the train, which designs do not bring."""
    return {key: each for key, each in off.items() if is_train_key(key)}


def initial_robust_errors(zones: Mapping[str, ToleranceZone]) -> tuple[NumberErrors, ...]:
    """By how much cams are off that are looked at, at first, where all within zones have to hold the limits."""
    return tuple(corner_errors(zones, MOST_CORNER_NUMBERS if len(train_entries(zones)) <= MOST_CORNER_LINKS else 0))


def corner_errors(zones: Mapping[str, ToleranceZone], most: int = MOST_CORNER_NUMBERS) -> Iterator[NumberErrors]:
    """By how much numbers are off at the corners of zones, by field; of more than a few where one of them is alone.

    None of zones that have no width.
    """
    ends = {field: {zone.lower, zone.upper} for field, zone in zones.items()}
    if len(ends) > most:
        yield from ({field: end} for field, each in ends.items() for end in sorted(each) if end)
        return
    for corner in product(*(sorted(each) for each in ends.values())):
        if any(corner):
            yield dict(zip(ends, corner, strict=True))


def add_errors(designs: Designs, off: NumberErrors) -> Designs:
    """Designs whose numbers are off; of any kind of number."""
    return designs.with_values({field: designs.values[field] + by for field, by in off.items()})


def designs_with_errors(design: Designs, offs: list[NumberErrors]) -> Designs:
    """One design off in several ways."""
    fields = {field for off in offs for field in off}
    every = design.take(np.zeros(len(offs), dtype=int))
    return every.with_values({n: every.values[n] + np.array([off.get(n, 0.0) for off in offs]) for n in fields})

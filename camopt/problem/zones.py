"""The sizes that designs may have which are within the tolerances of a scene."""

from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np

from camopt.mechanisms import FIELDS, Designs
from camopt.mistakes import BadInput, Mistake
from camopt.scene.scene import Scene
from camopt.scene.tolerances import Zone, zone_of

Off = Mapping[str, float]
"""By how much sizes are off, by field of ``Designs``."""


def size_zones(scene: Scene, design: Designs) -> dict[str, Zone]:
    """The zone of each size of the follower that has a tolerance, by its key in ``[follower]``, mm."""
    given = scene.tolerances.follower
    toleranced = {key: getattr(given, key) for key in type(given).model_fields}
    return {
        key: zone_of(tolerance, key, float(design.sizes[FIELDS[key]][0]))
        for key, tolerance in toleranced.items()
        if tolerance is not None
    }


def robust_zones(scene: Scene, design: Designs) -> dict[str, Zone]:
    """The zones within which cams have to hold the limits too, by field; none unless ``search.robust``.

    Raises
    ------
    BadInput
        If no size of the follower has a tolerance.
    """
    if not scene.search.robust:
        return {}
    zones = size_zones(scene, design)
    if not zones:
        why = "needs a tolerance of a size, such as tolerances.follower.offset = 0.02"
        raise BadInput([Mistake(scene.file, "search.robust", True, why, bare=True)])
    return {FIELDS[key]: zone for key, zone in zones.items() if zone.lower != zone.upper or zone.lower}


def corners(zones: Mapping[str, Zone]) -> Iterator[Off]:
    """By how much sizes are off at the corners of zones, by field; none of zones that have no width."""
    ends = {field: {zone.lower, zone.upper} for field, zone in zones.items()}
    for corner in product(*(sorted(each) for each in ends.values())):
        if any(corner):
            yield dict(zip(ends, corner, strict=True))


def moved(designs: Designs, off: Off) -> Designs:
    """Designs whose sizes are off; of any kind of number."""
    return designs.with_values({field: designs.sizes[field] + by for field, by in off.items()})


def all_moved(design: Designs, offs: list[Off]) -> Designs:
    """One design off in several ways."""
    fields = {field for off in offs for field in off}
    every = design.take(np.zeros(len(offs), dtype=int))
    return every.with_values({n: every.sizes[n] + np.array([off.get(n, 0.0) for off in offs]) for n in fields})

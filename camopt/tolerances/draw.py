"""Errors of cams, drawn as ``[tolerances]`` says by scrambled Sobol points.

A number has the distribution of its tolerance over its zone. The profile and the axis of the bore, whose tolerances
are a zone to either side and a distance, have two normal parts each with a third of it as standard deviation: at
each place of the profile, and in each direction of the axis, 99.73 % of the cams are within. Nothing is cut off a
normal distribution: some cams are outside of the tolerances, and no proof is of these.

Source: A. B. Owen, Scrambling Sobol' and Niederreiter-Xing points, J. Complexity 14 (1998).
"""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from math import radians

import numpy as np
from numpy.typing import NDArray

from camopt.mechanisms import Designs
from camopt.numerics import FloatArray
from camopt.problem.sample import sobol
from camopt.problem.zones import size_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import WITHIN, Zone, zone_of
from camopt.tolerances.touching import ANGLES

PARTS = {"profile": ("cosine", "sine"), "bore_eccentricity": ("x", "y")}
"""What the two parts of an error are that is a complex number."""
Drawn = dict[str, FloatArray]


def drawn(scene: Scene, design: Designs, cams: int, seed: int) -> Drawn:
    """The errors of cams, by key of ``[tolerances]``, in mm or rad; those with two parts are complex."""
    makers = dict(_makers(scene, design))
    points = iter(sobol(sum(count for count, _ in makers.values()), cams, seed).T)
    return {key: make(*(next(points) for _ in range(count))) for key, (count, make) in makers.items()}


Maker = tuple[int, Callable[..., FloatArray]]
"""How many points an error takes, and the error by the shares of all cams that are below it."""


def _makers(scene: Scene, design: Designs) -> Iterator[tuple[str, Maker]]:
    given = scene.tolerances
    for key, zone in size_zones(scene, design).items():
        yield f"follower.{key}", _of_number(getattr(given.follower, key).distribution, zone)
    if given.profile is not None:
        yield "profile", _of_parts(given.profile) if given.waves else _of_number("normal", _either(given.profile))
    if given.bore_eccentricity is not None:
        yield "bore_eccentricity", _of_parts(given.bore_eccentricity)
    for key in ANGLES:
        if (tolerance := getattr(given, key)) is not None:
            yield key, _of_number(tolerance.distribution, zone_of(tolerance, key, 0.0).scaled(radians(1.0)))


def _either(size: float) -> Zone:
    return Zone(-size, size, size / WITHIN)


def _of_number(kind: str, zone: Zone) -> Maker:
    return 1, lambda share: _quantile(kind, zone, share)


def _of_parts(size: float) -> Maker:
    of = partial(_quantile, "normal", _either(size))
    return 2, lambda real, imaginary: np.asarray(of(real) + 1j * of(imaginary))


def _quantile(kind: str, zone: Zone, share: FloatArray) -> FloatArray:
    """Where a share of the parts is below, of a distribution over a zone."""
    if kind == "uniform":
        return np.asarray(zone.lower + share * (zone.upper - zone.lower))
    if kind == "triangular":
        half = (zone.upper - zone.lower) / 2.0
        nearest = np.sqrt(2.0 * np.minimum(share, 1.0 - share))
        return np.asarray(zone.middle + np.sign(share - 0.5) * half * (1.0 - nearest))
    from scipy.special import ndtri

    return np.asarray(zone.middle + zone.deviation * ndtri(np.clip(share, 2.0**-60, 1.0 - 2.0**-53)))


def beyond(errors: Drawn, ends: Mapping[str, tuple[float, float]]) -> NDArray[np.bool_]:
    """Whether cams have an error outside of its tolerance, by the ends of each (``touching.error_ends``)."""
    found = np.zeros(next(iter(errors.values())).size, dtype=bool)
    for key, value in errors.items():
        low, high = ends[key]
        found |= np.abs(value) > high if np.iscomplexobj(value) else (value < low) | (value > high)
    return found


def parts_of(errors: Drawn) -> Drawn:
    """The errors as real numbers, by key and part, as ``bore_eccentricity.x``; mm, or deg of angles."""
    found: Drawn = {}
    for key, value in errors.items():
        if np.iscomplexobj(value):
            found |= {
                f"{key}.{part}": each for part, each in zip(PARTS[key], (value.real, value.imag), strict=True)
            }
        else:
            found[key] = np.degrees(value) if key in ANGLES else value
    return found

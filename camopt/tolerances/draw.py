"""Errors of cams, drawn as ``[tolerances]`` says by scrambled Sobol points.

A number has the distribution of its tolerance over its zone. The profile and the axis of the bore, whose tolerances
are a zone to either side and a distance, have two normal parts each with a third of it as standard deviation: at
each place of the profile, and in each direction of the axis, 99.73 % of the cams are within. Nothing is cut off a
normal distribution: some cams are outside of the tolerances, and no proof is of these. Measured errors are drawn as
they are, each as often as the others.

Errors of one batch go together: the share s of the variance of a normal number is that of the batch,

    z = √s·z_batch + √(1 − s)·z_own

and the error is where a share Φ(z) of its own distribution is below. Two normal errors have the correlation
√(s₁·s₂); of others it is a little less.

Source: A. B. Owen, Scrambling Sobol' and Niederreiter-Xing points, J. Complexity 14 (1998).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from math import radians

import numpy as np
import scipy
from numpy.typing import NDArray

from camopt.numerics import FloatArray
from camopt.problem.sample import sobol
from camopt.problem.zones import Off, error_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLES, WITHIN, Tolerance, Zone

PARTS = {"profile": ("cosine", "sine"), "bore_eccentricity": ("x", "y")}
"""What the two parts of an error are that is a complex number."""
GRID = 256
"""Shares of batches, and of parts of a batch, for what errors of one batch have in common."""
INSIDE = 2.0**-60, 1.0 - 2.0**-53
"""Shares that are not 0 or 1."""
Drawn = dict[str, FloatArray]


def itself(key: str) -> Iterable[str]:
    return (key,)


def drawn(
    scene: Scene, nominal: Off, cams: int, seed: int, each_of: Callable[[str], Iterable[str]] = itself
) -> Drawn:
    """The errors of cams, by key of ``[tolerances]``, in mm or rad, of numbers in their units; those with two parts
    are complex. ``each_of`` says which errors a tolerance is of, where it is of several."""
    made, given = dict(_makers(scene, nominal)), scene.tolerances.spread
    of = {part: key for key in made for part in each_of(key)}
    makers = {part: made[key] for part, key in of.items()}
    batches = sorted({each.batch for each in given.values() if each.batch is not None})
    count = sum(each for each, _ in makers.values())
    points = sobol(count + len(batches), cams, seed).T
    own, common = iter(points[:count]), dict(zip(batches, points[count:], strict=True))
    found = Drawn()
    for key, (parts, make) in makers.items():
        shares = [next(own) for _ in range(parts)]
        if of[key] in given and (batch := given[of[key]].batch) is not None:
            shares = [_in_batch(shares[0], common[batch], given[of[key]].shared)]
        found[key] = make(*shares)
    return found


Maker = tuple[int, Callable[..., FloatArray]]
"""How many points an error takes, and the error by the shares of all cams that are below it."""


def _makers(scene: Scene, nominal: Off) -> Iterator[tuple[str, Maker]]:
    given = scene.tolerances
    for key, zone in error_zones(scene, nominal).items():
        yield key, (1, partial(_quantile, given.spread[key], zone, radians(1.0) if key in ANGLES else 1.0))
    if given.profile:
        yield "profile", _of_parts(given.profile) if given.waves else (1, partial(_normal, _either(given.profile)))
    if given.bore_eccentricity:
        yield "bore_eccentricity", _of_parts(given.bore_eccentricity)


def _in_batch(own: FloatArray, common: FloatArray, shared: float) -> FloatArray:
    """Shares of normal numbers of which a part of the variance is that of the batch."""
    first, second = (scipy.special.ndtri(np.clip(each, *INSIDE)) for each in (common, own))
    return np.asarray(scipy.special.ndtr(np.sqrt(shared) * first + np.sqrt(1.0 - shared) * second))


def shared_part(given: Tolerance, zone: Zone, unit: float = 1.0) -> FloatArray:
    """The mean error of the parts of a batch, at even shares of batches, less that of all: (m,)."""
    z = scipy.special.ndtri((np.arange(GRID) + 0.5) / GRID)
    z = z / np.std(z)
    own = scipy.special.ndtr(np.sqrt(given.shared) * z[:, None] + np.sqrt(1.0 - given.shared) * z)
    means = _quantile(given, zone, unit, own).mean(axis=1)
    return np.asarray(means - means.mean())


def _either(size: float) -> Zone:
    return Zone(-size, size, size / WITHIN)


def _of_parts(size: float) -> Maker:
    of = partial(_normal, _either(size))
    return 2, lambda real, imaginary: np.asarray(of(real) + 1j * of(imaginary))


def _quantile(given: Tolerance, zone: Zone, unit: float, share: FloatArray) -> FloatArray:
    """Where a share of the parts is below, of the distribution of a tolerance over its zone."""
    if given.values is not None:
        values = unit * np.sort(given.values)
        return np.asarray(values[np.minimum((share * values.size).astype(int), values.size - 1)])
    if given.distribution == "uniform":
        return np.asarray(zone.lower + share * (zone.upper - zone.lower))
    if given.distribution == "triangular":
        half = (zone.upper - zone.lower) / 2.0
        nearest = np.sqrt(2.0 * np.minimum(share, 1.0 - share))
        return np.asarray(zone.mean + np.sign(share - 0.5) * half * (1.0 - nearest))
    return _normal(zone, share)


def _normal(zone: Zone, share: FloatArray) -> FloatArray:
    return np.asarray(zone.mean + zone.deviation * scipy.special.ndtri(np.clip(share, *INSIDE)))


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
            names = PARTS[key.partition(" ")[0]]
            found |= {f"{key}.{part}": each for part, each in zip(names, (value.real, value.imag), strict=True)}
        else:
            found[key] = np.degrees(value) if key in ANGLES else value
    return found

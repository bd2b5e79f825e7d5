"""A batch of cams: how many of those that are made hold the limits, by the distributions of their sizes.

Each cam has sizes of its own, drawn as ``[tolerances]`` says by scrambled Sobol points, and every quantity is that
of the cam itself, not of a linear model. The share that holds the limits has the interval of Clopper and Pearson,
which is that of independent draws: Sobol points are more even than these.

How much of the variance of a quantity q a size x explains, is S = Var(E[q | x]) / Var(q), from the means of q over
classes of x. To first order it is c²σ²/Σ c²σ², with the slope c = ∂q/∂x and the standard deviation σ.

Sources: C. J. Clopper, E. S. Pearson, The use of confidence or fiducial limits, Biometrika 26 (1934); E. Plischke,
E. Borgonovo, C. L. Smith, Global sensitivity measures from given data, Eur. J. Oper. Res. 226 (2013); A. B. Owen,
Scrambling Sobol' and Niederreiter-Xing points, J. Complexity 14 (1998).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms import FIELDS, Designs
from camopt.mistakes import BadInput, Mistake
from camopt.numerics import FloatArray
from camopt.problem.limit import Limit
from camopt.problem.problem import Problem, resolve_design
from camopt.problem.sample import sobol
from camopt.problem.zones import size_zones
from camopt.quantities import QUANTITIES
from camopt.quantities.shown import HasHtml
from camopt.quantities.unit_systems import shown
from camopt.scene.scene import Scene
from camopt.scene.tolerances import Zone
from camopt.tables.cells import number, with_unit
from camopt.tables.layout import NUMERIC, Cell, Table
from camopt.tolerances.limited import limited, worst_of

CAMS = 2**16
"""Unless told."""
MOST_CAMS = 2**24
AT_ONCE = 2**16
CLASSES = 64
"""Of a size, for the variance that it explains."""
CONFIDENCE = 0.95
TAIL = 0.00135
"""Of a normal distribution beyond three standard deviations, on one side."""


class Share(NamedTuple):
    """A share of the cams of a batch, with its interval of confidence of 95 %.

    Examples
    --------
    >>> scene = camopt.find_scene("rocker-valve").replace(**{"tolerances.follower.arm_length": 0.05})
    >>> camopt.sample_cams(scene, cams=1024).held.share
    1.0
    """

    share: float
    low: float
    high: float


class Spread(NamedTuple):
    """How the quantity of a limit is spread over the cams of a batch.

    Examples
    --------
    >>> scene = camopt.find_scene("rocker-valve").replace(**{"tolerances.follower.arm_length": 0.05})
    >>> spread = camopt.sample_cams(scene, cams=1024).spreads[0]
    >>> spread.limit, round(spread.median, 2)
    ('pressure_angle', 24.49)
    """

    limit: str
    quantity: str
    held: Share
    """The cams that hold the limit."""
    low: float
    """Below which 0.135 % of the cams are."""
    median: float
    high: float
    """Above which 0.135 % of the cams are."""
    worst: float
    """Of all cams of the batch."""
    sizes: dict[str, float]
    """Those of that cam that have tolerances, by key of the scene, mm."""
    variances: dict[str, float]
    """The share of the variance that each size explains, by key; 0 if the quantity is the same for all."""


@dataclass(frozen=True)
class Batch(HasHtml):
    """A batch of cams whose sizes are spread as the tolerances of a scene say.

    Attributes
    ----------
    scene : Scene
        The nominal cam, with its ``[tolerances]``.
    cams, seed : int
        How many, and which draw.
    held : Share
        The yield: the share of the cams that hold all limits.
    spreads : tuple of Spread
        Of each limit that a size decides.

    Examples
    --------
    >>> scene = camopt.find_scene("rocker-valve").replace(**{"tolerances.follower.arm_length": 0.05})
    >>> batch = camopt.sample_cams(scene, cams=4096)
    >>> batch.held.share, batch.held.high
    (1.0, 1.0)
    """

    scene: Scene
    cams: int
    seed: int
    held: Share
    spreads: tuple[Spread, ...]

    def table(self) -> Table:
        """The share of cams that holds each limit, and how its quantity is spread."""
        heads = ["limit", "held by", "0.135 %", "median", "99.865 %", "worst", "by"]
        rows = [["all", _percent(self.held), *([""] * 5)]]
        for each in self.spreads:
            unit = QUANTITIES[each.quantity].unit
            values = [number(shown(value, unit)) for value in (each.low, each.median, each.high)]
            parts = sorted(each.variances.items(), key=lambda part: -part[1])
            by = ", ".join(f"{key.partition('.')[2]} {100.0 * part:.0f} %" for key, part in parts)
            rows.append([each.limit, _percent(each.held), *values, with_unit(each.worst, unit), by])
        kinds = [Cell(head, NUMERIC if head in heads[1:6] else "") for head in heads]
        title = f"{self.scene.name}: {self.cams:,} cams within the tolerances of sizes"
        return Table.of(title, kinds, rows, "In brackets with a confidence of 95 %.")

    def records(self) -> list[dict[str, Any]]:
        """A mapping for each limit."""
        return [{**each._asdict(), "held": each.held._asdict()} for each in self.spreads]

    @property
    def shown_cam(self) -> Scene:
        """The nominal cam."""
        return self.scene


def sample_cams(scene: Scene, cams: int = CAMS, seed: int = 0) -> Batch:
    """Draw cams whose sizes are spread as the tolerances of a scene say, and see which hold the limits.

    Each cam has the motion that is asked, with sizes of its own: see ``margins`` of ``tolerance`` for what all of
    them hold. The profile's self-crossing is not looked at.

    Parameters
    ----------
    scene : Scene
        A scene with sizes of its own, limits and ``[tolerances]`` of sizes of the follower.
    cams : int, default 65,536
        How many, at most 16,777,216; Sobol points are the most even for a power of 2.
    seed : int, default 0
        Which of all such draws.

    Returns
    -------
    Batch
        The yield with its interval, and how the quantity of each limit is spread.

    Raises
    ------
    BadInput
        If the scene lacks a size, or has no tolerances of sizes, or for a number of cams that is none.

    References
    ----------
    A. B. Owen, Scrambling Sobol' and Niederreiter-Xing points, J. Complexity 14 (1998).

    Examples
    --------
    >>> tolerances = {"follower.offset": {"plus": 0.5, "minus": 0.5}}
    >>> scene = camopt.find_scene("bucket-valve").replace(tolerances=tolerances, **{"limits.face_reach": 13.2})
    >>> round(camopt.sample_cams(scene, cams=2**14).held.share, 2)
    0.8
    """
    if not isinstance(cams, int) or not 1 <= cams <= MOST_CAMS:
        raise BadInput([Mistake("camopt", "cams", cams, f"a whole number from 1 to {MOST_CAMS:,}")])
    problem = resolve_design(scene)
    zones = size_zones(scene, problem.design)
    if not zones:
        why = "names no size of the follower: give one, such as follower.offset = 0.02"
        raise BadInput([Mistake(problem.file, "tolerances", None, why, bare=True)])
    sizes = drawn(scene, problem.design, zones, cams, seed)
    limits = [limit for limit in problem.without_last.limits if limit.shown and not limit.is_of_motion]
    every = problem.design.take(np.zeros(cams, dtype=int)).with_values(
        {FIELDS[key]: values for key, values in sizes.items()}
    )
    excess, values = evaluated(problem, limits, every)
    held = np.all(excess <= 0.0, axis=0)
    spreads = tuple(_spreads(limits, excess, values, sizes))
    return Batch(scene, cams, seed, share_of(int(np.count_nonzero(held)), cams), spreads)


def drawn(scene: Scene, design: Designs, zones: dict[str, Zone], cams: int, seed: int) -> dict[str, FloatArray]:
    """The sizes of cams, by key in ``[follower]``."""
    points = sobol(len(zones), cams, seed)
    found = {}
    for (key, zone), share in zip(zones.items(), points.T, strict=True):
        kind = getattr(scene.tolerances.follower, key).distribution
        found[key] = float(design.sizes[FIELDS[key]][0]) + _quantile(kind, zone, share)
    return found


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


def evaluated(problem: Problem, limits: list[Limit], designs: Designs) -> tuple[FloatArray, FloatArray]:
    """As ``limited``, some designs at a time."""
    parts = [
        limited(problem, limits, designs.take(slice(first, first + AT_ONCE)))
        for first in range(0, len(designs), AT_ONCE)
    ]
    excess, values = (np.concatenate(each, axis=1) for each in zip(*parts, strict=True))
    return excess, values


def share_of(count: int, cams: int) -> Share:
    """A share with the interval of Clopper and Pearson."""
    from scipy.special import betaincinv

    tail = (1.0 - CONFIDENCE) / 2.0
    low = float(betaincinv(count, cams - count + 1, tail)) if count else 0.0
    high = float(betaincinv(count + 1, cams - count, 1.0 - tail)) if count < cams else 1.0
    return Share(count / cams, low, high)


def _spreads(
    limits: list[Limit], excess: FloatArray, values: FloatArray, sizes: dict[str, FloatArray]
) -> Iterator[Spread]:
    """How the quantity of each limit is spread."""
    cams = values.shape[1]
    for limit, over, each in zip(limits, excess, values, strict=True):
        worst = worst_of(limit, over, each)
        held = share_of(int(np.count_nonzero(over <= 0.0)), cams)
        low, median, high = (float(value) for value in np.quantile(each, [TAIL, 0.5, 1.0 - TAIL]))
        own = {f"follower.{key}": float(size[worst]) for key, size in sizes.items()}
        parts = {f"follower.{key}": explained(each, size) for key, size in sizes.items()}
        yield Spread(limit.name, limit.shown[0], held, low, median, high, float(each[worst]), own, parts)


def explained(values: FloatArray, size: FloatArray) -> float:
    """The share of the variance of values that a size explains, from the means over classes of it."""
    count = min(CLASSES, max(values.size // CLASSES, 1))
    spread = float(np.var(values)) if np.all(np.isfinite(values)) else 0.0
    if spread <= (1e-12 * float(np.max(np.abs(values)))) ** 2:
        return 0.0
    classes = np.array_split(values[np.argsort(size, kind="stable")], count)
    means, weights = (np.array([f(each) for each in classes]) for f in (np.mean, np.size))
    middle = np.average(means, weights=weights)
    return float(np.average(np.square(means - middle), weights=weights) / spread)


def _percent(held: Share) -> str:
    """A share in per cent, with its interval."""
    low, high = 100.0 * held.low, 100.0 * held.high
    return f"{100.0 * held.share:.6g} % [{low:.4f}, {high:.4f}]"

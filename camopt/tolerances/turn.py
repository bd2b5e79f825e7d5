"""The errors of a motion over the turn: totals at cam angles, where they are largest, and where they jump.

Contributions are sampled on every panel of the motion, on both sides of each jump, and every top that is nearly
as high as the highest is looked at again between its neighbours: there they are smooth, but for kinks.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import degrees
from typing import NamedTuple

import numpy as np

from camopt.effects.answers import ORDERS
from camopt.mistakes import BadInput, Mistake
from camopt.motion.programme import JUMP_SIDE
from camopt.numerics import FloatArray
from camopt.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.scene.tolerances import WITHIN
from camopt.tolerances.contributions import Contribution, contributions, variances

NAMES = ("displacement", "velocity", "acceleration")
BAND = "root sum square, 3σ"
"""What the band of independent errors is called."""
NODES = 24
"""Cam angles of a panel of the motion."""
NEAR = 1e-3
"""Places this near to the highest, relative, are looked at again."""
ZOOMS, FINER = 5, 33
"""How often, and with how many cam angles between the neighbours of the highest one."""
SAID = 6
"""How many cam angles of impulses are named."""
SAME = 1e-9
"""Two sides of a jump that differ by less, relative to the largest of the turn, are the same."""
Total = Callable[[list[Contribution], int], FloatArray]


def no_tolerances(file: str) -> BadInput:
    """The message on a scene without any."""
    why = "names none: give one, such as profile = 0.02 or follower.roller_radius = 'h6'"
    return BadInput([Mistake(file, "tolerances", None, why, bare=True)])


class Ends(NamedTuple):
    """Between which values an error is, at each cam angle."""

    lower: FloatArray
    upper: FloatArray

    @property
    def magnitude(self) -> FloatArray:
        return np.asarray(np.maximum(-self.lower, self.upper))


def worst_ends(found: list[Contribution], order: int) -> Ends:
    """Those of the worst case of an order: all errors at the ends that move the motion the same way."""
    lower, upper = (sum(getattr(each, end)[order] for each in found) for end in ("lower", "upper"))
    return Ends(lower, upper)


def band_ends(found: list[Contribution], order: int) -> Ends:
    """The root sum square of an order: 3σ to either side of the mean, but within the worst case.

    Of parts that spread beyond their zones the worst case is that of the furthest parts.
    """
    middle, most = sum(each.middle[order] for each in found), worst_ends(found, order)
    half = WITHIN * np.sqrt(np.maximum(variances(found, order).sum(axis=0), 0.0))
    under, over = (sum(each.beyond[side][order] for each in found) for side in (0, 1))
    return Ends(np.maximum(middle - half, most.lower - under), np.minimum(middle + half, most.upper + over))


def worst(found: list[Contribution], order: int) -> FloatArray:
    """The worst case of an order, at each cam angle."""
    return worst_ends(found, order).magnitude


def band(found: list[Contribution], order: int) -> FloatArray:
    """The root sum square of an order, at each cam angle: |mean| + 3σ, but within the furthest parts."""
    return band_ends(found, order).magnitude


def highest(nodes: FloatArray, value: Callable[[FloatArray], FloatArray]) -> float:
    """The cam angle of the largest of a value over the turn, from those at nodes (``TurnErrors.nodes``), rad."""
    values = value(nodes)
    most, same = values.max(), SAME * abs(values.max())
    rising = values > np.roll(values, 1) + same  # of a plateau, as in a dwell, the first node alone
    tops = np.flatnonzero(rising & (values >= np.roll(values, -1) - same) & (values >= most - NEAR * abs(most)))
    tops = np.union1d(tops, values.argmax())
    low, high = nodes[np.maximum(tops - 1, 0)], nodes[np.minimum(tops + 1, nodes.size - 1)]
    for _ in range(ZOOMS):
        inside = low + (high - low) * np.linspace(0.0, 1.0, FINER)[:, None]
        found = value(inside.ravel()).reshape(inside.shape)
        k, column = found.argmax(axis=0), np.arange(tops.size)
        low, high = inside[np.maximum(k - 1, 0), column], inside[np.minimum(k + 1, FINER - 1), column]
    places, heights = np.concatenate([inside[k, column], nodes]), np.concatenate([found.max(axis=0), values])
    return float(places[heights.argmax()])


class Impulse(NamedTuple):
    """The impulses of what a tolerance contributes: infinite from an order on, at some cam angles, rad."""

    order: int
    at: float
    """The first of ``places``."""
    places: tuple[float, ...]


@dataclass(frozen=True)
class TurnErrors:
    """The errors of one design over a turn of the cam, by its cam angle."""

    scene: Scene
    problem: Problem

    def at(self, angles: FloatArray) -> list[Contribution]:
        """What each tolerance contributes at cam angles, rad."""
        return [*contributions(self.scene, self.problem, angles)]

    def highest(self, total: Total, order: int) -> float:
        """The cam angle of the largest total of an order that is bounded, rad."""
        return highest(self.nodes, lambda angles: total(self.at(angles), order))

    def unbounded(self, order: int) -> dict[str, float | None]:
        """The keys of tolerances whose contribution to an order has no bound, each with the cam angle, rad.

        None of one that has no bound at any angle.
        """
        jumps = {key: impulse.at for key, impulse in self.impulses.items() if impulse.order <= order}
        return jumps | {each.key: None for each in self.sampled if np.isinf(each.upper[order]).any()}

    def impulses_said(self, order: int) -> str:
        """The cam angles of the impulses of an order in words, the first ones of many."""
        every = sorted({at for each in self.impulses.values() if each.order <= order for at in each.places})
        said = ", ".join(f"{degrees(at):.6g}" for at in every[:SAID])
        return f"{said} deg" + (f" and at {len(every) - SAID} more cam angles" if len(every) > SAID else "")

    @cached_property
    def impulses(self) -> dict[str, "Impulse"]:
        """The impulses of what tolerances contribute, by key of the tolerance; of those that have one.

        Where velocity or acceleration of the motion jumps, what an error does to it may jump too: the next slope is
        an impulse there.
        """
        places = np.array([jump.at for jump in self.problem.programme.jumps])
        turn, found = self.problem.programme.strokes[-1].end, dict[str, Impulse]()
        if not places.size:
            return found
        before, after = (self.at(np.mod(places + side, turn)) for side in (-JUMP_SIDE, JUMP_SIDE))
        for left, right, usual in zip(before, after, self.sampled, strict=True):
            for order in reversed(range(ORDERS - 1)):
                with np.errstate(invalid="ignore"):
                    ends = (right.lower - left.lower)[order], (right.upper - left.upper)[order]
                jumps = np.flatnonzero(np.abs(ends).max(axis=0) > SAME * worst([usual], order).max())
                if jumps.size:
                    where = tuple(float(each) for each in places[jumps])
                    found[left.key] = Impulse(order + 1, where[0], where)
        return found

    @cached_property
    def sampled(self) -> list[Contribution]:
        """The contributions at the nodes."""
        return self.at(self.nodes)

    @cached_property
    def nodes(self) -> FloatArray:
        """The cam angles at which errors are sampled, rad, in the order of the turn."""
        table = self.problem.programme.table
        half = table.half_width[:, None]
        inner = np.clip(np.linspace(-1.0, 1.0, NODES) * half, JUMP_SIDE - half, half - JUMP_SIDE)
        return np.asarray((table.centre[:, None] + inner).ravel())

"""Boxes of designs of which all cross themselves.

Two parts of the profile of one design that meet do so throughout the box if they reach further across each other
than the profile moves within the box (``parts.drift``). A crossing moves little from design to design: those known
are tried first.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from camopt.effects.case import Subject
from camopt.effects.crossing import HALVINGS, cross, find_crossing, meet
from camopt.effects.parts import WIDEST, Parts, cover, drift, ends_of, points_at
from camopt.mechanisms.design import BoolArray, Designs
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray

MOST_KNOWN = 4
STEPS, SHORT = 8, 1e-7  # of Newton's method; of its difference quotients, rad


class CrossingBoxes:
    """A search among the cams of a programme, and where their profiles were found to cross."""

    def __init__(self, subject: Subject, programme: Programme) -> None:
        self._subject, self._programme = subject, programme
        self._known: list[tuple[float, ...]] = []
        """Pairs of cam angles in rad, the latest first."""

    def excluded(self, box: Designs) -> BoolArray:
        """Of which boxes (Intervals) all designs are shown to cross themselves.

        Where no known crossing shows it, another one is looked for, at the box of the smallest cams.
        """
        sides: dict[str, Any] = box.sizes
        middles = replace(box, **{name: (side.low + side.high) / 2 for name, side in sides.items()})
        crossing, exists = np.zeros(len(box), dtype=bool), self._subject.mechanism.exists(middles, self._programme)
        for near in self._known:
            self._try(near, middles, box, crossing, exists)
        left = np.flatnonzero(exists & ~crossing)
        if left.size:
            smallest = left[np.argmin(sides["size"].low[left])]
            found = find_crossing(self._subject, middles.take([smallest]), self._programme)
            if found.shown:
                self._known = [found.at, *self._known][:MOST_KNOWN]
                self._try(found.at, middles, box, crossing, exists)
        return crossing

    def _try(
        self, near: tuple[float, ...], middles: Designs, box: Designs, crossing: BoolArray, exists: BoolArray
    ) -> None:
        """Mark the boxes that cross themselves throughout near two cam angles."""
        left = np.flatnonzero(exists & ~crossing)
        if left.size:
            column = (left, None)
            crossing[left] = crosses_throughout(
                self._subject, middles.take(column), box.take(column), self._programme, near
            )


def crosses_throughout(
    subject: Subject, designs: Designs, box: Designs, programme: Programme, near: tuple[float, ...]
) -> BoolArray:
    """In which boxes (n, 1) round designs all are shown to cross themselves near two cam angles in rad."""
    sides = []
    for root in _roots(subject, designs, programme, near).T:
        parts = _around(programme, root)
        found = cover(subject, designs, programme, parts)
        moved = drift(subject, designs, box, parts, found)
        sides.append((found, ends_of(subject, designs, programme, parts), moved))
    (one, ends, moved), (other, other_ends, also) = sides
    return np.asarray(np.any(meet(one, other, ends, other_ends, moved + also), axis=-1))


def _around(programme: Programme, angles: FloatArray) -> Parts:
    """Parts (n, HALVINGS) round cam angles (n,), ever narrower, with what bounds the motion in the widest."""
    table = programme.table
    away = np.abs(np.mod(angles[:, None] - table.centre + np.pi, 2 * np.pi) - np.pi)
    touched = away <= table.half_width + 1.01 * WIDEST
    velocity, acceleration = (
        np.max(np.where(touched, table.most[: table.centre.size, order], 0.0), axis=1, keepdims=True)
        for order in (1, 2)
    )
    half = np.broadcast_to(WIDEST * 0.5 ** np.arange(HALVINGS), (angles.size, HALVINGS))
    return Parts(np.broadcast_to(angles[:, None], half.shape), half, velocity, acceleration)


def _roots(subject: Subject, designs: Designs, programme: Programme, near: tuple[float, ...]) -> FloatArray:
    """The two cam angles (n, 2) of about one point of each profile, by Newton's method from those given."""
    angles = np.tile(np.array(near), (len(designs), 1))
    for _ in range(STEPS):
        points = points_at(subject, designs, programme, np.concatenate([angles, angles + SHORT], axis=1))
        gap, (along, across) = points[:, 1] - points[:, 0], ((points[:, 2:] - points[:, :2]) / SHORT).T
        turned = cross(along, across)
        step = np.stack([cross(gap, across), cross(gap, along)], axis=1)
        step = step / np.where(turned == 0.0, np.inf, turned)[:, None]
        angles = angles + np.clip(step, -WIDEST, WIDEST)
    return np.asarray(np.mod(angles, 2 * np.pi))

"""The largest errors of the motion by tolerances that no curve tells: of two contacts, and through any train.

To first order, as those of curves (``effects.motion_errors``): with the answer c of the tool to each error
(``effects.answers``), f'·c behind a train, and ∂f/∂p of a number p of it, the error is at most Σ c·t at each cam
angle. It is computed at many angles of the turn, and closer and closer about the highest. Where the motion jumps,
the errors on both sides are compared: where one of them jumps too, its slope is an impulse.

A profile adds the most that one within its zone makes (``answers.most_of_profile``), and an axis of the bore that
is off by ε the length ε·√(a² + b²) of its two answers, or of the same derivatives of both.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, pi, sin
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series
from camopt.model.effects.answers import (
    Answers,
    At,
    answers_of,
    back_of,
    derivatives_of,
    errors_at,
    most_of_profile,
    moved_by_link,
)
from camopt.model.effects.case import Case
from camopt.model.effects.given import Band, GivenErrors
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.driven import ratio_of
from camopt.model.motion.programme import JUMP_SIDE

NODES = 8
"""Cam angles of a panel of the motion."""
TOPS, ZOOMS, FINER = 3, 4, 17
"""How many of the highest places are looked at closer, how often, and at how many angles."""
AT_ONCE = 64
"""Designs."""
SAME = 1e-9
"""Errors on both sides of a jump that differ by less, relative to the largest of the turn, are the same."""


class Ends(NamedTuple):
    """Between which values what an error makes of the motion is, (orders, designs, angles)."""

    lower: FloatArray
    upper: FloatArray


@dataclass(frozen=True)
class ToolAnswers:
    """The answers of the tool of some designs at cam angles, (designs, angles) or the same of all."""

    case: Case
    angles: FloatArray
    orders: int = 1
    """How many derivatives, the displacement first."""

    @cached_property
    def contacts(self) -> list[Answers]:
        """Those of the follower's contacts, each of its own motion."""
        setup, designs = self.case.setup, _columns(self.case.designs)
        return answers_of(setup, designs, self.case.programme, self.angles, self.orders)

    @property
    def given(self) -> GivenErrors:
        assert self.case.setup.errors is not None
        return self.case.setup.errors

    def ends(self) -> Iterator[Ends]:
        """Those of each error."""
        for key, band in self.given.by_key.items():
            yield from (_of_band(answer, band) for answer in self._to(key))
        for band, made in self.given.links.values():
            train, programme = self.case.setup.train, self.case.programme
            assert train is not None
            yield _of_band(self._terms(moved_by_link(made, train, programme, self.angles)), band)
        if self.given.profile:
            for answer in self._to("profile"):
                most = most_of_profile(answer, self.given.profile, self.given.waves)
                yield Ends(-most, most)
        if self.given.bore:
            most = self.given.bore * np.hypot(*self.to_bore)
            yield Ends(-most, most)

    def in_dwell(self, angle: float) -> FloatArray:
        """By how much the tool may move in a dwell of an angle, rad, at whose middle these are."""
        moved, waves = 0.0, sin(min(0.5 * angle * (self.given.waves or inf), 0.5 * pi))
        if self.given.profile:
            moved = moved + 2.0 * self.given.profile * waves * sum(np.abs(each[0]) for each in self._to("profile"))
        if self.given.bore:
            moved = moved + 2.0 * self.given.bore * sin(min(0.5 * angle, 0.5 * pi)) * np.hypot(*self.to_bore)[0]
        return np.asarray(moved + np.zeros((len(self.case.designs), 1)))[:, 0]

    @property
    def to_bore(self) -> tuple[FloatArray, FloatArray]:
        """To an axis of the bore that is off, in two directions that turn with the cam."""
        first, *others = self.contacts
        if not others:
            x, y = first.to_bore
            return self._tool(x), self._tool(y)
        (x, across), (y, up) = first.to_bore, others[0].to_bore
        way = 0.5 * back_of(self.case.setup.mechanism)
        mirrored = -1.0 if others[0].designs.sense != first.designs.sense else 1.0
        return self._tool(x * 0.5 - y * way), self._tool(across * 0.5 - up * (mirrored * way))

    def _to(self, key: str) -> Iterator[FloatArray]:
        """To each error that a tolerance is of."""
        if len(self.contacts) == 1:
            yield self._tool(self.contacts[0].to_number(key))
            return
        for at in errors_at(self.case.setup.mechanism, key).values():
            yield self._tool(self._half(at))

    def _half(self, at: At) -> Series:
        """Half of the difference of both contacts."""
        sides = 1.0, -back_of(self.case.setup.mechanism)
        parts = [
            answers.to_number(own[0]) * (0.5 * side * own[1])
            for answers, own, side in zip(self.contacts, at, sides, strict=True)
            if own is not None
        ]
        return parts[0] if len(parts) == 1 else parts[0] + parts[1]

    @cached_property
    def _ratio(self) -> Series | None:
        train = self.case.setup.train
        return None if train is None else ratio_of(train, self.case.programme, self.angles)

    def _tool(self, found: Series) -> FloatArray:
        return self._terms(found if self._ratio is None else found * self._ratio)

    def _terms(self, found: Series) -> FloatArray:
        return derivatives_of(found, (len(self.case.designs), self.angles.shape[-1]), self.orders)


def _columns(designs: Designs) -> Designs:
    """Designs each in a row of its own."""
    return designs.with_values({name: each[:, None] for name, each in designs.values.items()})


def _of_band(answer: FloatArray, band: Band) -> Ends:
    ends = answer * band.low, answer * band.high
    return Ends(np.minimum(*ends), np.maximum(*ends))


def largest_errors(case: Case, orders: Sequence[int]) -> FloatArray:
    """The largest errors of position, velocity and acceleration, (orders, designs), mm (rad) by powers of rad."""
    count = len(case.designs)
    some = (np.arange(first, min(first + AT_ONCE, count)) for first in range(0, count, AT_ONCE))
    found = [_largest(replace(case, designs=case.designs.take(each)), orders) for each in some]
    return np.concatenate([np.zeros((len(orders), 0)), *found], axis=1)


def dwell_errors(case: Case) -> FloatArray:
    """The largest change of the position in a dwell of the tool, (designs,), mm (rad)."""
    found = [np.zeros(len(case.designs))]
    for stroke in case.programme.tool.dwells:
        middle = np.array([stroke.start + 0.5 * stroke.angle])
        found.append(ToolAnswers(case, middle).in_dwell(stroke.angle))
    return np.asarray(np.max(found, axis=0))


def _worst(case: Case, angles: FloatArray, orders: int) -> FloatArray:
    """(orders, designs, angles)."""
    every = [*ToolAnswers(case, angles, orders).ends()]
    return np.maximum(-sum(each.lower for each in every), sum(each.upper for each in every))


def _largest(case: Case, orders: Sequence[int]) -> FloatArray:
    nodes = _nodes(case)
    every = _worst(case, nodes, 1 + max(orders))
    found = every.max(axis=2)
    for order in orders:
        if np.isfinite(every[order]).all():
            np.maximum(found[: order + 1], _zoomed(case, nodes, every, order), out=found[: order + 1])
    return np.asarray(_with_impulses(case, found)[[*orders]])


def _zoomed(case: Case, nodes: FloatArray, every: FloatArray, order: int) -> FloatArray:
    """The largest of orders up to one, closer and closer about the highest of it."""
    values, found, rows = every[order], every[: order + 1].max(axis=2), np.arange(len(case.designs))[:, None]
    rising = values >= np.roll(values, 1, axis=1)
    tops = np.where(rising & (values >= np.roll(values, -1, axis=1)), values, -inf)
    places = np.argpartition(-tops, TOPS - 1, axis=1)[:, :TOPS]
    low, high = nodes[np.maximum(places - 1, 0)], nodes[np.minimum(places + 1, nodes.size - 1)]
    for _ in range(ZOOMS):
        angles = low[..., None] + (high - low)[..., None] * np.linspace(0.0, 1.0, FINER)
        here = _worst(case, angles.reshape(len(rows), -1), order + 1).reshape(-1, *angles.shape)
        found = np.maximum(found, here.max(axis=(2, 3)))
        ends = (np.clip(here[order].argmax(axis=2) + side, 0, FINER - 1) for side in (-1, 1))
        low, high = (angles[rows, np.arange(TOPS), end] for end in ends)
    return np.asarray(found)


def _with_impulses(case: Case, found: FloatArray) -> FloatArray:
    """Infinite where an error, or a slope of it, jumps: the largest of some orders, (orders, designs)."""
    places, turn = np.array([jump.at for jump in case.programme.jumps]), case.programme.strokes[-1].end
    if not places.size:
        return found
    before, after = (
        [*ToolAnswers(case, np.mod(places + side, turn), len(found)).ends()] for side in (-JUMP_SIDE, JUMP_SIDE)
    )
    for left, right in zip(before, after, strict=True):
        for order in range(len(found) - 1):
            with np.errstate(invalid="ignore"):
                apart = [np.abs(a[order] - b[order]).max(axis=1) for a, b in zip(left, right, strict=True)]
            found[order + 1 :, np.max(apart, axis=0) > SAME * found[order]] = inf
    return found


def _nodes(case: Case) -> FloatArray:
    """Cam angles on every panel of the motion, on both sides of each jump, in the order of the turn."""
    table: Any = case.programme.table
    half = table.half_width[:, None]
    inner = np.clip(np.linspace(-1.0, 1.0, NODES) * half, JUMP_SIDE - half, half - JUMP_SIDE)
    return np.asarray((table.centre[:, None] + inner).ravel())

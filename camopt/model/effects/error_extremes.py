"""The largest errors of the motion by tolerances that no curve tells: of two contacts, and through any train.

To first order, as those of curves (``effects.motion_errors``): with the answer c of the tool to each error
(``effects.answers``), f'·c behind a train, and ∂f/∂p of a number p of it, the error is at most Σ c·t at each cam
angle. It is computed at many angles of the turn, and closer and closer about the highest. Where the motion jumps,
the errors on both sides are compared: where one of them jumps too, its slope is an impulse.

A profile adds the most that one within its zone makes (``answers.largest_profile_response``), and an axis of the
bore that is off by ε the length ε·√(a² + b²) of its two answers, or of the same derivatives of both.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, pi, sin
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series
from camopt.model.effects.effect import EvaluationBlock
from camopt.model.effects.effect_numbers import ErrorBand, ToleranceBands
from camopt.model.effects.error_response import (
    ContactResponse,
    ErrorAtContacts,
    contact_responses,
    errors_by_contact,
    largest_profile_response,
    link_response,
    second_motion_sign,
    series_derivatives,
)
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.programme import JUMP_SIDE
from camopt.model.motion.tool_drive import train_ratio_series

ERROR_NODES = 8
"""Cam angles of a panel of the motion."""
ZOOMED_PEAKS, ZOOM_ROUNDS, ZOOM_ANGLES = 3, 4, 17
"""How many of the highest places are looked at closer, how often, and at how many angles."""
ERROR_BLOCK = 64
"""Designs."""
JUMP_TOLERANCE = 1e-9
"""Errors on both sides of a jump that differ by less, relative to the largest of the turn, are the same."""


class ResponseBounds(NamedTuple):
    """Between which values what an error makes of the motion is, (orders, designs, angles)."""

    lower: FloatArray
    upper: FloatArray


@dataclass(frozen=True)
class ToolErrorModel:
    """The answers of the tool of some designs at cam angles, (designs, angles) or the same of all."""

    case: EvaluationBlock
    angles: FloatArray
    orders: int = 1
    """How many derivatives, the displacement first."""

    @cached_property
    def contact_responses(self) -> list[ContactResponse]:
        """Those of the follower's contacts, each of its own motion."""
        setup, designs = self.case.setup, _designs_by_row(self.case.designs)
        return contact_responses(setup, designs, self.case.programme, self.angles, self.orders)

    @property
    def tolerance_bands(self) -> ToleranceBands:
        assert self.case.setup.errors is not None
        return self.case.setup.errors

    def error_bounds(self) -> Iterator[ResponseBounds]:
        """Those of each error."""
        for key, band in self.tolerance_bands.by_key.items():
            yield from (_band_bounds(answer, band) for answer in self._error_responses(key))
        for band, made in self.tolerance_bands.links.values():
            train, programme = self.case.setup.train, self.case.programme
            assert train is not None
            yield _band_bounds(self._derivative_terms(link_response(made, train, programme, self.angles)), band)
        if self.tolerance_bands.profile:
            for answer in self._error_responses("profile"):
                most = largest_profile_response(answer, self.tolerance_bands.profile, self.tolerance_bands.waves)
                yield ResponseBounds(-most, most)
        if self.tolerance_bands.bore:
            most = self.tolerance_bands.bore * np.hypot(*self.bore_responses)
            yield ResponseBounds(-most, most)

    def dwell_change(self, angle: float) -> FloatArray:
        """By how much the tool may move in a dwell of an angle, rad, at whose middle these are."""
        moved, waves = 0.0, sin(min(0.5 * angle * (self.tolerance_bands.waves or inf), 0.5 * pi))
        if self.tolerance_bands.profile:
            moved = moved + 2.0 * self.tolerance_bands.profile * waves * sum(
                np.abs(each[0]) for each in self._error_responses("profile")
            )
        if self.tolerance_bands.bore:
            moved = (
                moved
                + 2.0
                * self.tolerance_bands.bore
                * sin(min(0.5 * angle, 0.5 * pi))
                * np.hypot(*self.bore_responses)[0]
            )
        return np.asarray(moved + np.zeros((len(self.case.designs), 1)))[:, 0]

    @property
    def bore_responses(self) -> tuple[FloatArray, FloatArray]:
        """To an axis of the bore that is off, in two directions that turn with the cam."""
        first, *others = self.contact_responses
        if not others:
            x, y = first.bore_responses
            return self._tool_terms(x), self._tool_terms(y)
        (x, across), (y, up) = first.bore_responses, others[0].bore_responses
        way = 0.5 * second_motion_sign(self.case.setup.mechanism)
        mirrored = -1.0 if others[0].designs.sense != first.designs.sense else 1.0
        return self._tool_terms(x * 0.5 - y * way), self._tool_terms(across * 0.5 - up * (mirrored * way))

    def _error_responses(self, key: str) -> Iterator[FloatArray]:
        """To each error that a tolerance is of."""
        if len(self.contact_responses) == 1:
            yield self._tool_terms(self.contact_responses[0].number_response(key))
            return
        for at in errors_by_contact(self.case.setup.mechanism, key).values():
            yield self._tool_terms(self._half_difference(at))

    def _half_difference(self, at: ErrorAtContacts) -> Series:
        """Half of the difference of both contacts."""
        sides = 1.0, -second_motion_sign(self.case.setup.mechanism)
        parts = [
            answers.number_response(own[0]) * (0.5 * side * own[1])
            for answers, own, side in zip(self.contact_responses, at, sides, strict=True)
            if own is not None
        ]
        return parts[0] if len(parts) == 1 else parts[0] + parts[1]

    @cached_property
    def _train_ratio(self) -> Series | None:
        train = self.case.setup.train
        return None if train is None else train_ratio_series(train, self.case.programme, self.angles)

    def _tool_terms(self, found: Series) -> FloatArray:
        return self._derivative_terms(found if self._train_ratio is None else found * self._train_ratio)

    def _derivative_terms(self, found: Series) -> FloatArray:
        return series_derivatives(found, (len(self.case.designs), self.angles.shape[-1]), self.orders)


def _designs_by_row(designs: Designs) -> Designs:
    """Designs each in a row of its own."""
    return designs.with_values({name: each[:, None] for name, each in designs.values.items()})


def _band_bounds(answer: FloatArray, band: ErrorBand) -> ResponseBounds:
    ends = answer * band.low, answer * band.high
    return ResponseBounds(np.minimum(*ends), np.maximum(*ends))


def largest_errors(case: EvaluationBlock, orders: Sequence[int]) -> FloatArray:
    """The largest errors of position, velocity and acceleration, (orders, designs), mm (rad) by powers of rad."""
    count = len(case.designs)
    some = (np.arange(first, min(first + ERROR_BLOCK, count)) for first in range(0, count, ERROR_BLOCK))
    found = [_largest_in_block(replace(case, designs=case.designs.take(each)), orders) for each in some]
    return np.concatenate([np.zeros((len(orders), 0)), *found], axis=1)


def dwell_errors(case: EvaluationBlock) -> FloatArray:
    """The largest change of the position in a dwell of the tool, (designs,), mm (rad)."""
    found = [np.zeros(len(case.designs))]
    for stroke in case.programme.tool.dwells:
        middle = np.array([stroke.start + 0.5 * stroke.angle])
        found.append(ToolErrorModel(case, middle).dwell_change(stroke.angle))
    return np.asarray(np.max(found, axis=0))


def _worst_errors(case: EvaluationBlock, angles: FloatArray, orders: int) -> FloatArray:
    """(orders, designs, angles)."""
    every = [*ToolErrorModel(case, angles, orders).error_bounds()]
    return np.maximum(-sum(each.lower for each in every), sum(each.upper for each in every))


def _largest_in_block(case: EvaluationBlock, orders: Sequence[int]) -> FloatArray:
    nodes = _panel_angles(case)
    every = _worst_errors(case, nodes, 1 + max(orders))
    found = every.max(axis=2)
    for order in orders:
        if np.isfinite(every[order]).all():
            np.maximum(found[: order + 1], _refine_peaks(case, nodes, every, order), out=found[: order + 1])
    return np.asarray(_mark_impulses(case, found)[[*orders]])


def _refine_peaks(case: EvaluationBlock, nodes: FloatArray, every: FloatArray, order: int) -> FloatArray:
    """The largest of orders up to one, closer and closer about the highest of it."""
    values, found, rows = every[order], every[: order + 1].max(axis=2), np.arange(len(case.designs))[:, None]
    rising = values >= np.roll(values, 1, axis=1)
    tops = np.where(rising & (values >= np.roll(values, -1, axis=1)), values, -inf)
    places = np.argpartition(-tops, ZOOMED_PEAKS - 1, axis=1)[:, :ZOOMED_PEAKS]
    low, high = nodes[np.maximum(places - 1, 0)], nodes[np.minimum(places + 1, nodes.size - 1)]
    for _ in range(ZOOM_ROUNDS):
        angles = low[..., None] + (high - low)[..., None] * np.linspace(0.0, 1.0, ZOOM_ANGLES)
        here = _worst_errors(case, angles.reshape(len(rows), -1), order + 1).reshape(-1, *angles.shape)
        found = np.maximum(found, here.max(axis=(2, 3)))
        ends = (np.clip(here[order].argmax(axis=2) + side, 0, ZOOM_ANGLES - 1) for side in (-1, 1))
        low, high = (angles[rows, np.arange(ZOOMED_PEAKS), end] for end in ends)
    return np.asarray(found)


def _mark_impulses(case: EvaluationBlock, found: FloatArray) -> FloatArray:
    """Infinite where an error, or a slope of it, jumps: the largest of some orders, (orders, designs)."""
    places, turn = np.array([jump.at for jump in case.programme.jumps]), case.programme.strokes[-1].end
    if not places.size:
        return found
    before, after = (
        [*ToolErrorModel(case, np.mod(places + side, turn), len(found)).error_bounds()]
        for side in (-JUMP_SIDE, JUMP_SIDE)
    )
    for left, right in zip(before, after, strict=True):
        for order in range(len(found) - 1):
            with np.errstate(invalid="ignore"):
                apart = [np.abs(a[order] - b[order]).max(axis=1) for a, b in zip(left, right, strict=True)]
            found[order + 1 :, np.max(apart, axis=0) > JUMP_TOLERANCE * found[order]] = inf
    return found


def _panel_angles(case: EvaluationBlock) -> FloatArray:
    """Cam angles on every panel of the motion, on both sides of each jump, in the order of the turn."""
    table: Any = case.programme.table
    half = table.half_width[:, None]
    inner = np.clip(np.linspace(-1.0, 1.0, ERROR_NODES) * half, JUMP_SIDE - half, half - JUMP_SIDE)
    return np.asarray((table.centre[:, None] + inner).ravel())

"""Largest errors of the motion for which there is no curve: with two contacts, or through any train.

The errors are of first order, as those of curves (``effects.motion_errors``). The tool responds to each error with
a factor c (``effects.error_response``); behind a train it is f'·c, and for a number p of the train ∂f/∂p. At each
cam angle the error is at most Σ c·t. It is computed at many angles of the turn, and more and more closely about the
highest. At a jump of the motion the errors on both sides are compared; if an error jumps, its slope is an impulse.

A profile within its zone adds at most ``error_response.largest_error_by_profile_zone``. A bore with the
eccentricity ε adds ε·√(a² + b²) with its two responses a and b, or with their derivatives.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from math import inf, pi, sin
from operator import add
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series
from camopt.model.effects.effect import EvaluationBlock
from camopt.model.effects.effect_numbers import ErrorBand, ToleranceBands
from camopt.model.effects.error_response import (
    ContactResponse,
    contact_responses,
    errors_at_contacts_by_key,
    largest_error_by_profile_zone,
    second_contact_motion_error_sign,
    series_derivatives,
    tool_response_to_train_error,
)
from camopt.model.motion.programme import JUMP_SIDE
from camopt.model.motion.tool_drive import train_ratio_series

ERROR_NODES = 8
"""Cam angles on each panel of the motion."""
ZOOMED_PEAKS, ZOOM_ROUNDS, ZOOM_ANGLES = 3, 4, 17
"""Number of highest places that are refined, of refinements, and of angles in each."""
ERROR_BLOCK = 64
"""Number of designs that are computed together."""
JUMP_TOLERANCE = 1e-9
"""Share of the turn's largest error: errors on both sides of a jump that differ by less are the same."""


class ResponseBounds(NamedTuple):
    """Bounds of the effect of one error on the motion, (orders, designs, angles)."""

    lower: FloatArray
    upper: FloatArray


@dataclass(frozen=True)
class ToolErrorModel:
    """The errors of the tool of a block's designs at cam angles, (designs, angles) or one row for all."""

    case: EvaluationBlock
    angles: FloatArray
    orders: int = 1
    """Number of derivatives, the displacement included."""

    @cached_property
    def contact_responses(self) -> list[ContactResponse]:
        """The responses at the follower's contacts, each for the motion at that contact."""
        setup, designs = self.case.setup, self.case.designs.as_columns()
        return contact_responses(setup, designs, self.case.programme, self.angles, self.orders)

    @property
    def tolerance_bands(self) -> ToleranceBands:
        assert self.case.setup.errors is not None
        return self.case.setup.errors

    def tool_error_bounds_by_error(self) -> Iterator[ResponseBounds]:
        """The bounds of the effect of each error."""
        for key, band in self.tolerance_bands.bands_by_key.items():
            yield from (
                _response_bounds_within_band(response, band) for response in self._tool_responses_to_tolerance(key)
            )
        for band, varied in self.tolerance_bands.links.values():
            train, programme = self.case.setup.train, self.case.programme
            assert train is not None
            yield _response_bounds_within_band(
                self._response_derivatives(tool_response_to_train_error(varied, train, programme, self.angles)),
                band,
            )
        if self.tolerance_bands.profile:
            for response in self._tool_responses_to_tolerance("profile"):
                most = largest_error_by_profile_zone(
                    response, self.tolerance_bands.profile, self.tolerance_bands.waves
                )
                yield ResponseBounds(-most, most)
        if self.tolerance_bands.bore:
            most = self.tolerance_bands.bore * np.hypot(*self.bore_responses_in_two_directions)
            yield ResponseBounds(-most, most)

    def largest_dwell_position_change(self, dwell_length: float) -> FloatArray:
        """Largest motion of the tool in a dwell of a length [rad], whose middle is the model's cam angle."""
        bands, change = self.tolerance_bands, 0.0
        if bands.profile:
            waves = sin(min(0.5 * dwell_length * (bands.waves or inf), 0.5 * pi))
            responses = sum(np.abs(response[0]) for response in self._tool_responses_to_tolerance("profile"))
            change = change + 2.0 * bands.profile * waves * responses
        if bands.bore:
            turn = sin(min(0.5 * dwell_length, 0.5 * pi))
            change = change + 2.0 * bands.bore * turn * np.hypot(*self.bore_responses_in_two_directions)[0]
        return np.asarray(change + np.zeros((len(self.case.designs), 1)))[:, 0]

    @property
    def bore_responses_in_two_directions(self) -> tuple[FloatArray, FloatArray]:
        """Responses to a bore with an eccentricity, in two directions that turn with the cam."""
        first, *others = self.contact_responses
        if not others:
            x, y = first.bore_responses_in_two_directions
            return self._tool_response_derivatives(x), self._tool_response_derivatives(y)
        (x, across), (y, up) = first.bore_responses_in_two_directions, others[0].bore_responses_in_two_directions
        way = 0.5 * second_contact_motion_error_sign(self.case.setup.mechanism)
        mirrored = -1.0 if others[0].designs.sense != first.designs.sense else 1.0
        return self._tool_response_derivatives(x * 0.5 - y * way), self._tool_response_derivatives(
            across * 0.5 - up * (mirrored * way)
        )

    def _tool_responses_to_tolerance(self, tolerance_key: str) -> Iterator[FloatArray]:
        """Responses to the errors of one tolerance."""
        if len(self.contact_responses) == 1:
            yield self._tool_response_derivatives(self.contact_responses[0].response_to_error(tolerance_key))
            return
        sides = 1.0, -second_contact_motion_error_sign(self.case.setup.mechanism)
        for error in errors_at_contacts_by_key(self.case.setup.mechanism, tolerance_key).values():
            parts = [
                responses.response_to_error(signed_key[0]) * (0.5 * side * signed_key[1])
                for responses, signed_key, side in zip(self.contact_responses, error, sides, strict=True)
                if signed_key is not None
            ]
            yield self._tool_response_derivatives(reduce(add, parts))  # half the difference of both contacts

    @cached_property
    def _train_ratio(self) -> Series | None:
        train = self.case.setup.train
        return None if train is None else train_ratio_series(train, self.case.programme, self.angles)

    def _tool_response_derivatives(self, response: Series) -> FloatArray:
        return self._response_derivatives(response if self._train_ratio is None else response * self._train_ratio)

    def _response_derivatives(self, response: Series) -> FloatArray:
        return series_derivatives(response, (len(self.case.designs), self.angles.shape[-1]), self.orders)


def _response_bounds_within_band(response: FloatArray, band: ErrorBand) -> ResponseBounds:
    ends = response * band.low, response * band.high
    return ResponseBounds(np.minimum(*ends), np.maximum(*ends))


def largest_tool_errors(case: EvaluationBlock, orders: Sequence[int]) -> FloatArray:
    """Largest errors of position, velocity and acceleration, (orders, designs) [mm or rad per radⁿ]."""
    count = len(case.designs)
    blocks = (np.arange(first, min(first + ERROR_BLOCK, count)) for first in range(0, count, ERROR_BLOCK))
    errors = [_largest_errors_in_block(replace(case, designs=case.designs.take(block)), orders) for block in blocks]
    return np.concatenate([np.zeros((len(orders), 0)), *errors], axis=1)


def largest_dwell_position_changes(case: EvaluationBlock) -> FloatArray:
    """Largest change of the tool's position in a dwell, (designs,) [mm or rad]."""
    changes = [np.zeros(len(case.designs))]
    for stroke in case.programme.tool.dwells:
        middle = np.array([stroke.start + 0.5 * stroke.angle])
        changes.append(ToolErrorModel(case, middle).largest_dwell_position_change(stroke.angle))
    return np.asarray(np.max(changes, axis=0))


def _worst_errors_at_angles(case: EvaluationBlock, angles: FloatArray, order_count: int) -> FloatArray:
    """Largest magnitudes of the errors at cam angles, (orders, designs, angles)."""
    bounds = [*ToolErrorModel(case, angles, order_count).tool_error_bounds_by_error()]
    return np.maximum(-sum(each.lower for each in bounds), sum(each.upper for each in bounds))


def _largest_errors_in_block(case: EvaluationBlock, orders: Sequence[int]) -> FloatArray:
    nodes = case.programme.panel_angles(ERROR_NODES)
    errors = _worst_errors_at_angles(case, nodes, 1 + max(orders))
    largest = errors.max(axis=2)
    for order in orders:
        if np.isfinite(errors[order]).all():
            np.maximum(
                largest[: order + 1], _refine_largest_errors(case, nodes, errors, order), out=largest[: order + 1]
            )
    return np.asarray(_with_infinite_errors_past_jump_order(case, largest)[[*orders]])


def _refine_largest_errors(case: EvaluationBlock, nodes: FloatArray, errors: FloatArray, order: int) -> FloatArray:
    """Largest errors of orders up to one, refined about the highest places of that order."""
    values, largest, rows = errors[order], errors[: order + 1].max(axis=2), np.arange(len(case.designs))[:, None]
    rising = values >= np.roll(values, 1, axis=1)
    tops = np.where(rising & (values >= np.roll(values, -1, axis=1)), values, -inf)
    places = np.argpartition(-tops, ZOOMED_PEAKS - 1, axis=1)[:, :ZOOMED_PEAKS]
    low, high = nodes[np.maximum(places - 1, 0)], nodes[np.minimum(places + 1, nodes.size - 1)]
    for _ in range(ZOOM_ROUNDS):
        angles = low[..., None] + (high - low)[..., None] * np.linspace(0.0, 1.0, ZOOM_ANGLES)
        here = _worst_errors_at_angles(case, angles.reshape(len(rows), -1), order + 1).reshape(-1, *angles.shape)
        largest = np.maximum(largest, here.max(axis=(2, 3)))
        ends = (np.clip(here[order].argmax(axis=2) + side, 0, ZOOM_ANGLES - 1) for side in (-1, 1))
        low, high = (angles[rows, np.arange(ZOOMED_PEAKS), end] for end in ends)
    return np.asarray(largest)


def _with_infinite_errors_past_jump_order(case: EvaluationBlock, largest_errors: FloatArray) -> FloatArray:
    """Largest errors (orders, designs), infinite in the orders above one that jumps."""
    places, turn = np.array([jump.at for jump in case.programme.jumps]), case.programme.strokes[-1].end
    if not places.size:
        return largest_errors
    before, after = (
        [*ToolErrorModel(case, np.mod(places + side, turn), len(largest_errors)).tool_error_bounds_by_error()]
        for side in (-JUMP_SIDE, JUMP_SIDE)
    )
    for left, right in zip(before, after, strict=True):
        for order in range(len(largest_errors) - 1):
            with np.errstate(invalid="ignore"):
                jumps = [np.abs(a[order] - b[order]).max(axis=1) for a, b in zip(left, right, strict=True)]
            largest_errors[order + 1 :, np.max(jumps, axis=0) > JUMP_TOLERANCE * largest_errors[order]] = inf
    return largest_errors

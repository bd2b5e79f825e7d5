"""Loads of a design at given cam angles, for the effects that its scene needs."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from camopt.core.numerics import FloatArray, IntArray
from camopt.core.quantities import QUANTITIES
from camopt.model.effects.contacts import CONTACT_NAMES
from camopt.model.effects.force import CONTACT_FORCES
from camopt.show.drawing.loads import load_panels
from camopt.show.drawing.picture import Picture

PIECE_END_ANGLE = 1e-12  # rad: a closer angle counts as the end of a piece
PIECE_OFFSET = 1e-13  # rad: distance of samples from an angle between two pieces
LEAST_JUMP_SHARE = 1e-9  # share of the largest load: a smaller difference is no jump


@dataclass(frozen=True)
class _PictureAtAngles(Picture):
    """A picture with samples at given cam angles [deg], and in the middle of pieces without any."""

    degrees: FloatArray

    @cached_property
    def piece_boundaries(self) -> FloatArray:
        """Starts of the pieces, and the end of the turn [rad]."""
        table = self.problem.programme.table
        first = table.first_panel[:-1]
        return np.append(table.centre[first] - table.half_width[first], 2.0 * np.pi)

    @cached_property
    def sample_numbers_and_angles_by_piece(self) -> list[tuple[IntArray, FloatArray]]:
        """Samples of each piece: their numbers and cam angles [rad].

        An angle between two pieces, such as 0 and 360 deg, has a sample before it, at it and after it.
        """
        numbers, angles = np.tile(np.arange(self.degrees.size), 3), np.radians(self.degrees)
        repeated = np.concatenate([angles, angles + 2.0 * np.pi, angles - 2.0 * np.pi])
        pieces = []
        for start, end in pairwise(self.piece_boundaries):
            here = (repeated >= start - PIECE_END_ANGLE) & (repeated <= end + PIECE_END_ANGLE)
            first = here & (repeated <= start + PIECE_END_ANGLE)
            inside = np.clip(repeated[here], start + PIECE_OFFSET, end - PIECE_OFFSET)
            pieces.append(
                (
                    np.append(numbers[here], numbers[first]),
                    np.append(inside, np.full(np.count_nonzero(first), start)),
                )
            )
        return pieces

    @cached_property
    def angles_of_pieces(self) -> list[FloatArray]:
        pieces = zip(self.sample_numbers_and_angles_by_piece, pairwise(self.piece_boundaries), strict=True)
        return [angles if angles.size else np.array([(start + end) / 2]) for (_, angles), (start, end) in pieces]


def loads_at(picture: Picture, degrees: FloatArray) -> dict[str, FloatArray]:
    """Loads by column, named as the quantity without "max" or "min": ``contact_force_N``, ``torque_N_m``, …

    A load that is infinite somewhere has no column. Columns of two contacts are ``first_…`` and ``second_…``. At a
    jump, the column has the side with the larger magnitude; the smaller value if the quantity is a minimum.
    """
    sampled = _PictureAtAngles(picture.scene, picture.problem, degrees)
    columns = dict[str, FloatArray]()
    for panel in load_panels(sampled, with_unusual_forces=True):
        # no quantity is the extreme of a force at one of two contacts
        quantity = panel.quantity or CONTACT_FORCES[0]
        name = load_column_name(quantity)
        rank = np.negative if "_min" in quantity else np.abs
        values = {name: panel.values}
        if panel.other is not None:
            names = [f"{place}_{name}" for place in CONTACT_NAMES]
            values = dict(zip(names, (panel.values, panel.other), strict=True))
        columns |= {name: _values_at_angles(sampled, each, rank) for name, each in values.items()}
    return columns


def _values_at_angles(
    sampled: _PictureAtAngles, values_by_piece: list[FloatArray], rank_function: np.ufunc
) -> FloatArray:
    """Values of pieces in the order of the given cam angles; the highest rank if an angle has several values."""
    samples = sampled.sample_numbers_and_angles_by_piece
    numbers = np.concatenate([numbers for numbers, _ in samples])
    loads = np.concatenate([v for v, (kept, _) in zip(values_by_piece, samples, strict=True) if kept.size])
    spans = zip(samples, pairwise(sampled.piece_boundaries), strict=True)
    beside_boundary = np.concatenate(
        [(a == start + PIECE_OFFSET) | (a == end - PIECE_OFFSET) for (_, a), (start, end) in spans]
    )
    ranks = rank_function(loads) - LEAST_JUMP_SHARE * np.abs(loads).max(initial=0.0) * beside_boundary
    order, values = np.argsort(ranks, kind="stable"), np.empty(sampled.degrees.size)
    values[numbers[order]] = loads[order]
    return values


def load_column_name(quantity: str) -> str:
    """The column of a load over the turn, by the quantity that is its extreme."""
    return quantity.replace("_max", "").replace("_min", "")


LOAD_COLUMNS = {load_column_name(name): quantity for name, quantity in QUANTITIES.items()}
"""Quantity of each column of loads."""

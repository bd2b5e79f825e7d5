"""The loads of a design at given cam angles, of the effects that its scene calls for."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.core.quantities import QUANTITIES, Quantity
from camopt.model.effects.contacts import CONTACT_NAMES
from camopt.model.effects.force import CONTACT_FORCES
from camopt.show.drawing.dynamics import dynamics_panels
from camopt.show.drawing.loads import load_panels
from camopt.show.drawing.picture import Picture

PIECE_END_ANGLE = 1e-12  # rad: an angle so near to the end of a piece is at it
PIECE_OFFSET = 1e-13  # rad: so far from an angle between two pieces are the samples beside it
LEAST_JUMP_SHARE = 1e-9  # of the largest load: what differs by less is no jump


@dataclass(frozen=True)
class _PictureAtAngles(Picture):
    """A picture whose samples are at given cam angles (deg), and one in the middle of each piece that has none."""

    degrees: FloatArray

    @cached_property
    def ends(self) -> FloatArray:
        """Where the pieces start, and the end of the turn, rad."""
        table = self.problem.programme.table
        first = table.first_panel[:-1]
        return np.append(table.centre[first] - table.half_width[first], 2.0 * np.pi)

    @cached_property
    def places(self) -> list[tuple[IntArray, FloatArray]]:
        """The samples of each piece: the number of each, and its cam angle (rad).

        An angle between two pieces, as 0 and 360 deg are, has a sample just before it, one at it and one after it.
        """
        numbers, angles = np.tile(np.arange(self.degrees.size), 3), np.radians(self.degrees)
        turned = np.concatenate([angles, angles + 2.0 * np.pi, angles - 2.0 * np.pi])
        found = []
        for start, end in pairwise(self.ends):
            here = (turned >= start - PIECE_END_ANGLE) & (turned <= end + PIECE_END_ANGLE)
            first = here & (turned <= start + PIECE_END_ANGLE)
            inside = np.clip(turned[here], start + PIECE_OFFSET, end - PIECE_OFFSET)
            found.append(
                (
                    np.append(numbers[here], numbers[first]),
                    np.append(inside, np.full(np.count_nonzero(first), start)),
                )
            )
        return found

    @property
    def is_beside(self) -> BoolArray:
        """The samples just before and after an angle between two pieces, of those of all pieces."""
        spans = zip(self.places, self.ends[:-1], self.ends[1:], strict=True)
        return np.concatenate(
            [(a == start + PIECE_OFFSET) | (a == end - PIECE_OFFSET) for (_, a), start, end in spans]
        )

    @cached_property
    def pieces(self) -> list[FloatArray]:
        middles = (self.ends[:-1] + self.ends[1:]) / 2
        return [
            angles if angles.size else np.array([middle])
            for (_, angles), middle in zip(self.places, middles, strict=True)
        ]


def loads_at(picture: Picture, degrees: FloatArray) -> dict[str, FloatArray]:
    """Columns by name, as the quantity without its extreme: ``contact_force_N``, ``torque_N_m``, …

    A load that is infinite somewhere has none. Those of two contacts are ``first_…`` and ``second_…``. Where a load
    jumps, the column has the side with the larger magnitude; of a quantity that is a least one, the smaller value.
    """
    sampled = _PictureAtAngles(picture.scene, picture.problem, degrees)
    columns = {}
    for panel in [*dynamics_panels(sampled), *load_panels(sampled, every=True)]:
        # the extremes of a force that two contacts share are no quantities
        quantity = panel.quantity or CONTACT_FORCES[0]
        name = load_column(quantity)
        rank = np.negative if "_min" in quantity else np.abs
        if panel.other is None:
            columns[name] = _values_at_angles(sampled, panel.values, rank)
        else:
            both = zip(CONTACT_NAMES, (panel.values, panel.other), strict=True)
            columns |= {f"{place}_{name}": _values_at_angles(sampled, values, rank) for place, values in both}
    return columns


def _values_at_angles(sampled: _PictureAtAngles, pieces: list[FloatArray], rank: np.ufunc) -> FloatArray:
    """Values piece by piece at the given cam angles, in their order; of an angle with several the highest rank."""
    numbers = np.concatenate([numbers for numbers, _ in sampled.places])
    found = np.concatenate([v for v, (own, _) in zip(pieces, sampled.places, strict=True) if own.size])
    ranks = rank(found) - LEAST_JUMP_SHARE * np.abs(found).max(initial=0.0) * sampled.is_beside
    order, values = np.argsort(ranks, kind="stable"), np.empty(sampled.degrees.size)
    values[numbers[order]] = found[order]
    return values


def load_quantity(column: str) -> Quantity | None:
    """The quantity behind a column of loads, at whichever contact; None if it is none."""
    return LOAD_COLUMNS.get(column) or LOAD_COLUMNS.get(column.partition("_")[2])


def load_column(quantity: str) -> str:
    """The column of a load along the turn, by the quantity that is an extreme of it."""
    return quantity.replace("_max", "").replace("_min", "")


LOAD_COLUMNS = {load_column(name): quantity for name, quantity in QUANTITIES.items()}
"""The quantity behind each column."""

"""The loads of a design at given cam angles, of the effects that its scene calls for."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from camopt.drawing.dynamics import dynamics_panels
from camopt.drawing.loads import load_panels
from camopt.drawing.picture import Picture
from camopt.effects.contacts import PLACES
from camopt.effects.force import CONTACT
from camopt.numerics import FloatArray
from camopt.quantities import QUANTITIES, Quantity


@dataclass(frozen=True)
class _Sampled(Picture):
    """A picture whose samples are at given cam angles (deg), and one in the middle of each piece that has none."""

    degrees: FloatArray

    @cached_property
    def ends(self) -> FloatArray:
        """Where the pieces start, and the end of the turn, rad."""
        table = self.problem.programme.table
        first = table.first_panel[:-1]
        return np.append(table.centre[first] - table.half_width[first], 2.0 * np.pi)

    @cached_property
    def piece(self) -> FloatArray:
        """The piece of each angle; at a jump the one after it."""
        found = np.searchsorted(self.ends, np.radians(self.degrees) + 1e-12, side="right") - 1
        return np.asarray(np.clip(found, 0, self.ends.size - 2))

    @cached_property
    def pieces(self) -> list[FloatArray]:
        spans = zip(self.ends[:-1], self.ends[1:], strict=True)
        here = [np.radians(self.degrees[self.piece == k]) for k in range(self.ends.size - 1)]
        return [
            np.clip(own, a, b) if own.size else np.array([(a + b) / 2])
            for own, (a, b) in zip(here, spans, strict=True)
        ]


def loads_at(picture: Picture, degrees: FloatArray) -> dict[str, FloatArray]:
    """Columns by name, as the quantity without its extreme: ``contact_force_N``, ``torque_N_m``, …

    A load that is infinite somewhere has none. Those of two contacts are ``first_…`` and ``second_…``.
    """
    sampled = _Sampled(picture.scene, picture.problem, degrees)
    columns = {}
    for panel in [*dynamics_panels(sampled), *load_panels(sampled, every=True)]:
        # the extremes of a force that two contacts share are no quantities
        name = load_column(panel.quantity or CONTACT[0])
        if panel.other is None:
            columns[name] = _at_angles(sampled, panel.values)
        else:
            both = zip(PLACES, (panel.values, panel.other), strict=True)
            columns |= {f"{place}_{name}": _at_angles(sampled, values) for place, values in both}
    return columns


def _at_angles(sampled: _Sampled, pieces: list[FloatArray]) -> FloatArray:
    """Values piece by piece at the given cam angles, in their order."""
    values = np.empty(sampled.degrees.size)
    for k, found in enumerate(pieces):
        here = sampled.piece == k
        values[here] = found if here.any() else 0.0
    return values


def load_of(column: str) -> Quantity | None:
    """The quantity behind a column of loads, at whichever contact; None if it is none."""
    return LOAD_COLUMNS.get(column) or LOAD_COLUMNS.get(column.partition("_")[2])


def load_column(quantity: str) -> str:
    """The column of a load along the turn, by the quantity that is an extreme of it."""
    return quantity.replace("_max", "").replace("_min", "")


LOAD_COLUMNS = {load_column(name): quantity for name, quantity in QUANTITIES.items()}
"""The quantity behind each column."""

"""The second half of a turn in a yoke, from the first: y(θ + π) = h − y(θ) (``mechanisms.pairs``).

Half a turn later, a rise is a return with the same law. A position p becomes s − p. Here s is the sum of the lowest
and the highest position of the first half, or its only position; any s would do. Moves with a law of positions have
no second half.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from camopt.core.quantities import DERIVATIVE_UNITS
from camopt.model.mechanisms.elements import DRIVES
from camopt.scene.law_forms import NEAR_END
from camopt.scene.mapping import finite_number_or_none, tables_in_list, value_at_key

OPPOSITE_KIND = {"rise": "return", "return": "rise"}


def append_second_half_turn(data: dict[str, Any]) -> None:
    """Append the second half of the turn if the segments of a yoke cover half a turn, in ``data`` itself."""
    drive, rows = DRIVES.get(value_at_key(data, "drive.kind")), tables_in_list(data.get("motion"))
    angles = [finite_number_or_none(row.get("angle")) for row in rows]
    known = [angle for angle in angles if angle is not None]
    if drive is None or not drive.one_disc or len(known) < len(rows):
        return
    if abs(sum(known) - 180.0) <= 180.0 * NEAR_END:
        given = [end for row in rows for end in _range_numbers(row.get("to"))]
        total = min(given) + max(given) if len({*given}) > 1 else sum({*given})
        data["motion"] = [*rows, *(_opposite_segment(row, total) for row in rows)]


def _opposite_segment(row: Mapping[str, Any], sum_of_opposite_positions: float) -> dict[str, Any]:
    """The segment half a turn later, with the opposite motion."""
    found = {**row, "segment": OPPOSITE_KIND.get(row.get("segment", ""), row.get("segment"))}
    found |= {
        key: _opposite_value(sum_of_opposite_positions, row[key]) for key in ("to",) if row.get(key) is not None
    }
    found |= {key: _opposite_value(0.0, row[key]) for key in DERIVATIVE_UNITS if row.get(key) is not None}
    if row.get("through"):
        found["through"] = [_opposite_condition(each, sum_of_opposite_positions) for each in row["through"]]
    return found


def _opposite_condition(condition: Mapping[str, Any], sum_of_opposite_positions: float) -> dict[str, Any]:
    """The condition within a move half a turn later."""
    sums = {"angle": None, "position": sum_of_opposite_positions}
    return {
        key: _opposite_value(sums.get(key, 0.0), value) for key, value in condition.items() if value is not None
    }


def _opposite_value(sum_of_opposite_values: float | None, value: Any) -> Any:
    """``sum_of_opposite_values`` less a number or a range; without a total, a cam angle half a turn later."""
    if isinstance(value, Sequence) and not isinstance(value, str):
        ends = [_opposite_value(sum_of_opposite_values, end) for end in value]
        return ends if sum_of_opposite_values is None else ends[::-1]
    number = finite_number_or_none(value)
    return (
        value
        if number is None
        else number + 180.0
        if sum_of_opposite_values is None
        else sum_of_opposite_values - number
    )


def _range_numbers(value: Any) -> list[float]:
    """The numbers of a number or a range."""
    each = value if isinstance(value, (list, tuple)) else [value]
    return [number for end in each if (number := finite_number_or_none(end)) is not None]

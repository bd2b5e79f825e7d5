"""The second half of a turn in a yoke, from the first: y(θ + π) = h − y(θ) (``mechanisms.pairs``).

A rise is a return half a turn later, with the same law. Positions p are s − p there, whatever the sum s is: here
that of the lowest and the highest position of the first half, or its only one. A law of positions has no such other
half: moves have none of their own here.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from camopt.core.quantities import DERIVATIVES
from camopt.model.mechanisms.elements import DRIVES
from camopt.scene.law_forms import NEAR_END
from camopt.scene.mapping import at, number_of, segments

OTHER_WAY = {"rise": "return", "return": "rise"}


def read_half(data: dict[str, Any]) -> None:
    """Put the second half of a turn behind the first, where a yoke is given half a turn, in ``data`` itself."""
    drive, rows = DRIVES.get(at(data, "drive.kind")), segments(data)
    angles = [number_of(row.get("angle")) for row in rows]
    known = [angle for angle in angles if angle is not None]
    if drive is None or not drive.one_disc or len(known) < len(rows):
        return
    if abs(sum(known) - 180.0) <= 180.0 * NEAR_END:
        given = [end for row in rows for end in _ends(row.get("to"))]
        total = min(given) + max(given) if len({*given}) > 1 else sum({*given})
        data["motion"] = [*rows, *(_half_a_turn_later(row, total) for row in rows)]


def _half_a_turn_later(row: Mapping[str, Any], total: float) -> dict[str, Any]:
    """A segment that moves as much the other way."""
    found = {**row, "segment": OTHER_WAY.get(row.get("segment", ""), row.get("segment"))}
    found |= {key: _from(total, row[key]) for key in ("to",) if row.get(key) is not None}
    found |= {key: _from(0.0, row[key]) for key in DERIVATIVES if row.get(key) is not None}
    if row.get("through"):
        found["through"] = [_later(each, total) for each in row["through"]]
    return found


def _later(condition: Mapping[str, Any], total: float) -> dict[str, Any]:
    """A condition on the way of a move half a turn later."""
    sums = {"angle": None, "position": total}
    return {key: _from(sums.get(key, 0.0), value) for key, value in condition.items() if value is not None}


def _from(total: float | None, value: Any) -> Any:
    """What a number or a range is taken from a sum; without one it is half a turn later."""
    if isinstance(value, Sequence) and not isinstance(value, str):
        ends = [_from(total, end) for end in value]
        return ends if total is None else ends[::-1]
    number = number_of(value)
    return value if number is None else number + 180.0 if total is None else total - number


def _ends(value: Any) -> list[float]:
    """The numbers of a number or a range."""
    each = value if isinstance(value, (list, tuple)) else [value]
    return [number for end in each if (number := number_of(end)) is not None]

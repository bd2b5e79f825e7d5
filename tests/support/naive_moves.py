"""Turns with moves at 50 digits: each run of moves as the spline that its conditions and the least jerk make of it.

Beside ``naive.py``, and like it independent of the package. Where a derivative at a joint is not given, the least
∫ (y⁽ᵏ⁾)² has natural conditions there: with k = 3 a free acceleration makes the jerk continuous, a free velocity
the fourth derivative. These, and what is given, are one linear system in the powers of all polynomials.
"""

from functools import cache
from itertools import pairwise, product
from typing import Any

from mpmath import mp

from support.naive import Piece, Scene, law_pieces, stroke

DERIVATIVES = ("velocity", "acceleration", "jerk")
JOINING = ("move", "constant-velocity")


def derivative_factor(segment: Scene, rpm: Any) -> Any:
    """What a derivative of the first order is multiplied by, to be one by the cam angle in rad."""
    return {"rad": mp.mpf(1), "deg": 180 / mp.pi, "s": 30 / (mp.pi * mp.mpf(rpm or 1))}[segment.get("per", "rad")]


def programme(motion: list[Scene], rpm: Any = None, oscillating: bool = False) -> list[Piece]:
    """The smooth pieces of a turn whose positions are given, from theta = 0; y from its lowest, in mm or rad."""
    spans, ends = angles_of(motion), positions(motion, rpm)
    pieces: list[Piece] = []
    for run in runs(motion):
        pieces += best_of(motion, run, spans, ends, rpm)
    for k, segment in enumerate(motion):
        (start, end), (low, high) = spans[k], (ends[k - 1], ends[k])
        if segment["segment"] == "dwell":
            pieces.append(Piece(start, end, "dwell", lambda theta, y=low: (y, 0 * y, 0 * y, 0 * y)))
        elif segment["segment"] == "constant-velocity":
            v = (high - low) / (end - start)
            pieces += split(start, end, [low, v])
        elif segment["segment"] != "move":
            b = end - start
            for x0, x1, jet in law_pieces(segment["law"]):
                shape = stroke(jet, start, b, low, high - low)
                pieces.append(Piece(start + x0 * b, start + x1 * b, segment["segment"], shape))
    pieces.sort(key=lambda piece: piece.start)
    lowest = min(piece.jet(at)[0] for piece in pieces for at in (piece.start, piece.end))
    unit = mp.pi / 180 if oscillating else mp.mpf(1)
    return [Piece(p.start, p.end, p.kind, shift_and_scale(p.jet, lowest, unit)) for p in pieces]


def rough(pieces: list[Piece]) -> list[Piece]:
    """The same pieces for plain floats, each looked at once at the same angle."""

    def as_floats(jet: Any) -> Any:
        return cache(lambda theta: tuple(float(value) for value in jet(theta)))

    return [Piece(float(p.start), float(p.end), p.kind, as_floats(p.jet)) for p in pieces]


def shift_and_scale(jet: Any, lowest: Any, unit: Any) -> Any:
    def lowered_motion(theta: Any) -> Any:
        y, *rest = jet(theta)
        return tuple(value * unit for value in (y - lowest, *rest))

    return lowered_motion


def angles_of(motion: list[Scene]) -> list[tuple[Any, Any]]:
    turned = [mp.mpf(0)]
    for segment in motion:
        turned.append(turned[-1] + mp.mpf(segment["angle"]) * mp.pi / 180)
    return list(pairwise(turned))


def positions(motion: list[Scene], rpm: Any) -> list[Any]:
    """Where each segment ends; the first starts where the last ends."""
    ends: list[Any] = [None if isinstance(s.get("to"), list | None) else mp.mpf(s["to"]) for s in motion]
    for _ in motion:  # each pass knows one more, forwards or backwards
        for k, segment in enumerate(motion):
            change = None
            if segment["segment"] == "dwell":
                change = mp.mpf(0)
            elif segment["segment"] == "constant-velocity" and segment.get("velocity") is not None:
                change = (
                    mp.mpf(segment["velocity"])
                    * derivative_factor(segment, rpm)
                    * mp.mpf(segment["angle"])
                    * mp.pi
                    / 180
                )
            elif segment["segment"] in ("rise", "return") and segment.get("lift"):
                change = mp.mpf(segment["lift"]) * (1 if segment["segment"] == "rise" else -1)
            if change is not None and ends[k] is None and ends[k - 1] is not None:
                ends[k] = ends[k - 1] + change
            if change is not None and ends[k - 1] is None and ends[k] is not None:
                ends[k - 1] = ends[k] - change
    return ends


def runs(motion: list[Scene]) -> list[list[int]]:
    """Moves that follow each other, round the turn; a turn of moves alone is not asked for."""
    found: list[list[int]] = []
    for k, segment in enumerate(motion):
        if segment["segment"] == "move" and motion[k - 1]["segment"] != "move":
            found.append([k])
            while motion[(found[-1][-1] + 1) % len(motion)]["segment"] == "move":
                found[-1].append((found[-1][-1] + 1) % len(motion))
    return found


def motion_beside_move(motion: list[Scene], k: int, spans: Any, ends: Any, first: bool) -> list[Any]:
    """y', y'', y''' where a segment that is no move starts, or where it ends."""
    segment, (start, end) = motion[k], spans[k]
    if segment["segment"] == "dwell":
        return [mp.mpf(0)] * 3
    b, h = end - start, ends[k] - ends[k - 1]
    if segment["segment"] == "constant-velocity":
        return [h / b, mp.mpf(0), mp.mpf(0)]
    pieces = law_pieces(segment["law"])
    jet = pieces[0][2](mp.mpf(0)) if first else pieces[-1][2](mp.mpf(1))
    return [h * jet[n] / b**n for n in (1, 2, 3)]


def best_of(motion: list[Scene], run: list[int], spans: Any, ends: Any, rpm: Any) -> list[Piece]:
    """Each range of a run as free, or as an end of it: of all that keep the ranges, that of the least integral."""
    ranged = [(i, key) for i in run for key in ("to", *DERIVATIVES) if isinstance(motion[i].get(key), list)]
    found: list[tuple[Any, list[list[Piece]]]] = []
    for choice in product((None, 0, 1), repeat=len(ranged)):
        rows = [dict(segment) for segment in motion]
        for (i, key), side in zip(ranged, choice, strict=True):
            rows[i][key] = None if side is None else motion[i][key][side]
        tops = list(ends)
        for i, key in ranged:
            tops[i] = mp.mpf(rows[i]["to"]) if key == "to" and rows[i]["to"] is not None else tops[i]
        powers, order = solve_moves(rows, run, spans, tops, rpm)
        if all(stays_in_range(motion[i], key, powers[run.index(i)], spans[i], rpm) for i, key in ranged):
            squares = sum(square(p, order, spans[i]) for p, i in zip(powers, run, strict=True))
            found.append((squares, [split(*spans[i], p) for p, i in zip(powers, run, strict=True)]))
    return [piece for pieces in min(found, key=lambda each: each[0])[1] for piece in pieces]


def stays_in_range(segment: Scene, key: str, powers: list[Any], span: Any, rpm: Any) -> bool:
    """Whether a polynomial ends within a range."""
    order = ("to", *DERIVATIVES).index(key)
    value = curve(span[0], powers)(span[1])[order] / derivative_factor(segment, rpm) ** order
    low, high = map(mp.mpf, segment[key])
    return low - mp.mpf(10) ** -30 <= value <= high + mp.mpf(10) ** -30


def square(powers: list[Any], order: int, span: Any) -> Any:
    """∫ (p⁽ᵏ⁾)² over a move, term by term."""
    tops = [mp.ff(n, order) * c for n, c in enumerate(powers)][order:]
    b = span[1] - span[0]
    return sum(x * y * b ** (m + n + 1) / (m + n + 1) for m, x in enumerate(tops) for n, y in enumerate(tops))


def solve_moves(
    motion: list[Scene], run: list[int], spans: Any, ends: Any, rpm: Any
) -> tuple[list[list[Any]], int]:
    """The polynomials of a run of moves, in powers of the cam angle from the start of each; and k."""
    k = 4 if any(motion[i].get("jerk") is not None for i in run) else 3
    size = 2 * k
    rows: list[dict[int, Any]] = []
    right: list[Any] = []

    def powers(number: int, order: int, last: bool) -> dict[int, Any]:
        """A derivative at an end of a move, as factors of the unknown powers."""
        start, end = spans[run[number]]
        x = end - start if last else mp.mpf(0)
        return {number * size + n: mp.ff(n, order) * x ** (n - order) for n in range(order, size)}

    def ask(factors: dict[int, Any], value: Any) -> None:
        rows.append(factors)
        right.append(value)

    start = [ends[run[0] - 1], *motion_beside_move(motion, run[0] - 1, spans, ends, False)]
    after_run = (run[-1] + 1) % len(motion)
    finish = [ends[run[-1]], *motion_beside_move(motion, after_run, spans, ends, True)]
    for order in range(k):
        ask(powers(0, order, False), start[order])
    for number, i in enumerate(run):
        last = number == len(run) - 1
        for order in range(k):
            given = None if order == 0 else motion[i].get(DERIVATIVES[order - 1])
            wanted = None if given is None else mp.mpf(given) * derivative_factor(motion[i], rpm) ** order
            wanted = ends[i] if order == 0 else wanted
            if last:
                ask(powers(number, order, True), finish[order] if wanted is None else wanted)
                continue
            same = order if wanted is not None else 2 * k - 1 - order
            if wanted is not None:
                ask(powers(number, order, True), wanted)
            else:  # natural: the derivative that is dual to it is continuous
                ask(difference_of(powers(number, same, True), powers(number + 1, same, False)), mp.mpf(0))
            ask(difference_of(powers(number, order, True), powers(number + 1, order, False)), mp.mpf(0))
    found = unknowns(rows, right)
    return [found[number * size : (number + 1) * size] for number in range(len(run))], k


def unknowns(rows: list[dict[int, Any]], right: list[Any]) -> list[Any]:
    """The solution of a linear system, most of whose factors are 0, by Gauss's elimination with pivots."""
    rows, right = [dict(row) for row in rows], list(right)
    for k in range(len(rows)):
        pivot = max(range(k, len(rows)), key=lambda r: abs(rows[r].get(k, 0)))
        for each in (rows, right):
            each[k], each[pivot] = each[pivot], each[k]
        for row in range(k + 1, len(rows)):
            if k in rows[row]:
                factor = rows[row].pop(k) / rows[k][k]
                right[row] -= factor * right[k]
                for column, value in rows[k].items():
                    if column > k:
                        rows[row][column] = rows[row].get(column, 0) - factor * value
    found = [mp.mpf(0)] * len(rows)
    for k in reversed(range(len(rows))):
        rest = sum(value * found[column] for column, value in rows[k].items() if column > k)
        found[k] = (right[k] - rest) / rows[k][k]
    return found


def difference_of(one: dict[int, Any], other: dict[int, Any]) -> dict[int, Any]:
    return one | {at: -value for at, value in other.items()}


def split(start: Any, end: Any, powers: list[Any]) -> list[Piece]:
    """A polynomial cut where it turns back: rises, returns, or a dwell if it stays."""
    slopes = [n * c for n, c in enumerate(powers)][1:]
    if all(c == 0 for c in slopes):
        return [Piece(start, end, "dwell", curve(start, powers))]
    while slopes and slopes[-1] == 0:
        slopes.pop()
    roots = mp.polyroots(slopes, asc=True, maxsteps=500, extraprec=400) if len(slopes) > 1 else []
    tiny = mp.mpf(10) ** -20
    inside = sorted(r.real for r in map(mp.mpc, roots) if abs(r.imag) < tiny and tiny < r.real < end - start - tiny)
    pieces = []
    for low, high in pairwise([mp.mpf(0), *inside, end - start]):
        middle = curve(start, powers)(start + (low + high) / 2)[1]
        pieces.append(Piece(start + low, start + high, "rise" if middle > 0 else "return", curve(start, powers)))
    return pieces


def curve(start: Any, powers: list[Any]) -> Any:
    """The jet of a polynomial in powers of the cam angle from ``start``; of a float, as floats."""
    exact = [list(powers)]
    for _ in range(3):
        exact.append([n * c for n, c in enumerate(exact[-1])][1:] or [mp.mpf(0)])
    plain, first = [[float(c) for c in row] for row in exact], float(start)

    def jet(theta: Any) -> Any:
        rows, x = (plain, theta - first) if isinstance(theta, float) else (exact, theta - start)
        found = []
        for row in rows:
            value = 0 * x
            for c in reversed(row):
                value = value * x + c
            found.append(value)
        return tuple(found)

    return jet

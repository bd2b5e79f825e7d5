"""The ring of angles around the front view: strokes and dwells of the follower with their cam angles."""

from math import cos, pi

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.show.sheet.dimensions import angle_dimension
from camopt.show.sheet.marks import LARGE, MEDIUM, Marks, Words, line_mark, readable_direction, text_width

NAME_DISTANCE = 1.2  # mm from the ring to names along it
CROSS_NAME_DISTANCE = 6.0  # mm from the ring to names across it
NAME_STEP = 1.6  # distance of names across the ring, in letter heights
CROWDED_SHARE = 0.8  # share of the ring; if names across it need more, they are left out

RingSector = tuple[str, float, float]
"""A name with the start and end of its sector of the ring [rad]."""


def ring_marks(segments: list[RingSector], radius: float) -> Marks:
    """Dimension lines of angles, with names along the ring, or across it in short sectors."""
    marks: Marks = []
    crowded = []
    for name, begin, end in segments:
        marks += angle_dimension(radius, begin, end)
        middle = (begin + end) / 2
        room = abs(end - begin) * radius - 3.0
        height = next((h for h in (LARGE, MEDIUM) if text_width(name, h) <= room), None)
        if height is None:
            crowded.append((middle, name))
            continue
        turn = readable_direction(middle - pi / 2)
        inverted = cos(turn - (middle - pi / 2)) < 0.0
        foot = radius + NAME_DISTANCE + (height if inverted else 0.0)
        marks.append(Words(foot * np.exp(1j * middle), name, height, 0.5, turn, backed=True))
    foot = radius + CROSS_NAME_DISTANCE
    apart = NAME_STEP * MEDIUM / foot
    if not crowded or len(crowded) * apart > CROWDED_SHARE * 2 * pi:
        return marks
    names, wanted = sort_after_widest_gap(crowded)
    for name, was, turn in zip(names, wanted, spread_directions(wanted, apart), strict=True):
        reading = readable_direction(float(turn))
        at = foot * np.exp(1j * turn) - 1j * np.exp(1j * reading) * MEDIUM / 2
        marks += [
            line_mark(radius * np.exp(1j * was), (foot - 1.0) * np.exp(1j * turn)),
            Words(at, name, MEDIUM, 1.0 if cos(turn - reading) < 0.0 else 0.0, reading, backed=True),
        ]
    return marks


def sort_after_widest_gap(directions_and_names: list[tuple[float, str]]) -> tuple[list[str], FloatArray]:
    """Names sorted by direction [rad], beginning after the widest gap."""
    ordered = sorted((turn % (2 * pi), name) for turn, name in directions_and_names)
    turns = np.array([turn for turn, _ in ordered])
    first = int(np.argmax(np.diff(turns, prepend=turns[-1] - 2 * pi)))
    turns = np.roll(turns, -first)
    return [name for _, name in ordered[first:] + ordered[:first]], turns + 2 * pi * (turns < turns[0])


def spread_directions(wanted_directions: FloatArray, least_angle: float) -> FloatArray:
    """Rising directions at least ``least_angle`` from each other, as near to the wanted ones as possible.

    Those that would be too near to each other share the mean of what they want (pool adjacent violators).
    """
    pools: list[tuple[float, int]] = []  # mean preferred direction of the first name, and number of names
    for value in wanted_directions - least_angle * np.arange(wanted_directions.size):
        pools.append((float(value), 1))
        while len(pools) > 1 and pools[-1][0] < pools[-2][0]:
            (b, m), (a, n) = pools.pop(), pools.pop()
            pools.append(((a * n + b * m) / (n + m), n + m))
    means = np.concatenate([np.full(n, mean) for mean, n in pools])
    return np.asarray(means + least_angle * np.arange(wanted_directions.size))

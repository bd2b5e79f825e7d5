"""The stations of a construction: numbered cam angles at which the displacement is set off.

Each stroke is divided into equal parts. Stations are 1, 2, 3 … on the first stroke, 0′, 1′, 2′ … on the second, and
so on. Letters name the same points on the curves. Dwells have stations only at their ends.
"""

from functools import cached_property
from itertools import count, pairwise
from math import degrees, pi
from typing import NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.model.motion.stroke import DWELL, Stroke
from camopt.show.drawing.picture import Picture, four_digit_text

USUAL_PARTS, FEWEST_PARTS, MOST_PARTS = 6, 4, 24
STATION_LETTERS = "ABCDEFGHJKLMNPUVWZ"
"""Letters of stations: without I and O, and without those of the diagram (Q, R, S, T, X, Y).

They are repeated as A₂, B₂ …; A₁ is the pivot of an arm.
"""
DIVIDER_LETTERS = "STRQ"
"""Letters of cam angles at which a stroke or dwell ends while the follower is not at its lowest."""
SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
PRIME_SIGNS = ("", "′", "″", "‴")
TURN_ANGLE = 2.0 * pi
EQUAL_PLACES = 1e-9  # rad, and relative to the lift: closer places are the same


class Station(NamedTuple):
    """A numbered cam angle [rad] with its letter and displacement [mm or rad]."""

    number: str
    letter: str
    angle: float
    displacement: float


class Division(NamedTuple):
    """A rise or return with its stations; ``stroke`` is None if it has no law."""

    stations: tuple[Station, ...]
    stroke: Stroke | None

    @property
    def start(self) -> Station:
        return self.stations[0]

    @property
    def end(self) -> Station:
        return self.stations[-1]


class StationPlan:
    """The divided strokes of a motion, and the letters of all their points.

    Parameters
    ----------
    picture : Picture
        The scene, with the motion of the follower.
    parts : int
        Equal parts of each stroke: an even number from 4 to 24.

    Raises
    ------
    BadInput
        If the number of parts is not allowed.
    """

    def __init__(self, picture: Picture, parts: int) -> None:
        if isinstance(parts, bool) or parts not in range(FEWEST_PARTS, MOST_PARTS + 1, 2):
            allowed = f"an even number from {FEWEST_PARTS} to {MOST_PARTS}"
            raise BadInput([Mistake("camopt", "construction", parts, allowed)])
        self.picture, self.programme, self.parts = picture, picture.problem.programme, parts

    @cached_property
    def divisions(self) -> list[Division]:
        """Strokes with laws, and rises and returns of moves, with their stations. Adjacent ones share a station."""
        kept = [stroke for stroke in self.programme.strokes if not stroke.is_move]
        ranges: list[tuple[float, float, Stroke | None]] = [
            (stroke.start, stroke.end, stroke) for stroke in kept if stroke.kind != DWELL
        ]
        edges = [0.0, *(edge for stroke in kept for edge in (stroke.start, stroke.end)), TURN_ANGLE]
        for low, high in zip(edges[::2], edges[1::2], strict=True):  # moves lie between strokes with laws
            for kind, start, end in self.picture.stroke_kind_spans:
                ends = max(start, low), min(end, high)
                if kind != DWELL and ends[1] - ends[0] > EQUAL_PLACES:
                    ranges.append((*ends, None))
        found: list[Division] = []
        letters = (
            f"{name}{k + 1}".translate(SUBSCRIPTS) if k else name for k in count() for name in STATION_LETTERS
        )
        for number, (start, end, stroke) in enumerate(sorted(ranges, key=lambda leg: leg[0])):
            prime = PRIME_SIGNS[number] if number < len(PRIME_SIGNS) else f"({number})"
            angles = start + (end - start) * np.arange(self.parts + 1) / self.parts
            stations = []
            for place, (angle, level) in enumerate(
                zip(angles, self.programme.motion_at(angles, 0)[0], strict=True)
            ):
                if place == 0 and found and angle - found[-1].end.angle < EQUAL_PLACES:
                    stations.append(found[-1].end)
                elif found and angle > TURN_ANGLE - EQUAL_PLACES and found[0].start.angle < EQUAL_PLACES:
                    stations.append(found[0].start._replace(angle=float(angle)))
                else:
                    stations.append(Station(f"{place}{prime}", next(letters), float(angle), float(level)))
            found.append(Division(tuple(stations), stroke))
        return found

    @cached_property
    def segments(self) -> list[tuple[str, float, float]]:
        """Rises, returns and dwells of the turn with their ends [rad]."""
        found, at = list[tuple[str, float, float]](), 0.0
        for division in self.divisions:
            first, last = division.start, division.end
            found += [("dwell", at, first.angle)] if first.angle > at + EQUAL_PLACES else []
            found.append(("rise" if last.displacement > first.displacement else "return", first.angle, last.angle))
            at = last.angle
        return found if at > TURN_ANGLE - EQUAL_PLACES else [*found, ("dwell", at, TURN_ANGLE)]

    @cached_property
    def stations(self) -> list[Station]:
        """All distinct stations of the turn in order."""
        every = [each for division in self.divisions for each in division.stations]
        return list({each.letter: each for each in reversed(every)}.values())[::-1]

    @cached_property
    def lettered_segment_ends(self) -> list[tuple[str, float]]:
        """Letters and cam angles [rad] of the ends of all rises, returns and dwells, from A to X.

        An end at the lowest position has the letter of its station, but not on the pivot circle of an arm. A turn
        that begins with a dwell begins at A₀.
        """
        reserve = (
            f"{name}{k + 1}".translate(SUBSCRIPTS) if k else name for k in count() for name in DIVIDER_LETTERS
        )
        least = -1.0 if self.picture.problem.setup.angular else EQUAL_PLACES * self.programme.lift
        lowest = {round(s.angle, 9): s.letter for s in self.stations if s.displacement <= least}
        inner = [start for _, start, _ in self.segments[1:]]
        return [
            ("A" if self.divisions[0].start.angle < EQUAL_PLACES else "A₀", 0.0),
            *((lowest.get(round(angle, 9)) or next(reserve), angle) for angle in inner),
            ("X", TURN_ANGLE),
        ]

    def segment_angle_words(self, vertex_letter: str = "", first_letter: str = "", last_letter: str = "X") -> str:
        """The segments as text, "AS = 60° (rise)"; with ``vertex_letter`` as angles about O, "AOS = 60°"."""
        names = [
            first_letter or self.lettered_segment_ends[0][0],
            *(name for name, _ in self.lettered_segment_ends[1:-1]),
            last_letter,
        ]
        parts = [
            f"{one}{vertex_letter}{other} = {four_digit_text(degrees(end - start))}° ({name})"
            for (one, other), (name, start, end) in zip(pairwise(names), self.segments, strict=True)
        ]
        return " and ".join(filter(None, (", ".join(parts[:-1]), parts[-1])))

    @property
    def join_stations_sentence(self) -> str:
        """ "Join A, B, C … P by a smooth curve"; with corners where the velocity jumps."""
        names = [each.letter for each in self.stations]
        corners = ", with corners where the velocity jumps" if self.programme.corners else ""
        return f"Join {', '.join(names[:3])} … {names[-1]} by a smooth curve{corners}"

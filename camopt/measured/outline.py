"""The outline of a measured motion: where it rests and where it turns back, as far as a band of its points shows.

It rests where all points of a stretch lie within the band of one constant, and turns back where points differ by
more than two bands, so that every motion within the band does. A dwell that ended where points leave the band would
let the motion begin too late: what leaves with a finite jerk, y ∝ x³, is eight bands away twice as far from its
beginning as it is one band away. The dwell ends at that beginning, and as much earlier again.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camopt.measured.number_table import bad
from camopt.measured.reading import FULL_TURN, MeasuredPoints, angle_from
from camopt.mistakes import BadInput
from camopt.numerics import FloatArray

BANDS_AWAY = 8.0  # bands away: what is left as a cubic is then twice as far as at one band
LEAST_LEFT = 2.0  # bands, where the points go no further
EARLIER = 2.0  # beginning a little early costs hardly any jerk, beginning late much
LEAST_DWELL = 2.0  # times what it takes to leave it: a nose is within the band of a constant for a while, too
ONE_FLANK = "; a table of one flank, from the nose on, needs the other flank too, at angles below 0 or back to 360"
SPARSE = 4.0  # median steps: in a wider gap than that, if it is not narrow, points are missing
ANGLE_DIGITS = 4  # of the angles of dwells and turns, deg
IN_DWELL = 1e-9  # deg: a point so near to the end of a dwell is in it


class Dwell(NamedTuple):
    """A rest between two cam angles in deg (the last may be beyond a turn), with the points inside."""

    start: float
    end: float
    level: float  # about: the middle of the points of its stretch
    places: NDArray[np.intp]
    stretch: NDArray[np.intp]  # the points within the band of a constant, some of them beyond its ends


class TurningPoint(NamedTuple):
    """Where the motion turns back: between two cam angles in deg, which may be beyond the turn."""

    low: float
    high: float
    highest: bool  # or lowest
    level: float  # about


Outline = tuple[Dwell | TurningPoint, ...]
"""Dwells and turns in their order; the first is a dwell if there is any, and else the lowest turn."""


def outline_of(points: MeasuredPoints, band: float, earlier: float = EARLIER) -> Outline:
    """The outline of points within a band; dwells end ``earlier`` times the way of a cubic before it leaves.

    Raises
    ------
    BadInput
        If no point is two bands away from others, or a part of the turn has no points and is no dwell.
    """
    if np.ptp(points.lifts) <= 2.0 * band:
        raise bad(
            points.file, "band", band, f"all lifts are within {np.ptp(points.lifts):g} of each other: no motion"
        )
    dwells = sorted(_dwells(points, band, earlier), key=lambda dwell: dwell.start)
    _check_gaps(points, dwells)
    if not dwells:
        lowest = int(points.lifts.argmin())
        round_ = np.arange(lowest, lowest + points.lifts.size + 1) % points.lifts.size
        return _turn(points, lowest, False, band), *_turns(points, round_, points.lifts[round_], band)
    parts: list[Dwell | TurningPoint] = []
    for dwell, following in zip(dwells, [*dwells[1:], dwells[0]], strict=True):
        between = _between(points, dwell.end, following.start)
        parts += [dwell, *_turns(points, between, [dwell.level, *points.lifts[between], following.level], band)]
    if len(parts) == 1:
        raise bad(points.file, "band", band, "the lift leaves its one dwell by less than two bands: no motion")
    return tuple(parts)


def _between(points: MeasuredPoints, start: float, end: float) -> NDArray[np.intp]:
    """The points strictly between two cam angles, in their order."""
    away = angle_from(start, points.angles)
    inside = np.flatnonzero((away > 0.0) & (away < angle_from(start, end)))
    return inside[np.argsort(away[inside], kind="stable")]


# ----------------------------------------------------------------------------------------------------- dwells


def _dwells(points: MeasuredPoints, band: float, earlier: float) -> list[Dwell]:
    """The dwells, the longest first."""
    found: list[Dwell] = []
    free = np.ones(points.lifts.size, dtype=bool)
    while (dwell := next(_candidates(points, band, earlier, free), None)) is not None:
        found.append(dwell)
        free[dwell.stretch] = False
    return found


def _candidates(points: MeasuredPoints, band: float, earlier: float, free: NDArray[np.bool_]) -> Iterator[Dwell]:
    """The dwells of the stretches of free points, the longest stretch first."""
    size = points.lifts.size
    stretches = [np.arange(a, b) % size for a, b in _stretches(points.lifts, free, 2.0 * band)]
    lengths = [float(angle_from(points.angles[s[0]], points.angles[s[-1]])) for s in stretches]
    for number in np.argsort(lengths)[::-1]:
        stretch, first = stretches[number], points.angles[stretches[number][0]]
        level = float(points.lifts[stretch].max() + points.lifts[stretch].min()) / 2.0
        ahead, ahead_onset = _leaving(points, stretch[-1], 1, level, band)
        behind, behind_onset = _leaving(points, stretch[0], -1, level, band)
        start = first + earlier * behind_onset - behind
        end = first + lengths[number] + ahead - earlier * ahead_onset
        if end - start > LEAST_DWELL * earlier * max(ahead_onset, behind_onset):
            shift = FULL_TURN * np.floor(start / FULL_TURN)
            start, end = (round(float(angle - shift), ANGLE_DIGITS) for angle in (start, end))
            inside = angle_from(start - IN_DWELL, points.angles[stretch]) <= end - start + 2.0 * IN_DWELL
            yield Dwell(start, end, level, stretch[inside], stretch)


def _stretches(lifts: FloatArray, free: NDArray[np.bool_], room: float) -> Iterator[tuple[int, int]]:
    """The stretches of free points within a room that cannot be made longer, as (first place, the one after it)."""
    size, end, reached = lifts.size, 0, 0
    lowest: deque[int] = deque()
    highest: deque[int] = deque()
    for start in range(size):
        end = max(end, start)
        while end < start + size and free[end % size]:
            value = lifts[end % size]
            low = min(value, lifts[lowest[0] % size]) if lowest else value
            high = max(value, lifts[highest[0] % size]) if highest else value
            if high - low > room:
                break
            while lowest and lifts[lowest[-1] % size] >= value:
                lowest.pop()
            while highest and lifts[highest[-1] % size] <= value:
                highest.pop()
            lowest.append(end)
            highest.append(end)
            end += 1
        if end > max(reached, start + 1):
            yield start, end
            reached = end
        for queue in (lowest, highest):
            if queue and queue[0] == start:
                queue.popleft()


def _leaving(points: MeasuredPoints, place: int, way: int, level: float, band: float) -> tuple[float, float]:
    """The angle from a place to where the motion is one band from a level, and the length of that change, deg."""
    places = (place + way * np.arange(points.lifts.size)) % points.lifts.size
    away = np.mod(way * (points.angles[places] - points.angles[place]), FULL_TURN)
    off = np.abs(points.lifts[places] - level) / band
    left = min(BANDS_AWAY, max(LEAST_LEFT, float(off.max())))
    one, several = (_reaches(away, off, bands) for bands in (1.0, left))
    return one, (several - one) / (left ** (1.0 / 3.0) - 1.0)


def _reaches(away: FloatArray, off: FloatArray, bands: float) -> float:
    """Where points go beyond some bands, straight from point to point."""
    beyond = np.flatnonzero(off > bands)
    k = int(beyond[0]) if beyond.size else int(off.argmax())
    if k == 0 or off[k] <= off[k - 1]:
        return float(away[k])
    share = (min(bands, off[k]) - off[k - 1]) / (off[k] - off[k - 1])
    return float(away[k - 1] + np.clip(share, 0.0, 1.0) * (away[k] - away[k - 1]))


def gaps(points: MeasuredPoints) -> list[int]:
    """The places of points after which some are missing."""
    steps = angle_from(0.0, np.diff(points.angles, append=points.angles[0] + FULL_TURN))
    sparse = max(SPARSE * float(np.median(steps[steps > 0.0])), points.widest)
    return np.flatnonzero(steps > sparse).tolist()


def no_points(points: MeasuredPoints, place: int, why: str) -> BadInput:
    """The mistake of a gap after a place."""
    after = (place + 1) % points.angles.size
    where = f"from {points.angles[place]:g} to {points.angles[after]:g} deg (up to row {points.rows[after]})"
    return bad(points.file, f"row {points.rows[place]}", None, f"no points {where}, and {why}")


def _check_gaps(points: MeasuredPoints, dwells: Sequence[Dwell]) -> None:
    """Whether points are missing where the motion is not at rest."""
    for k in gaps(points):
        after = (k + 1) % points.angles.size
        if not any({k, after} <= set(dwell.stretch) for dwell in dwells):
            nose = points.lifts.argmax() in (k, after)
            raise no_points(points, k, "the lift is not at rest there" + (ONE_FLANK if nose else ""))


# ------------------------------------------------------------------------------------------------------ turns


def _turns(
    points: MeasuredPoints, places: NDArray[np.intp], lifts: Sequence[float] | FloatArray, band: float
) -> Iterator[TurningPoint]:
    """The turns among points between two ends, whose lifts are the first and the last."""
    beside = (len(lifts) - len(places)) // 2
    for k, highest in _pivots(np.asarray(lifts), 2.0 * band):
        yield _turn(points, int(places[k - beside]), highest, band)


def _pivots(lifts: FloatArray, room: float) -> Iterator[tuple[int, bool]]:
    """Where values turn back by more than a room between their ends: the place, and whether it is a highest."""
    lowest = highest = 0
    way = 0
    for k, value in enumerate(lifts):
        lowest = k if value < lifts[lowest] else lowest
        highest = k if value > lifts[highest] else highest
        if way >= 0 and lifts[highest] - value > room:
            if way > 0:
                yield highest, True
            way, lowest = -1, k
        elif way <= 0 and value - lifts[lowest] > room:
            if way < 0:
                yield lowest, False
            way, highest = 1, k


def _turn(points: MeasuredPoints, place: int, highest: bool, band: float) -> TurningPoint:
    """Where the motion may turn: as far as points are within two bands of one, and one point more on each side."""
    size = points.lifts.size
    ends = []
    for way in (-1, 1):
        places = (place + way * np.arange(size)) % size
        beyond = np.flatnonzero(np.abs(points.lifts[places] - points.lifts[place]) > 2.0 * band)
        ends.append(float(np.mod(way * (points.angles[places[beyond[0]]] - points.angles[place]), FULL_TURN)))
    return TurningPoint(
        points.angles[place] - ends[0], points.angles[place] + ends[1], highest, float(points.lifts[place])
    )

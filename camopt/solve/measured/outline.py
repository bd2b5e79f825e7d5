"""The outline of a measured motion: where it rests and where it turns back, as far as a band of its points shows.

It turns back where points differ by more than two bands, so that every motion within the band does. It rests where
all points of a stretch lie within the band of one constant, and the points about it are likelier with a dwell than
without one (``dwell_likelihood``). Of the likely dwells it takes the shortest: a motion that begins a little early
costs hardly any jerk, one that begins late costs much.
"""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import compress, pairwise, product
from typing import NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import BoolArray, FloatArray, IndexArray
from camopt.solve.measured.dwell_likelihood import FlatWindow, read_dwell
from camopt.solve.measured.measured_points import TURN_DEG, MeasuredPoints, angle_from
from camopt.solve.measured.number_table import file_mistake

BANDS_AWAY = 32.0  # bands: points are looked at as far as they are away from a level, or half of the way to a turn
CERTAIN_DWELL_FACTOR = 3.0  # times as long on both sides as the motion takes to go away: then a stretch has a dwell
FEWEST_RESTING = 5  # points of a dwell in doubt, and of a stretch that may be one
LEAST_DWELL_GAIN = 0.0  # of a dwell, as a logarithm of the likelihood
DOUBTFUL_GAINS = (-8.0, 3.0)  # gains of a dwell in doubt: the points fit both readings
SURE_GAIN = 1e6  # what the gain of a certain dwell counts
MOST_CHOICES = 8  # stretches that may be dwells or not
LIKELY_DROP = 0.5  # below the largest logarithm of the likelihood: a dwell that is nearly as likely
ONE_FLANK_HINT = (
    "; a table of one flank, from the nose on, needs the other flank too, at angles below 0 or back to 360"
)
SPARSE_STEPS = 4.0  # median steps: in a wider gap than that, if it is not narrow, points are missing
ANGLE_DIGITS = 4  # of the angles of dwells and turns, deg
DWELL_END_SLACK = 1e-9  # deg: a point so near to the end of a dwell is in it


class Dwell(NamedTuple):
    """A rest between two cam angles in deg (the last may be beyond a turn), with the points inside."""

    start: float
    end: float
    level: float  # about: the middle of the points of its stretch
    places: IndexArray
    stretch: IndexArray  # the points within the band of a constant, some of them beyond its ends
    gain: float  # how much likelier the points are with it than without, as a logarithm


class TurningPoint(NamedTuple):
    """Where the motion turns back: between two cam angles in deg, which may be beyond the turn."""

    low: float
    high: float
    highest: bool  # or lowest
    level: float  # about


class Doubt(NamedTuple):
    """A dwell between two cam angles, deg, where the points fit a motion without one too.

    ``rests`` says whether the motion has it, and ``segments`` are those of the other reading.
    """

    start: float
    end: float
    rests: bool
    segments: list[str]


MotionOutline = tuple[Dwell | TurningPoint, ...]
"""Dwells and turns in their order; the first is a dwell if there is any, and else the lowest turn."""


def read_outline(
    points: MeasuredPoints, band: float, turning: float, noise: float, drop: float, segments: Sequence[str] | None
) -> tuple[MotionOutline, tuple[Doubt, ...]]:
    """The outline of points, and its dwells in doubt; ``segments`` decide if they are given.

    Points rest within a ``band`` of a constant, and turn back by more than two bands of ``turning``.
    """
    flat = flat_stretches(points, band, noise, drop)
    dwells = [each for each in flat if each.gain >= LEAST_DWELL_GAIN]
    outline = motion_outline(points, dwells, turning)
    if segments is None:
        doubts = []
        for each in flat:
            if DOUBTFUL_GAINS[0] < each.gain < DOUBTFUL_GAINS[1] and each.places.size >= FEWEST_RESTING:
                rests = each.gain >= LEAST_DWELL_GAIN
                others = [dwell for dwell in dwells if dwell is not each] + ([] if rests else [each])
                with suppress(BadInput):  # without a dwell points may be missing
                    other = outline_segments(motion_outline(points, others, turning))
                    doubts.append(Doubt(each.start, each.end, rests, other))
        return outline, tuple(sorted(doubts))
    if (chosen := choose_dwells(points, flat, turning, segments)) is None:
        what = f"the strokes of the points, with or without dwells: {','.join(outline_segments(outline))}"
        raise BadInput([Mistake("camopt", "segments", ",".join(segments), what)])
    return motion_outline(points, chosen, turning), ()


def motion_outline(points: MeasuredPoints, dwells: Iterable[Dwell], band: float) -> MotionOutline:
    """The outline of points with some dwells; it turns where points turn back by more than two bands.

    Raises
    ------
    BadInput
        If no point is two bands away from the only dwell, or a part of the turn has no points and is no dwell.
    """
    dwells = sorted(dwells, key=lambda dwell: dwell.start)
    # whether points are missing where the motion is not at rest
    for k in find_gaps(points):
        after = (k + 1) % points.angles.size
        if not any({k, after} <= set(dwell.stretch) for dwell in dwells):
            nose = points.lifts.argmax() in (k, after)
            raise gap_mistake(points, k, "the lift is not at rest there" + (ONE_FLANK_HINT if nose else ""))
    if not dwells:
        lowest = int(points.lifts.argmin())
        round_ = np.arange(lowest, lowest + points.lifts.size + 1) % points.lifts.size
        return _turning_point(points, lowest, False, band), *_turning_points(
            points, round_, points.lifts[round_], band
        )
    parts: list[Dwell | TurningPoint] = []
    for dwell, following in zip(dwells, [*dwells[1:], dwells[0]], strict=True):
        # the points strictly between two cam angles, in their order
        away = angle_from(dwell.end, points.angles)
        inside = np.flatnonzero((away > 0.0) & (away < angle_from(dwell.end, following.start)))
        between = inside[np.argsort(away[inside], kind="stable")]
        parts += [
            dwell,
            *_turning_points(points, between, [dwell.level, *points.lifts[between], following.level], band),
        ]
    if len(parts) == 1:
        raise file_mistake(
            points.file, "band", band, "the lift leaves its one dwell by less than two bands: no motion"
        )
    return tuple(parts)


def outline_segments(outline: MotionOutline) -> list[str]:
    """The rises, returns and dwells of an outline, from its lowest part on."""
    first = min(range(len(outline)), key=lambda k: outline[k].level)
    found = []
    for part, following in pairwise([*outline[first:], *outline[:first], outline[first]]):
        found.append("rise" if following.level > part.level else "return")
        found += ["dwell"] if isinstance(following, Dwell) else []
    return found


def choose_dwells(
    points: MeasuredPoints, flat: Sequence[Dwell], band: float, segments: Sequence[str]
) -> list[Dwell] | None:
    """The likeliest dwells with which points rise, return and rest in a given order; None if no dwells do."""
    likeliest = sorted(flat, key=lambda dwell: -dwell.gain)[:MOST_CHOICES]
    given = list(segments[:-1] if segments[0] == segments[-1] == "dwell" else segments)
    found: list[list[Dwell]] = []
    for rests in product((True, False), repeat=len(likeliest)):
        dwells = list(compress(likeliest, rests))
        with suppress(BadInput):
            shown = outline_segments(motion_outline(points, dwells, band))
            if any(shown == given[k:] + given[:k] for k in range(len(given))):
                found.append(dwells)
    return max(found, key=lambda dwells: sum(min(each.gain, SURE_GAIN) for each in dwells), default=None)


# ----------------------------------------------------------------------------------------------------- dwells


def flat_stretches(points: MeasuredPoints, band: float, noise: float, drop: float = LIKELY_DROP) -> list[Dwell]:
    """The dwells that stretches within a band of a constant may have, each with its gain; the longest first.

    A dwell in doubt is the likeliest one, any other the shortest that is at most ``drop`` less likely.

    Raises
    ------
    BadInput
        If no point is two bands away from others.
    """
    if np.ptp(points.lifts) <= 2.0 * band:
        raise file_mistake(
            points.file, "band", band, f"all lifts are within {np.ptp(points.lifts):g} of each other: no motion"
        )
    found: list[Dwell] = []
    free, size = np.ones(points.lifts.size, dtype=bool), points.lifts.size
    while True:
        stretches = [np.arange(a, b) % size for a, b in _longest_stretches(points.lifts, free, 2.0 * band)]
        lengths = [float(angle_from(points.angles[s[0]], points.angles[s[-1]])) for s in stretches]
        readings = (_dwell_in_stretch(points, stretches[k], band, noise, drop) for k in np.argsort(lengths)[::-1])
        if (dwell := next(filter(None, readings), None)) is None:
            return found
        found.append(dwell)
        free[dwell.stretch] = False


def _dwell_in_stretch(
    points: MeasuredPoints, stretch: IndexArray, band: float, noise: float, drop: float
) -> Dwell | None:
    """The dwell that a stretch may have; None if the points beside it go on as they do in it."""
    first = points.angles[stretch[0]]
    length = float(angle_from(first, points.angles[stretch[-1]]))
    level = float(points.lifts[stretch].max() + points.lifts[stretch].min()) / 2.0
    before, behind, coming = _leaving_points(points, stretch, -1, level, band)
    after, ahead, leaving = _leaving_points(points, stretch, 1, level, band)
    certain = CERTAIN_DWELL_FACTOR * (behind + ahead) < length
    if not certain and (stretch.size < FEWEST_RESTING or coming + leaving > length):
        return None
    behind_it, ahead_of_it = before[::-1], np.concatenate([stretch, after])
    away = [-angle_from(0.0, first - points.angles[behind_it]), angle_from(first, points.angles[ahead_of_it])]
    starts, ends = (
        ((0.0, CERTAIN_DWELL_FACTOR * behind), (length - CERTAIN_DWELL_FACTOR * ahead, length))
        if certain
        else ((0.0, length),) * 2
    )
    lifts = points.lifts[np.concatenate([behind_it, ahead_of_it])]
    dwell = read_dwell(FlatWindow(np.concatenate(away), lifts, starts, ends), noise, drop, DOUBTFUL_GAINS[1])
    start, end = first + dwell.start, first + dwell.end
    shift = TURN_DEG * np.floor(start / TURN_DEG)
    start, end = (round(float(angle - shift), ANGLE_DIGITS) for angle in (start, end))
    inside = angle_from(start - DWELL_END_SLACK, points.angles[stretch]) <= end - start + 2.0 * DWELL_END_SLACK
    return Dwell(start, end, level, stretch[inside], stretch, dwell.gain)


def _leaving_points(
    points: MeasuredPoints, stretch: IndexArray, way: int, level: float, band: float
) -> tuple[IndexArray, float, float]:
    """The points that leave a stretch, the angle over them, and the angle until they are three bands away."""
    size, last = points.lifts.size, stretch[-1 if way > 0 else 0]
    if size - stretch.size < 2:
        return stretch[:0], 0.0, 0.0
    places = (last + way * np.arange(1, (size - stretch.size) // 2 + 1)) % size
    away = np.mod(way * (points.angles[places] - points.angles[last]), TURN_DEG)
    off = np.abs(points.lifts[places] - level) / band
    highest = np.maximum.accumulate(off)
    turned = np.flatnonzero(off < highest - 2.0)
    most = float(highest[turned[0] if turned.size else -1])
    several, three = (
        min(int(np.searchsorted(highest, bands, "right")), places.size - 1)
        for bands in (min(BANDS_AWAY, 1.0 + most / 2.0), 3.0)
    )
    return places[: several + 1], float(away[several]), float(away[three])


def _longest_stretches(lifts: FloatArray, free: BoolArray, room: float) -> Iterator[tuple[int, int]]:
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


def find_gaps(points: MeasuredPoints) -> list[int]:
    """The places of points after which some are missing."""
    steps = angle_from(0.0, np.diff(points.angles, append=points.angles[0] + TURN_DEG))
    sparse = max(SPARSE_STEPS * float(np.median(steps[steps > 0.0])), points.widest)
    return np.flatnonzero(steps > sparse).tolist()


def gap_mistake(points: MeasuredPoints, place: int, why: str) -> BadInput:
    """The mistake of a gap after a place."""
    after = (place + 1) % points.angles.size
    where = f"from {points.angles[place]:g} to {points.angles[after]:g} deg (up to row {points.rows[after]})"
    return file_mistake(points.file, f"row {points.rows[place]}", None, f"no points {where}, and {why}")


# ------------------------------------------------------------------------------------------------------ turns


def _turning_points(
    points: MeasuredPoints, places: IndexArray, lifts: Sequence[float] | FloatArray, band: float
) -> Iterator[TurningPoint]:
    """The turns among points between two ends, whose lifts are the first and the last."""
    beside = (len(lifts) - len(places)) // 2
    for k, highest in _find_reversals(np.asarray(lifts), 2.0 * band):
        yield _turning_point(points, int(places[k - beside]), highest, band)


def _find_reversals(lifts: FloatArray, room: float) -> Iterator[tuple[int, bool]]:
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


def _turning_point(points: MeasuredPoints, place: int, highest: bool, band: float) -> TurningPoint:
    """Where the motion may turn: as far as points are within two bands of one, and one point more on each side."""
    size = points.lifts.size
    ends = []
    for way in (-1, 1):
        places = (place + way * np.arange(size)) % size
        beyond = np.flatnonzero(np.abs(points.lifts[places] - points.lifts[place]) > 2.0 * band)
        ends.append(float(np.mod(way * (points.angles[places[beyond[0]]] - points.angles[place]), TURN_DEG)))
    return TurningPoint(
        points.angles[place] - ends[0], points.angles[place] + ends[1], highest, float(points.lifts[place])
    )

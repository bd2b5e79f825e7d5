"""The outline of a measured motion: its dwells and turning points, as far as a band of the points shows them.

The motion turns back if points differ by more than two bands, because every motion within the band then does. It
rests if all points of a stretch lie within the band of one constant, and the points about it are likelier with a
dwell than without one (``dwell_likelihood``). Of the likely dwells, the shortest is taken. A motion that begins a
little early costs hardly any jerk; one that begins late costs much.
"""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import compress, pairwise, product
from typing import NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import BoolArray, FloatArray, IndexArray
from camopt.solve.measured.dwell_likelihood import FlatWindow, likeliest_dwell
from camopt.solve.measured.measured_points import TURN_DEG, MeasuredPoints, forward_angle_deg
from camopt.solve.measured.number_table import file_mistake

BANDS_AWAY = 32.0  # largest distance of points from a level, in bands, unless the motion turns before
CERTAIN_DWELL_FACTOR = 3.0  # a stretch this many times as long as the motion takes to leave it has a dwell
FEWEST_RESTING = 5  # least points of a dwell in doubt, and of a stretch that may be one
LEAST_DWELL_GAIN = 0.0  # least log-likelihood gain of a dwell
DOUBTFUL_GAINS = (-8.0, 3.0)  # range of gains of a dwell in doubt: the points fit both readings
SURE_GAIN = 1e6  # gain that counts for a certain dwell
MOST_CHOICES = 8  # most stretches that may or may not be dwells
LIKELY_DROP = 0.5  # log-likelihood below the largest, for a dwell that is nearly as likely
ONE_FLANK_HINT = (
    "; a table of one flank, from the nose on, needs the other flank too, at angles below 0 or back to 360"
)
SPARSE_STEPS = 4.0  # a gap of more median steps, if wide enough in deg, has missing points
ANGLE_DIGITS = 4  # decimals of the angles of dwells and turning points [deg]
DWELL_END_SLACK = 1e-9  # a point this close to the end of a dwell is in it [deg]


class Dwell(NamedTuple):
    """A rest between two cam angles in deg (the last may be beyond a turn), with the points inside."""

    start: float
    end: float
    level: float  # approximate: the middle of the points of its stretch
    places: IndexArray
    stretch: IndexArray  # the points within the band of a constant, some of them outside the dwell
    gain: float  # log-likelihood of the points with the dwell, less that without it


class TurningPoint(NamedTuple):
    """A turning point of the motion between two cam angles [deg], which may be beyond the turn."""

    low: float
    high: float
    highest: bool  # if not, lowest
    level: float  # approximate


class Doubt(NamedTuple):
    """A dwell between two cam angles [deg] where the points also fit a motion without one.

    ``rests`` says whether the motion has the dwell, and ``segments`` are those of the other reading.
    """

    start: float
    end: float
    rests: bool
    segments: list[str]


MotionOutline = tuple[Dwell | TurningPoint, ...]
"""Dwells and turning points in order, from a dwell if there is one, else from the lowest turning point."""


def find_outline_and_doubtful_dwells(
    points: MeasuredPoints,
    band: float,
    turning_band: float,
    noise: float,
    likelihood_drop: float,
    segments: Sequence[str] | None,
) -> tuple[MotionOutline, tuple[Doubt, ...]]:
    """The outline of points, and its dwells in doubt; ``segments`` decide if they are given.

    Points rest within a ``band`` of a constant, and turn back by more than two bands of ``turning_band``.
    """
    flat = find_possible_dwells(points, band, noise, likelihood_drop)
    dwells = [dwell for dwell in flat if dwell.gain >= LEAST_DWELL_GAIN]
    outline = motion_outline(points, dwells, turning_band)
    if segments is None:
        doubts = []
        for dwell in flat:
            if DOUBTFUL_GAINS[0] < dwell.gain < DOUBTFUL_GAINS[1] and dwell.places.size >= FEWEST_RESTING:
                rests = dwell.gain >= LEAST_DWELL_GAIN
                others = [other_dwell for other_dwell in dwells if other_dwell is not dwell] + (
                    [] if rests else [dwell]
                )
                with suppress(BadInput):  # without a dwell points may be missing
                    other_segments = outline_segments(motion_outline(points, others, turning_band))
                    doubts.append(Doubt(dwell.start, dwell.end, rests, other_segments))
        return outline, tuple(sorted(doubts))
    if (chosen := choose_dwells(points, flat, turning_band, segments)) is None:
        what = f"the strokes of the points, with or without dwells: {','.join(outline_segments(outline))}"
        raise BadInput([Mistake("camopt", "segments", ",".join(segments), what)])
    return motion_outline(points, chosen, turning_band), ()


def motion_outline(points: MeasuredPoints, dwells: Iterable[Dwell], band: float) -> MotionOutline:
    """The outline of points with some dwells; it turns if points turn back by more than two bands.

    Raises
    ------
    BadInput
        If no point is two bands away from the only dwell, or if a part of the turn has no points and no dwell.
    """
    dwells = sorted(dwells, key=lambda dwell: dwell.start)
    # points must not be missing while the motion moves
    for k in places_before_gaps(points):
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
        # the points between the two dwells, in order
        angles_after = forward_angle_deg(dwell.end, points.angles)
        inside = np.flatnonzero(
            (angles_after > 0.0) & (angles_after < forward_angle_deg(dwell.end, following.start))
        )
        between = inside[np.argsort(angles_after[inside], kind="stable")]
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
    """The rises, returns and dwells of an outline, from its lowest part."""
    first = min(range(len(outline)), key=lambda k: outline[k].level)
    segments = []
    for part, following in pairwise([*outline[first:], *outline[:first], outline[first]]):
        segments.append("rise" if following.level > part.level else "return")
        segments += ["dwell"] if isinstance(following, Dwell) else []
    return segments


def choose_dwells(
    points: MeasuredPoints, possible_dwells: Sequence[Dwell], band: float, segments: Sequence[str]
) -> list[Dwell] | None:
    """The likeliest dwells for which the points rise, return and rest in a given order; None if no dwells do."""
    likeliest = sorted(possible_dwells, key=lambda dwell: -dwell.gain)[:MOST_CHOICES]
    required = list(segments[:-1] if segments[0] == segments[-1] == "dwell" else segments)
    matches: list[list[Dwell]] = []
    for rests in product((True, False), repeat=len(likeliest)):
        dwells = list(compress(likeliest, rests))
        with suppress(BadInput):
            outline_words = outline_segments(motion_outline(points, dwells, band))
            if any(outline_words == required[k:] + required[:k] for k in range(len(required))):
                matches.append(dwells)
    return max(matches, key=lambda dwells: sum(min(dwell.gain, SURE_GAIN) for dwell in dwells), default=None)


# ----------------------------------------------------------------------------------------------------- dwells


def find_possible_dwells(points: MeasuredPoints, band: float, noise: float, likelihood_drop: float) -> list[Dwell]:
    """The possible dwells of stretches within a band of a constant, each with its gain; the longest first.

    A dwell in doubt is the likeliest one. Any other is the shortest one at most ``likelihood_drop`` less likely.

    Raises
    ------
    BadInput
        If no two points differ by two bands.
    """
    if np.ptp(points.lifts) <= 2.0 * band:
        raise file_mistake(
            points.file, "band", band, f"all lifts are within {np.ptp(points.lifts):g} of each other: no motion"
        )
    dwells: list[Dwell] = []
    is_free, size = np.ones(points.lifts.size, dtype=bool), points.lifts.size
    while True:
        stretches = [
            np.arange(a, b) % size for a, b in _longest_stretches_in_range(points.lifts, is_free, 2.0 * band)
        ]
        lengths = [float(forward_angle_deg(points.angles[s[0]], points.angles[s[-1]])) for s in stretches]
        readings = (
            _possible_dwell_in_stretch(points, stretches[k], band, noise, likelihood_drop)
            for k in np.argsort(lengths)[::-1]
        )
        if (dwell := next(filter(None, readings), None)) is None:
            return dwells
        dwells.append(dwell)
        is_free[dwell.stretch] = False


def _possible_dwell_in_stretch(
    points: MeasuredPoints, stretch: IndexArray, band: float, noise: float, likelihood_drop: float
) -> Dwell | None:
    """The possible dwell of a stretch; None if the points beside it continue its motion."""
    first = points.angles[stretch[0]]
    length = float(forward_angle_deg(first, points.angles[stretch[-1]]))
    level = float(points.lifts[stretch].max() + points.lifts[stretch].min()) / 2.0
    before, behind, coming = _points_and_angles_leaving_stretch(points, stretch, -1, level, band)
    after, ahead, leaving = _points_and_angles_leaving_stretch(points, stretch, 1, level, band)
    certain = CERTAIN_DWELL_FACTOR * (behind + ahead) < length
    if not certain and (stretch.size < FEWEST_RESTING or coming + leaving > length):
        return None
    behind_it, ahead_of_it = before[::-1], np.concatenate([stretch, after])
    angles_from_first = [
        -forward_angle_deg(0.0, first - points.angles[behind_it]),
        forward_angle_deg(first, points.angles[ahead_of_it]),
    ]
    starts, ends = (
        ((0.0, CERTAIN_DWELL_FACTOR * behind), (length - CERTAIN_DWELL_FACTOR * ahead, length))
        if certain
        else ((0.0, length),) * 2
    )
    lifts = points.lifts[np.concatenate([behind_it, ahead_of_it])]
    dwell = likeliest_dwell(
        FlatWindow(np.concatenate(angles_from_first), lifts, starts, ends),
        noise,
        likelihood_drop,
        DOUBTFUL_GAINS[1],
    )
    start, end = first + dwell.start, first + dwell.end
    shift = TURN_DEG * np.floor(start / TURN_DEG)
    start, end = (round(float(angle - shift), ANGLE_DIGITS) for angle in (start, end))
    inside = (
        forward_angle_deg(start - DWELL_END_SLACK, points.angles[stretch]) <= end - start + 2.0 * DWELL_END_SLACK
    )
    return Dwell(start, end, level, stretch[inside], stretch, dwell.gain)


def _points_and_angles_leaving_stretch(
    points: MeasuredPoints, stretch: IndexArray, direction: int, level: float, band: float
) -> tuple[IndexArray, float, float]:
    """The points that leave a stretch, the angle over them, and the angle until they are three bands away."""
    size, last = points.lifts.size, stretch[-1 if direction > 0 else 0]
    if size - stretch.size < 2:
        return stretch[:0], 0.0, 0.0
    places = (last + direction * np.arange(1, (size - stretch.size) // 2 + 1)) % size
    angles = np.mod(direction * (points.angles[places] - points.angles[last]), TURN_DEG)
    distances = np.abs(points.lifts[places] - level) / band
    highest = np.maximum.accumulate(distances)
    reversals = np.flatnonzero(distances < highest - 2.0)
    furthest = float(highest[reversals[0] if reversals.size else -1])
    last_place, three_bands_place = (
        min(int(np.searchsorted(highest, bands, "right")), places.size - 1)
        for bands in (min(BANDS_AWAY, 1.0 + furthest / 2.0), 3.0)
    )
    return places[: last_place + 1], float(angles[last_place]), float(angles[three_bands_place])


def _longest_stretches_in_range(
    lifts: FloatArray, is_free: BoolArray, largest_range: float
) -> Iterator[tuple[int, int]]:
    """The longest stretches of free points within a range, as (first place, place after the last)."""
    size, end, reached = lifts.size, 0, 0
    lowest: deque[int] = deque()
    highest: deque[int] = deque()
    for start in range(size):
        end = max(end, start)
        while end < start + size and is_free[end % size]:
            value = lifts[end % size]
            low = min(value, lifts[lowest[0] % size]) if lowest else value
            high = max(value, lifts[highest[0] % size]) if highest else value
            if high - low > largest_range:
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


def places_before_gaps(points: MeasuredPoints) -> list[int]:
    """Places after which points are missing."""
    steps = forward_angle_deg(0.0, np.diff(points.angles, append=points.angles[0] + TURN_DEG))
    sparse = max(SPARSE_STEPS * float(np.median(steps[steps > 0.0])), points.widest)
    return np.flatnonzero(steps > sparse).tolist()


def gap_mistake(points: MeasuredPoints, place_before_gap: int, reason: str) -> BadInput:
    """The mistake of a gap after a place."""
    after = (place_before_gap + 1) % points.angles.size
    where = (
        f"from {points.angles[place_before_gap]:g} to {points.angles[after]:g} deg (up to row {points.rows[after]})"
    )
    return file_mistake(
        points.file, f"row {points.rows[place_before_gap]}", None, f"no points {where}, and {reason}"
    )


# ------------------------------------------------------------------------------------------------------ turns


def _turning_points(
    points: MeasuredPoints, places: IndexArray, lifts: Sequence[float] | FloatArray, band: float
) -> Iterator[TurningPoint]:
    """The turning points among points between two ends, whose lifts are the first and the last.

    The lifts turn back there by more than two bands.
    """
    lowest = highest = way = 0
    offset, lifts = (len(lifts) - len(places)) // 2, np.asarray(lifts)
    for k, value in enumerate(lifts):
        lowest = k if value < lifts[lowest] else lowest
        highest = k if value > lifts[highest] else highest
        if way >= 0 and lifts[highest] - value > 2.0 * band:
            if way > 0:
                yield _turning_point(points, int(places[highest - offset]), True, band)
            way, lowest = -1, k
        elif way <= 0 and value - lifts[lowest] > 2.0 * band:
            if way < 0:
                yield _turning_point(points, int(places[lowest - offset]), False, band)
            way, highest = 1, k


def _turning_point(points: MeasuredPoints, place: int, highest: bool, band: float) -> TurningPoint:
    """The range of a turning point: points within two bands of it, and one more on each side."""
    size = points.lifts.size
    ends = []
    for way in (-1, 1):
        places = (place + way * np.arange(size)) % size
        places_beyond = np.flatnonzero(np.abs(points.lifts[places] - points.lifts[place]) > 2.0 * band)
        ends.append(float(np.mod(way * (points.angles[places[places_beyond[0]]] - points.angles[place]), TURN_DEG)))
    return TurningPoint(
        points.angles[place] - ends[0], points.angles[place] + ends[1], highest, float(points.lifts[place])
    )

"""What `camopt fit` finds again of motions that are known, measured with errors.

    python benchmarks/fits.py [FILES]
    python benchmarks/fits.py random [FILES]
    python benchmarks/fits.py dwells [FILES]

The first looks at each law. FILES is how many files of random errors (5) there are of each motion and noise: a
point each degree, normal errors of 0.001, 0.01 and 0.05 mm. Motions are lobes of 8 mm, 60° up and 60° down, of each
law that rests at both ends, and those of shipped valves. The table has the largest acceleration and jerk that the
fit found over the true ones (the median of the files; ∞ where the true jerk has an impulse), the acceleration by
plain differences, in how many files the band is proved at every point, the root mean square of the jerk over the
least of all motions as near to the points, and seconds.

The second looks at FILES (1,000) random files: turns of textbook laws, dwells and quintic moves, whose lifts and
angles are random; 360 or 720 points with errors of 0.01 to 0.3 % of the lift. They are computed without camopt. The
table has, by the law that is hardest to find, in how many files the largest acceleration is within 5 and 15 % of
the true one, the furthest of all, in how many a band of 0.9, 0.7 or 0.5 times the one found gives a gentler motion
(of each tenth file, by over 2 % of the jerk), and in how many a stretch on one side of the points is told.

The third looks at FILES (500) random files with a dwell of 10 to 90° and as many without it: tops, stops between
two rises, and short rests at the bottom. Half of the laws are textbook laws, the others are in no registry: powers,
exponentials of Fourier sums, blends, and splines. Errors are normal, 0.001 to 0.1 % of the lift. The tables have
the share of the dwells that are found, and of those that are told in doubt only, by angle and noise. The outline
alone is read; some files are fitted too.
"""

import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
from math import inf, tau
from statistics import median
from time import perf_counter
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline

from camopt import LAWS, Unmet, find_scene, fit
from camopt.model.motion.programme import Programme, derivative_peak, law_peaks
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.problem import resolve
from camopt.solve.measured.columns import TableReadingOptions
from camopt.solve.measured.measured_points import read_points
from camopt.solve.measured.noise import estimate_point_errors, noise_band_factor
from camopt.solve.measured.outline import LIKELY_DROP, Dwell, find_outline_and_doubtful_dwells

NOISES = (0.001, 0.01, 0.05)  # mm
VALVES = ("exhaust-valve", "bucket-valve")
CAM = {"cam": {"form": "disc", "base_radius": 20.0}, "follower": {"motion": "translating", "contact": "flat"}}
ANGLES = np.arange(360.0)


def motions() -> Iterator[tuple[str, Programme]]:
    """The motions by name."""
    for name, law in LAWS.items():
        if law_peaks(law)["jumps"] != "velocity":
            lobe = [("dwell", 60.0, 0.0, None), ("rise", 60.0, 8.0, name), ("return", 60.0, 8.0, name)]
            yield name, Programme.from_segments([*lobe, ("dwell", 180.0, 0.0, None)], angular=False)
    for name in VALVES:
        yield name, resolve(find_scene(name)).programme


def row(programme: Programme, noise: float, files: int) -> dict[str, float]:
    """What is found of a motion in files with other errors: medians."""
    lifts = programme.motion_at(np.radians(ANGLES))[0]
    true = {
        "acceleration": derivative_peak(programme, 2, ALL_STROKES),
        "jerk": derivative_peak(programme, 3, ALL_STROKES),
    }
    rows = []
    for seed in range(files):
        errors = np.random.default_rng(seed).normal(0.0, noise, ANGLES.size)
        start = perf_counter()
        try:
            found = fit(np.column_stack([ANGLES, lifts + errors]), CAM)
        except Unmet:
            continue
        seconds = perf_counter() - start
        assert found.deviation.held
        ratios = [found.after[name] / value if value < inf else inf for name, value in true.items()]
        before = found.before["acceleration"] / true["acceleration"]
        rows.append((found.band, *ratios, before, found.jerk_rms / found.least_jerk_rms, seconds))
    names = ("band", "acceleration", "jerk", "differences", "over_bound", "seconds")
    return {**dict(zip(names, map(median, zip(*rows, strict=True)), strict=True)), "held": len(rows)}


# ------------------------------------------------------------------------------------------------ random files

Law = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""s and s″ by x, both from 0 to 1."""


def cycloidal(x):
    return x - np.sin(tau * x) / tau, tau * np.sin(tau * x)


def poly345(x):
    return x**3 * (10 - 15 * x + 6 * x**2), 60 * x - 180 * x**2 + 120 * x**3


def poly4567(x):
    return x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3), 420 * x**2 - 1680 * x**3 + 2100 * x**4 - 840 * x**5


def modified_sine(x):
    """Norton, Cam Design and Manufacturing Handbook, ch. 3: three sines."""
    u, share = 2 * tau * x, np.pi / (4 + np.pi)
    ends, middle = np.sin(u), np.sin((u + np.pi) / 3)
    outside = (x < 1 / 8) | (x >= 7 / 8)
    steady = np.select([x < 1 / 8, x < 7 / 8], [0.0, 2 / np.pi], 4 / np.pi)
    s = share * (steady + x - np.where(outside, ends, 9 * middle) / (2 * tau))
    return s, 2 * tau * share * np.where(outside, ends, middle)


def modified_trapezoid(x):
    """The same: a quarter of a sine, a constant, another quarter; the second half is the first one turned."""
    u, share = np.minimum(x, 1 - x), 1 / (np.pi + 2)
    most, half = 8 * np.pi * share, 1 / 8
    first = share * (2 * u - np.sin(2 * tau * u) / tau)
    begun, on = share * (2 * half - 1 / tau), u - half
    constant = begun + 2 * share * on + most * on**2 / 2
    reached, fast, left = begun + share / 2 + most / 32, 2 * share + most / 4, u - 3 * half
    last = reached + fast * left + most * (1 - np.cos(2 * tau * left)) / (2 * tau) ** 2
    s = np.select([u < half, u < 3 * half], [first, constant], last)
    bend = most * np.select([u < half, u < 3 * half], [np.sin(2 * tau * u), 1.0], np.cos(2 * tau * left))
    return np.where(x > 0.5, 1 - s, s), np.where(x > 0.5, -bend, bend)


TEXTBOOK: tuple[Law, ...] = (cycloidal, poly345, poly4567, modified_sine, modified_trapezoid)


class Part(NamedTuple):
    """A part of a turn: its angle in deg, the lifts at its ends, and a law; of a dwell None."""

    angle: float
    start: float
    end: float
    law: Law | None = None


def move(start, end, angle):
    """A quintic from one (lift, velocity, acceleration) to another, by deg, as a part from 0 to 1."""
    rows = [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 2, 0, 0, 0]]
    rows += [[1, 1, 1, 1, 1, 1], [0, 1, 2, 3, 4, 5], [0, 0, 2, 6, 12, 20]]
    scaled = [value * angle**order for state in (start, end) for order, value in enumerate(state)]
    quintic = np.polynomial.Polynomial(np.linalg.solve(np.array(rows, dtype=float), scaled))
    return Part(angle, 0.0, 1.0, lambda x: (quintic(x), quintic.deriv(2)(x)))


def random_parts(rng, lift):
    """A turn but for the dwell at its end."""

    def law():
        return TEXTBOOK[rng.integers(len(TEXTBOOK))]

    kind, draw = rng.integers(6), rng.uniform
    if kind == 0:  # two dwells
        up, down = draw(40, 120, 2)
        rest = draw(10, min(60, 340 - up - down))
        return [Part(up, 0, lift, law()), Part(rest, lift, lift), Part(down, lift, 0, law())]
    if kind == 1:  # one
        up, down = draw(40, 140, 2)
        return [Part(up, 0, lift, law()), Part(down, lift, 0, law())]
    if kind == 2:  # none
        up = draw(120, 240)
        return [Part(up, 0, lift, law()), Part(360 - up, lift, 0, law())]
    if kind == 3:  # a stop half way
        first, second, down = draw(40, 90, 3)
        below, above = draw(10, 35, 2)
        half = draw(0.3, 0.7) * lift
        up = [Part(first, 0, half, law()), Part(below, half, half), Part(second, half, lift, law())]
        return [*up, Part(above, lift, lift), Part(down, lift, 0, law())]
    if kind == 4:  # a valve with ramps
        low, ramp, flank = draw(0.02, 0.05) * lift, draw(15, 30), draw(45, 75)
        speed = draw(1.0, 1.3) * low / ramp
        top = (lift, 0, -draw(1.2, 2.2) * (lift - low) / flank**2)
        up = [move((0, 0, 0), (low, speed, 0), ramp), move((low, speed, 0), top, flank)]
        return [*up, move(top, (low, -speed, 0), flank), move((low, -speed, 0), (0, 0, 0), ramp)]
    first, second, down = draw(50, 100, 3)  # moves through a point at a velocity
    through = (draw(0.3, 0.7) * lift, draw(0.5, 1.2) * lift / (first + second), 0)
    rest = draw(0, 360 - first - second - down) * 0.4 if first + second + down < 350 else 0
    up = [move((0, 0, 0), through, first), move(through, (lift, 0, 0), second)]
    return [*up, *([Part(rest, lift, lift)] if rest > 10 else []), move((lift, 0, 0), (0, 0, 0), down)]


def along(parts, angles):
    """Lifts and accelerations (by rad) of parts at cam angles in deg."""
    lifts, bends, start = np.zeros_like(angles), np.zeros_like(angles), 0.0
    for part in parts:
        inside = (angles >= start) & (angles < start + part.angle)
        s, bend = part.law((angles[inside] - start) / part.angle) if part.law else (0.0, 0.0)
        lifts[inside] = part.start + (part.end - part.start) * s
        bends[inside] = (part.end - part.start) * bend / np.radians(part.angle) ** 2
        start += part.angle
    return lifts, bends


class RandomFile(NamedTuple):
    """Rows of angle and lift, the standard deviation of their errors and the errors, and the true motion."""

    rows: np.ndarray
    noise: float
    errors: np.ndarray
    parts: list[Part]
    acceleration: float

    @property
    def hardest(self) -> str:
        laws = {part.law for part in self.parts}
        return "with a modified trapezoid" if modified_trapezoid in laws else "other laws and moves"


def random_file(seed: int) -> RandomFile:
    """A file of 360 or 720 points: normal errors in three of five, else uniform ones, or Student's t of 5."""
    rng = np.random.default_rng(seed)
    lift = np.exp(rng.uniform(np.log(2), np.log(40)))
    parts = random_parts(rng, lift)
    rest = 360 - sum(part.angle for part in parts)
    parts += [Part(rest, 0, 0)] if rest > 1e-9 else []
    step = (1.0, 0.5)[rng.integers(2)]
    noise = float(np.exp(rng.uniform(np.log(1e-4), np.log(3e-3))) * lift)
    angles = np.arange(0, 360, step)
    shift = rng.uniform(0, 360)
    kind, size = ("normal", "normal", "normal", "uniform", "t")[rng.integers(5)], angles.size
    if kind == "normal":
        errors = rng.normal(size=size)
    elif kind == "uniform":
        errors = rng.uniform(-(3**0.5), 3**0.5, size)
    else:
        errors = rng.standard_t(5, size) / (5 / 3) ** 0.5
    lifts = along(parts, np.mod(angles - shift, 360))[0] + noise * errors
    largest = np.abs(along(parts, np.linspace(0, 360, 36_001)[:-1])[1]).max()
    return RandomFile(np.column_stack([angles, lifts]), noise, noise * errors, parts, float(largest))


class Found(NamedTuple):
    """What a fit finds of a random file: its acceleration over the true one, and whether stretches are told."""

    acceleration: float
    told: bool
    gentler: bool | None


NARROWER, EVERY, ALIKE = (0.9, 0.7, 0.5), 10, 1.02  # of the jerk: shapes of narrow bands differ by so much


def found_in(file: RandomFile, narrower: bool) -> Found:
    fitted = fit(file.rows, CAM)
    assert fitted.deviation.held
    return Found(
        fitted.after["acceleration"] / file.acceleration,
        bool(fitted.one_sided),
        any(_gentler(file, fitted.jerk_rms, share * fitted.band) for share in NARROWER) if narrower else None,
    )


def _gentler(file: RandomFile, jerk: float, band: float) -> bool:
    """Whether a band gives a gentler motion than one of some jerk."""
    try:
        return jerk > ALIKE * fit(file.rows, CAM, band=band).jerk_rms
    except Unmet:
        return False


def looked_at(seeds: Iterable[int]) -> list[tuple[str, Found]]:
    """Random files by their hardest law, and what is found of each."""
    files = ((seed, random_file(seed)) for seed in seeds)
    return [(file.hardest, found_in(file, seed % EVERY == 0)) for seed, file in files]


def random_table(looked: list[tuple[str, Found]]) -> None:
    groups = defaultdict(list)
    for name, found in looked:
        groups[name].append(found)
    print("| files | | within 5 % | within 15 % | furthest | a narrower band is gentler | one side told |")
    print("|---|---|---|---|---|---|---|")
    for name, rows in [*groups.items(), ("all", [row for each in groups.values() for row in each])]:
        off = np.array([row.acceleration for row in rows]) - 1
        compared = [row.gentler for row in rows if row.gentler is not None]
        counts = [np.sum(np.abs(off) <= most) for most in (0.05, 0.15)]
        furthest = off[np.abs(off).argmax()]
        told = sum(row.told for row in rows)
        narrow = f"{sum(compared)} of {len(compared)}"
        print(f"| {name} | {len(rows)} | {counts[0]} | {counts[1]} | {furthest:+.1%} | {narrow} | {told} |")


# ------------------------------------------------------------------------------------------------ dwells


def law_of(velocity):
    """The law of a velocity by x, up to a factor: sums of 20,000 trapezoids."""
    x = np.linspace(0, 1, 20_001)
    v = velocity(x)
    s = np.concatenate([[0], np.cumsum((v[1:] + v[:-1]) / 2)])
    bend = np.gradient(v / (s[-1] / 20_000), x)
    return lambda t: (np.interp(t, x, s / s[-1]), np.interp(t, x, bend))


def unregistered_law(rng):
    """A law of no registry, at rest at both ends."""
    kind = rng.integers(4)
    if kind == 0:  # any powers
        p, q = rng.uniform(2, 5, 2)
        return law_of(lambda x: x**p * (1 - x) ** q)
    if kind == 1:  # the exponential of a Fourier sum
        waves = rng.normal(0, 0.25, 3) / np.arange(2, 5) ** 1.5
        wavy = [(k, size) for k, size in enumerate(waves, start=2)]
        return law_of(lambda x: (1 - np.cos(tau * x)) * np.exp(sum(c * np.cos(np.pi * k * x) for k, c in wavy)))
    if kind == 2:  # a blend of two
        one, other = (TEXTBOOK[k] for k in rng.choice(len(TEXTBOOK), 2, replace=False))
        share = rng.uniform(0.2, 0.8)
        return lambda x: tuple(share * a + (1 - share) * b for a, b in zip(one(x), other(x), strict=True))
    coefficients = [0, 0, *rng.uniform(0.3, 1.5, 7), 0, 0]  # a cubic spline as the velocity
    knots = np.concatenate([[0] * 4, np.linspace(0, 1, 9)[1:-1], [1] * 4])
    return law_of(BSpline(knots, coefficients, 3))


class DwellFile(NamedTuple):
    """Rows of angle and lift, noise over lift, the dwells as (start, end) in deg, and the dwell in question."""

    rows: np.ndarray
    noise: float
    dwells: list[tuple[float, float]]
    asked: tuple[float, float] | None


def dwell_file(seed: int, rests: bool) -> DwellFile:
    """A file with a dwell of 10 to 90°, or without; of odd seeds the laws are in no registry."""
    rng = np.random.default_rng([seed, rests])
    draw, lift = rng.uniform, np.exp(rng.uniform(np.log(2), np.log(40)))
    angle = draw(10, 90) if rests else 0.0

    def law():
        return unregistered_law(rng) if seed % 2 else TEXTBOOK[rng.integers(len(TEXTBOOK))]

    kind, place = rng.integers(5), 1
    if kind == 3:  # the bottom of a turn
        up = draw(0.35, 0.65) * (360 - angle)
        parts, place = [Part(up, 0, lift, law()), Part(360 - angle - up, lift, 0, law())], 2
    elif kind == 4:  # on the way up
        first, second, down = draw(40, (340 - angle) / 3, 3)
        half = draw(0.3, 0.7) * lift
        if rests:
            up = [Part(first, 0, half, law()), Part(second, half, lift, law())]
        else:
            through = (half, draw(0.5, 1.2) * lift / (first + second), 0)
            up = [move((0, 0, 0), through, first), move(through, (lift, 0, 0), second)]
        parts = [*up, Part(down, lift, 0, law())]
    else:  # the top
        up, down = draw(40, (340 - angle) / 2, 2)
        parts = [Part(up, 0, lift, law()), Part(down, lift, 0, law())]
        if kind == 2 and not rests:  # a nose
            top = (lift, 0, -draw(1.2, 2.4) * lift / up**2)
            parts = [move((0, 0, 0), top, up), move(top, (0, 0, 0), down)]
    if rests:
        parts.insert(place, Part(angle, parts[place - 1].end, parts[place - 1].end))
    if (rest := 360 - sum(part.angle for part in parts)) > 1e-9:
        parts.append(Part(rest, 0, 0))
    noise, angles, shift = 10 ** draw(-5, -3), np.arange(0, 360, (1.0, 0.5)[rng.integers(2)]), draw(0, 360)
    lifts = along(parts, np.mod(angles - shift, 360))[0] + rng.normal(0, noise * lift, angles.size)
    ends = shift + np.cumsum([0.0, *(part.angle for part in parts)])
    dwells = [(a, b) for part, a, b in zip(parts, ends[:-1], ends[1:], strict=True) if part.law is None]
    return DwellFile(
        np.column_stack([angles, lifts]), noise, dwells, (ends[place], ends[place + 1]) if rests else None
    )


def shared(one: tuple[float, float], other: tuple[float, float]) -> float:
    """The angle that two dwells share, deg."""
    return max(0.0, *(min(one[1], other[1] + k) - max(one[0], other[0] + k) for k in (-720, -360, 0, 360, 720)))


class DwellsRead(NamedTuple):
    """Whether the dwell in question is found, else whether it is in doubt; how many more are, and are in doubt."""

    found: bool
    told: bool
    invented: int
    doubts: int


def compare_dwells(
    file: DwellFile, found: list[tuple[float, float]], doubts: list[tuple[float, float]]
) -> DwellsRead:
    """Dwells beside the true ones: half of a found one, or of one in doubt, has to be in a true one."""

    def true(each):
        return any(shared(each, dwell) >= 0.5 * (each[1] - each[0]) for dwell in file.dwells)

    def of_asked(some):
        return file.asked is not None and any(true(each) and shared(each, file.asked) > 0.0 for each in some)

    unasked = [each for each in doubts if not true(each)]
    return DwellsRead(of_asked(found), of_asked(doubts), sum(not true(each) for each in found), len(unasked))


def read_dwells(file: DwellFile) -> DwellsRead:
    """The dwells that the outline of a file has."""
    points = read_points(file.rows, TableReadingOptions())
    noise = estimate_point_errors(points).noise
    band = noise * noise_band_factor(points.rows.size)
    outline, doubts = find_outline_and_doubtful_dwells(points, band, band, noise, LIKELY_DROP, None)
    found = [(part.start, part.end) for part in outline if isinstance(part, Dwell)]
    return compare_dwells(file, found, [(each.start, each.end) for each in doubts])


def fit_dwells(file: DwellFile) -> DwellsRead:
    """The dwells of the motion that is fitted to a file."""
    fitted = fit(file.rows, CAM)
    ends = fitted.start + np.cumsum([0.0, *(segment.angle for segment in fitted.scene.motion)])
    rests = zip(fitted.scene.motion, ends[:-1], ends[1:], strict=True)
    found = [(a, b) for segment, a, b in rests if segment.segment == "dwell"]
    return compare_dwells(file, found, [(each.start, each.end) for each in fitted.doubts])


FITTED = 25  # each so many files
ANGLES_READ, NOISES_READ = (10, 15, 20, 30, 45, 90), (1e-5, 1e-4, 3e-4, 1e-3)


def share_of(read: list[tuple[DwellFile, DwellsRead]], angles, noises) -> str:
    """The share of the dwells within a range of angles and noises that is found, and that is told in doubt only."""
    chosen = [
        found
        for file, found in read
        if angles[0] <= file.asked[1] - file.asked[0] < angles[1] and noises[0] <= file.noise < noises[1]
    ]
    count = max(len(chosen), 1)
    doubtful = sum(each.told and not each.found for each in chosen) / count
    return f"{sum(each.found for each in chosen) / count:.0%} + {doubtful:.0%} of {len(chosen)}"


def dwell_table(files: int) -> None:
    read = {
        rests: [(file := dwell_file(k, rests), read_dwells(file)) for k in range(files)] for rests in (True, False)
    }
    heads = [f"noise {least:g} to {most:g} of the lift" for least, most in pairwise(NOISES_READ)]
    for name, some in (("textbook laws", read[True][::2]), ("laws of no registry", read[True][1::2])):
        print(f"| dwell, {name} | " + " | ".join(heads) + " |")
        print("|---|" + "---|" * len(heads))
        for angles in pairwise(ANGLES_READ):
            cells = [share_of(some, angles, noises) for noises in pairwise(NOISES_READ)]
            print(f"| {angles[0]} to {angles[1]}° | " + " | ".join(cells) + " |")
    for rests, every in read.items():
        invented = sum(found.invented > 0 for _, found in every)
        doubts = sum(found.doubts > 0 for _, found in every)
        kind = "with" if rests else "without"
        print(
            f"{files} files {kind} the dwell: {invented} have an invented one, {doubts} one in doubt where none is"
        )
    compared = [(fit_dwells(file), found) for every in read.values() for file, found in every[::FITTED]]
    print(
        f"of {len(compared)} fits {sum(a != b for a, b in compared)} have other dwells than the outline", flush=True
    )


def main() -> None:
    if sys.argv[1:2] == ["dwells"]:
        dwell_table(int(sys.argv[2]) if sys.argv[2:] else 500)
    elif sys.argv[1:2] == ["random"]:
        random_table(looked_at(range(int(sys.argv[2]) if sys.argv[2:] else 1000)))
    else:
        law_table(int(sys.argv[1]) if sys.argv[1:] else 5)


def law_table(files: int) -> None:
    print(
        "| motion | noise, mm | band, mm | held | acceleration | by differences | jerk | rms jerk over bound | s |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for name, programme in motions():
        for noise in NOISES:
            of = row(programme, noise, files)
            jerk = "∞" if of["jerk"] == inf else f"{of['jerk']:.3f}"
            print(
                f"| {name} | {noise:g} | {of['band']:.4f} | {of['held']} of {files} | {of['acceleration']:.3f} "
                f"| {of['differences']:.2f} | {jerk} | {of['over_bound']:.3f} | {of['seconds']:.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()

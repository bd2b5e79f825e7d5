"""What `camopt fit` finds again of motions that are known, measured with errors.

    python benchmarks/fits.py [FILES]
    python benchmarks/fits.py random [FILES]

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
"""

import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from math import inf, tau
from statistics import median
from time import perf_counter
from typing import NamedTuple

import numpy as np

from camopt import LAWS, Unmet, find_scene, fit
from camopt.motion.programme import Programme, law_peaks, peak
from camopt.motion.table import ALL_STROKES
from camopt.problem.problem import resolve

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
    lifts = programme.at(np.radians(ANGLES))[0]
    true = {"acceleration": peak(programme, 2, ALL_STROKES), "jerk": peak(programme, 3, ALL_STROKES)}
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


def main() -> None:
    if sys.argv[1:2] == ["random"]:
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

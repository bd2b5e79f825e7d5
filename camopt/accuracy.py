"""What accuracy costs in time: sampling, enclosures and balls on the same designs, in one process.

Errors are of what a designer acts on, against ball arithmetic of 200 bits with the laws in closed form. Times are
the least of a few runs, compilation apart, one thread.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any, cast

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from flint import arb

from camopt.files import whole_file
from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.motion.table import DWELL, RETURN, RISE, TURN
from camopt.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray
from camopt.numerics.extremes import extremes
from camopt.numerics.piecewise import MotionTable
from camopt.numerics.sampling import sampled_extremes
from camopt.proof.ball import as_arb
from camopt.proof.certify import HELD, Claim, decide, in_balls, motion_at, motion_of, of_curve
from camopt.proof.laws import pieces_of
from camopt.question import Question, resolve
from camopt.scene import Scene
from camopt.search.space import programmes_of, space_of

DESIGNS = 4096
REFERENCED = 24  # designs with a reference in balls
RUNS = 3
ANGLES = (36, 72, 180, 360, 720, 1800, 3600)
POLISHED = (36, 72, 180, 360)
TOLERANCES = (1e-4, 1e-6, 1e-9, 1e-12)
NEAR = 1e-9  # relative: how far beyond its limit a design is put, to see whether it is accepted
STEPS = 40  # of the secant in balls
ALIKE = arb(10) ** -25
SIGNS = {LARGEST: (1,), LEAST: (-1,), LARGEST_MAGNITUDE: (1, -1)}  # of a curve whose largest value answers a goal
Extremal = tuple[FloatArray, FloatArray]
"""Values and half-widths, (questions, designs)."""


@dataclass(frozen=True)
class Method:
    """One way to an extreme, at one setting: angles a turn, or a tolerance."""

    name: str
    setting: float
    run: Callable[[Any, int, Programme, Any], Extremal]


def _sampled(angles: int, polish: bool) -> Callable[[Any, int, Programme, Any], Extremal]:
    def run(f: Any, count: int, programme: Programme, questions: Any) -> Extremal:
        value = np.empty((len(questions), count))
        sampled_extremes(f, count, sample_table(programme, angles), questions, polish, value)
        return value, np.zeros_like(value)

    return run


def _enclosed(tolerance: float) -> Callable[[Any, int, Programme, Any], Extremal]:
    def run(f: Any, count: int, programme: Programme, questions: Any) -> Extremal:
        value, where, width = np.empty((3, len(questions), count))
        extremes(f, count, programme.table, questions, tolerance, np.inf, value, where, width)
        return value, width

    return run


METHODS = (
    *(Method("sampling", n, _sampled(n, False)) for n in ANGLES),
    *(Method("sampling, polished", n, _sampled(n, True)) for n in POLISHED),
    *(Method("enclosure", t, _enclosed(t)) for t in TOLERANCES),
)


def sample_table(programme: Programme, angles: int) -> MotionTable:
    """A table whose nodes are even cam angles; only what sampling reads is filled in."""
    theta = np.linspace(0.0, 2 * np.pi, angles, endpoint=False)
    motion = programme.at(theta).T.copy()
    ends = np.array([stroke.end for stroke in programme.strokes])
    stroke = np.minimum(np.searchsorted(ends, theta, side="right"), len(ends) - 1)
    counts = np.bincount(stroke, minlength=len(ends))
    kinds = np.array([s.kind for s in programme.strokes])[counts > 0]
    first = np.concatenate([[0], np.cumsum(counts[counts > 0] - 1)])
    blank = np.zeros((0, 1))
    return programme.table._replace(
        coefficients=blank, first_panel=first, kind=kinds, nodes=motion, low=blank, high=blank
    )


@dataclass(frozen=True)
class Subject:
    """One quantity to compute: its curve, the questions it asks, and the answer a designer reads."""

    name: str
    unit: str
    make: Callable[[Designs, Programme], Any]
    questions: Any
    answer: Callable[[FloatArray], FloatArray]


def subjects_of(question: Question) -> list[Subject]:
    """Pressure angle, and curvature of pitch curve or profile."""
    mechanism = question.subject.mechanism
    kinds = [kind for kind in (RISE, RETURN, DWELL) if any(s.kind == kind for s in question.programme.strokes)]
    found = [
        Subject(
            "pressure angle",
            "deg",
            mechanism.pressure,
            np.array([(kind, LARGEST_MAGNITUDE) for kind in kinds]),
            lambda value: np.degrees(np.arctan(value.max(axis=0))),
        )
    ]
    if mechanism.curvature:
        goal = LARGEST_MAGNITUDE if mechanism.grooved else LARGEST
        found.append(
            Subject("curvature", "1/mm", mechanism.curvature, np.array([(TURN, goal)]), lambda value: value[0])
        )
    elif mechanism.profile_radius:
        found.append(
            Subject(
                "radius of curvature",
                "mm",
                mechanism.profile_radius,
                np.array([(TURN, LEAST)]),
                lambda value: value[0],
            )
        )
    return found


def designs_of(question: Question, programme: Programme, seed: int = 0) -> Designs:
    """Designs of the scene's space at random; without a space, its own design with sizes varied a little."""
    rng, space = np.random.default_rng(seed), space_of(question)
    count = 4 * DESIGNS  # some cannot be put together
    if space.designs_each >= REFERENCED:
        designs = space.designs(rng.integers(0, space.designs_each, count))
    else:
        share = {name: rng.uniform(0.9, 1.3, count) for name in ("size", "roller_radius", "offset")}
        plain = question.design.sizes.items()
        sizes = {name: value * share.get(name, np.ones(count)) for name, value in plain}
        designs = Designs(**sizes, sense=question.design.sense)
    return designs.take(question.subject.mechanism.exists(designs, programme)).take(slice(DESIGNS))


def reference(
    subject: Subject, question: Question, programme: Programme, design: Designs, where: FloatArray
) -> arb:
    """The oriented extreme of one design to 50 digits: by a secant in balls from a kernel's cam angles, and proved.

    Raises
    ------
    ArithmeticError
        If the proof that nothing is larger fails.
    """
    motion = motion_of(question.scene, programme)
    made = subject.make(in_balls(design), cast(Programme, motion))
    best: arb | None = None
    for (kinds, goal), angle in zip(subject.questions, where, strict=True):
        for sign in SIGNS[int(goal)]:
            for value in _candidates(made, motion, programme, int(kinds), float(angle), sign):
                best = value if best is None or value > best else best
    assert best is not None
    for kinds, goal in subject.questions:
        for sign in SIGNS[int(goal)]:
            claim = Claim(of_curve(made), int(kinds), arb(sign), best + abs(best) * ALIKE)
            if decide(claim, motion) != HELD:
                raise ArithmeticError(f"no proof of the {subject.name} of {design}")
    return best


def _candidates(made: Any, motion: Any, programme: Programme, kinds: int, angle: float, sign: int) -> list[arb]:
    """Oriented values at the ends of the pieces of a law around a cam angle, and where the slope is zero inside."""
    found, values = [], of_curve(made)
    for stroke, plain in zip(motion.strokes, programme.strokes, strict=True):
        if not (stroke.kind & kinds and plain.start - 1e-6 <= angle <= plain.end + 1e-6):
            continue
        for piece in pieces_of(stroke.law) if stroke.law else (None,):

            def at(x: arb, stroke: Any = stroke, piece: Any = piece) -> tuple[arb, arb]:
                value, slope = values(motion_at(stroke, piece, x))
                return as_arb(value) * sign, as_arb(slope).mid()

            if piece is None:
                found.append(at(arb(0))[0])
                continue
            found += [at(piece.start)[0], at(piece.end)[0]]
            x = arb((angle - plain.start) / plain.angle)
            if not piece.start - 1e-6 < x < piece.end + 1e-6:
                continue
            other = x + arb(1e-7)
            for _ in range(STEPS):
                here, there = at(x)[1], at(other)[1]
                if here == there:
                    break
                x, other = (x - here * (x - other) / (here - there)).mid(), x
            if piece.start < x < piece.end:
                found.append(at(x)[0])
    return found


def measure(scene: Scene, progress: Callable[[int, int], None] | None = None) -> list[dict[str, Any]]:
    """One row for each quantity and method: cost, error, and how it judges designs at the edge of their limit.

    Over the laws that ``[search]`` names, or else the scene's own. ``ns_per_design`` is their mean, all else their
    worst: ``error_max`` and ``error_median`` (relative, against balls); ``achieved`` (largest half-width of an
    enclosure); ``false_accept``: the share of designs, each put 1e-9 beyond its limit, that the method calls
    feasible; ``undecided``: the share it leaves open.
    """
    question = resolve(scene)
    programmes, found = programmes_of(question), []
    for done, programme in enumerate(programmes):
        if progress:
            progress(done, len(programmes))
        designs = designs_of(question, programme)
        for subject in subjects_of(question):
            found += _measured(subject, question, programme, designs)
    return _worst(found)


def _measured(subject: Subject, question: Question, programme: Programme, designs: Designs) -> list[dict[str, Any]]:
    """The rows of one quantity under one programme; none where the quantity is zero throughout."""
    f, questions = subject.make(designs, programme), subject.questions
    exact, where, width = np.empty((3, len(questions), len(designs)))
    extremes(f, len(designs), programme.table, questions, 1e-13, 1e-9, exact, where, width)
    truth = subject.answer(exact)
    if not np.all(np.abs(truth) > 0.0):
        return []
    some, start = range(min(REFERENCED, len(designs))), perf_counter()
    balls = [reference(subject, question, programme, designs.take([i]), where[:, i]) for i in some]
    rows = [_row(subject, "balls", float(ALIKE), (perf_counter() - start) / len(some) * 1e9, float(ALIKE))]
    least = questions[0, 1] == LEAST
    expected = np.array([subject.answer(np.array([[float(-b if least else b)]]))[0] for b in balls])
    limit = truth + (NEAR if least else -NEAR) * np.abs(truth)
    for method in METHODS:
        value, width, nanoseconds = _timed(method, f, len(designs), programme, questions)
        errors = np.abs(subject.answer(value)[: len(some)] / expected - 1.0)
        outer, inner = (subject.answer(value + side * (-width if least else width)) for side in (1.0, -1.0))
        accepted = outer >= limit if least else outer <= limit
        possible = inner >= limit if least else inner <= limit
        rows.append(
            _row(subject, method.name, method.setting, nanoseconds, float(errors.max()))
            | {
                "error_median": float(np.median(errors)),
                "achieved": float((width.max(axis=0) / np.abs(value).max(axis=0)).max()),
                "false_accept": float(accepted.mean()),
                "undecided": float((possible & ~accepted).mean()),
            }
        )
    return rows


def _row(subject: Subject, method: str, setting: float, nanoseconds: float, error: float) -> dict[str, Any]:
    named = {"quantity": subject.name, "method": method, "setting": setting}
    numbers = {"ns_per_design": nanoseconds, "error_max": error, "error_median": error, "achieved": error}
    return {**named, **numbers, "false_accept": 0.0, "undecided": 0.0}


def _worst(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of the same quantity, method and setting made one."""
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault((row["quantity"], row["method"], row["setting"]), []).append(row)
    merged = []
    for group in groups.values():
        worst = {name: max(row[name] for row in group) for name in group[0]}
        merged.append(worst | {"ns_per_design": float(np.mean([row["ns_per_design"] for row in group]))})
    return merged


def _timed(
    method: Method, f: Any, count: int, programme: Programme, questions: Any
) -> tuple[FloatArray, FloatArray, float]:
    """Values, half-widths, and the least time in ns for each design; the first run may compile."""
    value, width = method.run(f, count, programme, questions)
    times = []
    for _ in range(RUNS):
        start = perf_counter()
        method.run(f, count, programme, questions)
        times.append(perf_counter() - start)
    return value, width, min(times) / count * 1e9


def write(rows: list[dict[str, Any]], scene: Scene, folder: str | os.PathLike[str]) -> list[Path]:
    """Write ``accuracy.parquet``, ``.png`` and ``.svg`` to a folder."""
    from camopt.drawing.accuracy import plot_accuracy

    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    with whole_file(out / "accuracy.parquet") as partial:
        pq.write_table(pa.Table.from_pylist(rows, metadata={"camopt_scene": scene.to_toml()}), partial)
    for suffix in ("png", "svg"):
        plot_accuracy(rows, scene.name, out / f"accuracy.{suffix}")
    return [out / f"accuracy.{suffix}" for suffix in ("parquet", "png", "svg")]

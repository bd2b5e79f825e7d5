"""Laws that a scene brings itself: tables read from files, their checks, and the splines that they become.

The checks work on the plain mapping of a scene, as those of ``scene_checks`` do. A fault is (key, value, what is
wrong).
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

from camopt.motion import LAWS
from camopt.motion.programme import unit_span
from camopt.motion.spline import SplineLaw, tabulated
from camopt.scene.csv_columns import MOST_VALUES, read_columns

Fault = tuple[str, Any, str]
SPLINE, TABLE = ("degree", "knots", "coefficients"), ("x", "s")
DEGREES = range(3, 13)  # a jerk is its third derivative, and the panels of a motion hold polynomials of degree 12
CLOSE = 1e-9  # to 0 or 1, of what has to be just that
FAR = 1e9  # that a number may be from 0
APART = 1e-6  # least distance of points or knots
BEYOND = 1e-12  # by how much rounding may take s below 0 or above 1
ENDS = ((0, 0.0), (-1, 1.0))  # where a law starts and ends


def spline_of(name: str, law: Mapping[str, Any]) -> SplineLaw:
    """The law that a faultless table of a scene describes. Its ends are at 0 and 1, without rounding.

    Mirrored it is 1 − s(1 − x): what goes along x and along s is turned round, each from its other end.
    """
    tabled = law.get("x") is not None
    ends = 1 if tabled else law["degree"] + 1
    along, up = (law[key] for key in (TABLE if tabled else SPLINE[1:]))
    if law.get("mirror") is True:
        along, up = ([1.0 - value for value in reversed(values)] for values in (along, up))
    along, up = _with_exact_ends(along, ends), _with_exact_ends(up, 1)
    return tabulated(name, along, up) if tabled else SplineLaw(name, law["degree"], along, up)


def _with_exact_ends(values: Sequence[float], count: int) -> tuple[float, ...]:
    return (*[0.0] * count, *(float(v) for v in values[count:-count]), *[1.0] * count)


# ------------------------------------------------------------------------------------------------- from files


def read_files(data: dict[str, Any], folder: Path | None) -> Iterator[Fault]:
    """Put the points of each law that names a file in place of the name, in ``data`` itself.

    ``folder`` is where files are looked for; None if none may be named.
    """
    for name, law in _laws(data).items():
        if not isinstance(law, dict) or not isinstance(law.get("file"), str):
            continue
        key = f"laws.{name}.file"
        if law.get("x") is not None or law.get("s") is not None:
            yield key, law["file"], "give a file, or x and s"
            continue
        try:
            columns = read_columns(folder, law["file"], TABLE)
        except ValueError as trouble:
            yield key, law["file"], str(trouble)
        else:
            del law["file"]
            law.update(columns)


# ----------------------------------------------------------------------------------------------------- checks


def check_laws(data: Mapping[str, Any]) -> Iterator[Fault]:
    """Every fault of a scene's own laws that needs more than one value to be seen."""
    for name, law in _laws(data).items():
        if name in LAWS:
            yield "laws", name, "is a built-in law; give yours another name"
        elif not name or not name.isprintable() or set(name) & set("+/"):
            yield "laws", name, "the name of a law must be one line of printable characters, without + and /"
        elif isinstance(law, Mapping):
            yield from _check_law(name, law)


def law_names(data: Mapping[str, Any]) -> tuple[str, ...]:
    """The names of the laws that a scene can use: the built-in ones and its own."""
    return (*LAWS, *_laws(data))


def _laws(data: Mapping[str, Any]) -> Mapping[str, Any]:
    laws = data.get("laws")
    return laws if isinstance(laws, Mapping) else {}


def _check_law(name: str, law: Mapping[str, Any]) -> Iterator[Fault]:
    key = f"laws.{name}"
    if law.get("file") is not None:  # it could not be read, which is said
        return
    wanted = TABLE if any(law.get(k) is not None for k in TABLE) else SPLINE
    absent = [k for k in wanted if law.get(k) is None]
    if len(absent) == len(SPLINE):
        yield key, None, "a law needs degree, knots and coefficients, or x and s, or a file"
        return
    what = "a table" if wanted is TABLE else "a B-spline"
    for other in SPLINE if wanted is TABLE else ():
        if law.get(other) is not None:
            yield f"{key}.{other}", law[other], "a table has none: give x and s, or degree, knots and coefficients"
            return
    for other in absent:
        yield f"{key}.{other}", None, f"missing; {what} has {', '.join(wanted)}"
    columns = [_numbers(law.get(k)) for k in wanted if k != "degree"]
    degree = law.get("degree")
    if absent or None in columns or not (wanted is TABLE or (type(degree) is int and degree in DEGREES)):
        return
    most = max(len(column) for column in columns if column is not None)
    if most > MOST_VALUES:
        yield f"{key}.{wanted[-1]}", None, f"has {most} values; the most are {MOST_VALUES}"
        return
    faults = list((_table if wanted is TABLE else _spline)(key, law))
    yield from faults or _shape(name, law)


def _numbers(values: Any) -> list[float] | None:
    """A list of numbers within bounds, or None: the mistake in it is told on its own."""
    if not isinstance(values, list):
        return None
    plain = all(isinstance(v, (int, float)) and not isinstance(v, bool) and abs(v) <= FAR for v in values)
    return values if plain else None


def _table(key: str, law: Mapping[str, Any]) -> Iterator[Fault]:
    x, s = law["x"], law["s"]
    if len(x) < 2:
        yield f"{key}.x", x, "needs two points at least, x = 0 and x = 1"
        return
    if len(s) != len(x):
        yield f"{key}.s", None, f"has {len(s)} values, and x has {len(x)}"
        return
    yield from _ends(f"{key}.x", x, "a stroke runs from x = 0 to x = 1")
    yield from _ends(f"{key}.s", s, "a stroke runs from s = 0 to s = 1")
    for number, (before, after) in enumerate(pairwise(x), start=2):
        if not after - before >= APART:
            yield f"{key}.x.{number}", after, f"must be above the {before:g} before it, by {APART:g} at least"
            return


def _spline(key: str, law: Mapping[str, Any]) -> Iterator[Fault]:
    degree, knots, coefficients = law["degree"], law["knots"], law["coefficients"]
    needed = max(len(coefficients), degree + 1) + degree + 1
    if len(coefficients) <= degree:
        yield f"{key}.coefficients", coefficients, f"needs {degree + 1} at least, for degree {degree}"
        return
    if len(knots) != needed:
        number = f"{len(coefficients)} coefficients of degree {degree}"
        yield f"{key}.knots", None, f"has {len(knots)} values; {number} need {needed}"
        return
    yield from _ends(f"{key}.coefficients", coefficients, "s(0) = 0 and s(1) = 1, the first and the last")
    first, last, inner = knots[: degree + 1], knots[-degree - 1 :], knots[degree + 1 : -degree - 1]
    if max(abs(k) for k in first) > CLOSE or max(abs(k - 1) for k in last) > CLOSE:
        yield f"{key}.knots", knots, f"must start with {degree + 1} zeros and end with {degree + 1} ones"
        return
    distinct = [(k, len(list(group))) for k, group in groupby([0.0, *inner, 1.0])]
    if any(b - a < APART for (a, _), (b, _) in pairwise(distinct)):
        yield f"{key}.knots", knots, f"must be in order, and equal or {APART:g} apart"
    for knot, times in distinct:
        if times > degree:
            yield f"{key}.knots", knot, f"is there {times} times; more than the degree makes the motion jump"


def _ends(key: str, values: Sequence[float], why: str) -> Iterator[Fault]:
    for place, end in ENDS:
        if abs(values[place] - end) > CLOSE:
            yield f"{key}.{place % len(values) + 1}", values[place], f"must be {end:g}: {why}"


def _shape(name: str, law: Mapping[str, Any]) -> Iterator[Fault]:
    """Whether the law stays between the ends of its stroke, which formulas take for the lowest and the highest."""
    least, largest = unit_span(spline_of(name, law))
    if least < -BEYOND or largest > 1.0 + BEYOND:
        by = max(-least, largest - 1.0)
        yield f"laws.{name}", None, f"s goes beyond its ends by {by:.2g}; it has to stay between 0 and 1"

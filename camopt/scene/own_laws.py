"""Laws that a scene brings itself: how they may be given, their checks, and the laws that they become.

The checks work on the plain mapping of a scene, as those of ``scene_checks`` do. A fault is (key, value, what is
wrong).
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

from camopt.mistakes import nearest
from camopt.motion import LAWS
from camopt.motion.law import Law, is_symmetric
from camopt.motion.polynomial import HIGHEST, PolynomialLaw
from camopt.motion.programme import unit_span
from camopt.motion.scca import SCCALaw
from camopt.motion.spline import SplineLaw, tabulated
from camopt.motion.turned import MirroredLaw, SkewedLaw
from camopt.scene.csv_columns import MOST_VALUES, read_columns

Fault = tuple[str, Any, str]
SPLINE, TABLE, CONDITIONS = ("degree", "knots", "coefficients"), ("x", "s"), ("start", "end")
FORMS = {
    "a table": TABLE,
    "a B-spline": SPLINE,
    "a polynomial": CONDITIONS,
    "an SCCA law": ("scca",),
    "a built-in law": ("law",),
}
"""What a law may be, and the keys that give it."""
PLAIN = {"degree", "law"}  # keys with one value
GIVEN_BY = "law, scca, start and end, degree, knots and coefficients, x and s, or a file"
DEGREES = range(3, 13)  # a jerk is its third derivative, and the panels of a motion hold polynomials of degree 12
CLOSE = 1e-9  # to 0 or 1, of what has to be just that
FAR = 1e9  # that a number may be from 0
APART = 1e-6  # least distance of points or knots, and least share of a stroke
NEAREST = 0.01  # of a crossing to an end of the stroke
ENDS = ((0, 0.0), (-1, 1.0))  # where a law starts and ends


def law_of(name: str, law: Mapping[str, Any]) -> Law:
    """The law that a faultless table of a scene describes. Its ends are at 0 and 1, without rounding."""
    crossing, mirror = _crossing(law), law.get("mirror") is True
    if crossing is not None:
        base = _plain(name, law, mirror=False)
        return SkewedLaw(name, base, 1.0 - crossing if mirror else crossing)
    return _plain(name, law, mirror=mirror)


def _crossing(law: Mapping[str, Any]) -> float | None:
    """Where the acceleration crosses zero, should it not be the middle: as such, or from the ratio of its peaks."""
    if law.get("peaks") is not None:
        up, down = law["peaks"]
        return float(down / (up + down))
    return None if law.get("crossing") is None else float(law["crossing"])


def _plain(name: str, law: Mapping[str, Any], *, mirror: bool) -> Law:
    """A law before it is skewed. Mirrored it is 1 − s(1 − x): what it is made from is turned round."""
    if law.get("law") is not None:
        return MirroredLaw(name, LAWS[law["law"]]) if mirror else LAWS[law["law"]]
    if law.get("scca") is not None:
        b, c, d, e = (*map(float, law["scca"]), 0.0)[:4]
        return SCCALaw(name, (b, c, d, e))
    if law.get("start") is not None:
        start, end = ((s, *map(float, law[key][1:])) for key, s in (("start", 0.0), ("end", 1.0)))
        return PolynomialLaw(name, *((_turned(end, 0.0), _turned(start, 1.0)) if mirror else (start, end)))
    return _spline_of(name, law, mirror=mirror)


def _turned(derivatives: tuple[float, ...], s: float) -> tuple[float, ...]:
    """Those of 1 − s(1 − x) at the other end."""
    return (s, *((-1.0) ** k * value for k, value in enumerate(derivatives[1:])))


def _spline_of(name: str, law: Mapping[str, Any], *, mirror: bool) -> SplineLaw:
    tabled = law.get("x") is not None
    ends = 1 if tabled else law["degree"] + 1
    along, up = (law[key] for key in (TABLE if tabled else SPLINE[1:]))
    if mirror:
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
    for name, law in own_laws(data).items():
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
    for name, law in own_laws(data).items():
        if name in LAWS:
            yield "laws", name, "is a built-in law; give yours another name"
        elif not name or not name.isprintable() or set(name) & set("+/"):
            yield "laws", name, "the name of a law must be one line of printable characters, without + and /"
        elif isinstance(law, Mapping):
            yield from _check_law(name, law)


def law_names(data: Mapping[str, Any]) -> tuple[str, ...]:
    """The names of the laws that a scene can use: the built-in ones and its own."""
    return (*LAWS, *own_laws(data))


def own_laws(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """The tables of the laws that a scene brings itself."""
    laws = data.get("laws")
    return laws if isinstance(laws, Mapping) else {}


def _check_law(name: str, law: Mapping[str, Any]) -> Iterator[Fault]:
    key = f"laws.{name}"
    if law.get("file") is not None:  # it could not be read, which is said
        return
    given = {what: [k for k in keys if law.get(k) is not None] for what, keys in FORMS.items()}
    what, *others = [what for what, keys in given.items() if keys] or [""]
    if not what:
        yield key, None, f"a law needs {GIVEN_BY}"
        return
    for other in others[:1]:
        first = given[other][0]
        yield f"{key}.{first}", law[first], f"{what} has none: give one of {GIVEN_BY}"
        return
    wanted = FORMS[what]
    absent = [k for k in wanted if law.get(k) is None]
    for other in absent:
        yield f"{key}.{other}", None, f"missing; {what} has {', '.join(wanted)}"
    if absent or not _are_values(law):
        return
    most = max((len(law[k]) for k in wanted if k not in PLAIN), default=0)
    if most > MOST_VALUES:
        yield f"{key}.{wanted[-1]}", None, f"has {most} values; the most are {MOST_VALUES}"
        return
    faults = list(CHECKS[what](key, law)) or list(_skew(key, law))
    yield from faults or _shape(name, law)


def _are_values(law: Mapping[str, Any]) -> bool:
    """Whether each value is one of its kind: the mistake in another is told on its own."""
    lists = [law[k] for k in (*TABLE, *SPLINE[1:], *CONDITIONS, "scca") if law.get(k) is not None]
    degree, name, crossing, peaks = (law.get(k) for k in ("degree", "law", "crossing", "peaks"))
    pair = isinstance(peaks, (list, tuple)) and len(peaks) == 2
    return (
        all(isinstance(values, list) and values and all(map(_is_number, values)) for values in lists)
        and (degree is None or (type(degree) is int and degree in DEGREES))
        and (name is None or isinstance(name, str))
        and (crossing is None or _is_number(crossing))
        and (peaks is None or (pair and all(_is_number(v) and v > 0.0 for v in peaks)))
    )


def _is_number(value: Any) -> bool:
    """Whether it is a number within bounds."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= FAR


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


def _conditions(key: str, law: Mapping[str, Any]) -> Iterator[Fault]:
    for side, end in (("start", 0.0), ("end", 1.0)):
        if abs(law[side][0] - end) > CLOSE:
            yield f"{key}.{side}.1", law[side][0], f"must be {end:g}: a stroke runs from s = 0 to s = 1"
    degree = len(law["start"]) + len(law["end"]) - 1
    if degree > HIGHEST:
        why = f"{degree + 1} conditions at both ends make a polynomial of degree {degree}; the highest is {HIGHEST}"
        yield f"{key}.end", None, why


def _scca(key: str, law: Mapping[str, Any]) -> Iterator[Fault]:
    shares = law["scca"]
    if len(shares) not in (3, 4):
        what = "must be three shares of the stroke, sine ramps, constant acceleration and cosine"
        yield f"{key}.scca", shares, f"{what}, or four with constant velocity"
        return
    for number, share in enumerate(shares, start=1):
        if not (share == 0.0 or APART <= share <= 1.0):
            yield f"{key}.scca.{number}", share, f"must be 0, or from {APART:g} to 1: it is a share of the stroke"
            return
    if abs(sum(shares) - 1.0) > CLOSE:
        yield f"{key}.scca", shares, f"the shares add up to {sum(shares):.10g}, not to 1"
    elif sum(shares[:3]) == 0.0:
        yield f"{key}.scca", shares, "needs a share with acceleration; constant velocity alone is the law uniform"


def _built_in(key: str, law: Mapping[str, Any]) -> Iterator[Fault]:
    name = law["law"]
    if name not in LAWS:
        yield f"{key}.law", name, f"must be a built-in motion law; {nearest(name, LAWS)}"
    elif law.get("crossing") is None and law.get("peaks") is None:
        if law.get("mirror") is not True:
            yield f"{key}.law", name, "give crossing, peaks or mirror too; without them it is the built-in law"
        elif is_symmetric(LAWS[name]):
            yield f"{key}.mirror", True, f"{name} is the same from both ends"


def _skew(key: str, law: Mapping[str, Any]) -> Iterator[Fault]:
    """Whether the acceleration of a law can cross zero elsewhere than it does."""
    named = [k for k in ("crossing", "peaks") if law.get(k) is not None]
    if not named:
        return
    where, value = f"{key}.{named[0]}", law[named[0]]
    if len(named) == 2:
        yield f"{key}.peaks", law["peaks"], "a law has either crossing or peaks"
    elif law.get("x") is not None:
        yield where, value, "a table has none: the acceleration crosses zero where its points make it"
    elif not NEAREST <= (_crossing(law) or 0.0) <= 1.0 - NEAREST:
        room = f"from {NEAREST:g} to {1.0 - NEAREST:g} of the stroke"
        yield where, value, f"the acceleration would cross zero at {_crossing(law):g}; it has to be {room}"
    elif not is_symmetric(_plain("", law, mirror=False)):
        why = "moves the crossing of a law whose halves mirror each other, s(1 − x) = 1 − s(x); this one's do not"
        yield where, value, why


def _ends(key: str, values: Sequence[float], why: str) -> Iterator[Fault]:
    for place, end in ENDS:
        if abs(values[place] - end) > CLOSE:
            yield f"{key}.{place % len(values) + 1}", values[place], f"must be {end:g}: {why}"


CHECKS = {
    "a table": _table,
    "a B-spline": _spline,
    "a polynomial": _conditions,
    "an SCCA law": _scca,
    "a built-in law": _built_in,
}


def _shape(name: str, law: Mapping[str, Any]) -> Iterator[Fault]:
    """Whether the law stays between the ends of its stroke, unless it may go beyond them."""
    if law.get("overshoot") is True:
        return
    least, largest = unit_span(law_of(name, law))
    if by := max(-least, largest - 1.0):
        within = "it has to stay between 0 and 1, unless overshoot = true allows it"
        yield f"laws.{name}", None, f"s goes beyond its ends by {by:.2g}; {within}"

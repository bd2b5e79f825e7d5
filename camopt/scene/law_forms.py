"""The forms in which a scene can give a law: the keys of each form, how they make a law, and their checks.

A new form needs an entry of ``LAW_FORMS`` and its keys in ``tables.OwnLaw``. A fault is (key, value, what is
wrong).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import groupby, pairwise
from typing import Any, NamedTuple

from camopt.core.numerics.neighbours import noise_standard_deviation
from camopt.model.motion import LAWS
from camopt.model.motion.aliases import suggest_law_names
from camopt.model.motion.derived_laws import MirroredLaw
from camopt.model.motion.law import Law
from camopt.model.motion.polynomial import HIGHEST_DEGREE, PolynomialLaw
from camopt.model.motion.scca import SCCALaw
from camopt.model.motion.spline import EndCondition, SplineLaw, fit_table_spline

Fault = tuple[str, Any, str]
VALUE_IN_SCENE = object()
"""Stands in a fault for the value that the scene has under the key."""
LawValues = Mapping[str, Any]
"""The values of a law by key: from the plain mapping of a scene, or from ``tables.OwnLaw``."""
SPLINE_DEGREES = range(3, 13)  # jerk needs degree 3; panels of a motion hold polynomials up to degree 12
NEAR_END = 1e-9  # tolerance of a value that has to be 0 or 1
MOST_LEEWAY = 0.005  # share of a stroke: a larger overshoot is not noise
LEAST_NOISE_POINTS = 16  # points needed to separate noise from motion
NOISE_SWING = 10.0  # standard deviations of the noise by which a spline may overshoot
LEAST_GAP = 1e-6  # least distance of points or knots, and least share of a stroke
LAW_ENDS = ((0, 0.0), (-1, 1.0))  # index and value of the start and the end of a law


class LawForm(NamedTuple):
    """One form of a law in a scene."""

    what: str
    keys: tuple[str, ...]
    make: Callable[[str, LawValues, bool], Law]
    """Makes the law from (name, faultless table, mirror); a mirrored law is 1 − s(1 − x)."""
    check: Callable[[str, LawValues], Iterator[Fault]]
    """Yields every fault that involves more than one value; the key of the law comes first."""
    is_for_moves: bool = False
    """Whether the form gives positions for a move, not a unit stroke."""


def law_form(law: LawValues) -> LawForm:
    """The form of a law: by the first key of a form, which is unique to it, or else by any key."""
    forms = [form for form in LAW_FORMS if law.get(form.keys[0]) is not None]
    return next(iter(forms or (form for form in LAW_FORMS if any(law.get(key) is not None for key in form.keys))))


# ---------------------------------------------------------------------------------------- tables and B-splines


def _table_law(name: str, law: LawValues, mirror: bool) -> SplineLaw:
    x, s = (_with_exact_zeros_and_ones_at_ends(_mirrored_values(law[key], mirror), 1) for key in ("x", "s"))
    start, end = _end_conditions_of_table(law)
    return fit_table_spline(name, x, s, (end, start) if mirror else (start, end))


TABLE_END_KEYS = ("rest", "reversal")
"""The keys that set the end conditions of a table."""
END_WORDS = {"both": (True, True), "start": (True, False), "end": (False, True), "none": (False, False)}
"""Whether a word includes the start, and the end."""


def reversal_word_to_reverse_at_end(law: LawValues, end_number: int) -> str:
    """Value of ``reversal`` that makes one end of a table a reversal: end 0 is its start, end 1 its end.

    "" if the law is no table, or if ``rest`` or ``reversal`` already sets this end.
    """
    side = 1 - end_number if law.get("mirror") else end_number
    is_set = law.get("rest") or END_WORDS[law.get("reversal") or "none"][side]
    return "" if law.get("x") is None or is_set else ("both" if law.get("reversal") else ("start", "end")[side])


def _end_conditions_of_table(law: LawValues) -> tuple[EndCondition, EndCondition]:
    """The end conditions of a table; an end is at rest unless ``rest`` or ``reversal`` says otherwise."""
    turns = END_WORDS[law.get("reversal") or "none"]
    rests = END_WORDS[law["rest"]] if law.get("rest") else tuple(not each for each in turns)
    start, end = (
        EndCondition.REVERSAL if turn else EndCondition.REST if rest else EndCondition.FREE
        for turn, rest in zip(turns, rests, strict=True)
    )
    return start, end


def overshoot_share_allowed_for_noise(law: LawValues) -> float:
    """Share of the stroke by which noise or rounding may take a table beyond its ends; 0 for other forms."""
    x, s = law.get("x"), law.get("s")
    if x is None or s is None or len(x) < LEAST_NOISE_POINTS:
        return 0.0
    return min(NOISE_SWING * noise_standard_deviation(x, s), MOST_LEEWAY)


def _spline_law(name: str, law: LawValues, mirror: bool) -> SplineLaw:
    knots, coefficients = (_mirrored_values(law[key], mirror) for key in ("knots", "coefficients"))
    return SplineLaw(
        name,
        law["degree"],
        _with_exact_zeros_and_ones_at_ends(knots, law["degree"] + 1),
        _with_exact_zeros_and_ones_at_ends(coefficients, 1),
    )


def _positions_law(name: str, law: LawValues, mirror: bool) -> SplineLaw:
    """The law of a move, with displacements from its start."""
    ends, start = law["degree"] + 1, float(law["positions"][0])
    return SplineLaw(
        name,
        law["degree"],
        _with_exact_zeros_and_ones_at_ends(law["knots"], ends),
        tuple(p - start for p in law["positions"]),
    )


def _mirrored_values(values: Sequence[float], mirror: bool) -> Sequence[float]:
    """Values of x or s; mirrored, 1 − value in reverse order."""
    return [1.0 - value for value in reversed(values)] if mirror else values


def _with_exact_zeros_and_ones_at_ends(values: Sequence[float], end_count: int) -> tuple[float, ...]:
    return (*[0.0] * end_count, *(float(v) for v in values[end_count:-end_count]), *[1.0] * end_count)


def _check_table_points(key: str, law: LawValues) -> Iterator[Fault]:
    x, s = law["x"], law["s"]
    free = _end_conditions_of_table(law) == (EndCondition.FREE, EndCondition.FREE)
    if len(x) < (3 if free else 2):
        points = (
            "at least three points, since both ends are free" if free else "at least two points, x = 0 and x = 1"
        )
        yield f"{key}.x", x, f"needs {points}"
        return
    if any(map(all, zip(*(END_WORDS[law.get(name) or "none"] for name in TABLE_END_KEYS), strict=True))):
        why = f"rest = {law['rest']!r} names the same end; a reversal has an acceleration, an end at rest has none"
        yield f"{key}.reversal", law["reversal"], why
        return
    if len(s) != len(x):
        yield f"{key}.s", None, f"has {len(s)} values, and x has {len(x)}"
        return
    yield from _check_first_is_zero_and_last_is_one(f"{key}.x", x, "a stroke runs from x = 0 to x = 1")
    yield from _check_first_is_zero_and_last_is_one(f"{key}.s", s, "a stroke runs from s = 0 to s = 1")
    for number, (before, after) in enumerate(pairwise(x), start=2):
        if not after - before >= LEAST_GAP:
            yield f"{key}.x.{number}", after, f"must be at least {LEAST_GAP:g} above the {before:g} before it"
            return


def _check_spline(key: str, law: LawValues) -> Iterator[Fault]:
    yield from _check_first_is_zero_and_last_is_one(
        f"{key}.coefficients", law["coefficients"], "s(0) = 0 and s(1) = 1, the first and the last"
    )
    yield from _check_knots(key, law, "coefficients")


def _check_positions(key: str, law: LawValues) -> Iterator[Fault]:
    for name in ("mirror", "crossing", "peaks", "overshoot"):
        if law.get(name) not in (None, False):
            yield f"{key}.{name}", law[name], "is for a law from 0 to 1; this law has positions"
    yield from _check_knots(key, law, "positions")


def _check_knots(key: str, law: LawValues, coefficients_key: str) -> Iterator[Fault]:
    degree, knots, count = law["degree"], law["knots"], len(law[coefficients_key])
    needed = max(count, degree + 1) + degree + 1
    if count <= degree:
        yield (
            f"{key}.{coefficients_key}",
            law[coefficients_key],
            f"needs at least {degree + 1} values for degree {degree}",
        )
        return
    if len(knots) != needed:
        number = f"{count} {coefficients_key} of degree {degree}"
        yield f"{key}.knots", None, f"has {len(knots)} values; {number} need {needed}"
        return
    first, last, inner = knots[: degree + 1], knots[-degree - 1 :], knots[degree + 1 : -degree - 1]
    if max(abs(k) for k in first) > NEAR_END or max(abs(k - 1) for k in last) > NEAR_END:
        yield f"{key}.knots", knots, f"must start with {degree + 1} zeros and end with {degree + 1} ones"
        return
    distinct = [(k, len(list(group))) for k, group in groupby([0.0, *inner, 1.0])]
    if any(b - a < LEAST_GAP for (a, _), (b, _) in pairwise(distinct)):
        yield f"{key}.knots", knots, f"must be in order, and equal or {LEAST_GAP:g} apart"
    for knot, times in distinct:
        if times > degree:
            yield f"{key}.knots", knot, f"occurs {times} times; more than {degree} times makes the motion jump"


def _check_first_is_zero_and_last_is_one(key: str, values: Sequence[float], reason: str) -> Iterator[Fault]:
    for place, end in LAW_ENDS:
        if abs(values[place] - end) > NEAR_END:
            yield f"{key}.{place % len(values) + 1}", values[place], f"must be {end:g}: {reason}"


# ------------------------------------------------------------------------------------------ from a few numbers


def _polynomial_law(name: str, law: LawValues, mirror: bool) -> PolynomialLaw:
    ends = [law["end"], law["start"]] if mirror else [law["start"], law["end"]]
    start, end = ([(-1.0) ** (k * mirror) * v for k, v in enumerate(values[1:])] for values in ends)
    return PolynomialLaw(name, (0.0, *start), (1.0, *end))


def _check_polynomial(key: str, law: LawValues) -> Iterator[Fault]:
    for side, end in (("start", 0.0), ("end", 1.0)):
        if abs(law[side][0] - end) > NEAR_END:
            yield f"{key}.{side}.1", law[side][0], f"must be {end:g}: a stroke runs from s = 0 to s = 1"
    degree = len(law["start"]) + len(law["end"]) - 1
    if degree > HIGHEST_DEGREE:
        why = f"{degree + 1} conditions in all make a polynomial of degree {degree}"
        why += f"; the highest degree is {HIGHEST_DEGREE}"
        yield f"{key}.end", None, why


def _scca_law(name: str, law: LawValues, mirror: bool) -> SCCALaw:
    """The law of the given shares; its mirror image is the same law."""
    b, c, d, e = (*map(float, law["scca"]), 0.0)[:4]
    return SCCALaw(name, (b, c, d, e))


def _check_scca(key: str, law: LawValues) -> Iterator[Fault]:
    shares = law["scca"]
    if len(shares) not in (3, 4):
        what = "must be three shares of the stroke (sine ramps, constant acceleration, cosine)"
        yield f"{key}.scca", shares, f"{what}, or four with constant velocity"
        return
    for number, share in enumerate(shares, start=1):
        if not (share == 0.0 or LEAST_GAP <= share <= 1.0):
            yield (
                f"{key}.scca.{number}",
                share,
                f"must be 0, or a share of the stroke from {LEAST_GAP:g} to 1",
            )
            return
    if abs(sum(shares) - 1.0) > NEAR_END:
        yield f"{key}.scca", shares, f"the shares add up to {sum(shares):.10g}, not to 1"
    elif sum(shares[:3]) == 0.0:
        yield (
            f"{key}.scca",
            shares,
            "needs a share with acceleration; for constant velocity alone use the law uniform",
        )


def _built_in_law(name: str, law: LawValues, mirror: bool) -> Law:
    """A built-in law; it keeps its own name unless it is mirrored."""
    return MirroredLaw(name, LAWS[law["law"]]) if mirror else LAWS[law["law"]]


def _check_built_in(key: str, law: LawValues) -> Iterator[Fault]:
    name = law["law"]
    if name not in LAWS:
        yield f"{key}.law", name, f"must be a built-in motion law; {suggest_law_names(name, LAWS)}"
    elif law.get("crossing") is None and law.get("peaks") is None and law.get("mirror") is not True:
        yield f"{key}.law", name, "needs crossing, peaks or mirror; without them it is the built-in law"


LAW_FORMS = (
    LawForm("a table", ("x", "s"), _table_law, _check_table_points),
    LawForm("a B-spline", ("coefficients", "degree", "knots"), _spline_law, _check_spline),
    LawForm(
        "a B-spline of positions",
        ("positions", "degree", "knots"),
        _positions_law,
        _check_positions,
        is_for_moves=True,
    ),
    LawForm("a polynomial", ("start", "end"), _polynomial_law, _check_polynomial),
    LawForm("an SCCA law", ("scca",), _scca_law, _check_scca),
    LawForm("a built-in law", ("law",), _built_in_law, _check_built_in),
)

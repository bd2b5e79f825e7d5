"""The scene's own laws: how they become laws, their files, and their checks.

The checks work on the tables of the laws, which forms of laws share. What a law is made from is in
``law_forms``.
"""

from collections.abc import Container, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camopt.model.motion import LAWS
from camopt.model.motion.aliases import law_named, segment_named
from camopt.model.motion.law import Law, is_symmetric
from camopt.model.motion.programme import unit_span
from camopt.model.motion.spline import SplineLaw
from camopt.model.motion.turned import SkewedLaw
from camopt.scene.csv_columns import MOST_SPANS, read_columns
from camopt.scene.law_forms import (
    ENDS_OF_TABLE,
    LAW_FORMS,
    LEAST_GAP,
    Fault,
    LawValues,
    form_of,
    leeway,
)
from camopt.scene.tables import OwnLaw

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

GIVEN_BY = "law, scca, start and end, degree, knots and coefficients (of a move: positions), x and s, or a file"
ONE_VALUE = {"degree", "law"}  # keys with one value
LARGEST_NUMBER = 1e9  # that a number may be from 0
NEAREST = 0.01  # of a crossing to an end of the stroke


NAMING = ("law", "law_rise", "law_return", "peak_velocity", "peak_acceleration", "peak_jerk")
"""Keys whose texts are names of laws, in whatever table."""


def with_camopt_names(tables: Any, own: Container[str]) -> Any:
    """The tables of a scene with laws and segments by the names of camopt; names of its ``own`` laws stay."""
    if isinstance(tables, list):
        return [with_camopt_names(each, own) for each in tables]
    if not isinstance(tables, dict):
        return tables
    found = {key: with_camopt_names(value, own) for key, value in tables.items()}
    found |= {key: _named(value, own) for key, value in tables.items() if key in NAMING}
    if isinstance(kind := found.get("segment"), str):
        found["segment"] = segment_named(kind)
    return found


def _named(value: Any, own: Container[str]) -> Any:
    if isinstance(value, list):
        return [_named(each, own) for each in value]
    return law_named(value) if isinstance(value, str) and value not in own else value


def law_of(name: str, law: OwnLaw) -> Law:
    """The law that a table of a scene describes. Its ends are at 0 and 1, without rounding."""
    return law_in(name, vars(law))


def law_in(name: str, law: LawValues) -> Law:
    """The law that a faultless table of the plain mapping of a scene describes."""
    crossing, mirror, make = _crossing(law), law.get("mirror") is True, form_of(law).make
    if crossing is None:
        return make(name, law, mirror)
    return SkewedLaw(name, make(name, law, False), 1.0 - crossing if mirror else crossing)


def _crossing(law: LawValues) -> float | None:
    """The x at which the acceleration crosses zero, if given: directly, or by the ratio of its peaks."""
    if law.get("peaks") is not None:
        up, down = law["peaks"]
        return float(down / (up + down))
    return None if law.get("crossing") is None else float(law["crossing"])


def law_names(laws: Mapping[str, Any]) -> tuple[str, ...]:
    """The names of the laws that a rise or return can have: the built-in ones and others, by their tables."""
    return (*LAWS, *(name for name, law in laws.items() if not is_of_moves(law)))


def laws_of_moves(laws: Mapping[str, Any]) -> tuple[str, ...]:
    """The names of the laws that a move can have."""
    return tuple(name for name, law in laws.items() if is_of_moves(law))


def law_tables(scene: "Scene") -> dict[str, LawValues]:
    """The values of the scene's own laws by key, by name."""
    return {name: vars(law) for name, law in scene.laws.items()}


def is_of_moves(law: Any) -> bool:
    """Whether the table of a law gives positions, for a move."""
    return isinstance(law, Mapping) and bool(given_keys(law)) and form_of(law).of_moves


def given_keys(law: LawValues) -> list[str]:
    """The keys of a law that tell its form."""
    return [
        key for key in dict.fromkeys(key for form in LAW_FORMS for key in form.keys) if law.get(key) is not None
    ]


def own_law_tables(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """The tables of the scene's own laws."""
    laws = data.get("laws")
    return laws if isinstance(laws, Mapping) else {}


# ------------------------------------------------------------------------------------------------- from files


def read_files(data: dict[str, Any], folder: Path | None) -> Iterator[Fault]:
    """Put the points of each law that names a file in place of the name, in ``data`` itself.

    ``folder`` is where files are looked for; None if none may be named.
    """
    for name, law in own_law_tables(data).items():
        if not isinstance(law, dict) or not isinstance(law.get("file"), str):
            continue
        key = f"laws.{name}.file"
        if law.get("x") is not None or law.get("s") is not None:
            yield key, law["file"], "give a file, or x and s"
            continue
        try:
            columns = read_columns(folder, law["file"], ("x", "s"))
        except ValueError as trouble:
            yield key, law["file"], str(trouble)
        else:
            del law["file"]
            law.update(columns)


# ----------------------------------------------------------------------------------------------------- checks


def check_laws(data: Mapping[str, Any]) -> Iterator[Fault]:
    """Every fault of a scene's own laws that needs more than one value to be seen."""
    for name, law in own_law_tables(data).items():
        if name in LAWS:
            yield "laws", name, "is a built-in law; give yours another name"
        elif not name or not name.isprintable() or set(name) & set("+/"):
            yield "laws", name, "the name of a law must be one line of printable characters, without + and /"
        elif isinstance(law, Mapping):
            yield from _check_law(name, law)


def are_faultless(scene: "Scene") -> bool:
    """Whether a scene's own laws have no fault, neither of values nor of files."""
    laws = law_tables(scene)
    named = any(law["file"] is not None for law in laws.values())
    return not (scene.has_wrong("laws") or named or any(check_laws({"laws": laws})))


def _check_law(name: str, law: LawValues) -> Iterator[Fault]:
    key = f"laws.{name}"
    if law.get("file") is not None:  # it could not be read, which is said
        return
    given = given_keys(law)
    if not given:
        yield key, None, f"a law needs {GIVEN_BY}"
        return
    form = form_of(law)
    if other := next((k for k in given if k not in form.keys), None):
        yield f"{key}.{other}", law[other], f"{form.what} has none: give one of {GIVEN_BY}"
        return
    if "x" not in form.keys and (named := [k for k in ENDS_OF_TABLE if law.get(k) is not None]):
        yield f"{key}.{named[0]}", law[named[0]], f"{form.what} has none: it is for a table of x and s"
        return
    absent = [k for k in form.keys if law.get(k) is None]
    for k in absent:
        yield f"{key}.{k}", None, f"missing; {form.what} has {', '.join(form.keys)}"
    if absent or OwnLaw.sound(law) is None:
        return
    most = max((len(law[k]) for k in form.keys if k not in ONE_VALUE), default=0)
    if most > MOST_SPANS:
        yield f"{key}.{form.keys[-1]}", None, f"has {most} values; the most are {MOST_SPANS}"
        return
    faults = list(form.check(key, law)) or list(_skew(key, law)) or list(_mirror(name, law))
    yield from faults or _shape(name, law)


def _skew(key: str, law: LawValues) -> Iterator[Fault]:
    """Check that the zero crossing of a law's acceleration can be moved."""
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
    elif not is_symmetric(form_of(law).make("", law, False)):
        why = "moves the crossing of a law whose halves mirror each other, s(1 − x) = 1 − s(x); this one's do not"
        yield where, value, why


def _mirror(name: str, law: LawValues) -> Iterator[Fault]:
    """Check that mirroring a law makes another law."""
    if law.get("mirror") is True and is_symmetric(law_in(name, {**law, "mirror": False})):
        yield f"laws.{name}.mirror", True, f"{law.get('law') or 'the law'} is the same from both ends; leave it out"


def _shape(name: str, law: LawValues) -> Iterator[Fault]:
    """Check that the law stays between the ends of its stroke, unless it may go beyond them.

    By the least share of a stroke it may: of a lift of 25 mm that is 25 nm, which no cam has and splines of other
    programs may. The lowest of the turn is on the base circle all the same.
    """
    if law.get("overshoot") is True or form_of(law).of_moves:
        return
    made = law_in(name, law)
    if isinstance(made, SplineLaw) and min(made.coefficients) >= 0.0 and max(made.coefficients) <= 1.0:
        return  # a spline is within the range of its coefficients
    least, largest = unit_span(made)
    by = max(-least, largest - 1.0)
    if by > max(leeway(law), LEAST_GAP):
        within = "it has to stay between 0 and 1, unless overshoot = true allows it"
        yield f"laws.{name}", None, f"s goes beyond its ends by {by:.2g}; {within}"

"""Motion laws that a scene defines: how tables become laws, their files, and their checks.

``law_forms`` has the keys and checks of each form of law.
"""

from collections.abc import Container, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camopt.model.motion import LAWS
from camopt.model.motion.aliases import canonical_law_name, canonical_segment_kind
from camopt.model.motion.derived_laws import SkewedLaw
from camopt.model.motion.law import Law, is_symmetric
from camopt.model.motion.programme import law_displacement_range
from camopt.model.motion.spline import SplineLaw
from camopt.scene.csv_columns import MOST_SPANS, read_csv_columns
from camopt.scene.law_forms import (
    LAW_FORMS,
    LEAST_GAP,
    TABLE_END_KEYS,
    Fault,
    LawValues,
    law_form,
    overshoot_share_allowed_for_noise,
)
from camopt.scene.mapping import table_named
from camopt.scene.tables import OwnLaw

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

LAW_FORM_WORDS = (
    "law, scca, start and end, degree, knots and coefficients (of a move: positions), x and s, or a file"
)
SINGLE_VALUE_KEYS = {"degree", "law"}
LARGEST_NUMBER = 1e9  # largest magnitude of a number
LEAST_CROSSING = 0.01  # least distance of a crossing from the ends of the stroke


LAW_NAMING_KEYS = ("law", "law_rise", "law_return", "peak_velocity", "peak_acceleration", "peak_jerk")
"""Keys whose texts are names of laws, in any table."""


def with_canonical_law_names(tables: Any, own_names: Container[str]) -> Any:
    """The tables of a scene with camopt's names of laws and segments.

    Names of the scene's ``own_names`` laws stay.
    """
    if isinstance(tables, list):
        return [with_canonical_law_names(each, own_names) for each in tables]
    if not isinstance(tables, dict):
        return tables
    renamed = {key: with_canonical_law_names(value, own_names) for key, value in tables.items()}
    renamed |= {
        key: _canonical_law_names(value, own_names) for key, value in tables.items() if key in LAW_NAMING_KEYS
    }
    if isinstance(kind := renamed.get("segment"), str):
        renamed["segment"] = canonical_segment_kind(kind)
    return renamed


def _canonical_law_names(value: Any, own_names: Container[str]) -> Any:
    if isinstance(value, list):
        return [_canonical_law_names(each, own_names) for each in value]
    return canonical_law_name(value) if isinstance(value, str) and value not in own_names else value


def laws_of_scene(scene: "Scene") -> dict[str, Law]:
    """All laws that a scene can name: built-in ones, and its own, which start at exactly 0 and end at exactly 1."""
    return {**LAWS, **{name: make_own_law_from_values(name, vars(law)) for name, law in scene.laws.items()}}


def make_own_law_from_values(name: str, law: LawValues) -> Law:
    """The law of a faultless table, by its values."""
    crossing, mirror, make = _acceleration_zero_crossing(law), law.get("mirror") is True, law_form(law).make
    if crossing is None:
        return make(name, law, mirror)
    return SkewedLaw(name, make(name, law, False), 1.0 - crossing if mirror else crossing)


def _acceleration_zero_crossing(law: LawValues) -> float | None:
    """The given x at which the acceleration crosses zero, or x from the ratio of peaks; None without both."""
    if law.get("peaks") is not None:
        up, down = law["peaks"]
        return float(down / (up + down))
    return None if law.get("crossing") is None else float(law["crossing"])


def stroke_law_names(laws: Mapping[str, Any]) -> tuple[str, ...]:
    """The names of laws for rises and returns: built-in ones, and those in ``laws``."""
    return (*LAWS, *(name for name, law in laws.items() if not is_move_law(law)))


def move_law_names(laws: Mapping[str, Any]) -> tuple[str, ...]:
    """The names of laws for moves."""
    return tuple(name for name, law in laws.items() if is_move_law(law))


def own_law_values_by_name(scene: "Scene") -> dict[str, LawValues]:
    """The values of the scene's own laws, by name and key."""
    return {name: vars(law) for name, law in scene.laws.items()}


def is_move_law(law: Any) -> bool:
    """Whether the table of a law gives positions, for a move."""
    return isinstance(law, Mapping) and bool(form_deciding_keys(law)) and law_form(law).is_for_moves


def form_deciding_keys(law: LawValues) -> list[str]:
    """The keys of a law that decide its form."""
    return [
        key for key in dict.fromkeys(key for form in LAW_FORMS for key in form.keys) if law.get(key) is not None
    ]


# ------------------------------------------------------------------------------------------------- from files


def replace_law_files(data: dict[str, Any], folder: Path | None) -> Iterator[Fault]:
    """Replace each file that a law names by its points, in ``data`` itself.

    Paths are relative to ``folder``; None if the scene may not name files.
    """
    for name, law in table_named(data, "laws").items():
        if not isinstance(law, dict) or not isinstance(law.get("file"), str):
            continue
        key = f"laws.{name}.file"
        if law.get("x") is not None or law.get("s") is not None:
            yield key, law["file"], "give either a file, or x and s"
            continue
        try:
            columns = read_csv_columns(folder, law["file"], ("x", "s"))
        except ValueError as trouble:
            yield key, law["file"], str(trouble)
        else:
            del law["file"]
            law.update(columns)


# ----------------------------------------------------------------------------------------------------- checks


def check_laws(data: Mapping[str, Any]) -> Iterator[Fault]:
    """Every fault of a scene's own laws that involves more than one value."""
    for name, law in table_named(data, "laws").items():
        if name in LAWS:
            yield "laws", name, "is a built-in law; give yours another name"
        elif not name or not name.isprintable() or set(name) & set("+/"):
            yield "laws", name, "the name of a law must be one line of printable characters, without + and /"
        elif isinstance(law, Mapping):
            yield from _check_law(name, law)


def _check_law(name: str, law: LawValues) -> Iterator[Fault]:
    key = f"laws.{name}"
    if law.get("file") is not None:  # replace_law_files reported a file that it could not read
        return
    given = form_deciding_keys(law)
    if not given:
        yield key, None, f"a law needs {LAW_FORM_WORDS}"
        return
    form = law_form(law)
    if other := next((k for k in given if k not in form.keys), None):
        yield f"{key}.{other}", law[other], f"{form.what} has none: give one of {LAW_FORM_WORDS}"
        return
    if "x" not in form.keys and (named := [k for k in TABLE_END_KEYS if law.get(k) is not None]):
        yield f"{key}.{named[0]}", law[named[0]], f"{form.what} has none; only a table of x and s has it"
        return
    absent = [k for k in form.keys if law.get(k) is None]
    for k in absent:
        yield f"{key}.{k}", None, f"missing; {form.what} has {', '.join(form.keys)}"
    if absent or OwnLaw.from_known_keys(law) is None:
        return
    most = max((len(law[k]) for k in form.keys if k not in SINGLE_VALUE_KEYS), default=0)
    if most > MOST_SPANS:
        yield f"{key}.{form.keys[-1]}", None, f"has {most} values; at most {MOST_SPANS} are allowed"
        return
    faults = (
        list(form.check(key, law))
        or list(_check_zero_crossing_can_be_moved(key, law))
        or list(_check_mirror_changes_law(name, law))
    )
    yield from faults or _check_overshoot(name, law)


def _check_zero_crossing_can_be_moved(key: str, law: LawValues) -> Iterator[Fault]:
    """Check that the zero crossing of a law's acceleration can be moved."""
    named = [k for k in ("crossing", "peaks") if law.get(k) is not None]
    if not named:
        return
    where, value = f"{key}.{named[0]}", law[named[0]]
    if len(named) == 2:
        yield f"{key}.peaks", law["peaks"], "a law has either crossing or peaks"
    elif law.get("x") is not None:
        yield where, value, "a table has none: its points decide where the acceleration crosses zero"
    elif not LEAST_CROSSING <= (_acceleration_zero_crossing(law) or 0.0) <= 1.0 - LEAST_CROSSING:
        room = f"from {LEAST_CROSSING:g} to {1.0 - LEAST_CROSSING:g} of the stroke"
        yield (
            where,
            value,
            f"the acceleration would cross zero at {_acceleration_zero_crossing(law):g}; it must be {room}",
        )
    elif not is_symmetric(law_form(law).make("", law, False)):
        yield where, value, "is for a symmetric law, s(1 − x) = 1 − s(x); this law is not symmetric"


def _check_mirror_changes_law(name: str, law: LawValues) -> Iterator[Fault]:
    """Check that mirroring a law makes another law."""
    if law.get("mirror") is True and is_symmetric(make_own_law_from_values(name, {**law, "mirror": False})):
        yield f"laws.{name}.mirror", True, f"{law.get('law') or 'the law'} is the same from both ends; leave it out"


def _check_overshoot(name: str, law: LawValues) -> Iterator[Fault]:
    """Check that a law without ``overshoot`` stays between 0 and 1.

    ``LEAST_GAP`` is tolerated: it is 25 nm for a lift of 25 mm, less than any cam is made to, and splines of other
    programs may overshoot that much. The lowest displacement of the turn is on the base circle in any case.
    """
    if law.get("overshoot") is True or law_form(law).is_for_moves:
        return
    motion_law = make_own_law_from_values(name, law)
    if (
        isinstance(motion_law, SplineLaw)
        and min(motion_law.coefficients) >= 0.0
        and max(motion_law.coefficients) <= 1.0
    ):
        return  # a spline stays within the range of its coefficients
    least, largest = law_displacement_range(motion_law)
    excess = max(-least, largest - 1.0)
    if excess > max(overshoot_share_allowed_for_noise(law), LEAST_GAP):
        within = "it must stay between 0 and 1 unless overshoot = true"
        yield f"laws.{name}", None, f"s goes beyond its ends by {excess:.2g}; {within}"

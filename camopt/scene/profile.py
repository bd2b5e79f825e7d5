"""A cam given by its profile: the checks of its arcs and lines, its base radius, and the motion of its follower.

The checks work on the plain mapping of a scene, as those of ``scene.checks`` do.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from math import degrees
from typing import Any

from camopt.motion.contact import Contact, OscillatingFace, OscillatingPoint, TranslatingFace, TranslatingPoint
from camopt.motion.load import ExternalLoad
from camopt.motion.profile import CLOSE, Element, Unfit, least_radius, parts_of
from camopt.motion.profile_law import programme_on
from camopt.motion.programme import Programme
from camopt.scene.law_forms import Fault
from camopt.scene.mapping import at, length, number, tables_in
from camopt.scene.own_laws import FAR

LEAST = 1e-9  # mm: of a radius


def read_profile(data: dict[str, Any]) -> None:
    """Put the least radius of a profile in place of one that is absent, or rounded, in ``data`` itself."""
    cam, elements = data.get("cam"), _elements(data)
    if elements and isinstance(cam, dict) and cam.get("form") == "disc":
        with suppress(Unfit):  # which is told with the other faults
            least = least_radius(parts_of(elements))
            if cam.get("base_radius") is None or not any(_base(data, least)):
                cam["base_radius"] = least


def programme_of(data: Mapping[str, Any], load: ExternalLoad | None = None) -> Programme | None:
    """The turn of a scene with a profile; None where a number that it needs is missing or wrong.

    Raises
    ------
    Unfit
        If the arcs and lines are no profile, or its follower cannot be on it.
    """
    elements, contact = _elements(data), _contact(data)
    return programme_on(parts_of(elements), contact, load) if elements and contact else None


def highest_on_profile(data: Mapping[str, Any]) -> float | None:
    """The highest displacement above the lowest, mm or deg; None where it is not known."""
    try:
        programme = programme_of(data)
    except Unfit:
        return None
    if programme is None:
        return None
    return degrees(programme.lift) if at(data, "follower.motion") == "oscillating" else programme.lift


def check_profile(data: Mapping[str, Any]) -> Iterator[Fault]:
    """Every fault of a profile that needs more than one value to be seen."""
    if data.get("motion"):
        yield "profile", None, "a scene has either [[motion]] or [[profile]]: one follows from the other"
    if at(data, "cam.form") == "cylindrical":
        yield "cam.form", "cylindrical", "must be 'disc': arcs and lines are the profile of a disc cam"
    for k, row in enumerate(_rows(data), start=1):
        yield from _element(row, f"profile.{k}")
    if elements := _elements(data):
        try:
            yield from _base(data, least_radius(parts_of(elements)))
            programme_of(data)
        except Unfit as unfit:
            yield f"profile.{unfit.number}" if unfit.number else "profile", None, unfit.why


def _base(data: Mapping[str, Any], least: float) -> Iterator[Fault]:
    base = number(at(data, "cam.base_radius"))
    if base is not None and abs(base - least) > CLOSE * least:
        yield "cam.base_radius", base, f"the least radius of the profile is {least:.10g}: leave it out"


# --------------------------------------------------------------------------------------------------- elements


def _rows(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The elements of a profile."""
    return tables_in(data.get("profile"))


def _element(row: Mapping[str, Any], key: str) -> Iterator[Fault]:
    if row.get("element") == "line":
        for name in ("radius", "x", "y"):
            if row.get(name) is not None:
                yield f"{key}.{name}", row[name], "a line has none: it touches both neighbours"
    elif row.get("element") == "arc":
        radius = number(row.get("radius"))
        if row.get("radius") is None:
            yield f"{key}.radius", None, "missing; an arc has a radius (mm), below 0 where the flank is hollow"
        elif radius is not None and abs(radius) < LEAST:
            yield f"{key}.radius", row["radius"], f"must be at least {LEAST:g} from 0"
        for name, other in (("x", "y"), ("y", "x")):
            if row.get(name) is None and row.get(other) is not None:
                yield f"{key}.{name}", None, "missing; a centre has x and y (mm)"


def _elements(data: Mapping[str, Any]) -> list[Element] | None:
    """The elements as the motion takes them; None where a number or a kind is missing or wrong."""
    mirrored, found = at(data, "cam.rotation") != "cw", []
    for row in _rows(data):
        given = {name: row[name] for name in ("radius", "x", "y") if row.get(name) is not None}
        numbers = {name: value for name, each in given.items() if (value := number(each)) is not None}
        wrong = row.get("element") not in ("arc", "line") or len(numbers) < len(given)
        if wrong or max(map(abs, numbers.values()), default=0.0) > FAR or any(_element(row, "")):
            return None
        centre = complex(numbers["x"], -numbers["y"] if mirrored else numbers["y"]) if "x" in numbers else None
        found.append(Element(numbers.get("radius"), centre))
    return found


def _contact(data: Mapping[str, Any]) -> Contact | None:
    """The follower as the profile meets it; None where a size is missing or wrong."""
    kind = at(data, "follower.motion"), at(data, "follower.contact")
    sense = -1.0 if at(data, "cam.rotation") == "cw" else 1.0
    named = {"roller": "roller_radius", "spherical": "face_radius"}.get(str(kind[1]))
    radius = length(data, f"follower.{named}") if named else 0.0 if kind[1] == "knife" else None
    centre_distance = length(data, "follower.centre_distance")
    if kind == ("translating", "flat"):
        return TranslatingFace()
    if kind == ("oscillating", "flat"):
        face = number(at(data, "follower.face_offset"))
        return OscillatingFace(centre_distance, face, sense) if centre_distance and face is not None else None
    if kind[0] == "translating":
        offset = number(at(data, "follower.offset") or 0.0)
        return TranslatingPoint(radius, sense * offset) if radius is not None and offset is not None else None
    arm = length(data, "follower.arm_length")
    if kind[0] != "oscillating" or radius is None or not centre_distance or not arm:
        return None
    return OscillatingPoint(radius, centre_distance, arm, sense)

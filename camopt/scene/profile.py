"""A cam given by its profile: the checks of its arcs and lines, its base radius, and the motion of its follower.

The checks work on the plain mapping of a scene, as those of ``scene.checks`` do.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from math import degrees
from typing import Any

from camopt.mechanisms import Mechanism, mechanism_for
from camopt.mechanisms.body import BODIES, DISC
from camopt.mechanisms.follower import OSCILLATING, TIPS
from camopt.motion.contact import ProfileContact
from camopt.motion.load import ExternalLoad
from camopt.motion.profile import TOUCHING_SHARE, GivenElement, Unfit, least_radius, parts_of
from camopt.motion.profile_law import programme_on
from camopt.motion.programme import Programme
from camopt.scene import tables
from camopt.scene.law_forms import Fault
from camopt.scene.mapping import at, number_of, tables_in
from camopt.scene.sizes import mechanism_in, sizes_in, sizes_of

LEAST_RADIUS = 1e-9  # mm: of a radius


def read_profile(data: dict[str, Any]) -> None:
    """Put the least radius of a profile in place of one that is absent, or rounded, in ``data`` itself."""
    cam, elements = data.get("cam"), _elements(data)
    if elements and isinstance(cam, dict) and cam.get("form") == DISC.form:
        with suppress(Unfit):  # which is told with the other faults
            least = least_radius(parts_of(elements))
            if cam.get("base_radius") is None or not any(_base(data, least)):
                cam["base_radius"] = least


def programme_of(
    profile: Sequence[tables.ProfileElement], cam: tables.Cam, follower: tables.Follower, load: ExternalLoad | None
) -> Programme:
    """The turn of a scene with a profile.

    Raises
    ------
    Unfit
        If the arcs and lines are no profile, or its follower cannot be on it.
    """
    mechanism = mechanism_for(cam.form, follower.motion, follower.contact)
    contact = _on_profile(mechanism, sizes_of(mechanism, TIPS[follower.contact], follower), cam.rotation)
    assert contact is not None, "a scene has the sizes of its follower"
    elements = [_element_of(each, cam.rotation) for each in profile]
    return programme_on(parts_of(elements), contact, load)


def programme_in(data: Mapping[str, Any]) -> Programme | None:
    """The turn of the plain mapping of a scene; None where a number that it needs is missing or wrong."""
    elements, contact = _elements(data), _contact(data)
    return programme_on(parts_of(elements), contact) if elements and contact else None


def highest_on_profile(data: Mapping[str, Any]) -> float | None:
    """The highest displacement above the lowest, mm or deg; None where it is not known."""
    try:
        programme = programme_in(data)
    except Unfit:
        return None
    if programme is None:
        return None
    return degrees(programme.lift) if at(data, "follower.motion") == OSCILLATING.name else programme.lift


def check_profile(data: Mapping[str, Any]) -> Iterator[Fault]:
    """Every fault of a profile that needs more than one value to be seen."""
    if data.get("motion"):
        yield "profile", None, "a scene has either [[motion]] or [[profile]]: one follows from the other"
    form = at(data, "cam.form")
    if form in [*BODIES] and form != DISC.form:
        yield "cam.form", form, "must be 'disc': arcs and lines are the profile of a disc cam"
    for k, row in enumerate(_rows(data), start=1):
        yield from _element(row, f"profile.{k}")
    if elements := _elements(data):
        try:
            yield from _base(data, least_radius(parts_of(elements)))
            programme_in(data)
        except Unfit as unfit:
            yield f"profile.{unfit.number}" if unfit.number else "profile", None, unfit.why


def _base(data: Mapping[str, Any], least: float) -> Iterator[Fault]:
    base = number_of(at(data, "cam.base_radius"))
    if base is not None and abs(base - least) > TOUCHING_SHARE * least:
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
        radius = number_of(row.get("radius"))
        if row.get("radius") is None:
            yield f"{key}.radius", None, "missing; an arc has a radius (mm), below 0 where the flank is hollow"
        elif radius is not None and abs(radius) < LEAST_RADIUS:
            yield f"{key}.radius", row["radius"], f"must be at least {LEAST_RADIUS:g} from 0"
        for name, other in (("x", "y"), ("y", "x")):
            if row.get(name) is None and row.get(other) is not None:
                yield f"{key}.{name}", None, "missing; a centre has x and y (mm)"


def _elements(data: Mapping[str, Any]) -> list[GivenElement] | None:
    """The elements as the motion takes them; None where a number or a kind is missing or wrong."""
    rows = [(tables.ProfileElement.sound(row), row) for row in _rows(data)]
    if any(each is None or any(_element(row, "")) for each, row in rows):
        return None
    return [_element_of(each, at(data, "cam.rotation")) for each, _ in rows if each]


def _element_of(row: tables.ProfileElement, rotation: str) -> GivenElement:
    """An element as the motion takes it: in a plane that is mirrored unless the cam turns cw."""
    if row.x is None or row.y is None:
        return GivenElement(row.radius)
    return GivenElement(row.radius, complex(row.x, row.y if rotation == "cw" else -row.y))


def _contact(data: Mapping[str, Any]) -> ProfileContact | None:
    """The follower as the profile meets it; None where a size is missing or wrong."""
    found = mechanism_in(data, DISC.form)
    return found and _on_profile(found[0], sizes_in(data, *found), at(data, "cam.rotation"))


def _on_profile(mechanism: Mechanism, sizes: Mapping[str, float], rotation: str) -> ProfileContact | None:
    """The follower of a mechanism on a profile; None where it meets none, or a size is missing."""
    try:
        return mechanism.on_profile and mechanism.on_profile(sizes, -1.0 if rotation == "cw" else 1.0)
    except KeyError:
        return None

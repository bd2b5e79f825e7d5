"""A cam given by its profile: checks of its arcs and lines, its base radius, and the motion of its follower."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from math import degrees
from typing import TYPE_CHECKING, Any

from camopt.model.mechanisms import Mechanism
from camopt.model.mechanisms.elements import BODIES, DISC, OSCILLATING
from camopt.model.motion.load import ExternalLoad
from camopt.model.motion.profile import (
    TOUCHING_SHARE,
    ElementSpec,
    ProfileFault,
    least_distance_from_axis,
    place_profile_elements,
)
from camopt.model.motion.profile_contact import ProfileContact
from camopt.model.motion.profile_law import programme_on_profile
from camopt.model.motion.programme import Programme
from camopt.scene import tables
from camopt.scene.law_forms import VALUE_IN_SCENE, Fault
from camopt.scene.mapping import finite_number_or_none, tables_in_list, value_at_key
from camopt.scene.sizes import known_number_or_none, known_sizes, mechanism_and_tip_named

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

LEAST_RADIUS = 1e-9  # least radius of an arc, mm


def set_base_radius_from_profile(data: dict[str, Any]) -> None:
    """Set a missing or rounded ``cam.base_radius`` to the least radius of the profile, in ``data`` itself."""
    rows = [tables.ProfileElement.from_known_keys(row) for row in tables_in_list(data.get("profile"))]
    cam, elements = (
        data.get("cam"),
        _element_specs_or_none([row for row in rows if row], value_at_key(data, "cam.rotation")),
    )
    if elements and None not in rows and isinstance(cam, dict) and cam.get("form") == DISC.form:
        with suppress(ProfileFault):  # check_profile reports it
            least = least_distance_from_axis(place_profile_elements(elements))
            base = cam.get("base_radius")
            if base is None or not any(_check_base_radius(finite_number_or_none(base), least)):
                cam["base_radius"] = least


def profile_programme_if_known(scene: "Scene", load: ExternalLoad | None = None) -> Programme | None:
    """The motion of the follower on a given profile; None if a number is missing or wrong.

    Raises
    ------
    ProfileFault
        If the arcs and lines make no profile, or the follower cannot run on it.
    """
    elements = (
        None if scene.has_refused_value("profile") else _element_specs_or_none(scene.profile, scene.cam.rotation)
    )
    mechanism = mechanism_and_tip_named(DISC.form, scene.follower.motion, scene.follower.contact, scene.drive.kind)
    contact = mechanism and _profile_contact(
        mechanism[0], known_sizes(*mechanism, scene.follower, scene.cam), scene.cam.rotation
    )
    return programme_on_profile(place_profile_elements(elements), contact, load) if elements and contact else None


def highest_profile_displacement(scene: "Scene") -> float | None:
    """Largest displacement above the lowest [mm or deg]; None where unknown."""
    try:
        programme = profile_programme_if_known(scene)
    except ProfileFault:
        return None
    if programme is None:
        return None
    return degrees(programme.lift) if scene.follower.motion == OSCILLATING.name else programme.lift


def check_profile(scene: "Scene") -> Iterator[Fault]:
    """Every fault of a profile that involves more than one value."""
    if scene.motion:
        yield "profile", None, "a scene has either [[motion]] or [[profile]], since one follows from the other"
    form = scene.cam.form
    if form in [*BODIES] and form != DISC.form:
        yield "cam.form", form, "must be 'disc': arcs and lines are the profile of a disc cam"
    for k, row in enumerate(scene.profile, start=1):
        yield from _check_element(row, f"profile.{k}")
    elements = (
        None if scene.has_refused_value("profile") else _element_specs_or_none(scene.profile, scene.cam.rotation)
    )
    if elements:
        try:
            yield from _check_base_radius(
                known_number_or_none(scene.cam.base_radius),
                least_distance_from_axis(place_profile_elements(elements)),
            )
            profile_programme_if_known(scene)
        except ProfileFault as fault:
            yield f"profile.{fault.number}" if fault.number else "profile", None, fault.why


def _check_base_radius(base_radius: float | None, least_profile_radius: float) -> Iterator[Fault]:
    if base_radius is not None and abs(base_radius - least_profile_radius) > TOUCHING_SHARE * least_profile_radius:
        yield (
            "cam.base_radius",
            base_radius,
            f"the least radius of the profile is {least_profile_radius:.10g}: leave it out",
        )


# --------------------------------------------------------------------------------------------------- elements


def _check_element(row: tables.ProfileElement, key: str) -> Iterator[Fault]:
    if row.element == "line":
        for name in ("radius", "x", "y"):
            if getattr(row, name) is not None:
                yield f"{key}.{name}", VALUE_IN_SCENE, "a line has none: it is tangent to both neighbours"
    elif row.element == "arc":
        if row.radius is None:
            yield f"{key}.radius", None, "missing; an arc has a radius (mm), below 0 on a hollow flank"
        elif abs(row.radius) < LEAST_RADIUS:
            yield f"{key}.radius", VALUE_IN_SCENE, f"must be at least {LEAST_RADIUS:g} from 0"
        for name, other in (("x", "y"), ("y", "x")):
            if getattr(row, name) is None and getattr(row, other) is not None:
                yield f"{key}.{name}", None, "missing; a centre has x and y (mm)"


def _element_specs_or_none(rows: Sequence[tables.ProfileElement], rotation: Any) -> list[ElementSpec] | None:
    """The elements in the form of ``model.motion``; None if one has a fault."""
    if any(any(_check_element(row, "")) for row in rows):
        return None
    side = 1.0 if rotation == "cw" else -1.0  # mirrored unless the cam turns cw
    return [
        ElementSpec(row.radius, None if row.x is None or row.y is None else complex(row.x, side * row.y))
        for row in rows
    ]


def _profile_contact(mechanism: Mechanism, sizes: Mapping[str, float], rotation: str) -> ProfileContact | None:
    """The contact of a follower with a profile; None if the mechanism has no such contact, or a size is missing."""
    try:
        return mechanism.on_profile and mechanism.on_profile(sizes, -1.0 if rotation == "cw" else 1.0)
    except KeyError:
        return None

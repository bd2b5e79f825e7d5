"""The table ``[tolerances]`` of a scene: by how much the sizes of a real cam and follower may be off.

A tolerance is a number, ± in the unit of its key; a table with ``plus`` and ``minus``; or a class of ISO 286, such
as ``"h6"``, of a length, or of the diameter that a radius belongs to.
"""

from collections.abc import Iterator, Mapping
from math import sqrt
from numbers import Real
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import BeforeValidator, Field

from camopt.mechanisms import Mechanism
from camopt.mechanisms.follower import Tip
from camopt.scene.iso286 import deviations
from camopt.scene.law_forms import Fault
from camopt.scene.mapping import at, number_of
from camopt.scene.sizes import SIGNED_SIZES
from camopt.scene.tables import Length, NotNegative, Positive, SceneTable, whole_number

RADII = ("roller_radius", "face_radius")
"""Keys whose class of ISO 286 is that of a diameter."""
SPREADS = {"uniform": sqrt(3.0), "triangular": sqrt(6.0)}
"""How many standard deviations half of a zone is, of what ends with it."""
WITHIN = 3.0
"""The same of normal errors, at a Cpk of 1."""
MOST_WAVES = 10_000
HALF_TURN = 180.0
"""A cam that is further off on its shaft is less off the other way, deg."""


class Tolerance(SceneTable):
    """How far a size may be from what the scene says, and how it is spread over parts."""

    plus: NotNegative = 0.0
    """How much larger it may be; in the unit of the number."""
    minus: NotNegative = 0.0
    """How much smaller it may be; in the unit of the number."""
    iso: str | None = None
    """Its class of ISO 286 in place of both, such as h6 or JS9, of the diameter if the size is a radius."""
    distribution: Literal["normal", "uniform", "triangular"] = "normal"
    """How parts are spread over the zone."""
    cpk: Positive = 1.0
    """Process capability of a normal distribution: half of the zone is 3·cpk standard deviations; no unit."""


def _as_tolerance(value: Any) -> Any:
    if isinstance(value, str):
        return {"iso": value}
    if isinstance(value, Real) and not isinstance(value, bool):
        return {"plus": value, "minus": value}
    if isinstance(value, (Mapping, Tolerance)):
        return value
    raise ValueError("a number, a class of ISO 286 such as 'h6', or a table with plus and minus")


Given = (
    Annotated[Tolerance, BeforeValidator(_as_tolerance, json_schema_input_type=NotNegative | str | Tolerance)]
    | None
)


class FollowerTolerances(SceneTable):
    """Tolerances of the sizes of the follower, each ± a number, a class of ISO 286, or a table."""

    roller_radius: Given = None
    """Of the radius of the roller; mm."""
    face_radius: Given = None
    """Of the radius of a spherical face; mm."""
    offset: Given = None
    """Of the offset; mm."""
    arm_length: Given = None
    """Of the length of the arm; mm."""
    centre_distance: Given = None
    """Of the distance from the pivot to the cam's axis; mm."""
    face_offset: Given = None
    """Of the distance of an oscillating flat face from its pivot; mm."""


class Tolerances(SceneTable):
    """How far a real cam and its follower may be from what the scene says; errors that no key names are 0."""

    elsewhere: ClassVar[Mapping[str, str]] = {
        key: f"not a known key; did you mean tolerances.follower.{key}?" for key in FollowerTolerances.model_fields
    }

    follower: FollowerTolerances = FollowerTolerances()
    """Tolerances of the sizes of the follower."""
    profile: Length | None = None
    """Of the profile along its normal, ±; mm."""
    waves: Annotated[int, BeforeValidator(whole_number), Field(ge=1, le=MOST_WAVES)] | None = None
    """How many waves the error of the profile has in a turn at most: without it, no slope of it is known."""
    bore_eccentricity: Length | None = None
    """How far the bore's axis may be from that of the profile, in any direction; mm."""
    phase: Given = None
    """Of the cam's angle on its shaft; deg."""
    face_tilt: Given = None
    """Of the angle of a translating flat face to the square of its motion; deg."""


class Zone(NamedTuple):
    """How far a number may be from its nominal value, and how it is spread, in the unit of its key."""

    lower: float
    upper: float
    deviation: float
    """Standard deviation."""

    @property
    def middle(self) -> float:
        return (self.lower + self.upper) / 2

    def scaled(self, unit: float) -> "Zone":
        """The zone in another unit."""
        return Zone(*(unit * each for each in self))


def zone_of(given: Tolerance, key: str, size: float) -> Zone:
    """The zone of a size; ValueError for a class of ISO 286 that there is not for it."""
    if given.iso is None:
        lower, upper = -given.minus, given.plus
    else:
        share = 0.5 if key in RADII else 1.0
        lower, upper = (share * each for each in deviations(given.iso, abs(size) / share))
    half = (upper - lower) / 2
    return Zone(lower, upper, half / SPREADS.get(given.distribution, WITHIN * given.cpk))


def check_tolerances(data: Mapping[str, Any], mechanism: Mechanism, tip: Tip, name: str) -> Iterator[Fault]:
    """Check that there is what a tolerance is of, and that each class of ISO 286 has a zone for its size."""
    table = data.get("tolerances")
    if not isinstance(table, Mapping):
        return
    given = table.get("follower")
    for key, value in given.items() if isinstance(given, Mapping) else ():
        place = f"tolerances.follower.{key}"
        if key in FollowerTolerances.model_fields and value is not None:
            if key not in mechanism.follower_keys(tip):
                yield place, None, f"a {name} has no {key.replace('_', ' ')}"
            elif key in RADII and mechanism.two_sided:
                yield place, None, "is held by the groove from both sides: how thick it is does not move it"
            else:
                size = number_of(at(data, f"follower.{key}"))
                yield from _class(place, value, key, size)
                yield from _above_zero(place, value, key, size)
                yield from _capability(place, value)
    for key in ("profile", "bore_eccentricity"):
        size, off = number_of(at(data, f"cam.{mechanism.body.size}")), number_of(table.get(key))
        if size is not None and off is not None and off >= size:
            yield f"tolerances.{key}", off, f"must be below cam.{mechanism.body.size} ({size:g})"
    for key in ("phase", "face_tilt"):
        yield from _capability(f"tolerances.{key}", table.get(key))
        if any(each > HALF_TURN for each in _ends(table.get(key)) if each is not None):
            why = f"must be at most {HALF_TURN:g} deg: what is turned further is turned less the other way"
            yield f"tolerances.{key}", table[key], why
        if isinstance(table.get(key), str) or at(table, f"{key}.iso") is not None:
            yield f"tolerances.{key}", table[key], "must be an angle in deg: ISO 286 is for lengths"
    if table.get("face_tilt") is not None and (mechanism.motion.angular or not mechanism.flat_faced):
        yield "tolerances.face_tilt", None, "is for a translating follower with a flat face"
    yield from _robust(data, table)
    if table.get("waves") is not None and table.get("profile") is None:
        yield "tolerances.waves", table["waves"], "goes with tolerances.profile, which is missing"
    if table.get("profile") is not None and at(data, "part.profile_tolerance") is not None:
        yield (
            "part.profile_tolerance",
            at(data, "part.profile_tolerance"),
            "is tolerances.profile already: leave it out",
        )


def _robust(data: Mapping[str, Any], table: Mapping[str, Any]) -> Iterator[Fault]:
    """Check that searched sizes have tolerances that are the same for all of their values."""
    given = table.get("follower")
    if at(data, "search.robust") is not True or not isinstance(given, Mapping):
        return
    for key, value in given.items():
        of_class = isinstance(value, str) or at(given, f"{key}.iso") is not None
        if of_class and at(data, f"search.{key}") is not None:
            why = f"is of a size that [search] varies: with search.robust give ± mm, or leave out search.{key}"
            yield f"tolerances.follower.{key}", value, why


def _ends(value: Any) -> tuple[float | None, float | None]:
    """How much larger and smaller a number may be by its tolerance, where they are given."""
    if isinstance(value, Mapping):
        return number_of(value.get("plus")), number_of(value.get("minus"))
    return number_of(value), number_of(value)


def _capability(place: str, value: Any) -> Iterator[Fault]:
    """Check that a process capability is that of a normal distribution."""
    if isinstance(value, Mapping) and value.get("distribution") in SPREADS and value.get("cpk") not in (None, 1.0):
        why = f"a cpk is of a normal distribution, and this one is {value['distribution']}: leave out one of both"
        yield f"{place}.cpk", value["cpk"], why


def _above_zero(place: str, value: Any, key: str, size: float | None) -> Iterator[Fault]:
    """Check that the least size is above 0."""
    _, minus = _ends(value)
    if size is not None and minus is not None and key not in SIGNED_SIZES and minus >= size > 0.0:
        yield place, minus, f"must be below follower.{key} ({size:g}): no size is 0 or less"


def _class(place: str, value: Any, key: str, size: float | None) -> Iterator[Fault]:
    """Check a tolerance of a length: it is a zone, of plus and minus or of a class."""
    name = value if isinstance(value, str) else value.get("iso") if isinstance(value, Mapping) else None
    if not isinstance(name, str):
        return
    if isinstance(value, Mapping) and not {"plus", "minus"}.isdisjoint(value):
        yield place, name, "has a class and plus or minus: give one of both"
    elif size is None:
        yield place, name, f"needs follower.{key}: a class of ISO 286 is of a size"
    else:
        try:
            zone_of(Tolerance(iso=name), key, size)
        except ValueError as trouble:
            yield place, name, str(trouble)

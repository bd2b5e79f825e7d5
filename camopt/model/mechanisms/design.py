"""Designs as a structure of arrays, and the record of a mechanism."""

from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import BoolArray, ComplexArray, FloatArray
from camopt.core.numerics.interval import as_interval
from camopt.core.numerics.stable_functions import difference_of_squares_root, exact_sum
from camopt.model.mechanisms.contact_errors import ContactErrors, ContactPoint, ContactShift
from camopt.model.mechanisms.elements import Body, DriveKind, Flank, FollowerMotion, Tip
from camopt.model.motion.profile_contact import ProfileContact as OnProfile
from camopt.model.motion.programme import Programme

SIZE_FIELDS = ("size", "roller_radius", "offset", "arm_length", "centre_distance", "face_offset", "roller_spacing")
FIELDS = {
    "roller_spacing": "roller_spacing",
    "face_offset": "face_offset",
    "centre_distance": "centre_distance",
    "arm_length": "arm_length",
    "face_radius": "roller_radius",
    "roller_radius": "roller_radius",
    "offset": "offset",
    "mean_radius": "size",
    "base_radius": "size",
}
"""The arrays of ``Designs`` by the keys of a scene that give them or vary them, the slowest of a sweep first."""
SECOND_FIELDS = {
    "drive.arm_length": "second_arm_length",
    "drive.roller_radius": "second_roller_radius",
    "drive.offset": "second_offset",
    "drive.base_radius": "second_size",
}
"""Likewise the sizes of a second contact of the follower, which has those of the first where they are not given."""
SECOND_SIZE = SECOND_FIELDS["drive.base_radius"]
SECOND_FIELD_NAMES = frozenset(SECOND_FIELDS.values())
SizeBounds = dict[str, tuple[float, float]]
"""Closed intervals of the sizes of a design, by field of Designs; equal ends where a size is fixed."""


@dataclass(frozen=True)
class Designs:
    """Sizes of n designs that share a programme; lengths in mm, each an array (n,).

    ``size`` is that of the cam's body: the base radius of a disc, the mean radius of a cylinder. ``roller_radius``
    is the radius of whatever round body touches the cam: 0 for a knife edge, the face radius of a spherical face.
    ``sense`` is +1 for a cam that turns ccw, −1 for cw. Sizes that a mechanism has not are 0.
    """

    size: FloatArray
    roller_radius: FloatArray
    offset: FloatArray
    arm_length: FloatArray
    centre_distance: FloatArray
    face_offset: FloatArray
    roller_spacing: FloatArray
    sense: float
    numbers: Mapping[str, FloatArray] = field(default_factory=dict)
    """Other numbers of the scene that designs differ in, by key, in its units, each (n,).

    In searches of turns the angles of strokes too, deg: formulas of curves do not read them.
    """
    second: Mapping[str, FloatArray] = field(default_factory=dict)
    """Those sizes of a second contact that are not as of the first, by field (``SECOND_FIELDS``), each (n,)."""

    def __len__(self) -> int:
        return int(self.size.size)

    def take(self, index: Any) -> "Designs":
        """The designs at an index, mask or slice."""
        arrays = self.values
        apart = {id(each): each for each in arrays.values()}  # sizes that a mechanism has not share an array
        found = {key: each[index] for key, each in apart.items()}
        taken = self.with_values({name: found[id(each)] for name, each in arrays.items()})
        if "height" in vars(self):  # known already
            vars(taken)["height"] = self.height[index]
        return taken

    def replace_at(self, index: Any, others: "Designs") -> "Designs":
        """The designs, those at an index replaced by others."""
        arrays = {name: values.copy() for name, values in self.values.items()}
        for name, values in others.values.items():
            arrays[name][index] = values
        return self.with_values(arrays)

    def with_values(self, values: Mapping[str, Any]) -> "Designs":
        """The same designs with other sizes, by field, and other numbers, by key of the scene."""
        sizes = {name: value for name, value in values.items() if name in SIZE_FIELDS}
        others = {name: value for name, value in values.items() if name not in SIZE_FIELDS}
        second = {name: others.pop(name) for name in SECOND_FIELD_NAMES & others.keys()}
        return replace(
            self,
            **sizes,
            numbers={**self.numbers, **others},
            second={**self.second, **second} if second else self.second,
        )

    def without_numbers(self, names: Container[str]) -> "Designs":
        """The designs without some of the numbers that they bring."""
        return replace(self, numbers={name: each for name, each in self.numbers.items() if name not in names})

    @property
    def number_values(self) -> dict[str, float]:
        """The numbers that one design brings, by key."""
        return {key: float(value[0]) for key, value in self.numbers.items()}

    @property
    def sizes(self) -> dict[str, FloatArray]:
        """The arrays of sizes by name."""
        return {**{name: getattr(self, name) for name in SIZE_FIELDS}, **self.second}

    @property
    def values(self) -> dict[str, FloatArray]:
        """All arrays: sizes by name, numbers by key."""
        return {**self.sizes, **self.numbers}

    @property
    def prime_radius(self) -> FloatArray:
        return self.size + self.roller_radius

    @cached_property
    def height(self) -> FloatArray:
        """√(R_p² − e²), mm: how high a trace point moves above the cam's axis at least, if it does not swing."""
        root: FloatArray = difference_of_squares_root(self.size, self.offset, self.roller_radius)
        return root

    @cached_property
    def point_designs(self) -> "Designs":
        """As ``with_point_follower``."""
        prime, lost = exact_sum(self.size, self.roller_radius)
        return replace(self, size=prime, roller_radius=lost)

    @property
    def lead(self) -> FloatArray:
        """The signed offset of the formulas: positive if it lowers the pressure angle of the rise."""
        return self.sense * self.offset


def concatenate(parts: Iterable[Designs]) -> Designs:
    """Designs one after the other, of cams that turn the same way."""
    parts = list(parts)
    return parts[0].with_values({n: np.concatenate([part.values[n] for part in parts]) for n in parts[0].values})


def with_point_follower(designs: Designs) -> Designs:
    """Designs without a roller that have the same pitch curves: of disc cams, the prime circle as base circle.

    Curves take the sum of size and roller radius to its last digit. What rounding takes off the prime radius stays
    as a tiny "roller radius", so that the sum is the same, and equal designs come of pitch curves that are equal.
    """
    return designs.point_designs


def without_roller(designs: Designs) -> Designs:
    """Designs whose pitch curves do not depend on the roller, without it."""
    return replace(designs, roller_radius=np.zeros(len(designs)))


def without_size(designs: Designs) -> Designs:
    """Designs of which a size of the cam moves the whole profile along its normal, without it."""
    return replace(designs, size=np.zeros(len(designs)))


def with_central_face(designs: Designs) -> Designs:
    """Designs of which a face, further from its pivot by as much as the base circle is larger, moves the whole
    profile along its normal, with the face through the pivot."""
    return replace(designs, size=designs.size - designs.face_offset, face_offset=np.zeros(len(designs)))


def unshared_pitch(designs: Designs) -> Designs:
    """Designs that share no pitch curve."""
    return designs


SizeFault = tuple[str, Any, str]
"""A key of a scene, its value if that is at fault, and what is wrong."""


class Travel(NamedTuple):
    """The trace point in the ground frame, as complex x + iy, and the cam's outward normal there."""

    trace: ComplexArray
    normal: ComplexArray


class FurtherContact(NamedTuple):
    """A further contact of the follower, seen as that of an ordinary cam (``mechanisms.pairs``)."""

    mechanism: "Mechanism"
    """With the curves of its own motion, over that of the follower."""
    local_designs: Callable[[Designs], Designs]
    """From designs to their sizes at this contact."""


class Mechanism(NamedTuple):
    """A pairing of cam and follower: the curves of its quantities, and its points.

    Curves are NamedTuples with a registered formula (``numerics.curves``). A mechanism with a trace point has
    ``curvature`` (of the pitch curve), a flat-faced one ``profile_radius`` and ``reach``.
    """

    body: Body
    drive: DriveKind
    """What keeps its follower on the cam."""
    motion: FollowerMotion
    tips: tuple[Tip, ...]
    """What may touch the cam."""
    sizes: tuple[str, ...]
    """The fields of ``Designs`` that its follower has; ``roller_radius`` only with a tip that has a radius."""
    name: str
    pressure: Callable[[Designs, Programme], Any]
    """Curve tan β."""
    assembly_margins: Callable[[Designs, Programme], tuple[Any, ...]]
    """Numbers, or Intervals over boxes of designs, all above 0 where a design can be assembled at every angle."""
    assembly: str
    """That condition in words."""
    contact: Callable[[Designs, float, Any, Any, Any], ContactPoint]
    """From a design, the lift, the cam angle (rad), y and y' to where the follower touches or traces the cam."""
    shifted_contact: Callable[[Designs, float, Any, Any, ContactErrors], ContactShift]
    """From a design, the lift, y, y' and what is off to where the follower rests on the point it would touch."""
    sliding: Callable[[Designs, Programme], Any] | None = None
    """Curve of the speed at which the trace point or the flat face slides over a disc cam, mm/rad."""
    curvature: Callable[[Designs, Programme], Any] | None = None
    start: Callable[[Designs], Any] | None = None
    """Of a disc cam, the height of the trace point, or the angle of the arm, at displacement 0."""
    trace_point: Callable[[Designs, Any], tuple[Any, Any]] | None = None
    """(x, y) of the trace point in the ground frame, from its heights or angles; the prime radius is not used."""
    profile_radius: Callable[[Designs, Programme], Any] | None = None
    reach: Callable[[Designs, Programme], Any] | None = None
    outline: Callable[[Designs, Programme, Any], Any] | None = None
    """Curve whose largest value is that of the distance of a disc cam's profile from its axis, mm; the profile is
    so far beyond the trace point (a flat face touches it)."""
    path: Callable[[Designs, Programme], Any] | None = None
    """Of a cylindrical cam, curve of how far the trace point moves along the developed groove, mm/rad."""
    speeding: Callable[[Designs, Programme], Any] | None = None
    """Curve of the derivative by the cam angle of the speed of the trace point over the cam, mm/rad²."""
    pitch: Callable[[Designs], Designs] = unshared_pitch
    """For designs those with the same pitch curves that are alike if these are; of a flat face: the same but for
    how far ``parallel`` has moved the profile. What effects find of pitch curves they find of these."""
    profile: Callable[[Designs], Designs] | None = None
    """As ``pitch``, where effects find of the pitch curve what ``parallel`` changes too."""
    parallel: str = "roller_radius"
    """The size, by field of ``Designs``, that moves the profile along its normal, as the roller does from a pitch
    curve (a flat face square to the motion: the base radius)."""
    misfit: Callable[[Mapping[str, float]], SizeFault | None] = lambda sizes: None
    """From the sizes of one design in mm, by field, and its ``lift`` in the unit of the motion: why it cannot be
    put together at its lowest or highest position; KeyError where it needs one that is not there."""
    on_profile: Callable[[Mapping[str, float], float], OnProfile] | None = None
    """From such sizes and the sense of rotation, the follower as it meets arcs and lines of a profile."""
    way: float = 1.0
    """−1 for a contact that a force on the follower presses on which points back towards the cam."""
    reverses: bool = False
    """Whether its own motion is that of the follower reversed."""
    further_contacts: tuple[FurtherContact, ...] = ()
    """The contacts of the follower beside this one."""

    def follower_keys(self, tip: Tip) -> tuple[str, ...]:
        """The keys of ``[follower]`` that give the sizes of a follower with a tip."""
        return tuple(filter(None, (tip.radius if name == "roller_radius" else name for name in self.sizes)))

    def keys(self, tip: Tip) -> tuple[str, ...]:
        """The keys of a scene that give its sizes, as ``cam.base_radius``, that of the body first."""
        return (f"cam.{self.body.size}", *(f"follower.{key}" for key in self.follower_keys(tip)))

    @property
    def flanks(self) -> tuple[Flank, ...]:
        """The sides of the cam that touch its follower."""
        return self.drive.flanks

    @property
    def flat_faced(self) -> bool:
        """Whether the follower's face is flat: no trace point, so that there is no pitch curve."""
        return self.curvature is None

    def moves_as(self, *others: "Mechanism") -> bool:
        """Whether its follower moves over the cam as in one of some mechanisms, whatever keeps it there."""
        return any(self.pressure is other.pressure for other in others)

    @property
    def pitch_ignores_parallel(self) -> bool:
        """Whether pitch curves do not depend on ``parallel`` at all; else on its sum with the size of the cam."""
        return self.pitch in (without_roller, without_size)

    @property
    def profile_or_pitch(self) -> Callable[[Designs], Designs]:
        """For designs those with the same profiles, but for how far ``parallel`` has moved them."""
        return self.profile or self.pitch

    @property
    def pitch_curves(self) -> tuple[Callable[[Designs, Programme], Any] | None, ...]:
        """Its curves that designs with the same pitch curve share."""
        if self.flat_faced:
            return (self.reach,) if self.profile else (self.pressure, self.reach)
        return self.pressure, self.curvature, self.sliding, self.path, self.speeding

    @property
    def size_quantities(self) -> dict[str, str]:
        """The quantity that each of its sizes is in tables, by field of ``Designs``."""
        second = {SECOND_FIELDS[key]: f"second_{key.partition('.')[2]}_mm" for key in self.second_keys}
        return {"size": self.body.size_quantity, **{field: f"{field}_mm" for field in self.sizes}, **second}

    @property
    def second_keys(self) -> tuple[str, ...]:
        """The keys of a scene that give sizes of a second contact, where they are not those of the first."""
        own = self.drive.keys if self.further_contacts else ()
        return tuple(key for key in SECOND_FIELDS if key.partition(".")[2] in own)

    @property
    def two_profiles(self) -> bool:
        """Whether its second contact is on a profile of its own: of a second disc, or another flank of a rib."""
        return bool(self.further_contacts) and not self.drive.one_disc

    @property
    def has_rib(self) -> bool:
        """Whether two rollers of its follower have a rib of the cam between them."""
        return bool(self.further_contacts) and self.touches_rib

    @property
    def touches_rib(self) -> bool:
        """Whether its follower touches a rib, with both rollers or as one of them."""
        return "roller_spacing" in self.sizes

    @property
    def trace_speed(self) -> Callable[[Designs, Programme], Any] | None:
        """Curve of the speed of the trace point over the cam, mm/rad."""
        return self.path or (None if self.flat_faced else self.sliding)

    @property
    def pulls(self) -> bool:
        """Whether a flank bears a force that pulls the follower back towards the cam."""
        return any(flank.pressing < 0.0 for flank in self.flanks)

    @property
    def is_positive(self) -> bool:
        """Whether the cam itself keeps the follower where it is, whatever the sign of the force."""
        return self.pulls or bool(self.further_contacts)

    @property
    def two_sided(self) -> bool:
        """Whether each bend of the pitch curve is a bulge of one flank and a hollow of another."""
        return len({flank.side for flank in self.flanks}) > 1

    @property
    def cut_as_by_roller(self) -> bool:
        """Whether nothing larger than the roller cuts its flanks: both of a groove, and those of a cylinder at each
        depth."""
        return self.two_sided or self.body.developed

    def travel(self, design: Designs, programme: Programme, angles: FloatArray) -> Travel:
        """Trace point (flat faces: contact point) and unit normal of one design at cam angles (m,)."""
        lift, (y, y1, *_) = programme.lift, self.contact_programme(programme).motion_at(angles)
        found = self.contact(design, lift, angles, y, y1)
        normal = found.across + 1j * found.up
        return Travel(found.x + 1j * found.y, normal / np.abs(normal))

    def contact_programme(self, programme: Programme) -> Programme:
        """The motion that the cam gives at this contact, from that of the follower."""
        return programme.reversed_programme if self.reverses else programme

    def with_no_assembly(self, why: str) -> "Mechanism":
        """The same of which no design can be assembled, for a reason."""
        return self._replace(assembly_margins=_no_assembly_margin, assembly=why)

    @property
    def has_no_assembly(self) -> bool:
        """Whether it is one of which no design can be assembled."""
        return self.assembly_margins is _no_assembly_margin

    def can_assemble(self, designs: Designs, programme: Programme) -> BoolArray:
        """Which designs can be assembled at every cam angle."""
        held = np.ones(len(designs), dtype=bool)
        for margin in self.assembly_margins(designs, programme):
            held &= margin > 0.0
        return held

    def cannot_assemble(self, boxes: Designs, programme: Programme) -> BoolArray:
        """Which boxes (designs of Intervals) hold no design that can be assembled."""
        lacking = np.zeros(len(boxes), dtype=bool)
        for margin in self.assembly_margins(boxes, programme):
            lacking |= as_interval(margin).high <= 0.0
        return lacking


def _no_assembly_margin(designs: Designs, programme: Programme) -> tuple[FloatArray]:
    return (np.full(len(designs), -1.0),)

"""Designs as a structure of arrays, and ``Mechanism``, the record of a pairing of cam and follower."""

from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import BoolArray, ComplexArray, FloatArray, Number
from camopt.core.numerics.interval import as_interval
from camopt.core.numerics.stable_functions import difference_of_squares_root, exact_sum, triangle_angle
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
"""The arrays of ``Designs``, by the keys of a scene that give or vary them. A sweep varies the first one
slowest."""
SECOND_FIELDS = {
    "drive.arm_length": "second_arm_length",
    "drive.roller_radius": "second_roller_radius",
    "drive.offset": "second_offset",
    "drive.base_radius": "second_size",
}
"""The sizes of a follower's second contact, by key of a scene; one that is not given is that of the first
contact."""
SECOND_SIZE = SECOND_FIELDS["drive.base_radius"]
SECOND_FIELD_NAMES = frozenset(SECOND_FIELDS.values())
SizeBounds = dict[str, tuple[float, float]]
"""Closed intervals of the sizes of a design, by field of ``Designs``; a fixed size has equal ends."""


@dataclass(frozen=True)
class Designs:
    """Sizes of n designs that share a programme [mm], each an array (n,).

    ``size`` is the base radius of a disc, or the mean radius of a cylinder. ``roller_radius`` is the radius of the
    round body that touches the cam: the face radius of a spherical face, 0 for a knife edge. ``sense`` is +1 for a
    cam that turns ccw, −1 for cw. Sizes that a mechanism does not have are 0.
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
    """Other numbers of the scene in which designs differ, by key, in the scene's units, each (n,).

    Searches of turns put the angles of strokes here too [deg]; no formula of a curve reads them.
    """
    second: Mapping[str, FloatArray] = field(default_factory=dict)
    """The sizes of a second contact that differ from those of the first, by field (``SECOND_FIELDS``), each
    (n,)."""

    def __len__(self) -> int:
        return int(self.size.size)

    def take(self, index: Any) -> "Designs":
        """The designs at an index, mask or slice."""
        arrays = self.values
        distinct = {id(array): array for array in arrays.values()}  # unused sizes share one array of zeros
        parts = {key: array[index] for key, array in distinct.items()}
        designs = self.with_values({name: parts[id(array)] for name, array in arrays.items()})
        if "height" in vars(self):  # cached already
            vars(designs)["height"] = self.height[index]
        return designs

    def as_columns(self) -> "Designs":
        """The designs as columns (n, 1), one design a row, for formulas at many cam angles."""
        return self.with_values({name: values[:, None] for name, values in self.values.items()})

    def replace_at(self, index: Any, others: "Designs") -> "Designs":
        """The designs with those at an index replaced by others."""
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
        return replace(self, numbers={name: each for name, each in self.numbers.items() if name not in names})

    @property
    def number_values(self) -> dict[str, float]:
        """The numbers of a single design, by key."""
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
    def height(self) -> Number:
        """Least height of a translating trace point above the cam's axis, s₀ = √(R_p² − e²) [mm]."""
        return difference_of_squares_root(self.size, self.offset, self.roller_radius)

    @cached_property
    def start_arm_angle(self) -> Number:
        """Angle ψ₀ of an oscillating arm at displacement 0 [rad]."""
        return triangle_angle(self.centre_distance, self.arm_length, self.size, self.roller_radius)

    @cached_property
    def knife_edge_designs(self) -> "Designs":
        """Disc cams of the same pitch curves with a knife edge: the prime circle becomes the base circle.

        Curves need the sum of size and roller radius to its last digit. So the rounding error of the prime radius
        stays as a tiny "roller radius". Equal pitch curves then give equal designs.
        """
        prime, rounding = exact_sum(self.size, self.roller_radius)
        return replace(self, size=prime, roller_radius=rounding)

    @property
    def signed_offset(self) -> FloatArray:
        """Signed offset of the formulas [mm]; positive if it lowers the pressure angle of the rise."""
        return self.sense * self.offset


def concatenate_designs(parts: Iterable[Designs]) -> Designs:
    """Several designs joined into one structure; their cams turn the same way."""
    parts = list(parts)
    return parts[0].with_values({n: np.concatenate([part.values[n] for part in parts]) for n in parts[0].values})


def with_zero_roller_radius(designs: Designs) -> Designs:
    """Designs with roller radius 0; for mechanisms whose pitch curve does not depend on the roller."""
    return replace(designs, roller_radius=np.zeros(len(designs)))


def with_zero_cam_size(designs: Designs) -> Designs:
    """Designs with cam size 0; for mechanisms where the size only moves the profile along its normal."""
    return replace(designs, size=np.zeros(len(designs)))


def with_face_through_pivot(designs: Designs) -> Designs:
    """Designs with the flat face through its pivot.

    A larger face offset, with a base radius larger by as much, only moves the profile along its normal.
    """
    return replace(designs, size=designs.size - designs.face_offset, face_offset=np.zeros(len(designs)))


def unreduced_designs(designs: Designs) -> Designs:
    """The designs themselves; for mechanisms where no two designs share a pitch curve."""
    return designs


SizeFault = tuple[str, Any, str]
"""A key of a scene, its value if that is wrong (else None), and the message."""


class Travel(NamedTuple):
    """The trace point in the ground frame, as complex x + iy [mm], and the cam's outward unit normal there."""

    trace: ComplexArray
    normal: ComplexArray


class FurtherContact(NamedTuple):
    """A second contact of the follower, as the contact of an ordinary cam (``mechanisms.pairs``)."""

    mechanism: "Mechanism"
    """Its curves take the motion of the follower, and compute with the motion at this contact."""
    local_designs: Callable[[Designs], Designs]
    """The sizes of designs at this contact."""


CurveMaker = Callable[[Designs, Programme], Any]
"""A function that makes a curve of the contact over the turn, from designs and their motion."""
OutlineMaker = Callable[[Designs, Programme, Any], Any]
"""The same, from a distance beyond the trace point too."""


class Mechanism(NamedTuple):
    """A pairing of cam and follower: the curves of its quantities, and the points of contact.

    Curves are NamedTuples with a registered formula (``numerics.curves``). A mechanism with a trace point has
    ``curvature``, a flat-faced one ``profile_radius`` and ``reach``.
    """

    body: Body
    drive: DriveKind
    """What keeps the follower on the cam."""
    motion: FollowerMotion
    tips: tuple[Tip, ...]
    """The kinds of tip that may touch the cam."""
    sizes: tuple[str, ...]
    """The fields of ``Designs`` that the follower has; ``roller_radius`` only if its tip has a radius."""
    name: str
    pressure: CurveMaker
    """Curve tan β."""
    assembly_margins: Callable[[Designs, Programme], tuple[Any, ...]]
    """Numbers that are all positive if a design can be assembled at every angle; Intervals for boxes of designs."""
    assembly: str
    """The condition of assembly in words."""
    contact: Callable[[Designs, float, Any, Any, Any], ContactPoint]
    """The contact, or the trace point, from a design, the lift, the cam angle [rad], y and y'."""
    shifted_contact: Callable[[Designs, float, Any, Any, ContactErrors], ContactShift]
    """The contact of a real follower at the same point of the cam, from a design, the lift, y, y' and the
    errors."""
    sliding: CurveMaker | None = None
    """Curve of the speed of the trace point or the flat face over a disc cam [mm/rad]."""
    curvature: CurveMaker | None = None
    """Curve of the curvature of the pitch curve [1/mm]."""
    start: Callable[[Designs], Any] | None = None
    """Height of a disc cam's trace point [mm], or angle of the arm [rad], at displacement 0."""
    trace_point: Callable[[Designs, Any], tuple[Any, Any]] | None = None
    """(x, y) of the trace point in the ground frame, from its height or angle; the prime radius is not used."""
    profile_radius: CurveMaker | None = None
    """Curve of the radius of curvature of a flat-faced follower's profile [mm]."""
    reach: CurveMaker | None = None
    """Curve of the contact's place along a flat face [mm]."""
    outline: OutlineMaker | None = None
    """Curve whose largest value is the largest distance of a disc cam's profile from its axis [mm].

    Its third argument is how far the profile is beyond the trace point; a flat face does not use it.
    """
    path: CurveMaker | None = None
    """Curve of the speed of the trace point along a groove; of a cylinder's, in its development [mm/rad]."""
    speeding: CurveMaker | None = None
    """Curve of the change of the trace point's speed over the cam with the cam angle [mm/rad²]."""
    pitch: Callable[[Designs], Designs] = unreduced_designs
    """Reduces designs to standard ones with the same pitch curve: two are equal if their pitch curves are.

    With a flat face, two are equal if only ``parallel`` makes a difference. Effects compute quantities of the pitch
    curve once for each standard design.
    """
    profile: Callable[[Designs], Designs] | None = None
    """Reduces designs as ``pitch`` does, for mechanisms whose quantities of the pitch curve depend on
    ``parallel``."""
    parallel: str = "roller_radius"
    """The size, by field of ``Designs``, that moves the profile along its normal.

    A roller moves it from the pitch curve; with a flat face square to the motion the base radius moves it.
    """
    misfit: Callable[[Mapping[str, float]], SizeFault | None] = lambda sizes: None
    """Why a design cannot be assembled at its lowest or highest position, or None.

    It takes the sizes of one design by field [mm] and its ``lift`` in the unit of the motion. Raises KeyError if a
    size is missing.
    """
    on_profile: Callable[[Mapping[str, float], float], OnProfile] | None = None
    """The follower on a profile of arcs and lines, from the same sizes and the sense of rotation."""
    way: float = 1.0
    """−1 if a force towards the cam's axis presses the follower on this contact, else 1."""
    reverses: bool = False
    """Whether the motion at this contact is that of the follower reversed."""
    further_contacts: tuple[FurtherContact, ...] = ()
    """The other contacts of the follower."""

    def follower_size_keys(self, tip: Tip) -> tuple[str, ...]:
        """The keys of ``[follower]`` that give the sizes of a follower with a tip."""
        return tuple(filter(None, (tip.radius if name == "roller_radius" else name for name in self.sizes)))

    def keys(self, tip: Tip) -> tuple[str, ...]:
        """The keys of a scene that give its sizes, such as ``cam.base_radius``; that of the body first."""
        return (f"cam.{self.body.size_key}", *(f"follower.{key}" for key in self.follower_size_keys(tip)))

    @property
    def flanks(self) -> tuple[Flank, ...]:
        return self.drive.flanks

    @property
    def flat_faced(self) -> bool:
        """Whether the follower's face is flat; then there is no trace point and no pitch curve."""
        return self.curvature is None

    def moves_as(self, *others: "Mechanism") -> bool:
        """Whether its follower moves over the cam as in one of the other mechanisms, whatever the drive."""
        return any(self.pressure is other.pressure for other in others)

    @property
    def pitch_ignores_parallel_size(self) -> bool:
        """Whether pitch curves do not depend on ``parallel``; if they do, they depend on its sum with ``size``."""
        return self.pitch in (with_zero_roller_radius, with_zero_cam_size)

    @property
    def standard_profile_reduction(self) -> Callable[[Designs], Designs]:
        """Function that reduces designs to standard ones.

        Two of these are equal if their profiles differ only by ``parallel``.
        """
        return self.profile or self.pitch

    @property
    def curves_shared_by_pitch_curve(self) -> tuple[CurveMaker | None, ...]:
        """The curves that designs with the same pitch curve share."""
        if self.flat_faced:
            return (self.reach,) if self.profile else (self.pressure, self.reach)
        return self.pressure, self.curvature, self.sliding, self.path, self.speeding

    @property
    def size_quantity_by_field(self) -> dict[str, str]:
        """The quantities of its sizes in tables, by field of ``Designs``."""
        second = {SECOND_FIELDS[key]: f"second_{key.partition('.')[2]}_mm" for key in self.second_contact_size_keys}
        return {"size": self.body.size_quantity, **{field: f"{field}_mm" for field in self.sizes}, **second}

    @property
    def second_contact_size_keys(self) -> tuple[str, ...]:
        """The keys of a scene that give sizes of a second contact."""
        drive_keys = self.drive.keys if self.further_contacts else ()
        return tuple(key for key in SECOND_FIELDS if key.partition(".")[2] in drive_keys)

    @property
    def has_two_profiles(self) -> bool:
        """Whether its second contact is on another profile: that of a second disc, or another flank of a rib."""
        return bool(self.further_contacts) and not self.drive.one_disc

    @property
    def has_rib(self) -> bool:
        """Whether a rib of the cam is between two rollers of its follower."""
        return bool(self.further_contacts) and self.touches_rib

    @property
    def touches_rib(self) -> bool:
        """Whether it is a follower on a rib, or one roller of such a follower."""
        return "roller_spacing" in self.sizes

    @property
    def trace_speed_curve_maker(self) -> CurveMaker | None:
        """Curve of the speed of the trace point over the cam [mm/rad]; None with a flat face."""
        return self.path or (None if self.flat_faced else self.sliding)

    @property
    def can_pull_follower(self) -> bool:
        """Whether a flank can pull the follower back towards the cam."""
        return any(flank.pressing < 0.0 for flank in self.flanks)

    @property
    def is_positive_drive(self) -> bool:
        """Whether the cam drives the follower both ways (form closure), without a spring."""
        return self.can_pull_follower or bool(self.further_contacts)

    @property
    def has_flanks_on_both_sides(self) -> bool:
        """Whether the flanks are on both sides of the pitch curve; a bulge of one is then a hollow of the other."""
        return len({flank.side for flank in self.flanks}) > 1

    @property
    def is_cut_by_roller_sized_cutter(self) -> bool:
        """Whether a cutter of the roller's size cuts its flanks, as in a groove or on a cylinder."""
        return self.has_flanks_on_both_sides or self.body.developed

    def trace_and_normal(self, design: Designs, programme: Programme, angles: FloatArray) -> Travel:
        """Trace point (flat faces: contact point) and unit normal of one design at cam angles (m,)."""
        lift, (y, y1, *_) = programme.lift, self.contact_programme(programme).motion_at(angles)
        point = self.contact(design, lift, angles, y, y1)
        normal = point.across + 1j * point.up
        return Travel(point.x + 1j * point.y, normal / np.abs(normal))

    def contact_programme(self, programme: Programme) -> Programme:
        """The motion at this contact, from that of the follower."""
        return programme.reversed_programme if self.reverses else programme

    def with_no_assembly(self, reason: str) -> "Mechanism":
        """The same mechanism where no design can be assembled, with the reason."""
        return self._replace(assembly_margins=_no_assembly_margin, assembly=reason)

    @property
    def has_no_assembly(self) -> bool:
        """Whether no design can be assembled (``with_no_assembly``)."""
        return self.assembly_margins is _no_assembly_margin

    def can_assemble(self, designs: Designs, programme: Programme) -> BoolArray:
        """Which designs can be assembled at every cam angle."""
        fits = np.ones(len(designs), dtype=bool)
        for margin in self.assembly_margins(designs, programme):
            fits &= margin > 0.0
        return fits

    def cannot_assemble(self, boxes: Designs, programme: Programme) -> BoolArray:
        """Which boxes (designs of Intervals) contain no design that can be assembled."""
        empty = np.zeros(len(boxes), dtype=bool)
        for margin in self.assembly_margins(boxes, programme):
            empty |= as_interval(margin).high <= 0.0
        return empty


def _no_assembly_margin(designs: Designs, programme: Programme) -> tuple[FloatArray]:
    return (np.full(len(designs), -1.0),)

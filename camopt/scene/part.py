"""The table ``[part]`` of a scene: the cam as a workpiece, and the checks of its sizes.

A disc cam is a plate with a bore, a keyway and a hub on one side, or a round plate with a groove in its face. A
conjugate pair is two plates of equal thickness on one bore and hub. A cylindrical cam is a cylinder with a groove;
the mean radius is at half the depth of the groove.
"""

import re
from collections.abc import Iterator
from datetime import date
from functools import partial
from math import asin, hypot, radians, sin
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from camopt.core.quantities.key import LENGTHS, Key
from camopt.model.mechanisms import Mechanism
from camopt.model.mechanisms.elements import DISC, EVERY_BODY, Body
from camopt.scene.fits import FIT, SHAFT_FIT
from camopt.scene.law_forms import VALUE_IN_SCENE, Fault
from camopt.scene.sizes import known_number_or_none
from camopt.scene.tables import (
    BoundedNumber,
    Length,
    Positive,
    SceneTable,
    SignedNumber,
    allow_text_in_schema,
    check_one_line,
    check_two_numbers,
)

if TYPE_CHECKING:
    from camopt.scene.scene import Scene


def _check_fit(value: Any, pattern: str, example: str) -> str:
    if not isinstance(value, str) or not re.fullmatch(pattern, value):
        raise ValueError(f"a fit of ISO 286, such as {example}")
    return value


def _date_as_text(value: Any) -> Any:
    return value.isoformat() if isinstance(value, date) else check_one_line(value)


def _number_as_text(value: Any) -> Any:
    if isinstance(value, float):  # as a float, the steel 1.4310 would lose its last zero
        raise ValueError("a text, in quotes")
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else check_one_line(value)


OneLine = Annotated[str, BeforeValidator(check_one_line)]
NumberedText = Annotated[str, BeforeValidator(_number_as_text, json_schema_input_type=str | int)]
"""A text that may be a whole number, without quotes."""
HoleFit = Annotated[str, BeforeValidator(partial(_check_fit, pattern=FIT, example="H7"))]
ShaftFit = Annotated[str, BeforeValidator(partial(_check_fit, pattern=SHAFT_FIT, example="h9"))]
TOWARDS_FOLLOWER = 90.0
HUB_KEYS, KEYWAY_KEYS = DISC.part, ("keyway_width", "keyway_depth")
USUAL_GAP = 0.25  # share of the thickness: gap between the discs of a pair, so that the rollers clear each other


class Part(SceneTable):
    """The cam as a workpiece, and the texts of its drawing. Every key is optional.

    The groove of a cylindrical cam runs in the middle of its thickness. ``keyway_angle`` is 90 if not given: at cam
    angle 0 the keyway then points to a translating follower.
    """

    thickness: Annotated[
        Length | None,
        Key(
            "Thickness of the plate of a disc cam, or length of a cylindrical cam along its axis",
            "mm",
            example=60,
            usual=LENGTHS,
        ),
    ] = None
    disc_gap: Annotated[
        Length | None,
        Key(
            "Gap between the plates of a conjugate pair; a quarter of the thickness if not given",
            "mm",
            usual=LENGTHS,
        ),
    ] = None
    bore: Annotated[
        Length | None,
        Field(json_schema_extra=allow_text_in_schema),
        Key(
            "Diameter of the bore, or a text with its fit, such as 30 H7; `cam.shaft_diameter` if not given",
            "mm",
            example=20,
            usual=LENGTHS,
        ),
    ] = None
    bore_fit: Annotated[HoleFit | None, Key("Fit of the bore (ISO 286), such as H7")] = None
    hub_diameter: Annotated[
        Length | None, Key("Diameter of the hub, at most the diameter of the base circle", "mm", usual=LENGTHS)
    ] = None
    hub_length: Annotated[
        Length | None,
        Key("Length of the hub, including the plate (of a pair: both plates and their gap)", "mm", usual=LENGTHS),
    ] = None
    keyway: Annotated[
        Literal["DIN 6885"] | None,
        Key("Standard of the keyway: DIN 6885 sets its width and depth by the bore"),
    ] = None
    keyway_width: Annotated[Length | None, Key("Width of the keyway", "mm", usual=LENGTHS)] = None
    keyway_fit: Annotated[HoleFit | None, Key("Fit of the width of the keyway, such as JS9")] = None
    keyway_depth: Annotated[
        Length | None,
        Key(
            "Depth of the keyway in the hub (t₂ of DIN 6885), from the surface of the bore at mid-width",
            "mm",
            usual=LENGTHS,
        ),
    ] = None
    keyway_angle: Annotated[
        Annotated[float, BoundedNumber(ge=-360, le=360)] | None,
        Key("Direction of the middle of the keyway in the frame of the cam, ccw from x; 90 if not given", "deg"),
    ] = None
    outer_diameter: Annotated[
        Length | None, Key("Outer diameter of a disc cam with a groove in its face or a rib on it", "mm")
    ] = None
    groove_depth: Annotated[Length | None, Key("Depth of the groove", "mm", example=8, usual=LENGTHS)] = None
    rib_height: Annotated[
        Length | None,
        Key(
            "Height of the rib. On a cylinder the mean radius is at half of it; on a disc it is part of the "
            "thickness",
            "mm",
            example=8,
            usual=LENGTHS,
        ),
    ] = None
    groove_fit: Annotated[
        HoleFit | None, Key("Fit of the groove, such as H8; its width is the diameter of the roller")
    ] = None
    groove_chamfer: Annotated[
        Length | None, Key("Chamfer of the groove's edges at 45°, only for the drawing", "mm")
    ] = None
    outer_fit: Annotated[ShaftFit | None, Key("Fit of the outer diameter of a cylindrical cam, such as h9")] = None
    density: Annotated[
        Positive | None,
        Key("Density; the density of `materials.cam` if not given", "kg/m³", usual=(500.0, 25000.0)),
    ] = None
    material: Annotated[
        NumberedText | None, Key("Material in the title block; `materials.cam` if not given", example="16MnCr5")
    ] = None
    hardness: Annotated[
        OneLine | None, Key("Hardness in the title block, such as 58 + 4 HRC", example="58 + 4 HRC")
    ] = None
    case_depth: Annotated[OneLine | None, Key("Case hardening depth in the title block, such as 0.8 + 0.4")] = None
    profile_tolerance: Annotated[Length | None, Key("Tolerance of the profile, ±", "mm", usual=(1e-4, 1.0))] = None
    roughness: Annotated[Positive | None, Key("Roughness Ra of the profile", "µm", usual=(0.005, 50.0))] = None
    other_roughness: Annotated[Positive | None, Key("Roughness Ra of all other surfaces", "µm")] = None
    general_tolerances: Annotated[OneLine | None, Key("General tolerances of the drawing, such as ISO 2768-mK")] = (
        None
    )
    edges: Annotated[
        Annotated[tuple[SignedNumber, SignedNumber], BeforeValidator(check_two_numbers)] | None,
        Key("Outer and inner edges by ISO 13715, below 0 where material is removed", "mm"),
    ] = None
    name: Annotated[OneLine | None, Key("Name in the title block; the scene's name if not given")] = None
    number: Annotated[NumberedText | None, Key("Number of the drawing")] = None
    designer: Annotated[OneLine | None, Key("Designer, for the title block")] = None
    approved_by: Annotated[OneLine | None, Key("Person who approved the drawing")] = None
    legal_owner: Annotated[OneLine | None, Key("Company that owns the drawing")] = None
    revision: Annotated[NumberedText | None, Key("Revision index, such as A")] = None
    date_of_issue: Annotated[
        Annotated[str, BeforeValidator(_date_as_text)] | None,
        Key("Date of issue, as a text or a TOML date such as 2026-11-25"),
    ] = None
    language: Annotated[Literal["en", "de"], Key("Language of the drawing")] = "en"
    standard: Annotated[
        Literal["iso", "asme"] | None,
        Key(
            "Standard of the drawing: iso is in mm with first-angle projection, asme in inches with third-angle "
            "projection and in English; if not given, the shown units decide"
        ),
    ] = None

    @property
    def plate_extents(self) -> tuple[tuple[float, float], ...]:
        """Back and front of each plate along the axis [mm]; empty without a thickness.

        The last plate starts at 0. The first plate is nearest to the viewer in the front view.
        """
        if self.thickness is None:
            return ()
        feet = [0.0] if self.disc_gap is None else [self.thickness + self.disc_gap, 0.0]
        return tuple((foot, foot + self.thickness) for foot in feet)

    @property
    def width(self) -> float:
        """Distance from the back of the last plate to the front of the first [mm]; 0 without a thickness."""
        return max((high for _, high in self.plate_extents), default=0.0)

    @property
    def has_protruding_hub(self) -> bool:
        """Whether the hub is longer than the plates within it."""
        return (self.hub_length or 0.0) > self.width

    def disc_part(self, disc: int | None) -> "Part":
        """One disc of a pair. Without a common hub it is a separate part with its own number."""
        if disc is None or self.hub_diameter or not self.number:
            return self
        return self.model_copy(update={"number": f"{self.number}/{disc}"})

    @property
    def bore_reach(self) -> float:
        """Largest distance of the bore with its keyway from the axis [mm]; 0 without a bore."""
        return bore_or_keyway_reach(self.bore or 0.0, self.keyway_width or 0.0, self.keyway_depth or 0.0)


def bore_or_keyway_reach(bore: float, width: float, depth: float) -> float:
    """Distance from the axis to the corners of the keyway, or to the bore's surface without one [mm]."""
    return hypot(bore / 2 + depth, width / 2) if width else bore / 2


def check_part(
    scene: "Scene", mechanism: Mechanism, lift: float | None, tip_radius: float | None
) -> Iterator[Fault]:
    """Check that the sizes of the part are consistent and lie inside the cam.

    ``lift`` of the follower is in mm, or in deg of its arm; ``tip_radius`` is the radius of a roller or
    spherical face [mm].
    """
    part, body = scene.part, mechanism.body
    for key in dict.fromkeys(key for other in EVERY_BODY for key in other.part if key not in body.part):
        if getattr(part, key) is not None:
            yield f"part.{key}", VALUE_IN_SCENE, f"a {body.words} has none"
    if part.disc_gap is not None and not mechanism.second_contact_size_keys:
        yield "part.disc_gap", VALUE_IN_SCENE, "only a conjugate pair has a gap; this cam has one disc"
    shaft, bore = known_number_or_none(scene.cam.shaft_diameter), known_number_or_none(part.bore)
    if shaft and bore and shaft != bore:
        yield "part.bore", bore, f"must equal cam.shaft_diameter ({shaft:g}); or leave one of them out"
        return
    hole = _Hole(scene)
    yield from _check_keyway(part, hole)
    if body.closed:
        bases = map(known_number_or_none, (getattr(scene.cam, body.size_key), scene.drive.base_radius))
        base = min(filter(None, bases), default=None)
        yield from (
            _check_hub(part, hole, base, 1 + bool(mechanism.second_contact_size_keys)) if body.bounded else ()
        )
        yield from _check_bore_and_keyway_inside(part, hole, base, "the base circle (radius {:g})")
        yield from _check_face_groove_or_rib_height(part, body)
    else:
        yield from _check_groove(scene, hole, mechanism, lift, tip_radius)


class _Hole:
    """The hole of a part: diameter of the bore, and largest distance of bore and keyway from the axis [mm]."""

    def __init__(self, scene: "Scene") -> None:
        part = scene.part
        self.is_given = part.bore is not None or scene.cam.shaft_diameter is not None
        self.bore = known_number_or_none(scene.cam.shaft_diameter if part.bore is None else part.bore)
        width, depth = (known_number_or_none(getattr(part, key)) or 0.0 for key in KEYWAY_KEYS)
        self.reach = None if self.bore is None else bore_or_keyway_reach(self.bore, width if depth else 0.0, depth)


def _check_keyway(part: Part, hole: _Hole) -> Iterator[Fault]:
    """Check that a keyway has a width, a depth and a bore."""
    given = [key for key in (*KEYWAY_KEYS, "keyway_angle") if getattr(part, key) is not None]
    if not given:
        return
    for key in KEYWAY_KEYS:
        if getattr(part, key) is None:
            yield f"part.{key}", None, f"missing; the keyway of part.{given[0]} needs it"
    if not hole.is_given:
        yield "part.bore", None, "missing; a keyway needs it, or cam.shaft_diameter"
    width = known_number_or_none(part.keyway_width)
    if hole.bore and width and width >= hole.bore:
        yield "part.keyway_width", width, f"must be below the diameter of the bore ({hole.bore:g})"


def _check_hub(part: Part, hole: _Hole, base_radius: float | None, disc_count: int) -> Iterator[Fault]:
    """Check that a hub has both sizes, holds the plates and the bore, and lies inside the base circle."""
    given = [key for key in HUB_KEYS if getattr(part, key) is not None]
    for key in (*HUB_KEYS, "thickness") if given else ():
        if getattr(part, key) is None:
            yield f"part.{key}", None, f"missing; part.{given[0]} describes a hub, which needs it"
    whole, plate, diameter = map(known_number_or_none, (part.hub_length, part.thickness, part.hub_diameter))
    if plate and disc_count > 1:
        plate = disc_count * plate + (known_number_or_none(part.disc_gap) or USUAL_GAP * plate)
    if whole and plate and whole < plate:
        what = "the thickness" if disc_count == 1 else "two thicknesses and the gap"
        yield "part.hub_length", whole, f"must be at least {what} ({plate:g}), which it includes"
    reach = hole.reach
    if diameter and reach and diameter <= 2 * reach:
        yield "part.hub_diameter", diameter, f"must be above {2 * reach:g}: the bore and its keyway are inside it"
    if diameter and base_radius and (reach or 0.0) < base_radius < diameter / 2:
        yield "part.hub_diameter", diameter, f"must be at most twice the base radius ({2 * base_radius:g})"


def _check_bore_and_keyway_inside(
    part: Part, hole: _Hole, circle_radius: float | None, circle_words: str
) -> Iterator[Fault]:
    """Bore and keyway are inside a circle about the axis."""
    if not circle_radius or not hole.reach or not hole.bore or hole.reach < circle_radius:
        return
    if hole.bore / 2 < circle_radius:
        yield "part.keyway_depth", VALUE_IN_SCENE, f"must leave a wall to {circle_words.format(circle_radius)}"
    elif own := known_number_or_none(
        part.bore
    ):  # a shaft as thick as the base circle has its own message, or is one piece with the cam
        yield "part.bore", own, f"must leave a wall to {circle_words.format(circle_radius)}"


def _check_face_groove_or_rib_height(part: Part, body: Body) -> Iterator[Fault]:
    """Check that a groove in the face of a disc leaves a bottom, and that a rib stands on a plate."""
    whole, height = (
        known_number_or_none(part.thickness),
        known_number_or_none(getattr(part, body.flank_height, None)),
    )
    if whole and height and height >= whole:
        why = (
            "the groove needs a bottom" if "groove_depth" in body.flank_height else "the rib needs a plate below it"
        )
        yield f"part.{body.flank_height}", height, f"must be below the thickness ({whole:g}): {why}"


def _check_groove(
    scene: "Scene", hole: _Hole, mechanism: Mechanism, lift: float | None, tip_radius: float | None
) -> Iterator[Fault]:
    """Check that a groove (rib) lies within the length of the cylinder and leaves a wall to the bore."""
    body = mechanism.body
    key, what = f"part.{body.flank_height}", body.flank_height.partition("_")[0]
    part, mean = scene.part, known_number_or_none(getattr(scene.cam, body.size_key))
    depth, whole = known_number_or_none(getattr(part, body.flank_height)), known_number_or_none(part.thickness)
    if mean and depth and depth >= 2 * mean:
        yield key, depth, f"must be below twice the mean radius ({2 * mean:g})"
    elif mean:
        yield from _check_bore_and_keyway_inside(
            part, hole, mean - (depth or 0.0) / 2, f"{body.foot} (radius {{:g}})"
        )
    needed = groove_length_along_axis(scene, mechanism, lift, tip_radius)
    if depth and whole and needed is not None and whole <= needed:
        yield "part.thickness", whole, f"must be above {needed:g}, the length of the {what} along the axis"


def groove_length_along_axis(
    scene: "Scene", mechanism: Mechanism, lift: float | None, tip_radius: float | None
) -> float | None:
    """Length of the groove (rib) along the axis [mm]; None if a size is missing."""
    arm, ribbed = known_number_or_none(scene.follower.arm_length), mechanism.has_rib
    spacing = known_number_or_none(scene.follower.roller_spacing) if ribbed else 0.0
    if lift is None or tip_radius is None or spacing is None:
        return None
    rollers = -2 * tip_radius if ribbed else 2 * tip_radius
    if not mechanism.motion.angular:
        return lift + spacing + rollers
    if arm is None or spacing > 2 * arm:
        return None
    return 2 * arm * sin(radians(lift) / 2 + asin(spacing / (2 * arm))) + rollers

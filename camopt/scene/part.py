"""The table ``[part]`` of a scene: the cam as a piece of steel, and whether its sizes go together.

A disc cam is a plate with a bore, a keyway and a hub on one side, or a round plate with a groove in its face. A
conjugate pair is two such plates on one bore and hub, of one thickness. A cylindrical cam is a cylinder with a
groove; the mean radius is in the middle of its depth.
"""

import re
from collections.abc import Iterator, Mapping
from datetime import date
from functools import partial
from math import asin, hypot, radians, sin
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from camopt.mechanisms import Mechanism
from camopt.mechanisms.body import DISC, EVERY_BODY, Body
from camopt.quantities.key import LENGTHS, Key
from camopt.scene.fits import FIT, SHAFT_FIT
from camopt.scene.law_forms import Fault
from camopt.scene.mapping import at, length
from camopt.scene.materials import MATERIALS
from camopt.scene.tables import (
    Anywhere,
    Cam,
    Length,
    Materials,
    Positive,
    SceneTable,
    Within,
    is_pair,
    one_line,
    or_text,
)


def _is_fit(value: Any, pattern: str, example: str) -> Any:
    if not isinstance(value, str) or not re.fullmatch(pattern, value):
        raise ValueError(f"a fit of ISO 286, such as {example}")
    return value


def _is_date(value: Any) -> Any:
    return value.isoformat() if isinstance(value, date) else one_line(value)


def _as_text(value: Any) -> Any:
    if isinstance(value, float):  # the last zero of 1.4310, a number of a steel, is gone
        raise ValueError("a text, in quotes")
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else one_line(value)


OneLine = Annotated[str, BeforeValidator(one_line)]
Numbered = Annotated[str, BeforeValidator(_as_text, json_schema_input_type=str | int)]
"""A text that may be a whole number, without quotes."""
Fit = Annotated[str, BeforeValidator(partial(_is_fit, pattern=FIT, example="H7"))]
ShaftFit = Annotated[str, BeforeValidator(partial(_is_fit, pattern=SHAFT_FIT, example="h9"))]
TOWARDS_FOLLOWER = 90.0
HUB, KEYWAY = DISC.part, ("keyway_width", "keyway_depth")
USUAL_GAP = 0.25  # of the thickness: between both discs of a pair, which leaves the rollers room


class Part(SceneTable):
    """The cam as a manufactured part, and the texts of its drawing. Every key is optional.

    The groove of a cylindrical cam runs in the middle of its thickness. A ``keyway_angle`` of 90, if none is given,
    is towards a translating follower at cam angle 0.
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
            "Gap between both plates of a conjugate pair, a quarter of their thickness if not given",
            "mm",
            usual=LENGTHS,
        ),
    ] = None
    bore: Annotated[
        Length | None,
        Field(json_schema_extra=or_text),
        Key(
            "Diameter of the bore, or a text of it and its fit, such as 30 H7; that of the shaft if not given",
            "mm",
            example=20,
            usual=LENGTHS,
        ),
    ] = None
    bore_fit: Annotated[Fit | None, Key("Fit of the bore (ISO 286), such as H7")] = None
    hub_diameter: Annotated[
        Length | None, Key("Diameter of the hub, at most that of the base circle", "mm", usual=LENGTHS)
    ] = None
    hub_length: Annotated[
        Length | None,
        Key("Length of the whole hub, the plate included, or both plates and their gap", "mm", usual=LENGTHS),
    ] = None
    keyway: Annotated[
        Literal["DIN 6885"] | None,
        Key("Standard of the keyway, by which its width and depth follow from the bore: DIN 6885"),
    ] = None
    keyway_width: Annotated[Length | None, Key("Width of the keyway", "mm", usual=LENGTHS)] = None
    keyway_fit: Annotated[Fit | None, Key("Fit of the width of the keyway, such as JS9")] = None
    keyway_depth: Annotated[
        Length | None,
        Key(
            "Depth of the keyway in the hub (t₂ of DIN 6885), from the bore's surface at its middle",
            "mm",
            usual=LENGTHS,
        ),
    ] = None
    keyway_angle: Annotated[
        Annotated[float, Within(ge=-360, le=360)] | None,
        Key("Direction of the keyway's middle in the cam's own frame, ccw from x", "deg"),
    ] = None
    outer_diameter: Annotated[
        Length | None, Key("Outer diameter of a disc cam with a groove in its face or a rib on it", "mm")
    ] = None
    groove_depth: Annotated[Length | None, Key("Depth of the groove", "mm", example=8, usual=LENGTHS)] = None
    rib_height: Annotated[
        Length | None,
        Key(
            "Height of the rib: on a cylinder with the mean radius in its middle, on a disc within the thickness",
            "mm",
            example=8,
            usual=LENGTHS,
        ),
    ] = None
    groove_fit: Annotated[
        Fit | None, Key("Fit of the width of the groove, which is the diameter of the roller, such as H8")
    ] = None
    groove_chamfer: Annotated[
        Length | None, Key("Chamfer of the edges of the groove at 45°, in the drawing alone", "mm")
    ] = None
    outer_fit: Annotated[ShaftFit | None, Key("Fit of the outer diameter of a cylindrical cam, such as h9")] = None
    density: Annotated[
        Positive | None, Key("Density; that of ``materials.cam`` if not given", "kg/m³", usual=(500.0, 25000.0))
    ] = None
    material: Annotated[
        Numbered | None, Key("Material in the title block, ``materials.cam`` if not given", example="16MnCr5")
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
        Annotated[tuple[Anywhere, Anywhere], BeforeValidator(is_pair)] | None,
        Key("Edges by ISO 13715, outer and inner, below 0 where steel is taken off", "mm"),
    ] = None
    name: Annotated[OneLine | None, Key("Name in the title block, that of the scene if not given")] = None
    number: Annotated[Numbered | None, Key("Number of the drawing")] = None
    designer: Annotated[OneLine | None, Key("Who drew it")] = None
    approved_by: Annotated[OneLine | None, Key("Who approved it")] = None
    legal_owner: Annotated[OneLine | None, Key("The firm that owns the drawing")] = None
    revision: Annotated[Numbered | None, Key("Index of the revision, such as A")] = None
    date_of_issue: Annotated[
        Annotated[str, BeforeValidator(_is_date)] | None,
        Key("Date of issue, as a text or a date of TOML such as 2026-11-25"),
    ] = None
    language: Annotated[Literal["en", "de"], Key("Language of the drawing")] = "en"

    @property
    def plates(self) -> tuple[tuple[float, float], ...]:
        """From where to where the plate of each disc is along the axis, mm; none of a thickness that is not known.

        The last one stands at 0, and the first one is the nearest to who sees the front view.
        """
        if self.thickness is None:
            return ()
        feet = [0.0] if self.disc_gap is None else [self.thickness + self.disc_gap, 0.0]
        return tuple((foot, foot + self.thickness) for foot in feet)

    @property
    def width(self) -> float:
        """From the back of the last plate to the front of the first one, mm; 0 if it is not known."""
        return max((high for _, high in self.plates), default=0.0)

    @property
    def stands_on_hub(self) -> bool:
        """Whether the hub is longer than the plates that it includes."""
        return (self.hub_length or 0.0) > self.width

    def of_disc(self, disc: int | None) -> "Part":
        """One disc of a pair: without a hub it is a part of its own, with a number of its own."""
        if disc is None or self.hub_diameter or not self.number:
            return self
        return self.model_copy(update={"number": f"{self.number}/{disc}"})

    @property
    def bore_reach(self) -> float:
        """The largest distance of the bore, its keyway included, from the axis; 0 without a bore; mm."""
        return reach_of(self.bore or 0.0, self.keyway_width or 0.0, self.keyway_depth or 0.0)


def reach_of(bore: float, width: float, depth: float) -> float:
    """The distance from the axis of the corners of a keyway, or of the bore's surface if there is none; mm."""
    return hypot(bore / 2 + depth, width / 2) if width else bore / 2


def resolved(
    part: Part, title: str, cam: Cam, materials: Materials, profile_tolerance: float | None, paired: bool
) -> Part:
    """The part, completed from other tables of the scene; of two discs if it is ``paired``.

    The bore is that of the shaft, material and density are those of the contact, the name is that of the scene.
    """
    listed = MATERIALS[materials.cam] if materials.cam else None
    elsewhere = {
        "bore": cam.shaft_diameter,
        "material": materials.cam,
        "density": listed and listed.density,
        "name": title,
        "profile_tolerance": profile_tolerance,
        "keyway_angle": TOWARDS_FOLLOWER if part.keyway_width else None,
        "disc_gap": USUAL_GAP * part.thickness if paired and part.thickness else None,
    }
    return part.model_copy(update={key: v for key, v in elsewhere.items() if getattr(part, key) is None})


def check_part(
    data: Mapping[str, Any], mechanism: Mechanism, travel: float | None, radius: float | None
) -> Iterator[Fault]:
    """Check that the given sizes of the part fit together and lie inside the cam.

    ``travel`` of the follower is in mm, or in deg of its arm; ``radius`` is that of a roller or spherical face.
    """
    part = data.get("part")
    if not isinstance(part, Mapping):
        return
    body = mechanism.body
    for key in dict.fromkeys(key for other in EVERY_BODY for key in other.part if key not in body.part):
        if part.get(key) is not None:
            yield f"part.{key}", part[key], f"a {body.words} has none"
    if part.get("disc_gap") is not None and not mechanism.second_keys:
        yield "part.disc_gap", part["disc_gap"], "is that of a conjugate pair, and this cam has one disc"
    shaft, bore = length(data, "cam.shaft_diameter"), length(data, "part.bore")
    if shaft and bore and shaft != bore:
        yield "part.bore", bore, f"must be cam.shaft_diameter ({shaft:g}), or one of both is left out"
        return
    yield from _keyway(data, part)
    if body.closed:
        bases = [length(data, key) for key in (f"cam.{body.size}", "drive.base_radius")]
        base = min((each for each in bases if each), default=None)
        yield from _hub(data, part, base, 1 + bool(mechanism.second_keys)) if body.bounded else ()
        yield from _inside(data, base, "the base circle (radius {:g})")
        yield from _in_face(data, body)
    else:
        yield from _groove(data, mechanism, travel, radius)


def _bore(data: Mapping[str, Any]) -> float | None:
    """The bore's diameter; None where there is none, or it is wrong."""
    return length(data, "part.bore" if at(data, "part.bore") is not None else "cam.shaft_diameter")


def _reach(data: Mapping[str, Any]) -> float | None:
    """The largest distance of bore and keyway from the axis."""
    bore = _bore(data)
    width, depth = (length(data, f"part.{key}") or 0.0 for key in KEYWAY)
    return None if bore is None else reach_of(bore, width if depth else 0.0, depth)


def _keyway(data: Mapping[str, Any], part: Mapping[str, Any]) -> Iterator[Fault]:
    """A keyway has a width, a depth and a bore that it is in."""
    given = [key for key in (*KEYWAY, "keyway_angle") if part.get(key) is not None]
    if not given:
        return
    for key in KEYWAY:
        if part.get(key) is None:
            yield f"part.{key}", None, f"missing; the keyway of part.{given[0]} needs it"
    if part.get("bore") is None and at(data, "cam.shaft_diameter") is None:
        yield "part.bore", None, "missing; a keyway needs it, or cam.shaft_diameter"
    bore, width = _bore(data), length(data, "part.keyway_width")
    if bore and width and width >= bore:
        yield "part.keyway_width", width, f"must be below the diameter of the bore ({bore:g})"


def _hub(data: Mapping[str, Any], part: Mapping[str, Any], base: float | None, discs: int) -> Iterator[Fault]:
    """A hub has a diameter and a length, is longer and wider than what it holds, and lies behind the profile."""
    given = [key for key in HUB if part.get(key) is not None]
    for key in (*HUB, "thickness") if given else ():
        if part.get(key) is None:
            yield f"part.{key}", None, f"missing; part.{given[0]} is that of a hub on a plate"
    whole, plate = length(data, "part.hub_length"), length(data, "part.thickness")
    if plate and discs > 1:
        plate = discs * plate + (length(data, "part.disc_gap") or USUAL_GAP * plate)
    if whole and plate and whole < plate:
        what = "the thickness" if discs == 1 else "two thicknesses and the gap"
        yield "part.hub_length", whole, f"must be at least {what} ({plate:g}), which it includes"
    diameter, reach = length(data, "part.hub_diameter"), _reach(data)
    if diameter and reach and diameter <= 2 * reach:
        yield "part.hub_diameter", diameter, f"must be above {2 * reach:g}: the bore and its keyway are inside it"
    if diameter and base and (reach or 0.0) < base < diameter / 2:
        yield "part.hub_diameter", diameter, f"must be at most twice the base radius ({2 * base:g})"


def _inside(data: Mapping[str, Any], radius: float | None, what: str) -> Iterator[Fault]:
    """Bore and keyway are inside a circle about the axis."""
    reach, bore = _reach(data), _bore(data)
    if not radius or not reach or not bore or reach < radius:
        return
    own = length(data, "part.bore")
    if bore / 2 < radius:
        yield "part.keyway_depth", at(data, "part.keyway_depth"), f"must leave a wall to {what.format(radius)}"
    elif own:  # a shaft as thick as the base circle is told as such, or allowed: then it is one with the cam
        yield "part.bore", own, f"must leave a wall to {what.format(radius)}"


def _in_face(data: Mapping[str, Any], body: Body) -> Iterator[Fault]:
    """A groove in the face of a disc leaves a bottom, and a rib stands on a plate."""
    key = f"part.{body.flank_height}"
    whole, height = length(data, "part.thickness"), length(data, key) if body.flank_height else None
    if whole and height and height >= whole:
        why = "it has a bottom" if "groove_depth" in key else "the rib stands on a plate"
        yield key, height, f"must be below the thickness ({whole:g}): {why}"


def _groove(
    data: Mapping[str, Any], mechanism: Mechanism, travel: float | None, radius: float | None
) -> Iterator[Fault]:
    """A groove (rib) lies within the length of the cylinder, and leaves a wall to the bore."""
    body = mechanism.body
    key, what = f"part.{body.flank_height}", body.flank_height.partition("_")[0]
    mean, depth = length(data, f"cam.{body.size}"), length(data, key)
    if mean and depth and depth >= 2 * mean:
        yield key, depth, f"must be below twice the mean radius ({2 * mean:g})"
    elif mean:
        yield from _inside(data, mean - (depth or 0.0) / 2, f"{body.foot} (radius {{:g}})")
    whole = length(data, "part.thickness")
    needed = run_of_groove(data, mechanism, travel, radius)
    if depth and whole and needed is not None and whole <= needed:
        yield "part.thickness", whole, f"must be above {needed:g}, the length over which the {what} runs"


def run_of_groove(
    data: Mapping[str, Any], mechanism: Mechanism, travel: float | None, radius: float | None
) -> float | None:
    """The length over which the groove (rib) runs along the axis, mm; None if a size of it is missing."""
    arm, ribbed = length(data, "follower.arm_length"), mechanism.ribbed
    apart = length(data, "follower.roller_spacing") if ribbed else 0.0
    if travel is None or radius is None or apart is None:
        return None
    beside = -2 * radius if ribbed else 2 * radius
    if not mechanism.motion.angular:
        return travel + apart + beside
    if arm is None or apart > 2 * arm:
        return None
    return 2 * arm * sin(radians(travel) / 2 + asin(apart / (2 * arm))) + beside

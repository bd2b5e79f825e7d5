"""The table ``[limits]`` of a scene: what the cam must hold."""

from typing import TYPE_CHECKING, Annotated

from pydantic import ConfigDict, create_model

from camopt.quantities import BOUNDED, SIGNED
from camopt.quantities.key import Key
from camopt.scene.tables import ANYWHERE, POSITIVE, Acute, Anywhere, Length, Positive, SceneTable, Within


class ShortLimits(SceneTable):
    """The limits of the cam, by the short keys of the most common ones."""

    model_config = ConfigDict(extra="allow")  # names of the scene's own quantities, which the scene checks
    __pydantic_extra__: dict[str, Annotated[float | None, ANYWHERE]]

    pressure_angle: Annotated[Acute | None, Key("Largest |β| over rises, dwells and returns", "deg")] = None
    pressure_angle_return: Annotated[
        Acute | None, Key("Largest |β| over returns of the follower, in place of ``pressure_angle``", "deg")
    ] = None
    curvature_radius: Annotated[Length | None, Key("Least convex radius of curvature of the profile", "mm")] = None
    face_reach: Annotated[
        Length | None, Key("Largest reach of the contact along a flat face, to either side", "mm")
    ] = None
    outer_radius: Annotated[Length | None, Key("Largest distance of the profile from the cam's axis", "mm")] = None
    cutter_radius: Annotated[
        Length | None, Key("Radius of a cutter or grinding wheel that has to reach every hollow flank", "mm")
    ] = None
    lift_change: Annotated[
        Positive | None, Key("Largest change of the lift by degree of the cam", "mm/deg", "deg/deg")
    ] = None
    hub_wall: Annotated[
        Length | None, Key("Least wall from bore or keyway to base circle, hub or groove", "mm")
    ] = None
    area: Annotated[Positive | None, Key("Largest area of the section", "mm²")] = None
    cam_mass: Annotated[Positive | None, Key("Largest mass of the cam", "kg")] = None
    cam_inertia: Annotated[Positive | None, Key("Largest moment of inertia of the cam", "kg·m²")] = None
    unbalance: Annotated[Positive | None, Key("Largest unbalance of the cam", "g·mm")] = None
    velocity: Annotated[
        Positive | None, Key("Largest |velocity| of the follower, or of the tool that it drives", "m/s", "rad/s")
    ] = None
    acceleration: Annotated[
        Positive | None,
        Key("Largest |acceleration| of the follower, or of the tool that it drives", "m/s²", "rad/s²"),
    ] = None
    jerk: Annotated[
        Positive | None, Key("Largest |jerk| of the follower, or of the tool that it drives", "m/s³", "rad/s³")
    ] = None
    contact_force_min: Annotated[Anywhere | None, Key("Least contact force along the motion", "N")] = None
    jump_speed: Annotated[Positive | None, Key("Least speed at which contact may be lost", "rev/min")] = None
    normal_force: Annotated[Positive | None, Key("Largest normal force at the contact", "N")] = None
    side_thrust: Annotated[Positive | None, Key("Largest force across the motion of the trace point", "N")] = None
    guide_reaction: Annotated[Positive | None, Key("Largest reaction at the near end of the guide", "N")] = None
    stem_bending_stress: Annotated[Positive | None, Key("Largest bending stress of the stem", "MPa")] = None
    jamming_margin: Annotated[
        Annotated[float, Within(ge=0, le=1)] | None, Key("Least jamming margin; a follower at 0 jams", "no unit")
    ] = None
    contact_stress: Annotated[
        Positive | None, Key("Largest contact pressure (Hertz), in a groove on the flank that carries", "MPa")
    ] = None
    wear: Annotated[Positive | None, Key("Largest depth worn off the profile in a million turns", "µm")] = None
    sliding_speed: Annotated[Positive | None, Key("Largest sliding speed at the contact", "m/s")] = None
    film_ratio: Annotated[
        Positive | None, Key("Least thickness of the oil film over the composite roughness", "no unit")
    ] = None
    residual_vibration: Annotated[
        Positive | None, Key("Largest amplitude of vibration that remains in a dwell", "mm", "deg")
    ] = None
    lash_speed: Annotated[
        Positive | None, Key("Largest speed at which the lash is taken up or given back", "m/s", "rad/s")
    ] = None
    crossing_speed: Annotated[
        Positive | None, Key("Largest speed at which a follower meets the other flank of a positive drive", "m/s")
    ] = None
    slip_speed: Annotated[
        Positive | None,
        Key("Largest speed at which a roller slips on the flank that it meets at a crossing", "m/s"),
    ] = None
    roller_angular_acceleration: Annotated[
        Positive | None, Key("Largest angular acceleration of a roller in a groove that does not slip", "rad/s²")
    ] = None
    contact_force_elastic: Annotated[Anywhere | None, Key("Least contact force with the elastic train", "N")] = None
    torque: Annotated[Positive | None, Key("Largest |torque| of the camshaft", "N·m")] = None
    power: Annotated[Positive | None, Key("Largest |power| of the camshaft", "W")] = None
    position_error: Annotated[
        Length | None, Key("Largest error of the tool's position by the tolerances, to first order", "mm", "deg")
    ] = None
    velocity_error: Annotated[
        Positive | None,
        Key("Largest error of the tool's velocity by the tolerances, to first order", "m/s", "rad/s"),
    ] = None
    acceleration_error: Annotated[
        Positive | None,
        Key("Largest error of the tool's acceleration by the tolerances, to first order", "m/s²", "rad/s²"),
    ] = None
    dwell_error: Annotated[
        Length | None,
        Key("Largest change of the tool's position in a dwell by the tolerances, to first order", "mm", "deg"),
    ] = None

    @property
    def given(self) -> dict[str, float]:
        """The bounds that are set, by key."""
        return {key: bound for key, bound in self if bound is not None}


if TYPE_CHECKING:
    Limits = ShortLimits
else:
    Limits = create_model(
        "Limits",
        __base__=ShortLimits,
        __doc__="What the cam must hold, by a short key or by the name of any quantity; each is optional.",
        **{
            name: (Annotated[float | None, ANYWHERE if name in SIGNED else POSITIVE, quantity.key_of_limit], None)
            for name, quantity in BOUNDED.items()
            if name not in ShortLimits.model_fields
        },
    )

"""The table ``[limits]`` of a scene: what the cam must hold."""

from typing import TYPE_CHECKING, Annotated

from pydantic import ConfigDict, create_model

from camopt.quantities import BOUNDED, SIGNED
from camopt.scene.tables import ANYWHERE, POSITIVE, Acute, Anywhere, Length, Positive, SceneTable, Within


class ShortLimits(SceneTable):
    """The limits of the cam, by the short keys of the most common ones."""

    model_config = ConfigDict(extra="allow")  # names of the scene's own quantities, which the scene checks
    __pydantic_extra__: dict[str, Annotated[float | None, ANYWHERE]]

    pressure_angle: Acute | None = None
    """Largest |β| over rises, dwells and returns; deg."""
    pressure_angle_return: Acute | None = None
    """Largest |β| over returns of the follower, in place of ``pressure_angle``; deg."""
    curvature_radius: Length | None = None
    """Least convex radius of curvature of the profile; mm."""
    face_reach: Length | None = None
    """Largest reach of the contact along a flat face, to either side; mm."""
    outer_radius: Length | None = None
    """Largest distance of the profile from the cam's axis; mm."""
    cutter_radius: Length | None = None
    """Radius of a cutter or grinding wheel that has to reach every hollow flank; mm."""
    lift_change: Positive | None = None
    """Largest change of the lift by degree of the cam; mm/deg, oscillating deg/deg."""
    hub_wall: Length | None = None
    """Least wall from bore or keyway to base circle, hub or groove; mm."""
    area: Positive | None = None
    """Largest area of the section; mm²."""
    cam_mass: Positive | None = None
    """Largest mass of the cam; kg."""
    cam_inertia: Positive | None = None
    """Largest moment of inertia of the cam; kg·m²."""
    unbalance: Positive | None = None
    """Largest unbalance of the cam; g·mm."""
    velocity: Positive | None = None
    """Largest |velocity| of the follower, or of the tool that it drives; m/s, oscillating rad/s."""
    acceleration: Positive | None = None
    """Largest |acceleration| of the follower, or of the tool that it drives; m/s², oscillating rad/s²."""
    jerk: Positive | None = None
    """Largest |jerk| of the follower, or of the tool that it drives; m/s³, oscillating rad/s³."""
    contact_force_min: Anywhere | None = None
    """Least contact force along the motion; N."""
    jump_speed: Positive | None = None
    """Least speed at which contact may be lost; rev/min."""
    normal_force: Positive | None = None
    """Largest normal force at the contact; N."""
    side_thrust: Positive | None = None
    """Largest force across the motion of the trace point; N."""
    guide_reaction: Positive | None = None
    """Largest reaction at the near end of the guide; N."""
    stem_bending_stress: Positive | None = None
    """Largest bending stress of the stem; MPa."""
    jamming_margin: Annotated[float, Within(ge=0, le=1)] | None = None
    """Least jamming margin; a follower at 0 jams; no unit."""
    contact_stress: Positive | None = None
    """Largest contact pressure (Hertz), in a groove on the flank that carries; MPa."""
    wear: Positive | None = None
    """Largest depth worn off the profile in a million turns; µm."""
    sliding_speed: Positive | None = None
    """Largest sliding speed at the contact; m/s."""
    film_ratio: Positive | None = None
    """Least thickness of the oil film over the composite roughness; no unit."""
    residual_vibration: Positive | None = None
    """Largest amplitude of vibration that remains in a dwell; mm, oscillating deg."""
    lash_speed: Positive | None = None
    """Largest speed at which the lash is taken up or given back; m/s, oscillating rad/s."""
    crossing_speed: Positive | None = None
    """Largest speed at which a follower meets the other flank of a positive drive; m/s."""
    slip_speed: Positive | None = None
    """Largest speed at which a roller slips on the flank that it meets at a crossing; m/s."""
    roller_angular_acceleration: Positive | None = None
    """Largest angular acceleration of a roller in a groove that does not slip; rad/s²."""
    contact_force_elastic: Anywhere | None = None
    """Least contact force with the elastic train; N."""
    torque: Positive | None = None
    """Largest |torque| of the camshaft; N·m."""
    power: Positive | None = None
    """Largest |power| of the camshaft; W."""
    position_error: Length | None = None
    """Largest error of the tool's position by the tolerances, to first order; mm, oscillating deg."""
    velocity_error: Positive | None = None
    """Largest error of the tool's velocity by the tolerances, to first order; m/s, oscillating rad/s."""
    acceleration_error: Positive | None = None
    """Largest error of the tool's acceleration by the tolerances, to first order; m/s², oscillating rad/s²."""
    dwell_error: Length | None = None
    """Largest change of the tool's position in a dwell by the tolerances, to first order; mm, oscillating deg."""

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
            name: (Annotated[float | None, ANYWHERE if name in SIGNED else POSITIVE], None)
            for name in BOUNDED
            if name not in ShortLimits.model_fields
        },
    )

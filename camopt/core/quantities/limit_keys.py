"""The short keys of ``[limits]``, each with the quantity that it bounds."""

from camopt.core.quantities.key import ANYWHERE, LENGTH, LimitKey

SHAPE_KEYS = (
    LimitKey(
        "Largest pressure angle |β| over the turn",
        "deg",
        key="pressure_angle",
        allowed={"ge": 1e-9, "lt": 90},
    ),
    LimitKey(
        "Largest pressure angle |β| over the returns of the follower, in place of `pressure_angle`",
        "deg",
        key="pressure_angle_return",
        allowed={"ge": 1e-9, "lt": 90},
    ),
    LimitKey("Smallest convex radius of curvature of the profile", "mm", key="curvature_radius", allowed=LENGTH),
    LimitKey(
        "Largest distance of the contact along a flat face, to either side", "mm", key="face_reach", allowed=LENGTH
    ),
    LimitKey("Largest distance of the profile from the cam's axis", "mm", key="outer_radius", allowed=LENGTH),
    LimitKey(
        "Radius of a cutter or grinding wheel that must fit every concave flank",
        "mm",
        key="cutter_radius",
        allowed=LENGTH,
    ),
)
PART_KEYS = (
    LimitKey(
        "Largest change of the lift per degree of the cam",
        "mm/deg",
        "deg/deg",
        key="lift_change",
        quantity="lift_change_max_mm_per_deg",
    ),
    LimitKey(
        "Smallest wall between the bore or keyway and the base circle, hub, groove or rib",
        "mm",
        key="hub_wall",
        quantity="hub_wall_min_mm",
        allowed=LENGTH,
    ),
    LimitKey("Largest area of the section", "mm²", key="area", quantity="area_mm2"),
    LimitKey("Largest mass of the cam", "kg", key="cam_mass", quantity="cam_mass_kg"),
    LimitKey("Largest moment of inertia of the cam", "kg·m²", key="cam_inertia", quantity="cam_inertia_kg_m2"),
    LimitKey("Largest unbalance of the cam", "g·mm", key="unbalance", quantity="unbalance_g_mm"),
)
MOTION_KEYS = (
    LimitKey("Largest |velocity| of the follower; with a train, of the tool", "m/s", "rad/s", key="velocity"),
    LimitKey(
        "Largest |acceleration| of the follower; with a train, of the tool",
        "m/s²",
        "rad/s²",
        key="acceleration",
    ),
    LimitKey("Largest |jerk| of the follower; with a train, of the tool", "m/s³", "rad/s³", key="jerk"),
)
LOAD_KEYS = (
    LimitKey(
        "Smallest contact force along the motion",
        "N",
        key="contact_force_min",
        quantity="contact_force_min_N",
        allowed=ANYWHERE,
    ),
    LimitKey(
        "Lowest speed of the cam at which contact may be lost",
        "rev/min",
        key="jump_speed",
        quantity="jump_speed_rpm",
    ),
    LimitKey("Largest normal force at the contact", "N", key="normal_force", quantity="normal_force_max_N"),
    LimitKey(
        "Largest contact force square to the motion of the trace point",
        "N",
        key="side_thrust",
        quantity="side_thrust_max_N",
    ),
    LimitKey(
        "Largest reaction at the end of the guide near the cam",
        "N",
        key="guide_reaction",
        quantity="guide_reaction_max_N",
    ),
    LimitKey(
        "Largest bending stress of a round follower stem",
        "MPa",
        key="stem_bending_stress",
        quantity="stem_bending_stress_max_MPa",
    ),
    LimitKey(
        "Smallest jamming margin; at 0 the follower jams",
        "no unit",
        key="jamming_margin",
        quantity="jamming_margin",
        allowed={"ge": 0, "le": 1},
    ),
    LimitKey(
        "Largest contact pressure (Hertz), in a groove on the flank that carries",
        "MPa",
        key="contact_stress",
        quantity="contact_stress_max_MPa",
    ),
    LimitKey("Largest wear of the profile after a million turns", "µm", key="wear", quantity="wear_depth_max_um"),
    LimitKey("Largest sliding speed at the contact", "m/s", key="sliding_speed", quantity="sliding_speed_max_m_s"),
    LimitKey(
        "Smallest thickness of the oil film divided by the composite roughness",
        "no unit",
        key="film_ratio",
        quantity="film_ratio_min",
    ),
    LimitKey(
        "Largest amplitude of the vibration that remains in a dwell",
        "mm",
        "deg",
        key="residual_vibration",
        quantity="residual_vibration_max_mm",
    ),
    LimitKey(
        "Largest speed of the follower as it takes up the lash or gives it back",
        "m/s",
        "rad/s",
        key="lash_speed",
        quantity="lash_speed_max_m_s",
    ),
    LimitKey(
        "Largest speed at which the follower strikes the other flank of a positive drive",
        "m/s",
        key="crossing_speed",
        quantity="crossing_speed_max_m_s",
    ),
    LimitKey(
        "Largest speed at which the roller slips as it meets the other wall",
        "m/s",
        key="slip_speed",
        quantity="slip_speed_max_m_s",
    ),
    LimitKey(
        "Largest angular acceleration of a roller that rolls without slip in its groove",
        "rad/s²",
        key="roller_angular_acceleration",
        quantity="roller_angular_acceleration_max_rad_s2",
    ),
    LimitKey(
        "Smallest contact force with the elastic train",
        "N",
        key="contact_force_elastic",
        quantity="contact_force_elastic_min_N",
        allowed=ANYWHERE,
    ),
    LimitKey("Largest |torque| of the camshaft", "N·m", key="torque", quantity="torque_peak_N_m"),
    LimitKey("Largest |power| of the camshaft", "W", key="power", quantity="power_peak_W"),
)
ERROR_KEYS = (
    LimitKey(
        "Largest error of the tool's position due to the tolerances, to first order",
        "mm",
        "deg",
        key="position_error",
        quantity="position_error_max_mm",
        allowed=LENGTH,
    ),
    LimitKey(
        "Largest error of the tool's velocity due to the tolerances, to first order",
        "m/s",
        "rad/s",
        key="velocity_error",
        quantity="velocity_error_max_m_s",
    ),
    LimitKey(
        "Largest error of the tool's acceleration due to the tolerances, to first order",
        "m/s²",
        "rad/s²",
        key="acceleration_error",
        quantity="acceleration_error_max_m_s2",
    ),
    LimitKey(
        "Largest change of the tool's position in a dwell due to the tolerances, to first order",
        "mm",
        "deg",
        key="dwell_error",
        quantity="dwell_error_max_mm",
        allowed=LENGTH,
    ),
)
LIMIT_KEYS = {key.key: key for key in (*SHAPE_KEYS, *PART_KEYS, *MOTION_KEYS, *LOAD_KEYS, *ERROR_KEYS)}
"""Every short key, in the order of ``[limits]``."""

"""The short keys of ``[limits]``: each a record of the key and of the quantity that it bounds."""

from camopt.core.quantities.key import ANYWHERE, LENGTH, LimitKey

SHAPE_KEYS = (
    LimitKey(
        "Largest |β| over rises, dwells and returns", "deg", key="pressure_angle", allowed={"ge": 1e-9, "lt": 90}
    ),
    LimitKey(
        "Largest |β| over returns of the follower, in place of ``pressure_angle``",
        "deg",
        key="pressure_angle_return",
        allowed={"ge": 1e-9, "lt": 90},
    ),
    LimitKey("Least convex radius of curvature of the profile", "mm", key="curvature_radius", allowed=LENGTH),
    LimitKey(
        "Largest reach of the contact along a flat face, to either side", "mm", key="face_reach", allowed=LENGTH
    ),
    LimitKey("Largest distance of the profile from the cam's axis", "mm", key="outer_radius", allowed=LENGTH),
    LimitKey(
        "Radius of a cutter or grinding wheel that has to reach every hollow flank",
        "mm",
        key="cutter_radius",
        allowed=LENGTH,
    ),
)
PART_KEYS = (
    LimitKey(
        "Largest change of the lift by degree of the cam",
        "mm/deg",
        "deg/deg",
        key="lift_change",
        quantity="lift_change_max_mm_per_deg",
    ),
    LimitKey(
        "Least wall from bore or keyway to base circle, hub or groove",
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
    LimitKey("Largest |velocity| of the follower, or of the tool that it drives", "m/s", "rad/s", key="velocity"),
    LimitKey(
        "Largest |acceleration| of the follower, or of the tool that it drives",
        "m/s²",
        "rad/s²",
        key="acceleration",
    ),
    LimitKey("Largest |jerk| of the follower, or of the tool that it drives", "m/s³", "rad/s³", key="jerk"),
)
LOAD_KEYS = (
    LimitKey(
        "Least contact force along the motion",
        "N",
        key="contact_force_min",
        quantity="contact_force_min_N",
        allowed=ANYWHERE,
    ),
    LimitKey("Least speed at which contact may be lost", "rev/min", key="jump_speed", quantity="jump_speed_rpm"),
    LimitKey("Largest normal force at the contact", "N", key="normal_force", quantity="normal_force_max_N"),
    LimitKey(
        "Largest force across the motion of the trace point", "N", key="side_thrust", quantity="side_thrust_max_N"
    ),
    LimitKey(
        "Largest reaction at the near end of the guide", "N", key="guide_reaction", quantity="guide_reaction_max_N"
    ),
    LimitKey(
        "Largest bending stress of the stem",
        "MPa",
        key="stem_bending_stress",
        quantity="stem_bending_stress_max_MPa",
    ),
    LimitKey(
        "Least jamming margin; a follower at 0 jams",
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
    LimitKey(
        "Largest depth worn off the profile in a million turns", "µm", key="wear", quantity="wear_depth_max_um"
    ),
    LimitKey("Largest sliding speed at the contact", "m/s", key="sliding_speed", quantity="sliding_speed_max_m_s"),
    LimitKey(
        "Least thickness of the oil film over the composite roughness",
        "no unit",
        key="film_ratio",
        quantity="film_ratio_min",
    ),
    LimitKey(
        "Largest amplitude of vibration that remains in a dwell",
        "mm",
        "deg",
        key="residual_vibration",
        quantity="residual_vibration_max_mm",
    ),
    LimitKey(
        "Largest speed at which the lash is taken up or given back",
        "m/s",
        "rad/s",
        key="lash_speed",
        quantity="lash_speed_max_m_s",
    ),
    LimitKey(
        "Largest speed at which a follower meets the other flank of a positive drive",
        "m/s",
        key="crossing_speed",
        quantity="crossing_speed_max_m_s",
    ),
    LimitKey(
        "Largest speed at which a roller slips on the flank that it meets at a crossing",
        "m/s",
        key="slip_speed",
        quantity="slip_speed_max_m_s",
    ),
    LimitKey(
        "Largest angular acceleration of a roller in a groove that does not slip",
        "rad/s²",
        key="roller_angular_acceleration",
        quantity="roller_angular_acceleration_max_rad_s2",
    ),
    LimitKey(
        "Least contact force with the elastic train",
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
        "Largest error of the tool's position by the tolerances, to first order",
        "mm",
        "deg",
        key="position_error",
        quantity="position_error_max_mm",
        allowed=LENGTH,
    ),
    LimitKey(
        "Largest error of the tool's velocity by the tolerances, to first order",
        "m/s",
        "rad/s",
        key="velocity_error",
        quantity="velocity_error_max_m_s",
    ),
    LimitKey(
        "Largest error of the tool's acceleration by the tolerances, to first order",
        "m/s²",
        "rad/s²",
        key="acceleration_error",
        quantity="acceleration_error_max_m_s2",
    ),
    LimitKey(
        "Largest change of the tool's position in a dwell by the tolerances, to first order",
        "mm",
        "deg",
        key="dwell_error",
        quantity="dwell_error_max_mm",
        allowed=LENGTH,
    ),
)
LIMIT_KEYS = {each.key: each for each in (*SHAPE_KEYS, *PART_KEYS, *MOTION_KEYS, *LOAD_KEYS, *ERROR_KEYS)}
"""Every short key, in the order of ``[limits]``."""

"""Every quantity that camopt can report, with its symbol, unit and a sentence about it.

Table columns, JSON keys, the reference and checks of names are made from this list. A name ends with its unit.
"""

from collections.abc import Collection
from typing import Literal

from camopt.core.quantities.motion_names import (
    AT_FOLLOWER,
    DERIVATIVE_UNITS,
    MOTION_ERROR_QUANTITIES,
    MOTION_QUANTITIES,
    MOTION_RMS_QUANTITIES,
    RMS_ORDERS,
    STROKE_WORDS,
    displacement_unit,
    dwell_error_name,
    motion_error_name,
    motion_peak_name,
    motion_rms_name,
    motion_unit,
)
from camopt.core.quantities.quantity import AT_LEAST, AT_MOST, Quantity
from camopt.core.quantities.scene_numbers import (
    NUMBER_COLUMNS,
    NUMBER_KEYS,
    NUMBERS,
    SPRING_AT,
    has_number_angular_unit,
    quantity_name_by_number_key,
)
from camopt.core.quantities.stage_numbers import STAGE_NUMBER_KEYS, find_stage_quantity, stage_quantity_name

__all__ = [
    "AT_FOLLOWER",
    "AT_LEAST",
    "AT_MOST",
    "BOUNDED_QUANTITIES",
    "DERIVATIVE_UNITS",
    "DISCIPLINES",
    "EVERYTHING",
    "GEOMETRY",
    "NUMBERS",
    "NUMBER_COLUMNS",
    "NUMBER_KEYS",
    "QUANTITIES",
    "RMS_ORDERS",
    "SPRING_AT",
    "STAGE_NUMBER_KEYS",
    "STROKE_WORDS",
    "Flag",
    "Quantity",
    "Word",
    "displacement_unit",
    "dwell_error_name",
    "has_number_angular_unit",
    "in_column_order",
    "motion_error_name",
    "motion_peak_name",
    "motion_rms_name",
    "motion_unit",
    "quantity_name_by_number_key",
    "stage_quantity_name",
]
Flag = Literal["undercut", "self_crossing", "feasible", "refined"]
Word = Literal["law_rise", "law_return", "violated", "status", "proof"]
"""Quantities that are no numbers, for type checkers: they cannot read the list."""


PAIR_QUANTITIES = [
    Quantity("roller_distance_mm", "d", "mm", "frame", "Distance between the centres of two translating rollers."),
    Quantity("subtending_angle_deg", "η", "deg", "frame", "Angle between the arms of two oscillating rollers."),
    Quantity(
        "breadth_mm",
        "",
        "mm",
        "frame",
        "Distance between the two faces of a yoke, which is the breadth of its disc.",
    ),
    Quantity("pair_preload_N", "P", "N", "preload", "Force between the cam and each contact of a pair at rest."),
    Quantity("pair_preload_N_m", "P", "N·m", "preload", "Moment of the force at each contact of a pair at rest."),
    *(
        Quantity(
            name,
            symbol,
            unit,
            "preload",
            f"Smallest {what} that keeps both contacts of a pair closed at this speed.",
        )
        for name, symbol, unit, what in (
            ("pair_preload_required_N", "P", "N", "preload"),
            ("pair_preload_required_N_m", "P", "N·m", "preload"),
            ("interference_required_mm", "δ_0", "mm", "interference"),
            ("interference_required_deg", "δ_0", "deg", "interference"),
        )
    ),
    Quantity(
        "pair_preload_ratio",
        "",
        "",
        "preload",
        "Preload divided by the preload required; below 1 a contact opens.",
        least=True,
    ),
    *(
        Quantity(
            f"{place}_{name}",
            symbol,
            unit,
            "pair",
            f"{sentence} at the {place} contact of a pair.",
            least=sentence.startswith("Smallest"),
        )
        for name, symbol, unit, sentence in (
            ("pressure_angle_max_deg", "β_max", "deg", "Largest pressure angle |β| over the turn"),
            ("profile_radius_min_mm", "ρ_min", "mm", "Smallest convex radius of curvature of the profile"),
            ("outer_radius_mm", "", "mm", "Largest distance of the profile from the cam's axis"),
            ("contact_stress_max_MPa", "p_0", "MPa", "Largest contact pressure (Hertz)"),
        )
        for place in ("first", "second")
    ),
]


LASH_QUANTITIES = [
    Quantity(
        f"{stem}_speed_max_{unit.replace('/', '_')}",
        "v",
        unit,
        "lash",
        f"Largest speed of the follower {words}.",
    )
    for stem, words in (
        ("opening", "as it takes up the lash"),
        ("closing", "as it gives the lash back"),
        ("lash", "as it takes up the lash or gives it back"),
    )
    for unit in ("m/s", "rad/s")
] + [
    Quantity("lash_open_deg", "", "deg", "lash", "Cam angle over which the lash is taken up, as of an open valve.")
]


VIBRATION_QUANTITIES = [
    Quantity(name, symbol, unit, "vibration", sentence)
    for stem, symbol, units, sentence in (
        (
            "overshoot_max",
            "z_max",
            ("mm", "deg"),
            "Largest deviation of the elastic train from the motion that its cam gives.",
        ),
        (
            "acceleration_elastic_max",
            "a_max",
            ("m/s²", "rad/s²"),
            "Largest |acceleration| of the mass on the elastic train.",
        ),
        (
            "residual_vibration_max",
            "A",
            ("mm", "deg"),
            "Largest amplitude of the vibration that remains in a dwell.",
        ),
    )
    for unit in units
    for name in (f"{stem}_{unit.replace('²', '2').replace('/', '_')}",)
] + [
    Quantity(
        "dynamic_factor",
        "",
        "",
        "vibration",
        "Peak acceleration of the mass on the elastic train divided by the peak of a rigid one.",
    ),
    Quantity(
        "contact_force_elastic_min_N",
        "F_min",
        "N",
        "vibration",
        "Smallest contact force along the motion with the elastic train; contact is lost at 0 and below.",
        least=True,
        signed=True,
    ),
]


class QuantityTable(dict[str, Quantity]):
    """Quantities by name, and the numbers of train stages, which are too many to list."""

    def __missing__(self, name: str) -> Quantity:
        if (quantity := find_stage_quantity(name)) is None:
            raise KeyError(name)
        return quantity

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or (isinstance(name, str) and find_stage_quantity(name) is not None)


KEEPS_CONTACT = "keeps contact at this speed; in a groove, contact with one flank."
_LISTED_QUANTITIES = [
    Quantity("law_rise", "", "", "sizes", "Motion law of the rises; with a train, of the tool's rises.", str),
    Quantity("law_return", "", "", "sizes", "Motion law of the returns; with a train, of the tool's returns.", str),
    Quantity(
        "base_radius_mm", "R_b", "mm", "sizes", "Radius of the base circle, the smallest of a disc cam's profile."
    ),
    Quantity(
        "mean_radius_mm", "R_m", "mm", "sizes", "Radius of a cylindrical cam at which its profile is developed."
    ),
    Quantity("roller_radius_mm", "R_r", "mm", "sizes", "Radius of the roller, or of a spherical face."),
    Quantity(
        "prime_radius_mm",
        "R_p",
        "mm",
        "sizes",
        "Radius of the prime circle, the smallest of the pitch curve: R_b + R_r.",
    ),
    Quantity("offset_mm", "e", "mm", "sizes", "Offset of the follower's axis, positive to the right."),
    Quantity("arm_length_mm", "l", "mm", "sizes", "Distance from the pivot to the trace point."),
    Quantity("centre_distance_mm", "c", "mm", "sizes", "Distance from the pivot to the cam centre."),
    Quantity("face_offset_mm", "f", "mm", "sizes", "Distance of an oscillating flat face from its pivot."),
    Quantity(
        "roller_spacing_mm", "d", "mm", "sizes", "Distance between the centres of the two rollers about a rib."
    ),
    Quantity("second_arm_length_mm", "l_2", "mm", "sizes", "Arm length of the second roller of a conjugate pair."),
    Quantity("second_roller_radius_mm", "R_r2", "mm", "sizes", "Radius of the second roller of a conjugate pair."),
    Quantity("second_offset_mm", "e_2", "mm", "sizes", "Offset of the second roller, positive to the right."),
    Quantity("second_base_radius_mm", "R_b2", "mm", "sizes", "Radius of the base circle of the second disc."),
    Quantity(
        "shaft_clearance_mm",
        "",
        "mm",
        "sizes",
        "Smallest gap between the shaft and the profile, or between the shaft and a rib's inner roller.",
    ),
    *(quantity for number in NUMBERS for quantity in number.quantities),
    *PAIR_QUANTITIES,
    *MOTION_QUANTITIES,
    *MOTION_RMS_QUANTITIES,
    *MOTION_ERROR_QUANTITIES,
    Quantity(
        "lift_area_mm_deg",
        "",
        "mm·deg",
        "rms",
        "Area below the lift curve over the cam angle, as of a valve.",
        least=True,
    ),
    Quantity(
        "lift_area_deg_deg",
        "",
        "deg·deg",
        "rms",
        "Area below the curve of the follower's angle over the cam angle.",
        least=True,
    ),
    Quantity(
        "transmission_angle_min_deg",
        "μ_min",
        "deg",
        "transmission",
        "Smallest transmission angle of a train's couplers over the turn.",
        least=True,
    ),
    Quantity(
        "joint_force_max_N",
        "F_J",
        "N",
        "joints",
        "Largest force in a joint of a train: a pin, roller, tooth, lever or face.",
    ),
    Quantity("joint_force_max_at_deg", "", "deg", "joints", "Cam angle of the largest joint force.", place=True),
    Quantity(
        "joint_force_max_direction_deg",
        "",
        "deg",
        "joints",
        "Direction of the largest joint force, from the slide's motion or from the line of a four-bar's pivots.",
        place=True,
    ),
    Quantity("pivot_force_max_N", "F_P", "N", "joints", "Largest force on any pivot of a train."),
    Quantity("slide_thrust_max_N", "", "N", "joints", "Largest force of a train's slide square to its guide."),
    Quantity("pressure_angle_max_deg", "β_max", "deg", "pressure", "Largest pressure angle |β| over the turn."),
    Quantity(
        "pressure_angle_max_rise_deg",
        "β_max",
        "deg",
        "pressure",
        "Largest pressure angle |β| over the rises of the follower.",
    ),
    Quantity(
        "pressure_angle_max_return_deg",
        "β_max",
        "deg",
        "pressure",
        "Largest pressure angle |β| over the returns of the follower.",
    ),
    Quantity(
        "pressure_angle_max_dwell_deg",
        "β_max",
        "deg",
        "pressure",
        "Largest pressure angle |β| over the dwells of the follower.",
    ),
    Quantity(
        "pressure_angle_max_bottom_deg",
        "β_max",
        "deg",
        "pressure",
        "Largest pressure angle |β| at the bottom of a groove or the foot of a rib, above that at the mean radius.",
    ),
    Quantity(
        "pressure_angle_max_at_deg",
        "θ_p",
        "deg",
        "pressure",
        "Cam angle of the pitch point, where |β| is largest.",
        place=True,
    ),
    Quantity(
        "pitch_circle_radius_mm",
        "",
        "mm",
        "pitch_circle",
        "Radius of the circle through the pitch point.",
        place=True,
    ),
    Quantity(
        "pitch_curvature_max_per_mm", "κ", "1/mm", "curvature", "Largest curvature of the pitch curve.", signed=True
    ),
    Quantity(
        "pitch_curvature_min_per_mm",
        "κ",
        "1/mm",
        "curvature",
        "Smallest curvature of the pitch curve; below 0 where the curve is concave.",
        least=True,
        signed=True,
    ),
    Quantity(
        "profile_radius_min_mm",
        "ρ_min",
        "mm",
        "curvature",
        "Smallest convex radius of curvature of the profile; 0 or less if the cam is undercut.",
        least=True,
    ),
    Quantity(
        "cutter_radius_max_mm",
        "R_c",
        "mm",
        "curvature",
        "Radius of the largest cutter or grinding wheel that fits every concave flank of a disc cam.",
        least=True,
    ),
    Quantity(
        "undercut",
        "",
        "",
        "curvature",
        "Whether the cam is undercut: its profile loses a part that the motion needs.",
        bool,
    ),
    Quantity(
        "self_crossing",
        "",
        "",
        "crossing",
        "Whether the profile crosses itself; yes also if camopt cannot decide it.",
        bool,
    ),
    Quantity(
        "face_reach_max_mm",
        "",
        "mm",
        "reach",
        "Largest distance of the contact along a flat face from the follower's axis, positive to the right if the "
        "cam turns ccw, to the left if cw; on an oscillating face, from its pivot.",
        signed=True,
    ),
    Quantity(
        "face_reach_min_mm",
        "",
        "mm",
        "reach",
        "Smallest distance of the contact along a flat face, with the sign of the largest; below 0 on the other "
        "side of the axis.",
        least=True,
        signed=True,
    ),
    Quantity(
        "face_diameter_min_mm",
        "",
        "mm",
        "face",
        "Smallest diameter of a round flat face that the contact line never leaves, over the cam's face width.",
    ),
    Quantity(
        "outer_radius_mm",
        "",
        "mm",
        "outline",
        "Largest distance of the profile, or of the outer wall of a groove or rib, from the cam's axis.",
    ),
    Quantity(
        "edge_wall_min_mm",
        "",
        "mm",
        "outline",
        "Smallest wall between the edge of a disc and a groove or rib on its face; below 0 there is no wall.",
        least=True,
    ),
    Quantity(
        "rib_thickness_min_mm",
        "t",
        "mm",
        "rib",
        "Smallest thickness of a rib, along the normals at both rollers; exact where both flanks are arcs about "
        "one centre or lines. At 0 and below there is no rib.",
        least=True,
    ),
    Quantity(
        "pivot_clearance_min_mm",
        "",
        "mm",
        "outline",
        "Smallest gap between the turning cam and the axis of the follower's pivot; below 0 the cam crosses it.",
        least=True,
    ),
    Quantity(
        "contact_force_min_N",
        "F_min",
        "N",
        "force",
        "Smallest contact force along the motion; at 0 and below contact is lost, or the other flank of a groove "
        "carries.",
        least=True,
        signed=True,
    ),
    Quantity("contact_force_max_N", "F_max", "N", "force", "Largest contact force along the motion.", signed=True),
    Quantity("preload_required_N", "F_0", "N", "force", f"Smallest preload that {KEEPS_CONTACT}"),
    Quantity("preload_required_N_m", "M_0", "N·m", "force", f"Smallest preload that {KEEPS_CONTACT}"),
    Quantity("spring_rate_required_N_per_mm", "k", "N/mm", "force", f"Smallest spring rate that {KEEPS_CONTACT}"),
    Quantity(
        "spring_rate_required_N_m_per_rad", "k", "N·m/rad", "force", f"Smallest spring rate that {KEEPS_CONTACT}"
    ),
    Quantity(
        "jump_speed_rpm",
        "",
        "rev/min",
        "force",
        "Cam speed above which contact is lost; in a groove, contact with one flank. It is 0 if nothing presses "
        "the follower on the cam.",
        least=True,
    ),
    Quantity("jump_speed_ratio", "", "", "force", "Jump speed divided by the speed of the cam.", least=True),
    *LASH_QUANTITIES,
    *VIBRATION_QUANTITIES,
    Quantity(
        "torque_max_N_m",
        "T_max",
        "N·m",
        "torque",
        "Largest torque with its sign, guide friction included; torque_peak_N_m has no sign.",
        signed=True,
    ),
    Quantity(
        "torque_min_N_m",
        "T_min",
        "N·m",
        "torque",
        "Smallest torque with its sign; below 0 where the follower drives the cam.",
        least=True,
        signed=True,
    ),
    Quantity("torque_peak_N_m", "", "N·m", "torque", "Largest |torque| over the turn."),
    Quantity("torque_mean_N_m", "T_mean", "N·m", "torque", "Mean torque over the turn.", signed=True),
    Quantity("torque_rms_N_m", "", "N·m", "torque", "Root mean square of the torque over the turn."),
    Quantity("power_peak_W", "P_max", "W", "torque", "Largest |power| over the turn."),
    Quantity("power_mean_W", "P_mean", "W", "torque", "Mean power over the turn.", signed=True),
    Quantity(
        "energy_fluctuation_J", "ΔE", "J", "torque", "Range of the work of the torque, less the work of its mean."
    ),
    Quantity(
        "flywheel_inertia_kg_m2",
        "I",
        "kg·m²",
        "torque",
        "Flywheel inertia that keeps the speed within the fluctuation allowed.",
    ),
    Quantity(
        "normal_force_max_N", "N", "N", "thrust", "Largest normal force at the contact, guide friction included."
    ),
    Quantity(
        "side_thrust_max_N", "S", "N", "thrust", "Largest contact force square to the motion of the trace point."
    ),
    Quantity("guide_reaction_max_N", "", "N", "thrust", "Largest reaction at the end of the guide near the cam."),
    Quantity(
        "stem_bending_stress_max_MPa", "σ", "MPa", "thrust", "Largest bending stress of a round follower stem."
    ),
    Quantity(
        "jamming_margin",
        "",
        "",
        "thrust",
        "Smallest 1 − μ·q·|tan β| where the follower moves outward, in a groove inward too; at 0 it jams.",
        least=True,
        signed=True,
    ),
    Quantity(
        "jamming_angle_deg",
        "",
        "deg",
        "thrust",
        "Pressure angle at which the follower would jam at its lowest position.",
        place=True,
    ),
    Quantity(
        "contact_stress_max_MPa",
        "p_0",
        "MPa",
        "hertz",
        "Largest contact pressure (Hertz), in a groove on the flank that carries.",
    ),
    Quantity(
        "contact_stress_push_MPa",
        "p_0",
        "MPa",
        "hertz",
        "Largest contact pressure on the flank of a groove that pushes the follower outward.",
    ),
    Quantity(
        "contact_stress_pull_MPa",
        "p_0",
        "MPa",
        "hertz",
        "Largest contact pressure on the flank of a groove that pulls the follower back.",
    ),
    Quantity(
        "contact_stress_either_MPa",
        "p_0",
        "MPa",
        "hertz",
        "Largest contact pressure if the clearance lets the roller bear on either flank of the groove.",
    ),
    Quantity("contact_half_width_mm", "b", "mm", "hertz", "Half-width of the contact where its stress is largest."),
    Quantity(
        "contact_half_length_mm",
        "",
        "mm",
        "hertz",
        "Half-length of a point contact across the cam where its stress is largest.",
        place=True,
    ),
    Quantity("contact_shear_max_MPa", "τ_max", "MPa", "hertz", "Largest shear stress below the contact."),
    Quantity(
        "contact_shear_depth_mm",
        "",
        "mm",
        "hertz",
        "Depth of the largest shear stress below the contact.",
        place=True,
    ),
    Quantity("sliding_speed_max_m_s", "v", "m/s", "surface", "Largest sliding speed at the contact."),
    Quantity(
        "roller_speed_max_rpm",
        "",
        "rev/min",
        "surface",
        "Largest speed of the roller about its pin if it does not slip.",
    ),
    Quantity(
        "entrainment_speed_max_m_s",
        "u",
        "m/s",
        "surface",
        "Largest entrainment speed, the mean of both surface speeds at the contact.",
        signed=True,
    ),
    Quantity(
        "entrainment_speed_min_m_s",
        "u",
        "m/s",
        "surface",
        "Smallest entrainment speed, the mean of both surface speeds at the contact; at 0 no oil is drawn in.",
        least=True,
        signed=True,
    ),
    Quantity(
        "wear_depth_max_um", "", "µm", "surface", "Largest wear of the profile after a million turns (Archard)."
    ),
    Quantity(
        "film_thickness_min_um",
        "h_min",
        "µm",
        "surface",
        "Smallest thickness of the oil film; 0 where entrainment reverses or contact is lost.",
        least=True,
    ),
    Quantity(
        "film_ratio_min",
        "λ",
        "",
        "surface",
        "Smallest thickness of the oil film divided by the composite roughness.",
        least=True,
    ),
    Quantity(
        "lift_change_max_mm_per_deg",
        "",
        "mm/deg",
        "lift_change",
        "Largest change of the lift per degree of the cam.",
    ),
    Quantity(
        "lift_change_max_deg_per_deg",
        "",
        "deg/deg",
        "lift_change",
        "Largest change of the lift per degree of the cam.",
    ),
    Quantity(
        "crossing_count",
        "",
        "",
        "clearance",
        "Number of times in a turn that the follower crosses to the other flank.",
        place=True,
    ),
    Quantity(
        "crossing_at_deg", "", "deg", "clearance", "Cam angle at which the fastest crossing begins.", place=True
    ),
    Quantity(
        "crossing_speed_max_m_s",
        "v",
        "m/s",
        "clearance",
        "Largest speed at which the follower strikes the other flank after its free flight over the clearance.",
    ),
    Quantity(
        "crossing_speed_leading_m_s",
        "v",
        "m/s",
        "clearance",
        "Largest speed at which the follower strikes the other flank, by the formula for a small clearance.",
    ),
    Quantity(
        "crossing_time_max_ms", "t", "ms", "clearance", "Longest free flight of the follower over the clearance."
    ),
    Quantity(
        "slip_speed_max_m_s",
        "",
        "m/s",
        "clearance",
        "Largest speed at which the roller slips as it meets the other wall.",
    ),
    Quantity(
        "roller_spin_change_max_rpm",
        "",
        "rev/min",
        "clearance",
        "Largest change of the roller's spin from one wall to the other.",
    ),
    Quantity(
        "skidding_time_max_ms",
        "",
        "ms",
        "clearance",
        "Longest time that the roller skids before friction turns it; infinite if the next crossing comes first.",
    ),
    Quantity(
        "roller_angular_acceleration_max_rad_s2",
        "",
        "rad/s²",
        "clearance",
        "Largest angular acceleration of a roller that rolls without slip on either wall.",
    ),
    Quantity(
        "hub_wall_min_mm",
        "",
        "mm",
        "wall",
        "Smallest wall between the bore or keyway and the base circle, hub, groove or rib.",
        least=True,
    ),
    Quantity("area_mm2", "A", "mm²", "section", "Area inside the profile, bore included."),
    Quantity("profile_length_mm", "L", "mm", "section", "Length of the profile."),
    Quantity(
        "centroid_x_mm",
        "x_S",
        "mm",
        "section",
        "Centroid of the area inside the profile, in the cam's own frame.",
        place=True,
    ),
    Quantity(
        "centroid_y_mm",
        "y_S",
        "mm",
        "section",
        "Centroid of the area inside the profile, in the cam's own frame.",
        place=True,
    ),
    Quantity(
        "polar_moment_mm4",
        "I_p",
        "mm⁴",
        "section",
        "Second moment of the area inside the profile about the cam's axis.",
    ),
    Quantity(
        "groove_length_mm",
        "L",
        "mm",
        "section",
        "Length of a groove's pitch curve; on a cylinder, at its mean radius.",
    ),
    Quantity(
        "cam_mass_kg",
        "m",
        "kg",
        "solid",
        "Mass of the cam: plates and hub, or cylinder, less bore, keyway and groove.",
    ),
    Quantity(
        "unbalance_g_mm",
        "U",
        "g·mm",
        "solid",
        "Mass of the cam times the distance of its centre of gravity from the axis.",
    ),
    Quantity(
        "centre_of_gravity_mm", "e_S", "mm", "solid", "Distance of the cam's centre of gravity from its axis."
    ),
    Quantity("cam_inertia_kg_m2", "J", "kg·m²", "solid", "Moment of inertia of the cam about its axis."),
    Quantity("feasible", "", "", "limits", "Whether the design is proved to meet every limit.", bool),
    Quantity("violated", "", "", "limits", "Limits that the design breaks, separated by commas.", str),
    Quantity(
        "status",
        "",
        "",
        "limits",
        "certified: the verdict is proved; sampled: it depends on a table of points or a Python function; "
        "undecided: it is not proved.",
        str,
    ),
    Quantity("refined", "", "", "proof", "Whether the design was moved off the grid to a local optimum.", bool),
    Quantity(
        "proof",
        "",
        "",
        "proof",
        "Verdict of certify: held (every limit is met), broken or undecided.",
        str,
    ),
    Quantity(
        "relative_half_width",
        "",
        "",
        "limits",
        "Bound on the relative error of the numbers in the row; for an extreme near zero, relative to the largest "
        "magnitude of its curve.",
    ),
]

QUANTITIES: dict[str, Quantity] = QuantityTable({quantity.name: quantity for quantity in _LISTED_QUANTITIES})
"""Every quantity by name, in the order of the columns."""


def in_column_order(names: Collection[str]) -> list[str]:
    """Names in column order: a train's numbers after other sizes, a scene's own quantities before the verdict."""
    listed = [name for name in QUANTITIES if name in names]
    return sorted([*listed, *sorted(name for name in names if name not in listed)], key=_column_sort_key)


def _column_sort_key(name: str) -> int:
    """Sort key of a column: sizes first, then other quantities, a scene's own, and the verdict."""
    return {"sizes": 0, "limits": 3, "proof": 3}.get(QUANTITIES[name].effect, 1) if name in QUANTITIES else 2


BOUNDED_QUANTITIES = {name: quantity for name, quantity in QUANTITIES.items() if quantity.relation_to_limit}
"""Quantities that ``[limits]`` takes by name."""
EVERYTHING = "all"
"""The word in a scene's ``outputs`` for every quantity."""
GEOMETRY = ("sizes", "frame", "pair", "motion", "pressure", "pitch_circle", "curvature", "reach", "rib", "crossing")
"""Effects that run where a scene has no ``outputs``: those of the cam's shape and motion."""
DISCIPLINES = tuple(dict.fromkeys(q.effect for q in QUANTITIES.values() if q.effect not in ("limits", "proof")))
"""Names of the effects that compute quantities."""

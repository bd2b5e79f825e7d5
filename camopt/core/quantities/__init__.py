"""The list of quantities: all that camopt can report, each with its symbol, unit and sentence; how they are shown.

Table columns, JSON keys, documentation and checks of names all come from here. The unit is the suffix.
"""

from collections.abc import Collection
from typing import Literal

from camopt.core.quantities.motion_names import (
    AT_FOLLOWER,
    DERIVATIVE_UNITS,
    RMS_ORDERS,
    STROKE_WORDS,
    displacement_unit,
    dwell_error_quantity,
    error_quantities,
    error_quantity,
    mean_quantities,
    motion_mean,
    motion_quantities,
    motion_quantity,
    motion_unit,
)
from camopt.core.quantities.quantity import AT_LEAST, AT_MOST, Quantity
from camopt.core.quantities.scene_numbers import (
    NUMBER_COLUMNS,
    NUMBER_KEYS,
    NUMBERS,
    SPRING_AT,
    number_quantities,
    number_turns,
)
from camopt.core.quantities.stage_numbers import STAGE_NUMBER_KEYS, find_stage_quantity, stage_quantity

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
    "dwell_error_quantity",
    "error_quantity",
    "in_column_order",
    "motion_mean",
    "motion_quantity",
    "motion_unit",
    "number_quantities",
    "number_turns",
    "stage_quantity",
]
Flag = Literal["undercut", "self_crossing", "feasible", "refined"]
Word = Literal["law_rise", "law_return", "violated", "status", "proof"]
"""The quantities that are no numbers, for type checkers, which cannot read them from the list."""


def _pair_quantities() -> list[Quantity]:
    of_each = (
        ("pressure_angle_max_deg", "β_max", "deg", "Largest |β| over the turn"),
        ("profile_radius_min_mm", "ρ_min", "mm", "Least convex radius of curvature of the profile"),
        ("outer_radius_mm", "", "mm", "Largest distance of the profile from the cam's axis"),
        ("contact_stress_max_MPa", "p_0", "MPa", "Largest contact pressure (Hertz)"),
    )
    least = "Least preload of two contacts with which none lets go at this speed."
    needed = "Least interference of two contacts with which none lets go at this speed."
    places = {"first": "at the first contact of a pair.", "second": "at the second contact of a pair."}
    return [
        Quantity(
            "roller_distance_mm", "d", "mm", "frame", "Distance of the centres of two rollers that translate."
        ),
        Quantity("subtending_angle_deg", "η", "deg", "frame", "Angle between the arms of two rollers that swing."),
        Quantity("breadth_mm", "", "mm", "frame", "Distance of the two faces of a yoke, the breadth of its disc."),
        Quantity("pair_preload_N", "P", "N", "preload", "Force with which two contacts press at rest."),
        Quantity("pair_preload_N_m", "P", "N·m", "preload", "Moment with which two contacts press at rest."),
        Quantity("pair_preload_required_N", "P", "N", "preload", least),
        Quantity("pair_preload_required_N_m", "P", "N·m", "preload", least),
        Quantity("interference_required_mm", "δ_0", "mm", "preload", needed),
        Quantity("interference_required_deg", "δ_0", "deg", "preload", needed),
        Quantity(
            "pair_preload_ratio",
            "",
            "",
            "preload",
            "Preload over the least with which no contact lets go; below 1 one does.",
            least=True,
        ),
        *(
            Quantity(
                f"{place}_{name}", symbol, unit, "pair", f"{sentence} {words}", least=sentence.startswith("Least")
            )
            for name, symbol, unit, sentence in of_each
            for place, words in places.items()
        ),
    ]


def _lash_quantities() -> list[Quantity]:
    return [
        Quantity(f"{stem}_speed_max_{unit.replace('/', '_')}", "v", unit, "lash", f"Largest speed {words}.")
        for stem, words in (
            ("opening", "where the follower takes up the lash"),
            ("closing", "where the follower gives the lash back"),
            ("lash", "at the lash, on the way out or back"),
        )
        for unit in ("m/s", "rad/s")
    ] + [Quantity("lash_open_deg", "", "deg", "lash", "Cam angle over which the follower is beyond its lash.")]


def _vibration_quantities() -> list[Quantity]:
    return [
        Quantity(name, symbol, unit, "vibration", sentence)
        for stem, symbol, units, sentence in (
            (
                "overshoot_max",
                "z_max",
                ("mm", "deg"),
                "Largest deviation of the train from its cam's motion.",
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
                "Largest vibration that remains in a dwell (amplitude).",
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
            "Peak acceleration of the mass on the elastic train over that of the motion.",
        ),
        Quantity(
            "contact_force_elastic_min_N",
            "F_min",
            "N",
            "vibration",
            "Least force along the motion with the elastic train; contact is lost at 0 and below.",
            least=True,
            signed=True,
        ),
    ]


class QuantityTable(dict[str, Quantity]):
    """Quantities by name; with the numbers of stages of trains, of which there are too many to list."""

    def __missing__(self, name: str) -> Quantity:
        if (found := find_stage_quantity(name)) is None:
            raise KeyError(name)
        return found

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or (isinstance(name, str) and find_stage_quantity(name) is not None)


KEEPS_CONTACT = "keeps contact at this speed, in a groove with one and the same flank."
_LISTED_QUANTITIES = [
    Quantity("law_rise", "", "", "sizes", "Motion law of the rises (of the tool, with a train).", str),
    Quantity("law_return", "", "", "sizes", "Motion law of the returns (of the tool, with a train).", str),
    Quantity("base_radius_mm", "R_b", "mm", "sizes", "Least radius of the profile of a disc cam."),
    Quantity("mean_radius_mm", "R_m", "mm", "sizes", "Radius at which a cylindrical cam is developed."),
    Quantity("roller_radius_mm", "R_r", "mm", "sizes", "Radius of the roller; of the face if spherical."),
    Quantity("prime_radius_mm", "R_p", "mm", "sizes", "Least radius of the pitch curve, R_b + R_r."),
    Quantity("offset_mm", "e", "mm", "sizes", "Offset of the follower's axis, positive to the right."),
    Quantity("arm_length_mm", "l", "mm", "sizes", "Distance from the pivot to the trace point."),
    Quantity("centre_distance_mm", "c", "mm", "sizes", "Distance from the pivot to the cam centre."),
    Quantity("face_offset_mm", "f", "mm", "sizes", "Distance of an oscillating flat face from its pivot."),
    Quantity("roller_spacing_mm", "d", "mm", "sizes", "Distance of the centres of two rollers about a rib."),
    Quantity("second_arm_length_mm", "l_2", "mm", "sizes", "Arm of the second roller of a conjugate pair."),
    Quantity("second_roller_radius_mm", "R_r2", "mm", "sizes", "Radius of the second roller of a conjugate pair."),
    Quantity("second_offset_mm", "e_2", "mm", "sizes", "Offset of the second roller, positive to the right."),
    Quantity("second_base_radius_mm", "R_b2", "mm", "sizes", "Least radius of the profile of the second disc."),
    Quantity(
        "shaft_clearance_mm",
        "",
        "mm",
        "sizes",
        "Least gap between the shaft and the profile, or the inner roller of a rib.",
    ),
    *(each for number in NUMBERS for each in number.quantities),
    *_pair_quantities(),
    *motion_quantities(),
    *mean_quantities(),
    *error_quantities(),
    Quantity(
        "lift_area_mm_deg",
        "",
        "mm·deg",
        "rms",
        "Area below the lift over the cam angle, as of a valve.",
        least=True,
    ),
    Quantity(
        "lift_area_deg_deg", "", "deg·deg", "rms", "Area below the follower's angle over the cam angle.", least=True
    ),
    Quantity(
        "transmission_angle_min_deg",
        "μ_min",
        "deg",
        "transmission",
        "Least transmission angle of the couplers of a train over the turn.",
        least=True,
    ),
    Quantity(
        "joint_force_max_N",
        "F_J",
        "N",
        "joints",
        "Largest force in the pins of couplers, rollers, teeth, levers and faces of a train.",
    ),
    Quantity(
        "joint_force_max_at_deg", "", "deg", "joints", "Cam angle of the largest force in a joint.", place=True
    ),
    Quantity(
        "joint_force_max_direction_deg",
        "",
        "deg",
        "joints",
        "Direction of the largest force in a joint, from the slide's motion, or the line of a four-bar's pivots.",
        place=True,
    ),
    Quantity("pivot_force_max_N", "F_P", "N", "joints", "Largest force on a pivot of a train, wherever it stands."),
    Quantity("slide_thrust_max_N", "", "N", "joints", "Largest force of a train's slides across their guides."),
    Quantity("pressure_angle_max_deg", "β_max", "deg", "pressure", "Largest |β| over the turn."),
    Quantity(
        "pressure_angle_max_rise_deg", "β_max", "deg", "pressure", "Largest |β| over the rises of the follower."
    ),
    Quantity(
        "pressure_angle_max_return_deg", "β_max", "deg", "pressure", "Largest |β| over the returns of the follower."
    ),
    Quantity(
        "pressure_angle_max_dwell_deg", "β_max", "deg", "pressure", "Largest |β| over the dwells of the follower."
    ),
    Quantity(
        "pressure_angle_max_bottom_deg",
        "β_max",
        "deg",
        "pressure",
        "Largest |β| over the turn at the bottom of a groove or foot of a rib, steeper than at the mean radius.",
    ),
    Quantity(
        "pressure_angle_max_at_deg",
        "θ_p",
        "deg",
        "pressure",
        "Cam angle of the pitch point (largest |β|).",
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
        "Least curvature of the pitch curve; below 0 where concave.",
        least=True,
        signed=True,
    ),
    Quantity(
        "profile_radius_min_mm",
        "ρ_min",
        "mm",
        "curvature",
        "Least convex radius of curvature of the profile; 0 or less where the cam is undercut.",
        least=True,
    ),
    Quantity(
        "cutter_radius_max_mm",
        "R_c",
        "mm",
        "curvature",
        "Radius of the largest cutter or grinding wheel that reaches every concave flank of a disc cam.",
        least=True,
    ),
    Quantity("undercut", "", "", "curvature", "Whether the follower cuts away a part of the profile.", bool),
    Quantity(
        "self_crossing",
        "",
        "",
        "crossing",
        "Whether the profile crosses itself; also yes if that is undecided.",
        bool,
    ),
    Quantity(
        "face_reach_max_mm",
        "",
        "mm",
        "reach",
        "Largest reach of the contact along a flat face: from the axis, + to the right if ccw, to the left if cw; "
        "oscillating: from the pivot.",
        signed=True,
    ),
    Quantity(
        "face_reach_min_mm",
        "",
        "mm",
        "reach",
        "Least reach of the contact along a flat face, with the sign of the largest: "
        "below 0 on the other side of the axis.",
        least=True,
        signed=True,
    ),
    Quantity(
        "face_diameter_min_mm",
        "",
        "mm",
        "face",
        "Least diameter of a round flat face that the contact never leaves, over the cam's face width.",
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
        "Least wall between a groove in the face of a disc, or a rib on it, and its edge; below 0 it breaks out.",
        least=True,
    ),
    Quantity(
        "rib_thickness_min_mm",
        "t",
        "mm",
        "rib",
        "Least thickness of a rib, by the normals at both rollers: exact where flanks are arcs about one centre "
        "(lines). At 0 and below there is no rib.",
        least=True,
    ),
    Quantity(
        "pivot_clearance_min_mm",
        "",
        "mm",
        "outline",
        "Least distance of the turning cam from the axis of its follower's pivot; below 0 it passes over that.",
        least=True,
    ),
    Quantity(
        "contact_force_min_N",
        "F_min",
        "N",
        "force",
        "Least force along the motion; contact is lost at 0 and below, in a groove its other flank bears.",
        least=True,
        signed=True,
    ),
    Quantity("contact_force_max_N", "F_max", "N", "force", "Largest force along the motion.", signed=True),
    Quantity("preload_required_N", "F_0", "N", "force", f"Least preload that {KEEPS_CONTACT}"),
    Quantity("preload_required_N_m", "M_0", "N·m", "force", f"Least preload that {KEEPS_CONTACT}"),
    Quantity("spring_rate_required_N_per_mm", "k", "N/mm", "force", f"Least spring rate that {KEEPS_CONTACT}"),
    Quantity(
        "spring_rate_required_N_m_per_rad", "k", "N·m/rad", "force", f"Least spring rate that {KEEPS_CONTACT}"
    ),
    Quantity(
        "jump_speed_rpm",
        "",
        "rev/min",
        "force",
        "Speed of the cam above which contact is lost, in a groove with one flank; 0 where nothing presses "
        "the follower.",
        least=True,
    ),
    Quantity("jump_speed_ratio", "", "", "force", "Jump speed over the speed of the cam.", least=True),
    *_lash_quantities(),
    *_vibration_quantities(),
    Quantity(
        "torque_max_N_m",
        "T_max",
        "N·m",
        "torque",
        "Largest torque with its sign (torque_peak_N_m has none); a guide's friction adds to it.",
        signed=True,
    ),
    Quantity(
        "torque_min_N_m",
        "T_min",
        "N·m",
        "torque",
        "Least torque; below 0 where the follower drives the cam.",
        least=True,
        signed=True,
    ),
    Quantity("torque_peak_N_m", "", "N·m", "torque", "Largest |torque| over the turn."),
    Quantity("torque_mean_N_m", "T_mean", "N·m", "torque", "Mean torque over the turn.", signed=True),
    Quantity("torque_rms_N_m", "", "N·m", "torque", "Root mean square of the torque over the turn."),
    Quantity("power_peak_W", "P_max", "W", "torque", "Largest |power| over the turn."),
    Quantity("power_mean_W", "P_mean", "W", "torque", "Mean power over the turn.", signed=True),
    Quantity("energy_fluctuation_J", "ΔE", "J", "torque", "Range of the work of the torque less its mean."),
    Quantity(
        "flywheel_inertia_kg_m2", "I", "kg·m²", "torque", "Inertia that keeps the speed within its fluctuation."
    ),
    Quantity(
        "normal_force_max_N", "N", "N", "thrust", "Largest normal force at the contact, guide friction included."
    ),
    Quantity("side_thrust_max_N", "S", "N", "thrust", "Largest force across the motion of the trace point."),
    Quantity("guide_reaction_max_N", "", "N", "thrust", "Largest reaction at the near end of the guide."),
    Quantity("stem_bending_stress_max_MPa", "σ", "MPa", "thrust", "Largest bending stress of a round stem."),
    Quantity(
        "jamming_margin",
        "",
        "",
        "thrust",
        "1 − μ·q·|tan β| where the follower moves outward, in a groove inward too; 0 jams.",
        least=True,
        signed=True,
    ),
    Quantity(
        "jamming_angle_deg",
        "",
        "deg",
        "thrust",
        "Pressure angle at which the follower jams at its lowest position.",
        place=True,
    ),
    Quantity(
        "contact_stress_max_MPa",
        "p_0",
        "MPa",
        "hertz",
        "Largest contact pressure (Hertz); in a groove on the flank that carries.",
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
        "Largest contact pressure if the roller may bear on either flank, for the clearance of the groove.",
    ),
    Quantity("contact_half_width_mm", "b", "mm", "hertz", "Half-width of the contact where its stress is largest."),
    Quantity(
        "contact_half_length_mm",
        "",
        "mm",
        "hertz",
        "Half-length of a point contact across the cam, where its stress is largest.",
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
        "Largest speed of the roller about its pin, if it does not slip.",
    ),
    Quantity(
        "entrainment_speed_max_m_s",
        "u",
        "m/s",
        "surface",
        "Largest mean speed of both surfaces over the contact.",
        signed=True,
    ),
    Quantity(
        "entrainment_speed_min_m_s",
        "u",
        "m/s",
        "surface",
        "Least mean speed of both surfaces over the contact; at 0, no oil is carried in.",
        least=True,
        signed=True,
    ),
    Quantity(
        "wear_depth_max_um", "", "µm", "surface", "Largest depth worn off the profile in a million turns (Archard)."
    ),
    Quantity(
        "film_thickness_min_um",
        "h_min",
        "µm",
        "surface",
        "Least thickness of the oil film; 0 where entrainment reverses or contact is lost.",
        least=True,
    ),
    Quantity(
        "film_ratio_min",
        "λ",
        "",
        "surface",
        "Least thickness of the oil film over the composite roughness.",
        least=True,
    ),
    Quantity("lift_change_max_mm_per_deg", "", "mm/deg", "lift_change", "Largest change of the lift by cam angle."),
    Quantity(
        "lift_change_max_deg_per_deg", "", "deg/deg", "lift_change", "Largest change of the lift by cam angle."
    ),
    Quantity(
        "crossing_count",
        "",
        "",
        "clearance",
        "How often in a turn the follower crosses to the other flank.",
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
        "Largest speed along the motion at which a flank is met, after the free flight over the clearance.",
    ),
    Quantity(
        "crossing_speed_leading_m_s",
        "v",
        "m/s",
        "clearance",
        "Largest speed at which a flank is met, by the formula for a small clearance.",
    ),
    Quantity("crossing_time_max_ms", "t", "ms", "clearance", "Longest free flight over the clearance."),
    Quantity(
        "slip_speed_max_m_s",
        "",
        "m/s",
        "clearance",
        "Largest speed at which a roller slips as it meets the other wall.",
    ),
    Quantity(
        "roller_spin_change_max_rpm",
        "",
        "rev/min",
        "clearance",
        "Largest change of the roller's spin that the other wall asks for.",
    ),
    Quantity(
        "skidding_time_max_ms",
        "",
        "ms",
        "clearance",
        "Longest time a roller skids until friction turns it; infinite if the next crossing begins before.",
    ),
    Quantity(
        "roller_angular_acceleration_max_rad_s2",
        "",
        "rad/s²",
        "clearance",
        "Largest angular acceleration of a roller that does not slip, on either wall.",
    ),
    Quantity(
        "hub_wall_min_mm",
        "",
        "mm",
        "wall",
        "Least wall from bore or keyway to base circle, hub, groove or rib.",
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
        "Length of a groove's pitch curve, of a cylinder at its mean radius.",
    ),
    Quantity(
        "cam_mass_kg",
        "m",
        "kg",
        "solid",
        "Mass of the cam: plate (both of a pair) and hub, or cylinder, less bore, keyway and groove.",
    ),
    Quantity(
        "unbalance_g_mm", "U", "g·mm", "solid", "Mass of the cam times the distance of its centre of gravity."
    ),
    Quantity(
        "centre_of_gravity_mm", "e_S", "mm", "solid", "Distance of the cam's centre of gravity from its axis."
    ),
    Quantity("cam_inertia_kg_m2", "J", "kg·m²", "solid", "Moment of inertia of the cam about its axis."),
    Quantity("feasible", "", "", "limits", "Whether it is proved that the design meets every limit.", bool),
    Quantity("violated", "", "", "limits", "The limits that are broken, separated by commas.", str),
    Quantity(
        "status",
        "",
        "",
        "limits",
        "certified: the verdict is proved; sampled: proved for the spline of a table; undecided: not proved.",
        str,
    ),
    Quantity("refined", "", "", "proof", "Whether the design was moved off the grid to a local optimum.", bool),
    Quantity(
        "proof",
        "",
        "",
        "proof",
        "Verdict of certify: held (limits are met), broken or undecided.",
        str,
    ),
    Quantity(
        "relative_half_width",
        "",
        "",
        "limits",
        "Bound on the relative error of the numbers in the row; "
        "of an extreme near zero, relative to its curve's largest magnitude.",
    ),
]

QUANTITIES: dict[str, Quantity] = QuantityTable({quantity.name: quantity for quantity in _LISTED_QUANTITIES})
"""Every quantity by name, in the order of the columns."""


def in_column_order(names: Collection[str]) -> list[str]:
    """Names in the order of the columns; numbers of a train are behind other sizes, own ones before verdicts."""
    found = [name for name in QUANTITIES if name in names]
    return sorted([*found, *sorted(name for name in names if name not in found)], key=_column_place)


def _column_place(name: str) -> int:
    """The place of a column: sizes, other quantities, a scene's own, the verdict."""
    return {"sizes": 0, "limits": 3, "proof": 3}.get(QUANTITIES[name].effect, 1) if name in QUANTITIES else 2


BOUNDED_QUANTITIES = {name: quantity for name, quantity in QUANTITIES.items() if quantity.relation}
"""Those that ``[limits]`` takes by their names."""
EVERYTHING = "all"
"""The word in a scene's outputs that asks for every quantity."""
GEOMETRY = ("sizes", "frame", "pair", "motion", "pressure", "pitch_circle", "curvature", "reach", "rib", "crossing")
"""The effects that run where a scene names no outputs: those that every sweep of a cam's shape has a use for."""
DISCIPLINES = tuple(dict.fromkeys(q.effect for q in QUANTITIES.values() if q.effect not in ("limits", "proof")))
"""Every effect that computes quantities, by name."""

"""The list of quantities: all that camopt can report, each with its symbol, unit and sentence; how they are shown.

Table columns, JSON keys, documentation and checks of names all come from here. The unit is the suffix.
"""

import re
from collections.abc import Collection
from dataclasses import dataclass
from itertools import product
from typing import Literal

AT_MOST, AT_LEAST = "≤", "≥"
WITHOUT_BOUNDS = ("sizes", "limits", "proof")
"""Effects whose quantities are what is asked, or its answer."""
UNBOUNDED = (
    *("pressure_angle_max_at_deg", "pitch_circle_radius_mm", "centroid_x_mm", "centroid_y_mm"),
    *("crossing_count", "crossing_at_deg"),
    *("jamming_angle_deg", "contact_half_length_mm", "contact_shear_depth_mm", "joint_force_max_at_deg"),
)
"""Quantities that say where or how something is, not how much."""
BOUNDED_BELOW = (
    *("pitch_curvature_min_per_mm", "profile_radius_min_mm", "cutter_radius_max_mm", "face_reach_min_mm"),
    *("contact_force_min_N", "contact_force_elastic_min_N", "jump_speed_rpm", "jump_speed_ratio", "torque_min_N_m"),
    *("jamming_margin", "entrainment_speed_min_m_s", "film_thickness_min_um", "film_ratio_min", "hub_wall_min_mm"),
    *("lift_area_mm_deg", "lift_area_deg_deg", "transmission_angle_min_deg"),
    *("first_profile_radius_min_mm", "second_profile_radius_min_mm"),
    *("pivot_clearance_min_mm", "edge_wall_min_mm"),
)
"""Quantities of which one wants at least so much; of all others at most."""
SIGNED = (
    *("pitch_curvature_max_per_mm", "pitch_curvature_min_per_mm", "face_reach_max_mm", "face_reach_min_mm"),
    *("contact_force_min_N", "contact_force_max_N", "contact_force_elastic_min_N"),
    *("torque_max_N_m", "torque_min_N_m", "torque_mean_N_m", "power_mean_W"),
    *("entrainment_speed_max_m_s", "entrainment_speed_min_m_s", "jamming_margin"),
)
"""Quantities that may be below 0, and bounds on them too."""
Flag = Literal["undercut", "self_crossing", "feasible", "refined"]
Word = Literal["law_rise", "law_return", "violated", "status", "proof"]
"""The quantities that are no numbers, for type checkers, which cannot read them from the list."""


@dataclass(frozen=True)
class Quantity:
    """One reportable quantity. ``effect`` names the effect that computes it; ``kind`` is its column type."""

    name: str
    symbol: str
    unit: str
    effect: str
    sentence: str
    kind: type = float

    @property
    def relation(self) -> str:
        """The relation to its bound, ≤ or ≥; empty if it cannot be bounded."""
        if self.name in UNBOUNDED or self.kind is not float or self.effect in WITHOUT_BOUNDS:
            return ""
        return AT_LEAST if self.name in BOUNDED_BELOW else AT_MOST

    @property
    def side(self) -> float:
        """−1 for a quantity bounded from below, else 1."""
        return -1.0 if self.relation == AT_LEAST else 1.0

    @property
    def bounded(self) -> str:
        """A bound on it, in words."""
        words = "Least allowed" if self.relation == AT_LEAST else "Most allowed"
        return f"{words} ``{self.name}``; {self.unit or 'no unit'}."


AT_FOLLOWER = "follower"
STROKE_WORDS = {
    "rise": "over the rises",
    "return": "over the returns",
    "": "over the turn",
    AT_FOLLOWER: "of the follower itself, where it drives a tool through a train",
}
"""Of what quantities of the motion are, by the part of their name that says so."""
DERIVATIVES = {
    "velocity": ("v", {"m_s": "m/s", "rad_s": "rad/s", "mm_per_rad": "mm/rad", "deg_per_rad": "deg/rad"}),
    "acceleration": (
        "a",
        {"m_s2": "m/s²", "rad_s2": "rad/s²", "mm_per_rad2": "mm/rad²", "deg_per_rad2": "deg/rad²"},
    ),
    "jerk": ("j", {"m_s3": "m/s³", "rad_s3": "rad/s³", "mm_per_rad3": "mm/rad³", "deg_per_rad3": "deg/rad³"}),
}


def displacement_unit(*, angular: bool) -> str:
    """The unit of a displacement in tables."""
    return "deg" if angular else "mm"


def motion_quantity(derivative: str, stroke: str, *, angular: bool, timed: bool) -> str:
    """Name of a motion quantity: ``timed`` by time (the scene has an rpm), else by cam angle."""
    position = 2 * (not timed) + angular  # the order of the units in DERIVATIVES
    suffix = list(DERIVATIVES[derivative][1])[position]
    return "_".join(part for part in (derivative, "max", stroke, suffix) if part)


def _motion_quantities() -> list[Quantity]:
    return [
        Quantity(
            motion_quantity(derivative, stroke, angular=angular, timed=timed),
            f"{DERIVATIVES[derivative][0]}_max",
            list(DERIVATIVES[derivative][1].values())[2 * (not timed) + angular],
            "motion",
            f"Largest |{derivative}| {words}.",
        )
        for derivative, (stroke, words), angular, timed in product(
            DERIVATIVES, STROKE_WORDS.items(), (False, True), (True, False)
        )
    ]


def error_quantity(order: int, *, angular: bool, timed: bool) -> str:
    """Name of the largest error of position, velocity or acceleration (0, 1, 2)."""
    if order == 0:
        return f"position_error_max_{displacement_unit(angular=angular)}"
    derivative = [*DERIVATIVES][order - 1]
    return motion_quantity(derivative, "", angular=angular, timed=timed).replace("_max_", "_error_max_")


def dwell_error_quantity(*, angular: bool) -> str:
    """Name of the largest change of the position in a dwell."""
    return f"dwell_error_max_{displacement_unit(angular=angular)}"


RMS_ORDERS = {"acceleration": 2, "jerk": 3}
"""Derivatives of which there is a root mean square, with their orders."""


def motion_mean(derivative: str, *, angular: bool, timed: bool) -> str:
    """Name of the root mean square of a derivative, as ``motion_quantity`` names its peak."""
    return motion_quantity(derivative, "", angular=angular, timed=timed).replace("_max_", "_rms_")


def _mean_quantities() -> list[Quantity]:
    return [
        Quantity(
            motion_mean(derivative, angular=angular, timed=timed),
            f"{DERIVATIVES[derivative][0]}_rms",
            list(DERIVATIVES[derivative][1].values())[2 * (not timed) + angular],
            "rms",
            f"Root mean square of the {derivative} over the turn.",
        )
        for derivative, angular, timed in product(RMS_ORDERS, (False, True), (True, False))
    ]


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
        *(
            Quantity(f"{place}_{name}", symbol, unit, "pair", f"{sentence} {words}")
            for name, symbol, unit, sentence in of_each
            for place, words in places.items()
        ),
    ]


def _lash_quantities() -> list[Quantity]:
    return [
        Quantity(f"{stem}_speed_max_{unit.replace('/', '_')}", "v", unit, "lash", f"Largest speed {words}.")
        for stem, words in (
            ("opening", "where the follower takes up the lash"),
            ("closing", "where it gives the lash back"),
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
        Quantity("dynamic_factor", "", "", "vibration", "Peak acceleration of the mass over that of the motion."),
        Quantity(
            "contact_force_elastic_min_N",
            "F_min",
            "N",
            "vibration",
            "Least force along the motion with the elastic train; contact is lost at 0 and below.",
        ),
    ]


_NUMBERS = (
    ("cam.rpm", "rpm", "n", "rpm", "Speed of the cam."),
    ("cam.shaft_diameter", "shaft_diameter_mm", "", "mm", "Diameter of the shaft."),
    ("follower.dynamics.mass", "mass_kg", "m", "kg", "Mass that moves with the follower."),
    ("follower.dynamics.inertia", "inertia_kg_m2", "J", "kg·m²", "Inertia of the follower about its pivot."),
    ("follower.dynamics.spring_rate", "spring_rate_N_per_mm", "k", "N/mm", "Rate of the spring."),
    ("follower.dynamics.spring_rate", "spring_rate_N_m_per_rad", "k", "N·m/rad", "Rate of the spring."),
    ("follower.dynamics.preload", "preload_N", "F_0", "N", "Preload of the spring."),
    ("follower.dynamics.preload", "preload_N_m", "M_0", "N·m", "Preload of the spring."),
    ("follower.dynamics.spring_at", "spring_at_mm", "a", "mm", "Distance of a straight spring from the pivot."),
    ("follower.dynamics.damping", "damping_N_s_per_mm", "c", "N·s/mm", "Damping of the follower's motion."),
    ("follower.dynamics.damping", "damping_N_m_s_per_rad", "c", "N·m·s/rad", "Damping of the follower's motion."),
    ("follower.dynamics.load", "load_N", "", "N", "External force on the follower."),
    ("follower.dynamics.load", "load_N_m", "", "N·m", "External moment on the follower."),
    ("follower.dynamics.gravity", "gravity_m_s2", "g", "m/s²", "Acceleration of gravity towards the cam."),
    ("follower.dynamics.guide_length", "guide_length_mm", "b", "mm", "Length of the guide."),
    ("follower.dynamics.overhang", "overhang_mm", "a_0", "mm", "Distance from the guide to the trace point."),
    ("follower.dynamics.friction", "friction", "μ", "", "Coefficient of friction in the guide."),
    ("follower.dynamics.stem_diameter", "stem_diameter_mm", "d", "mm", "Diameter of the follower's stem."),
    ("follower.dynamics.natural_frequency", "natural_frequency_Hz", "f_n", "Hz", "Natural frequency of the train."),
    ("follower.dynamics.damping_ratio", "damping_ratio", "ζ", "", "Damping ratio of the train."),
    ("follower.dynamics.lash", "lash_mm", "", "mm", "Clearance that the follower takes up."),
    ("follower.dynamics.lash", "lash_deg", "", "deg", "Clearance that the follower takes up."),
    ("follower.dynamics.lash_variation", "lash_variation_mm", "", "mm", "Variation of the lash, to either side."),
    ("follower.dynamics.lash_variation", "lash_variation_deg", "", "deg", "Variation of the lash, to either side."),
    ("follower.dynamics.fluctuation", "fluctuation", "", "", "Fluctuation of the speed that is allowed."),
    ("drive.interference", "interference_mm", "δ_0", "mm", "Interference of two contacts."),
    ("drive.interference", "interference_deg", "δ_0", "deg", "Interference of two contacts."),
    ("drive.stiffness", "pair_stiffness_N_per_mm", "k", "N/mm", "Stiffness of what joins two contacts."),
    ("drive.stiffness", "pair_stiffness_N_m_per_rad", "k", "N·m/rad", "Stiffness of what joins two contacts."),
    ("drive.clearance", "clearance_mm", "j", "mm", "Clearance of the roller in its groove."),
    ("drive.roller_inertia", "roller_inertia_kg_m2", "J_r", "kg·m²", "Inertia of the roller about its pin."),
    ("drive.friction", "roller_friction", "μ", "", "Coefficient of friction between roller and flank."),
    ("materials.cam_modulus", "cam_modulus_GPa", "E_1", "GPa", "Young's modulus of the cam."),
    ("materials.cam_poisson", "cam_poisson", "ν_1", "", "Poisson's ratio of the cam."),
    ("materials.follower_modulus", "follower_modulus_GPa", "E_2", "GPa", "Young's modulus of the follower."),
    ("materials.follower_poisson", "follower_poisson", "ν_2", "", "Poisson's ratio of the follower."),
    ("materials.face_width", "face_width_mm", "L", "mm", "Width of the contact along the cam's axis."),
    ("materials.wear_rate", "wear_rate_mm2_per_N", "", "mm²/N", "Volume worn off by load and sliding distance."),
    ("materials.viscosity", "viscosity_Pa_s", "η", "Pa·s", "Viscosity of the lubricant."),
    ("materials.pressure_viscosity", "pressure_viscosity_per_GPa", "α", "1/GPa", "Its increase with pressure."),
    ("materials.roughness", "roughness_um", "", "µm", "Composite roughness (root mean square)."),
)
"""Numbers of the scene, by key. Two rows of one key: what is a force for a translating follower is a moment for an
oscillating one."""


NUMBER_COLUMNS = tuple(dict.fromkeys(key for key, *_ in _NUMBERS))
"""Their keys."""


OF_TOOL = ("follower.dynamics.lash", "follower.dynamics.lash_variation")
"""Numbers of the tool's motion, which a train drives."""


SPRING_AT = "follower.dynamics.spring_at"
"""The lever of a straight spring on the arm of an oscillating follower."""
OF_SPRING = ("follower.dynamics.spring_rate", "follower.dynamics.preload")
"""Numbers of the spring, whose moment is a force on its lever if it is a straight one."""


def number_quantities(*, angular: bool, tool_turns: bool, straight: bool = False) -> dict[str, str]:
    """The quantity that each number of the scene is in tables, by key.

    Of a follower, and of a tool, whose motion is an angle or not; of a spring that is a straight one, or one about
    the pivot of a follower that swings.
    """
    rows = {True: _NUMBERS, False: _NUMBERS[::-1]}  # the last row of a key counts
    found = {turns: {key: name for key, name, *_ in rows[turns]} for turns in rows}
    turns = dict.fromkeys(OF_TOOL, tool_turns) | dict.fromkeys(OF_SPRING, angular and not straight)
    return {key: found[turns.get(key, angular)][key] for key in NUMBER_COLUMNS}


OF_STAGE = {
    **dict.fromkeys(("crank", "coupler", "rocker", "ground", "offset", "input_arm", "output_arm", "radius"), "mm"),
    **dict.fromkeys(("angle", "input_angle", "output_angle", "guide"), "deg"),
    "ratio": "",
    "mass": "kg",
    **dict.fromkeys(("inertia", "arm_inertia"), "kg·m²"),
    "spring_rate": "N/mm, N·m/rad",
    **dict.fromkeys(("preload", "load", "friction_force"), "N, N·m"),
    "gravity": "m/s²",
}
"""Units of the numbers of a stage of a train by key; of two the second where what the stage moves turns."""
SUFFIXES = {"N/mm": "N_per_mm", "N·m/rad": "N_m_per_rad", "N·m": "N_m", "kg·m²": "kg_m2", "m/s²": "m_s2"}
STAGE_NUMBER = re.compile(r"train_([1-9]\d*)_([a-z_]+?)(?:_(mm|deg|kg|kg_m2|N|N_m|N_per_mm|N_m_per_rad|m_s2))?")


def stage_quantity(number: int, key: str, *, turns: bool) -> str:
    """The quantity that a number of a stage is in tables, of a stage whose motion is an angle or not."""
    unit = OF_STAGE[key].split(", ")[-1 if turns else 0]
    return "_".join(filter(None, ("train", str(number), key, SUFFIXES.get(unit, unit))))


def _of_stage(name: str) -> Quantity | None:
    """The number of a stage that has a name; None if there is none."""
    found = STAGE_NUMBER.fullmatch(name)
    if found is None or found[2] not in OF_STAGE:
        return None
    units = {SUFFIXES.get(each, each): each for each in OF_STAGE[found[2]].split(", ")}
    if (unit := units.get(found[3] or "")) is None:
        return None
    sentence = f"{found[2].replace('_', ' ').capitalize()} of stage {found[1]} of the train."
    return Quantity(name, "", unit, "sizes", sentence)


class Quantities(dict[str, Quantity]):
    """Quantities by name; with the numbers of stages of trains, of which there are too many to list."""

    def __missing__(self, name: str) -> Quantity:
        if (found := _of_stage(name)) is None:
            raise KeyError(name)
        return found

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or (isinstance(name, str) and _of_stage(name) is not None)


KEEPS_CONTACT = "keeps contact at this speed, in a groove with one and the same flank."
_ALL = [
    Quantity("law_rise", "", "", "sizes", "Motion law of the rises.", str),
    Quantity("law_return", "", "", "sizes", "Motion law of the returns.", str),
    Quantity("base_radius_mm", "R_b", "mm", "sizes", "Least radius of the profile of a disc cam."),
    Quantity("mean_radius_mm", "R_m", "mm", "sizes", "Radius at which a cylindrical cam is developed."),
    Quantity("roller_radius_mm", "R_r", "mm", "sizes", "Radius of the roller; of the face if spherical."),
    Quantity("prime_radius_mm", "R_p", "mm", "sizes", "Least radius of the pitch curve, R_b + R_r."),
    Quantity("offset_mm", "e", "mm", "sizes", "Offset of the follower's axis, positive to the right."),
    Quantity("arm_length_mm", "l", "mm", "sizes", "Distance from the pivot to the trace point."),
    Quantity("centre_distance_mm", "c", "mm", "sizes", "Distance from the pivot to the cam centre."),
    Quantity("face_offset_mm", "f", "mm", "sizes", "Distance of an oscillating flat face from its pivot."),
    Quantity("second_arm_length_mm", "l_2", "mm", "sizes", "Arm of the second roller of a conjugate pair."),
    Quantity("second_roller_radius_mm", "R_r2", "mm", "sizes", "Radius of the second roller of a conjugate pair."),
    Quantity("second_offset_mm", "e_2", "mm", "sizes", "Offset of the second roller, positive to the right."),
    Quantity("second_base_radius_mm", "R_b2", "mm", "sizes", "Least radius of the profile of the second disc."),
    Quantity("shaft_clearance_mm", "", "mm", "sizes", "Least gap between the profile and the shaft."),
    *[Quantity(name, symbol, unit, "sizes", sentence) for _, name, symbol, unit, sentence in _NUMBERS],
    *_pair_quantities(),
    *_motion_quantities(),
    *_mean_quantities(),
    Quantity("lift_area_mm_deg", "", "mm·deg", "rms", "Area below the lift over the cam angle, as of a valve."),
    Quantity("lift_area_deg_deg", "", "deg·deg", "rms", "Area below the follower's angle over the cam angle."),
    Quantity(
        "transmission_angle_min_deg",
        "μ_min",
        "deg",
        "transmission",
        "Least transmission angle of the couplers of a train over the turn.",
    ),
    Quantity(
        "joint_force_max_N",
        "F_J",
        "N",
        "joints",
        "Largest force in the pins of couplers, rollers, teeth, levers and faces of a train.",
    ),
    Quantity("joint_force_max_at_deg", "", "deg", "joints", "Cam angle of the largest of these forces."),
    Quantity("pivot_force_max_N", "F_P", "N", "joints", "Largest force on a pivot of a train, wherever it stands."),
    Quantity("slide_thrust_max_N", "", "N", "joints", "Largest force of a train's slides across their guides."),
    Quantity("pressure_angle_max_deg", "β_max", "deg", "pressure", "Largest |β| over the turn."),
    Quantity("pressure_angle_max_rise_deg", "β_max", "deg", "pressure", "Largest |β| over the rises."),
    Quantity("pressure_angle_max_return_deg", "β_max", "deg", "pressure", "Largest |β| over the returns."),
    Quantity("pressure_angle_max_dwell_deg", "β_max", "deg", "pressure", "Largest |β| over the dwells."),
    Quantity(
        "pressure_angle_max_bottom_deg",
        "β_max",
        "deg",
        "pressure",
        "Largest |β| over the turn at the bottom of a groove, where it is steeper than at the mean radius.",
    ),
    Quantity("pressure_angle_max_at_deg", "θ_p", "deg", "pressure", "Cam angle of the pitch point (largest |β|)."),
    Quantity("pitch_circle_radius_mm", "", "mm", "pressure", "Radius of the circle through the pitch point."),
    Quantity("pitch_curvature_max_per_mm", "κ", "1/mm", "curvature", "Largest curvature of the pitch curve."),
    Quantity(
        "pitch_curvature_min_per_mm",
        "κ",
        "1/mm",
        "curvature",
        "Least curvature; below 0 where concave.",
    ),
    Quantity(
        "profile_radius_min_mm",
        "ρ_min",
        "mm",
        "curvature",
        "Least convex radius of curvature of the profile; 0 or less where the cam is undercut.",
    ),
    Quantity(
        "cutter_radius_max_mm",
        "R_c",
        "mm",
        "curvature",
        "Largest cutter or grinding wheel that reaches every concave flank of a disc cam.",
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
    ),
    Quantity(
        "face_reach_min_mm",
        "",
        "mm",
        "reach",
        "Least reach of the contact along a flat face, with the sign of the largest: "
        "below 0 on the other side of the axis.",
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
        "Largest distance of the profile, or of the outer wall of a groove, from the cam's axis.",
    ),
    Quantity(
        "edge_wall_min_mm",
        "",
        "mm",
        "outline",
        "Least wall between a groove in the face of a disc and its edge; below 0 the groove breaks out.",
    ),
    Quantity(
        "pivot_clearance_min_mm",
        "",
        "mm",
        "outline",
        "Least distance of the turning cam from the axis of its follower's pivot; below 0 it passes over that.",
    ),
    *[
        Quantity(name, symbol, unit, "force", sentence)
        for name, symbol, unit, sentence in (
            (
                "contact_force_min_N",
                "F_min",
                "N",
                "Least force along the motion; contact is lost at 0 and below, in a groove its other flank bears.",
            ),
            ("contact_force_max_N", "F_max", "N", "Largest force along the motion."),
            ("preload_required_N", "F_0", "N", f"Least preload that {KEEPS_CONTACT}"),
            ("preload_required_N_m", "M_0", "N·m", f"Least preload that {KEEPS_CONTACT}"),
            ("spring_rate_required_N_per_mm", "k", "N/mm", f"Least spring rate that {KEEPS_CONTACT}"),
            ("spring_rate_required_N_m_per_rad", "k", "N·m/rad", f"Least spring rate that {KEEPS_CONTACT}"),
            (
                "jump_speed_rpm",
                "",
                "rpm",
                "Speed of the cam above which contact is lost, in a groove with one flank; 0 where nothing presses "
                "the follower.",
            ),
            ("jump_speed_ratio", "", "", "Jump speed over the speed of the cam."),
        )
    ],
    *_lash_quantities(),
    *_vibration_quantities(),
    *[
        Quantity(name, symbol, unit, "torque", sentence)
        for name, symbol, unit, sentence in (
            (
                "torque_max_N_m",
                "T_max",
                "N·m",
                "Largest torque with its sign (torque_peak_N_m has none); a guide's friction adds to it.",
            ),
            ("torque_min_N_m", "T_min", "N·m", "Least torque; below 0 where the follower drives the cam."),
            ("torque_peak_N_m", "", "N·m", "Largest |torque| over the turn."),
            ("torque_mean_N_m", "T_mean", "N·m", "Mean torque over the turn."),
            ("torque_rms_N_m", "", "N·m", "Root mean square of the torque over the turn."),
            ("power_peak_W", "P_max", "W", "Largest |power| over the turn."),
            ("power_mean_W", "P_mean", "W", "Mean power over the turn."),
            (
                "energy_fluctuation_J",
                "ΔE",
                "J",
                "Range of the work of the torque less its mean.",
            ),
            ("flywheel_inertia_kg_m2", "I", "kg·m²", "Inertia that keeps the speed within its fluctuation."),
        )
    ],
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
    ),
    Quantity("jamming_angle_deg", "", "deg", "thrust", "Pressure angle at which the follower jams at its lowest."),
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
        "Largest contact pressure on its other flank, which pulls the follower back.",
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
        "Half-length of a point contact across the cam, there.",
    ),
    Quantity("contact_shear_max_MPa", "τ_max", "MPa", "hertz", "Largest shear stress below the contact."),
    Quantity("contact_shear_depth_mm", "", "mm", "hertz", "Depth of the largest shear stress."),
    *[
        Quantity(name, symbol, unit, "surface", sentence)
        for name, symbol, unit, sentence in (
            ("sliding_speed_max_m_s", "v", "m/s", "Largest sliding speed at the contact."),
            ("roller_speed_max_rpm", "", "rpm", "Largest speed of the roller about its pin, if it does not slip."),
            ("entrainment_speed_max_m_s", "u", "m/s", "Largest mean speed of both surfaces over the contact."),
            (
                "entrainment_speed_min_m_s",
                "u",
                "m/s",
                "Least mean speed of both surfaces; at 0, no oil is carried in.",
            ),
            ("wear_depth_max_um", "", "µm", "Largest depth worn off the profile in a million turns (Archard)."),
            (
                "film_thickness_min_um",
                "h_min",
                "µm",
                "Least film; 0 where entrainment reverses or contact is lost.",
            ),
            ("film_ratio_min", "λ", "", "Least film over the composite roughness."),
        )
    ],
    Quantity("lift_change_max_mm_per_deg", "", "mm/deg", "lift_change", "Largest change of the lift by cam angle."),
    Quantity(
        "lift_change_max_deg_per_deg", "", "deg/deg", "lift_change", "Largest change of the lift by cam angle."
    ),
    *[
        Quantity(name, symbol, unit, "clearance", sentence)
        for name, symbol, unit, sentence in (
            ("crossing_count", "", "", "How often in a turn the follower crosses to the other flank."),
            ("crossing_at_deg", "", "deg", "Cam angle at which the fastest of these crossings begins."),
            (
                "crossing_speed_max_m_s",
                "v",
                "m/s",
                "Largest speed along the motion at which a flank is met, after the free flight over the clearance.",
            ),
            ("crossing_speed_leading_m_s", "v", "m/s", "The same by the formula for a small clearance."),
            ("crossing_time_max_ms", "t", "ms", "Longest such flight."),
            ("slip_speed_max_m_s", "", "m/s", "Largest speed at which a roller slips as it meets the other wall."),
            ("roller_spin_change_max_rpm", "", "rpm", "Largest change of its spin that the other wall asks for."),
            (
                "skidding_time_max_ms",
                "",
                "ms",
                "Longest time that it skids until friction turns it; infinite if the next crossing comes first.",
            ),
            (
                "roller_angular_acceleration_max_rad_s2",
                "",
                "rad/s²",
                "Largest angular acceleration of a roller that does not slip, on either wall.",
            ),
        )
    ],
    Quantity("hub_wall_min_mm", "", "mm", "wall", "Least wall from bore or keyway to base circle, hub or groove."),
    Quantity("area_mm2", "A", "mm²", "section", "Area inside the profile, bore included."),
    Quantity("profile_length_mm", "L", "mm", "section", "Length of the profile."),
    Quantity("centroid_x_mm", "x_S", "mm", "section", "Centroid of that area, in the cam's own frame."),
    Quantity("centroid_y_mm", "y_S", "mm", "section", "Centroid of that area, in the cam's own frame."),
    Quantity("polar_moment_mm4", "I_p", "mm⁴", "section", "Second moment of that area about the cam's axis."),
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
        "Mass of the cam: plate and hub, or cylinder, less bore, keyway and groove.",
    ),
    Quantity(
        "unbalance_g_mm", "U", "g·mm", "solid", "Mass of the cam times the distance of its centre of gravity."
    ),
    Quantity("centre_of_gravity_mm", "e_S", "mm", "solid", "Distance of its centre of gravity from its axis."),
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
        "Bound on the relative error of the numbers in the row.",
    ),
]

QUANTITIES: dict[str, Quantity] = Quantities({quantity.name: quantity for quantity in _ALL})
"""Every quantity by name, in the order of the columns."""


def in_order(names: Collection[str]) -> list[str]:
    """The quantities among some names in the order of the columns, numbers of a train behind other sizes."""
    found = [name for name in QUANTITIES if name in names]
    of_train = sorted(name for name in names if name not in found and name in QUANTITIES)
    return sorted([*found, *of_train], key=lambda name: QUANTITIES[name].effect != "sizes")


BOUNDED = {name: quantity for name, quantity in QUANTITIES.items() if quantity.relation}
"""Those that ``[limits]`` takes by their names."""
EVERYTHING = "all"
"""The word in a scene's outputs that asks for every quantity."""
GEOMETRY = ("sizes", "frame", "pair", "motion", "pressure", "curvature", "reach", "crossing")
"""The effects that run where a scene names no outputs: those that every sweep of a cam's shape has a use for."""
DISCIPLINES = tuple(dict.fromkeys(q.effect for q in QUANTITIES.values() if q.effect not in ("limits", "proof")))
"""Every effect that computes quantities, by name."""

"""Numbers of a scene other than sizes. Each record gives the key, its columns in tables and its unit."""

from collections.abc import Mapping
from functools import cache

from camopt.core.quantities.key import ANYWHERE, LENGTH, LENGTHS, NOT_NEGATIVE, NumberKey

GUIDE_EFFECTS = ("torque", "thrust", "hertz", "surface")
"""Effects that read the follower's guide."""
PRESS_EFFECTS = ("force", *GUIDE_EFFECTS, "vibration", "clearance")
"""Effects that read the forces on the follower."""
NUMBERS = (
    NumberKey(
        "Constant speed of the cam; without it, derivatives are by cam angle",
        "rev/min",
        key="cam.rpm",
        example=300,
        columns=(("rpm", "n", "Speed of the cam."),),
        usual=(0.01, 1e5),
    ),
    NumberKey(
        "Diameter of the shaft, which must lie within the base circle",
        "mm",
        key="cam.shaft_diameter",
        allowed=LENGTH,
        columns=(("shaft_diameter_mm", "", "Diameter of the shaft."),),
        usual=LENGTHS,
    ),
    NumberKey(
        "Mass that moves with a translating follower",
        "kg",
        key="follower.dynamics.mass",
        columns=(("mass_kg", "m", "Mass that moves with the follower."),),
        example=0.5,
        read_by=PRESS_EFFECTS,
        usual=(1e-05, 1e4),
        slides=True,
    ),
    NumberKey(
        "Moment of inertia of an oscillating follower about its pivot",
        "kg·m²",
        key="follower.dynamics.inertia",
        columns=(("inertia_kg_m2", "J", "Inertia of the follower about its pivot."),),
        example=0.01,
        read_by=PRESS_EFFECTS,
        usual=(1e-09, 1e4),
        turns=True,
    ),
    NumberKey(
        "Rate of the spring that presses the follower on the cam",
        "N/mm",
        "N·m/rad",
        key="follower.dynamics.spring_rate",
        allowed=NOT_NEGATIVE,
        columns=(
            ("spring_rate_N_per_mm", "k", "Rate of the spring."),
            ("spring_rate_N_m_per_rad", "k", "Rate of the spring."),
        ),
        motion_of="spring",
        default=0.0,
        example=5,
        turning_example=15,
        read_by=PRESS_EFFECTS,
    ),
    NumberKey(
        "Force (moment) of the spring at the follower's lowest position",
        "N",
        "N·m",
        key="follower.dynamics.preload",
        allowed=NOT_NEGATIVE,
        columns=(("preload_N", "F_0", "Preload of the spring."), ("preload_N_m", "M_0", "Preload of the spring.")),
        motion_of="spring",
        default=0.0,
        example=100,
        turning_example=6,
        read_by=PRESS_EFFECTS,
    ),
    NumberKey(
        "Distance from the pivot at which a straight spring presses square to the arm of an oscillating "
        "follower; `spring_rate` is then in N/mm, and `preload` in N",
        "mm",
        key="follower.dynamics.spring_at",
        allowed=LENGTH,
        columns=(("spring_at_mm", "a", "Distance of a straight spring from the pivot."),),
        read_by=PRESS_EFFECTS,
        turns=True,
    ),
    NumberKey(
        "Damping of the follower's motion",
        "N·s/mm",
        "N·m·s/rad",
        key="follower.dynamics.damping",
        allowed=NOT_NEGATIVE,
        columns=(
            ("damping_N_s_per_mm", "c", "Damping of the follower's motion."),
            ("damping_N_m_s_per_rad", "c", "Damping of the follower's motion."),
        ),
        default=0.0,
        example=0.01,
        read_by=PRESS_EFFECTS,
    ),
    NumberKey(
        "External force (moment) that presses the follower on the cam",
        "N",
        "N·m",
        key="follower.dynamics.load",
        allowed=ANYWHERE,
        columns=(
            ("load_N", "", "External force on the follower."),
            ("load_N_m", "", "External moment on the follower."),
        ),
        default=0.0,
        read_by=PRESS_EFFECTS,
    ),
    NumberKey(
        "Acceleration of gravity, positive if it presses the follower on the cam",
        "m/s²",
        key="follower.dynamics.gravity",
        allowed=ANYWHERE,
        columns=(("gravity_m_s2", "g", "Acceleration of gravity towards the cam."),),
        default=0.0,
        example=9.81,
        read_by=PRESS_EFFECTS,
        slides=True,
    ),
    NumberKey(
        "Length of the guide of a translating follower",
        "mm",
        key="follower.dynamics.guide_length",
        allowed=LENGTH,
        columns=(("guide_length_mm", "b", "Length of the guide."),),
        example=60,
        read_by=GUIDE_EFFECTS,
        slides=True,
        guide=True,
    ),
    NumberKey(
        "Distance from the guide to the trace point at the follower's lowest position, at least the lift",
        "mm",
        key="follower.dynamics.overhang",
        allowed=NOT_NEGATIVE,
        columns=(("overhang_mm", "a_0", "Distance from the guide to the trace point."),),
        example=100,
        read_by=GUIDE_EFFECTS,
        slides=True,
        guide=True,
    ),
    NumberKey(
        "Coefficient of friction in the guide",
        "no unit",
        key="follower.dynamics.friction",
        allowed=NOT_NEGATIVE,
        columns=(("friction", "μ", "Coefficient of friction in the guide."),),
        default=0.0,
        example=0.1,
        read_by=GUIDE_EFFECTS,
        slides=True,
        guide=True,
    ),
    NumberKey(
        "Diameter of the round stem of a translating follower",
        "mm",
        key="follower.dynamics.stem_diameter",
        allowed=LENGTH,
        columns=(("stem_diameter_mm", "d", "Diameter of the follower's stem."),),
        example=12,
        read_by=("thrust",),
        slides=True,
        guide=True,
    ),
    NumberKey(
        "Natural frequency of the elastic train",
        "Hz",
        key="follower.dynamics.natural_frequency",
        columns=(("natural_frequency_Hz", "f_n", "Natural frequency of the train."),),
        example=200,
        read_by=("vibration",),
    ),
    NumberKey(
        "Damping ratio of the elastic train",
        "no unit",
        key="follower.dynamics.damping_ratio",
        allowed={"ge": 0, "lt": 1},
        columns=(("damping_ratio", "ζ", "Damping ratio of the train."),),
        default=0.0,
        example=0.05,
        read_by=("vibration",),
    ),
    NumberKey(
        "Allowed fluctuation of the speed, (largest − smallest)/mean, for the flywheel",
        "no unit",
        key="follower.dynamics.fluctuation",
        columns=(("fluctuation", "", "Allowed fluctuation of the speed."),),
        example=0.02,
        read_by=("torque",),
    ),
    NumberKey(
        "Clearance that the follower takes up before the tool moves",
        "mm",
        "deg",
        key="follower.dynamics.lash",
        allowed=NOT_NEGATIVE,
        columns=(
            ("lash_mm", "", "Clearance that the follower takes up."),
            ("lash_deg", "", "Clearance that the follower takes up."),
        ),
        motion_of="tool",
        example=0.2,
        read_by=("lash",),
    ),
    NumberKey(
        "Variation of the lash to either side",
        "mm",
        "deg",
        key="follower.dynamics.lash_variation",
        allowed=NOT_NEGATIVE,
        columns=(
            ("lash_variation_mm", "", "Variation of the lash to either side."),
            ("lash_variation_deg", "", "Variation of the lash to either side."),
        ),
        motion_of="tool",
        default=0.0,
        example=0.1,
        read_by=("lash",),
    ),
    NumberKey(
        "Interference of the two contacts of a pair before they are mounted",
        "mm",
        "deg",
        key="drive.interference",
        allowed=NOT_NEGATIVE,
        columns=(
            ("interference_mm", "δ_0", "Interference of the two contacts of a pair before they are mounted."),
            ("interference_deg", "δ_0", "Interference of the two contacts of a pair before they are mounted."),
        ),
    ),
    NumberKey(
        "Stiffness between the two contacts of a pair: rollers, discs and frame",
        "N/mm",
        "N·m/rad",
        key="drive.stiffness",
        columns=(
            ("pair_stiffness_N_per_mm", "k", "Stiffness between the two contacts of a pair."),
            ("pair_stiffness_N_m_per_rad", "k", "Stiffness between the two contacts of a pair."),
        ),
    ),
    NumberKey(
        "Clearance of the roller in its groove, or of a rib between its two rollers; the follower crosses it "
        "where the force changes sign",
        "mm",
        key="drive.clearance",
        allowed=LENGTH,
        columns=(("clearance_mm", "j", "Clearance of the roller in its groove, or of a rib between its rollers."),),
        example=0.02,
    ),
    NumberKey(
        "Moment of inertia of the roller about its pin; friction turns the roller the other way after a crossing",
        "kg·m²",
        key="drive.roller_inertia",
        columns=(("roller_inertia_kg_m2", "J_r", "Inertia of the roller about its pin."),),
        example=1e-06,
    ),
    NumberKey(
        "Coefficient of friction between roller and flank",
        "no unit",
        key="drive.friction",
        columns=(("roller_friction", "μ", "Coefficient of friction between roller and flank."),),
        example=0.1,
    ),
    NumberKey(
        "Young's modulus of the cam",
        "GPa",
        key="materials.cam_modulus",
        columns=(("cam_modulus_GPa", "E_1", "Young's modulus of the cam."),),
        read_by=("hertz", "surface"),
        usual=(0.1, 1500.0),
    ),
    NumberKey(
        "Poisson's ratio of the cam",
        "no unit",
        key="materials.cam_poisson",
        allowed={"ge": 0, "lt": 0.5},
        columns=(("cam_poisson", "ν_1", "Poisson's ratio of the cam."),),
        read_by=("hertz", "surface"),
    ),
    NumberKey(
        "Young's modulus of the follower",
        "GPa",
        key="materials.follower_modulus",
        columns=(("follower_modulus_GPa", "E_2", "Young's modulus of the follower."),),
        read_by=("hertz", "surface"),
        usual=(0.1, 1500.0),
    ),
    NumberKey(
        "Poisson's ratio of the follower",
        "no unit",
        key="materials.follower_poisson",
        allowed={"ge": 0, "lt": 0.5},
        columns=(("follower_poisson", "ν_2", "Poisson's ratio of the follower."),),
        read_by=("hertz", "surface"),
    ),
    NumberKey(
        "Width of the contact along the cam's axis",
        "mm",
        key="materials.face_width",
        allowed=LENGTH,
        columns=(("face_width_mm", "L", "Width of the contact along the cam's axis."),),
        example=15,
        read_by=("face", "hertz", "surface"),
    ),
    NumberKey(
        "Wear rate: volume worn off the cam per unit of load and of sliding distance",
        "mm²/N",
        key="materials.wear_rate",
        columns=(
            ("wear_rate_mm2_per_N", "", "Wear rate: volume worn off per unit of load and of sliding distance."),
        ),
        example=1e-10,
        read_by=("surface",),
    ),
    NumberKey(
        "Dynamic viscosity of the lubricant",
        "Pa·s",
        key="materials.viscosity",
        columns=(("viscosity_Pa_s", "η", "Viscosity of the lubricant."),),
        example=0.05,
        read_by=("surface",),
    ),
    NumberKey(
        "Increase of the viscosity with pressure, α of η·exp(αp)",
        "1/GPa",
        key="materials.pressure_viscosity",
        columns=(("pressure_viscosity_per_GPa", "α", "Increase of the viscosity with pressure."),),
        example=20,
        read_by=("surface",),
    ),
    NumberKey(
        "Composite roughness of both surfaces, root mean square",
        "µm",
        key="materials.roughness",
        columns=(("roughness_um", "", "Composite roughness (root mean square)."),),
        example=0.4,
        read_by=("surface",),
    ),
)
"""Record of each number, in the order of keys and columns."""
NUMBER_KEYS = {number.key: number for number in NUMBERS}
"""Records of the numbers by key."""
NUMBER_COLUMNS = (*NUMBER_KEYS,)
"""Keys of the numbers."""
SPRING_AT = "follower.dynamics.spring_at"
"""Key of the distance from the pivot to a straight spring on an oscillating follower."""


def number_keys_of_table(table: str) -> tuple[NumberKey, ...]:
    """Numbers of a table of the scene."""
    return tuple(number for number in NUMBERS if number.table == table)


def has_number_angular_unit(key: str, *, angular: bool, tool_turns: bool, straight_spring: bool = False) -> bool:
    """Whether a number takes the unit of a rotation: its follower, tool or spring turns.

    A straight spring on the arm of an oscillating follower does not turn.
    """
    return {"follower": angular, "tool": tool_turns, "spring": angular and not straight_spring}[
        NUMBER_KEYS[key].motion_of
    ]


@cache
def quantity_name_by_number_key(
    *, angular: bool, tool_turns: bool, straight_spring: bool = False
) -> Mapping[str, str]:
    """Name of the quantity in tables for each number of the scene, by key."""
    turns = {
        key: has_number_angular_unit(key, angular=angular, tool_turns=tool_turns, straight_spring=straight_spring)
        for key in NUMBER_KEYS
    }
    return {key: number.quantities[-1 if turns[key] else 0].name for key, number in NUMBER_KEYS.items()}

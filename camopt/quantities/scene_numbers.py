"""The numbers of a scene that are no sizes as quantities, by key."""

from collections.abc import Mapping
from functools import cache

NUMBERS = (
    ("cam.rpm", "rpm", "n", "rev/min", "Speed of the cam."),
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
    (
        "materials.pressure_viscosity",
        "pressure_viscosity_per_GPa",
        "α",
        "1/GPa",
        "Increase of the viscosity with pressure.",
    ),
    ("materials.roughness", "roughness_um", "", "µm", "Composite roughness (root mean square)."),
)
"""Numbers of the scene, by key. Two rows of one key: what is a force for a translating follower is a moment for an
oscillating one."""


NUMBER_COLUMNS = tuple(dict.fromkeys(key for key, *_ in NUMBERS))
"""Their keys."""


OF_TOOL = ("follower.dynamics.lash", "follower.dynamics.lash_variation")
"""Numbers of the tool's motion, which a train drives."""


SPRING_AT = "follower.dynamics.spring_at"
"""The lever of a straight spring on the arm of an oscillating follower."""
OF_SPRING = ("follower.dynamics.spring_rate", "follower.dynamics.preload")
"""Numbers of the spring, whose moment is a force on its lever if it is a straight one."""


@cache
def number_quantities(*, angular: bool, tool_turns: bool, straight: bool = False) -> Mapping[str, str]:
    """The quantity that each number of the scene is in tables, by key.

    Of a follower, and of a tool, whose motion is an angle or not; of a spring that is a straight one, or one about
    the pivot of a follower that swings.
    """
    rows = {True: NUMBERS, False: NUMBERS[::-1]}  # the last row of a key counts
    found = {turns: {key: name for key, name, *_ in rows[turns]} for turns in rows}
    turns = dict.fromkeys(OF_TOOL, tool_turns) | dict.fromkeys(OF_SPRING, angular and not straight)
    return {key: found[turns.get(key, angular)][key] for key in NUMBER_COLUMNS}

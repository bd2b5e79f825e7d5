"""A quantity: its symbol, unit and sentence, and from which side it can be bounded."""

from dataclasses import dataclass

from camopt.quantities.key import NO_UNIT, Key

AT_MOST, AT_LEAST = "≤", "≥"
WITHOUT_BOUNDS = ("sizes", "limits", "proof")
"""Effects whose quantities are what is asked, or its answer."""
UNBOUNDED = (
    *("pressure_angle_max_at_deg", "pitch_circle_radius_mm", "centroid_x_mm", "centroid_y_mm"),
    *("crossing_count", "crossing_at_deg"),
    *("jamming_angle_deg", "contact_half_length_mm", "contact_shear_depth_mm", "joint_force_max_at_deg"),
    "joint_force_max_direction_deg",
)
"""Quantities that say where or how something is, not how much."""
BOUNDED_BELOW = (
    *("pitch_curvature_min_per_mm", "profile_radius_min_mm", "cutter_radius_max_mm", "face_reach_min_mm"),
    *("contact_force_min_N", "contact_force_elastic_min_N", "jump_speed_rpm", "jump_speed_ratio", "torque_min_N_m"),
    *("jamming_margin", "entrainment_speed_min_m_s", "film_thickness_min_um", "film_ratio_min", "hub_wall_min_mm"),
    *("lift_area_mm_deg", "lift_area_deg_deg", "transmission_angle_min_deg"),
    *("first_profile_radius_min_mm", "second_profile_radius_min_mm"),
    *("pivot_clearance_min_mm", "edge_wall_min_mm", "rib_thickness_min_mm", "pair_preload_ratio"),
)
"""Quantities of which one wants at least so much; of all others at most."""
SIGNED = (
    *("pitch_curvature_max_per_mm", "pitch_curvature_min_per_mm", "face_reach_max_mm", "face_reach_min_mm"),
    *("contact_force_min_N", "contact_force_max_N", "contact_force_elastic_min_N"),
    *("torque_max_N_m", "torque_min_N_m", "torque_mean_N_m", "power_mean_W"),
    *("entrainment_speed_max_m_s", "entrainment_speed_min_m_s", "jamming_margin"),
)
"""Quantities that may be below 0, and bounds on them too."""


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
    def key_of_limit(self) -> Key:
        """The key in ``[limits]`` that is its name."""
        words = "Least allowed" if self.relation == AT_LEAST else "Most allowed"
        return Key(f"{words} ``{self.name}``", self.unit or NO_UNIT)

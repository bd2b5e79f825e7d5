"""A cam for each contact and mechanism, with loads that try every formula: what tests of many effects share."""

from typing import Any

STEEL = {"cam": "steel", "follower": "steel", "face_width": 15}
WORN = {**STEEL, "wear_rate": 1e-10, "viscosity": 0.05, "pressure_viscosity": 18, "roughness": 0.3}
FREE = {"mass": 0.8, "spring_rate": 9.0, "preload": 260.0, "damping": 0.03, "load": 12.0, "gravity": 9.81}
UNGUIDED = {**FREE, "guide_length": 80, "overhang": 70, "stem_diameter": 16}
GUIDED = {**UNGUIDED, "friction": 0.12}
SWUNG = {"inertia": 0.02, "spring_rate": 60.0, "preload": 35.0, "damping": 0.2, "load": 1.5}

CORNERED = [[20, -60.0], [55, 180.0], [150, 40.0], [261.3, 40.0], [300, -25.0]]
JUMPING = [[0, 80.0], [70, 80.0], [70, 310.0], [110, 20.0], [220.5, 130.0], [360, -30.0]]
MOMENT = [[0, 1.0], [64.2, 9.0], [180, -3.0], [180, 2.0]]
"""External loads over the turn: deg, N (N·m)."""

ARM = {"motion": "oscillating", "arm_length": 110}
CONTACTS: dict[str, dict[str, Any]] = {
    "knife": {"motion": "translating", "contact": "knife"},
    "roller": {"motion": "translating", "contact": "roller", "roller_radius": 14},
    "offset-roller": {"motion": "translating", "contact": "roller", "roller_radius": 14, "offset": 11},
    "flat": {"motion": "translating", "contact": "flat"},
    "spherical": {"motion": "translating", "contact": "spherical", "face_radius": 60},
    "arm": {**ARM, "contact": "roller", "roller_radius": 14, "centre_distance": 130},
    "swinging-face": {"motion": "oscillating", "contact": "flat", "centre_distance": 130, "face_offset": 10},
    "groove": {"motion": "translating", "contact": "roller", "roller_radius": 6},
    "groove-arm": {**ARM, "contact": "roller", "roller_radius": 6},
}


def turn_of(law: str, lift: float, angles: tuple[float, ...] = (110, 40, 95, 115)) -> list[dict[str, Any]]:
    """Rise, dwell, return, dwell."""
    moving = {"lift": lift, "law": law}
    return [
        {"segment": kind, "angle": angle, **(moving if kind != "dwell" else {})}
        for kind, angle in zip(("rise", "dwell", "return", "dwell"), angles, strict=True)
    ]


def cam_with(
    contact: str,
    law: str = "cycloidal",
    dynamics: dict[str, Any] | None = None,
    rotation: str = "ccw",
    rpm: float = 420,
    **more: Any,
) -> dict[str, Any]:
    """A scene of a contact, with all its loads; ``more`` are tables beside these or in their place."""
    follower = CONTACTS[contact]
    swinging, groove = follower["motion"] == "oscillating", contact.startswith("groove")
    size = (
        {"form": "cylindrical", "mean_radius": 60}
        if groove
        else {"form": "disc", "base_radius": 90 if contact == "swinging-face" else 70}
    )
    chosen = dynamics if dynamics is not None else SWUNG if swinging else UNGUIDED
    return {
        "cam": {**size, "rpm": rpm, "rotation": rotation},
        "follower": {**follower, "dynamics": chosen},
        "materials": STEEL,
        "motion": turn_of(law, 14 if swinging else 24),
        "outputs": ["all"],
        **more,
    }

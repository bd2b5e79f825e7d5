"""Functions that other processes can import, as quantities."""

import numpy as np


def compactness(radius, angle):
    """``outer_radius_mm * torque_rms_N_m / cos(radians(pressure_angle_max_deg))`` of what ``COLUMNS`` names."""
    return radius * 13.5 / np.cos(np.radians(angle))


COLUMNS = ["outer_radius_mm", "pressure_angle_max_deg"]
TEXT = "outer_radius_mm * 13.5 / cos(radians(pressure_angle_max_deg))"

"""The hole for the shaft: a bore with a keyway, in the cam's frame [mm]."""

from math import asin, pi, radians, tan

import numpy as np

from camopt.core.numerics import ComplexArray
from camopt.core.numerics.stable_functions import difference_of_squares_root
from camopt.scene.part import TOWARDS_FOLLOWER, Part
from camopt.solve.contour.path import ArcPath


def keyway_corners(part: Part, direction_angle: float) -> ComplexArray:
    """Four corners of a keyway that points in the direction ``direction_angle`` (rad) [mm].

    Anticlockwise, from the corner at the mouth that lies to the right as seen from the axis.
    """
    half, bottom = (part.keyway_width or 0.0) / 2, (part.bore or 0.0) / 2 + (part.keyway_depth or 0.0)
    mouth = difference_of_squares_root((part.bore or 0.0) / 2, half)
    corners = np.array([complex(mouth, -half), complex(bottom, -half), complex(bottom, half), complex(mouth, half)])
    return np.asarray(corners * np.exp(1j * direction_angle))


def keyway_direction_angle(part: Part) -> float:
    """Direction of the middle of the keyway [rad]; towards the follower where the scene gives none."""
    return radians(TOWARDS_FOLLOWER if part.keyway_angle is None else part.keyway_angle)


def bore_with_keyway(part: Part) -> ArcPath:
    """The outline of a bore with a keyway, anticlockwise: the arc of the bore, then three sides of the keyway."""
    corners = keyway_corners(part, keyway_direction_angle(part))
    sweep = 2.0 * pi - 2.0 * asin((part.keyway_width or 0.0) / (part.bore or 0.0))
    vertices = np.concatenate([corners[-1:], corners])
    return ArcPath(vertices, np.array([tan(sweep / 4), 0.0, 0.0, 0.0]), np.zeros((4, 2)), (0,) * 4)

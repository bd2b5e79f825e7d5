"""Dense points of the curves of a cam, and how far points are from a line through others."""

from itertools import product
from math import inf

import numpy as np
from scipy.spatial import cKDTree


def largest_distance(points, corners):
    """The largest distance of points from a line through corners, on the segments beside their nearest corners."""
    closed = abs(corners[0] - corners[-1]) < 1e-6
    corners = corners[:-1] if closed else corners
    tree = cKDTree(np.column_stack([corners.real, corners.imag]))
    _, nearest = tree.query(np.column_stack([points.real, points.imag]), k=4)  # some lie on each other
    found = np.full(points.size, inf)
    for place, step in product(nearest.T, (-1, 0)):
        start = (place + step) % corners.size if closed else np.clip(place + step, 0, corners.size - 2)
        a, b = corners[start], corners[(start + 1) % corners.size]
        length = np.maximum(np.abs(b - a), 1e-30)
        share = np.clip(((points - a) * (b - a).conjugate()).real / length**2, 0.0, 1.0)
        found = np.minimum(found, np.abs(points - a - share * (b - a)))
    return found.max()


def true_points(problem, distance, count=40_001):
    """The curve as other programs get it: from ``cam_curves``, not from series."""
    from camopt.model.mechanisms.geometry import cam_curves

    angles = np.linspace(0.0, 2 * np.pi, count)
    starts = [stroke.start for stroke in problem.programme.strokes]
    found = cam_curves(
        problem.setup.mechanism, problem.design, problem.programme, np.sort(np.append(angles, starts))
    )
    return found.pitch + distance * found.normal

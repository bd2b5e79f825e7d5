"""Cams whose profile is known in closed form, as a machine would measure them, without the package.

The inlet lobe has the polynomial of valve designers, y = L·(1 + C₂x² + C_p·xᵖ + C_q·x^q + C_r·xʳ), |x| ≤ 1, whose
coefficients make y, y', y″ and y‴ vanish at both ends (Thoren, Engemann and Stoddart, Cam design as related to
valve train dynamics, 1952), under a flat tappet. The worn cam has cycloidal strokes under an offset roller; its
rising flank has lost up to 0.05 mm.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Curve = Callable[[Array], tuple[Array, Array]]
"""From cam angles (rad) to points x + iy of a profile at cam angle 0, and its outward normals there."""

LIFT, BASE, HALF = 9.0, 18.0, np.radians(68.0)
POWERS = (2, 8, 14, 20)
NOSE = np.radians(100.0)  # cam angle of the largest lift

ROLLER, OFFSET, LEAST, STROKE = 10.0, 6.0, 32.0, 12.0
RISE, TOP, RETURN = np.radians([80.0, 30.0, 90.0])
WEAR, WORN_AT, WORN_OVER = 0.05, np.radians(20.0), np.radians(10.0)  # mm, and cam angles


def coefficients() -> Array:
    """C₂, C_p, C_q, C_r: y and its first three derivatives vanish at x = 1."""
    falling = [[np.prod([p - j for j in range(order)]) for p in POWERS] for order in range(4)]
    return np.linalg.solve(np.array(falling, dtype=float), [-1.0, 0.0, 0.0, 0.0])


def valve_lift(theta: Array) -> list[Array]:
    """y and its first three derivatives, of the lobe."""
    x = (np.mod(theta - NOSE + np.pi, 2 * np.pi) - np.pi) / HALF
    inside, found = np.abs(x) <= 1.0, []
    for order in range(4):
        powers = zip(coefficients(), POWERS, strict=True)
        terms = [c * np.prod([p - j for j in range(order)]) * x ** max(p - order, 0) for c, p in powers]
        y = LIFT * (sum(terms) + (1.0 if order == 0 else 0.0)) / HALF**order
        found.append(np.where(inside, y, 0.0))
    return found


def valve_profile(theta: Array) -> tuple[Array, Array]:
    """The lobe under a flat face, on a cam that turns ccw: the contact is y' beside the axis, R_b + y above it."""
    y, y1, *_ = valve_lift(theta)
    turn = np.exp(-1j * theta)
    return turn * (y1 + 1j * (BASE + y)), turn * 1j


def cycloidal(theta: Array) -> list[Array]:
    """y and y' of the worn cam when it was new: rise, dwell, return, dwell."""
    theta = np.mod(theta, 2 * np.pi)
    up, down = theta / RISE, (theta - RISE - TOP) / RETURN
    rising, falling = theta < RISE, (down >= 0.0) & (down < 1.0)
    at_top = (theta >= RISE) & (down < 0.0)
    y = np.where(rising, up - np.sin(2 * np.pi * up) / (2 * np.pi), 0.0) + at_top
    y = y + np.where(falling, 1.0 - down + np.sin(2 * np.pi * down) / (2 * np.pi), 0.0)
    slope = np.where(rising, (1 - np.cos(2 * np.pi * up)) / RISE, 0.0)
    slope = slope - np.where(falling, (1 - np.cos(2 * np.pi * down)) / RETURN, 0.0)
    return [STROKE * y, STROKE * slope]


def worn_profile(theta: Array, wear: float = WEAR) -> tuple[Array, Array]:
    """The cam of the roller, less what wear took along the normal; the normals are those of the new cam."""
    y, y1 = cycloidal(theta)
    s = np.sqrt((LEAST + ROLLER) ** 2 - OFFSET**2) + y
    along = y1 - OFFSET  # of a ccw cam: the pitch curve runs this way beside the follower
    turn, normal = np.exp(-1j * theta), (-along + 1j * s) / np.hypot(along, s)
    lost = wear * np.cos(np.clip((theta - WORN_AT) / WORN_OVER, -1.0, 1.0) * np.pi / 2) ** 2
    return turn * (OFFSET + 1j * s - (ROLLER + lost) * normal), turn * normal


def touched_lift(curve: Curve, theta: Array, radius: float, offset: float = 0.0) -> Array:
    """How high a roller stands on a profile at cam angles, by trying all points below it of 100,000."""
    points, _ = curve(np.linspace(0.0, 2 * np.pi, 100_001)[:-1])
    points = points[np.argsort(np.angle(points))]
    around = (np.angle(points) + 2 * np.pi * np.array([[-1], [0], [1]])).ravel()
    room = np.arcsin(min((abs(offset) + radius) / np.abs(points).min(), 1.0))  # beyond, none is below the roller
    up = np.angle(np.exp(1j * (np.pi / 2 - theta)))  # where it is, seen from the cam
    ends = zip(np.searchsorted(around, up - room), np.searchsorted(around, up + room, "right"), strict=True)
    found = []
    for angle, (low, high) in zip(theta, ends, strict=True):
        seen = points[np.arange(low, high) % points.size] * np.exp(1j * angle)
        below = np.abs(seen.real - offset) <= radius
        found.append(np.max(seen.imag[below] + np.sqrt(radius**2 - (seen.real[below] - offset) ** 2)))
    return np.array(found)


def along_the_profile(curve: Curve, count: int) -> Array:
    """Cam angles whose points are at even steps along the profile."""
    theta = np.linspace(0.0, 2 * np.pi, 200_001)
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(curve(theta)[0])))])
    return np.interp(np.linspace(0.0, length[-1], count + 1)[:-1], length, theta)


def at_polar_angles(curve: Curve, probe: float, angles: Array) -> Array:
    """Cam angles at which the centre of a ball is where a radial follower meets it at given angles (rad)."""
    theta = np.linspace(-np.pi, 3 * np.pi, 400_001)
    points, normals = curve(theta)
    met = np.unwrap(np.pi / 2 - np.angle(points + probe * normals))
    met += 2 * np.pi * np.round((theta[200_000] - met[200_000]) / (2 * np.pi))
    return np.interp(angles, met, theta)


def probe_centres(curve: Curve, theta: Array, probe: float = 0.0, noise: float = 0.0, seed: int = 1) -> Array:
    """Centres of a ball on a profile, with normal errors along its normals."""
    points, normals = curve(theta)
    errors = noise * np.random.default_rng(seed).normal(size=theta.size)
    return points + (probe + errors) * normals


def xy(points: Array) -> Array:
    """Rows of x and y."""
    return np.column_stack([points.real, points.imag])

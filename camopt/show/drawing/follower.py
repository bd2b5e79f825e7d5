"""Draws followers to scale at cam angle 0: the contacting part, and its stem or arm."""

from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray
from camopt.model.mechanisms import oscillating_flat
from camopt.show.drawing.picture import Picture, draw_circle, draw_line, fill_area
from camopt.show.drawing.style import BODY, INK, MUTED

BODY_STYLE = {"facecolor": BODY, "edgecolor": INK, "lw": 1.1}


class FollowerAxes(NamedTuple):
    """Axes for parts that move differently. A still picture uses the same axes for all."""

    follower: Any
    ground: Any
    """Fixed parts, such as the guide."""
    contact: Any
    """The contact of follower and cam."""


def draw_follower(follower_axes: FollowerAxes, picture: Picture, size: float) -> list[ComplexArray]:
    """Draw the follower of a disc cam; return its extent. ``size`` is the largest radius of the cam [mm]."""
    swings = picture.problem.setup.angular
    if picture.problem.setup.mechanism.flat_faced:
        return (_draw_swinging_face if swings else _draw_sliding_face)(follower_axes, picture, size)
    trace = complex(_start_trace_and_normal(picture)[0])
    pivot = complex(picture.problem.design.centre_distance[0]) if swings else 0j
    up = -1j * (trace - pivot) / abs(trace - pivot) if swings else 1j
    seat = _draw_tip_and_find_seat(follower_axes, picture, trace, up, size)
    if not swings:
        return [*_draw_follower_stem(follower_axes, picture, seat, size), np.array([trace])]
    draw_arm(follower_axes, pivot, seat, size)
    swing = _draw_tip_arc(follower_axes.ground, picture, pivot, trace)
    return [swing, np.array([pivot + 0.12 * size * (1 - 1j), seat + 0.12j * size])]


def _draw_sliding_face(follower_axes: FollowerAxes, picture: Picture, size: float) -> list[ComplexArray]:
    """Draw a face square to the motion, as wide as the contact needs."""
    design, values = picture.problem.design, picture.quantity_values
    contact, offset, thick = complex(_start_trace_and_normal(picture)[0]), float(design.offset[0]), 0.045 * size
    ends = design.sense * np.array([values["face_reach_min_mm"], values["face_reach_max_mm"]]) + offset
    left = min(*ends, offset - 0.07 * size) - 0.05 * size
    right = max(*ends, offset + 0.07 * size) + 0.05 * size
    face = np.array([left, right, right + 1j * thick, left + 1j * thick]) + 1j * contact.imag
    fill_area(follower_axes.follower, face, zorder=5, **BODY_STYLE)
    draw_line(follower_axes.contact, [contact], marker="o", ms=3.5, color=INK, zorder=7)
    return [face, *_draw_follower_stem(follower_axes, picture, offset + 1j * (contact.imag + thick), size)]


def _draw_follower_stem(
    follower_axes: FollowerAxes, picture: Picture, seat: complex, size: float
) -> list[ComplexArray]:
    """Draw the stem above its seat, in a guide above the reach of the follower; return its extent."""
    half, lift = 0.035 * size, picture.problem.programme.lift
    roller = float(picture.problem.design.roller_radius[0]) * (seat == complex(_start_trace_and_normal(picture)[0]))
    guide = 0.05 * size + roller + lift
    top = guide + 0.16 * size
    stem = seat + np.array([-half, half, half + 1j * top, -half + 1j * top])
    fill_area(follower_axes.follower, stem, zorder=4.8, **BODY_STYLE)
    for side in (-1.0, 1.0):
        block = seat + side * half + np.array([0, side * 0.07 * size])
        block = np.concatenate([block + 1j * guide, block[::-1] + 1j * (guide + 0.1 * size)])
        fill_area(
            follower_axes.ground, block, facecolor="white", edgecolor=MUTED, hatch="//////", lw=0.8, zorder=4.7
        )
    return [stem]


def _draw_tip_and_find_seat(
    follower_axes: FollowerAxes, picture: Picture, trace_point: complex, motion_direction: complex, size: float
) -> complex:
    """Draw a knife edge, roller or spherical face that moves along a direction; return the seat of its carrier."""
    contact, axes = picture.scene.follower.contact, follower_axes.follower
    radius = float(picture.problem.design.roller_radius[0])
    if contact == "knife":
        wedge = trace_point + motion_direction * size * np.array([0, 0.12 - 0.045j, 0.12 + 0.045j])
        fill_area(axes, wedge, zorder=5, **BODY_STYLE)
        return trace_point + motion_direction * 0.12 * size
    normal = complex(_start_trace_and_normal(picture)[1])
    if contact == "roller":
        turn = np.exp(1j * np.linspace(0.0, 2 * np.pi, 181))
        fill_area(axes, trace_point + radius * turn, zorder=5, facecolor="white", edgecolor=INK, lw=1.3)
        draw_circle(axes, min(0.15 * radius, 0.015 * size), trace_point, color=INK, lw=0.9, zorder=6)
        seat = trace_point
    else:
        half = np.radians(min(max(picture.quantity_values["pressure_angle_max_deg"] + 8.0, 20.0), 85.0))
        cap = trace_point - radius * motion_direction * np.exp(1j * np.linspace(-half, half, 91))
        back = motion_direction * max(0.04 * size, 0.06 * radius)
        fill_area(axes, np.concatenate([cap, cap[[-1, 0]] + back]), zorder=5, **BODY_STYLE)
        draw_line(axes, [trace_point], marker="+", ms=7, color=INK, zorder=6)
        seat = complex((cap[0] + cap[-1]) / 2 + back)
    draw_line(follower_axes.contact, [trace_point - radius * normal], marker="o", ms=3.5, color=INK, zorder=7)
    return seat


def _draw_swinging_face(follower_axes: FollowerAxes, picture: Picture, size: float) -> list[ComplexArray]:
    """Draw a straight face at its distance from the pivot, as long as the contact needs."""
    design, values = picture.problem.design, picture.quantity_values
    pivot, face = complex(design.centre_distance[0]), float(design.face_offset[0])
    psi = float(np.arcsin(oscillating_flat.sine_of_start_face_angle(design))[0]) + picture.start_displacement
    along, normal = -np.exp(-1j * psi), 1j * np.exp(-1j * psi)
    foot, thick = pivot + face * normal, 0.05 * size
    near, far = values["face_reach_min_mm"] - 0.08 * size, values["face_reach_max_mm"] + 0.08 * size
    blade = foot + along * np.array([near, far, far, near]) + normal * np.array([0, 0, thick, thick])
    draw_arm(follower_axes, pivot, complex(foot + along * near + normal * thick / 2), size)
    fill_area(follower_axes.follower, blade, zorder=5, **BODY_STYLE)
    draw_line(follower_axes.contact, [_start_trace_and_normal(picture)[0]], marker="o", ms=3.5, color=INK, zorder=7)
    swing = _draw_tip_arc(follower_axes.ground, picture, pivot, complex(foot + along * far))
    return [swing, blade, np.array([pivot + 0.12 * size * (1 - 1j)])]


def draw_arm(follower_axes: FollowerAxes, pivot: complex, end: complex, size: float) -> None:
    """Draw an arm from its fixed pivot to the tip of the follower."""
    axes, fixed, half = follower_axes.follower, follower_axes.ground, 0.03 * size
    across = 1j * (end - pivot) / max(abs(end - pivot), 1e-300) * half
    fill_area(
        axes, [pivot + across, end + 0.7 * across, end - 0.7 * across, pivot - across], zorder=4.8, **BODY_STYLE
    )
    ground = pivot + size * np.array([0, 0.07 - 0.09j, -0.07 - 0.09j])
    fill_area(fixed, ground, facecolor="white", edgecolor=MUTED, lw=0.9, zorder=4.7)
    base = pivot + size * np.array([-0.1 - 0.09j, 0.1 - 0.09j, 0.1 - 0.115j, -0.1 - 0.115j])
    fill_area(fixed, base, facecolor="white", edgecolor=MUTED, hatch="//////", lw=0.0, zorder=4.6)
    draw_line(fixed, base[:2], color=MUTED, lw=0.9, zorder=4.7)
    turn = np.exp(1j * np.linspace(0.0, 2 * np.pi, 91))
    fill_area(axes, pivot + 1.25 * half * turn, zorder=6, **BODY_STYLE)
    draw_line(axes, [pivot], marker="o", ms=2.5, color=INK, zorder=6.1)


def _draw_tip_arc(axes: Any, picture: Picture, pivot: complex, tip: complex) -> ComplexArray:
    """Draw the arc of the tip of an arm; return its points."""
    angles = np.linspace(0.0, picture.problem.programme.lift, 61) - picture.start_displacement
    swing = pivot + (tip - pivot) * np.exp(-1j * angles)
    draw_line(axes, swing, color=MUTED, lw=0.8, ls=(0, (2, 2)), zorder=4.4)
    return np.asarray(swing)


def _start_trace_and_normal(picture: Picture) -> tuple[complex, complex]:
    """Trace point (contact point of a flat face) and outward normal at cam angle 0."""
    problem = picture.problem
    travel = problem.setup.mechanism.trace_and_normal(problem.design, problem.programme, np.zeros(1))
    return complex(travel.trace[0]), complex(travel.normal[0])

"""Data of one cam for the program of a page: motion by smooth pieces, sizes and diagrams, as plain numbers."""

from math import isfinite
from typing import Any

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.scene.problem.linkage import linkage_sketch
from camopt.scene.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.show.drawing.cam import outline_left_by_undercutting
from camopt.show.drawing.figures import all_panels_in_shown_units
from camopt.show.drawing.linkage import sketch_extent_over_turn
from camopt.show.drawing.moving_bodies import FRAME_ANGLES
from camopt.show.drawing.panels import Panel
from camopt.show.drawing.picture import STROKE_NAMES, Picture
from camopt.show.drawing.second_contact import second_contact_shapes

LARGEST_POWER = 300
POWERS_OF_TEN = np.array([float(f"1e{power}") for power in range(-LARGEST_POWER, LARGEST_POWER + 1)])
PAGE_DIGITS = 8  # significant digits: more than a screen shows, fewer than a double has


def cam_data(picture: Picture) -> dict[str, Any]:
    """Motion, shape and diagrams of one design. Lengths in mm, cam angles in deg, displacements y in mm or rad.

    ``left`` is the outline of an undercut disc cam after the follower has cut it. ``second`` has the outlines of a
    second contact: its disc, and the parts of the follower at y = 0.
    """
    problem = picture.problem
    if not picture.can_assemble:
        return {"exists": False}
    first, second = picture.contacts[0], second_contact_shapes(picture, 0.0)
    cut_disc = picture.undercut and problem.setup.mechanism.body.bounded
    pitch_point = not problem.setup.mechanism.flat_faced and picture.steepest_contact is first
    return {
        "exists": True,
        **cam_kind_data(picture.scene, problem),
        "sizes": {name: rounded_number_for_page(values[0]) for name, values in problem.design.sizes.items()},
        "motion": sampled_motion_pieces(picture),
        "strokes": [
            {
                "name": "move" if stroke.is_move else STROKE_NAMES[stroke.kind],
                "kind": STROKE_NAMES.get(stroke.kind, "move"),
                "law": stroke.law.NAME if stroke.law else "",
                "start": rounded_number_for_page(np.degrees(stroke.start)),
                "angle": rounded_number_for_page(np.degrees(stroke.angle)),
            }
            for stroke in problem.programme.strokes
        ],
        "pitch_point": first.quantity_values["pressure_angle_max_at_deg"] if pitch_point else None,
        "steepest": first.quantity_values["pressure_angle_max_deg"],
        "undercut": picture.undercut,
        "left": _x_and_y_lists(outline_left_by_undercutting(picture)) if cut_disc else None,
        "panels": [_panel_data(panel) for panel in all_panels_in_shown_units(picture)],
        "train": train_position_data(picture),
        "second": None
        if second is None
        else {
            "outline": _x_and_y_lists(second.outline) if second.outline.size else None,
            "solid": [_x_and_y_lists(points) for points in second.solid],
            "lines": [_x_and_y_lists(points) for points in second.lines],
        },
    }


def train_position_data(picture: Picture) -> dict[str, Any] | None:
    """Positions of the train over the turn, relative to the point that the follower drives at y = 0."""
    problem = picture.problem
    developed = problem.setup.mechanism.body.developed
    size = problem.design.size[0] if developed else max(np.abs(each.pitch).max() for each in picture.curves)
    at = 0j if problem.setup.angular else 1j * picture.start_displacement
    if (sketch := linkage_sketch(problem, FRAME_ANGLES % (2 * np.pi), at, float(size))) is None:
        return None
    reach = sketch_extent_over_turn(sketch)
    return {
        "members": [
            {
                "shape": member.shape,
                "points": _x_and_y_lists(member.points),
                "at": _x_and_y_lists(member.at),
                "turned": rounded_numbers_for_page(np.degrees(member.turned)),
            }
            for member in sketch.members
        ],
        "standing": [
            {
                "ground": support.ground,
                "at": _x_and_y_lists(np.array([support.at])),
                "way": _x_and_y_lists(np.array([support.way])),
            }
            for support in sketch.supports
        ],
        "reach": _x_and_y_lists(np.array([complex(f(reach.real), f(reach.imag)) for f in (np.min, np.max)])),
    }


def _x_and_y_lists(points: ComplexArray) -> list[list[float | None]]:
    """The list of x and the list of y of points."""
    return [rounded_numbers_for_page(points.real), rounded_numbers_for_page(points.imag)]


def cam_kind_data(scene: Scene, problem: Problem) -> dict[str, Any]:
    """Kinds of cam, motion and contact, sense of rotation, speed and shaft: they select the formulas of the page.

    ``outer_diameter`` is that of a disc with a groove or rib on its face [mm]; None if unknown.
    """
    body, diameter = problem.setup.mechanism.body, problem.setup.solid.outer_diameter
    return {
        "on_face": body.closed and not body.bounded,
        "outer_diameter": diameter,
        "form": scene.cam.form,
        "moves": scene.follower.motion,
        "contact": scene.follower.contact,
        "sense": problem.design.sense,
        "shaft": problem.setup.shaft_radius,
        "rpm": scene.cam.rpm,
    }


def sampled_motion_pieces(picture: Picture) -> dict[str, Any]:
    """Cam angle, y and dy/dθ of each smooth piece, and the lift. Jumps lie between pieces."""
    names = [STROKE_NAMES[kind] for kind in picture.stroke_kind_of_each_piece]
    pieces = [
        {
            "kind": name,
            "angle": rounded_numbers_for_page(np.degrees(angles)),
            "y": rounded_numbers_for_page(moved[0]),
            "slope": rounded_numbers_for_page(moved[1]),
        }
        for name, angles, moved in zip(names, picture.angles_of_pieces, picture.motion, strict=True)
    ]
    return {"lift": rounded_number_for_page(picture.problem.programme.lift), "pieces": pieces}


def _panel_data(panel: Panel) -> dict[str, Any]:
    return {
        "title": panel.title,
        "unit": panel.unit,
        "values": [rounded_numbers_for_page(values) for values in panel.values],
        "reference": panel.reference and [rounded_numbers_for_page(values) for values in panel.reference],
        "other": panel.other and [rounded_numbers_for_page(values) for values in panel.other],
        "peaks": [
            {"angle": rounded_number_for_page(p.angle), "value": rounded_number_for_page(p.value), "text": p.text}
            for p in panel.peaks
        ],
        "limits": [
            {
                "kinds": [name for kind, name in STROKE_NAMES.items() if kind & kinds],
                "bound": rounded_number_for_page(bound),
            }
            for kinds, bound in panel.limits
        ],
        "impulses": [
            {"angle": rounded_number_for_page(angle), "size": rounded_number_for_page(size)}
            for angle, size in panel.impulses
        ],
        "bands": [[rounded_number_for_page(end) for end in band] for band in panel.bands],
        "marks": [[rounded_number_for_page(number) for number in mark] for mark in panel.marks],
        "span": panel.span and [rounded_number_for_page(end) for end in panel.span],
        "note": panel.note,
        "undercut": panel.alarm and [[bool(b) for b in bad] for bad in panel.alarm],
    }


def rounded_number_for_page(value: Any) -> float | None:
    """A number rounded to ``PAGE_DIGITS`` digits; None if it is not finite."""
    return float(f"{float(value):.{PAGE_DIGITS}g}") if np.isfinite(value) else None


def rounded_numbers_for_page(values: FloatArray) -> list[float | None]:
    """``rounded_number_for_page`` of an array, vectorised: a slider waits for thousands of numbers."""
    values = np.asarray(values, dtype=float)
    with np.errstate(all="ignore"):
        power = PAGE_DIGITS - 1 - np.floor(np.log10(np.abs(values)))
    usual = np.abs(power) <= LARGEST_POWER  # false for 0 and for values that are not finite
    scale = POWERS_OF_TEN[np.where(usual, power, 0.0).astype(int) + LARGEST_POWER]
    rounded = np.where(usual, np.rint(np.where(usual, values, 0.0) * scale) / scale, values)
    return [value if isfinite(value) else None for value in rounded.tolist()]

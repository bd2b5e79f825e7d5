"""Draws a second contact of a follower with a disc, to scale: a second disc, and the parts that touch it."""

from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray
from camopt.model.mechanisms.geometry import profile_points
from camopt.show.drawing.picture import Picture, draw_line, fill_area
from camopt.show.drawing.style import BODY, INK, SECOND_COLOUR

FRAME_SHARE = 1.06  # of the largest radius of the discs: distance of the frame of a translating follower


class SecondContact(NamedTuple):
    """The parts of a picture for a second contact [mm]."""

    outline: ComplexArray
    """Profile of a second disc in the frame of the cam; empty without one."""
    solid: list[ComplexArray]
    """Outlines of parts of the follower in the ground frame, at one displacement."""
    lines: list[ComplexArray]
    """Lines of the follower: the frame that joins both contacts."""


def second_contact_shapes(picture: Picture, displacement: float) -> SecondContact | None:
    """The second contact with a disc at a displacement [mm or rad]; None without one."""
    if len(picture.contacts) == 1 or picture.is_developed:
        return None
    problem, (first, second) = picture.problem, (each.problem.design for each in picture.contacts)
    mechanism, size = problem.setup.mechanism, picture.largest_pitch_radius
    outline = second_disc_outline(picture)
    if mechanism.start is None:
        high, low = first.size[0] + displacement, -(second.size[0] + problem.programme.lift - displacement)
        half, thick = size, 0.045 * size
        face = 1j * low + np.array([-half, half, half - 1j * thick, -half - 1j * thick])
        frame = np.array([-half + 1j * low, -half + 1j * high, half + 1j * high, half + 1j * low])
        return SecondContact(outline, [face], [frame])
    travel = [float(mechanism.start(each)[0]) for each in (first, second)]
    opposed = mechanism.further_contacts[0].mechanism.reverses
    displacements = displacement, problem.programme.lift - displacement if opposed else displacement
    assert mechanism.trace_point is not None
    one, other = (
        complex(*(float(np.squeeze(c)) for c in mechanism.trace_point(d, np.array([start + by]))))
        for d, start, by in zip((first, second), travel, displacements, strict=True)
    )
    other = other.conjugate() if opposed else other
    roller = other + float(second.roller_radius[0]) * np.exp(2j * np.pi * np.linspace(0.0, 1.0, 121))
    if problem.setup.angular:
        pivot = complex(first.centre_distance[0])
        across = 0.03j * size * (other - pivot) / abs(other - pivot)
        arm = np.array([pivot + across, other + 0.7 * across, other - 0.7 * across, pivot - across])
        return SecondContact(outline, [arm, roller], [])
    if not opposed:
        return SecondContact(outline, [roller], [np.array([one, other])])
    beside = -FRAME_SHARE * size
    return SecondContact(
        outline, [roller], [np.array([one, complex(beside, one.imag), complex(beside, other.imag), other])]
    )


def second_disc_outline(picture: Picture) -> ComplexArray:
    """Profile of the second disc in the frame of the cam; empty without one."""
    problem = picture.problem
    if not problem.setup.mechanism.second_contact_size_keys:
        return np.zeros(0, dtype=complex)
    each, angles = picture.contacts[1].problem, np.concatenate(picture.angles_of_pieces)
    with np.errstate(all="ignore"):
        return profile_points(each.setup.mechanism, each.design, problem.programme, angles).conj()


def draw_second_disc_outline(axes: Any, picture: Picture) -> None:
    """Draw the outline of a second disc, which turns with the first."""
    outline = second_disc_outline(picture)
    if outline.size:
        style = {"color": SECOND_COLOUR, "lw": 1.6, "zorder": 4.2}
        draw_line(axes, np.append(outline, outline[0]), label="profile of the second disc", **style)


def draw_second_contact(axes: Any, picture: Picture) -> list[ComplexArray]:
    """Draw the parts of the follower at a second contact, at cam angle 0; return their extent."""
    if (contact := second_contact_shapes(picture, picture.start_displacement)) is None:
        return []
    for line in contact.lines:
        draw_line(axes, line, color=INK, lw=1.6, alpha=0.5, zorder=4.6)
    for part in contact.solid:
        fill_area(axes, part, facecolor=BODY, edgecolor=SECOND_COLOUR, lw=1.2, zorder=5)
    return [*contact.solid, *contact.lines]

"""Links as pictures show them: rigid members that move, and what stands still, in a plane; mm and rad.

A link is drawn in a frame of its own. A train puts its links one after the other: each is turned, and mirrored
where that is needed, so that what drives it is where, and moves as, the one before says.
"""

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray

MemberShape = Literal["bar", "wheel", "slide", "roller", "wedge", "belt"]
SupportKind = Literal["pivot", "guide"]


class Port(NamedTuple):
    """Where a link is driven, or drives the next one, in the start position."""

    at: complex
    """Of an angle the pivot, of a length the point that moves."""
    way: complex = 1.0
    """Of length 1. Of a length where it moves to; of an angle the side that the next link is on."""
    sense: float = 1.0
    """Of an angle 1 if it grows counterclockwise, −1 if clockwise."""


class Member(NamedTuple):
    """A rigid part."""

    shape: MemberShape
    points: ComplexArray
    """Its joints or corners, seen from its own origin in the first position; of a round one its radius."""
    at: ComplexArray
    """Where that origin is in each position, (positions,)."""
    turned: FloatArray
    """By how much it has turned since the first position, (positions,)."""


class Support(NamedTuple):
    """A pivot, or a guide along a way, that stands still."""

    ground: SupportKind
    at: complex
    way: complex = 1.0


class LinkSketch(NamedTuple):
    """A link, or several, in some positions."""

    members: Sequence[Member]
    supports: Sequence[Support]
    input_port: Port
    """What drives it."""
    output_port: Port
    """What it drives."""

    @property
    def reversed_sketch(self) -> "LinkSketch":
        """The same, driven from its other end."""
        return self._replace(input_port=self.output_port, output_port=self.input_port)

    def attach_to(self, port: Port) -> "LinkSketch":
        """Where what drives it is a port of another link."""
        mirrored = port.sense != self.input_port.sense
        way = port.way / (np.conj(self.input_port.way) if mirrored else self.input_port.way)

        def rotate_points(points: Any) -> Any:
            return way * (np.conj(points) if mirrored else points)

        side, away = -1.0 if mirrored else 1.0, port.at - rotate_points(self.input_port.at)
        asked = self.output_port
        members = [
            Member(m.shape, rotate_points(m.points), rotate_points(m.at) + away, side * m.turned)
            for m in self.members
        ]
        standing = [Support(s.ground, rotate_points(s.at) + away, rotate_points(s.way)) for s in self.supports]
        return LinkSketch(
            members,
            standing,
            port,
            Port(rotate_points(asked.at) + away, rotate_points(asked.way), side * asked.sense),
        )

    def shift_by(self, by: complex) -> "LinkSketch":
        """Elsewhere in the plane."""
        return self.attach_to(self.input_port._replace(at=self.input_port.at + by))


def bar(ends: tuple[Any, Any]) -> Member:
    """A bar between two joints, from the paths of both."""
    along = np.asarray(ends[1] - ends[0], dtype=complex)
    return Member("bar", np.array([0.0, along[0]]), np.asarray(ends[0]), np.unwrap(np.angle(along / along[0])))


def wheel(radius: float, centre: complex, turned: FloatArray) -> Member:
    """A wheel on a fixed centre."""
    return Member("wheel", np.array([radius]), np.full(turned.size, complex(centre)), turned - turned[0])


def sliding_member(shape: MemberShape, points: Any, at: Any) -> Member:
    """A member that does not turn, from its corners and the path of its origin."""
    return Member(shape, np.asarray(points, dtype=complex), np.asarray(at), np.zeros(len(at)))

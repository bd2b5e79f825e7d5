"""Links as pictures show them: moving rigid members and fixed supports in a plane; mm and rad.

Each link is drawn in its own frame. A train attaches its links one after the other: it turns each link, and mirrors
it if necessary, so that its input port lies and moves as the output port of the link before.
"""

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray

MemberShape = Literal["bar", "wheel", "slide", "roller", "wedge", "belt"]


class Port(NamedTuple):
    """The place where a link is driven, or drives the next one, in the start position."""

    at: complex
    """The pivot of a turning member, or the moving point of a sliding one."""
    way: complex = 1.0
    """A unit vector: the direction in which a sliding member moves, or from a pivot the side of the next link."""
    sense: float = 1.0
    """1 if a turning member turns counterclockwise, −1 if clockwise."""


class Member(NamedTuple):
    shape: MemberShape
    points: ComplexArray
    """Joints or corners, from the member's origin, in the first position; of a round member its radius."""
    at: ComplexArray
    """Place of the origin in each position, (positions,)."""
    turned: FloatArray
    """Rotation since the first position [rad], (positions,)."""


class Support(NamedTuple):
    """A fixed pivot, or a fixed guide along a direction."""

    ground: Literal["pivot", "guide"]
    at: complex
    way: complex = 1.0


class LinkSketch(NamedTuple):
    """One link or several, in some positions."""

    members: Sequence[Member]
    supports: Sequence[Support]
    input_port: Port
    output_port: Port

    @property
    def reversed_sketch(self) -> "LinkSketch":
        """The same sketch, driven at its other end."""
        return self._replace(input_port=self.output_port, output_port=self.input_port)

    def attached_to_port(self, port: Port) -> "LinkSketch":
        """The sketch moved so that its input port lies on the port of another link."""
        mirrored = port.sense != self.input_port.sense
        way = port.way / (np.conj(self.input_port.way) if mirrored else self.input_port.way)

        def rotate_points(points: Any) -> Any:
            return way * (np.conj(points) if mirrored else points)

        side, away = -1.0 if mirrored else 1.0, port.at - rotate_points(self.input_port.at)
        output = self.output_port
        members = [
            Member(m.shape, rotate_points(m.points), rotate_points(m.at) + away, side * m.turned)
            for m in self.members
        ]
        standing = [Support(s.ground, rotate_points(s.at) + away, rotate_points(s.way)) for s in self.supports]
        return LinkSketch(
            members,
            standing,
            port,
            Port(rotate_points(output.at) + away, rotate_points(output.way), side * output.sense),
        )


def bar_member(ends: tuple[Any, Any]) -> Member:
    """A bar between two joints, from their paths."""
    along = np.asarray(ends[1] - ends[0], dtype=complex)
    return Member("bar", np.array([0.0, along[0]]), np.asarray(ends[0]), np.unwrap(np.angle(along / along[0])))


def wheel_member(radius: float, centre: complex, turn_angles: FloatArray) -> Member:
    """A wheel on a fixed centre."""
    return Member(
        "wheel", np.array([radius]), np.full(turn_angles.size, complex(centre)), turn_angles - turn_angles[0]
    )


def sliding_member(shape: MemberShape, corners: Any, origin_path: Any) -> Member:
    """A member that does not turn, from its corners and the path of its origin."""
    return Member(shape, np.asarray(corners, dtype=complex), np.asarray(origin_path), np.zeros(len(origin_path)))

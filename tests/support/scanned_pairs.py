"""The smallest conjugate pair by a dense scan: a program of its own, which has nothing of camopt's.

The centres of both rollers are points of the plane, which the cam turns: P = T·exp(iσθ), with two derivatives by
the cam angle. The general formulas of plane curves tell the curvature of a pitch curve, and the angle between its
normal and the way of the roller. All designs of a grid are looked at, then those of others about the least.
"""

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from support import naive

NUMPY = SimpleNamespace(
    zero=0.0,
    one=1.0,
    pi=np.pi,
    mpf=float,
    mpc=complex,
    cos=np.cos,
    sin=np.sin,
    expj=lambda angle: np.exp(1j * angle),
)
"""Plain floats, and arrays of them, as a context of ``naive``."""
PLACES, NEAR, CLOSER = 41, 9, 6  # of a piece of the motion; about the worst of them; how often
MANY, FEW = 21, 9  # values of a number in the first grid, and in those after it
LITTLE = 0.1  # of the width of a grid: it is made closer where the least size falls by less
SHRINK, FLAT = 0.6, 0.02  # grids; in base radii, since a little of those takes much of the other sizes
LAST = 1e-8  # of a range


class Sizes(NamedTuple):
    """Of one disc: base radius, radius of its roller, offset of the roller or length of its arm, in mm."""

    base: Any
    roller: Any
    place: Any


class ScannedPair:
    """A pair of discs with one follower and limits, by the data of its scene."""

    def __init__(self, scene: dict[str, Any]) -> None:
        self.scene, follower = scene, scene["follower"]
        self.swings = follower["motion"] == "oscillating"
        self.pieces = naive.programme(scene["motion"], NUMPY, self.swings)
        self.lift = max(float(piece.jet(piece.end)[0]) for piece in self.pieces)
        self.sense, self.centre = naive.spin(scene), follower.get("centre_distance", 0.0)
        self.names = ("base_radius", "roller_radius", "arm_length" if self.swings else "offset")

    def sizes(self, numbers: dict[str, Any]) -> tuple[Sizes, Sizes]:
        """Of both discs, with free numbers by their keys; the second has those of the first where it has no own."""
        first, second = ({**self.scene["cam"], **self.scene["follower"]}, {**self.scene["drive"]})
        for key, value in numbers.items():
            table, name = key.split(".")
            (second if table == "drive" else first)[name] = value
        return tuple(Sizes(*({**first, **own}[name] for name in self.names)) for own in ({}, second))

    def centres(self, which: int, sizes: Sizes, jet: Any) -> tuple[Any, Any, Any]:
        """The centre of a roller, which is at the foot of its disc at the least lift, and two derivatives of it."""
        (y, y1, y2, _), prime, up = jet, sizes.base + sizes.roller, 1.0
        if which:  # on the other side of the cam
            y, y1, y2, up = self.lift - y, -y1, -y2, -1.0
        if not self.swings:
            return sizes.place + up * 1j * (np.sqrt(prime**2 - sizes.place**2) + y), up * 1j * y1, up * 1j * y2
        c, length = self.centre, sizes.place
        start = np.arccos((c**2 + length**2 - prime**2) / (2.0 * c * length))
        arm = -length * np.exp(-up * 1j * (start + y))
        return c + arm, -up * 1j * y1 * arm, (-up * 1j * y2 - y1**2) * arm

    def at(self, which: int, sizes: Sizes, piece: naive.Piece, angle: Any) -> tuple[Any, Any]:
        """The magnitude of the pressure angle, deg, and the curvature of the pitch curve, 1/mm."""
        centre, *derivatives = self.centres(which, sizes, piece.jet(angle))
        _, p1, p2, turn = naive.turned_frame(self.sense, angle, centre, *derivatives, NUMPY)
        way = turn * 1j * ((centre - self.centre) if self.swings else 1.0)
        slant = np.arctan(np.abs(naive.cross(way, 1j * p1) / naive.cross(way, p1)))
        return np.degrees(slant), self.sense * naive.curvature(p1, p2)

    def worst(self, which: int, sizes: Sizes) -> list[Any]:
        """The largest of both over the turn: at places of each piece, then closer and closer about the worst."""
        found: list[Any] = [-np.inf, -np.inf]
        for piece in self.pieces:
            for k in range(len(found)):
                low, high, places = piece.start, piece.end, PLACES
                for _ in range(CLOSER if piece.kind != "dwell" else 1):
                    step = (high - low) / (places - 1)
                    angles = low + step * np.arange(places).reshape(-1, 1, 1, 1, 1)
                    values = self.at(which, sizes, piece, angles)[k]
                    index = np.argmax(values, axis=0)[None]
                    found[k] = np.maximum(found[k], np.take_along_axis(values, index, axis=0)[0])
                    low, high = low + step * (index - 1), low + step * (index + 1)
                    low, high, places = np.maximum(low, piece.start), np.minimum(high, piece.end), NEAR
        return found

    def margins(self, numbers: dict[str, Any]) -> list[Any]:
        """By how much designs hold each limit at each disc, relative; NaN of those that cannot be put together."""
        limits, found = self.scene["limits"], []
        for which, sizes in enumerate(self.sizes(numbers)):
            angle, curvature = self.worst(which, sizes)
            found.append(1.0 - angle / limits["pressure_angle"])
            found.append(1.0 - curvature * (sizes.roller + limits["curvature_radius"]))
        return found

    def least(self, ranges: dict[str, tuple[float, float]]) -> tuple[float, dict[str, float]]:
        """The least of larger base radii, and the numbers with it; infinite if no design of a whole grid will do.

        Of pairs as small the one is taken that is far from all limits, for the next grid to be about it.
        """
        low, high = np.array([*ranges.values()]).T
        width, centre, size, count = high - low, (low + high) / 2.0, np.inf, MANY
        while np.all(width > LAST * (high - low)):
            ends = np.maximum(low, centre - width / 2.0), np.minimum(high, centre + width / 2.0)
            axes = [np.linspace(*each, count) for each in zip(*ends, strict=True)]
            grid = dict(zip(ranges, np.meshgrid(*axes, indexing="ij", sparse=True), strict=True))
            with np.errstate(invalid="ignore"):
                margins = np.broadcast_arrays(*self.margins(grid))
            held = np.logical_and.reduce([each >= 0.0 for each in margins])
            bases = np.maximum(*(each.base for each in self.sizes(grid)))
            sizes = np.where(held, bases, np.inf)
            room = np.where(sizes == sizes.min(), np.multiply.reduce(margins), -1.0)
            place = np.unravel_index(np.argmax(room), sizes.shape)
            if sizes[place] == size == np.inf:
                break
            if count == MANY:
                width *= SHRINK * np.where(["base" in key for key in ranges], FLAT, 1.0)
            elif size - sizes[place] < LITTLE * width[0]:
                width *= SHRINK
            if sizes[place] < size:
                centre, size = np.array([axis[k] for axis, k in zip(axes, place, strict=True)]), float(sizes[place])
            count = FEW
        return size, dict(zip(ranges, centre.tolist(), strict=True))

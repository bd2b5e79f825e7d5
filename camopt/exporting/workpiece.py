"""The source of files for machines: the cam of a scene, and the scene's problem."""

from dataclasses import dataclass
from functools import cached_property
from math import inf

from camopt.contour.curve import SECOND, CamCurve, Disc, curves_of, discs_of
from camopt.problem.problem import Problem
from camopt.scene.part import Part
from camopt.scene.scene import Scene


@dataclass(frozen=True)
class Workpiece:
    """A cam that is to be made."""

    scene: Scene
    problem: Problem
    disc: int | None = None
    """The number of the disc of a pair that is made alone; None for the whole cam."""

    @cached_property
    def part(self) -> Part:
        """The part, completed from other tables of the scene: bore, material, density, name."""
        return self.scene.whole_part.of_disc(self.disc)

    @cached_property
    def discs(self) -> tuple[Disc, ...]:
        """The discs that are made."""
        return tuple(each for each in discs_of(self.problem) if self.disc in (None, each.number))

    @property
    def only(self) -> Disc:
        """The disc that is made alone."""
        (disc,) = self.discs
        return disc

    def curves(self, cutter_radius: float | None = None) -> dict[str, CamCurve]:
        """The curves of the discs that are made, by name (``curves_of``)."""
        return curves_of(self.problem, cutter_radius, self.disc)

    @property
    def title(self) -> str:
        """The name of the part, and which disc of it is made alone."""
        return (self.part.name or "cam") + ("" if self.disc is None else f", disc {self.disc}")

    @property
    def from_behind(self) -> bool:
        """Whether a disc is cut from behind its drawing, from where it is the first one.

        The hub of a cam stands out in front, and of a pair the first disc is in front of the second one.
        """
        return self.part.stands_on_hub if self.disc is None else self.disc == SECOND

    @property
    def stands_above(self) -> float:
        """How far the hub stands out above the plate of a disc that is cut, mm."""
        return 0.0 if self.from_behind else max((self.part.hub_length or 0.0) - self.part.width, 0.0)

    @property
    def room_below(self) -> float:
        """How far below the plate of a disc that is cut something else of the part begins, mm."""
        if self.disc is None:
            return 0.0 if self.part.stands_on_hub else inf
        return self.part.disc_gap or inf if self.part.hub_diameter else inf

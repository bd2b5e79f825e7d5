"""What files for machines are made of: a cam as a scene gives it, and the problem that the scene poses."""

from dataclasses import dataclass
from functools import cached_property

from camopt.problem.problem import Problem
from camopt.scene.part import Part
from camopt.scene.scene import Scene


@dataclass(frozen=True)
class Workpiece:
    """A cam that is to be made."""

    scene: Scene
    problem: Problem

    @cached_property
    def part(self) -> Part:
        """The part, with what ``[part]`` leaves to other tables: bore, material, density, name."""
        return self.scene.whole_part

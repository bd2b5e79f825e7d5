"""The source of files for machines: the cam of a scene, and the scene's problem."""

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
        """The part, completed from other tables of the scene: bore, material, density, name."""
        return self.scene.whole_part

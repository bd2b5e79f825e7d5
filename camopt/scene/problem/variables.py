"""Variables: the sizes, other numbers and angles of segments that may differ between designs of a scene.

Laws are no variables: a search tries them one by one.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import floor, inf, nan
from typing import Literal

import numpy as np

from camopt.core.mistakes import Mistake
from camopt.core.numerics import FloatArray
from camopt.core.quantities import QUANTITIES
from camopt.model.mechanisms import SECOND_FIELDS
from camopt.model.motion.segments import MotionSegment
from camopt.scene.choices import CheckedChoice, StepRange
from camopt.scene.scene import Scene
from camopt.scene.search import Search
from camopt.scene.sizes import SIGNED_SIZES

VariableRole = Literal["size", "number", "shared", "train", "angle"]
"""Role of a variable.

Designs carry a "size" or "number". All designs of a problem share a "shared" number, which decides the list of
limits, and a number of the "train", which decides the motion. An "angle" is that of a segment.
"""
SHARED_KEYS = ("cam.shaft_diameter",)
ROLE_ADVICE = {
    "number": "this number from the scene; only sweep and optimise can vary it",
    "shared": "this number from the scene; only sweep can vary it",
    "train": "this number of the train from the scene; only sweep and optimise can vary it",
    "angle": "the angles of the scene; only optimise can vary them",
}
"""The end of a message from a command that cannot vary a variable, by role."""


@dataclass(frozen=True)
class Variable:
    """A number that may differ between designs, with its choice in ``[search]``."""

    key: str
    """Key in the scene, such as ``cam.base_radius`` or ``motion.2.angle``."""
    role: VariableRole
    name: str
    """Key in ``[search]``, such as ``base_radius``, ``cam.rpm`` or ``angle_rise``."""
    field: str
    """Field in ``Designs`` and in boxes."""
    quantity: str = ""
    """Column in tables; empty for an angle."""
    choice: CheckedChoice | None = None
    """Range or list in ``[search]``; None if it is not searched."""
    segment: int = -1
    """Index of the segment of an angle."""
    shared_angle: float = 0.0
    """Sum of the angles of all varied segments, for an angle [deg]."""

    @property
    def search_key(self) -> str:
        """Key of its choice in the scene."""
        return f"search.{self.name}"

    @property
    def unit(self) -> str:
        return QUANTITIES[self.quantity].unit if self.quantity else "deg"

    @property
    def is_searched(self) -> bool:
        return self.choice is not None

    @property
    def is_size(self) -> bool:
        return self.role == "size"

    @property
    def is_scene_number(self) -> bool:
        """Whether it is a number of the scene other than a size."""
        return self.role in ("number", "shared", "train")

    @property
    def varies_by_design(self) -> bool:
        """Whether it may differ between designs of a problem, so that boxes may have a range of it."""
        return self.role not in ("shared", "train")

    @property
    def has_range(self) -> bool:
        """Whether the choice is a range."""
        return isinstance(self.choice, StepRange)

    @property
    def is_searched_continuously(self) -> bool:
        """Whether a search may use any value in a range."""
        return self.varies_by_design and self.has_range

    @property
    def range_ends(self) -> tuple[float, float]:
        """The least and the largest value of the choice; NaN without one."""
        if isinstance(self.choice, StepRange):
            return self.choice.start, self.choice.stop
        return (float(min(self.choice)), float(max(self.choice))) if self.choice else (nan, nan)

    @property
    def least_allowed_value(self) -> float:
        """The least value that is allowed at all: 0, or −∞ for signed values."""
        return -inf if self.field in SIGNED_SIZES or self.range_ends[0] < 0.0 else 0.0

    def order_of_magnitude(self, cam_length: float) -> float:
        """Order of magnitude of the variable, for a cam of the order of a length [mm]."""
        return {"size": cam_length, "angle": self.shared_angle}.get(self.role) or max(map(abs, self.range_ends))

    @property
    def first_value(self) -> float:
        """The first value of the choice."""
        return self.range_ends[0] if isinstance(self.choice, StepRange) else float(self.listed_values[0])

    @property
    def listed_values(self) -> FloatArray:
        """The values of a list without repetitions."""
        values = () if self.choice is None or isinstance(self.choice, StepRange) else self.choice
        return np.array([*dict.fromkeys(values)], dtype=float)

    @property
    def grid_count(self) -> int:
        """Number of values in a grid."""
        if not isinstance(self.choice, StepRange):
            return self.listed_values.size
        low, high = self.range_ends
        return 1 + (floor((high - low) / self.choice.step + 1e-9) if self.choice.step else 0)

    @property
    def grid_values(self) -> FloatArray:
        """The values in a grid; a range includes both ends, so the last step may be shorter."""
        if not isinstance(self.choice, StepRange):
            return self.listed_values
        low, high = self.range_ends
        return np.asarray(np.minimum(low + (self.choice.step or 0.0) * np.arange(self.grid_count), high))

    def values_at_shares(self, shares: FloatArray) -> FloatArray:
        """Values of the range or list at shares from 0 to 1."""
        if isinstance(self.choice, StepRange):
            low, high = self.range_ends
            return np.asarray(np.clip(low + shares * (high - low), low, high))
        return np.asarray(
            self.listed_values[
                np.minimum((shares * self.listed_values.size).astype(int), self.listed_values.size - 1)
            ]
        )

    @property
    def box_intervals(self) -> list[tuple[float, float]]:
        """The intervals in boxes: the range, or each listed value; for the cam's size one over all values."""
        if isinstance(self.choice, StepRange) or self.field == "size":
            return [self.range_ends]
        return [(value, value) for value in self.listed_values.tolist()]


def variables_of_scene(scene: Scene) -> tuple[Variable, ...]:
    """The variables of a scene: the sizes of its mechanism, the body's first, and all other numbers."""
    sizes, numbers, columns = scene.search.sizes, scene.search.numbers, scene.mechanism.size_quantity_by_field
    return (
        *(
            Variable(key, "size", name, field, columns[field], sizes.get(name))
            for key, field in scene.size_fields.items()
            for name in [key if key in SECOND_FIELDS else key.partition(".")[2]]
        ),
        *(
            Variable(key, "shared" if key in SHARED_KEYS else "number", key, key, name, numbers.get(key))
            for key, name in scene.number_quantities.items()
        ),
        *(Variable(key, "train", key, key, name, numbers.get(key)) for key, name in scene.stage_quantities.items()),
    )


def is_train_key(key: str) -> bool:
    """Whether a key belongs to a number of the train, which decides the motion."""
    return key.startswith("train.")


def angle_variables(search: Search, segments: Sequence[MotionSegment]) -> tuple[Variable, ...]:
    """The angles of segments that ``[search]`` varies."""
    varied = {place: each for place, each in enumerate(segments) if each.segment in search.angles}
    turn = float(sum(each.angle for each in varied.values()))
    return tuple(
        Variable(
            f"{s.key}.angle", "angle", f"angle_{s.segment}", f"angle {i}", "", search.angles[s.segment], i, turn
        )
        for i, s in varied.items()
    )


def variation_mistakes(file: str, variables: Iterable[Variable], command_phrase: str) -> list[Mistake]:
    """A mistake for each variable of ``[search]`` that a command (``command_phrase``) cannot vary."""
    advice = {each.search_key: ROLE_ADVICE[each.role] for each in variables if each.is_searched}
    why = {key: f"{command_phrase} {other}: leave it out of [search]" for key, other in advice.items()}
    return [Mistake(file, key, None, what, bare=True) for key, what in why.items()]

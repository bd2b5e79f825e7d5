"""What may differ between designs of a scene, each said once: its sizes, its other numbers, angles of its segments.

Laws are no variables: a search goes through them one by one.
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
"""Where a variable enters: as a size, or another number, that designs bring; as a number that decides which limits
there are, so that all designs of a problem share it; as one of the train, which decides their motion and which they
share therefore; as the angle of a segment of their motion."""
SHARED_KEYS = ("cam.shaft_diameter",)
ROLE_ADVICE = {
    "number": "this number from the scene; only sweep and optimise can vary it",
    "shared": "this number from the scene; only sweep can vary it",
    "train": "this number of the train from the scene; only sweep and optimise can vary it",
    "angle": "the angles of the scene; only optimise can vary them",
}
"""What those take that do not vary it, by where a variable enters."""


@dataclass(frozen=True)
class Variable:
    """A number that may differ between designs, and what ``[search]`` gives for it."""

    key: str
    """In the scene, as ``cam.base_radius`` or ``motion.2.angle``."""
    role: VariableRole
    name: str
    """In ``[search]``, as ``base_radius``, ``cam.rpm`` or ``angle_rise``."""
    field: str
    """In ``Designs`` and in boxes of them."""
    quantity: str = ""
    """The column that tables have it in; an angle has none of its own."""
    choice: CheckedChoice | None = None
    segment: int = -1
    """Of an angle, the number of its segment."""
    shared_angle: float = 0.0
    """Of an angle, the degrees that all freed segments have together."""

    @property
    def search_key(self) -> str:
        """Its key in the scene where a search varies it."""
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
    def is_number(self) -> bool:
        """Whether it is a number of the scene that is no size."""
        return self.role in ("number", "shared", "train")

    @property
    def varies_by_design(self) -> bool:
        """Whether boxes of designs may have a range of it: not of what all designs of a problem share."""
        return self.role not in ("shared", "train")

    @property
    def has_range(self) -> bool:
        """Whether its choice is a range."""
        return isinstance(self.choice, StepRange)

    @property
    def is_free(self) -> bool:
        """Whether a search may give it any value of a range."""
        return self.varies_by_design and self.has_range

    @property
    def range_ends(self) -> tuple[float, float]:
        """The least and the largest value of its choice."""
        if isinstance(self.choice, StepRange):
            return self.choice.start, self.choice.stop
        return (float(min(self.choice)), float(max(self.choice))) if self.choice else (nan, nan)

    @property
    def lower_bound(self) -> float:
        """What it may not be below, beside its choice."""
        return -inf if self.field in SIGNED_SIZES or self.range_ends[0] < 0.0 else 0.0

    def magnitude(self, length: float) -> float:
        """What it is of the order of, if the cam is of the order of a length in mm."""
        return {"size": length, "angle": self.shared_angle}.get(self.role) or max(map(abs, self.range_ends))

    @property
    def first_value(self) -> float:
        """The first value of its choice."""
        return self.range_ends[0] if isinstance(self.choice, StepRange) else float(self.listed_values[0])

    @property
    def listed_values(self) -> FloatArray:
        """The values of a list, each once."""
        values = () if self.choice is None or isinstance(self.choice, StepRange) else self.choice
        return np.array([*dict.fromkeys(values)], dtype=float)

    @property
    def grid_count(self) -> int:
        """How many values it has in a grid."""
        if not isinstance(self.choice, StepRange):
            return self.listed_values.size
        low, high = self.range_ends
        return 1 + (floor((high - low) / self.choice.step + 1e-9) if self.choice.step else 0)

    @property
    def grid_values(self) -> FloatArray:
        """Those values, of a range with both its ends: the last step may fall short, and none is beyond."""
        if not isinstance(self.choice, StepRange):
            return self.listed_values
        low, high = self.range_ends
        return np.asarray(np.minimum(low + (self.choice.step or 0.0) * np.arange(self.grid_count), high))

    def values_at_shares(self, shares: FloatArray) -> FloatArray:
        """Values of its range, or of its list, at shares of it from 0 to 1."""
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
        """What boxes have of it: its range, or a listed value; of the cam's own size all between those listed."""
        if isinstance(self.choice, StepRange) or self.field == "size":
            return [self.range_ends]
        return [(value, value) for value in self.listed_values.tolist()]


def variables_of(scene: Scene) -> tuple[Variable, ...]:
    """The sizes of a scene's mechanism, that of the body first, and all numbers of scenes that are no sizes."""
    sizes, numbers, columns = scene.search.sizes, scene.search.numbers, scene.mechanism.size_quantities
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
    """Whether a key is that of a number of the train, which decides the motion."""
    return key.startswith("train.")


def angle_variables(search: Search, segments: Sequence[MotionSegment]) -> tuple[Variable, ...]:
    """The angles of the segments of a turn that ``[search]`` frees."""
    freed = {place: each for place, each in enumerate(segments) if each.segment in search.angles}
    turn = float(sum(each.angle for each in freed.values()))
    return tuple(
        Variable(
            f"{s.key}.angle", "angle", f"angle_{s.segment}", f"angle {i}", "", search.angles[s.segment], i, turn
        )
        for i, s in freed.items()
    )


def variation_mistakes(file: str, variables: Iterable[Variable], who: str) -> list[Mistake]:
    """A mistake for each of some variables that ``[search]`` varies, for those that take what the scene has."""
    found = {each.search_key: ROLE_ADVICE[each.role] for each in variables if each.is_searched}
    why = {key: f"{who} {other}: leave it out of [search]" for key, other in found.items()}
    return [Mistake(file, key, None, what, bare=True) for key, what in why.items()]

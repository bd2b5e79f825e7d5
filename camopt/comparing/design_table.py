"""A table of designs, read column by column: what makes a design, and its front."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from camopt.front.pareto import undominated
from camopt.mechanisms.design import BoolArray
from camopt.numerics import FloatArray
from camopt.problem.variables import variables_of
from camopt.quantities import QUANTITIES
from camopt.scene.design_rows import DERIVED
from camopt.scene.scene import Scene
from camopt.storage.tables import SCENE_KEY, TYPES, table_facts
from camopt.tables.columns import axes_of

LAW_COLUMN, OWN_SCENE, FREE_COLUMN = "law_rise", "scene", "free"
"""Columns: one that every table of designs has; two that a frontier has."""


@dataclass(frozen=True)
class DesignTable:
    """Designs and their quantities, a row each."""

    name: str
    scene: Scene
    layout: pa.Schema
    count: int
    read: Callable[[list[str]], pa.Table]
    """Some of its columns."""

    @property
    def names(self) -> list[str]:
        """Its columns."""
        return list(self.layout.names)

    @property
    def version(self) -> str:
        """The version of camopt that wrote it."""
        return str(table_facts(self.layout)["version"])

    @property
    def units(self) -> dict[str, str]:
        """The units of its columns."""
        return {name: str(unit) for name, unit in table_facts(self.layout)["units"].items()}

    def column(self, name: str) -> pa.Array:
        """One column."""
        return self.read([name]).column(name).combine_chunks()

    def floats(self, name: str) -> FloatArray:
        """One column of numbers; what is null is not a number."""
        return np.asarray(self.column(name).to_numpy(zero_copy_only=False), dtype=float)

    @property
    def key(self) -> list[str]:
        """The columns that make a design: laws, sizes and searched numbers; of a frontier the scene of its own."""
        sizes = [name for name in self.names if name in QUANTITIES and QUANTITIES[name].effect == "sizes"]
        own = [OWN_SCENE] if OWN_SCENE in self.names else []
        return [*(name for name in sizes if name not in DERIVED), *own]

    def fixed(self, name: str) -> float | None:
        """What all designs have of a number that is no column: that of the scene."""
        keys = [each.key for each in variables_of(self.scene) if each.quantity == name]
        return next(iter(self.scene.numbers(keys).values()), None)

    @property
    def objectives(self) -> dict[str, float]:
        """The objectives, and what turns each into a cost; of a frontier its axes."""
        axes = axes_of(self.names)
        found = dict.fromkeys(axes, 1.0) if axes else self.scene.search.objectives
        numbers = {field.name for field in self.layout if pa.types.is_floating(field.type)}
        return found if {*found} <= numbers else {}

    def front(self) -> FloatArray:
        """The costs (points, objectives) of the feasible designs that no other betters."""
        possible = self.possible()
        costs = np.column_stack([sign * self.floats(name)[possible] for name, sign in self.objectives.items()])
        costs = costs[~np.isnan(costs).any(axis=1)]
        return costs[undominated(costs)] if len(costs) else costs

    def possible(self) -> BoolArray:
        """Which designs may be on the front: of a frontier those of free laws, which meet every limit."""
        name = FREE_COLUMN if FREE_COLUMN in self.names else "feasible"
        if name not in self.names:
            return np.ones(self.count, dtype=bool)
        return np.asarray(self.column(name).to_numpy(zero_copy_only=False), dtype=bool)


def type_of(field: pa.Field) -> pa.DataType:
    """The type that a column has in tables of designs: a quantity its own, others theirs."""
    if field.name in QUANTITIES and not pa.types.is_null(field.type):
        return TYPES[QUANTITIES[field.name].kind]
    return pa.string() if pa.types.is_large_string(field.type) else field.type


def is_of_designs(layout: pa.Schema) -> bool:
    """Whether a table is one of designs: it has their laws, and the scene that was searched."""
    return LAW_COLUMN in layout.names and bool((layout.metadata or {}).get(SCENE_KEY))

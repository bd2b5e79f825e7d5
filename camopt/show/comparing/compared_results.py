"""Inputs of a comparison: scenes and tables of designs of a result, by name. Tables are read by columns."""

import os
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import singledispatch
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import BoolArray, FloatArray
from camopt.core.quantities import QUANTITIES
from camopt.core.storage.files import checked_path
from camopt.core.storage.manifest import Manifest, open_checked_result_file, read_manifest, result_paths
from camopt.core.storage.tables import ARROW_TYPES, SCENE_KEY, TableFile, not_a_table_error, table_metadata
from camopt.scene.design_rows import DERIVED_SIZES
from camopt.scene.scene import RESULT_WORDS, Scene, scene_named
from camopt.solve.front.pareto import is_non_dominated
from camopt.solve.front.result import Sweep
from camopt.solve.synthesis.files import KNOWN_FILE, SCENE_FILE, frontier_table
from camopt.solve.synthesis.frontier_result import Frontier
from camopt.solve.tables.designs import OPTIMUM, frontier_axes_among_columns
from camopt.solve.tables.table import read_scene_metadata

LAW_COLUMN, SCENE_COLUMN, FREE_COLUMN = "law_rise", "scene", "free"
"""Columns: the first is in every table of designs, the others in frontiers."""


@dataclass(frozen=True)
class DesignTable:
    """A table of designs and their quantities, one design per row."""

    name: str
    scene: Scene
    layout: pa.Schema
    count: int
    read: Callable[[list[str]], pa.Table]
    """A function that reads columns by name."""

    @property
    def names(self) -> list[str]:
        """Names of the columns."""
        return list(self.layout.names)

    @property
    def metadata(self) -> dict[Any, Any]:
        """Version of camopt that wrote the table, and units of the columns by name."""
        return table_metadata(self.layout)

    def column(self, name: str) -> pa.Array:
        """One column."""
        return self.read([name]).column(name).combine_chunks()

    def floats(self, name: str) -> FloatArray:
        """One column of numbers; null becomes NaN."""
        return np.asarray(self.column(name).to_numpy(zero_copy_only=False), dtype=float)

    @property
    def key_columns(self) -> list[str]:
        """Columns that identify a design: laws, sizes and searched numbers; for a frontier also its scene."""
        sizes = [name for name in self.names if name in QUANTITIES and QUANTITIES[name].effect == "sizes"]
        return [*(name for name in sizes if name not in DERIVED_SIZES), *({SCENE_COLUMN} & {*self.names})]

    @property
    def objectives(self) -> dict[str, float]:
        """Objectives with the sign that makes each a cost; the axes of a frontier."""
        axes = frontier_axes_among_columns(self.names)
        signs = dict.fromkeys(axes, 1.0) if axes else self.scene.search.objectives
        numbers = {field.name for field in self.layout if pa.types.is_floating(field.type)}
        return signs if {*signs} <= numbers else {}

    def front_costs(self) -> FloatArray:
        """Costs of the feasible designs that are not dominated, (points, objectives)."""
        candidates = self.front_candidates()
        costs = np.column_stack([sign * self.floats(name)[candidates] for name, sign in self.objectives.items()])
        costs = costs[~np.isnan(costs).any(axis=1)]
        return costs[is_non_dominated(costs)] if len(costs) else costs

    def front_candidates(self) -> BoolArray:
        """Mask of designs that may be on the front: feasible ones; for a frontier those of free laws."""
        name = FREE_COLUMN if FREE_COLUMN in self.names else "feasible"
        if name not in self.names:
            return np.ones(self.count, dtype=bool)
        return np.asarray(self.column(name).to_numpy(zero_copy_only=False), dtype=bool)


def expected_column_type(field: pa.Field) -> pa.DataType:
    """The type of a column in tables of designs: that of its quantity, else its own."""
    if field.name in QUANTITIES and not pa.types.is_null(field.type):
        return ARROW_TYPES[QUANTITIES[field.name].kind]
    return pa.string() if pa.types.is_large_string(field.type) else field.type


def is_design_table(layout: pa.Schema) -> bool:
    """Whether a table is a table of designs: it has laws and the searched scene."""
    return LAW_COLUMN in layout.names and bool((layout.metadata or {}).get(SCENE_KEY))


SCENE_FILES = ("scene.toml", SCENE_FILE, KNOWN_FILE, OPTIMUM)
"""Scenes in folders that commands write."""
ONE_SCENE, ONE_TABLE = "scene", "table"
"""Names of a scene and a table without a folder."""


@dataclass(frozen=True)
class ComparedResult:
    """One of two results."""

    name: str
    scenes: dict[str, Scene]
    """Scenes, also those inside tables."""
    tables: dict[str, DesignTable]
    files: tuple[Path, ...] = ()
    """Files of the tables."""


@singledispatch
def open_result(what: Any, stack: ExitStack) -> ComparedResult:
    """The scenes and tables of a result; its files stay open until the stack closes."""
    frame = getattr(what, "attrs", None)
    if frame is None:
        allowed = "a path, a scene, a table of camopt, or a result of sweep or frontier"
        raise BadInput([Mistake("camopt", "result", type(what).__name__, allowed)])
    try:
        table = pa.Table.from_pandas(what, preserve_index=False)
        table = table.cast(pa.schema([field.with_type(expected_column_type(field)) for field in table.schema]))
    except (pa.ArrowException, ValueError) as trouble:
        raise not_a_table_error("table", f"this is none: {str(trouble).splitlines()[0]}") from None
    return _one_table_result("table", table.replace_schema_metadata({SCENE_KEY: str(frame.get("scene", ""))}))


def _one_table_result(name: str, table: pa.Table | TableFile, *files: Path) -> ComparedResult:
    design_table = _checked_design_table(name, table)
    return ComparedResult(name, {ONE_SCENE: design_table.scene}, {ONE_TABLE: design_table}, files)


def _checked_design_table(name: str, table: pa.Table | TableFile) -> DesignTable:
    """A table of designs; BadInput if it is another."""
    layout, count, read = (
        (table.layout, table.count, table.read)
        if isinstance(table, TableFile)
        else (table.schema, table.num_rows, table.select)
    )
    if not is_design_table(layout):
        raise not_a_table_error(name, "this is not one of designs, with their laws and the scene that was searched")
    for field in layout:
        if layout.names.count(field.name) > 1:
            raise not_a_table_error(name, f"this has the column {field.name} twice")
        if field.type != expected_column_type(field):
            raise not_a_table_error(name, f"its column {field.name} has not the type {expected_column_type(field)}")
    return DesignTable(name, read_scene_metadata(layout, name), layout, count, read)


@open_result.register
def _open_scene(what: Scene, stack: ExitStack) -> ComparedResult:
    return ComparedResult(what.name, {ONE_SCENE: what}, {})


@open_result.register
def _open_frontier(what: Frontier, stack: ExitStack) -> ComparedResult:
    return _one_table_result(f"frontier of {what.scene.name}", frontier_table(what))


@open_result.register
def _open_sweep(what: Sweep, stack: ExitStack) -> ComparedResult:
    if not what.files:
        raise BadInput(
            [Mistake("camopt", "result", None, "a sweep that wrote its tables: call sweep with out, a folder")]
        )
    return _open_folder(what.files[0].parent, stack)


@open_result.register(str)
@open_result.register(os.PathLike)
def _open_path(what: str | os.PathLike[str], stack: ExitStack) -> ComparedResult:
    path = checked_path(what, "result")
    if path.is_dir():
        return _open_folder(path, stack)
    if path.suffix == ".parquet":
        return _one_table_result(str(path), _open_table(path, stack), path)
    return ComparedResult(str(what), {ONE_SCENE: scene_named(str(what), "result", RESULT_WORDS)}, {})


def _open_table(path: Path, stack: ExitStack, manifest: Manifest | None = None) -> TableFile:
    return TableFile(path, stack.enter_context(open_checked_result_file(path, manifest)))


def _open_folder(folder: Path, stack: ExitStack) -> ComparedResult:
    """The tables of designs and the scenes in a folder, of one run: later ones do not change open files."""
    manifest = read_manifest(folder)
    files = {path.name: _open_table(path, stack, manifest) for path in result_paths(folder, "*.parquet", manifest)}
    tables = {
        name: _checked_design_table(str(folder / name), file)
        for name, file in files.items()
        if is_design_table(file.layout)
    }
    scenes = {name: table.scene for name, table in tables.items()}
    for path in (path for names in SCENE_FILES for path in result_paths(folder, names, manifest)):
        with open_checked_result_file(path, manifest):
            scenes[path.name] = Scene.from_toml(path)
    if not scenes:
        why = "a folder with scenes or tables of designs that a command wrote"
        raise BadInput([Mistake("camopt", "result", str(folder), why)])
    return ComparedResult(str(folder), scenes, tables, tuple(folder / name for name in tables))

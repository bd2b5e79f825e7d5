"""What is compared: the scenes and the tables of designs of a result, by name."""

import os
from contextlib import ExitStack
from dataclasses import dataclass
from functools import singledispatch
from pathlib import Path
from typing import Any

import pyarrow as pa

from camopt.comparing.design_table import DesignTable, is_of_designs, type_of
from camopt.front.result import Sweep
from camopt.mistakes import BadInput, Mistake
from camopt.scene.scene import RESULTS, Scene, scene_named
from camopt.storage.files import checked_path
from camopt.storage.manifest import Manifest, manifest_of, result_paths, whole_result_file
from camopt.storage.tables import SCENE_KEY as SCENE_OF_TABLE
from camopt.storage.tables import TableFile, no_table
from camopt.synthesis.files import KNOWN_FILE, SCENE_FILE, frontier_table
from camopt.synthesis.traded import Frontier
from camopt.tables.designs import OPTIMUM
from camopt.tables.table import scene_in

SCENES = ("scene.toml", SCENE_FILE, KNOWN_FILE, OPTIMUM)
"""The scenes in the folders that commands write."""
ONE_SCENE, ONE_TABLE = "scene", "table"
"""The names of those that are not in a folder."""


@dataclass(frozen=True)
class Side:
    """One of two results."""

    name: str
    scenes: dict[str, Scene]
    """Also those in the tables."""
    tables: dict[str, DesignTable]
    files: tuple[Path, ...] = ()
    """Those of the tables."""


@singledispatch
def side_of(what: Any, stack: ExitStack) -> Side:
    """The scenes and tables of a result; its files are open until the stack is left."""
    frame = getattr(what, "attrs", None)
    if frame is None:
        allowed = "a path, a scene, a table of camopt, or what sweep or frontier gives"
        raise BadInput([Mistake("camopt", "result", type(what).__name__, allowed)])
    try:
        table = pa.Table.from_pandas(what, preserve_index=False)
        table = table.cast(pa.schema([field.with_type(type_of(field)) for field in table.schema]))
    except (pa.ArrowException, ValueError) as trouble:
        raise no_table("table", f"this is none: {str(trouble).splitlines()[0]}") from None
    return _of_a_table("table", table.replace_schema_metadata({SCENE_OF_TABLE: str(frame.get("scene", ""))}))


def _of_a_table(name: str, table: pa.Table) -> Side:
    return _alone(_checked(name, table.schema, table.num_rows, table.select))


def _alone(table: DesignTable, *files: Path) -> Side:
    return Side(table.name, {ONE_SCENE: table.scene}, {ONE_TABLE: table}, files)


def _checked(name: str, layout: pa.Schema, count: int, read: Any) -> DesignTable:
    """A table of designs; BadInput if it is another."""
    if not is_of_designs(layout):
        raise no_table(name, "this is not one of designs, with their laws and the scene that was searched")
    for field in layout:
        if layout.names.count(field.name) > 1:
            raise no_table(name, f"this has the column {field.name} twice")
        if field.type != type_of(field):
            raise no_table(name, f"its column {field.name} has not the type {type_of(field)}")
    return DesignTable(name, scene_in(layout, name), layout, count, read)


def _of_a_file(name: str, file: TableFile) -> DesignTable:
    return _checked(name, file.layout, file.count, file.read)


@side_of.register
def _of_a_scene(what: Scene, stack: ExitStack) -> Side:
    return Side(what.name, {ONE_SCENE: what}, {})


@side_of.register
def _of_a_frontier(what: Frontier, stack: ExitStack) -> Side:
    return _of_a_table(f"frontier of {what.scene.name}", frontier_table(what))


@side_of.register
def _of_a_sweep(what: Sweep, stack: ExitStack) -> Side:
    if not what.files:
        raise BadInput([Mistake("camopt", "result", None, "a sweep that wrote its tables: give it a folder, out")])
    return _of_a_folder(what.files[0].parent, stack)


@side_of.register(str)
@side_of.register(os.PathLike)
def _of_a_path(what: str | os.PathLike[str], stack: ExitStack) -> Side:
    path = checked_path(what, "result")
    if path.is_dir():
        return _of_a_folder(path, stack)
    if path.suffix == ".parquet":
        return _alone(_of_a_file(str(path), _opened(path, stack)), path)
    return Side(str(what), {ONE_SCENE: scene_named(str(what), "result", RESULTS)}, {})


def _opened(path: Path, stack: ExitStack, manifest: Manifest | None = None) -> TableFile:
    return TableFile(path, stack.enter_context(whole_result_file(path, manifest)))


def _of_a_folder(folder: Path, stack: ExitStack) -> Side:
    """The tables of designs and the scenes in a folder, of one run: later ones do not change open files."""
    manifest = manifest_of(folder)
    files = {path.name: _opened(path, stack, manifest) for path in result_paths(folder, "*.parquet", manifest)}
    tables = {
        name: _of_a_file(str(folder / name), file) for name, file in files.items() if is_of_designs(file.layout)
    }
    scenes = {name: table.scene for name, table in tables.items()}
    for path in (path for names in SCENES for path in result_paths(folder, names, manifest)):
        with whole_result_file(path, manifest):
            scenes[path.name] = Scene.from_toml(path)
    if not scenes:
        why = "a folder with scenes or tables of designs that a command wrote"
        raise BadInput([Mistake("camopt", "result", str(folder), why)])
    return Side(str(folder), scenes, tables, tuple(folder / name for name in tables))

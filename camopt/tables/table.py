"""Tables on disk: Parquet with units, symbols, scene and version in its metadata, sealed; pandas at the door."""

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from camopt.mistakes import BadInput
from camopt.scene.scene import Scene
from camopt.storage.sealed import SCENE_KEY, no_table, read_table, table_facts, write_table
from camopt.storage.version import VERSION
from camopt.tables.row_groups import array_of

if TYPE_CHECKING:
    import pandas as pd


class Column(Protocol):
    """Numbers of a table that are no quantities of designs."""

    @property
    def unit(self) -> str: ...

    @property
    def sentence(self) -> str: ...

    @property
    def values(self) -> NDArray[np.float64]: ...


def write_columns(columns: Mapping[str, Column], scene: Scene, path: str | os.PathLike[str]) -> None:
    """Write columns of numbers as a table with their units and the scene, sealed."""
    about = [{"unit": each.unit, "description": each.sentence} for each in columns.values()]
    names = zip(columns, about, strict=True)
    fields = [pa.field(name, pa.float64(), nullable=False, metadata=facts) for name, facts in names]
    layout = pa.schema(fields, metadata={"camopt_version": VERSION, "camopt_scene": scene.to_toml()})
    rows = len(next(iter(columns.values())).values)
    arrays = [array_of(each.values, rows, pa.float64()) for each in columns.values()]
    write_table(pa.table(arrays, schema=layout), path)


def scene_in(layout: pa.Schema, path: str | os.PathLike[str]) -> Scene:
    """The scene in the metadata of a table; BadInput if it has none, or one with mistakes."""
    text = (layout.metadata or {}).get(SCENE_KEY)
    if not text:
        raise no_table(path, "this has no scene in it")
    try:
        return Scene.embedded(text.decode(), os.fsdecode(path))
    except BadInput as bad:
        first = bad.mistakes[0]
        raise no_table(path, f"the scene in this has mistakes, such as {first.key}: {first.allowed}") from None


def load(path: str | os.PathLike[str]) -> "pd.DataFrame":
    """A table that camopt wrote, as a pandas DataFrame.

    ``attrs`` holds ``units``, ``symbols`` and ``descriptions`` (by column), ``scene`` (TOML) and ``version``, and
    that of a Pareto table ``front``: its hypervolume, ideal, nadir and knee, and ``sweep``: how many designs were
    evaluated, and how many were decided in boxes.

    Parameters
    ----------
    path : str or os.PathLike
        A Parquet file that ``sweep``, ``frontier``, ``cam_points`` or another command wrote.

    Returns
    -------
    pandas.DataFrame
        A row for each row of the file.

    Raises
    ------
    BadInput
        If the file is no table of camopt's, or damaged: digests of all its bytes are verified.
    OSError
        If there is no such file, or it cannot be read.

    Examples
    --------
    >>> search = {"base_radius": [55, 60, 65], "offset": [0, 10, 20], "law": ["cycloidal"]}
    >>> scene = camopt.find_scene("roller-1000rpm").replace(search=search)
    >>> swept = camopt.sweep(scene, out="results", keep="all")
    >>> designs = camopt.load("results/designs.parquet")
    >>> len(designs), designs.attrs["units"]["base_radius_mm"]
    (9, 'mm')
    """
    table = read_table(path)
    frame: pd.DataFrame = table.replace_schema_metadata(None).to_pandas()
    frame.attrs = table_facts(table.schema)
    return frame

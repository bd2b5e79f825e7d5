"""Designs of a result: quantities by name, and each design as a scene that every command takes."""

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

from camopt.effects import quantity_of
from camopt.mistakes import BadInput, Mistake, UnknownName, nearest
from camopt.problem.problem import resolve
from camopt.quantities import QUANTITIES, Flag, Word
from camopt.quantities.shown import Drawn
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.design_rows import LAW_KEYS, ROW, has_scene, odd_columns, warn_of_odd_columns
from camopt.scene.scene import Scene
from camopt.scene.written import write_scene
from camopt.tables.columns import columns_of, design_table, joined_laws, with_law
from camopt.tables.layout import Cell, Table
from camopt.tables.result import Result


class Design(Result, Drawn, dict[str, Any]):
    """One design of a result: a mapping from the name of a quantity to its value.

    Parameters
    ----------
    quantities : Mapping or iterable of pairs
        The names and values of a row of a table.
    searched : Scene
        The scene that was searched: the design has its own sizes, laws and angles, and its own values of
        other numbers that were searched; the rest is that of the scene.

    Examples
    --------
    >>> import camopt
    >>> best = camopt.optimise(camopt.find_scene("knife-300rpm-offset")).best
    >>> best.scene.cam.base_radius == best["base_radius_mm"]
    True
    """

    picture = "drawing.figures"

    def __init__(self, quantities: Mapping[str, Any] | Iterable[tuple[str, Any]], searched: Scene) -> None:
        super().__init__(quantities)
        self.searched = searched

    if TYPE_CHECKING:  # overlaps are meant: any other name is that of a number

        @overload
        def __getitem__(self, name: Flag | Literal["proved", "local", "within"], /) -> bool: ...  # type: ignore[overload-overlap]
        @overload
        def __getitem__(self, name: Word | Literal["held_by", "scene"], /) -> str: ...  # type: ignore[overload-overlap]
        @overload
        def __getitem__(self, name: Literal["binding"], /) -> list[str]: ...  # type: ignore[overload-overlap]
        @overload
        def __getitem__(self, name: Literal["angles_deg"], /) -> list[float]: ...  # type: ignore[overload-overlap]
        @overload
        def __getitem__(self, name: Literal["bound"], /) -> float | None: ...  # type: ignore[overload-overlap]
        @overload
        def __getitem__(self, name: str, /) -> float: ...
        def __getitem__(self, name: str, /) -> Any: ...

    def __missing__(self, name: str) -> Any:
        raise UnknownName(f"{name!r} is no quantity of this design; {nearest(str(name), self)}")

    def __repr__(self) -> str:
        sizes = [f", {name} = {self[name]:.6g}" for name in ("base_radius_mm", "mean_radius_mm") if name in self]
        laws = joined_laws(str(self.get("law_rise", "")), str(self.get("law_return", "")))
        return f"<Design of {self.searched.name}: {laws}{''.join(sizes)}, {len(self)} quantities>"

    def table(self) -> Table:
        """The sizes of the design and the quantities that its scene wants, beside the limits."""
        (row,), problem = with_law([self]), resolve(self.searched)
        shown, own = columns_of(problem, [row]), problem.setup.own
        known = {name: quantity_of(name, problem.setup) for name in shown if name in own or name in QUANTITIES}
        about = {name: known[name].sentence if name in known else "" for name in shown}
        return design_table(self.searched.name, problem, row, about)

    def document(self) -> dict[str, Any]:
        """The quantities by name."""
        return dict(self)

    @cached_property
    def scene(self) -> Scene:
        """The scene of this one design: that which was searched, with the design's own sizes, laws and so on."""
        return scene_of_row(self.searched, self)


def miss_sections(miss: Design, title: str = "No feasible design. The nearest miss:") -> Iterator[Table | str]:
    """The design that comes nearest to holding every limit: its sizes, and each limited value beside its limit."""
    problem = resolve(miss.searched)
    (row,) = with_law([miss])
    violated = miss["violated"].split(",")
    broken = {name for limit in problem.limits if limit.name in violated for name in limit.shown}
    about = {name: Cell("broken" if name in broken else "") for name in columns_of(problem, [row])}
    yield ""
    yield design_table(title, problem, row, about)
    yield ""
    if miss["violated"]:
        it = "It, or a cam within its tolerances, breaks" if problem.zones else "It breaks"
        yield f"{it} {', '.join(violated)}."
    elif problem.zones:
        yield "It holds the limits; a cam within its tolerances does not."
    else:
        yield "It is so near its limits that neither side is proved."


class ByLaw(dict[str, Design]):
    """Designs by the names of their laws."""

    def __missing__(self, name: str) -> Design:
        raise UnknownName(f"{name!r} is no law with a feasible design; {nearest(str(name), self)}")


def scene_of(table: Any, row: Any = None, *, scene: SceneSource | None = None) -> Scene:
    """The scene of one row of a table: the scene that was searched, with the sizes, laws and numbers of the row.

    Parameters
    ----------
    table : str, os.PathLike, DataFrame, Series or Mapping
        A Parquet file that ``sweep`` or ``frontier`` wrote, or the DataFrame that ``camopt.load`` or
        ``pandas.read_parquet`` makes of it; rows may have been filtered out. Or one row: a pandas Series, a
        mapping, or a table of one row.
    row : int or other label, optional
        The row's label in the DataFrame: its number in the file, counted from 0, or its law in the rows of an
        ``Optimum``.
    scene : Scene, str or os.PathLike, optional
        The scene that was searched, where the table has lost its ``attrs``, as in a merge with another one.
        One warning names columns that are no quantities of camopt.

    Returns
    -------
    Scene
        For ``evaluate``, ``plot``, ``certify`` and the others; limits and ``[search]`` are those of the table.

    Raises
    ------
    BadInput
        If the table has no such row, or no scene, or the scene may not have what stands in the row.
    OSError
        If the file cannot be read.

    Examples
    --------
    >>> search = {"base_radius": [55, 60, 65], "offset": [0, 10, 20], "law": ["cycloidal"]}
    >>> scene = camopt.find_scene("roller-1000rpm").replace(search=search)
    >>> swept = camopt.sweep(scene, out="results", keep="all")
    >>> designs = camopt.load("results/designs.parquet")
    >>> smallest = designs.base_radius_mm.idxmin()
    >>> camopt.scene_of(designs, smallest).cam.base_radius
    55.0
    >>> camopt.scene_of(dict(designs.loc[smallest]), scene=scene).cam.base_radius
    55.0
    """
    from camopt.tables.table import load, row_of

    if isinstance(row, Scene):
        raise BadInput([Mistake("camopt", ROW, None, "a label of a row; give the scene as scene=")])
    name, given = (os.fspath(table), load(table)) if isinstance(table, (str, os.PathLike)) else ("table", table)
    values = row_of(given, row, name)
    text = getattr(given, "attrs", {}).get("scene")
    searched = None if scene is None else scene_from(scene)
    if searched is None and text:
        searched = Scene.embedded(text, name)
    if searched is None and not has_scene(values):
        lost = "missing: the table has lost it, as in a merge, or camopt did not write it; give it as scene="
        if isinstance(table, Result) and hasattr(table, "scene"):
            lost = f"missing: the scene of this {type(table).__name__} is its .scene"
        raise BadInput([Mistake("camopt", "scene", None, lost, bare=True)])
    found = scene_of_row(searched, values)
    if searched and not has_scene(values) and (odd := odd_columns(searched, values)):
        warn_of_odd_columns(odd, (*searched.row_columns.values(), *LAW_KEYS), values, name)
    return found


def scene_of_row(searched: Scene | None, row: Mapping[str, Any]) -> Scene:
    """The scene of a row: a frontier's has one of its own (TOML), others are designs of the scene searched."""
    if searched is None or has_scene(row):
        return Scene.embedded(row["scene"], searched.file if searched else "table")
    return searched.with_row(row)


PARETO, DESIGNS = "pareto.parquet", "designs.parquet"
"""The files of a sweep: of its front, and of all designs that it keeps."""
OPTIMUM = "optimum-*.toml"
"""The files of ``write_scenes``."""
NAME_BYTES = 200  # bytes: a file system takes 255


def write_scenes(designs: Mapping[str, Design], folder: str | os.PathLike[str]) -> list[Path]:
    """Write the scene of each design as a TOML file into a folder; the files.

    A file is called by the laws of its design, or by the scene where all segments are moves, which name no law.
    """
    files: list[Path] = []
    for laws, design in designs.items():
        name = _file_name(laws) or _file_name(design.scene.name) or "moves"
        names = chain([name], (f"{name}~{k}" for k in count(2)))
        tried = (Path(folder) / OPTIMUM.replace("*", each) for each in names)
        files.append(next(path for path in tried if path not in files))
        write_scene(files[-1], design.scene)
    return files


def _file_name(text: str) -> str:
    """The part of a text that any file system takes in a name."""
    plain = re.sub(r"[^\w.+-]+", "-", text).strip("-")
    return plain.encode()[:NAME_BYTES].decode(errors="ignore")

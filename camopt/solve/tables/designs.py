"""Designs of a result: their quantities by name, tables of them, and each as a scene that every command takes.

A table has a row for each design, or one down the page: the quantities that it shows, and the limits beside them.
"""

import os
import re
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

from camopt.core.mistakes import BadInput, Mistake, UnknownName, suggest_names
from camopt.core.quantities import QUANTITIES, Flag, Word, in_column_order
from camopt.core.quantities.display import Drawable
from camopt.core.quantities.unit_systems import shown_unit, to_shown_unit
from camopt.model.effects import find_quantity
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.design_rows import (
    DERIVED_SIZES,
    LAW_NAME_COLUMNS,
    ROW_WORD,
    has_scene,
    unknown_columns,
    warn_of_unknown_columns,
)
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.scene import Scene
from camopt.scene.scene_file import write_scene
from camopt.solve.tables.cells import name_in_shown_unit, quantity_text, unit_of_column
from camopt.solve.tables.result import ABOUT, VALUE, Cell, Result, Table, table_of

TableRow = Mapping[str, Any]
WHOLE_TURN, STROKE_ANGLES = (
    "pressure_angle_max_deg",
    ("pressure_angle_max_rise_deg", "pressure_angle_max_return_deg"),
)
LAW_COLUMNS = ("law_rise", "law_return")


def bounds_shown(problem: Problem) -> dict[str, str]:
    """The limit on each quantity, as "≤ 30"; of several on one quantity, the first."""
    found: dict[str, str] = {}
    for limit in problem.limits:
        for name in limit.shown_quantities:
            bound = to_shown_unit(limit.bound, find_quantity(name, limit.setup).unit)
            found.setdefault(name, f"{limit.relation} {bound:g}".replace("-", "−"))
    on_parts = {found.get(name) for name in STROKE_ANGLES}
    if len(on_parts) == 1 and None not in on_parts:
        found[WHOLE_TURN] = found[STROKE_ANGLES[0]]
    return found


def own_units(problem: Problem) -> dict[str, str]:
    """The units of the scene's own quantities, by name."""
    return {name: each.unit for name, each in problem.setup.own_quantities.items()}


def columns_of(problem: Problem, rows: Iterable[TableRow], asked: Iterable[str] = ()) -> list[str]:
    """Sizes, then wanted quantities: objectives, limited quantities and outputs; none that is 0 throughout.

    A law on rises and returns alike is one column, ``law``; so is a pressure angle that is asked over the turn.
    """
    rows, bounds = list(rows), bounds_shown(problem)
    outputs = (
        problem.evaluated_quantities - problem.required_quantities
        if problem.outputs
        else problem.setup.own_quantities.keys()
    )
    asked = [*asked, *in_column_order(outputs)]
    twice = {WHOLE_TURN} - {*asked} or {*STROKE_ANGLES} - {*asked}
    named = dict.fromkeys([*asked, *(name for name in bounds if WHOLE_TURN not in bounds or name not in twice)])
    searched = [each.name for each in problem.search_space.sizes]
    shown = [name for name in named if name in rows[0] and not is_zero_column(searched, name, rows)]
    sizes = sizes_shown(searched, rows)
    return [*sizes, *(name for name in shown if name not in sizes)]


def sizes_shown(searched: Container[str], rows: Iterable[TableRow]) -> list[str]:
    """The sizes worth a column: no law twice, no sum or difference of others, none that is 0 and not searched.

    ``searched`` are the keys of the sizes in ``[search]``.
    """
    rows = list(rows)
    sizes = [name for name in rows[0] if name in QUANTITIES and QUANTITIES[name].effect == "sizes"]
    kept = [name for name in sizes if name not in DERIVED_SIZES and not is_zero_column(searched, name, rows)]
    return [*laws_shown(rows), *(name for name in kept if name not in LAW_COLUMNS)]


def laws_shown(rows: Iterable[TableRow]) -> list[str]:
    """The columns of laws: one if rises and returns have the same, none if the motion is made of moves only."""
    rows = list(rows)
    if any(row["law_rise"] != row["law_return"] for row in rows):
        return list(LAW_COLUMNS)
    return ["law"] if any(row["law_rise"] for row in rows) else []


def joined_laws(rise: str, fall: str) -> str:
    """The laws of rises and returns as one name: once if they are the same, empty if there are only moves."""
    return " / ".join(filter(None, dict.fromkeys((rise, fall))))


def with_law(rows: Iterable[TableRow]) -> list[dict[str, Any]]:
    """Rows with the column ``law``."""
    return [{"law": row["law_rise"], **row} for row in rows]


def axes_of(names: Sequence[str]) -> list[str]:
    """The columns of a frontier that are its axes; none of another table."""
    if not {"free", "bound"} <= {*names}:
        return []
    return list(names[names.index("free") + 1 : names.index("bound")])


def is_zero_column(searched: Container[str], name: str, rows: Iterable[TableRow]) -> bool:
    """Whether a quantity is 0, or an empty name, in all designs: a roller radius of a knife, a law of moves.

    ``searched`` are the keys of the sizes in ``[search]``.
    """
    if any(row[name] not in (0.0, "") for row in rows):
        return False
    effect = QUANTITIES[name].effect if name in QUANTITIES else ""
    return effect == "pressure" or (effect == "sizes" and name.removesuffix("_mm") not in searched)


def designs_table(
    title: str, problem: Problem, rows: Iterable[TableRow], last: Iterable[str] = (), asked: Iterable[str] = ()
) -> Table:
    """A row for each design: sizes, wanted quantities, and further columns; lists become texts."""
    shown = [{name: _list_text(value) for name, value in row.items()} for row in rows]
    names = [*columns_of(problem, shown, asked), *last]
    return table_of(title, shown, names, bounds_shown(problem), own_units(problem))


def _list_text(value: Any) -> Any:
    return ", ".join(value) if isinstance(value, list) and all(isinstance(each, str) for each in value) else value


def design_table(title: str, problem: Problem, design: TableRow, about: Mapping[str, str | Cell]) -> Table:
    """One design down the page: name, value, unit and meaning of each quantity, and limits if there are any.

    A narrow terminal leaves meanings out, but not those that are cells of words.
    """
    bounds, units = bounds_shown(problem), own_units(problem)
    rows: list[list[str | Cell]] = []
    for name, text in about.items():
        unit = unit_of_column(name, units.get(name))
        limit = [bounds.get(name, "")] if bounds else []
        value = quantity_text(name, design[name], unit).replace(",", ", ")
        rows.append([name_in_shown_unit(name, unit), value, shown_unit(unit), *limit, text])
    heads = [Cell(""), Cell("", VALUE), Cell(""), *([Cell("")] if bounds else []), Cell("", ABOUT)]
    return Table.from_texts(title, heads, rows)


class Design(Result, Drawable, dict[str, Any]):
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
        raise UnknownName(f"{name!r} is no quantity of this design; {suggest_names(str(name), self)}")

    def __repr__(self) -> str:
        sizes = [f", {name} = {self[name]:.6g}" for name in ("base_radius_mm", "mean_radius_mm") if name in self]
        laws = joined_laws(str(self.get("law_rise", "")), str(self.get("law_return", "")))
        return f"<Design of {self.searched.name}: {laws}{''.join(sizes)}, {len(self)} quantities>"

    def table(self) -> Table:
        """The sizes of the design and the quantities that its scene wants, beside the limits."""
        (row,), problem = with_law([self]), resolve(self.searched)
        shown, own = columns_of(problem, [row]), problem.setup.own_quantities
        known = {name: find_quantity(name, problem.setup) for name in shown if name in own or name in QUANTITIES}
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
    broken = {name for limit in problem.limits if limit.name in violated for name in limit.shown_quantities}
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


class DesignsByLaw(dict[str, Design]):
    """Designs by the names of their laws."""

    def __missing__(self, name: str) -> Design:
        raise UnknownName(f"{name!r} is no law with a feasible design; {suggest_names(str(name), self)}")


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
    from camopt.solve.tables.table import load, row_of

    if isinstance(row, Scene):
        raise BadInput([Mistake("camopt", ROW_WORD, None, "a label of a row; give the scene as scene=")])
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
    if searched and not has_scene(values) and (odd := unknown_columns(searched, values)):
        warn_of_unknown_columns(odd, (*searched.row_columns.values(), *LAW_NAME_COLUMNS), values, name)
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

"""Designs of a result: their quantities, tables of them, and the scene of each, which every command takes.

A table has a row for each design, or one design down the page, with the limits beside the quantities.
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
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.effects import find_quantity
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.design_rows import (
    DERIVED_SIZES,
    LAW_NAME_COLUMNS,
    ROW_WORD,
    has_embedded_scene,
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


def limit_texts_by_quantity(problem: Problem) -> dict[str, str]:
    """Text of the limit on each quantity, such as "≤ 30"; the first of several limits on one quantity."""
    bounds: dict[str, str] = {}
    for limit in problem.limits:
        for name in limit.shown_quantities:
            bound = to_shown_unit(limit.bound, find_quantity(name, limit.setup).unit)
            bounds.setdefault(name, f"{limit.relation} {bound:g}".replace("-", "−"))
    by_stroke = {bounds.get(name) for name in STROKE_ANGLES}
    if len(by_stroke) == 1 and None not in by_stroke:
        bounds[WHOLE_TURN] = bounds[STROKE_ANGLES[0]]
    return bounds


def own_quantity_units(problem: Problem) -> dict[str, str]:
    """Units of the scene's own quantities, by name."""
    return {name: quantity.unit for name, quantity in problem.setup.own_quantities.items()}


def design_table_columns(
    problem: Problem, rows: Iterable[TableRow], requested_columns: Iterable[str] = ()
) -> list[str]:
    """Columns of a table: sizes, then objectives, limited quantities and outputs; without columns of zeros.

    Equal laws of rises and returns share the column ``law``; so do equal limits on their pressure angles.
    """
    rows, bounds = list(rows), limit_texts_by_quantity(problem)
    outputs = (
        problem.evaluated_quantities - problem.required_quantities
        if problem.outputs
        else problem.setup.own_quantities.keys()
    )
    requested_columns = [*requested_columns, *in_column_order(outputs)]
    redundant = {WHOLE_TURN} - {*requested_columns} or {*STROKE_ANGLES} - {*requested_columns}
    named = dict.fromkeys(
        [*requested_columns, *(name for name in bounds if WHOLE_TURN not in bounds or name not in redundant)]
    )
    searched = [size.name for size in problem.search_space.sizes]
    shown = [name for name in named if name in rows[0] and not is_unsearched_zero_column(searched, name, rows)]
    sizes = shown_size_columns(searched, rows)
    return [*sizes, *(name for name in shown if name not in sizes)]


def shown_size_columns(searched_keys: Container[str], rows: Iterable[TableRow]) -> list[str]:
    """Sizes that have a column: equal laws once, no sums of other sizes, and no zeros that were not searched.

    ``searched_keys`` has the keys of the sizes in ``[search]``.
    """
    rows = list(rows)
    sizes = [name for name in rows[0] if name in QUANTITIES and QUANTITIES[name].effect == "sizes"]
    shown = [
        name
        for name in sizes
        if name not in DERIVED_SIZES and not is_unsearched_zero_column(searched_keys, name, rows)
    ]
    return [*shown_law_columns(rows), *(name for name in shown if name not in LAW_COLUMNS)]


def shown_law_columns(rows: Iterable[TableRow]) -> list[str]:
    """Columns of laws: one if rises and returns have equal laws, none if the motion has only moves."""
    rows = list(rows)
    if any(row["law_rise"] != row["law_return"] for row in rows):
        return list(LAW_COLUMNS)
    return ["law"] if any(row["law_rise"] for row in rows) else []


def joined_laws(rise: str, fall: str) -> str:
    """The laws of rises and returns as one name; equal laws once, empty if there are only moves."""
    return " / ".join(filter(None, dict.fromkeys((rise, fall))))


def with_rise_law_as_law_column(rows: Iterable[TableRow]) -> list[dict[str, Any]]:
    """Add the column ``law`` to rows."""
    return [{"law": row["law_rise"], **row} for row in rows]


def frontier_axes_among_columns(column_names: Sequence[str]) -> list[str]:
    """Columns of a frontier that are its axes; none for another table."""
    if not {"free", "bound"} <= {*column_names}:
        return []
    return list(column_names[column_names.index("free") + 1 : column_names.index("bound")])


def is_unsearched_zero_column(searched_keys: Container[str], name: str, rows: Iterable[TableRow]) -> bool:
    """Whether a column is 0 or empty in all designs, as the roller radius of a knife edge, and was not searched.

    ``searched_keys`` has the keys of the sizes in ``[search]``.
    """
    if any(row[name] not in (0.0, "") for row in rows):
        return False
    effect = QUANTITIES[name].effect if name in QUANTITIES else ""
    return effect == "pressure" or (effect == "sizes" and name.removesuffix("_mm") not in searched_keys)


def designs_table(
    title: str,
    problem: Problem,
    rows: Iterable[TableRow],
    last_columns: Iterable[str] = (),
    requested_columns: Iterable[str] = (),
) -> Table:
    """A table with a row for each design: sizes, wanted quantities and the columns ``last_columns``.

    Lists become texts.
    """
    shown = [{name: _join_list_of_texts(value) for name, value in row.items()} for row in rows]
    names = [*design_table_columns(problem, shown, requested_columns), *last_columns]
    return table_of(title, shown, names, limit_texts_by_quantity(problem), own_quantity_units(problem))


def _join_list_of_texts(value: Any) -> Any:
    return ", ".join(value) if isinstance(value, list) and all(isinstance(each, str) for each in value) else value


def design_table(title: str, problem: Problem, design: TableRow, meanings: Mapping[str, str | Cell]) -> Table:
    """A table of one design down the page: name, value, unit, limit and meaning of each quantity.

    A narrow terminal omits meanings that are sentences, but not those that are cells.
    """
    bounds, units = limit_texts_by_quantity(problem), own_quantity_units(problem)
    rows: list[list[str | Cell]] = []
    for name, text in meanings.items():
        unit = unit_of_column(name, units.get(name))
        limit = [bounds.get(name, "")] if bounds else []
        value = quantity_text(name, design[name], unit).replace(",", ", ")
        rows.append([name_in_shown_unit(name, unit), value, unit_in_shown_system(unit), *limit, text])
    heads = [Cell(""), Cell("", VALUE), Cell(""), *([Cell("")] if bounds else []), Cell("", ABOUT)]
    return Table.from_texts(title, heads, rows)


class Design(Result, Drawable, dict[str, Any]):
    """One design of a result: a mapping from quantity names to values.

    Parameters
    ----------
    quantities : Mapping or iterable of pairs
        Names and values in a row of a table.
    searched : Scene
        The scene that was searched. The design has its own sizes, laws and angles, and its own values of other
        searched numbers; everything else is that of the scene.

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

    if TYPE_CHECKING:  # the overlaps are intended: any other name is a number's

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
        raise UnknownName(f"{name!r} is not a quantity of this design; {suggest_names(str(name), self)}")

    def __repr__(self) -> str:
        sizes = [f", {name} = {self[name]:.6g}" for name in ("base_radius_mm", "mean_radius_mm") if name in self]
        laws = joined_laws(str(self.get("law_rise", "")), str(self.get("law_return", "")))
        return f"<Design of {self.searched.name}: {laws}{''.join(sizes)}, {len(self)} quantities>"

    def table(self) -> Table:
        """A table of the design's sizes and the quantities of its scene, with the limits."""
        (row,), problem = with_rise_law_as_law_column([self]), resolve(self.searched)
        shown, own = design_table_columns(problem, [row]), problem.setup.own_quantities
        known = {name: find_quantity(name, problem.setup) for name in shown if name in own or name in QUANTITIES}
        about = {name: known[name].sentence if name in known else "" for name in shown}
        return design_table(self.searched.name, problem, row, about)

    def values_for_json(self) -> dict[str, Any]:
        """Quantities by name."""
        return dict(self)

    @cached_property
    def scene(self) -> Scene:
        """Scene of this design: the searched scene with the design's own sizes, laws and other numbers."""
        return scene_of_row(self.searched, self)


def nearest_miss_sections(
    miss: Design, title: str = "No feasible design. The nearest miss:"
) -> Iterator[Table | str]:
    """Sections on the design that misses the limits by the least: its sizes, and limited values with limits."""
    problem = resolve(miss.searched)
    (row,) = with_rise_law_as_law_column([miss])
    violated = miss["violated"].split(",")
    broken = {name for limit in problem.limits if limit.name in violated for name in limit.shown_quantities}
    about = {name: Cell("broken" if name in broken else "") for name in design_table_columns(problem, [row])}
    yield ""
    yield design_table(title, problem, row, about)
    yield ""
    if miss["violated"]:
        subject = "The design, or a cam within its tolerances, breaks" if problem.zones else "The design breaks"
        yield f"{subject} {', '.join(violated)}."
    elif problem.zones:
        yield "The design holds the limits, but a cam within its tolerances does not."
    else:
        yield "The design is so near its limits that neither side is proved."


class DesignsByLaw(dict[str, Design]):
    """Designs by the names of their laws."""

    def __missing__(self, name: str) -> Design:
        raise UnknownName(f"{name!r} is not a law with a feasible design; {suggest_names(str(name), self)}")


def scene_of(table: Any, row: Any = None, *, scene: SceneSource | None = None) -> Scene:
    """The scene of one row of a table: the searched scene with the sizes, laws and numbers of the row.

    Parameters
    ----------
    table : str, os.PathLike, DataFrame, Series or Mapping
        A Parquet file that ``sweep`` or ``frontier`` wrote, or its DataFrame from ``camopt.load`` or
        ``pandas.read_parquet``, which may be filtered. Or one row: a pandas Series, a mapping, or a table of one
        row.
    row : int or other label, optional
        Label of the row in the DataFrame: its number in the file, counted from 0, or its law in the rows of an
        ``Optimum``.
    scene : Scene, str or os.PathLike, optional
        The searched scene, if the table has lost its ``attrs``, as after a merge. A warning names columns that are
        no quantities of camopt.

    Returns
    -------
    Scene
        For ``evaluate``, ``plot``, ``certify`` and the others; limits and ``[search]`` are those of the table.

    Raises
    ------
    BadInput
        If the table has no such row or no scene, or the scene does not allow the values in the row.
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
    from camopt.solve.tables.table import load, values_of_table_row

    if isinstance(row, Scene):
        raise BadInput([Mistake("camopt", ROW_WORD, None, "a label of a row; give the scene as scene=")])
    name, frame = (os.fspath(table), load(table)) if isinstance(table, (str, os.PathLike)) else ("table", table)
    values = values_of_table_row(frame, row, name)
    text = getattr(frame, "attrs", {}).get("scene")
    searched = None if scene is None else scene_from(scene)
    if searched is None and text:
        searched = Scene.embedded(text, name)
    if searched is None and not has_embedded_scene(values):
        why = "missing: the table has lost it, as after a merge, or camopt did not write it; give it as scene="
        if isinstance(table, Result) and hasattr(table, "scene"):
            why = f"missing: the scene of this {type(table).__name__} is its .scene"
        raise BadInput([Mistake("camopt", "scene", None, why, bare=True)])
    design_scene = scene_of_row(searched, values)
    if searched and not has_embedded_scene(values) and (unknown := unknown_columns(searched, values)):
        warn_of_unknown_columns(unknown, (*searched.row_columns.values(), *LAW_NAME_COLUMNS), values, name)
    return design_scene


def scene_of_row(searched: Scene | None, row: Mapping[str, Any]) -> Scene:
    """The scene of a row: its own (TOML) in a frontier, else the searched scene with the row's values."""
    if searched is None or has_embedded_scene(row):
        return Scene.embedded(row["scene"], searched.file if searched else "table")
    return searched.with_row(row)


PARETO, DESIGNS = "pareto.parquet", "designs.parquet"
"""Files of a sweep: its front, and all designs that it keeps."""
OPTIMUM = "optimum-*.toml"
"""Files of ``write_scenes``."""
NAME_BYTES = 200  # most bytes of a name; file systems take 255


def write_scenes(designs: Mapping[str, Design], folder: str | os.PathLike[str]) -> list[Path]:
    """Write the scene of each design as a TOML file into a folder; return the files.

    A file is named after the laws of its design, or after the scene if all segments are moves, which have no law.
    """
    files: list[Path] = []
    for laws, design in designs.items():
        name = _file_name(laws) or _file_name(design.scene.name) or "moves"
        names = chain([name], (f"{name}~{k}" for k in count(2)))
        paths = (Path(folder) / OPTIMUM.replace("*", name) for name in names)
        files.append(next(path for path in paths if path not in files))
        write_scene(files[-1], design.scene)
    return files


def _file_name(text: str) -> str:
    """A text without the characters that some file systems refuse in a name."""
    return re.sub(r"[^\w.+-]+", "-", text).strip("-").encode()[:NAME_BYTES].decode(errors="ignore")

"""``compare``: two results side by side, by designs, fronts, settings, and quantities of two cams."""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from math import isinf, isnan
from typing import Any

import numpy as np
import pyarrow as pa

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import IndexArray
from camopt.core.quantities.display import Drawable
from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.core.storage.files import check_writable, checked_suffix, expand_user_path
from camopt.core.storage.tables import not_a_table_error
from camopt.scene.arguments import allow_positional_options
from camopt.scene.problem.problem import missing_variable_mistakes, resolve
from camopt.scene.scene import Scene
from camopt.show.comparing.compared_results import ComparedResult, DesignTable, open_result
from camopt.show.comparing.designs import (
    CSV,
    PARQUET,
    Change,
    Matching,
    changed_quantities_with_masks,
    match_designs,
    write_differences,
)
from camopt.show.comparing.fronts import Fronts, FrontSide, compare_fronts
from camopt.show.comparing.scenes import (
    Difference,
    ValuePair,
    differing_cam_quantities,
    differing_settings_in_shown_units,
    scene_differences,
)
from camopt.solve.tables.cells import number_text, shown_column_name, unit_of_column
from camopt.solve.tables.designs import (
    DESIGNS,
    LAW_COLUMNS,
    PARETO,
    shown_law_columns,
    with_rise_law_as_law_column,
)
from camopt.solve.tables.result import Result, Table, table_of

VALUE_CHARACTERS = 60  # shown characters of a value
NOT_SET = "—"
SHOWN_DESIGNS = 5
"""Number of designs shown of those only in A, and of those only in B."""


@dataclass(frozen=True, eq=False)
class TableComparison:
    """The differences of two tables of designs."""

    designs: tuple[int, int]
    """Numbers of designs in A and B."""
    went: IndexArray
    """Rows of A, from 0, with designs that are only in A."""
    came: IndexArray
    """Rows of B with designs that are only in B."""
    changed: IndexArray
    """Rows (A, B) of designs in both that differ in a quantity, (designs, 2)."""
    beyond: int
    """Number of changed designs that differ by more than the relative errors of both scenes."""
    quantities: dict[str, Change]
    """Changed quantities by name."""
    columns_in_a: tuple[str, ...]
    """Columns only in A."""
    columns_in_b: tuple[str, ...]
    """Columns only in B."""
    objectives: tuple[dict[str, str], dict[str, str]]
    """Objectives of A and B: minimise or maximise, by name."""
    units: dict[str, str]
    """Units of the objectives of A."""
    fronts: Fronts | None
    """The fronts; None if the objectives differ, or another table of the folder has the front."""
    first: dict[str, list[dict[str, Any]]]
    """Sizes and objectives of a few designs only in A or B, the best feasible ones by the first objective."""

    @property
    def has_same_designs(self) -> bool:
        """Whether both tables have the same designs with the same quantities, in any order."""
        return not any((self.went.size, self.came.size, len(self.changed), self.columns_in_a, self.columns_in_b))

    def to_dict(self) -> dict[str, Any]:
        """Counts and quantities as plain values."""
        return {
            "same": self.has_same_designs,
            "designs": {"a": self.designs[0], "b": self.designs[1]},
            "went": self.went.size,
            "came": self.came.size,
            "changed": len(self.changed),
            "beyond_accuracy": self.beyond,
            "quantities": {name: _json_record(asdict(each)) for name, each in self.quantities.items()},
            "columns_only_in": {"a": list(self.columns_in_a), "b": list(self.columns_in_b)},
            "objectives": dict(zip("ab", self.objectives, strict=True)),
            "fronts": self.fronts and self.fronts.to_dict(),
            "first": {kind: [_json_record(row) for row in rows] for kind, rows in self.first.items()},
        }


@dataclass(frozen=True, eq=False)
class Comparison(Result, Drawable):
    """Two results side by side.

    Attributes
    ----------
    a : str
        Name of A.
    b : str
        Name of B.
    settings : dict
        Keys in which scenes differ, with the values in A and B (None if not set), by names of scenes and of tables
        with a scene. Equal scenes are left out.
    scenes : dict
        The scenes that differ, (A, B), by the same names.
    cams : dict
        Quantities that differ by more than the relative errors of both, by the same names, for scenes with all
        sizes that are not the scene of a table. Each has ``a``, ``b`` and ``difference``, b less a (None if one is
        missing, infinite or not a number).
    by_table : dict
        By name of the table: ``went`` and ``came``, the rows of designs only in A and only in B; ``changed``, pairs
        of rows; ``quantities``, the changes of each quantity; ``fronts``; ``to_dict()``.
    only_in_a : tuple of str
        Scenes and tables only in A.
    only_in_b : tuple of str
        Scenes and tables only in B.
    versions : tuple of str
        Versions of camopt that wrote the tables of A, and of B.

    Examples
    --------
    >>> search = {"base_radius": [110, 120, 130], "offset": [20], "law": ["cycloidal"]}
    >>> scene = camopt.find_scene("roller-1000rpm").replace(search=search)
    >>> before = camopt.sweep(scene, out="before")
    >>> after = camopt.sweep(scene.replace(**{"search.base_radius": [120, 130, 140]}), out="after")
    >>> found = camopt.compare(before, after)
    >>> found.settings["designs.parquet, pareto.parquet, scene.toml"]
    {'search.base_radius': ([110.0, 120.0, 130.0], [120.0, 130.0, 140.0])}
    """

    picture = "comparing.picture"
    a: str
    b: str
    settings: dict[str, dict[str, Difference]]
    scenes: dict[str, tuple[Scene, Scene]]
    cams: dict[str, dict[str, ValuePair]]
    by_table: dict[str, TableComparison]
    only_in_a: tuple[str, ...]
    only_in_b: tuple[str, ...]
    versions: tuple[str, str]

    def __repr__(self) -> str:
        words = "the same" if self.same else "not the same"
        return f"<Comparison: {self.a} and {self.b} are {words}>"

    @property
    def same(self) -> bool:
        """Whether settings and designs are the same; versions of camopt may differ."""
        differ = (self.settings, self.only_in_a, self.only_in_b)
        return not any(differ) and all(each.has_same_designs for each in self.by_table.values())

    def sections(self) -> Iterator[Table | str]:
        """Texts and tables of the differences, or a line that there are none."""
        yield f"A: {self.a}"
        yield f"B: {self.b}"
        if self.same:
            yield (
                "A and B are the same: designs, quantities and settings."
                if self.by_table
                else "A and B are the same."
            )
        if self.by_table and self.versions[0] != self.versions[1]:
            yield f"Written by camopt {self.versions[0]} (A) and {self.versions[1]} (B)."
        for name, only in (("A", self.only_in_a), ("B", self.only_in_b)):
            if only:
                yield f"Only in {name}: {', '.join(only)}"
        for names, pair in self.scenes.items():
            rows = [
                {"key": key, "A": _short_value_text(a), "B": _short_value_text(b), "unit": unit}
                for key, (a, b, unit) in differing_settings_in_shown_units(*pair).items()
            ]
            yield ""
            yield table_of(f"Settings that differ ({names})", rows, ["key", "A", "B", "unit"])
        for names, cam in self.cams.items():
            yield ""
            yield from _quantity_sections(names, cam)
        for name, table in self.by_table.items():
            yield ""
            yield from _design_sections(name, table)
            yield from _front_sections(table)

    def values_for_json(self) -> dict[str, Any]:
        """The differences by kind, as plain values."""
        settings = {
            names: {key: dict(zip("ab", pair, strict=True)) for key, pair in keys.items()}
            for names, keys in self.settings.items()
        }
        return {
            "a": self.a,
            "b": self.b,
            "same": self.same,
            "versions": dict(zip("ab", self.versions, strict=True)),
            "settings": settings,
            "cams": {
                names: {n: _json_record(v._asdict()) for n, v in each.items()} for names, each in self.cams.items()
            },
            "only_in": {"a": list(self.only_in_a), "b": list(self.only_in_b)},
            "tables": {name: each.to_dict() for name, each in self.by_table.items()},
        }


def _json_record(record: Mapping[str, Any]) -> dict[str, Any]:
    """A record with None in place of infinite numbers and NaN."""
    odd = {n for n, value in record.items() if isinstance(value, float) and (isinf(value) or isnan(value))}
    return {name: None if name in odd else value for name, value in record.items()}


@allow_positional_options
def compare(a: Any, b: Any, *, out: str | os.PathLike[str] | None = None) -> Comparison:
    """Compare two results: designs, Pareto fronts, settings, and the quantities of two cams.

    Parameters
    ----------
    a : str, os.PathLike, Scene, Sweep, Frontier or pandas.DataFrame
        A folder that a command wrote, a table of designs (a Parquet file, or its DataFrame from ``camopt.load``), a
        scene, or a result of ``sweep`` (with ``out``) or ``frontier``.
    b : str, os.PathLike, Scene, Sweep, Frontier or pandas.DataFrame
        The other result: a folder for a folder, whose scenes and tables of the same names are compared; a table or
        scene for a table or scene.
    out : str or os.PathLike, optional
        A table (.parquet or .csv) of the designs that differ. Its column ``change`` is "went" (only in A), "came"
        (only in B), or "before" and "after" for a changed design; ``table`` and ``row`` are the source of the row.

    Returns
    -------
    Comparison
        The differences. Two designs are the same if their laws, sizes and other searched numbers are exactly equal;
        for a frontier, also their motions. A design changed if another quantity differs at all. It changed beyond
        the accuracy if the relative difference exceeds the sum of ``[accuracy] relative_error`` of both scenes.

    Raises
    ------
    BadInput
        If one is not a result or is damaged, or if both have nothing in common.
    OSError
        If a file cannot be read or written.

    References
    ----------
    E. Zitzler, L. Thiele, M. Laumanns, C. M. Fonseca, V. Grunert da Fonseca, Performance assessment of
    multiobjective optimizers, IEEE Trans. Evol. Comput. 7 (2003).
    H. Ishibuchi, H. Masuda, Y. Tanigaki, Y. Nojima, Modified distance calculation in generational distance and
    inverted generational distance, EMO 2015.

    Examples
    --------
    >>> scene = camopt.find_scene("two-pauses")
    >>> found = camopt.compare(scene, scene.replace(**{"cam.base_radius": 60}))
    >>> found.settings
    {'scene': {'cam.base_radius': (25.0, 60.0)}}
    >>> round(found.cams["scene"]["pressure_angle_max_deg"].difference, 3)
    -12.659
    """
    place = None
    if out is not None:
        checked_suffix(out, "out", (PARQUET, CSV))
        place = expand_user_path(out)
        check_writable(place)
    with ExitStack() as stack:
        one, other = (open_result(each, stack) for each in (a, b))
        files = [file for file in (*one.files, *other.files) if file.exists()]
        if place and place.exists() and any(map(place.samefile, files)):
            raise BadInput([Mistake("camopt", "out", str(place), "another file: this one is compared")])
        names = [name for name in one.scenes if name in other.scenes]
        if not names:
            why = "a result with a scene or table of the same name as in the other; "
            why += f"there are {_scene_list_text(one)}, and {_scene_list_text(other)}"
            raise BadInput([Mistake("camopt", "result", other.name, why)])
        pairs = {name: (one.tables[name], other.tables[name]) for name in one.tables if name in other.tables}
        for x, y in pairs.values():
            _check_equal_column_types(x, y)
        matchings = {name: match_designs(*pair) for name, pair in pairs.items()}
        fronts = {name for name in pairs if name != DESIGNS or PARETO not in pairs}
        tables = {name: _compare_tables(*pair, matchings[name], name in fronts) for name, pair in pairs.items()}
        scenes = _differing_scenes(one, other, names)
        searched = {table.scene for side in (one, other) for table in side.tables.values()}
        cams = {
            names: differing_cam_quantities(*pair)
            for names, pair in scenes.items()
            if searched.isdisjoint(pair) and not any(missing_variable_mistakes(resolve(scene)) for scene in pair)
        }
        if place:
            changes = {name: (*pair, matchings[name], tables[name].changed) for name, pair in pairs.items()}
            write_differences(changes, place)
        return Comparison(
            one.name,
            other.name,
            {names: scene_differences(*pair) for names, pair in scenes.items()},
            scenes,
            cams,
            tables,
            tuple(name for name in one.scenes if name not in other.scenes),
            tuple(name for name in other.scenes if name not in one.scenes),
            (_table_version_text(one), _table_version_text(other)),
        )


def _check_equal_column_types(a: DesignTable, b: DesignTable) -> None:
    """Raise BadInput if a common column has different types; an empty column has any type."""
    for name in a.names:
        kinds = {side.layout.field(name).type for side in (a, b) if name in side.names} - {pa.null()}
        if len(kinds) > 1:
            raise not_a_table_error(b.name, f"the type of its column {name} differs from that in {a.name}")


def _scene_list_text(result: ComparedResult) -> str:
    return f"{', '.join(result.scenes)} in {result.name}"


def _table_version_text(result: ComparedResult) -> str:
    return ", ".join(sorted({str(table.metadata["version"]) for table in result.tables.values()}))


def _differing_scenes(a: ComparedResult, b: ComparedResult, names: Iterable[str]) -> dict[str, tuple[Scene, Scene]]:
    """Pairs of scenes that differ in a setting, by their names; names of the same pair are joined."""
    names_by_pair: dict[tuple[Scene, Scene], list[str]] = {}
    for name in names:
        names_by_pair.setdefault((a.scenes[name], b.scenes[name]), []).append(name)
    return {", ".join(joined): pair for pair, joined in names_by_pair.items() if scene_differences(*pair)}


def _compare_tables(a: DesignTable, b: DesignTable, pairs: Matching, with_fronts: bool) -> TableComparison:
    differs, beyond = np.zeros((2, pairs.in_a.size), dtype=bool)
    quantities = {}
    for name, change, here, there in changed_quantities_with_masks(a, b, pairs):
        quantities[name] = change
        differs |= here
        beyond |= there
    comparable = with_fronts and a.objectives == b.objectives and a.objectives
    return TableComparison(
        designs=(a.count, b.count),
        went=pairs.went,
        came=pairs.came,
        changed=np.column_stack([pairs.in_a[differs], pairs.in_b[differs]]),
        beyond=int(beyond.sum()),
        quantities=quantities,
        columns_in_a=tuple(name for name in a.names if name not in b.names),
        columns_in_b=tuple(name for name in b.names if name not in a.names),
        objectives=(_aim_by_objective(a), _aim_by_objective(b)),
        units={name: str(a.metadata["units"][name]) for name in a.objectives},
        fronts=compare_fronts(a.front_costs(), b.front_costs()) if comparable else None,
        first={
            "went": _shown_rows_feasible_and_best_first(a, pairs.went),
            "came": _shown_rows_feasible_and_best_first(b, pairs.came),
        },
    )


def _aim_by_objective(table: DesignTable) -> dict[str, str]:
    return {name: "minimise" if sign > 0.0 else "maximise" for name, sign in table.objectives.items()}


def _shown_rows_feasible_and_best_first(table: DesignTable, rows: IndexArray) -> list[dict[str, Any]]:
    """Sizes and objectives of at most ``SHOWN_DESIGNS`` rows, with row numbers; the best feasible designs first."""
    if not rows.size:
        return []
    worse = [sign * table.floats(name)[rows] for name, sign in table.objectives.items()][:1]
    rows = rows[np.lexsort([*worse, ~table.front_candidates()[rows]])][:SHOWN_DESIGNS]
    names = [name for name in dict.fromkeys((*table.key_columns, *table.objectives)) if name != "scene"]
    columns = {name: table.column(name).take(rows).to_pylist() for name in names}
    return [{"row": int(row), **{n: columns[n][k] for n in names}} for k, row in enumerate(rows)]


def _short_value_text(value: Any) -> str:
    """A value of a scene as text of a cell."""
    if value is None:
        return NOT_SET
    text = ", ".join(map(number_text, value)) if isinstance(value, list) else number_text(value)
    return text if len(text) <= VALUE_CHARACTERS else f"{text[:VALUE_CHARACTERS]}…"


def _value_in_shown_unit(name: str, value: Any) -> Any:
    """A value of a column in the shown unit."""
    return to_shown_unit(value, unit_of_column(name)) if isinstance(value, float) else value


def _quantity_sections(scene_names: str, value_pairs: Mapping[str, ValuePair]) -> Iterator[Table | str]:
    """Quantities of two cams that differ, side by side."""
    if not value_pairs:
        yield f"The quantities of both cams are the same ({scene_names})."
        return
    rows = [
        {
            "quantity": shown_column_name(name),
            "A": _short_value_text(_value_in_shown_unit(name, each.a)),
            "B": _short_value_text(_value_in_shown_unit(name, each.b)),
            "B − A": "" if each.difference is None else f"{_value_in_shown_unit(name, each.difference):+.6g}",
            "relative": f"{each.difference / abs(each.a):+.1%}" if each.difference and each.a else "",
        }
        for name, each in value_pairs.items()
    ]
    yield table_of(f"Quantities that differ ({scene_names})", rows, [*rows[0]])


def _design_sections(name: str, table: TableComparison) -> Iterator[Table | str]:
    """Numbers of designs only in A, only in B and changed; changed quantities; the best designs only in A or B."""
    in_a, in_b = table.designs
    yield f"{name}: {in_a:,} designs in A, {in_b:,} in B"
    if table.has_same_designs:
        yield "The same designs, with the same quantities."
        return
    only = f"{table.went.size:,} only in A, {table.came.size:,} only in B"
    beyond = f" ({table.beyond:,} of them beyond the accuracy)" if len(table.changed) else ""
    yield f"{only}, {len(table.changed):,} changed{beyond}"
    for side, columns in (("A", table.columns_in_a), ("B", table.columns_in_b)):
        if columns:
            yield f"Columns only in {side}: {', '.join(columns)}"
    if table.quantities:
        rows = [
            {
                "quantity": shown_column_name(name),
                "designs": change.designs,
                "beyond accuracy": change.beyond,
                "largest change": "" if change.largest is None else float(f"{change.largest:.2g}"),
                "A": _short_value_text(_value_in_shown_unit(name, change.a)),
                "B": _short_value_text(_value_in_shown_unit(name, change.b)),
            }
            for name, change in table.quantities.items()
        ]
        yield ""
        yield table_of(
            "Quantities that changed, with the values of the design with the largest relative change",
            rows,
            [*rows[0]],
        )
    for side, kind, count in (("A", "went", table.went.size), ("B", "came", table.came.size)):
        if rows := table.first[kind]:
            title = f"Designs only in {side}" + (f": {len(rows)} of {count:,}" if count > len(rows) else "")
            yield ""
            numbers = [name for name in rows[0] if name not in ("row", *LAW_COLUMNS)]
            yield table_of(title, with_rise_law_as_law_column(rows), ["row", *shown_law_columns(rows), *numbers])


def _front_sections(table: TableComparison) -> Iterator[Table | str]:
    """Differences of the fronts, or the reason why they cannot be compared."""
    a, b = table.objectives
    if table.fronts and table.fronts.has_same_points:
        yield table.fronts.verdict_sentence
    elif table.fronts:
        yield ""
        words: dict[str, Callable[[FrontSide], str]] = {
            "points": lambda side: f"{side.points:,}",
            "hypervolume (0 to 1, higher is better)": lambda side: (
                f"{'' if side.exact else 'about '}{side.hypervolume:.6g}"
            ),
            "points dominated by the other": lambda side: _count_with_share(side.dominated, side.points),
            "points on both fronts": lambda side: _count_with_share(side.shared, side.points),
            "mean distance behind the other (IGD⁺)": lambda side: _distance_text(side.behind_mean),
            "largest distance behind the other (ε)": lambda side: _distance_text(side.behind_most),
        }
        rows = [{"": word, "A": text(table.fronts.a), "B": text(table.fronts.b)} for word, text in words.items()]
        yield table_of("The fronts, normalised by the ideal and the nadir of both", rows, ["", "A", "B"])
        yield table.fronts.verdict_sentence
    elif a != b:
        yield f"The fronts cannot be compared: A has the objectives {_objectives_text(a)}; B {_objectives_text(b)}."


def _objectives_text(objectives: dict[str, str]) -> str:
    return ", ".join(f"{aim} {name}" for name, aim in objectives.items()) or "none"


def _count_with_share(count: int, total: int) -> str:
    return f"{count:,} ({count / total:.1%})" if total else "0"


def _distance_text(value: float | None) -> str:
    return NOT_SET if value is None else f"{value:.3g}".replace("-", "−")

"""The page of tables of designs: its rows, its columns and the motions of its cams."""

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isnan
from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import BoolArray, FloatArray
from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.unit_systems import from_shown_unit, to_shown_unit, unit_in_shown_system
from camopt.scene.problem.problem import resolve_design
from camopt.scene.problem.variables import variables_of_scene
from camopt.scene.scene import Scene
from camopt.show.drawing.picture import Picture
from camopt.show.reporting.cam_data import (
    cam_kind_data,
    rounded_number_for_page,
    sampled_motion_pieces,
    train_position_data,
)
from camopt.show.reporting.cams import Chapter
from camopt.show.reporting.page import deflate_to_base64, render_page
from camopt.show.reporting.sections import number_text_with_minus_sign
from camopt.solve.tables.cells import column_heading, shown_column_name, unit_of_column
from camopt.solve.tables.designs import DESIGNS, PARETO, frontier_axes_among_columns, scene_of_row
from camopt.solve.tables.result import NUMERIC, Cell, Table

if TYPE_CHECKING:
    import pandas as pd

PAGE_ROWS = 100_000
MOST_MOTIONS = 200
MOST_WORDS = 2**16
MOST_AXES = 8
MOTION_COLUMNS = ("law_rise", "law_return", "angles_deg", "scene")
"""Columns on which the motion of a row depends."""
IN_ROW, RESULT, FRONT = "row", "result", "front"
HIDDEN_COLUMNS = {"scene", "relative_half_width", "prime_radius_mm"}


@dataclass(frozen=True)
class ResultRows:
    """A table of designs for a page."""

    name: str
    frame: "pd.DataFrame"
    """The rows; column ``row`` is the number in the file; column ``front``, if present, marks the Pareto front."""
    total: int
    """Number of rows of the whole result; ``frame`` may have fewer."""

    @cached_property
    def scene(self) -> Scene:
        """The scene that was searched."""
        text = self.frame.attrs.get("scene")
        names = {*self.frame.columns}
        if not text:
            why = (
                "has no scene: pandas has dropped attrs, as in a merge; merged.attrs.update(front.attrs) "
                "restores them"
            )
            raise BadInput([Mistake("camopt", "table", self.name, why, bare=True)])
        if not {"law_rise", *RADIUS_COLUMNS} & names or len({"law_rise", "law_return"} & names) == 1:
            why = "a table of designs that camopt wrote, such as pareto.parquet"
            raise BadInput([Mistake("camopt", "table", self.name, why)])
        return Scene.embedded(text, self.name)

    @property
    def objectives(self) -> list[str]:
        """Columns that were minimised or maximised; the axes of a frontier."""
        names, search = list(self.frame.columns), self.scene.search
        return frontier_axes_among_columns(names) or [
            name for name in (*search.minimise, *search.maximise) if name in names
        ]


RADIUS_COLUMNS = ("base_radius_mm", "mean_radius_mm")


def thinned_result_rows(name: str, frame: "pd.DataFrame", front: "pd.DataFrame | None" = None) -> ResultRows:
    """A table with its Pareto front. A table longer than ``PAGE_ROWS`` is thinned evenly, but not its front."""
    import pandas as pd

    room = PAGE_ROWS - (0 if front is None else len(front))
    kept = frame if len(frame) <= room else frame.iloc[:: -(-len(frame) // room)]
    kept = kept.assign(**{IN_ROW: kept.index})
    attrs = frame.attrs
    if front is not None:
        attrs = {**frame.attrs, **{key: front.attrs.get(key) for key in (FRONT, "sweep")}}
        marked = [kept.assign(**{FRONT: False}), front.assign(**{FRONT: True}).assign(**{IN_ROW: front.index})]
        sizes = [column for column in front if column in QUANTITIES and QUANTITIES[column].effect == "sizes"]
        kept = pd.concat(marked, ignore_index=True).drop_duplicates(sizes, keep="last", ignore_index=True)
    kept = kept.reset_index(drop=True)
    kept.attrs = attrs
    return ResultRows(name, kept, len(frame))


class CoarsePicture(Picture):
    """A picture with few samples, for a page with many motions."""

    per_degree = 1.0


def results_page(results: Sequence[ResultRows], full: bool = False) -> str:
    """The HTML page of one table of designs, or of several with the same columns."""
    import pandas as pd

    scenes = [result.scene for result in results]
    frame = pd.concat([r.frame.assign(**{RESULT: r.name}) for r in results], ignore_index=True)
    motions, motion_of_row = _motions_and_motion_index_by_row(results)
    columns, constants = _packed_and_constant_columns(frame, results)
    numeric = [column["name"] for column in columns if "words" not in column and column["name"] != IN_ROW]
    numeric = [name for name in numeric if frame[name].nunique() > 1]
    worded = [column["name"] for column in columns if "words" in column]
    if len(numeric) < 2:
        why = "a table with at least two columns whose numbers differ between rows"
        raise BadInput([Mistake("camopt", "table", results[0].name, why)])
    objectives = [name for name in results[0].objectives if name in numeric]
    axes = [*objectives, *(name for name in numeric if name not in objectives)]
    data = {
        "count": len(frame),
        "columns": columns,
        "motions": deflate_to_base64(json.dumps(motions, separators=(",", ":")).encode()),
        "motion_of": deflate_to_base64(np.asarray(motion_of_row, dtype="<u2").tobytes()),
        "results": [_shape_data(result, frame) for result in results],
        "axes": axes[:2],
        "parallel": axes[:MOST_AXES],
        "colour": next((name for name in (RESULT, "free", "law_rise", "law_return") if name in worded), ""),
        "first": _rows_drawn_first(frame, results[0], axes[0]),
        "files": [PARETO, DESIGNS] if FRONT in frame else [""],
    }
    return render_page(
        "results",
        " and ".join(dict.fromkeys(scene.name for scene in scenes)),
        data,
        lines=[Cell(line) for result in results for line in _result_sentences(result)],
        tables=[constants] if constants.rows else [],
        sections=[
            Chapter(f"{r.name}: scene (TOML)", text=s.to_toml()) for r, s in zip(results, scenes, strict=True)
        ],
        full=full,
    )


def _result_sentences(result: ResultRows) -> list[str]:
    """Sentences on the number of designs, the Pareto front and the proven bound."""
    shown, total = len(result.frame), result.total
    swept = result.frame.attrs.get("sweep")
    words = f"{result.name}: {total:,} designs" + (f" of {swept['designs']:,} swept" if swept else "")
    thinned = f"; the page shows {shown:,} of them, evenly spaced" if shown < total else ""
    if "feasible" in result.frame:
        feasible = result.frame["feasible"].to_numpy(dtype=bool)
        count = "all" if feasible.all() else f"{np.sum(feasible):,} of those here" if feasible.any() else "none"
        words += f", {count} feasible"
    lines = [words + (f"{thinned}, and all of the Pareto front" if thinned and FRONT in result.frame else thinned)]
    front = result.frame.attrs.get("front")
    if front:
        many = "design" if front["points"] == 1 else "designs"
        lines.append(
            f"Pareto front: {front['points']:,} {many}, hypervolume {front['hypervolume']:.6g} (0 "
            f"to 1, higher is better)"
        )
    frame = result.frame
    free = frame[frame["free"].astype(bool) & frame["bound"].notna()] if "bound" in frame else frame[:0]
    if not free.empty:  # the smallest cam of a frontier, and the proven bound over all motions
        axis = result.objectives[0]
        best = free.sort_values(axis).iloc[0]
        gap = best[axis] / best["bound"] - 1.0 if best["bound"] else float("nan")
        unit = frame.attrs["units"].get(axis, "")
        values = (float(to_shown_unit(best[name], unit)) for name in (axis, "bound"))
        least, bound = map(number_text_with_minus_sign, values)
        words = f"Smallest {axis} {least} {unit_in_shown_system(unit)}; proven lower bound over all motions"
        lines.append(f"{words} {bound} {unit_in_shown_system(unit)}: a gap of {gap:.2%}")
    return lines


def _motions_and_motion_index_by_row(results: Sequence[ResultRows]) -> tuple[list[Any], list[int]]:
    """The motions of all rows, and the index of each row's motion. Beyond ``MOST_MOTIONS`` the motion is None."""
    motions: list[Any] = []
    places: list[int] = []
    for result in results:
        trains = [variable.quantity for variable in variables_of_scene(result.scene) if variable.role == "train"]
        keys = [name for name in (*MOTION_COLUMNS, *trains) if name in result.frame]
        groups = result.frame.groupby(keys, sort=False, dropna=False) if keys else None
        of_row = np.zeros(len(result.frame), dtype=int) if groups is None else groups.ngroup().to_numpy()
        _, first = np.unique(of_row, return_index=True)
        offset = len(motions)
        room = MOST_MOTIONS // len(results)
        for row in result.frame.iloc[first[:room]].to_dict("records"):
            scene = scene_of_row(result.scene, _present_values(row))
            picture = CoarsePicture(scene, resolve_design(scene))
            motions.append({"motion": sampled_motion_pieces(picture), "train": train_position_data(picture)})
        motions.append(None)
        places += [offset + min(int(place), len(first[:room])) for place in of_row]
    return motions, places


def _shape_data(result: ResultRows, frame: "pd.DataFrame") -> dict[str, Any]:
    """Data on the shape of the cams of a result: kind, constant sizes, and columns of the other sizes."""
    scene = scene_of_row(result.scene, _present_values(result.frame.iloc[:1].to_dict("records")[0]))
    problem = resolve_design(scene)
    sizes = {name: rounded_number_for_page(values[0]) for name, values in problem.design.sizes.items()}
    defaults = {"pitch_point": None, "undercut": False, "left": None, "exists": True}
    return {
        "kind": {**cam_kind_data(scene, problem), **defaults},
        "sizes": sizes,
        "columns": _size_column_by_field(result, frame),
    }


def _size_column_by_field(result: ResultRows, frame: "pd.DataFrame") -> dict[str, str]:
    """The column of each size, by field of Designs."""
    sizes = [variable for variable in variables_of_scene(result.scene) if variable.is_size]
    return {size.field: size.quantity for size in sizes if size.quantity in frame}


def _present_values(row: Mapping[Any, Any]) -> dict[str, Any]:
    """The values of a row without missing ones."""
    return {n: v for n, v in row.items() if not (v is None or (isinstance(v, float) and isnan(v)))}


def _packed_and_constant_columns(
    frame: "pd.DataFrame", results: Sequence[ResultRows]
) -> tuple[list[dict[str, Any]], Table]:
    """The packed columns of a page, and a table of the columns that are constant."""
    units, descriptions = (results[0].frame.attrs.get(key, {}) for key in ("units", "descriptions"))
    packed: list[dict[str, Any]] = []
    constants = []
    duplicates = (
        {"law_return"} if "law_return" in frame and frame["law_return"].equals(frame["law_rise"]) else set()
    )
    sized = {name for result in results for name in _size_column_by_field(result, frame).values()}
    for name in frame.columns:
        if name in HIDDEN_COLUMNS | duplicates:
            continue
        title = _column_title(str(name), units.get(name, ""), duplicates)
        unit = unit_of_column(str(name), units.get(name))
        values = frame[name]  # numbers in shown units, all else as text
        values = to_shown_unit(values, unit) if values.dtype.kind in "fi" else values.map(_value_text)
        if values.nunique() <= 1 and name not in sized | {IN_ROW}:
            if name not in (RESULT, FRONT) and values.notna().any():
                constants.append([title, _value_text(values.dropna().iloc[0])])
            continue
        about = QUANTITIES[name].sentence if name in QUANTITIES else descriptions.get(name, "")
        names = {"name": str(name), "called": shown_column_name(str(name)), "title": title, "about": about}
        packed.append({**names, "scale": from_shown_unit(1.0, unit), **_packed_column(values)})
    packed.sort(key=lambda column: (column["name"] != RESULT, column["name"] != FRONT, column["name"] != IN_ROW))
    return packed, Table.from_texts("Equal in all designs", ["quantity", Cell("value", NUMERIC)], constants)


def _column_title(name: str, unit: str, duplicates: Collection[str]) -> str:
    """The name of a column in words, with its unit."""
    if duplicates and name == "law_rise":
        return "law"
    words = column_heading(name, unit).split("\n")
    name = " ".join(words[:-1] if unit else words)
    return f"{name}, {words[-1]}" if unit and unit != name else name or words[-1]


def _value_text(value: Any) -> str:
    if value is None:
        return ""
    return (
        ", ".join(map(str, value)) if isinstance(value, (list, np.ndarray)) else number_text_with_minus_sign(value)
    )


def _packed_column(values: "pd.Series[Any]") -> dict[str, Any]:
    """A column as base64: numbers as byte planes of floats, which deflate better; texts as indices of words."""
    if values.dtype.kind in "fi":
        floats = values.to_numpy(dtype="<f4")
        return {"packed": deflate_to_base64(floats.view(np.uint8).reshape(-1, 4).T.tobytes())}
    codes, distinct = values.factorize(sort=True)
    words = [str(word) for word in distinct]
    if len(words) > MOST_WORDS:
        codes, words = np.zeros(len(values), dtype=int), ["…"]
    return {"packed": deflate_to_base64(np.asarray(codes, dtype="<u2").tobytes()), "words": words}


def _rows_drawn_first(frame: "pd.DataFrame", result: ResultRows, objective: str) -> list[int]:
    """Rows drawn when the page opens: the knee or the best known law, then the best by the first objective."""
    values = frame[objective].to_numpy(dtype=float)
    front = frame[FRONT].to_numpy(dtype=bool) if FRONT in frame else np.ones(len(frame), dtype=bool)
    free = frame["free"].to_numpy(dtype=bool) if "free" in frame else front
    best = _smallest_value_index(values, front & free)
    beside = _smallest_value_index(values, front & ~free)
    knee = (result.frame.attrs.get("front") or {}).get("knee")
    if knee:
        at_knee = np.logical_and.reduce([frame[name] == knee[name] for name in result.objectives if name in knee])
        beside = _smallest_value_index(values, at_knee)
    return [row for row in dict.fromkeys((beside, best)) if row is not None] or [0]


def _smallest_value_index(values: FloatArray, mask: BoolArray) -> int | None:
    """Index of the smallest value where ``mask`` is true; None if no such value is finite."""
    return int(np.nanargmin(np.where(mask, values, np.nan))) if np.isfinite(values[mask]).any() else None

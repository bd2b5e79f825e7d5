"""The page of a result with many designs: its columns, the motions that its cams have, and which rows it holds."""

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
from camopt.core.quantities.unit_systems import from_shown_unit, shown_unit, to_shown_unit
from camopt.scene.problem.problem import resolve_design
from camopt.scene.problem.variables import variables_of
from camopt.scene.scene import Scene
from camopt.show.drawing.picture import Picture
from camopt.show.reporting.cam_data import motion_pieces, page_number, stroke_kind, train_frames
from camopt.show.reporting.cams import Chapter
from camopt.show.reporting.page import deflate_to_text, render_page
from camopt.show.reporting.sections import signed_text
from camopt.solve.tables.cells import heading, shown_column_name, unit_of_column
from camopt.solve.tables.designs import DESIGNS, PARETO, axes_of, scene_of_row
from camopt.solve.tables.result import NUMERIC, Cell, Table

if TYPE_CHECKING:
    import pandas as pd

PAGE_ROWS = 100_000
MOST_MOTIONS = 200
MOST_WORDS = 2**16
MOST_AXES = 8
MOTION_COLUMNS = ("law_rise", "law_return", "angles_deg", "scene")
"""Columns that decide the motion of a row."""
IN_ROW, RESULT, FRONT = "row", "result", "front"
HIDDEN_COLUMNS = {"scene", "relative_half_width", "prime_radius_mm"}


@dataclass(frozen=True)
class ResultRows:
    """A table of designs: its name, its rows with those of the front, and how many rows it has elsewhere."""

    name: str
    frame: "pd.DataFrame"
    """Rows by their number in the file; a column ``front`` says which are on the Pareto front, if not all are."""
    total: int
    """The rows of the whole result, of which the frame may be a part."""

    @cached_property
    def scene(self) -> Scene:
        """The scene that was searched."""
        text = self.frame.attrs.get("scene")
        names = {*self.frame.columns}
        if not text:
            why = (
                "has no scene: pandas drops attrs, as in a merge; merged.attrs.update(front.attrs) brings them back"
            )
            raise BadInput([Mistake("camopt", "table", self.name, why, bare=True)])
        if not {"law_rise", *RADIUS_COLUMNS} & names or len({"law_rise", "law_return"} & names) == 1:
            why = "a table of designs that camopt wrote, such as pareto.parquet"
            raise BadInput([Mistake("camopt", "table", self.name, why)])
        return Scene.embedded(text, self.name)

    @property
    def objectives(self) -> list[str]:
        """What was minimised or maximised, as columns; of a frontier its axes."""
        names, search = list(self.frame.columns), self.scene.search
        return axes_of(names) or [name for name in (*search.minimise, *search.maximise) if name in names]


RADIUS_COLUMNS = ("base_radius_mm", "mean_radius_mm")


def result_rows(name: str, frame: "pd.DataFrame", front: "pd.DataFrame | None" = None) -> ResultRows:
    """A table, or one with its Pareto front: thinned evenly if it has too many rows, the front whole."""
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
    """For motions of which a page has many."""

    per_degree = 1.0


def results_page(results: Sequence[ResultRows]) -> str:
    """The page of one result, or of several in the same columns."""
    import pandas as pd

    scenes = [result.scene for result in results]
    frame = pd.concat([r.frame.assign(**{RESULT: r.name}) for r in results], ignore_index=True)
    motions, motion_of_row = _row_motions(results)
    columns, same = _packed_columns(frame, results)
    numeric = [column["name"] for column in columns if "words" not in column and column["name"] != IN_ROW]
    numeric = [name for name in numeric if frame[name].nunique() > 1]
    worded = [column["name"] for column in columns if "words" in column]
    if len(numeric) < 2:
        why = "a table in which at least two numbers differ from row to row"
        raise BadInput([Mistake("camopt", "table", results[0].name, why)])
    objectives = [name for name in results[0].objectives if name in numeric]
    axes = [*objectives, *(name for name in numeric if name not in objectives)]
    data = {
        "count": len(frame),
        "columns": columns,
        "motions": deflate_to_text(json.dumps(motions, separators=(",", ":")).encode()),
        "motion_of": deflate_to_text(np.asarray(motion_of_row, dtype="<u2").tobytes()),
        "results": [_shape_data(result, frame) for result in results],
        "axes": axes[:2],
        "parallel": axes[:MOST_AXES],
        "colour": next((name for name in (RESULT, "free", "law_rise", "law_return") if name in worded), ""),
        "first": _first_rows(frame, results[0], axes[0]),
        "files": [PARETO, DESIGNS] if FRONT in frame else [""],
    }
    return render_page(
        "results",
        " and ".join(dict.fromkeys(scene.name for scene in scenes)),
        data,
        lines=[Cell(line) for result in results for line in _result_sentences(result)],
        tables=[same] if same.rows else [],
        sections=[
            Chapter(f"{r.name}: scene (TOML)", text=s.to_toml()) for r, s in zip(results, scenes, strict=True)
        ],
    )


def _result_sentences(result: ResultRows) -> list[str]:
    """How many designs are here, and of how many; what is known of the front."""
    here, of = len(result.frame), result.total
    swept = result.frame.attrs.get("sweep")
    words = f"{result.name}: {of:,} designs" + (f" of {swept['designs']:,} that were swept" if swept else "")
    thinned = f"; the page has {here:,} of them, evenly taken" if here < of else ""
    if "feasible" in result.frame:
        words += f", {_count_words(result.frame['feasible'].to_numpy(dtype=bool))} feasible"
    lines = [words + (f"{thinned}, and all of the Pareto front" if thinned and FRONT in result.frame else thinned)]
    front = result.frame.attrs.get("front")
    if front:
        many = "design" if front["points"] == 1 else "designs"
        lines.append(f"Pareto front: {front['points']:,} {many}, hypervolume {front['hypervolume']:.6g} as a share")
    return [*lines, *_bound_sentences(result)]


def _count_words(which: BoolArray) -> str:
    """How many of some designs: all, none, or a number."""
    return "all" if which.all() else f"{np.sum(which):,} of those here" if which.any() else "none"


def _bound_sentences(result: ResultRows) -> list[str]:
    """Of a frontier, how near its smallest cam is to the bound that no motion can pass."""
    frame = result.frame
    if "bound" not in frame:
        return []
    axis = result.objectives[0]
    free = frame[frame["free"].astype(bool) & frame["bound"].notna()]
    if free.empty:
        return []
    best = free.sort_values(axis).iloc[0]
    gap = best[axis] / best["bound"] - 1.0 if best["bound"] else float("nan")
    unit = frame.attrs["units"].get(axis, "")
    least, bound = (signed_text(float(to_shown_unit(best[name], unit))) for name in (axis, "bound"))
    words = f"Least {axis} {least} {shown_unit(unit)}; no motion at all can have less than"
    return [f"{words} {bound} {shown_unit(unit)}: a gap of {gap:.2%}"]


def _row_motions(results: Sequence[ResultRows]) -> tuple[list[Any], list[int]]:
    """The motions that rows have, and which each row has; the last of all, none, for rows beyond the most."""
    motions: list[Any] = []
    places: list[int] = []
    for result in results:
        trains = [each.quantity for each in variables_of(result.scene) if each.role == "train"]
        keys = [name for name in (*MOTION_COLUMNS, *trains) if name in result.frame]
        groups = result.frame.groupby(keys, sort=False, dropna=False) if keys else None
        of_row = np.zeros(len(result.frame), dtype=int) if groups is None else groups.ngroup().to_numpy()
        _, first = np.unique(of_row, return_index=True)
        offset = len(motions)
        room = MOST_MOTIONS // len(results)
        for row in result.frame.iloc[first[:room]].to_dict("records"):
            scene = scene_of_row(result.scene, _present_values(row))
            picture = CoarsePicture(scene, resolve_design(scene))
            motions.append({"motion": motion_pieces(picture), "train": train_frames(picture)})
        motions.append(None)
        places += [offset + min(int(place), len(first[:room])) for place in of_row]
    return motions, places


def _shape_data(result: ResultRows, frame: "pd.DataFrame") -> dict[str, Any]:
    """What decides the shape of the cams of a result: formulas, sizes that stay, and the columns of the others."""
    scene = scene_of_row(result.scene, _present_values(result.frame.iloc[:1].to_dict("records")[0]))
    problem = resolve_design(scene)
    sizes = {name: page_number(values[0]) for name, values in problem.design.sizes.items()}
    own = {"pitch_point": None, "undercut": False, "left": None, "exists": True}
    return {"kind": {**stroke_kind(scene, problem), **own}, "sizes": sizes, "columns": _size_columns(result, frame)}


def _size_columns(result: ResultRows, frame: "pd.DataFrame") -> dict[str, str]:
    """The columns that sizes of a design are in, by field of Designs."""
    sizes = [each for each in variables_of(result.scene) if each.is_size]
    return {each.field: each.quantity for each in sizes if each.quantity in frame}


def _present_values(row: Mapping[Any, Any]) -> dict[str, Any]:
    """What a row has of its columns."""
    return {n: v for n, v in row.items() if not (v is None or (isinstance(v, float) and isnan(v)))}


def _packed_columns(frame: "pd.DataFrame", results: Sequence[ResultRows]) -> tuple[list[dict[str, Any]], Table]:
    """The columns as a page holds them, and a table of those that are the same in all rows."""
    units, descriptions = (results[0].frame.attrs.get(key, {}) for key in ("units", "descriptions"))
    found: list[dict[str, Any]] = []
    same = []
    twice = {"law_return"} if "law_return" in frame and frame["law_return"].equals(frame["law_rise"]) else set()
    sized = {name for result in results for name in _size_columns(result, frame).values()}
    for name in frame.columns:
        if name in HIDDEN_COLUMNS | twice:
            continue
        title = _column_title(str(name), units.get(name, ""), twice)
        unit = unit_of_column(str(name), units.get(name))
        values = frame[name]  # numbers as they are shown, all else as texts
        values = to_shown_unit(values, unit) if values.dtype.kind in "fi" else values.map(_value_text)
        if values.nunique() <= 1 and name not in sized | {IN_ROW}:
            if name not in (RESULT, FRONT) and values.notna().any():
                same.append([title, _value_text(values.dropna().iloc[0])])
            continue
        about = QUANTITIES[name].sentence if name in QUANTITIES else descriptions.get(name, "")
        known = {"name": str(name), "called": shown_column_name(str(name)), "title": title, "about": about}
        found.append({**known, "scale": from_shown_unit(1.0, unit), **_packed_column(values)})
    found.sort(key=lambda column: (column["name"] != RESULT, column["name"] != FRONT, column["name"] != IN_ROW))
    return found, Table.from_texts("The same in all designs", ["quantity", Cell("value", NUMERIC)], same)


def _column_title(name: str, unit: str, twice: Collection[str]) -> str:
    """A column's name in words, and its unit."""
    if twice and name == "law_rise":
        return "law"
    words = heading(name, unit).split("\n")
    name = " ".join(words[:-1] if unit else words)
    return f"{name}, {words[-1]}" if unit and unit != name else name or words[-1]


def _value_text(value: Any) -> str:
    if value is None:
        return ""
    return ", ".join(map(str, value)) if isinstance(value, (list, np.ndarray)) else signed_text(value)


def _packed_column(values: "pd.Series[Any]") -> dict[str, Any]:
    """Numbers as planes of the bytes of floats, which deflate better; all else as places in a list of words."""
    if values.dtype.kind in "fi":
        floats = values.to_numpy(dtype="<f4")
        return {"packed": deflate_to_text(floats.view(np.uint8).reshape(-1, 4).T.tobytes())}
    codes, found = values.factorize(sort=True)
    words = [str(word) for word in found]
    if len(words) > MOST_WORDS:
        codes, words = np.zeros(len(values), dtype=int), ["…"]
    return {"packed": deflate_to_text(np.asarray(codes, dtype="<u2").tobytes()), "words": words}


def _first_rows(frame: "pd.DataFrame", result: ResultRows, objective: str) -> list[int]:
    """The rows that are drawn first: the knee or the best known law, then the best of the first objective."""
    values = frame[objective].to_numpy(dtype=float)
    here = frame[FRONT].to_numpy(dtype=bool) if FRONT in frame else np.ones(len(frame), dtype=bool)
    free = frame["free"].to_numpy(dtype=bool) if "free" in frame else here
    best = _least_row(values, here & free)
    beside = _least_row(values, here & ~free)
    knee = (result.frame.attrs.get("front") or {}).get("knee")
    if knee:
        same = np.logical_and.reduce([frame[name] == knee[name] for name in result.objectives if name in knee])
        beside = _least_row(values, same)
    return [row for row in dict.fromkeys((beside, best)) if row is not None] or [0]


def _least_row(values: FloatArray, among: BoolArray) -> int | None:
    """The place of the least of some values; None of none."""
    return int(np.nanargmin(np.where(among, values, np.nan))) if np.isfinite(values[among]).any() else None

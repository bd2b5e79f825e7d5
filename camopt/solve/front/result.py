"""The result of a sweep: counts, files, the best designs and the front."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camopt.core.mistakes import NOTHING_FEASIBLE, BadInput, Mistake
from camopt.core.quantities.display import Drawable
from camopt.core.storage.manifest import read_manifest
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.scene_notes import notes_on_search
from camopt.scene.problem.space import EDGE_OF_SPACE
from camopt.scene.scene import Scene
from camopt.solve.front.pareto import Front
from camopt.solve.tables.designs import (
    Design,
    design_table_columns,
    designs_table,
    limit_texts_by_quantity,
    nearest_miss_sections,
    own_quantity_units,
    shown_law_columns,
    with_rise_law_as_law_column,
)
from camopt.solve.tables.result import Result, Table, table_of
from camopt.solve.tables.table_writers import TableInMemory, import_table_module
from camopt.solve.verdicts.limit_verdicts import Effort
from camopt.solve.verdicts.verdict_words import BROKEN, UNDECIDED

HYPERVOLUME_NOTE = "It compares fronts of the same objectives, from 0 to 1: higher is better."


def undecided_and_recheck_counts(effort: Effort) -> dict[str, int]:
    """The numbers of designs that stayed undecided, were evaluated again, and were decided by intervals."""
    return {
        "undecided": effort.undecided,
        "looked_at_again": effort.again,
        "decided_in_intervals": effort.intervals - effort.undecided,
    }


if TYPE_CHECKING:
    import pandas as pd


FRONT_TABLE, DESIGNS_TABLE, TABLE_SUFFIX = "pareto", "designs", ".parquet"
"""The names of the tables of a sweep, and the suffix of their files."""


@dataclass(frozen=True)
class Sweep(Result, Drawable):
    """The result of a sweep: counts, files, and the best designs.

    Attributes
    ----------
    scene : Scene
        The scene that was swept.
    designs : int
        Number of designs in the space.
    impossible : int or None
        Number of designs that cannot be assembled, such as an offset beyond the prime radius; they are in no table.
        None if boxes of designs were decided together, without counting.
    feasible : int or None
        Number of feasible designs; None if boxes were decided together.
    effort : Effort
        Numbers of designs so near a limit that they were evaluated again, and by intervals. Designs that stay
        undecided even then do not count as feasible, and are only in a table of all designs.
    pareto : int
        Number of designs on the Pareto front.
    files : tuple of pathlib.Path
        The files that were written.
    best : dict
        The best feasible design of each law: least first objective, ties by the next. ``held_by`` names the
        limits that the next smaller cam of the space would exceed. If boxes were decided, the best on the front.
    nearest_miss : Design or None
        If no design is feasible: the design with the least excess; ``violated`` names the limits that it exceeds.
        In a space of more than four million designs, the nearest miss of some evenly spread blocks.
    reached : float
        The largest relative half-width of an enclosure of any row kept.
    front : Front or None
        Hypervolume, ideal, nadir and knee of the Pareto front; None if no design is feasible.
    obstacle : str
        If no design tried for the nearest miss can be assembled: the condition that they break. If some of the
        searched trains cannot make the motion: how many, and why the first of them cannot.
    evaluated : int
        Number of designs that were evaluated one by one.
    boxes : int
        Number of boxes of designs that were bounded; 0 if every design was evaluated.
    decided_by_boxes : int
        Number of designs in boxes that were dropped. A few of them were evaluated before.
    every_cam : dict of int or None
        With ``search.robust``: the number of designs on the front for each verdict on all cams within the
        tolerances. ``held``: all meet the limits, proved over the whole box. ``undecided``: not proved. A sweep
        evaluates the corners of the tolerances. If a proof finds a cam between them that breaks a limit, this cam
        joins them, and the sweep runs again. Designs that break a limit even then are left out (``broken``).
    already_done : bool
        Whether the result was in the folder already.

    Examples
    --------
    >>> search = {"base_radius": [60, 90, 120], "law": ["cycloidal"]}
    >>> swept = camopt.sweep(camopt.find_scene("roller-1000rpm").replace(search=search))
    >>> swept.feasible, swept.best["cycloidal"]["base_radius_mm"], swept.best["cycloidal"]["held_by"]
    (1, 120.0, 'pressure_angle')
    >>> swept.to_pandas()["base_radius_mm"].tolist()
    [120.0]
    """

    picture = "pictures.front"
    scene: Scene
    designs: int
    impossible: int | None
    feasible: int | None
    effort: Effort
    pareto: int
    files: tuple[Path, ...]
    best: dict[str, Design]
    nearest_miss: Design | None
    reached: float = 0.0
    front: Front | None = None
    obstacle: str = ""
    evaluated: int = 0
    boxes: int = 0
    decided_by_boxes: int = 0
    every_cam: dict[str, int] | None = None
    already_done: bool = False
    _rows: Mapping[str, TableInMemory] = field(default_factory=dict, repr=False, compare=False)
    """The tables of a sweep without files."""
    _question: Any = field(default=None, repr=False, compare=False)
    """The question of the sweep, as in the manifest of its folder."""

    def to_pandas(self, name: str | None = None) -> "pd.DataFrame":
        """The Pareto front, or another table of the sweep, as a DataFrame like that of ``load``.

        Parameters
        ----------
        name : str, optional
            "pareto", the default; "designs" for the designs that ``keep`` names; with ``search.refine``,
            "pareto-grid" for the front of the grid; or a key of ``to_dict`` with rows, such as "by_law". Tables
            of a sweep with ``out`` are read from its folder.

        Returns
        -------
        pandas.DataFrame
            A row for each design; ``attrs`` has units and scene, for ``scene_of``.

        Raises
        ------
        BadInput
            If the sweep has no such table; without ``out`` it has "designs" only if ``keep`` was given. If the
            folder has another result now.
        OSError
            If a file cannot be read.
        """
        name = FRONT_TABLE if name is None else name
        tables = self.kept_tables
        if name in tables:
            if name in self._rows:
                return self._rows[name].to_pandas()
            # BadInput if a later run left another result in the folder of the sweep
            folder = self.files[0].parent
            manifest = read_manifest(folder)
            if manifest and all(result.question != self._question for result in manifest.results.values()):
                why = "has another result now; give each sweep a folder of its own"
                raise BadInput([Mistake("camopt", "folder", str(folder), why, bare=True)])
            frame: pd.DataFrame = import_table_module().load(folder / f"{name}{TABLE_SUFFIX}")
            return frame
        if name not in (FRONT_TABLE, DESIGNS_TABLE):
            return super().to_pandas(name)
        allowed = f"a table of this sweep: {' or '.join(tables)}"
        hint = (
            '; a sweep without out keeps designs if keep names them, as keep="feasible"'
            if name == DESIGNS_TABLE
            else ""
        )
        raise BadInput([Mistake("camopt", "table", name, allowed + hint)])

    @property
    def kept_tables(self) -> list[str]:
        """The names of the tables of designs that ``to_pandas`` returns."""
        return [*self._rows, *(path.stem for path in self.files if path.suffix == TABLE_SUFFIX)]

    def __repr__(self) -> str:
        feasible = "" if self.feasible is None else f" {self.feasible:,} feasible,"
        return (
            f"<Sweep of {self.scene.name}: {self.designs:,} designs,{feasible} {self.pareto:,} on the Pareto front>"
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """A warning if an objective is the scene's own: the front is then that of the grid, without proof."""
        search = self.scene.search
        own = [name for name in search.objectives if name in self.scene.quantities]
        if not own or not self.pareto:
            return ()
        space = "sample" if search.samples else "grid"
        refined = ", refined without proof" if search.refine else ""
        why = f"boxes of designs cannot bound {', '.join(own)}, so every design was evaluated"
        return (f"the front is that of the {space}{refined}: {why}",)

    def table(self) -> Table | None:
        """The best design of each law."""
        if not self.best:
            return None
        rows, search = with_rise_law_as_law_column(self.best.values()), self.scene.search
        where = " on the front" if self.feasible is None else ""
        if search.refine:
            where += " of the grid" if where else " on the grid"
        title = f"The best design{' of each law' if shown_law_columns(rows) else ''}{where}"
        return designs_table(title, resolve(self.scene), rows, ["held_by"], (*search.minimise, *search.maximise))

    def knee_table(self) -> Table | None:
        """The knee of the front, in the columns of ``table``."""
        if self.front is None or not self.best:
            return None
        knee, search, problem = [self.front.knee], self.scene.search, resolve(self.scene)
        columns = design_table_columns(
            problem, with_rise_law_as_law_column(self.best.values()), (*search.minimise, *search.maximise)
        )
        names = [*shown_law_columns(knee), *(name for name in columns if not name.startswith("law"))]
        return table_of(
            "Its knee",
            with_rise_law_as_law_column(knee),
            names,
            limit_texts_by_quantity(problem),
            own_quantity_units(problem),
        )

    def sections(self) -> Iterator[Table | str]:
        """Counts, the best design of each law, the front; or the nearest miss."""
        undecided = f"{self.effort.undecided:,} undecided, " if self.effort.undecided else ""
        designs = f"{self.designs:,} design{'s' * (self.designs != 1)}"
        if self.feasible is None:  # boxes found the front, without counting
            counts = f"{self.decided_by_boxes:,} decided by boxes, {self.evaluated:,} evaluated, "
        else:
            counts = f"{self.impossible:,} impossible, {self.feasible:,} feasible, "
        yield f"{self.scene.name}: {designs}, {counts}{undecided}{self.pareto:,} on the Pareto front"
        if self.obstacle and (self.best or self.nearest_miss):
            yield f"Cannot be assembled: {self.obstacle}."
        if best := self.table():
            yield ""
            yield best
            yield from self._front_sections()
            yield from self._robust_verdict_sections()
        elif self.nearest_miss:
            yield from nearest_miss_sections(self.nearest_miss)
        elif self.impossible is not None:
            yield f"No design can be assembled: {self.obstacle}."
        else:
            yield f"No feasible design. None of the designs tried can be assembled: {self.obstacle}."

    def _front_sections(self) -> Iterator[Table | str]:
        """The hypervolume and the knee of a front of more than one design."""
        front = self.front
        assert front is not None
        if any(row["held_by"] == EDGE_OF_SPACE for row in self.best.values()):
            yield f"{EDGE_OF_SPACE.capitalize()}: [search] has no smaller cam, so no limit is active."
        if front.points == 1:
            return
        volume = f"{'' if front.exact else 'about '}{front.hypervolume:.6g}"
        if front.grid_points is not None:
            outside = "" if front.grid_hypervolume else " (all outside the box of the refined front)"
            volume += f"; of the grid's {front.grid_points:,} points, {front.grid_hypervolume:.6g}{outside}"
        yield f"Hypervolume of the Pareto front, as a share: {volume}"
        yield HYPERVOLUME_NOTE
        if knee := self.knee_table():
            yield ""
            yield knee

    def _robust_verdict_sections(self) -> Iterator[str]:
        """With ``search.robust``, the number of designs on the front for each verdict on all their cams."""
        counts = self.every_cam or {}
        verdicts = ", ".join(f"{n:,} {verdict}" for verdict, n in counts.items() if verdict != BROKEN)
        if verdicts:
            yield f"Every cam within the tolerances meets each limit: {verdicts}."
            if UNDECIDED in counts:
                yield "`certify` on the scene of a row names the undecided limit."
        if broken := counts.get(BROKEN):
            dropped = f"Dropped {broken:,} design{'s' * (broken != 1)}: a cam within the tolerances breaks a limit."
            yield f"{dropped} Designs that only these dominate may be missing."

    @property
    def notes(self) -> tuple[str, ...]:
        """Warnings, odd or unused keys of the scene, and objectives that are equal for all designs."""
        return (*self.warnings, *notes_on_search(self.scene))

    def values_for_json(self) -> dict[str, Any]:
        """Counts, files, the best designs and the front."""
        return {
            "scene": self.scene.name,
            "designs": self.designs,
            "evaluated": self.evaluated,
            "decided_by_boxes": self.decided_by_boxes,
            "impossible": self.impossible,
            "feasible": self.feasible,
            **undecided_and_recheck_counts(self.effort),
            "pareto": self.pareto,
            "front": self.front,
            "files": self.files,
            "best": next(iter(self.best.values()), None),
            "by_law": self.best,
            "nearest_miss": self.nearest_miss,
            **({} if self.every_cam is None else {"every_cam": self.every_cam}),
            **({"obstacle": self.obstacle} if self.obstacle else {}),
            **({"warnings": self.warnings} if self.warnings else {}),
        }

    @property
    def relative_half_width(self) -> float:
        """The largest relative half-width of an enclosure of any row kept."""
        return self.reached if self.pareto else 0.0

    @property
    def exit_code(self) -> int:
        """0; 1 without a feasible design; 4 where the accuracy is not reached."""
        return super().exit_code if self.pareto else NOTHING_FEASIBLE

    @property
    def shown_cam(self) -> Scene | None:
        """The scene of the best design, if there is only one."""
        return next(iter(self.best.values())).scene if len(self.best) == 1 else None

"""What a sweep found: counts, files, the best designs and the front."""

from dataclasses import dataclass
from pathlib import Path

from camopt.front.pareto import Front
from camopt.problem.problem import resolve
from camopt.quantities.shown import HasHtml
from camopt.scene.scene import Scene
from camopt.tables.columns import bounds_shown, columns_of, laws_shown, with_law
from camopt.tables.design_tables import designs_table
from camopt.tables.designs import Design
from camopt.tables.layout import Table, table_of
from camopt.verdicts.judging import Effort


@dataclass(frozen=True)
class Sweep(HasHtml):
    """The result of a sweep: counts, files, and the best designs.

    Attributes
    ----------
    scene : Scene
        What was asked.
    designs : int
        Designs of the space.
    impossible : int or None
        Designs that cannot be assembled, such as an offset beyond the prime radius; they are in no table. None
        where boxes of designs were decided together: nobody has counted them.
    feasible : int or None
        Feasible designs; None, too, where boxes were decided.
    effort : Effort
        Designs so near a limit that they were looked at again, and in balls; and those undecided even then, which
        are not feasible, and in no table but that of all.
    pareto : int
        Designs on the Pareto front.
    files : tuple of pathlib.Path
        What was written.
    best : dict
        The best feasible design of each law: least first objective, ties by the next. ``held_by`` names the
        limits that the next smaller cam of the space would exceed. Where boxes were decided, the best on the front.
    nearest_miss : Design or None
        Where nothing is feasible: the design with the least excess, and what it exceeds under ``violated``; of more
        than four million designs, that of some blocks, evenly spread.
    reached : float
        The largest relative half-width of an enclosure of any row kept.
    front : Front or None
        Hypervolume, ideal, nadir and knee of the Pareto front; None where nothing is feasible.
    obstacle : str
        Where no design can be put together, of those looked at for the nearest miss: the condition that they break.
        Where some of the trains that are searched cannot move as asked: how many, and why not the first of them.
    evaluated : int
        Designs that were evaluated, one by one.
    boxes : int
        Boxes of designs that were bounded; 0 where every design was evaluated.
    decided_by_boxes : int
        Designs in boxes that were dropped. A few of them were evaluated before.
    every_cam : dict of int or None
        With ``search.robust``: of how many designs of the front every cam within the tolerances holds the limits,
        proved over the whole box (``held``), or it is not known (``undecided``). A sweep looks at the corners of
        the tolerances; where a proof finds a cam between them that breaks a limit, that one counts too, and the
        sweep is done again. Designs that break a limit even then are left out (``broken``).
    already_done : bool
        Whether the result was in the folder already.

    Examples
    --------
    >>> search = {"base_radius": [60, 90, 120], "law": ["cycloidal"]}
    >>> swept = camopt.sweep(camopt.find_scene("roller-1000rpm").replace(search=search))
    >>> swept.feasible, swept.best["cycloidal"]["base_radius_mm"], swept.best["cycloidal"]["held_by"]
    (1, 120.0, 'pressure_angle')
    """

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

    def __repr__(self) -> str:
        feasible = "" if self.feasible is None else f" {self.feasible:,} feasible,"
        return (
            f"<Sweep of {self.scene.name}: {self.designs:,} designs,{feasible} {self.pareto:,} on the Pareto front>"
        )

    def table(self) -> Table | None:
        """The best design of each law."""
        if not self.best:
            return None
        rows, search = with_law(self.best.values()), self.scene.search
        where = " on the front" if self.feasible is None else ""
        if search.refine:
            where += " of the grid" if where else " on the grid"
        title = f"The best design{' of each law' if laws_shown(rows) else ''}{where}"
        return designs_table(title, resolve(self.scene), rows, ["held_by"], (*search.minimise, *search.maximise))

    def knee_table(self) -> Table | None:
        """The knee of the front, in the columns of ``table``."""
        if self.front is None or not self.best:
            return None
        knee, search, problem = [self.front.knee], self.scene.search, resolve(self.scene)
        columns = columns_of(problem, with_law(self.best.values()), (*search.minimise, *search.maximise))
        names = [*laws_shown(knee), *(name for name in columns if not name.startswith("law"))]
        return table_of("Its knee", with_law(knee), names, bounds_shown(problem))

    @property
    def shown_cam(self) -> Scene | None:
        """The best design, where there is one alone."""
        return next(iter(self.best.values())).scene if len(self.best) == 1 else None

"""The output of ``camopt sweep``."""

import camopt
from camopt.cli.terminal import print_json, show
from camopt.problem.problem import resolve
from camopt.problem.rows import finite
from camopt.problem.space import EDGE_OF_SPACE
from camopt.tables.columns import columns_of, with_law
from camopt.tables.design_tables import design_table
from camopt.verdicts.words import BROKEN, UNDECIDED


def show_sweep(result: "camopt.Sweep", as_json: bool) -> None:
    """Counts, the best design of each law, and the files."""
    if as_json:
        best = {law: finite(row) for law, row in result.best.items()}
        return print_json(
            {
                "scene": result.scene.name,
                "designs": result.designs,
                "evaluated": result.evaluated,
                "decided_by_boxes": result.decided_by_boxes,
                "impossible": result.impossible,
                "feasible": result.feasible,
                "undecided": result.effort.undecided,
                "looked_at_again": result.effort.again,
                "decided_in_balls": result.effort.balls - result.effort.undecided,
                "pareto": result.pareto,
                "front": result.front.to_dict() if result.front else None,
                "files": [str(file) for file in result.files],
                "best": next(iter(best.values()), None),
                "by_law": best,
                "nearest_miss": finite(result.nearest_miss) if result.nearest_miss else None,
                **({} if result.every_cam is None else {"every_cam": result.every_cam}),
                **({"obstacle": result.obstacle} if result.obstacle else {}),
            }
        )
    undecided = f"{result.effort.undecided:,} undecided, " if result.effort.undecided else ""
    pareto = f"{result.pareto:,} on the Pareto front"
    designs = f"{result.designs:,} design{'s' * (result.designs != 1)}"
    show(f"{result.scene.name}: {designs}, {_counts(result)}{undecided}{pareto}")
    if result.obstacle and (result.best or result.nearest_miss):
        show(f"Not to be assembled: {result.obstacle}.")
    if result.best:
        show("", result.table())
        _show_front(result)
        if result.every_cam:
            told = ", ".join(f"{verdict} of {n:,}" for verdict, n in result.every_cam.items() if verdict != BROKEN)
            if told:
                what = "That every cam within the tolerances holds each limit, over the whole box"
                which = "camopt certify pareto.parquet --row N tells which limit of a design is undecided."
                show(f"{what}: {told} on the front.{' ' + which if UNDECIDED in result.every_cam else ''}")
            if broken := result.every_cam.get(BROKEN):
                left = f"Left out {broken:,} design{'s' * (broken != 1)} of which a cam within the tolerances"
                show(f"{left} breaks a limit; others that only these dominate may be missing.")
    elif result.nearest_miss:
        show_miss(result.nearest_miss)
    elif result.impossible is not None:
        show(f"No design can be assembled: {result.obstacle}.")
    else:
        show(f"No feasible design. Of those looked at, none can be assembled: {result.obstacle}.")
    return None


def show_part(result: "camopt.SweepPart", as_json: bool) -> None:
    """Counts of a part of a sweep."""
    if as_json:
        return print_json(
            {
                "scene": result.scene.name,
                "part": result.part,
                "parts": result.parts,
                "designs": result.designs,
                "impossible": result.impossible,
                "feasible": result.feasible,
                "undecided": result.effort.undecided,
                "looked_at_again": result.effort.again,
                "decided_in_balls": result.effort.balls - result.effort.undecided,
                "files": [str(result.file)],
            }
        )
    where = f"part {result.part} of {result.parts}"
    show(f"{result.scene.name}, {where}: {result.designs:,} designs, {result.feasible:,} feasible")
    return None


def _counts(result: "camopt.Sweep") -> str:
    """The numbers of impossible and feasible designs; or, if not counted, how the front was found."""
    if result.feasible is None:
        return f"{result.decided_by_boxes:,} decided by boxes, {result.evaluated:,} evaluated, "
    return f"{result.impossible:,} impossible, {result.feasible:,} feasible, "


def _show_front(result: "camopt.Sweep") -> None:
    """How much the front dominates, and its knee; what a single best design leaves to say is nothing."""
    front = result.front
    assert front is not None
    if any(row["held_by"] == EDGE_OF_SPACE for row in result.best.values()):
        show(f"{EDGE_OF_SPACE.capitalize()}: [search] has no smaller cam that could break a limit.")
    if front.points == 1:
        return
    volume = f"{'' if front.exact else 'about '}{front.hypervolume:.6g}"
    if front.grid_points is not None:
        outside = "" if front.grid_hypervolume else ", for all lie outside the box of the refined front"
        volume += f"; of the grid's {front.grid_points:,} points, {front.grid_hypervolume:.6g}{outside}"
    show(f"Hypervolume of the Pareto front, as a share: {volume}")
    show(
        "It compares fronts of the same objectives: the more of their space is beaten by some design, the nearer 1."
    )
    show("", result.knee_table())


def show_miss(miss: "camopt.Design", found: str = "No feasible design. The nearest miss:") -> None:
    """The design that comes nearest to holding every limit: its sizes, and each limited value beside its limit."""
    problem = resolve(miss.searched)
    (row,) = with_law([miss])
    violated = miss["violated"].split(",")
    broken = {name for limit in problem.limits if limit.name in violated for name in limit.shown}
    about = {name: "broken" if name in broken else "" for name in columns_of(problem, [row])}
    show("", design_table(found, problem, row, about))
    others = "It holds the limits; a cam within its tolerances does not."
    undecided = others if problem.zones else "It is so near its limits that neither side is proved."
    it = "It, or a cam within its tolerances, breaks" if problem.zones else "It breaks"
    show("", f"{it} {', '.join(violated)}." if miss["violated"] else undecided)

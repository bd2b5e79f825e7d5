"""How results show themselves in a notebook: tables as HTML, designs with a small picture of the cam."""

from collections.abc import Callable, Iterable, Mapping
from functools import singledispatch
from html import escape
from typing import Any

from camopt.drawing.small import small_cam
from camopt.front.sweep import Sweep
from camopt.measured.fitted import Fit
from camopt.mistakes import BadInput
from camopt.problem.problem import resolve
from camopt.quantities import QUANTITIES
from camopt.scene.scene import Scene
from camopt.shown import Shown
from camopt.smallest.optimise import Optimum
from camopt.synthesis.frontier import Frontier
from camopt.synthesis.synthesised import Synthesis
from camopt.synthesis.units import unit_of
from camopt.tables.cells import heading, number
from camopt.tables.columns import bounds_of, columns_of, is_nothing, laws_shown, sizes_shown, with_law
from camopt.tables.designs import Design
from camopt.tables.html import html_table
from camopt.verdicts.evaluation import Evaluation

Row = Mapping[str, Any]


@singledispatch
def html_of(result: Shown) -> str:
    """How a notebook shows a result."""
    raise NotImplementedError(type(result).__name__)


@html_of.register
def _of_a_scene(scene: Scene) -> str:
    """What the scene is, its TOML to unfold, and its cam if it has sizes of its own."""
    unfolded = f"<details><summary>TOML</summary><pre>{escape(scene.to_toml())}</pre></details>"
    return _beside_the_cam(f"<div><b>{escape(repr(scene))}</b>{unfolded}</div>", lambda: scene)


@html_of.register
def _of_an_evaluation(result: Evaluation) -> str:
    """Every quantity with its unit, limit and meaning, a row each."""
    names = [name for name in result if not is_nothing(result.scene.search.sizes, name, [result])]
    table = _down(result.scene.name, result.scene, result, names, result.unbounded)
    return _beside_the_cam(table, lambda: result.scene)


@html_of.register
def _of_a_design(design: Design) -> str:
    """The sizes of a design and what its scene asks, beside the limits."""
    (row,) = with_law([design])
    table = _down(design.searched.name, design.searched, row, columns_of(resolve(design.searched), [row]), {})
    return _beside_the_cam(table, lambda: design.scene)


@html_of.register
def _of_an_optimum(result: Optimum) -> str:
    """The smallest cam of each law, and the smallest of all as a picture."""
    each = " of each law" if laws_shown(result.by_law.values()) else ""
    title, best = f"{result.scene.name}: the smallest cam{each}", result.best
    table = _designs(title, result.scene, result.by_law.values(), (), "binding")
    return table if best is None else _beside_the_cam(table, lambda: best.scene)


@html_of.register
def _of_a_sweep(result: Sweep) -> str:
    """The best design of each law."""
    asked = (*result.scene.search.minimise, *result.scene.search.maximise)
    table = _designs(_title(result), result.scene, result.best.values(), asked, "held_by")
    one = [design.scene for design in result.best.values()] if len(result.best) == 1 else []
    return _beside_the_cam(table, lambda: one[0]) if one else table


@html_of.register
def _of_a_synthesis(result: Synthesis) -> str:
    """The smallest cam of the free laws."""
    return _beside_the_cam(
        _designs(_title(result), result.scene, [result.design], (), "binding"), lambda: result.scene
    )


@html_of.register
def _of_a_frontier(result: Frontier) -> str:
    """The cams of free laws, the axes first."""
    if not result.rows:
        return f"<b>{escape(_title(result))}</b>"
    sizes = sizes_shown(result.scene.search.sizes, result.rows)
    names = [*result.axes, "bound", *(name for name in sizes if not name.startswith("law"))]
    units = {axis: unit_of(axis, result.scene) for axis in result.axes}
    units["bound"] = units[result.axes[0]]
    rows = [["" if row[name] is None else _text(row[name]) for name in names] for row in result.rows]
    return html_table(_title(result), [heading(name, units.get(name)).split("\n") for name in names], rows)


@html_of.register
def _of_a_fit(result: Fit) -> str:
    """How the motion lies in the points, and its peaks beside those of plain differences."""
    lengths = {
        "noise": result.noise,
        "band": result.band,
        "largest deviation": result.deviation.largest,
        "root mean square deviation": result.deviation_rms,
    }
    rows = [("points", str(result.points.angles.size), "")]
    rows += [(name, number(value), result.unit) for name, value in lengths.items()]
    jerk = QUANTITIES[result.quantity("jerk")].unit
    rows += [("root mean square jerk", number(result.jerk_rms), jerk)]
    rows += [("the least of any motion", number(result.least_jerk_rms), jerk)]
    for name, value in result.after.items():
        rows.append((f"largest {name}", number(value), QUANTITIES[result.quantity(name)].unit))
    return _beside_the_cam(html_table(_title(result), [], rows), lambda: result.scene)


def _title(result: Shown) -> str:
    """What a result says of itself in a line."""
    return repr(result).removeprefix("<").removesuffix(">")


def _designs(title: str, scene: Scene, designs: Iterable[Row], asked: Iterable[str], last: str) -> str:
    """A row for each design: what the scene asks, and one column of names at the end."""
    problem, rows = resolve(scene), with_law(designs)
    if not rows:
        return f"<b>{escape(title)}</b>"
    names, bounds = [*columns_of(problem, rows, asked), last], bounds_of(problem)
    heads = [[*heading(name).split("\n"), bounds.get(name, "")] for name in names]
    return html_table(title, heads, [[_text(row.get(name, "")) for name in names] for row in rows])


def _beside_the_cam(table: str, scene_of: Callable[[], Scene]) -> str:
    """A table with the picture of a cam on its right, if there is such a cam."""
    try:
        cam = small_cam(scene_of())
    except BadInput:  # sizes that no scene has: the table shows them all the same
        cam = ""
    return f'<div style="display: flex; flex-wrap: wrap; gap: 2em">{table}{cam}</div>' if cam else table


def _down(title: str, scene: Scene, row: Row, names: Iterable[str], why: Mapping[str, str]) -> str:
    bounds = bounds_of(resolve(scene))
    about = {name: QUANTITIES.get(name) for name in names}
    cells = [
        [name, _text(row[name]), q.unit if q else "", bounds.get(name, ""), why.get(name, q.sentence if q else "")]
        for name, q in about.items()
    ]
    return html_table(title, [], cells)


def _text(value: Any) -> str:
    return ", ".join(value) if isinstance(value, list) else number(value)

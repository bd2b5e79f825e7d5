"""How results show themselves in a notebook: tables as HTML, designs with a small picture of the cam."""

from collections.abc import Callable, Iterable, Mapping
from functools import singledispatch
from html import escape
from typing import Any

from camopt.drawing.small import small_cam
from camopt.front.sweep import Sweep
from camopt.mistakes import BadInput
from camopt.problem.problem import resolve
from camopt.quantities import QUANTITIES
from camopt.scene.scene import Scene
from camopt.shown import Shown
from camopt.smallest.optimise import Optimum
from camopt.tables.cells import heading, number
from camopt.tables.columns import bounds_of, columns_of, is_nothing, laws_shown, with_law
from camopt.tables.designs import Design
from camopt.verdicts.evaluation import Evaluation

Row = Mapping[str, Any]


@singledispatch
def html_of(result: Shown) -> str:
    """How a notebook shows a result."""
    raise NotImplementedError(type(result).__name__)


@html_of.register
def _of_a_scene(scene: Scene) -> str:
    """What the scene is, and its TOML to unfold."""
    unfolded = f"<details><summary>TOML</summary><pre>{escape(scene.to_toml())}</pre></details>"
    return f"<b>{escape(repr(scene))}</b>{unfolded}"


@html_of.register
def _of_an_evaluation(result: Evaluation) -> str:
    """Every quantity with its unit, limit and meaning, a row each."""
    names = [name for name in result if not is_nothing(result.scene, name, [result])]
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
    return _designs(repr(result).strip("<>"), result.scene, result.best.values(), asked, "held_by")


def _designs(title: str, scene: Scene, designs: Iterable[Row], asked: Iterable[str], last: str) -> str:
    """A row for each design: what the scene asks, and one column of names at the end."""
    problem, rows = resolve(scene), with_law(designs)
    if not rows:
        return f"<b>{escape(title)}</b>"
    names, bounds = [*columns_of(problem, rows, asked), last], bounds_of(problem)
    heads = [[*heading(name).split("\n"), bounds.get(name, "")] for name in names]
    cells = [[escape(_text(row.get(name, ""))) for name in names] for row in rows]
    return _table(title, [[*map(escape, head)] for head in heads], cells)


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
    return _table(title, [], [[escape(text) for text in line] for line in cells])


def _text(value: Any) -> str:
    return ", ".join(value) if isinstance(value, list) else number(value)


def _table(title: str, heads: list[list[str]], cells: list[list[str]]) -> str:
    head = "".join(f"<th>{'<br>'.join(lines)}</th>" for lines in heads)
    body = "".join(f"<tr>{''.join(f'<td>{text}</td>' for text in line)}</tr>" for line in cells)
    caption = f"<caption>{escape(title)}</caption>"
    return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"

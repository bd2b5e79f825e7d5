"""How results show themselves in a notebook: their table as HTML, with a small picture of the cam."""

from dataclasses import replace
from html import escape

from camopt.drawing.small import small_cam
from camopt.mistakes import BadInput
from camopt.quantities.shown import HasHtml
from camopt.scene.scene import Scene
from camopt.tables.html import html_table


def html_of(result: HasHtml) -> str:
    """How a notebook shows a result: its table, and on its right its cam, if it has one."""
    text = _unfolded(result) if isinstance(result, Scene) else _table(result)
    try:
        cam = small_cam(result.shown_cam) if result.shown_cam else ""
    except BadInput:  # sizes that no scene has: the table shows them all the same
        cam = ""
    return f'<div style="display: flex; flex-wrap: wrap; gap: 2em">{text}{cam}</div>' if cam else text


def _table(result: HasHtml) -> str:
    table = result.table()
    said = repr(result)[1:-1]
    return f"<b>{escape(said)}</b>" if table is None else html_table(replace(table, title=said))


def _unfolded(scene: Scene) -> str:
    """A description of a scene, with its TOML to unfold."""
    unfolded = f"<details><summary>TOML</summary><pre>{escape(scene.to_toml())}</pre></details>"
    return f"<div><b>{escape(repr(scene))}</b>{unfolded}</div>"

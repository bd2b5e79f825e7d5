"""How results show themselves in a notebook: their tables as HTML, with a small picture of the cam."""

from dataclasses import replace
from html import escape
from typing import Any

from camopt.drawing.small import small_cam
from camopt.mistakes import BadInput
from camopt.quantities.shown import HasHtml
from camopt.tables.html import html_section, html_table
from camopt.tables.layout import Table
from camopt.tables.result import Result


def html_of(result: HasHtml) -> str:
    """How a notebook shows a result: its tables and sentences, and on its right its cam, if it has one."""
    text = _sections(result) if isinstance(result, Result) else _unfolded(result)
    try:
        cam = small_cam(result.shown_cam) if result.shown_cam else ""
    except BadInput:  # sizes that no scene has: the table shows them all the same
        cam = ""
    return f'<div style="display: flex; flex-wrap: wrap; gap: 2em">{text}{cam}</div>' if cam else text


def _sections(result: Result) -> str:
    """The tables and the sentences of a result under its name."""
    name, *rest = repr(result)[1:-1], *filter(None, result.sections())
    if rest and isinstance(rest[0], Table):
        first, *rest = rest
        head = html_table(replace(first, title=name))
    else:
        head = f"<b>{escape(name)}</b>"
    return f"<div>{head}{''.join(map(html_section, rest))}</div>"


def _unfolded(scene: Any) -> str:
    """A description of a scene, with its TOML to unfold."""
    unfolded = f"<details><summary>TOML</summary><pre>{escape(scene.to_toml())}</pre></details>"
    return f"<div><b>{escape(repr(scene))}</b>{unfolded}</div>"

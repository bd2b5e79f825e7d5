"""The page as text: templates filled, style and program inside, nothing from anywhere else.

What is filled in is escaped (Jinja), data are JSON that closes no element, and a content security policy lets the
browser run this one program and fetch nothing: a name in a scene stays text.
"""

import json
import zlib
from base64 import b64encode
from collections.abc import Mapping
from functools import cache
from hashlib import sha256
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from camopt.core.storage.version import VERSION
from camopt.solve.tables.html import html_table
from camopt.solve.tables.result import Table

CAM_SCRIPTS = ("geometry", "drawing", "cam", "diagrams", "player", "theme", "printing")
PAGE_SCRIPTS = {
    "cams": (*CAM_SCRIPTS, "cams_page", "start"),
    "results": (*CAM_SCRIPTS, "rows", "scatter", "parallel", "tables", "grid", "results_page", "start"),
    "serve": (*CAM_SCRIPTS, "tables", "controls", "asking", "serve_page", "start"),
}
"""The parts of the program of each kind of page, in the order in which they need each other."""


def render_page(kind: str, title: str, data: Mapping[str, Any], **more: Any) -> str:
    """A page of a kind in ``PAGE_SCRIPTS``: its title, the data of its program, the content of its template."""
    style, script = _asset_text("page.css"), "\n".join(_asset_text(f"{part}.js") for part in PAGE_SCRIPTS[kind])
    text = json.dumps({"page": kind, **data}, allow_nan=False, ensure_ascii=True, separators=(",", ":"))
    for sign in "<>&":  # or the text could close its element, or open another
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return str(
        _templates()
        .get_template(f"{kind}.html")
        .render(
            title=title,
            version=VERSION,
            style=Markup(style),
            script=Markup(script),
            style_hash=Markup(_content_hash(style)),
            script_hash=Markup(_content_hash(script)),
            data=Markup(text),
            **more,
        )
    )


@cache
def _templates() -> Any:
    made = Environment(
        loader=PackageLoader("camopt.show.reporting"), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    made.globals["html_table"] = _table_html
    return made


def _table_html(table: Table | Mapping[str, Any]) -> Any:
    """A table as HTML, all rows of it; or one as an answer to a page has it, a mapping."""
    whole = table if isinstance(table, Table) else Table(**table)
    return Markup(html_table(whole, len(whole.rows)))


@cache
def _asset_text(name: str) -> str:
    return (files("camopt.show.reporting") / "assets" / name).read_text(encoding="utf-8")


def _content_hash(text: str) -> str:
    return f"sha256-{b64encode(sha256(text.encode()).digest()).decode()}"


def deflate_to_text(data: bytes) -> str:
    """Bytes as a page holds them: deflated, in base64."""
    return b64encode(zlib.compress(data, 9)).decode()


def data_url(data: bytes, kind: str) -> str:
    """A file inside the page, as an address."""
    return f"data:{kind};base64,{b64encode(data).decode()}"

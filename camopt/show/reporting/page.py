"""HTML pages: templates filled with data, with style and program inside the file.

Text from a scene stays text: Jinja escapes it, and the JSON data cannot close their element. A content security
policy lets the browser run only the program of the page and fetch nothing.
"""

import json
import zlib
from base64 import b64encode
from collections.abc import Mapping
from functools import cache
from hashlib import sha256
from importlib.resources import files
from io import BytesIO
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from camopt.core.storage.version import VERSION
from camopt.solve.tables.html import html_table
from camopt.solve.tables.result import Table

CAM_SCRIPTS = ("geometry", "drawing", "cam", "diagrams", "player", "theme", "printing")
SERVED_SCRIPTS = ("tables", "controls", "requests", "served_page")
PAGE_SCRIPTS = {
    "cams": (*CAM_SCRIPTS, "cams_page", "start"),
    "machine": (*CAM_SCRIPTS, "machine_page", "start"),
    "serve_machine": (*CAM_SCRIPTS, "machine_page", *SERVED_SCRIPTS, "serve_machine", "start"),
    "results": (*CAM_SCRIPTS, "rows", "scatter", "parallel", "tables", "grid", "results_page", "start"),
    "serve": (*CAM_SCRIPTS, *SERVED_SCRIPTS, "serve_page", "start"),
}
"""Scripts of each kind of page; each script uses only earlier ones."""


DOTS_PER_INCH = 110
"""Dots of pictures on a page."""


def render_page(kind: str, title: str, data: Mapping[str, Any], **template_values: Any) -> str:
    """The HTML of a page of a kind in ``PAGE_SCRIPTS``: ``data`` for its scripts, values for its template."""
    style, script = _asset_text("page.css"), "\n".join(_asset_text(f"{part}.js") for part in PAGE_SCRIPTS[kind])
    text = json.dumps({"page": kind, **data}, allow_nan=False, ensure_ascii=True, separators=(",", ":"))
    for sign in "<>&":  # else the text could close its element or open another
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return str(
        TEMPLATES.get_template(f"{kind}.html").render(
            title=title,
            version=VERSION,
            style=Markup(style),
            script=Markup(script),
            style_hash=Markup(_content_hash(style)),
            script_hash=Markup(_content_hash(script)),
            data=Markup(text),
            served="served_page" in PAGE_SCRIPTS[kind],
            **template_values,
        )
    )


def _table_html(table: Table | Mapping[str, Any]) -> Markup:
    """All rows of a table as HTML; the table may be a mapping, as in an answer of the server."""
    whole = table if isinstance(table, Table) else Table(**table)
    return Markup(html_table(whole, len(whole.rows)))


TEMPLATES = Environment(
    loader=PackageLoader("camopt.show.reporting"), autoescape=True, undefined=StrictUndefined, trim_blocks=True
)
TEMPLATES.globals["html_table"] = _table_html


@cache
def _asset_text(name: str) -> str:
    return (files("camopt.show.reporting") / "assets" / name).read_text(encoding="utf-8")


def _content_hash(text: str) -> str:
    return f"sha256-{b64encode(sha256(text.encode()).digest()).decode()}"


def deflate_to_base64(data: bytes) -> str:
    """Bytes deflated, in base64."""
    return b64encode(zlib.compress(data, 9)).decode()


def data_url(data: bytes, media_type: str) -> str:
    """A data URL that holds a file."""
    return f"data:{media_type};base64,{b64encode(data).decode()}"


def figure_url(figure: Any) -> str:
    """A data URL that holds a picture."""
    file = BytesIO()
    figure.savefig(file, format="png", dpi=DOTS_PER_INCH)
    return data_url(file.getvalue(), "image/png")

"""Parts of pages that are made from the code: each line `<!-- made: NAME -->` of a page stands for one.

Quantities, keys and laws are objects of the site: the search finds them, and {quantity}`NAME`, {key}`NAME` and
{law}`NAME` lead to them.
"""

import re
from collections.abc import Callable, Iterable
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.domains.std import GenericObject

from . import columns, keys, laws, rooms, scenes

MADE: dict[str, Callable[[], Iterable[str]]] = {
    "keys": keys.of_scene,
    "limits": keys.of_limits,
    "materials": keys.materials,
    "quantities": columns.of_effects,
    "symbols": columns.symbols,
    "mechanisms": columns.mechanisms,
    "laws": laws.all_laws,
    "law-peaks": laws.peaks,
    "scenes": scenes.shipped,
    "rooms": rooms.of_package,
    "exits": rooms.exit_codes,
    "points": columns.of_points,
}
MARK = re.compile(r"^<!-- made: ([a-z-]+) -->$", re.MULTILINE)


def fill(app: Sphinx, name: str, source: list[str]) -> None:
    """Put the parts into a page as it is read."""
    source[0] = MARK.sub(lambda mark: "\n".join(MADE[mark[1]]()), source[0])


def write(app: Sphinx) -> None:
    """What other extensions read as files: pictures of laws, and the list of public names."""
    folder = Path(app.srcdir) / "reference"
    for name in ("pictures", "python"):
        (folder / name).mkdir(exist_ok=True)
    laws.draw(folder / "pictures")
    (folder / "python" / "index.rst").write_text("\n".join(rooms.public_names()), encoding="utf-8")


class Named(GenericObject):
    """An object that may have several names, separated by commas."""

    def get_signatures(self) -> list[str]:
        return [str(name) for name in self.arguments[0].split(", ")]


def setup(app: Sphinx) -> dict[str, bool]:
    for name in ("quantity", "key", "law"):
        app.add_object_type(name, name, objname=name)
        app.add_directive_to_domain("std", name, type(name, (Named,), {}), override=True)
    app.connect("builder-inited", write, priority=100)  # before autosummary reads the list
    app.connect("source-read", fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""Parts of pages that are made from the code: each stands between `<!-- made: NAME -->` and `<!-- made -->`.

They are kept in the pages, so that a checkout has them; `docs/make.py` makes them anew. Pictures are made with
the site.

Quantities, keys and laws are objects of the site: the search finds them, and {quantity}`NAME`, {key}`NAME` and
{law}`NAME` lead to them.
"""

import re
from collections.abc import Callable, Iterable
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.domains.std import GenericObject

from . import columns, keys, laws, package, scenes

DOCS = Path(__file__).parents[2]
MADE: dict[str, Callable[[], Iterable[str]]] = {
    "keys": keys.of_scene,
    "machine-keys": keys.of_machine,
    "limits": keys.of_limits,
    "materials": keys.materials,
    "quantities": columns.of_effects,
    "symbols": columns.symbols,
    "mechanisms": columns.mechanisms,
    "laws": laws.all_laws,
    "law-peaks": laws.peaks,
    "folders": package.folders_and_parts,
    "exits": package.exit_codes,
    "points": columns.of_points,
}
MARK = re.compile(r"^<!-- made: ([a-z-]+) -->\n.*?^<!-- made -->$", re.MULTILINE | re.DOTALL)
DRAWN = {"<!-- drawn: scenes -->": scenes.shipped, "<!-- drawn: machines -->": scenes.shipped_with_stations}


def filled(page: str) -> str:
    """A page with its parts as the code has them now."""
    return MARK.sub(lambda mark: "\n".join([f"<!-- made: {mark[1]} -->", *MADE[mark[1]](), "<!-- made -->"]), page)


def pages() -> dict[Path, str]:
    """The pages that have such parts, as they should be."""
    texts = {path: path.read_text(encoding="utf-8") for path in sorted(DOCS.rglob("*.md"))}
    return {path: filled(text) for path, text in texts.items() if MARK.search(text)}


def fill(app: Sphinx, name: str, source: list[str]) -> None:
    """Put the shipped scenes and machines into the page as it is read."""
    for mark, cards in DRAWN.items():
        if mark in source[0]:
            source[0] = source[0].replace(mark, "\n".join(cards()))


def write(app: Sphinx) -> None:
    """What other extensions read as files: pictures of laws, and the list of public names."""
    folder = Path(app.srcdir) / "reference"
    for name in ("pictures", "python"):
        (folder / name).mkdir(exist_ok=True)
    laws.draw(folder / "pictures")
    (folder / "python" / "index.rst").write_text("\n".join(package.public_names()), encoding="utf-8")


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

"""The gallery's eye for camopt's own figures, which pyplot does not know of."""

from typing import Any

from sphinx_gallery.scrapers import figure_rst

from camopt.drawing.sheet import Sheet

DPI = 110


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """The figure that the last expression of a block gives, and those that it names, each drawn once."""
    seen: list[Sheet] = block_vars.setdefault("sheets", [])
    values = block_vars["example_globals"].values()
    found = {id(value): value for value in values if isinstance(value, Sheet) and value not in seen}
    seen += found.values()
    paths = []
    for sheet, path in zip(found.values(), block_vars["image_path_iterator"], strict=False):
        sheet.savefig(path, dpi=DPI)
        paths.append(path)
    return figure_rst(paths, gallery_conf["src_dir"])

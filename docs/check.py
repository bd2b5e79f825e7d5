"""Checks the built site: links lead somewhere, no page asks another host, and what readers look for is near.

`python docs/check.py FOLDER` prints each mistake, and ends with 1 if there is one.
"""

import re
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote, urlsplit

LOADED = {
    "script": "src",
    "img": "src",
    "link": "href",
    "iframe": "src",
    "source": "src",
    "video": "src",
    "object": "data",
}
"""What a browser fetches of its own accord, by element."""
CLICKS = 3
SOUGHT = {
    "the meaning of a column": "reference/quantities.html#quantity-pressure_angle_max_deg",
    "the equation behind it": "reference/mechanisms.html#mechanism-translating",
    "a key of the scene": "reference/scene.html#key-follower.dynamics.mass",
    "a motion law": "reference/laws.html#law-cycloidal",
    "how to add a law": "architecture.html#add-a-motion-law",
    "how to import measured lift": "how-to/import-measured-lift.html",
}


class Page(NamedTuple):
    """What is on a page."""

    anchors: set[str]
    links: list[str]
    loaded: list[str]


class Reader(HTMLParser):
    """Collects what is on a page."""

    def __init__(self) -> None:
        super().__init__()
        self.page = Page({""}, [], [])

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.page.anchors.update(given[name] for name in ("id", "name") if name in given)
        if address := given.get({"a": "href", "form": "action"}.get(tag, "")):
            self.page.links.append(address)
        if (address := given.get(LOADED.get(tag, ""))) and given.get("rel") != "canonical":
            self.page.loaded.append(address)


def read(path: Path) -> Page:
    """A page of the site."""
    reader = Reader()
    reader.feed(path.read_text(encoding="utf-8"))
    return reader.page


def is_outside(address: str) -> bool:
    """Whether an address names a host, or is not one of a page."""
    parts = urlsplit(address)
    return bool(parts.scheme or parts.netloc)


def target(site: Path, page: str, address: str) -> tuple[str, str]:
    """The file, from the root of the site, and the anchor that a link on a page leads to."""
    parts = urlsplit(address)
    file = (site / page).parent / unquote(parts.path) if parts.path else site / page
    return file.resolve().relative_to(site).as_posix(), unquote(parts.fragment)


def mistakes(site: Path) -> Iterator[str]:  # noqa: C901
    """Everything that is wrong with the site."""
    pages = {path.relative_to(site).as_posix(): read(path) for path in sorted(site.rglob("*.html"))}
    pages = {name: page for name, page in pages.items() if not name.startswith("_")}
    for sheet in sorted(site.rglob("*.css")):
        for address in re.findall(
            r"(?:url\(|@import)\s*['\"]?((?:https?:)?//[^'\")\s]+)", sheet.read_text(encoding="utf-8")
        ):
            yield f"{sheet.relative_to(site)}: asks another host for {address}"
    leads: dict[str, set[str]] = {}
    for name, page in pages.items():
        for address in page.loaded:
            if urlsplit(address).scheme not in ("", "data") or urlsplit(address).netloc:
                yield f"{name}: asks another host for {address}"
            elif not urlsplit(address).scheme and not (site / target(site, name, address)[0]).is_file():
                yield f"{name}: nothing at {address}"
        inside = [target(site, name, address) for address in page.links if not is_outside(address)]
        for file, anchor in inside:
            if not (site / file).is_file():
                yield f"{name}: a link leads to {file}, which is not there"
            elif file in pages and anchor not in pages[file].anchors:
                yield f"{name}: a link leads to {file}#{anchor}, which is not there"
        leads[name] = {file for file, _ in inside}
    far = distances(leads)
    for what, address in SOUGHT.items():
        file, _, anchor = address.partition("#")
        if file not in pages or anchor not in pages[file].anchors:
            yield f"{what}: {address} is not there"
        elif far.get(file, CLICKS + 1) > CLICKS:
            yield f"{what}: {file} is more than {CLICKS} clicks from the front page"
    yield from (f"{name}: no link leads there" for name in pages if name not in far)


def distances(leads: dict[str, set[str]]) -> dict[str, int]:
    """How many clicks each page is from the front page, by links in any of its parts."""
    far, edge = {"index.html": 0}, ["index.html"]
    while edge:
        here = edge.pop(0)
        for file in sorted(leads.get(here, set()) - far.keys()):
            far[file] = far[here] + 1
            edge.append(file)
    return far


if __name__ == "__main__":
    found = list(mistakes(Path(sys.argv[1]).resolve()))
    print("\n".join(found) or "the site: links, hosts and ways to what readers look for are in order")
    sys.exit(bool(found))

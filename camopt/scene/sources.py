"""What scenes are read of: the text of a file or of a shipped scene, and the files that it names."""

import tomllib
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from camopt.mistakes import BadInput
from camopt.storage.files import read_bytes, text_of
from camopt.storage.manifest import settled_path

SHIPPED = Path(__file__).parent / "shipped"
SCHEMA = "scene.schema.json"
"""The file beside this one that ``camopt.scene.schema`` makes."""


@cache
def shipped_scenes() -> tuple[str, ...]:
    """The names of the scenes that come with the package.

    Returns
    -------
    tuple
        For ``find_scene`` and for all commands.

    Examples
    --------
    >>> "exhaust-valve" in camopt.shipped_scenes()
    True
    """
    return tuple(sorted(path.stem for path in SHIPPED.glob("*.toml")))


def shipped_toml(name: str) -> str:
    """The text of a shipped scene, without the line that leads from there to the schema."""
    return (SHIPPED / f"{name}.toml").read_text(encoding="utf-8").removeprefix(f"#:schema ../{SCHEMA}\n")


def sources(name: str) -> Iterator[bytes]:
    """The text of a scene, and what is in each file that a text in it may name: who gets the same, gets the scene.

    Of what is no file it is nothing.

    Raises
    ------
    OSError
        If it cannot be read.
    BadInput
        If it is too long.
    ValueError
        If it is no TOML.
    """
    if name in shipped_scenes():
        yield shipped_toml(name).encode()
        return
    path = settled_path(Path(name))
    if not path.is_file():
        return
    text = read_bytes(path)
    yield text
    for named in _texts(tomllib.loads(text_of(text))):
        yield _content(Path(name).parent / named)


def _texts(value: Any) -> Iterator[str]:
    """All texts in tables and lists."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, (dict, list)):
        for each in value.values() if isinstance(value, dict) else value:
            yield from _texts(each)


def _content(path: Path) -> bytes:
    """What is in a file; nothing if there is none that can be read."""
    with suppress(OSError, BadInput):
        return read_bytes(path)
    return b""

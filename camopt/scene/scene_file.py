"""Write a scene as a file: the text it was read from, with the changed values.

The new file keeps the order, comments, units and spelling of the old one. If the old text is gone, or would give
another scene, the scene is written plainly.
"""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from camopt.core.mistakes import BadInput
from camopt.core.storage.files import decode_user_text, read_bytes, write_text
from camopt.scene.scene import Scene, find_scene
from camopt.scene.sources import shipped_scenes, shipped_toml

LONGEST_TEXT = 100_000  # characters: longer texts are tables of numbers, whose order is not kept


def write_scene(path: Path, scene: Scene) -> None:
    """Write a scene as TOML, including the data it read from other files."""
    write_text(path, text_of_scene(scene))


def text_of_scene(scene: Scene) -> str:
    """The scene as TOML text that reads back as an equal scene, with the order and comments of its file."""
    import tomlkit  # noqa: PLC0415, most commands write no scene

    with suppress(BadInput, OSError, ValueError, LookupError):  # tomlkit fails on some tables out of order
        if scene.file in shipped_scenes():
            source = shipped_toml(scene.file)
        else:
            source = decode_user_text(read_bytes(scene.file)) if Path(scene.file).suffix == ".toml" else ""
        if 0 < len(source) <= LONGEST_TEXT:
            document = tomlkit.parse(source)
            old, new = find_scene(scene.file).to_dict(), scene.to_dict()
            document.setdefault("name", new["name"])
            _update_table(document, old, new)
            text = tomlkit.dumps(document).rstrip("\n") + "\n"
            if Scene.embedded(text, scene.file).to_dict() == new:
                return text
    return scene.to_toml()


def _update_table(table: Any, old: Mapping[str, Any], new: Mapping[str, Any]) -> None:
    """Set the values of ``new`` that differ from ``old`` in a table of a text; data replace names of files."""
    for key in [each for each in old if each not in new]:
        table.pop(key, None)
    for key, value in new.items():
        before: Any = old.get(key)
        written = table.get(key)
        if isinstance(value, dict) and isinstance(before, dict) and isinstance(written, dict):
            _update_table(written, before, value)
        elif (
            _is_list_of_tables(value)
            and _is_list_of_tables(before)
            and _is_list_of_tables(written)
            and len(value) == len(written)
        ):
            for rows in zip(written, before, value, strict=True):
                _update_table(*rows)
        elif value != before or (isinstance(written, str) and isinstance(value, list)):
            table[key] = _item_with_blank_line(value) if written is None else value


def _item_with_blank_line(value: Any) -> Any:
    """A new value of a text; a table gets an empty line after it."""
    import tomlkit  # noqa: PLC0415, as above

    item = tomlkit.item(value)
    if isinstance(value, dict):
        item.add(tomlkit.nl())
    return item


def _is_list_of_tables(value: Any) -> bool:
    """Whether a value is a list of tables."""
    return isinstance(value, list) and bool(value) and all(isinstance(row, dict) for row in value)

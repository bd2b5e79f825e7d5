"""Scenes for commands: read from the name that a user gives, and changed by options."""

from pathlib import Path
from typing import Any

from camopt.cli.options import Changes, changed_values_by_key, name_options_in_mistakes, scene_with_changes
from camopt.core.mistakes import BadInput, Mistake
from camopt.scene.machine import is_machine
from camopt.scene.scene import RESULT_WORDS, scene_named
from camopt.solve.tables.designs import scene_of

SCENE_OR_ROW = "a TOML file, a shipped scene, or a table of designs (.parquet) with --row"


def read_scene(
    target: str,
    row: int | None,
    changes: Changes,
    noun_for_message: str = "scene",
    allowed_words: str = SCENE_OR_ROW,
) -> Any:
    """The scene of a file, a shipped name or a row of a table, with the changes of options.

    The changes are made before a file is checked. If ``target`` is no scene, the message names
    ``noun_for_message`` and ``allowed_words``.
    """
    table = target.endswith(".parquet")
    if table and row is not None:
        return scene_with_changes(scene_of(target, row), changes)
    if table and allowed_words == SCENE_OR_ROW:
        raise BadInput([Mistake("camopt", "SCENE", target, "is a table: choose a row with --row", bare=True)])
    if row is not None:
        raise BadInput([Mistake("camopt", "--row", row, f"needs a table; {target} is a scene", bare=True)])
    with name_options_in_mistakes(changes):
        scene = scene_named(target, noun_for_message, allowed_words, changed_values_by_key(changes))
    return scene_with_changes(
        scene, {key: change for key, change in changes.items() if key in scene.search.numbers}
    )


def read_scene_or_result_path(target: str, row: int | None, changes: Changes) -> Any:
    """The content of a page: a scene with changes, or the path of a folder, table or machine."""
    if row is not None and Path(target).is_dir():
        why = f"needs a table; {target} is a folder: name a table in it"
        raise BadInput([Mistake("camopt", "--row", row, why, bare=True)])
    if row is None and Path(target).exists() and Path(target).suffix not in ("", ".toml", ".parquet"):
        return target  # its reader names the allowed suffixes
    machine = row is None and is_machine(target)
    if row is not None or not (machine or Path(target).is_dir() or target.endswith(".parquet")):
        return read_scene(target, row, changes, "what", RESULT_WORDS)
    for option, value in changes.values():
        why = f"needs a scene; {target} is a {'machine' if machine else 'result'}, which cannot be changed here"
        raise BadInput([Mistake("camopt", option, value, why, bare=True)])
    return target

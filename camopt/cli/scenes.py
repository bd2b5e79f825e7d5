"""Scenes as commands take them: what a user names, with options; what of them is odd or unused."""

from pathlib import Path
from typing import Any

from camopt.cli.options import Changes, name_options_in_mistakes, values_by_key, with_changes
from camopt.core.mistakes import BadInput, Mistake
from camopt.scene.scene import RESULT_WORDS, scene_named
from camopt.solve.tables.designs import scene_of

SCENE_OR_ROW = "a TOML file, a shipped scene, or a table of designs (.parquet) with --row"


def read_scene(
    target: str, row: int | None, changes: Changes, what: str = "scene", allowed: str = SCENE_OR_ROW
) -> Any:
    """The scene of a file or of a shipped name; of a table, that of one of its rows. With changes, from options.

    The changes are made before a file is checked. Of a target that is none, a message says ``what`` it is and what
    is allowed there.
    """
    table = target.endswith(".parquet")
    if table and row is not None:
        return with_changes(scene_of(target, row), changes)
    if table and allowed == SCENE_OR_ROW:
        raise BadInput([Mistake("camopt", "SCENE", target, "is a table: say which row with --row", bare=True)])
    if row is not None:
        raise BadInput([Mistake("camopt", "--row", row, f"belongs to a table; {target} is a scene", bare=True)])
    with name_options_in_mistakes(changes):
        scene = scene_named(target, what, allowed, values_by_key(changes))
    return with_changes(scene, {key: change for key, change in changes.items() if key in scene.search.numbers})


def scene_or_result(target: str, row: int | None, changes: Changes) -> Any:
    """What a page shows: a scene, changed as asked; a folder or a whole table as it is."""
    if row is not None and Path(target).is_dir():
        why = f"belongs to a table; {target} is a folder: name one of the tables in it"
        raise BadInput([Mistake("camopt", "--row", row, why, bare=True)])
    if row is None and Path(target).exists() and Path(target).suffix not in ("", ".toml", ".parquet"):
        return target  # which says what it takes
    if row is not None or not (Path(target).is_dir() or target.endswith(".parquet")):
        return read_scene(target, row, changes, "what", RESULT_WORDS)
    for option, value in changes.values():
        why = f"belongs to a scene; {target} is a result, whose numbers stay as they are"
        raise BadInput([Mistake("camopt", option, value, why, bare=True)])
    return target

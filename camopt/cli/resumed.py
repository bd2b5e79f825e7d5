"""The interrupted work that ``--resume`` continues."""

from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from camopt.storage.unit import name_of_part

SAME_SWEEP = {"out", "resume", "part", "workers", "scheduler", "quiet", "as_json", "again"}
"""Options that do not ask for another sweep."""


def place_of(out: Path, part: tuple[int, int] | None) -> tuple[Path, str]:
    """The folder of a sweep, or of a part of one, and what its result is called there."""
    return (out / name_of_part(*part), "part") if part else (out, "sweep")


def resumed(scene: Any, keep: str, out: Path, part: tuple[int, int] | None) -> tuple[Any, str]:
    """The scene of the sweep in a folder, interrupted or whole, and what it keeps; what is given if there is none.

    BadInput if options ask for something else than it was asked, or nothing tells what it was asked.
    """
    from camopt.front.journal import interrupted
    from camopt.front.plan import KEPT, key_of_result, plan_of_key, sweep_plan
    from camopt.mistakes import BadInput, Mistake
    from camopt.scene.scene import find_scene
    from camopt.storage.manifest import has_result

    folder, command = place_of(out, part)
    question = interrupted(folder, command) or key_of_result(folder, command)
    context = click.get_current_context()
    sources = {name: context.get_parameter_source(name) for name in context.params}
    asks = any(source is ParameterSource.COMMANDLINE for name, source in sources.items() if name not in SAME_SWEEP)
    if question is None:
        if not asks and has_result(folder, command):
            why = "needs a scene: nothing tells what the sweep in this folder was asked"
            raise BadInput([Mistake("camopt", "--resume", str(folder), why, bare=True)])
        return scene, keep
    if asks:
        asked = sweep_plan(scene, keep).question(*(part or (1, 1)))
        other = asked.asks_other_than(question)
        if sources.get("scene") is not ParameterSource.COMMANDLINE:  # options alone: those that differ
            (default,) = (each.default for each in context.command.params if each.name == "scene")
            plain = sweep_plan(find_scene(str(default)), KEPT[0]).question(*(part or (1, 1)))
            other = [key for key in other if key in asked.other_than(plain)]
        if other:
            why = f"goes on with the sweep in {folder}, which differs in {', '.join(other)}"
            raise BadInput([Mistake("camopt", "--resume", None, why, bare=True)])
    return plan_of_key(question).scene, question.keep

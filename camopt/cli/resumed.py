"""What ``--resume`` goes on with."""

from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

BESIDE = {"out", "resume", "part", "workers", "scheduler", "quiet", "as_json"}
"""Options that do not ask for another sweep."""


def resumed(scene: Any, keep: str, out: Path, part: tuple[int, int] | None) -> tuple[Any, str]:
    """The scene of the interrupted sweep in a folder, and which designs it keeps.

    BadInput if there is none, or if options ask for something else than it was asked.
    """
    from camopt.front.asked import KEPT, asked_again, asked_of
    from camopt.front.journal import interrupted
    from camopt.front.parts import COMMAND, folder_of
    from camopt.mistakes import BadInput, Mistake
    from camopt.scene.scene import find_scene

    folder, command = (out / folder_of(*part), COMMAND) if part else (out, "sweep")
    question = interrupted(folder, command)
    if question is None:
        why = "needs an interrupted sweep, and there is none in this folder"
        raise BadInput([Mistake("camopt", "--resume", str(folder), why, bare=True)])
    context = click.get_current_context()
    sources = {name: context.get_parameter_source(name) for name in context.params}
    if any(source is ParameterSource.COMMANDLINE for name, source in sources.items() if name not in BESIDE):
        asked = asked_of(scene, keep).question(*(part or (1, 1)))
        other = asked.asks_other_than(question)
        if sources.get("scene") is not ParameterSource.COMMANDLINE:  # options alone: those that differ
            (default,) = (each.default for each in context.command.params if each.name == "scene")
            plain = asked_of(find_scene(str(default)), KEPT[0]).question(*(part or (1, 1)))
            other = [key for key in other if key in asked.other_than(plain)]
        if other:
            why = f"goes on with the sweep in {folder}, which differs in {', '.join(other)}"
            raise BadInput([Mistake("camopt", "--resume", None, why, bare=True)])
    return asked_again(question).scene, question.keep

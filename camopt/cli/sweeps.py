"""Unfinished sweeps in a folder, for --resume."""

from pathlib import Path

import click
from click.core import ParameterSource

from camopt.cli.options import DEFAULT_SCENE
from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.manifest import read_manifest_or_empty
from camopt.scene.scene import Scene, find_scene
from camopt.solve.front.parts import PART_COMMAND, part_folder_name
from camopt.solve.front.plan import KEEP_CHOICES, TABLED_KEEPS, key_from_manifest, plan_of_key, sweep_plan
from camopt.solve.front.store import interrupted_key
from camopt.solve.front.sweep import SWEEP_COMMAND

UNCOMPARED_OPTIONS = {"out", "resume", "part", "workers", "scheduler", "quiet", "as_json", "again"}
"""Options that do not change which sweep is run."""


def sweep_decides_whole_boxes(scene: Scene, keep: str) -> bool:
    """Whether a sweep accepts or drops whole boxes of designs."""
    return keep not in TABLED_KEEPS and sweep_plan(scene, keep).searches_front_by_boxes


def scene_and_keep_to_resume(scene: Scene, keep: str, out: Path, part: tuple[int, int] | None) -> tuple[Scene, str]:
    """The scene and ``keep`` of the sweep in a folder, finished or not; without a sweep, the arguments.

    Raises BadInput if the options differ from those of the sweep, or if its scene is not recorded.
    """
    folder, command = (out / part_folder_name(*part), PART_COMMAND) if part else (out, SWEEP_COMMAND)
    result = read_manifest_or_empty(folder).results.get(command)
    question = interrupted_key(folder, command) or (key_from_manifest(result.question) if result else None)
    context = click.get_current_context()
    sources = {name: context.get_parameter_source(name) for name in context.params}
    asks = any(
        source is ParameterSource.COMMANDLINE for name, source in sources.items() if name not in UNCOMPARED_OPTIONS
    )
    if question is None:
        if result and not asks:
            why = "needs SCENE: the manifest of this folder does not record the scene of its sweep"
            raise BadInput([Mistake("camopt", "--resume", str(folder), why, bare=True)])
        return scene, keep
    if asks:
        command_key = sweep_plan(scene, keep).sweep_key(*(part or (1, 1)))
        differences = command_key.differences_except_block_size(question)
        if sources.get("scene") is not ParameterSource.COMMANDLINE:  # without a SCENE, only the options count
            default_key = sweep_plan(find_scene(DEFAULT_SCENE), KEEP_CHOICES[0]).sweep_key(*(part or (1, 1)))
            differences = [key for key in differences if key in command_key.differences_from(default_key)]
        if differences:
            why = f"cannot resume the sweep in {folder}: it differs in {', '.join(differences)}"
            raise BadInput([Mistake("camopt", "--resume", None, why, bare=True)])
    return plan_of_key(question).scene, question.keep

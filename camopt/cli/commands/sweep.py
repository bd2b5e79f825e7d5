"""``camopt sweep``."""

from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from camopt.cli.exits import NOTHING_FEASIBLE, reached
from camopt.cli.options import (
    DEFAULT_SCENE,
    Axis,
    Command,
    FreeNumber,
    OutputPlace,
    Share,
    again_option,
    changed,
    check_folder,
    listed,
    option_of,
    output_options,
    outputs_option,
    scene_options,
    scheduler_option,
)

SAME_SWEEP = {"out", "resume", "part", "workers", "scheduler", "quiet", "as_json", "again"}
"""Options that do not ask for another sweep."""


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@outputs_option
@output_options
@click.option("--base-radius", type=Axis(), help="Base radii to sweep, mm.")
@click.option("--offset", type=Axis(), help="Offsets to sweep, mm, positive to the right.")
@click.option("--roller-radius", type=Axis(), help="Roller radii to sweep, mm.")
@click.option(
    "--vary",
    type=FreeNumber(),
    multiple=True,
    help="Any other number to sweep, by its key, such as follower.dynamics.spring_rate=2:10:1 or arm_length=80.",
)
@click.option("--samples", type=int, help="Draw so many designs for each law, in place of a grid; no steps needed.")
@click.option("--law", multiple=True, help="Motion law to try; repeat the option for several laws.")
@click.option(
    "--minimise",
    callback=listed,
    metavar="NAME,NAME",
    help="Quantities that the Pareto front minimises, in place of all objectives of the scene.",
)
@click.option(
    "--maximise",
    callback=listed,
    metavar="NAME,NAME",
    help="Quantities that the Pareto front maximises, in place of all objectives of the scene.",
)
@click.option("--out", type=OutputPlace(), default="camopt-out", show_default=True, help="Folder for the tables.")
@click.option(
    "--keep", type=click.Choice(("pareto", "feasible", "all", "front-only")), default="feasible", show_default=True,
    help="Which designs to write to designs.parquet. For pareto, whole boxes of designs are decided together where "
    "that is faster, in large spaces; front-only does the same, and writes none.",
)  # fmt: skip
@click.option("--refine", is_flag=True, help="Move each design of the Pareto front off the grid, to an optimum.")
@click.option(
    "--thin",
    type=float,
    metavar="EPS",
    help="Shorten the Pareto front: leave out rows of which one that stays costs at most EPS more, in every "
    "objective (normalised to 0 to 1). It may cost far less in some.",
)
@click.option("--workers", type=click.IntRange(1), help="Number of threads; one per core by default.")
@click.option(
    "--resume",
    is_flag=True,
    help="Resume the unfinished sweep in --out, or start one. The same command does so anyway.",
)
@click.option(
    "--part", type=Share(), help="Evaluate one of N equal parts, on any machine; `camopt merge` puts them together."
)
@again_option
@scheduler_option
def sweep(
    scene: Any,
    as_json: bool,
    quiet: bool,
    out: Path,
    keep: str,
    workers: int | None,
    resume: bool,
    part: tuple[int, int] | None,
    again: bool,
    engine: Any,
    **asked: Any,
) -> int:
    """Evaluate every design of a grid, or a sample; write the feasible ones and the Pareto front as tables.

    An interrupted sweep keeps what it has done: the same command goes on from there. If the result is up to date,
    the same command prints it again.
    """
    from camopt.cli import terminal
    from camopt.cli.commands.sweep_report import show_part, show_sweep
    from camopt.front.parts import sweep_part
    from camopt.front.plan import TABLED, sweep_plan
    from camopt.front.sweep import sweep as run
    from camopt.problem.unused import constant_objectives

    scene = changed(scene, _searched(**asked))
    if resume:
        scene, keep = _unfinished(scene, keep, out, part)
    check_folder(scene, out)
    notify = terminal.say_lost if quiet else terminal.say_note
    by_boxes = keep not in TABLED and not part and not engine and sweep_plan(scene, keep).by_boxes
    made: Any
    with terminal.progress(quiet, "boxes of designs" if by_boxes else "designs") as advance:
        if part:
            made = sweep_part(scene, part, out, keep, workers, advance, engine, notify, again)
        else:
            made = run(scene, out, keep, workers, advance, engine=engine, tell=notify, again=again)
    (show_part if part else show_sweep)(made, as_json)
    if not quiet:
        terminal.say_notes((*terminal.unused_of(scene), *constant_objectives(scene)))
        terminal.say_written([] if made.already_done else [made.folder] if part else made.files)
    if part:
        return 0
    return reached(scene, made.reached) if made.pareto else NOTHING_FEASIBLE


def _unfinished(scene: Any, keep: str, out: Path, part: tuple[int, int] | None) -> tuple[Any, str]:
    """The scene of the sweep in a folder, unfinished or whole, and what it keeps; what is given if there is none.

    BadInput if options ask for something else than it was asked, or nothing tells what it was asked.
    """
    from camopt.front.parts import PART_COMMAND, name_of_part
    from camopt.front.plan import KEPT, key_of, plan_of_key, sweep_plan
    from camopt.front.store import interrupted_question
    from camopt.front.sweep import SWEEP_COMMAND
    from camopt.mistakes import BadInput, Mistake
    from camopt.scene.scene import find_scene
    from camopt.storage.manifest import readable_manifest

    folder, command = (out / name_of_part(*part), PART_COMMAND) if part else (out, SWEEP_COMMAND)
    result = readable_manifest(folder).results.get(command)
    question = interrupted_question(folder, command) or (key_of(result.question) if result else None)
    context = click.get_current_context()
    sources = {name: context.get_parameter_source(name) for name in context.params}
    asks = any(source is ParameterSource.COMMANDLINE for name, source in sources.items() if name not in SAME_SWEEP)
    if question is None:
        if result and not asks:
            why = "needs a scene: nothing tells what the sweep in this folder was asked"
            raise BadInput([Mistake("camopt", "--resume", str(folder), why, bare=True)])
        return scene, keep
    if asks:
        asked = sweep_plan(scene, keep).question(*(part or (1, 1)))
        other = asked.asks_other_than(question)
        if sources.get("scene") is not ParameterSource.COMMANDLINE:  # options alone: those that differ
            plain = sweep_plan(find_scene(DEFAULT_SCENE), KEPT[0]).question(*(part or (1, 1)))
            other = [key for key in other if key in asked.other_than(plain)]
        if other:
            why = f"goes on with the sweep in {folder}, which differs in {', '.join(other)}"
            raise BadInput([Mistake("camopt", "--resume", None, why, bare=True)])
    return plan_of_key(question).scene, question.keep


def _searched(
    law: tuple[str, ...],
    minimise: list[str] | None,
    maximise: list[str] | None,
    thin: float | None,
    refine: bool,
    vary: tuple[tuple[str, Any], ...],
    **axes: Any,
) -> dict[str, tuple[str, Any]]:
    """What options change in [search]: keys, each with its option and value."""
    changes = {f"search.{key}": (option_of(key), value) for key, value in axes.items() if value is not None}
    if minimise or maximise:
        changes |= {"search.minimise": ("--minimise", minimise), "search.maximise": ("--maximise", maximise)}
    changes |= {f"search.{key}": (f"--vary {key}", axis) for key, axis in vary}
    if law:
        changes |= {"search.law": ("--law", list(law))}
        changes |= {f"search.law_{stroke}": ("--law", None) for stroke in ("rise", "return")}
    if thin is not None:
        changes |= {"search.thin": ("--thin", thin)}
    if refine:
        changes |= {"search.refine": ("--refine", True)}
    return changes

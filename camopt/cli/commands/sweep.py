"""``camopt sweep``."""

from functools import partial
from pathlib import Path
from typing import Any

import click

from camopt.cli.exits import NOT_REACHED, NOTHING_FEASIBLE, exit_code, reached
from camopt.cli.once import OnceCommand, Report, words_read
from camopt.cli.options import (
    DEFAULT_SCENE,
    Axis,
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
from camopt.cli.resumed import place_of, resumed


@click.command(cls=OnceCommand, place=lambda out, part, **_: place_of(out, part))
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
    help="Go on with the sweep in the folder, whatever it was asked, or begin. The same command does so anyway.",
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

    An interrupted sweep keeps what it has done: the same command goes on from there. If it is done already, the
    same command says so.
    """
    from camopt.cli import terminal
    from camopt.cli.commands.sweep_report import show_part, show_sweep
    from camopt.front.plan import TABLED, sweep_plan
    from camopt.front.sweep import sweep as run
    from camopt.problem.unused import constant_objectives

    words, scene = words_read(), changed(scene, _searched(**asked))
    if resume:
        scene, keep = resumed(scene, keep, out, part)
    check_folder(scene, out)
    notify = terminal.say_lost if quiet else terminal.say_note
    by_boxes = keep not in TABLED and not part and not engine and sweep_plan(scene, keep).by_boxes
    unit = "boxes of designs" if by_boxes else "designs"

    def report_of(made: Any) -> Report:
        notes = (*terminal.unused_of(scene), *constant_objectives(scene))
        if part:
            return Report(partial(show_part, made), 0, notes)
        code = exit_code(scene, made.reached) if made.pareto else NOTHING_FEASIBLE
        return Report(partial(show_sweep, made), code, notes)

    def beside(made: Any) -> dict[str, Any]:
        reports.append(report_of(made))
        kept.update(reports[0].kept(words))
        return kept

    kept: dict[str, Any] = {}
    reports: list[Report] = []
    made: Any
    with terminal.progress(quiet, unit) as advance:
        if part:
            from camopt.front.parts import sweep_part

            made = sweep_part(scene, part, out, keep, workers, advance, engine, notify, again, beside)
        else:
            made = run(scene, out, keep, workers, advance, engine=engine, tell=notify, again=again, beside=beside)
    report = reports[0] if reports else report_of(made)  # of what was done already
    report.tell(as_json, kept)
    if not quiet:
        terminal.say_notes(report.notes)
        terminal.say_written([] if made.already_done else [made.file] if part else made.files)
    return reached(scene, made.reached) if report.code == NOT_REACHED else report.code


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

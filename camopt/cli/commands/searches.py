"""Commands that search for designs and motion laws."""

from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import monotonic
from typing import Any

import click

import camopt
from camopt import cli, library
from camopt.cli.options import (
    DEFAULT_SCENE,
    PICTURE_SUFFIXES,
    Axis,
    Command,
    OptionWithFormerName,
    OutputPath,
    PartNumber,
    SearchAxis,
    again_option,
    former_again_option,
    option_spelling,
    output_options,
    outputs_option,
    refuse_to_overwrite_scene_in_folder,
    scene_options,
    scene_with_changes,
    scheduler_option,
    split_at_commas,
)

SWEEP_OPTIONS = {
    "Designs": ("base_radius", "offset", "roller_radius", "vary", "law", "samples"),
    "Pareto front": ("minimise", "maximise", "refine", "thin"),
    "Tables": ("out", "keep", "again", "resume"),
    "Work": ("workers", "scheduler", "part"),
}


@click.command(cls=Command, groups=SWEEP_OPTIONS)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@outputs_option
@output_options
@click.option("--base-radius", type=Axis(), help="Base radii to sweep, mm.")
@click.option("--offset", type=Axis(), help="Offsets to sweep, mm, positive to the right.")
@click.option("--roller-radius", type=Axis(), help="Roller radii to sweep, mm.")
@click.option(
    "--vary",
    type=SearchAxis(),
    multiple=True,
    help="Sweep any other number by its key, such as follower.dynamics.spring_rate=2:10:1. Repeatable.",
)
@click.option(
    "--samples", type=int, help="Number of random designs for each law, in place of a grid; ranges need no STEP."
)
@click.option("--law", multiple=True, help="Motion law to try. Repeatable.")
@click.option(
    "--minimise",
    callback=split_at_commas,
    metavar="NAME,NAME",
    help="Quantities that the Pareto front minimises; replaces all objectives of the scene.",
)
@click.option(
    "--maximise",
    callback=split_at_commas,
    metavar="NAME,NAME",
    help="Quantities that the Pareto front maximises; replaces all objectives of the scene.",
)
@click.option("--out", type=OutputPath(), default="camopt-out", show_default=True, help="Folder for the tables.")
@click.option(
    "--keep", type=click.Choice(("pareto", "feasible", "all", "front-only")), default="feasible", show_default=True,
    help="Designs to write to designs.parquet; front-only writes the Pareto front alone. In large searches, pareto "
    "and front-only are faster.",
)  # fmt: skip
@click.option(
    "--refine",
    is_flag=True,
    help="Move each design of the Pareto front from its grid point to the optimum near it.",
)
@click.option(
    "--thin",
    type=float,
    metavar="EPS",
    help="Shorten the Pareto front: drop a row if a kept row is at most EPS worse in every objective. EPS is "
    "a share of the range of the objective.",
)
@click.option("--workers", type=click.IntRange(1), help="Number of threads; one per core by default.")
@click.option(
    "--resume",
    is_flag=True,
    help="Resume the unfinished sweep in --out, or start one. The same command without --resume does so too.",
)
@click.option(
    "--part",
    type=PartNumber(),
    help="Evaluate only part I of N equal parts, on any machine; `camopt merge` joins the parts.",
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
    **options: Any,
) -> int:
    """Evaluate every design of a grid, or a sample.

    camopt writes the feasible designs and the Pareto front as tables. An interrupted sweep keeps its work: the same
    command resumes it. If the tables are up to date, the same command prints them again.
    """
    scene = scene_with_changes(scene, _search_changes(**options))
    if resume:
        scene, keep = cli.scene_and_keep_to_resume(scene, keep, out, part)
    refuse_to_overwrite_scene_in_folder(scene, out)
    notify = cli.print_note_if_loss_warning if quiet else cli.print_note
    by_boxes = not part and not engine and cli.sweep_decides_whole_boxes(scene, keep)
    run: Any = partial(camopt.sweep_part, scene, part) if part else partial(camopt.sweep, scene)
    with cli.progress(quiet, "boxes of designs" if by_boxes else "designs") as advance:
        result = run(out=out, keep=keep, workers=workers, progress=advance, engine=engine, tell=notify, again=again)
    files = [] if result.already_done else [result.folder] if part else result.files
    return cli.print_result(result, as_json, quiet, files)


def _search_changes(
    law: tuple[str, ...],
    minimise: list[str] | None,
    maximise: list[str] | None,
    refine: bool,
    vary: tuple[tuple[str, Any], ...],
    **settings: Any,
) -> dict[str, tuple[str, Any]]:
    """Changes of the options to [search]: by key, the option and the value."""
    settings["refine"] = refine or None  # without the flag, the scene decides
    given = {key: value for key, value in settings.items() if value is not None}
    changes = {f"search.{key}": (option_spelling(key), value) for key, value in given.items()}
    if minimise or maximise:
        changes |= {"search.minimise": ("--minimise", minimise), "search.maximise": ("--maximise", maximise)}
    changes |= {f"search.{key}": (f"--vary {key}", axis) for key, axis in vary}
    if law:
        changes |= {"search.law": ("--law", list(law))}
        changes |= {f"search.law_{stroke}": ("--law", None) for stroke in ("rise", "return")}
    return changes


@click.command(cls=Command)
@click.argument("parts", nargs=-1, required=True, metavar="FOLDER...")
@output_options
@click.option("--out", type=OutputPath(), default="camopt-out", show_default=True, help="Folder for the tables.")
@again_option
def merge(parts: tuple[str, ...], as_json: bool, quiet: bool, out: Path, again: bool) -> int:
    """Merge the parts of a sweep.

    The tables are the same as those of one whole sweep. Each FOLDER holds parts that `camopt sweep --part` wrote,
    directly or in folders inside it.
    """
    with cli.progress(quiet, "designs") as advance:
        result = camopt.merge(
            parts,
            out,
            progress=advance,
            tell=cli.print_note_if_loss_warning if quiet else cli.print_note,
            again=again,
        )
    return cli.print_result(result, as_json, quiet, [] if result.already_done else result.files)


NO_SECONDS = 1e-9  # time limit of the prices when no time is left: they end at once, with bounds only


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@outputs_option
@output_options
@click.option("--out", type=OutputPath(), help="Folder for the smallest cam of each law, as a scene (TOML).")
@click.option(
    "--seconds",
    type=click.FloatRange(0, min_open=True),
    help="Time limit, s. By default the search stops after a fixed amount of work, about a minute. If it stops "
    "before the proof, camopt shows the smallest cam so far and the gap to the proven bound.",
)
@former_again_option
def optimise(scene: Any, as_json: bool, quiet: bool, out: Path | None, seconds: float | None) -> int:
    """Find the smallest cam of each motion law.

    The cam meets every limit of the scene. camopt proves that no smaller cam does, or gives the gap to a proven
    bound.
    """
    if out:
        refuse_to_overwrite_scene_in_folder(scene, out, library.OPTIMUM)
    if not quiet:
        cli.print_notes(library.notes_on_scene(scene))
        named = [*scene.search.minimise, *scene.search.maximise]
        if named and scene.mechanism.body.size_quantity not in named:
            cli.print_note(f"search: optimise minimises the size; use sweep to optimise {', '.join(named)}")
    publication = library.publication(out, "optimise", (library.OPTIMUM,)) if out else nullcontext()
    with publication as unit, cli.progress(quiet, "laws") as advance:
        end = monotonic() + (seconds or 0.0)
        result = camopt.optimise(scene, progress=advance, seconds=seconds)
        if unit:
            library.write_scenes(result.by_law, unit.staging)
        is_limited = seconds is not None or result.out_of_time
        left = max(end - monotonic(), NO_SECONDS) if is_limited else None
        result = replace(result, prices=camopt.prices(result, left))
    return cli.print_result(result, as_json, quiet, unit.files if unit else ())


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--out", type=OutputPath(), default="camopt-out", show_default=True, help="Folder for the scene and the laws."
)
@click.option(
    "--plot",
    "picture",
    type=OutputPath(*PICTURE_SUFFIXES),
    help="Draw the cams of the new law and of known laws: PNG, SVG, PDF.",
)
@former_again_option
def synthesise(scene: Any, as_json: bool, quiet: bool, out: Path, picture: Path | None) -> int:
    """Compute a motion law for the smallest cam.

    The law is a B-spline, found by convex optimisation. camopt proves a bound on the size over all motions.
    """
    refuse_to_overwrite_scene_in_folder(scene, out, library.SCENE_FILE)
    if not quiet:
        cli.print_notes(library.dropped_ramps_in_words(scene))
    with library.publication(out, "synthesise", library.SYNTHESIS) as unit:
        with cli.progress(quiet, "starts") as advance:
            result = camopt.synthesise(scene, progress=advance)
            known = library.build_known_law_cams(scene)
            library.write_scene_and_laws(result, unit.staging)
            library.write_known_cam_and_summary(result, known, unit.staging)
            (prices,) = camopt.prices(result).values()
        if picture:
            camopt.plot(result, picture, known=known)
    result = replace(result, known=known, prices=prices)
    return cli.print_result(result, as_json, quiet, [*unit.files, *([picture] if picture else [])])


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--axes",
    callback=split_at_commas,
    default="size,acceleration",
    show_default=True,
    help="Two or three quantities to trade off: terms of synthesis.minimise, or loads with an upper limit.",
)
@click.option(
    "--values",
    "points",
    cls=OptionWithFormerName,
    former="--points",
    type=click.IntRange(2, 500),
    default=24,
    show_default=True,
    help="Number of values on each axis but the first, which is minimised.",
)
@click.option(
    "--out",
    type=OutputPath(),
    default="camopt-out",
    show_default=True,
    help="Folder for the table and the picture.",
)
@click.option(
    "--workers", type=click.IntRange(1), help="Number of processes; one per core by default. Few points take one."
)
@former_again_option
@scheduler_option
def frontier(
    scene: Any,
    as_json: bool,
    quiet: bool,
    axes: list[str],
    points: int,
    out: Path,
    workers: int | None,
    engine: Any,
) -> int:
    """Show the trade-off of size and acceleration.

    Each point is a new motion law. --axes chooses other quantities, such as jerk or contact force.
    """
    if not quiet:
        cli.print_notes(library.dropped_ramps_in_words(scene))
    with (
        library.publication(out, "frontier", library.FRONTIER_FILES) as unit,
        cli.progress(quiet, "points") as advance,
    ):
        result = camopt.frontier(
            scene,
            axes,
            points=points,
            workers=workers,
            progress=advance,
            engine=engine,
            tell=None if quiet else cli.print_note,
        )
        library.write_frontier(result, unit.staging)
        camopt.plot(result, unit.staged_path(library.FRONTIER_FILES[1]))
    return cli.print_result(result, as_json, quiet, unit.files)

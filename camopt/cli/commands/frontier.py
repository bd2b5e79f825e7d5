"""``camopt frontier``."""

from pathlib import Path
from typing import Any

import click

import camopt
from camopt import cli, library
from camopt.cli.options import (
    DEFAULT_SCENE,
    Command,
    OutputPlace,
    Renamed,
    former_again_option,
    output_options,
    scene_options,
    scheduler_option,
)


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--axes",
    default="size,acceleration",
    show_default=True,
    help="What to trade off: two or three terms or loads.",
)
@click.option(
    "--values",
    "points",
    cls=Renamed,
    former="--points",
    type=click.IntRange(2, 500),
    default=24,
    show_default=True,
    help="Number of values for each axis but the first.",
)
@click.option(
    "--out",
    type=OutputPlace(),
    default="camopt-out",
    show_default=True,
    help="Folder for the table and the picture.",
)
@click.option("--workers", type=click.IntRange(1), help="Number of processes; one per core by default.")
@former_again_option
@scheduler_option
def frontier(
    scene: Any,
    as_json: bool,
    quiet: bool,
    axes: str,
    points: int,
    out: Path,
    workers: int | None,
    engine: Any,
) -> int:
    """Show the trade-off between size and acceleration, or other terms and loads, with new motion laws."""
    traded = [axis.strip() for axis in axes.split(",")]
    tell = None if quiet else cli.say_note
    if not quiet:
        cli.say_notes(library.lost_ramps(scene))
    with (
        library.publication(out, "frontier", library.FRONTIER_FILES) as unit,
        cli.progress(quiet, "points") as advance,
    ):
        result = camopt.frontier(
            scene, traded, points=points, workers=workers, progress=advance, engine=engine, tell=tell
        )
        library.write_frontier(result, unit.staging)
        camopt.plot(result, unit.path(library.FRONTIER_FILES[1]))
    return cli.print_result(result, as_json, quiet, unit.files)

"""``camopt frontier``."""

from pathlib import Path
from typing import Any

import click

from camopt.cli.exits import NOTHING_FEASIBLE
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
    from camopt.cli import terminal
    from camopt.cli.commands.frontier_report import show_frontier
    from camopt.drawing.plot import plot
    from camopt.storage.publishing import publication
    from camopt.synthesis.files import FRONTIER, PICTURE, write_frontier
    from camopt.synthesis.frontier import frontier as run
    from camopt.synthesis.ramps import lost_ramps

    if not quiet:
        terminal.say_notes(lost_ramps(scene))
    traded = [axis.strip() for axis in axes.split(",")]
    with publication(out, "frontier", (FRONTIER, PICTURE)) as unit, terminal.progress(quiet, "points") as advance:
        found = run(scene, traded, points, workers, advance, engine, None if quiet else terminal.say_note)
        write_frontier(found, unit.staging)
        plot(found, unit.path(PICTURE))
    show_frontier(found, as_json)
    if not quiet:
        terminal.say_written(unit.files)
    return 0 if found.rows else NOTHING_FEASIBLE

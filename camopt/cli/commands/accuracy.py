"""``camopt accuracy``."""

from pathlib import Path
from typing import Any

import click

from camopt import cli
from camopt.cli.options import (
    DEFAULT_SCENE,
    Command,
    OutputPlace,
    former_again_option,
    output_options,
    refuse_without,
    scene_options,
    scheduler_option,
)


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--out",
    type=OutputPlace(),
    default="camopt-out",
    show_default=True,
    help="Folder for the table and the pictures.",
)
@click.option("--workers", type=click.IntRange(1), help="Number of processes of --scheduler local.")
@former_again_option
@scheduler_option
def accuracy(scene: Any, as_json: bool, quiet: bool, out: Path, workers: int | None, engine: Any) -> int:
    """Measure how much time accuracy costs, as a table and a picture."""
    if engine is None:
        refuse_without("--scheduler", {"workers": workers})
    rows, files = cli.publish_accuracy(scene, out, engine, quiet)
    cli.show_accuracy(rows, scene, as_json)
    if not quiet:
        cli.say_written(files)
    return 0

"""``camopt accuracy``."""

from pathlib import Path
from typing import Any

import click

from camopt import cli, library
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
    with library.publication(out, "accuracy", library.ACCURACY) as unit, cli.progress(quiet, "laws") as advance:
        result = library.measure(scene, advance, engine)
        library.write_accuracy(result, unit.staging)
    return cli.print_result(result, as_json, quiet, unit.files)

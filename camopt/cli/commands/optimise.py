"""``camopt optimise``."""

from pathlib import Path
from typing import Any

import click

from camopt import cli
from camopt.cli.exits import NOTHING_FEASIBLE, reached
from camopt.cli.options import (
    DEFAULT_SCENE,
    Command,
    OutputPlace,
    former_again_option,
    output_options,
    outputs_option,
    scene_options,
)


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@outputs_option
@output_options
@click.option(
    "--out", type=OutputPlace(), help="Folder to write the smallest cam of each law to, as a scene (TOML)."
)
@click.option(
    "--seconds",
    type=click.FloatRange(0, min_open=True),
    default=60,
    show_default=True,
    help="Time for the searches. After it, the smallest cam so far is shown, and how much smaller one might be.",
)
@former_again_option
def optimise(scene: Any, as_json: bool, quiet: bool, out: Path | None, seconds: float) -> int:
    """Find the smallest cam of each motion law that meets every limit."""
    result, costs, files = cli.publish_optimum(scene, seconds, out, quiet)
    cli.show_optimum(result, costs, as_json)
    if not quiet:
        cli.say_notes(cli.notes_of_optimum(result))
        cli.say_written(files)
    return reached(scene, result.best["relative_half_width"]) if result.best else NOTHING_FEASIBLE

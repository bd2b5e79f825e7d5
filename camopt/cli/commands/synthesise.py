"""``camopt synthesise``."""

from pathlib import Path
from typing import Any

import click

from camopt import cli
from camopt.cli.exits import reached
from camopt.cli.options import (
    DEFAULT_SCENE,
    PICTURES,
    Command,
    OutputPlace,
    former_again_option,
    output_options,
    scene_options,
)


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--out", type=OutputPlace(), default="camopt-out", show_default=True, help="Folder for the scene and the laws."
)
@click.option(
    "--plot",
    "picture",
    type=OutputPlace(*PICTURES),
    help="Draw the cams of new and known laws: PNG, SVG, PDF.",
)
@former_again_option
def synthesise(scene: Any, as_json: bool, quiet: bool, out: Path, picture: Path | None) -> int:
    """Compute new motion laws (B-splines) that allow the smallest cam."""
    result, known, costs, files = cli.publish_synthesis(scene, out, picture, quiet)
    cli.show_synthesis(result, known, costs, as_json)
    if not quiet:
        cli.say_written(files)
    return reached(scene, result.design["relative_half_width"])

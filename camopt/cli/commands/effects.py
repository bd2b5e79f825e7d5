"""``camopt effects``."""

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
    scene_options,
)


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--spectrum",
    is_flag=True,
    help="Compute response spectra of the motion laws instead.",
)
@click.option(
    "--out",
    type=OutputPlace(),
    default="camopt-out",
    show_default=True,
    help="With --spectrum: folder for its files.",
)
@former_again_option
def effects(scene: Any, as_json: bool, quiet: bool, spectrum: bool, out: Path) -> int:
    """Show which computations (effects) a scene needs, why, and how long each takes."""
    if not spectrum:
        cli.show_cost_report(scene, as_json, quiet)
        return 0
    rows, files = cli.publish_spectrum(scene, out)
    cli.show_spectrum(rows, as_json)
    if not quiet:
        cli.say_written(files)
    return 0

"""``camopt harmonics``."""

from pathlib import Path
from typing import Any

import click

import camopt
from camopt import cli
from camopt.cli.options import DEFAULT_SCENE, PICTURES, Command, OutputPlace, output_options, scene_options


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option("--orders", type=int, default=24, show_default=True, help="How many harmonics.")
@click.option("--plot", "picture", type=OutputPlace(*PICTURES), help="Draw their amplitudes: PNG, SVG, PDF.")
def harmonics(scene: Any, as_json: bool, quiet: bool, orders: int, picture: Path | None) -> int:
    """Compute the harmonics of a motion and of its acceleration."""
    result = camopt.harmonics(scene, orders)
    if picture:
        camopt.plot(result, picture)
    return cli.print_result(result, as_json, quiet, [picture] if picture else [])

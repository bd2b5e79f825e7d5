"""``camopt timing``."""

from typing import Any

import click

import camopt
from camopt import cli
from camopt.cli.options import DEFAULT_SCENE, Command, output_options, scene_options


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--lift",
    "lifts",
    type=float,
    multiple=True,
    help="A lift from the lowest position, mm (deg); repeatable. By default the lash, or else half of the largest.",
)
def timing(scene: Any, as_json: bool, quiet: bool, lifts: tuple[float, ...]) -> int:
    """Find where in the turn the follower passes a lift, as a valve's opening and closing.

    For a scene with [tolerances] the table also shows the earliest and the latest cam angle at which a cam within
    them passes, to first order. A second table shows the cam angles before and after which no cam passes, proved by
    exact contact, with the errors of a cam that passes nearly there.
    """
    return cli.print_result(camopt.timing(scene, lifts or None), as_json, quiet)

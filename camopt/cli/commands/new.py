"""``camopt new``."""

from pathlib import Path

import click

from camopt import cli
from camopt.cli.options import Command, OutputPlace, output_options, refuse_with


@click.command(cls=Command)
@click.argument("name", required=False)
@click.argument("file", required=False, type=OutputPlace(".toml"))
@click.option("--form", help="Form of the cam: disc or cylindrical.")
@click.option("--follower", metavar="MOTION-CONTACT", help="Its follower, such as oscillating-roller.")
@click.option("--exercise", metavar="KIND", help="A problem for students, and its scene; KIND is as offset-roller.")
@click.option("--seed", type=int, default=1, show_default=True, help="With --exercise: which of its problems.")
@output_options
def new(
    name: str | None,
    file: Path | None,
    form: str | None,
    follower: str | None,
    exercise: str | None,
    seed: int,
    as_json: bool,
    quiet: bool,
) -> int:
    """Write a scene to start from to FILE, or print it: commented, with more keys and tables switched off.

    NAME is what the cam is for (valve, rocker, feeder, press, lock-bolt, belt) or a shipped scene; without one it
    is a simple cam with the follower of the options. An exercise has round numbers and a cam that can be made;
    `camopt plot FILE solution.pdf --construction` draws its solution.
    """
    if exercise:
        refuse_with("--exercise", {"form": form, "follower": follower})
    cli.show_new(name, file, form, follower, (exercise, seed) if exercise else None, as_json, quiet)
    return 0

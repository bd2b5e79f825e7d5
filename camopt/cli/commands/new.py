"""``camopt new``."""

from pathlib import Path

import click

from camopt.cli.options import Command, OutputPlace, output_options


@click.command(cls=Command)
@click.argument("name", required=False)
@click.argument("file", required=False, type=OutputPlace(".toml"))
@click.option("--form", help="Form of the cam: disc or cylindrical.")
@click.option("--follower", metavar="MOTION-CONTACT", help="Its follower, such as oscillating-roller.")
@output_options
def new(
    name: str | None, file: Path | None, form: str | None, follower: str | None, as_json: bool, quiet: bool
) -> int:
    """Write a scene to start from to FILE, or print it: commented, with more keys and tables switched off.

    NAME is what the cam is for (valve, rocker, feeder, press, lock-bolt, belt) or a shipped scene; without one it
    is a simple cam with the follower of the options.
    """
    from camopt.cli.commands.new_report import show_new

    show_new(name, file, form, follower, as_json, quiet)
    return 0

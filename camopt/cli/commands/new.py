"""``camopt new``."""

import sys
from pathlib import Path

import click

from camopt import cli, library
from camopt.cli.options import Command, OutputPlace, output_options, refuse_with
from camopt.mistakes import BadInput, Mistake


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
    if name and name.endswith(".toml") and file is None:
        file, name = library.checked_path(name, "FILE"), None
    if exercise and name:
        raise BadInput([Mistake("camopt", "NAME", name, "does not go with --exercise", bare=True)])
    text = library.exercise_toml(exercise, seed) if exercise else library.starting_scene(name, form, follower)
    if file and file.exists():
        raise BadInput([Mistake("camopt", "FILE", str(file), "a new file: this one is there already")])
    if file:
        library.write_text(file, text)
    if as_json:
        cli.print_json({"file": file and str(file), "toml": text})
    elif file is None:
        sys.stdout.write(text)
    elif not quiet:
        cli.say_written([file])
    return 0

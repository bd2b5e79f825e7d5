"""Commands that list what camopt knows, and write scenes to start from."""

import sys
from pathlib import Path

import click

import camopt
from camopt import cli, library
from camopt.cli.options import Command, OutputPath, output_options, refuse_options_with
from camopt.core.mistakes import BadInput, Mistake, suggest_names


@click.command(cls=Command)
@click.argument("name", required=False)
@click.argument("file", required=False, type=OutputPath(".toml"))
@click.option("--form", help="Form of the cam: disc or cylindrical.")
@click.option(
    "--follower", metavar="MOTION-CONTACT", help="Motion and contact of the follower, such as oscillating-roller."
)
@click.option(
    "--exercise",
    metavar="KIND",
    help="Write a problem for students with its scene. KIND is a follower, such as offset-roller.",
)
@click.option(
    "--seed",
    type=int,
    default=1,
    show_default=True,
    help="With --exercise: number of the problem; another number gives another problem.",
)
@click.option("--machine", is_flag=True, help="Write a machine of several cams to start from.")
@output_options
def new(
    name: str | None,
    file: Path | None,
    form: str | None,
    follower: str | None,
    exercise: str | None,
    seed: int,
    machine: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Write a scene to start from, with comments.

    NAME is the purpose of the cam (valve, rocker, feeder, press, lock-bolt, belt, lever), or a shipped scene. A
    lever moves its tool by a coupler. Without a NAME, camopt makes a simple cam; --form and --follower choose its
    kind. Without a FILE, camopt prints the scene. Comments in the scene show further keys and tables.

    An exercise has round numbers and a cam that can be made. `camopt plot FILE solution.pdf --construction` draws
    its solution.
    """
    if exercise:
        refuse_options_with("--exercise", {"form": form, "follower": follower, "machine": machine or None})
    if machine:
        refuse_options_with("--machine", {"form": form, "follower": follower})
    if name and name.endswith(".toml") and file is None:
        file, name = library.checked_path(name, "FILE"), None
    if (exercise or machine) and name:
        option = "--exercise" if exercise else "--machine"
        raise BadInput([Mistake("camopt", "NAME", name, f"cannot be used with {option}", bare=True)])
    text = (
        library.exercise_toml(exercise, seed)
        if exercise
        else library.starting_machine()
        if machine
        else library.starting_scene(name, form, follower)
    )
    if file and file.exists():
        raise BadInput([Mistake("camopt", "FILE", str(file), "a new file: this one exists")])
    if file:
        library.write_text(file, text)
    if not (as_json or file):
        sys.stdout.write(text)
    return cli.print_json_or_files(
        {"file": file and str(file), "toml": text}, as_json, quiet, filter(None, (file,))
    )


@click.command(cls=Command)
@click.argument("name", required=False)
@output_options
def scenes(name: str | None, as_json: bool, quiet: bool) -> int:
    """List the shipped scenes and machines, or print one.

    With a NAME, camopt prints that scene or machine as TOML.
    """
    if name is None:
        return cli.print_result(library.list_scenes(), as_json, quiet)
    scenes, machines = camopt.shipped_scenes(), camopt.shipped_machines()
    if name not in (*scenes, *machines):
        why = f"a shipped scene or machine; {suggest_names(name, (*scenes, *machines))}"
        raise BadInput([Mistake("camopt", "NAME", name, why)])
    text = library.shipped_machine_toml(name) if name in machines else library.shipped_toml(name)
    if as_json:
        cli.print_json({"name": name, "toml": text})
    else:
        sys.stdout.write(text)
    return 0


@click.command(cls=Command)
@click.argument("table", required=False)
@output_options
def keys(table: str | None, as_json: bool, quiet: bool) -> int:
    """List the keys of a scene, with units and defaults.

    TABLE is a table, such as cam or follower.dynamics, or a key, such as rpm or cam.rpm. Without it camopt lists
    all keys; machine has the keys of machines. Besides the listed keys, [limits] takes the name of any quantity.
    """
    return cli.print_result(library.list_keys(table), as_json, quiet)


@click.command(cls=Command)
@output_options
def schema(as_json: bool, quiet: bool) -> int:
    """Print the JSON Schema of scenes.

    With it, editors complete keys and mark mistakes.
    """
    cli.print_json(library.scene_schema())
    return 0


@click.command(cls=Command)
@output_options
def laws(as_json: bool, quiet: bool) -> int:
    """List the motion laws with their peak factors.

    The factors are the peak velocity, acceleration and jerk of a unit stroke.
    """
    with cli.progress(quiet, ""):
        result = library.list_laws()
    return cli.print_result(result, as_json, quiet)

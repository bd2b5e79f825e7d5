"""``camopt warm``."""

import click

from camopt import cli
from camopt.cli.options import Command, output_options


@click.command(cls=Command)
@click.argument("scenes", nargs=-1)
@output_options
def warm(scenes: tuple[str, ...], as_json: bool, quiet: bool) -> int:
    """Compile what first runs need, and keep it on this machine.

    SCENES are TOML files or shipped scenes; without any, all shipped scenes. Commands then compile nothing for
    these, nor for others with the same followers and quantities. Run it once in an image of a container or in CI.
    """
    from camopt.studies.first_runs import compile_scenes

    with cli.progress(quiet, "scenes") as advance:
        kernels, folder = compile_scenes(scenes, advance)
    if as_json:
        cli.print_json({"kernels": kernels, "folder": str(folder)})
    else:
        cli.show(f"{kernels} kernels are in {folder}.")
    return 0

"""Commands on computing time: what each effect and digit of accuracy costs, and kernels compiled in advance."""

from pathlib import Path
from typing import Any

import click

from camopt import cli, library
from camopt.cli.options import (
    DEFAULT_SCENE,
    Command,
    OutputPath,
    former_again_option,
    output_options,
    refuse_options_without,
    scene_options,
    scheduler_option,
)


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--spectrum",
    is_flag=True,
    help="Compute the response spectra of the motion laws in place of the table.",
)
@click.option(
    "--out",
    type=OutputPath(),
    default="camopt-out",
    show_default=True,
    help="With --spectrum: folder for its files.",
)
@former_again_option
def effects(scene: Any, as_json: bool, quiet: bool, spectrum: bool, out: Path) -> int:
    """Show which computations a scene needs.

    The table says why each computation (effect) runs, and how long it takes.
    """
    if spectrum:
        with library.publication(out, "effects", library.SPECTRUM) as unit:
            spectra = library.spectra_of(scene)
            spectra.write(unit.staging)
        return cli.print_result(spectra, as_json, quiet, unit.files)
    with cli.progress(quiet, ""):
        result = library.cost_report(scene)
    return cli.print_result(result, as_json, quiet)


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--out",
    type=OutputPath(),
    default="camopt-out",
    show_default=True,
    help="Folder for the table and the pictures.",
)
@click.option("--workers", type=click.IntRange(1), help="Number of processes of --scheduler local.")
@former_again_option
@scheduler_option
def accuracy(scene: Any, as_json: bool, quiet: bool, out: Path, workers: int | None, engine: Any) -> int:
    """Measure what accuracy costs in time.

    The result is a table and a picture of error against time.
    """
    if engine is None:
        refuse_options_without("--scheduler", {"workers": workers})
    with library.publication(out, "accuracy", library.ACCURACY) as unit, cli.progress(quiet, "laws") as advance:
        result = library.measure_accuracy_costs(scene, advance, engine)
        library.write_accuracy(result, unit.staging)
    return cli.print_result(result, as_json, quiet, unit.files)


@click.command(cls=Command)
@click.argument("scenes", nargs=-1)
@output_options
def warm(scenes: tuple[str, ...], as_json: bool, quiet: bool) -> int:
    """Compile what first runs need.

    SCENES are TOML files or shipped scenes; by default all shipped scenes. The machine code is kept on this
    machine. Later commands do not compile again for these scenes, nor for scenes with the same followers and
    quantities. Run it once in a container image or in CI.
    """
    from camopt.show.studies.first_runs import compile_kernels_for_scenes

    with cli.progress(quiet, "scenes") as advance:
        kernels, folder = compile_kernels_for_scenes(scenes, advance)
    if as_json:
        cli.print_json({"kernels": kernels, "folder": str(folder)})
    else:
        cli.print_sections(f"Compiled kernels in {folder}: {kernels}.")
    return 0

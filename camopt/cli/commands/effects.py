"""``camopt effects``."""

from pathlib import Path
from typing import Any

import click

from camopt import cli, library
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
    if spectrum:
        with library.publication(out, "effects", library.SPECTRUM) as unit:
            spectra = library.spectra_of(scene)
            spectra.write(unit.staging)
        return cli.print_result(spectra, as_json, quiet, unit.files)
    with cli.progress(quiet, ""):
        result = library.cost_report(scene)
    return cli.print_result(result, as_json, quiet)

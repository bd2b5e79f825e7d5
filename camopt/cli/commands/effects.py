"""``camopt effects``."""

from pathlib import Path
from typing import Any

import click

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
    from camopt.cli import terminal
    from camopt.cli.commands.effects_report import show_cost_report, show_spectrum
    from camopt.storage.publishing import publication
    from camopt.studies.cost_report import cost_report

    if not spectrum:
        with terminal.progress(quiet, ""):
            result = cost_report(scene)
        show_cost_report(result, as_json)
        return 0
    from camopt.studies.spectrum import SPECTRUM, write_spectrum
    from camopt.studies.spectrum import spectrum as spectra

    with publication(out, "effects", SPECTRUM) as unit:
        rows = spectra(scene)
        write_spectrum(rows, unit.staging)
    show_spectrum(rows, as_json)
    if not quiet:
        terminal.say_written(unit.files)
    return 0

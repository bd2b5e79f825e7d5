"""``camopt effects``."""

from functools import partial
from pathlib import Path
from typing import Any

import click

from camopt.cli.once import Once, OnceCommand, Report, once
from camopt.cli.options import (
    DEFAULT_SCENE,
    OutputPlace,
    again_option,
    output_options,
    refuse_without,
    scene_options,
)


@click.command(cls=OnceCommand, place=lambda out, spectrum, **_: (out, "effects") if spectrum else None)
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
@again_option
def effects(scene: Any, as_json: bool, quiet: bool, spectrum: bool, out: Path, again: bool) -> int:
    """Show which computations (effects) a scene needs, why, and how long each takes."""
    from camopt.cli import terminal
    from camopt.cli.commands.effects_report import show_cost_report, show_spectrum

    if spectrum:
        from camopt.studies.spectrum import SPECTRUM, write_spectrum
        from camopt.studies.spectrum import spectrum as spectra

        def work(unit: Any) -> Report:
            rows = spectra(scene)
            write_spectrum(rows, unit.staging)
            return Report(partial(show_spectrum, rows), 0)

        return once(Once(out, "effects", SPECTRUM, {}), scene, again, as_json, quiet, work)
    refuse_without("--spectrum", {"again": again or None})
    from camopt.studies.cost_report import cost_report

    with terminal.progress(quiet, ""):
        result = cost_report(scene)
    show_cost_report(result, as_json)
    return 0

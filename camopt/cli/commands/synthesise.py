"""``camopt synthesise``."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

import camopt
from camopt import cli, library
from camopt.cli.options import (
    DEFAULT_SCENE,
    PICTURES,
    Command,
    OutputPlace,
    check_folder,
    former_again_option,
    output_options,
    scene_options,
)


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--out", type=OutputPlace(), default="camopt-out", show_default=True, help="Folder for the scene and the laws."
)
@click.option(
    "--plot",
    "picture",
    type=OutputPlace(*PICTURES),
    help="Draw the cams of new and known laws: PNG, SVG, PDF.",
)
@former_again_option
def synthesise(scene: Any, as_json: bool, quiet: bool, out: Path, picture: Path | None) -> int:
    """Compute new motion laws (B-splines) that allow the smallest cam."""
    check_folder(scene, out, library.SCENE_FILE)
    if not quiet:
        cli.say_notes(library.lost_ramps(scene))
    with library.publication(out, "synthesise", library.SYNTHESIS) as unit:
        with cli.progress(quiet, "starts") as advance:
            result = camopt.synthesise(scene, progress=advance)
            known = library.known_laws_of(scene)
            library.write_laws(result, unit.staging)
            library.write_comparison(result, known, unit.staging)
            (prices,) = camopt.prices(result).values()
        if picture:
            camopt.plot(result, picture, known=known)
    result = replace(result, known=known, prices=prices)
    return cli.print_result(result, as_json, quiet, [*unit.files, *([picture] if picture else [])])

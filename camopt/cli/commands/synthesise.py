"""``camopt synthesise``."""

from pathlib import Path
from typing import Any

import click

from camopt.cli.exits import reached
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
    from camopt.cli import terminal
    from camopt.cli.commands.synthesise_report import show_synthesis
    from camopt.smallest.prices import prices
    from camopt.storage.publishing import publication
    from camopt.synthesis.compare import known_laws_of
    from camopt.synthesis.files import SCENE_FILE, SYNTHESIS, write_comparison, write_laws
    from camopt.synthesis.ramps import lost_ramps
    from camopt.synthesis.synthesise import synthesise as run

    check_folder(scene, out, SCENE_FILE)
    if not quiet:
        terminal.say_notes(lost_ramps(scene))
    with publication(out, "synthesise", SYNTHESIS) as unit:
        with terminal.progress(quiet, "starts") as advance:
            result = run(scene, advance)
            known = known_laws_of(scene)
            write_laws(result, unit.staging)
            write_comparison(result, known, unit.staging)
            (costs,) = prices(result).values()
        if picture:
            from camopt.drawing.plot import plot

            plot(result, picture, known=known)
    show_synthesis(result, known, costs, as_json)
    if not quiet:
        terminal.say_written([*unit.files, *([picture] if picture else [])])
    return reached(scene, result.design["relative_half_width"])

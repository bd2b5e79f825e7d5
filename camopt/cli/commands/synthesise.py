"""``camopt synthesise``."""

from functools import partial
from pathlib import Path
from typing import Any

import click

from camopt.cli.exits import reached
from camopt.cli.once import Once, OnceCommand, Report, once
from camopt.cli.options import (
    DEFAULT_SCENE,
    PICTURES,
    OutputPlace,
    again_option,
    check_folder,
    output_options,
    scene_options,
)


@click.command(cls=OnceCommand, place=lambda out, picture, **_: None if picture else (out, "synthesise"))
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
@again_option
def synthesise(scene: Any, as_json: bool, quiet: bool, out: Path, picture: Path | None, again: bool) -> int:
    """Compute new motion laws (B-splines) that allow the smallest cam."""
    from camopt.cli import terminal
    from camopt.cli.commands.synthesise_report import show_synthesis
    from camopt.synthesis.files import SCENE_FILE, SYNTHESIS, write_comparison, write_laws
    from camopt.synthesis.ramps import lost_ramps

    def work(unit: Any) -> Report:
        from camopt.smallest.prices import prices
        from camopt.synthesis.compare import known_laws_of
        from camopt.synthesis.synthesise import synthesise as run

        with terminal.progress(quiet, "starts") as advance:
            result = run(scene, advance)
            known = known_laws_of(scene)
            write_laws(result, unit.staging)
            write_comparison(result, known, unit.staging)
            (costs,) = prices(result).values()
        if picture:
            from camopt.drawing.plot import plot

            plot(result, picture, known=known)
        code = reached(scene, result.design["relative_half_width"])
        return Report(partial(show_synthesis, result, known, costs), code)

    check_folder(scene, out, SCENE_FILE)
    made = Once(out, "synthesise", SYNTHESIS, {}, tuple(lost_ramps(scene)))
    code = once(made, scene, again or bool(picture), as_json, quiet, work)
    if picture and not quiet:
        terminal.say_written([picture])
    return code

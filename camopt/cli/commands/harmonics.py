"""``camopt harmonics``."""

from pathlib import Path
from typing import Any

import click

from camopt.cli.options import DEFAULT_SCENE, PICTURES, Command, OutputPlace, output_options, scene_options


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option("--orders", type=int, default=24, show_default=True, help="How many harmonics.")
@click.option("--plot", "picture", type=OutputPlace(*PICTURES), help="Draw their amplitudes: PNG, SVG, PDF.")
def harmonics(scene: Any, as_json: bool, quiet: bool, orders: int, picture: Path | None) -> int:
    """Compute the harmonics of a motion and of its acceleration."""
    from camopt.cli import terminal
    from camopt.problem.rows import finite
    from camopt.studies.harmonics import harmonics as run

    result = run(scene, orders)
    if picture:
        from camopt.drawing.plot import plot

        plot(result, picture)
    if as_json:
        about = {"scene": scene.name, "mean": result.mean, "acceleration_unit": result.acceleration_unit}
        terminal.print_json({**about, "harmonics": [finite(each) for each in result.records()]})
    else:
        terminal.show(result.table())
    if picture and not quiet:
        terminal.say_written([picture])
    return 0

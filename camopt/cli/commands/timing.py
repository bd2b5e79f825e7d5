"""``camopt timing``."""

from typing import Any

import click

from camopt.cli.options import DEFAULT_SCENE, Command, output_options, scene_options


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--lift",
    "lifts",
    type=float,
    multiple=True,
    help="A lift from the lowest position, mm (deg); repeatable. By default the lash, or else half of the largest.",
)
def timing(scene: Any, as_json: bool, quiet: bool, lifts: tuple[float, ...]) -> int:
    """Find where in the turn the follower passes a lift, as a valve's opening and closing.

    For a scene with [tolerances] the table also shows the earliest and the latest cam angle at which a cam within
    them passes, to first order. A second table shows the cam angles before and after which no cam passes, proved by
    exact contact, with the errors of a cam that passes nearly there.
    """
    from camopt.cli import terminal
    from camopt.problem.rows import finite
    from camopt.studies.timing import timing as run

    result = run(scene, lifts or None)
    if as_json:
        about = {"scene": scene.name, "velocity_unit": result.velocity_unit}
        worst = [finite(each._asdict()) for each in result.worst]
        terminal.print_json({**about, "passages": [finite(each) for each in result.records()], "worst": worst})
    else:
        for table in filter(None, (result.table(), result.worst_table())):
            terminal.show(table)
    return 0

"""``camopt tolerance``."""

from pathlib import Path
from typing import Any

import click

from camopt.cli.options import PICTURES, Command, OutputPlace, output_options, scene_options


@click.command(cls=Command)
@click.argument("scene")
@scene_options
@output_options
@click.option(
    "--plot", "picture", type=OutputPlace(*PICTURES), help="Draw the errors over the turn: PNG, SVG, PDF."
)
def tolerance(scene: Any, as_json: bool, quiet: bool, picture: Path | None) -> int:
    """Find how far the motion of a real cam may be off, by the tolerances of the scene.

    The table shows the worst case of displacement, velocity and acceleration, what each tolerance contributes to
    it, and what 99.73 % of the cams hold if errors are independent. A second one shows what tolerances of sizes
    leave of each limit: the worst cam within them, and whether every cam holds it, proved.
    """
    from camopt.cli import terminal
    from camopt.problem.rows import finite
    from camopt.tolerances.tolerance import tolerance as run

    result = run(scene)
    if picture:
        from camopt.drawing.plot import plot

        plot(result, picture)
    if as_json:
        dwells = [each._asdict() for each in result.dwells]
        errors = [{**finite(each), "shares": finite(each["shares"])} for each in result.records()]
        margins = [finite(each._asdict()) for each in result.margins]
        about = {"dwells": dwells, "reason": result.reason, "margins": margins}
        terminal.print_json({"scene": scene.name, "errors": errors, **about})
    else:
        terminal.show(result.table())
        if (limits := result.margins_table()) is not None:
            terminal.show(limits)
    if picture and not quiet:
        terminal.say_written([picture])
    return 0

"""``camopt export``."""

from pathlib import Path
from typing import Any

import click

import camopt
from camopt import cli
from camopt.cli.options import Command, Measure, OutputPlace, Renamed, check_file, output_options, scene_options
from camopt.exporting.endings import ENDINGS


@click.command(cls=Command)
@click.argument("scene")
@click.argument("file", type=OutputPlace(*ENDINGS))
@scene_options
@output_options
@click.option("--disc", type=int, help="Of a conjugate pair, the disc that is in the file alone: 1 or 2.")
@click.option("--chord", type=Measure("mm"), help="Largest deviation from the true curve, mm; 0.001 by default.")
@click.option("--curves", help="What curves are made of: arcs (the default), spline or polyline.")
@click.option(
    "--cutter-radius", type=Measure("mm"), help="Also the path of a cutter or grinding wheel of this radius, mm."
)
@click.option("--step", type=float, help="Points, or rows of a drawing's table, in even steps of the angle, deg.")
@click.option(
    "--point-count",
    "points",
    cls=Renamed,
    former="--points",
    type=int,
    help="Number of points of an electronic cam; 361 by default.",
)
@click.option("--feed", type=Measure("mm/min"), help="Feed of a cutter, mm/min.")
@click.option(
    "--depth", type=Measure("mm"), help="Depth of the cut below the top face, mm; the thickness and 1 by default."
)
@click.option("--roughing", type=Measure("mm"), help="A first cut that leaves so much, mm.")
@click.option("--direction", help="climb (the default) or conventional milling.")
@click.option("--control", help="Whose words a program has: iso, fanuc, siemens or heidenhain; by the ending.")
@click.option("--decimals", type=int, help="Decimals of its coordinates; those of the control by default.")
@click.option("--rotary", help="Axis about which a grooved cylinder turns: A (the default) or C.")
@click.option("--tool", type=int, help="Number of the cutter, for a tool call.")
@click.option("--spindle", type=float, help="Speed of the cutter, rev/min.")
@click.option("--coolant", is_flag=True, default=None, help="Switch the coolant on.")
@click.option(
    "--roughing-feed", type=Measure("mm/min"), help="Feed of first cuts, mm/min; that of --feed by default."
)
@click.option("--depth-step", type=Measure("mm"), help="Largest depth of one cut, mm.")
@click.option(
    "--blank-diameter", type=Measure("mm"), help="Diameter of the blank, mm; as wide as the cam by default."
)
@click.option(
    "--largest-radius", type=Measure("mm"), help="Arcs of a larger radius are lines, mm; 10000 by default."
)
def export(scene: Any, file: Path, as_json: bool, quiet: bool, **settings: Any) -> int:
    """Write the cam of one design to FILE for a machine, a person or another program, as its ending says.

    How far the curves in the file are from the true ones is proved, and printed. Options that mean nothing for a
    kind of file are refused.
    """
    check_file(scene.file, file, "FILE")
    with cli.progress(quiet, ""):
        result = camopt.export(
            scene, file, **{name: value for name, value in settings.items() if value is not None}
        )
    return cli.print_result(result, as_json, quiet, [file])

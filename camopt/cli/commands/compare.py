"""``camopt compare``."""

from pathlib import Path

import click

import camopt
from camopt import cli
from camopt.cli.options import PICTURES, Command, OutputPlace, output_options


@click.command(cls=Command)
@click.argument("a", metavar="A")
@click.argument("b", metavar="B")
@click.option("--out", type=OutputPlace(".parquet", ".csv"), help="Table of the designs that differ: Parquet, CSV.")
@click.option("--plot", "picture", type=OutputPlace(*PICTURES), help="Draw the fronts: PNG, SVG, PDF.")
@output_options
def compare(a: str, b: str, as_json: bool, quiet: bool, out: Path | None, picture: Path | None) -> int:
    """Compare two results: which designs came, went or changed, how the fronts differ, which settings differ.

    A and B are folders that a command wrote, tables of designs, or scenes; a scene beside a table is compared with
    the scene in it. Of two scenes with all sizes the quantities that differ stand side by side. The
    exit code is 0 whether or not they differ; --json says it under "same".
    """
    result = camopt.compare(a, b, out=out)
    if picture:
        camopt.plot(result, picture)
    return cli.print_result(result, as_json, quiet, filter(None, (out, picture)))

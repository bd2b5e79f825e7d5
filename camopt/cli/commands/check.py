"""``camopt check``."""

from pathlib import Path

import click

import camopt
from camopt import cli
from camopt.cli.options import Command, OutputPlace, output_options


@click.command(cls=Command)
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=OutputPlace())
@output_options
def check(files: tuple[Path, ...], as_json: bool, quiet: bool) -> int:
    """Check whether files are as camopt wrote them, bit for bit.

    FILE is a table, any other file of a result, or a folder. Tables and parts of sweeps have digests of their own;
    other files of a result are known by manifest.json beside them, and so are files that are missing, or of another
    run.

    Ends with 3 if a file is damaged, changed or missing; else with 2 if there is nothing to check one by.
    """
    with cli.progress(quiet, ""):
        result = camopt.check(*files)
    return cli.print_result(result, as_json, quiet)

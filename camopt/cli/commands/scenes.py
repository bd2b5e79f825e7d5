"""``camopt scenes``."""

import sys

import click

import camopt
from camopt import cli, library
from camopt.cli.options import Command, output_options
from camopt.mistakes import BadInput, Mistake, nearest


@click.command(cls=Command)
@click.argument("name", required=False)
@output_options
def scenes(name: str | None, as_json: bool, quiet: bool) -> int:
    """List the scenes that come with camopt; with a NAME, print that one as TOML."""
    if name is None:
        return cli.print_result(library.list_scenes(), as_json, quiet)
    if name not in camopt.shipped_scenes():
        raise BadInput(
            [Mistake("camopt", "NAME", name, f"a shipped scene; {nearest(name, camopt.shipped_scenes())}")]
        )
    text = library.shipped_toml(name)
    if as_json:
        cli.print_json({"name": name, "toml": text})
    else:
        sys.stdout.write(text)
    return 0

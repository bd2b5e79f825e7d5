"""The command line: modules of ``camopt.cli.commands`` have its commands, imported when they are needed."""

from collections.abc import Iterator, Mapping
from importlib import import_module

import click

from camopt.cli.exits import run_command
from camopt.core.storage.version import VERSION

MODULES = {
    "lists": ("new", "scenes", "keys", "schema", "laws"),
    "design": ("evaluate", "plot", "certify", "timing", "harmonics", "export"),
    "searches": ("sweep", "merge", "optimise", "synthesise", "frontier"),
    "results": ("report", "serve", "compare", "check"),
    "real_cams": ("tolerance", "fit"),
    "costs": ("effects", "accuracy", "warm"),
}
"""Modules of ``camopt.cli.commands``, each with the names of its commands, which are those of their functions."""
COMMANDS = {name: module for module, names in MODULES.items() for name in names}
"""Names of the commands, each with its module."""


class Imported(Mapping[str, click.Command]):
    """The commands by name."""

    def __getitem__(self, name: str) -> click.Command:
        command: click.Command = getattr(import_module(f"camopt.cli.commands.{COMMANDS[name]}"), name)
        return command

    def __iter__(self) -> Iterator[str]:
        return iter(COMMANDS)

    def __len__(self) -> int:
        return len(COMMANDS)


class Aliased(click.Group):
    """A group that also takes the American spelling."""

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        return super().get_command(
            ctx, cmd_name.removesuffix("ize") + "ise" if cmd_name.endswith("ize") else cmd_name
        )


@click.group(
    cls=Aliased,
    commands=Imported(),
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(VERSION, prog_name="camopt")
@click.pass_context
def camopt(context: click.Context) -> None:
    """Find the smallest cam that gives a motion within your limits, and what a smaller one would cost.

    SCENE is a TOML file, or the name of a scene that comes with camopt (`camopt scenes` lists them). Without one,
    commands take roller-1000rpm; evaluate and certify need one.

    Exit codes: 0 done; 1 no feasible design, or certify finds a limit broken; 2 bad input; 3 trouble with a file or
    memory; 4 the accuracy was not reached, or a limit is undecided; 70 an error of camopt itself; 129 its
    terminal was closed (SIGHUP); 130 interrupted; 141 the program that read the output has ended; 143 SIGTERM.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def main(arguments: list[str] | None = None) -> int:
    """Run a command; the exit code. A user's mistake is a message, never a traceback."""
    return run_command(lambda: camopt.main(arguments, prog_name="camopt", standalone_mode=False) or 0)

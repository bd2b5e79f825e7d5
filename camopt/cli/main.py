"""The command line: lists the commands, and imports the module of one when it is called."""

from collections.abc import Iterator, Mapping
from importlib import import_module

import click

from camopt.cli.exits import run_command
from camopt.core.storage.version import VERSION

GROUPS = {
    "Start": {"new": "lists", "serve": "results", "scenes": "lists", "laws": "lists", "keys": "lists"},
    "One cam": dict.fromkeys(("evaluate", "certify", "plot", "export", "harmonics", "timing"), "design"),
    "Find": dict.fromkeys(("optimise", "sweep", "merge", "synthesise", "frontier"), "searches"),
    "Check": dict.fromkeys(("tolerance", "fit"), "real_cams"),
    "Machine": {"machine": "machines"},
    "Results": dict.fromkeys(("report", "compare", "check"), "results"),
    "Inside": {"effects": "costs", "accuracy": "costs", "warm": "costs", "schema": "lists"},
}
"""Headings of the help: for each, the commands and their modules in ``camopt.cli.commands``."""
MODULE_BY_COMMAND = {name: module for commands in GROUPS.values() for name, module in commands.items()}
"""Module of each command."""


class LazyCommands(Mapping[str, click.Command]):
    """The commands by name, imported when they are read."""

    def __getitem__(self, name: str) -> click.Command:
        command: click.Command = getattr(import_module(f"camopt.cli.commands.{MODULE_BY_COMMAND[name]}"), name)
        return command

    def __iter__(self) -> Iterator[str]:
        return iter(MODULE_BY_COMMAND)

    def __len__(self) -> int:
        return len(MODULE_BY_COMMAND)


class Camopt(click.Group):
    """The group of all commands: listed under headings, and found in American spelling too."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands, a section for each heading."""
        for heading, names in GROUPS.items():
            with formatter.section(heading):
                formatter.write_dl([(name, self.commands[name].get_short_help_str(58)) for name in names])

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        return super().get_command(
            ctx, cmd_name.removesuffix("ize") + "ise" if cmd_name.endswith("ize") else cmd_name
        )


@click.group(
    cls=Camopt,
    commands=LazyCommands(),
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(VERSION, prog_name="camopt")
@click.pass_context
def camopt(context: click.Context) -> None:
    """Find the smallest cam for a motion within your limits, and what a smaller one would cost.

    SCENE is a TOML file, or the name of a scene that comes with camopt (`camopt scenes` lists them). Most commands
    take roller-1000rpm by default.

    Exit codes: 0 done; 1 no feasible design, or certify finds a limit broken; 2 bad input; 3 trouble with a file or
    memory; 4 accuracy not reached, or a limit is undecided; 70 internal error of camopt; 129 terminal closed
    (SIGHUP); 130 interrupted; 141 output pipe closed; 143 terminated (SIGTERM).
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def main(arguments: list[str] | None = None) -> int:
    """Run a command and return its exit code. A user's mistake prints a message, never a traceback."""
    return run_command(lambda: camopt.main(arguments, prog_name="camopt", standalone_mode=False) or 0)

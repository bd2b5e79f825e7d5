"""The command line: modules of ``camopt.cli.commands`` have its commands, imported when they are needed."""

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
    "Results": dict.fromkeys(("report", "compare", "check"), "results"),
    "Inside": {"effects": "costs", "accuracy": "costs", "warm": "costs", "schema": "lists"},
}
"""Headings of the help, each with its commands and their modules in ``camopt.cli.commands``."""
MODULE_BY_COMMAND = {name: module for commands in GROUPS.values() for name, module in commands.items()}
"""Names of the commands, each with its module."""


class LazyCommands(Mapping[str, click.Command]):
    """The commands by name."""

    def __getitem__(self, name: str) -> click.Command:
        command: click.Command = getattr(import_module(f"camopt.cli.commands.{MODULE_BY_COMMAND[name]}"), name)
        return command

    def __iter__(self) -> Iterator[str]:
        return iter(MODULE_BY_COMMAND)

    def __len__(self) -> int:
        return len(MODULE_BY_COMMAND)


class Camopt(click.Group):
    """The commands: listed under headings, and taken in American spelling too."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands, a section for each heading."""
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

"""``camopt serve``."""

import sys
import webbrowser
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any

import click

from camopt import cli
from camopt.cli import interrupts
from camopt.cli.exits import say
from camopt.cli.options import DEFAULT_SCENE, Command, OutputPlace, output_options, scene_options


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port to listen on; by default a free one.")
@click.option(
    "--folder", type=OutputPlace(), help="Folder for what is saved; by default that of SCENE, or this one."
)
@click.option("--no-browser", is_flag=True, help="Only print the address.")
def serve(scene: Any, as_json: bool, quiet: bool, port: int, folder: Path | None, no_browser: bool) -> int:
    """Show a cam with sliders for sizes, laws and limits, in a browser on this machine alone.

    Each move draws the cam and its diagrams anew; where the sliders rest, the limits are proved. Ctrl-C ends it.
    """
    from camopt.reporting.server import serving

    place = Path(scene.file).parent if Path(scene.file).is_file() else Path()
    server = serving(scene, folder or place, port, say)
    with suppress(KeyboardInterrupt), server:
        if as_json:
            cli.print_json({"address": server.address})
        else:
            click.echo(f"{server.address}\nCtrl-C ends it.")
        sys.stdout.flush()
        if not no_browser:  # in a thread of its own, for some browsers run in this terminal until they are closed
            Thread(target=webbrowser.open, args=[server.first_address], daemon=True).start()
        server.serve_forever()
    return 0 if interrupts.code() == interrupts.CTRL_C else interrupts.code()

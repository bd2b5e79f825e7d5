"""``camopt plot``."""

from pathlib import Path
from typing import Any

import click

import camopt
from camopt import cli
from camopt.cli.options import (
    ANIMATIONS,
    PICTURES,
    Command,
    OutputPlace,
    output_options,
    refuse_without,
    scene_options,
)


@click.command(cls=Command)
@click.argument("scene")
@click.argument("file", type=OutputPlace(*dict.fromkeys((*PICTURES, *ANIMATIONS))))
@scene_options
@output_options
@click.option(
    "--construction",
    type=int,
    is_flag=False,
    flag_value=6,
    metavar="[N]",
    help="Draw how the cam is constructed, with N equal parts a stroke (6), and print the table by station.",
)
@click.option("--steps", is_flag=True, help="With --construction: a page of a PDF, or a frame of a GIF, a step.")
def plot(scene: Any, file: Path, as_json: bool, quiet: bool, construction: int | None, steps: bool) -> int:
    """Draw the cam with its diagrams to FILE: PNG, SVG or PDF; GIF and MP4 show it turning.

    With --construction, FILE shows how the cam is drawn with ruler and compasses, as lectures teach it.
    """
    document: dict[str, Any] = {"scene": scene.name, "file": str(file)}
    if construction is None:
        refuse_without("--construction", {"steps": steps or None})
    if construction is None and file.suffix.lower() not in PICTURES:
        camopt.animate(scene, file)
    elif construction is None:
        camopt.plot(scene, file)
    else:
        found = camopt.construct(scene, construction)
        camopt.plot(found, file, steps=steps)
        document |= found.to_dict()
        if not (quiet or as_json):
            cli.show(found.table())
    if as_json:
        cli.print_json(document)
    elif not quiet:
        cli.say_written([file])
    return 0

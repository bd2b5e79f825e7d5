"""``camopt optimise``."""

from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

import camopt
from camopt import cli, library
from camopt.cli.options import (
    DEFAULT_SCENE,
    Command,
    OutputPlace,
    check_folder,
    former_again_option,
    output_options,
    outputs_option,
    scene_options,
)

NO_SECONDS = 1e-9  # over at once: where none are left, bounds have prices, and nothing is sought without them


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@outputs_option
@output_options
@click.option(
    "--out", type=OutputPlace(), help="Folder to write the smallest cam of each law to, as a scene (TOML)."
)
@click.option(
    "--seconds",
    type=click.FloatRange(0, min_open=True),
    default=60,
    show_default=True,
    help="Time for the searches. After it, the smallest cam so far is shown, and how much smaller one might be.",
)
@former_again_option
def optimise(scene: Any, as_json: bool, quiet: bool, out: Path | None, seconds: float) -> int:
    """Find the smallest cam of each motion law that meets every limit."""
    if out:
        check_folder(scene, out, library.OPTIMUM)
    if not quiet:
        cli.say_notes((*library.notes_of(scene), *_other_objectives(scene)))
    written = library.publication(out, "optimise", (library.OPTIMUM,)) if out else nullcontext()
    with written as unit, cli.progress(quiet, "laws") as advance:
        end = library.now() + seconds
        result = camopt.optimise(scene, progress=advance, seconds=seconds)
        if unit:
            library.write_scenes(result.by_law, unit.staging)
        result = replace(result, prices=camopt.prices(result, max(end - library.now(), NO_SECONDS)))
    return cli.print_result(result, as_json, quiet, unit.files if unit else ())


def _other_objectives(scene: Any) -> Iterator[str]:
    """A sentence on objectives that are for sweeps: here the size alone is one."""
    named = [*scene.search.minimise, *scene.search.maximise]
    if named and scene.mechanism.body.size_quantity not in named:
        yield f"search: optimise minimises the size, and not {', '.join(named)}, which sweep does"

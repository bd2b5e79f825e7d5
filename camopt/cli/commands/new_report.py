"""The output of ``camopt new``."""

import sys
from pathlib import Path

from camopt.cli.terminal import print_json, say_written
from camopt.mistakes import BadInput, Mistake
from camopt.scene.starting import starting_scene


def show_new(
    name: str | None, file: Path | None, form: str | None, follower: str | None, as_json: bool, quiet: bool
) -> None:
    """A scene to start from, in a file of its own or on the screen."""
    if name and name.endswith(".toml") and file is None:
        file, name = Path(name), None
    text = starting_scene(name, form, follower)
    if file and file.exists():
        raise BadInput([Mistake("camopt", "FILE", str(file), "a new file: this one is there already")])
    if file:
        file.write_text(text, encoding="utf-8")
    if as_json:
        return print_json({"file": file and str(file), "toml": text})
    if file is None:
        sys.stdout.write(text)
    elif not quiet:
        say_written([file])
    return None

"""The output of ``camopt new``."""

import sys
from pathlib import Path
from textwrap import wrap

from camopt.cli.terminal import print_json, say_written
from camopt.mistakes import BadInput, Mistake
from camopt.scene.starting import starting_scene
from camopt.storage.files import checked_path, write_text


def show_new(
    name: str | None,
    file: Path | None,
    form: str | None,
    follower: str | None,
    exercise: tuple[str, int] | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """A scene to start from, in a file of its own or on the screen."""
    if name and name.endswith(".toml") and file is None:
        file, name = checked_path(name, "FILE"), None
    if exercise and name:
        raise BadInput([Mistake("camopt", "NAME", name, "does not go with --exercise", bare=True)])
    text = exercise_text(*exercise) if exercise else starting_scene(name, form, follower)
    if file and file.exists():
        raise BadInput([Mistake("camopt", "FILE", str(file), "a new file: this one is there already")])
    if file:
        write_text(file, text)
    if as_json:
        return print_json({"file": file and str(file), "toml": text})
    if file is None:
        sys.stdout.write(text)
    elif not quiet:
        say_written([file])
    return None


def exercise_text(kind: str, seed: int) -> str:
    """The scene of an exercise, under its problem as comments."""
    from camopt.studies.exercise import make_exercise

    problem, scene = make_exercise(kind, seed)
    return "".join(f"# {line}\n" for line in wrap(problem, 100)) + "\n" + scene.to_toml()

"""A plugin of pytest that keeps as cases what tests ask of camopt, by command or by public name, and it refuses.

``CASES=FOLDER python -m pytest -p recording TESTS``
"""

import os
import pickle
import re
from collections.abc import Callable
from contextlib import suppress
from functools import partial, wraps
from pathlib import Path
from typing import Any

import click
from answers import scene_of, write_case

import camopt

FOLDER = re.compile(r"/\S*/pytest-of-[^/]+/pytest-\d+/(?:popen-gw\d+/)?[^/\s']+")
LARGEST = 100_000  # bytes of files and of arguments


def case_of(name: str, arguments: tuple[Any, ...], named: dict[str, Any]) -> dict[str, Any]:
    """The case of a call, with the files of the test's folder, which is then the current one."""
    folder = next(iter(FOLDER.findall(f"{arguments} {named} {Path.cwd()}")), "/no/folder")
    paths = [path for path in Path(folder).rglob("*") if path.is_file()]
    small = sum(path.stat().st_size for path in paths) < LARGEST
    files = {str(path.relative_to(folder)): path.read_bytes() for path in paths} if small else {}

    def here(text: str) -> str:
        found = text.replace(f"{folder}/", "").replace(folder, ".")
        if "ccamopt" in found or "pytest-of" in found or len(found) > LARGEST:
            raise pickle.PicklingError("of the package itself, of other folders, or large")
        return found

    if name == "command":
        return {"files": files, "argv": [here(str(each)) for each in named["args"]]}
    plain = [str(each) if isinstance(each, Path) else each for each in arguments]
    return {"files": files, "call": name, "arguments": here(pickle.dumps((plain, named), 0).decode("latin-1"))}


def record(name: str, function: Callable[..., Any], kept: int, /, *arguments: Any, **named: Any) -> Any:
    """Call a function; a call that is refused is kept, without the first arguments."""
    try:
        return function(*arguments, **named)
    except (camopt.BadInput, click.ClickException):
        with suppress(Exception):  # an argument is a function or an open file, or has no text
            write_case(Path(os.environ["CASES"]), "refused", **case_of(name, arguments[kept:], named))
        raise


def main(self: click.Command, args: Any = None, prog_name: Any = None, **named: Any) -> Any:
    """A command of camopt, recorded."""
    call = partial(record, "command", run, 1) if prog_name == "camopt" else run
    return call(self, args=args, prog_name=prog_name, **named)


run, click.Command.main = click.Command.main, main  # type: ignore[method-assign]
camopt.Scene.__reduce__ = lambda scene: (scene_of, (scene.to_dict(),))  # type: ignore[method-assign, assignment]
for name in ("from_dict", "from_toml"):
    method = partial(record, f"Scene.{name}", getattr(camopt.Scene, name), 0)
    setattr(camopt.Scene, name, staticmethod(method))
replace = partial(record, "Scene.replace", camopt.Scene.replace, 0)
camopt.Scene.replace = lambda scene, **changes: replace(scene, **changes)  # type: ignore[method-assign]
for name in (name for name in camopt.__all__ if name[0].islower() and name != "cluster"):
    setattr(camopt, name, wraps(getattr(camopt, name))(partial(record, name, getattr(camopt, name), 0)))

"""The output of ``camopt check``."""

from collections.abc import Iterable
from dataclasses import asdict
from typing import TYPE_CHECKING

from camopt.cli.terminal import print_json, show_lines
from camopt.mistakes import printable

if TYPE_CHECKING:
    from camopt.storage.checking import FileCheck


def show_checked(found: "Iterable[FileCheck]", as_json: bool) -> None:
    """The state of each file, one a line."""
    if as_json:
        files = [{**asdict(each), "file": str(each.file)} for each in found]
        return print_json({"whole": all(each.is_whole for each in found), "files": files})
    return show_lines(printable(f"{each.file}: {each.told}") for each in found)

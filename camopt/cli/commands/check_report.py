"""The output of ``camopt check``."""

from collections.abc import Iterable
from dataclasses import asdict

import camopt
from camopt.cli.terminal import print_json, show_lines
from camopt.mistakes import printable


def show_checked(found: "Iterable[camopt.FileCheck]", as_json: bool) -> None:
    """The state of each file, one a line."""
    if as_json:
        files = [{**asdict(each), "file": str(each.file)} for each in found]
        return print_json({"whole": all(each.is_whole for each in found), "files": files})
    return show_lines(printable(f"{each.file}: {each.told}") for each in found)

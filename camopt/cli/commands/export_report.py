"""The output of ``camopt export``."""

import camopt
from camopt.cli.terminal import print_json, show


def show_export(result: "camopt.Export", as_json: bool) -> None:
    """The curves in a file with their proved deviations, and its other numbers."""
    if as_json:
        curves = {name: curve._asdict() for name, curve in result.curves.items()}
        return print_json({"file": str(result.file), "curves": curves, **result.about, "notes": list(result.notes)})
    for name, text in result.facts:
        show(f"{name}: {text}")
    return None

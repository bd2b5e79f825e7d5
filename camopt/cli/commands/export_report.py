"""What ``camopt export`` prints."""

from typing import TYPE_CHECKING

from camopt.cli.terminal import print_json, show
from camopt.tables.cells import number

if TYPE_CHECKING:
    from camopt.exporting.exported import Export


def show_export(result: "Export", as_json: bool) -> None:
    """The curves in a file with their proved deviations, and its other numbers."""
    if as_json:
        curves = {name: curve._asdict() for name, curve in result.curves.items()}
        return print_json({"file": str(result.file), "curves": curves, **result.about, "notes": list(result.notes)})
    for name, curve in result.curves.items():
        words = f"{curve.elements:,} {curve.what}, within {number(curve.deviation_mm)} mm (proved)"
        show(f"{name.replace('_', ' ')}: {words}")
    for name, value in result.about.items():
        show(f"{name}: {number(value) if isinstance(value, float) else value}")
    return None

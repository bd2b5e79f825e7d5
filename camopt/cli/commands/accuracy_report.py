"""The output of ``camopt accuracy``."""

from typing import TYPE_CHECKING, Any

from camopt.cli.terminal import print_json, show
from camopt.tables.layout import table_of

if TYPE_CHECKING:
    from camopt.scene.scene import Scene


def show_accuracy(rows: list[dict[str, Any]], scene: "Scene", as_json: bool) -> None:
    """Cost and error of each method."""
    if as_json:
        return print_json({"scene": scene.name, "methods": rows})
    names = list(rows[0])
    shown = [{name: f"{row[name]:.2g}" if name in names[4:] else row[name] for name in names} for row in rows]
    for row in shown:
        row |= {"setting": float(f"{row['setting']:.2g}"), "ns_per_design": float(f"{row['ns_per_design']:.3g}")}
    return show(table_of(f"{scene.name}: what accuracy costs", shown, names))

"""The output of ``camopt scenes``."""

import sys
import tomllib

from camopt.cli.terminal import print_json, show
from camopt.mistakes import BadInput, Mistake, nearest
from camopt.scene.sources import shipped_scenes, shipped_toml
from camopt.tables.layout import table_of


def show_scenes(name: str | None, as_json: bool) -> None:
    """The shipped scenes, or one of them as TOML."""
    if name is not None:
        if name not in shipped_scenes():
            raise BadInput([Mistake("camopt", "NAME", name, f"a shipped scene; {nearest(name, shipped_scenes())}")])
        text = shipped_toml(name)
        if as_json:
            return print_json({"name": name, "toml": text})
        sys.stdout.write(text)
        return None
    records = [{"name": each, "title": tomllib.loads(shipped_toml(each))["name"]} for each in shipped_scenes()]
    if as_json:
        return print_json(records)
    return show(table_of("Shipped scenes", records, ["name", "title"]))

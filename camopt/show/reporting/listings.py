"""Lists of the motion laws, of the keys of a scene, and of the shipped scenes and machines."""

import tomllib
from dataclasses import replace
from itertools import groupby
from typing import Any

from camopt.core.quantities.limit_keys import LIMIT_KEYS
from camopt.model.motion import LAWS
from camopt.model.motion.aliases import ALIASES
from camopt.model.motion.law import vdi_motion_task
from camopt.model.motion.programme import LAW_PEAKS, law_peaks, law_peaks_inside_stroke
from camopt.scene.keys import MACHINE_KEYS, KeyDescription, find_keys
from camopt.scene.machine import MACHINE_TABLES
from camopt.scene.scene import SCENE_TABLES
from camopt.scene.sources import shipped_machine_toml, shipped_machines, shipped_scenes, shipped_toml
from camopt.scene.table_places import table_heading
from camopt.solve.tables.result import ABOUT, Cell, Listing, Table, table_of

LAW_SCALING_NOTE = "For a stroke of lift h over an angle β (rad), multiply these peaks by h/β, h/β² and h/β³."


def list_laws() -> Listing:
    """The motion laws, the states that they join, and the peaks of their unit stroke."""
    records: list[dict[str, Any]] = [
        {
            "law": name,
            "title": law.TITLE,
            "joins": vdi_motion_task(law),
            **law_peaks(law),
            **{f"{peak}_inside": value for peak, value in law_peaks_inside_stroke(law).items()},
            "source": law.SOURCE,
            "aliases": list(ALIASES.get(name, ())),
        }
        for name, law in LAWS.items()
    ]
    names = ["law", "title", "joins", *LAW_PEAKS, "jumps"]
    title = "Motion laws for stroke 1, angle 1; they join rest R, constant velocity G, reversal U"
    jumping = [
        {**each, **{peak: each[f"{peak}_inside"] for peak in LAW_PEAKS}} for each in records if each["jumps"]
    ]
    other = [{"law": name, "other names": ", ".join(aliases)} for name, aliases in ALIASES.items()]
    parts = (
        replace(table_of(title, records, names), note=LAW_SCALING_NOTE),
        table_of("Peaks inside the stroke, for laws with a jump at a dwell", jumping, names[:-1]),
        table_of("Other names allowed in scenes", other, ["law", "other names"]),
    )
    return Listing(records, parts)


ANY_QUANTITY = "A limit can also be any quantity, such as limits.velocity_max_rise_m_s; see camopt keys NAME."
KEY_HEADS: list[Cell | str] = ["key", "unit", "allowed", "default", Cell("meaning", ABOUT)]


def list_keys(name: str | None) -> Listing:
    """The keys of one table of a scene, or of all tables; ``machine`` has those of a machine."""
    keys, tables = find_keys(name), MACHINE_TABLES if name == MACHINE_KEYS else {**MACHINE_TABLES, **SCENE_TABLES}
    return Listing(
        keys,
        tuple(
            _key_table(table, tables[table].__doc__ or "", [*each])
            for table, each in groupby(keys, lambda key: key.table)
        ),
    )


def _key_table(table: str, docstring: str, keys: list[KeyDescription]) -> Table:
    """Table of the keys of one table of a file; for limits only the short keys, and a note on the others."""
    summary = docstring.split("\n")[0].replace("``", "`")
    short = [key for key in keys if key.key.removeprefix("limits.") in LIMIT_KEYS]
    rows = short if table == "limits" and len(short) > 1 else keys
    title = f"{table_heading(table)}  {summary}" if table else "Top level"
    return Table.from_texts(title, KEY_HEADS, map(_key_row, rows), "" if rows is keys else ANY_QUANTITY)


def _key_row(key: KeyDescription) -> list[Cell | str]:
    """A key as a row of the table."""
    default = (
        "required" if key.needed else str(key.default).lower() if isinstance(key.default, bool) else key.default
    )
    return [key.key, key.unit, key.allowed, "" if default is None else str(default), Cell(key.sentence, ABOUT)]


def list_scenes() -> Listing:
    """The shipped scenes and machines with their titles."""
    texts = {
        "scene": {name: shipped_toml(name) for name in shipped_scenes()},
        "machine": {name: shipped_machine_toml(name) for name in shipped_machines()},
    }
    kinds = {
        kind: [{"name": name, "kind": kind, "title": tomllib.loads(text)["name"]} for name, text in each.items()]
        for kind, each in texts.items()
    }
    tables = (table_of(f"Shipped {kind}s", rows, ["name", "title"]) for kind, rows in kinds.items())
    return Listing([row for rows in kinds.values() for row in rows], (*tables,))

"""The output of ``camopt laws``."""

from dataclasses import replace
from typing import Any

from camopt.cli.terminal import print_json, show
from camopt.motion import LAWS
from camopt.motion.aliases import ALIASES
from camopt.motion.law import joined_by
from camopt.motion.programme import PEAKS, law_peaks, peaks_inside
from camopt.problem.rows import finite
from camopt.tables.layout import table_of

SCALED = "By the cam angle, a stroke of lift h over an angle β (rad) has these peaks times h/β, h/β² and h/β³."


def show_laws(as_json: bool) -> None:
    """The motion laws with what they join and the peaks of their unit stroke."""
    records: list[dict[str, Any]] = [
        {
            "law": name,
            "title": law.TITLE,
            "joins": joined_by(law),
            **law_peaks(law),
            **{f"{peak}_inside": value for peak, value in peaks_inside(law).items()},
            "source": law.SOURCE,
            "aliases": list(ALIASES.get(name, ())),
        }
        for name, law in LAWS.items()
    ]
    if as_json:
        return print_json([finite(record) for record in records])
    names = ["law", "title", "joins", *PEAKS, "jumps"]
    title = "Motion laws between dwells (stroke 1, angle 1); they join rest R, constant velocity G, reversal U"
    show(replace(table_of(title, records, names), note=SCALED))
    jumping = [{**each, **{peak: each[f"{peak}_inside"] for peak in PEAKS}} for each in records if each["jumps"]]
    show(table_of("Inside the stroke, of those with a jump beside a dwell", jumping, names[:-1]))
    other = [{"law": name, "other names": ", ".join(aliases)} for name, aliases in ALIASES.items()]
    return show(table_of("Other names that scenes may use", other, ["law", "other names"]))

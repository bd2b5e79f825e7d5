"""The list of motion laws, with what they join and their peaks."""

from dataclasses import replace
from typing import Any

from camopt.motion import LAWS
from camopt.motion.aliases import ALIASES
from camopt.motion.law import joined_by
from camopt.motion.programme import PEAKS, law_peaks, peaks_inside
from camopt.tables.layout import table_of
from camopt.tables.result import Listing

SCALED = "By the cam angle, a stroke of lift h over an angle β (rad) has these peaks times h/β, h/β² and h/β³."


def list_laws() -> Listing:
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
    names = ["law", "title", "joins", *PEAKS, "jumps"]
    title = "Motion laws between dwells (stroke 1, angle 1); they join rest R, constant velocity G, reversal U"
    jumping = [{**each, **{peak: each[f"{peak}_inside"] for peak in PEAKS}} for each in records if each["jumps"]]
    other = [{"law": name, "other names": ", ".join(aliases)} for name, aliases in ALIASES.items()]
    parts = (
        replace(table_of(title, records, names), note=SCALED),
        table_of("Inside the stroke, of those with a jump beside a dwell", jumping, names[:-1]),
        table_of("Other names that scenes may use", other, ["law", "other names"]),
    )
    return Listing(records, parts)

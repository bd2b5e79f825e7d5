"""The output of ``camopt certify``."""

from camopt.cli.terminal import print_json, show
from camopt.tables.layout import table_of


def show_verdicts(verdicts: dict[str, str], as_json: bool) -> None:
    """The verdict on each limit."""
    if as_json:
        return print_json(verdicts)
    records = [{"limit": name, "verdict": verdict} for name, verdict in verdicts.items()]
    return show(table_of("At every cam angle", records, ["limit", "verdict"]))


def show_counts(counts: dict[str, int], as_json: bool) -> None:
    """The numbers of rows of a table that are held, broken and undecided."""
    every = {verdict: counts.get(verdict, 0) for verdict in ("held", "broken", "undecided")}
    if as_json:
        return print_json(every)
    return show(", ".join(f"{count:,} {verdict}" for verdict, count in every.items()))

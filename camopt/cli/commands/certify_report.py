"""The output of ``camopt certify``."""

from camopt.cli.terminal import print_json, show
from camopt.tables.layout import table_of


def show_verdicts(verdicts: dict[str, str], as_json: bool, robust: bool = False) -> None:
    """The verdict on each limit, of the cam or, if robust, of all cams within its tolerances."""
    if as_json:
        return print_json(verdicts)
    records = [{"limit": name, "verdict": verdict} for name, verdict in verdicts.items()]
    title = "At every cam angle" + (", of every cam within the tolerances (search.robust)" if robust else "")
    return show(table_of(title, records, ["limit", "verdict"]))


def show_counts(counts: dict[str, int], as_json: bool) -> None:
    """The numbers of rows of a table that are held, broken and undecided."""
    every = {verdict: counts.get(verdict, 0) for verdict in ("held", "broken", "undecided")}
    if as_json:
        return print_json(every)
    return show(", ".join(f"{count:,} {verdict}" for verdict, count in every.items()))

"""Tables as HTML, for a notebook: short, and what is in them stays text."""

from collections.abc import Iterable, Sequence
from html import escape

MOST_ROWS = 40


def html_table(title: str, heads: Iterable[Sequence[str]], rows: Iterable[Sequence[str]]) -> str:
    """A table with a caption; ``heads`` has the lines of each column's heading. Of many rows the first ones."""
    rows = [*rows]
    head = "".join(f"<th>{'<br>'.join(map(escape, lines))}</th>" for lines in heads)
    body = "".join(f"<tr>{''.join(f'<td>{escape(text)}</td>' for text in row)}</tr>" for row in rows[:MOST_ROWS])
    if len(rows) > MOST_ROWS:
        body += f'<tr><td colspan="{len(rows[0])}">… and {len(rows) - MOST_ROWS:,} more rows</td></tr>'
    caption = f"<caption>{escape(title)}</caption>"
    return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"

"""Tables as HTML, for notebooks and pages; their contents are escaped."""

from html import escape

from camopt.tables.layout import Cell, Table

HTML_ROWS = 40


def html_table(table: Table, most: int = HTML_ROWS) -> str:
    """A table with a caption; of many rows the first ones. Kinds of column are classes."""
    head = "".join(map(_head, table.heads)) if table.is_headed else ""
    body = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in table.rows[:most])
    if len(table.rows) > most:
        more = f"… and {len(table.rows) - most:,} more rows"
        body += f'<tr><td colspan="{len(table.heads)}">{more}</td></tr>'
    note = f"<small>{escape(table.note)}</small>" if table.note else ""
    caption = f"<caption>{escape(table.title)}</caption>"
    return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{note}"


def _head(cell: Cell) -> str:
    lines = "<br>".join(escape(line) for line in cell.text.splitlines())
    return f'<th scope="col"{_of_kind(cell)}>{lines}</th>'


def _cell(cell: Cell) -> str:
    return f"<td{_of_kind(cell)}>{escape(cell.text)}</td>"


def _of_kind(cell: Cell) -> str:
    return f' class="{cell.kind}"' if cell.kind else ""

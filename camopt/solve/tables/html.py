"""Tables as HTML for notebooks and pages. All texts are escaped."""

from html import escape

from camopt.solve.tables.result import Branch, Cell, Table

HTML_ROWS = 40


def html_table(table: Table, most_rows: int = HTML_ROWS) -> str:
    """A table as HTML with a caption, at most ``most_rows`` rows, and the kinds of cells as CSS classes."""
    heads = ((_kind_attribute(cell), "<br>".join(map(escape, cell.text.splitlines()))) for cell in table.heads)
    head = "".join(f'<th scope="col"{kind}>{text}</th>' for kind, text in heads) if table.is_headed else ""
    body = "".join(f"<tr>{''.join(map(_html_cell, row))}</tr>" for row in table.rows[:most_rows])
    if len(table.rows) > most_rows:
        more = f"… and {len(table.rows) - most_rows:,} more rows"
        body += f'<tr><td colspan="{len(table.heads)}">{more}</td></tr>'
    note = f"<small>{escape(table.note)}</small>" if table.note else ""
    caption = f"<caption>{escape(table.title)}</caption>"
    return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{note}"


def html_section(part: Table | Branch | str) -> str:
    """A part of a result as HTML: a table, a tree as nested lists, or a sentence as a paragraph."""
    if isinstance(part, Table):
        return html_table(part)
    return f"<ul>{_html_branch(part)}</ul>" if isinstance(part, Branch) else f"<p>{escape(part)}</p>"


def _html_branch(branch: Branch) -> str:
    below = "".join(map(_html_branch, branch.branches))
    return f"<li>{escape(branch.text)}{f'<ul>{below}</ul>' if below else ''}</li>"


def _html_cell(cell: Cell) -> str:
    return f"<td{_kind_attribute(cell)}>{escape(cell.text)}</td>"


def _kind_attribute(cell: Cell) -> str:
    return f' class="{cell.kind}"' if cell.kind else ""

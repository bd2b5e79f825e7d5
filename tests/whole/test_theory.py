"""The pages of theory: the Python of a page evaluates each of its labelled equations beside camopt."""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {path.stem: path for path in sorted((DOCS / "theory").glob("*.md")) if path.stem != "index"}


def python_of(page):
    """The Python of a page, each line where it is there, so that failures point at the page."""
    parts = re.split(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    blocks = (part if k % 2 else "\n" * (part.count("\n") + 1) for k, part in enumerate(parts))
    return "".join(blocks)


def test_pages_are_found():
    assert {"motion-laws", "pressure-angle", "loads"} <= set(PAGES)


@pytest.mark.parametrize("name", PAGES)
def test_the_python_of_a_page_runs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(python_of(PAGES[name]), str(PAGES[name]), "exec"), {"__name__": name})


@pytest.mark.parametrize("name", PAGES)
def test_every_equation_with_a_label_is_checked(name):
    """A comment with the label of an equation heads the lines that check it, an assertion among them."""
    labels = re.findall(r"^\$\$ \(([a-z0-9-]+)\)$", PAGES[name].read_text(encoding="utf-8"), re.MULTILINE)
    _, *parts = re.split(r"^# \(([a-z0-9-]+)\)", python_of(PAGES[name]), flags=re.MULTILINE)
    checked = [
        label
        for label, lines in zip(parts[::2], parts[1::2], strict=True)
        if re.search(r"^ *assert ", lines, re.MULTILINE)
    ]
    assert sorted(checked) == sorted(labels)

"""The pages that people copy from: the README and the recipes, with their blocks of code."""

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs" / "how-to").glob("*.md"))]
FENCED = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
ALL = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)


class Block(NamedTuple):
    """A fenced block: its language and what is in it."""

    language: str
    text: str


def blocks(page: Path) -> list[Block]:
    """The blocks of a page, from top to bottom."""
    return [Block(*found) for found in FENCED.findall(page.read_text(encoding="utf-8"))]


def file_of(block: Block) -> str:
    """The file that a block of TOML belongs to, by the comment in its first line; "" without one."""
    named = re.match(r"# (\S+\.toml)\n", block.text) if block.language == "toml" else None
    return named[1] if named else ""


def commands(block: Block) -> list[tuple[str, str]]:
    """The commands of a block that start camopt, each with what the page says that it prints; "" in a script."""
    if block.language == "text":
        _, *parts = re.split(r"^\$ ", block.text, flags=re.MULTILINE)
        return [(line, said) for line, _, said in (part.partition("\n") for part in parts)]
    lines = block.text.splitlines() if block.language == "sh" else []
    return [(line, "") for line in lines if line.startswith("camopt ")]


def prints(expected: str, printed: str) -> bool:
    """Whether a text is what a page says, where … is anything in a line, or lines. Empty lines are skipped."""
    said, shown = ([line.rstrip() for line in text.splitlines() if line.strip()] for text in (expected, printed))
    lines = ["(.*\n)*" if line.strip() == "…" else re.escape(line).replace("…", ".*") + "\n" for line in said]
    return re.fullmatch("".join(lines), "".join(f"{line}\n" for line in shown)) is not None

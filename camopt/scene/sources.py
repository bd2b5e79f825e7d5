"""The scenes that come with the package."""

from functools import cache
from pathlib import Path

SHIPPED = Path(__file__).parent / "shipped"
SCHEMA = "scene.schema.json"
"""The JSON schema in this folder, which ``camopt.scene.schema`` makes."""


@cache
def shipped_scenes() -> tuple[str, ...]:
    """The names of the scenes that come with the package.

    Returns
    -------
    tuple
        Names for ``find_scene`` and for all commands.

    Examples
    --------
    >>> "exhaust-valve" in camopt.shipped_scenes()
    True
    """
    return tuple(sorted(path.stem for path in SHIPPED.glob("*.toml")))


def shipped_toml(name: str) -> str:
    """The text of a shipped scene, without the line that links the schema."""
    return (SHIPPED / f"{name}.toml").read_text(encoding="utf-8").removeprefix(f"#:schema ../{SCHEMA}\n")

"""The scenes and machines that come with the package."""

from functools import cache
from pathlib import Path

SHIPPED = Path(__file__).parent / "shipped"
MACHINES = SHIPPED / "machines"
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


@cache
def shipped_machines() -> tuple[str, ...]:
    """The names of the machines that come with the package.

    Returns
    -------
    tuple
        Names for ``find_machine`` and for ``camopt machine``.

    Examples
    --------
    >>> "pick-and-place" in camopt.shipped_machines()
    True
    """
    return tuple(sorted(path.stem for path in MACHINES.glob("*.toml")))


def shipped_machine_toml(name: str) -> str:
    """The text of a shipped machine. It names files of the package, which ``path_beside_machine`` finds."""
    return (MACHINES / f"{name}.toml").read_text(encoding="utf-8")


def path_beside_machine(folder: Path | None, name: str) -> Path:
    """The path of a file that a machine names: beside the machine, or else beside the shipped machines."""
    path, shipped = (folder or Path()) / name, MACHINES / name
    return shipped if shipped.is_file() and not path.is_file() else path

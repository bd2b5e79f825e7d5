"""The scene itself as TOML: the source of every other file."""

from pathlib import Path

from camopt.scene.scene_file import write_scene
from camopt.show.exporting.workpiece import Export, Workpiece


def write(work: Workpiece, path: Path) -> Export:
    """Write the scene as TOML, with all data that it reads from other files."""
    write_scene(path, work.scene)
    return Export(path)

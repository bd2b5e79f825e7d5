"""Kinds of files for a cam, by ending."""

from typing import NamedTuple


class FileType(NamedTuple):
    """A kind of file: the module with its function ``write``, and the optional extra that this needs.

    ``of_cam``: the file contains a cam, which must be makable. ``of_plane``: the curves are plane, and a
    cylindrical cam is developed. ``of_pair``: the file can have both discs of a pair. ``of_disc``: it can have one
    disc of a pair.
    """

    module: str
    extra: str = ""
    of_cam: bool = True
    of_plane: bool = False
    of_pair: bool = True
    of_disc: bool = True


FILE_TYPES = {
    ".dxf": FileType("dxf", of_plane=True),
    ".svg": FileType("svg", of_plane=True),
    ".pdf": FileType("pdf"),
    ".step": FileType("step", "cad"),
    ".stp": FileType("step", "cad"),
    ".stl": FileType("stl", "cad"),
    ".csv": FileType("cam_points", of_plane=True),
    ".parquet": FileType("cam_points", of_plane=True),
    ".xlsx": FileType("cam_points", of_plane=True),
    ".nc": FileType("gcode", of_pair=False),
    ".mpf": FileType("gcode", of_pair=False),
    ".h": FileType("gcode", of_pair=False),
    ".p": FileType("grinding", of_pair=False),
    ".s96": FileType("s96", of_cam=False, of_disc=False),
    ".txt": FileType("electronic", of_cam=False, of_disc=False),
    ".toml": FileType("scene", of_cam=False, of_disc=False),
}
"""Kinds of files by ending."""

"""The kinds of files that the cam is written to, by the ending of the name."""

from typing import NamedTuple


class FileType(NamedTuple):
    """The writer of files with an ending: a module with a function ``write``, and the extra that it needs.

    ``of_cam`` is whether there is a cam in the file, which must be one that can be made; ``of_plane`` whether its
    curves are in a plane, in which a cylindrical cam is developed. Of a pair ``of_pair`` is whether both discs can
    be in it, ``of_disc`` whether one of them can be alone.
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
    ".csv": FileType("points", of_plane=True),
    ".parquet": FileType("points", of_plane=True),
    ".xlsx": FileType("points", of_plane=True),
    ".nc": FileType("gcode", of_pair=False),
    ".mpf": FileType("gcode", of_pair=False),
    ".h": FileType("gcode", of_pair=False),
    ".p": FileType("grinding", of_pair=False),
    ".txt": FileType("electronic", of_cam=False, of_disc=False),
    ".toml": FileType("scene", of_cam=False, of_disc=False),
}
"""By the ending of a file."""

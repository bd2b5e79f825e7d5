"""The kinds of files that the cam is written to, by the ending of the name."""

from typing import NamedTuple


class Ending(NamedTuple):
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


ENDINGS = {
    ".dxf": Ending("dxf", of_plane=True),
    ".svg": Ending("svg", of_plane=True),
    ".pdf": Ending("pdf"),
    ".step": Ending("step", "cad"),
    ".stp": Ending("step", "cad"),
    ".stl": Ending("stl", "cad"),
    ".csv": Ending("points", of_plane=True),
    ".parquet": Ending("points", of_plane=True),
    ".xlsx": Ending("points", of_plane=True),
    ".nc": Ending("gcode", of_pair=False),
    ".mpf": Ending("gcode", of_pair=False),
    ".h": Ending("gcode", of_pair=False),
    ".p": Ending("grinding", of_pair=False),
    ".txt": Ending("electronic", of_cam=False, of_disc=False),
    ".toml": Ending("scene", of_cam=False, of_disc=False),
}
"""By the ending of a file."""

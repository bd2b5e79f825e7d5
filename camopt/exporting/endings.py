"""The kinds of files that the cam is written to, by the ending of the name."""

from typing import NamedTuple


class Ending(NamedTuple):
    """The writer of files with an ending: a module with a function ``write``, and the extra that it needs.

    ``of_cam`` is whether there is a cam in the file, which must be one that can be made; ``of_plane`` whether its
    curves are in a plane, in which a cylindrical cam is developed; ``of_pair`` whether both discs of a pair are in
    it.
    """

    module: str
    extra: str = ""
    of_cam: bool = True
    of_plane: bool = False
    of_pair: bool = False


ENDINGS = {
    ".dxf": Ending("dxf", of_plane=True, of_pair=True),
    ".svg": Ending("svg", of_plane=True, of_pair=True),
    ".pdf": Ending("pdf"),
    ".step": Ending("step", "cad"),
    ".stp": Ending("step", "cad"),
    ".stl": Ending("stl", "cad"),
    ".csv": Ending("points", of_plane=True, of_pair=True),
    ".parquet": Ending("points", of_plane=True, of_pair=True),
    ".xlsx": Ending("points", of_plane=True, of_pair=True),
    ".nc": Ending("gcode"),
    ".mpf": Ending("gcode"),
    ".h": Ending("gcode"),
    ".p": Ending("grinding"),
    ".txt": Ending("electronic", of_cam=False, of_pair=True),
    ".toml": Ending("scene", of_cam=False, of_pair=True),
}
"""By the ending of a file."""

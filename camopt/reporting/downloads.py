"""The files that a page holds: the scene, and the cam for machines."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from camopt.exporting.export import export
from camopt.mistakes import BadInput
from camopt.quantities.unit_systems import shown, shown_unit
from camopt.reporting.page import data_url
from camopt.scene.scene import Scene

MEDIA_TYPES = {".toml": "application/toml", ".csv": "text/csv", ".dxf": "image/vnd.dxf"}


class Download(NamedTuple):
    """A file inside the page."""

    name: str
    address: str
    about: str


def downloads_of(scene: Scene, stem: str) -> tuple[list[Download], str]:
    """The files of a cam; of one that cannot be made the scene alone, and why."""
    found, why = [], ""
    with TemporaryDirectory() as folder:
        for suffix, kind in MEDIA_TYPES.items():
            path = Path(folder) / f"{stem}{suffix}"
            try:
                written = export(scene, path)
            except BadInput as refused:
                why = "; ".join(mistake.allowed for mistake in refused.mistakes)
                continue
            unit, of = shown_unit("mm"), written.curves.items()
            within = [f"{name} within {shown(c.deviation_mm, 'mm'):.2g} {unit} (proved)" for name, c in of]
            found.append(Download(path.name, data_url(path.read_bytes(), kind), "; ".join(within)))
    return found, why

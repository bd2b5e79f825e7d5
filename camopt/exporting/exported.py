"""The report on a file that has been written."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from camopt.contour.follow import Followed
from camopt.tables.cells import quantity, shown_name, with_unit
from camopt.tables.result import Result


@dataclass(frozen=True)
class Export(Result):
    """A file that has been written.

    Attributes
    ----------
    file : pathlib.Path
        The file.
    curves : Mapping
        The curves of the cam in the file by name: ``elements``, how many it is of, and ``what`` they are, and
        ``deviation_mm``, how far it is at most from the true curve, proved.
    about : Mapping
        Other numbers of the file, by name.
    notes : tuple of str
        What a user should know of it.

    Examples
    --------
    >>> curve = camopt.export(camopt.find_scene("two-pauses"), "cam.svg").curves["profile"]
    >>> curve.what, curve.deviation_mm <= 0.001
    ('arcs', True)
    """

    file: Path
    curves: Mapping[str, "CurveInFile"] = field(default_factory=dict)
    about: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    main_rows: ClassVar[str] = "curves"

    def __repr__(self) -> str:
        return f"<Export to {self.file}>"

    def sections(self) -> Iterator[str]:
        """The curves in the file with their proved deviations, and its other numbers."""
        return (f"{name}: {text}" for name, text in self.facts)

    def document(self) -> dict[str, Any]:
        """The curves, and the other numbers of the file."""
        return {"file": self.file, "curves": self.curves, **self.about, "notes": self.notes}

    @property
    def facts(self) -> list[tuple[str, str]]:
        """The curves with their proved deviations, and the other numbers: names and texts."""
        curves = [
            (
                name.replace("_", " "),
                f"{each.elements:,} {each.what}, within {with_unit(each.deviation_mm, 'mm')} (proved)",
            )
            for name, each in self.curves.items()
        ]
        return [*curves, *((shown_name(name), quantity(name, value)) for name, value in self.about.items())]


class CurveInFile(NamedTuple):
    """A curve of the cam in a file: the number and kind of its elements, and its largest deviation, mm."""

    elements: int
    what: str
    deviation_mm: float


def told(paths: Mapping[str, Followed]) -> dict[str, CurveInFile]:
    """The reports on paths, by name."""
    return {name: CurveInFile(len(each.path), each.path.what, each.deviation) for name, each in paths.items()}

"""The ends of a file for machines: the cam that goes into it, and the report once it is written."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from camopt.scene.part import Part
from camopt.scene.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.solve.contour.curve import SECOND_DISC, CamCurve, Disc, cam_discs, disc_curves
from camopt.solve.contour.path_fitting import FittedPath
from camopt.solve.tables.cells import quantity_text, shown_column_name, with_unit
from camopt.solve.tables.result import Result


@dataclass(frozen=True)
class Workpiece:
    """A cam that is to be made."""

    scene: Scene
    problem: Problem
    disc: int | None = None
    """The number of the disc of a pair that is made alone; None for the whole cam."""

    @cached_property
    def part(self) -> Part:
        """The part, completed from other tables of the scene: bore, material, density, name."""
        return self.scene.whole_part.disc_part(self.disc)

    @cached_property
    def discs(self) -> tuple[Disc, ...]:
        """The discs that are made."""
        return tuple(each for each in cam_discs(self.problem) if self.disc in (None, each.number))

    @property
    def only_disc(self) -> Disc:
        """The disc that is made alone."""
        (disc,) = self.discs
        return disc

    def curves(self, cutter_radius: float | None = None) -> dict[str, CamCurve]:
        """The curves of the discs that are made, by name (``curves_of``)."""
        return disc_curves(self.problem, cutter_radius, self.disc)

    @property
    def title(self) -> str:
        """The name of the part, and which disc of it is made alone."""
        return (self.part.name or "cam") + ("" if self.disc is None else f", disc {self.disc}")

    @property
    def is_cut_from_behind(self) -> bool:
        """Whether a disc is cut from behind its drawing, from where it is the first one.

        The hub of a cam stands out in front, and of a pair the first disc is in front of the second one.
        """
        return self.part.stands_on_hub if self.disc is None else self.disc == SECOND_DISC

    @property
    def hub_height(self) -> float:
        """How far the hub stands out above the plate of a disc that is cut, mm."""
        return 0.0 if self.is_cut_from_behind else max((self.part.hub_length or 0.0) - self.part.width, 0.0)

    @property
    def depth_below(self) -> float:
        """How far below the plate of a disc that is cut something else of the part begins, mm."""
        if self.disc is None:
            return 0.0 if self.part.stands_on_hub else inf
        return self.part.disc_gap or inf if self.part.hub_diameter else inf


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
        return [
            *curves,
            *((shown_column_name(name), quantity_text(name, value)) for name, value in self.about.items()),
        ]


class CurveInFile(NamedTuple):
    """A curve of the cam in a file: the number and kind of its elements, and its largest deviation, mm."""

    elements: int
    what: str
    deviation_mm: float


def curves_in_file(paths: Mapping[str, FittedPath]) -> dict[str, CurveInFile]:
    """The reports on paths, by name."""
    return {
        name: CurveInFile(len(each.path), each.path.element_kind, each.deviation) for name, each in paths.items()
    }

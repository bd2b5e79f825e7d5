"""Input and result of an export: the cam to make, and the report on the written file."""

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
    """A cam to be made."""

    scene: Scene
    problem: Problem
    disc: int | None = None
    """Number of the only disc of a pair to be made; None for the whole cam."""

    @cached_property
    def part(self) -> Part:
        """The part, with bore, material, density and name from other tables of the scene."""
        return self.scene.whole_part.disc_part(self.disc)

    @cached_property
    def discs(self) -> tuple[Disc, ...]:
        """The discs to be made."""
        return tuple(each for each in cam_discs(self.problem) if self.disc in (None, each.number))

    @property
    def only_disc(self) -> Disc:
        """The single disc to be made."""
        (disc,) = self.discs
        return disc

    @property
    def flank_height(self) -> float | None:
        """Depth of the groove, or height of the rib [mm]; None if the cam has neither, or it is unknown."""
        key = self.problem.setup.mechanism.body.flank_height
        return getattr(self.part, key) if key else None

    def curves(self, cutter_radius: float | None = None) -> dict[str, CamCurve]:
        """Curves of the discs to be made, by name (``disc_curves``)."""
        return disc_curves(self.problem, cutter_radius, self.disc)

    @property
    def title(self) -> str:
        """Name of the part, with the number of a single disc."""
        return (self.part.name or "cam") + ("" if self.disc is None else f", disc {self.disc}")

    @property
    def is_cut_from_behind(self) -> bool:
        """Whether the cam is cut from the back of the drawing: it stands on its hub, or it is the second disc.

        A hub stands out in front; the first disc of a pair is in front of the second.
        """
        return self.part.has_protruding_hub if self.disc is None else self.disc == SECOND_DISC

    @property
    def hub_height_above_plate(self) -> float:
        """Height of the hub above the plate during the cut [mm]."""
        return 0.0 if self.is_cut_from_behind else max((self.part.hub_length or 0.0) - self.part.width, 0.0)

    @property
    def free_depth_below_plate(self) -> float:
        """Free depth below the plate during the cut, down to the rest of the part [mm]."""
        if self.disc is None:
            return 0.0 if self.part.has_protruding_hub else inf
        return self.part.disc_gap or inf if self.part.hub_diameter else inf


@dataclass(frozen=True)
class Export(Result):
    """A file that has been written.

    Attributes
    ----------
    file : pathlib.Path
        The file.
    curves : Mapping
        The curves of the cam in the file by name: number of ``elements``, their kind ``what``, and the proven bound
        ``deviation_mm`` of the distance from the true curve.
    about : Mapping
        Other numbers of the file, by name.
    notes : tuple of str
        Notes on the file.

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
        """Texts on the curves with their proven deviations, and on the other numbers of the file."""
        for name, each in self.curves.items():
            deviation = with_unit(each.deviation_mm, "mm")
            yield f"{name.replace('_', ' ')}: {each.elements:,} {each.what}, within {deviation} (proved)"
        for name, value in self.about.items():
            yield f"{shown_column_name(name)}: {quantity_text(name, value)}"

    def values_for_json(self) -> dict[str, Any]:
        """The curves and the other numbers of the file."""
        return {"file": self.file, "curves": self.curves, **self.about, "notes": self.notes}


class CurveInFile(NamedTuple):
    """A curve of the cam in a file: number and kind of its elements, and proven bound of its deviation [mm]."""

    elements: int
    what: str
    deviation_mm: float


def curves_in_file(paths: Mapping[str, FittedPath]) -> dict[str, CurveInFile]:
    """Reports on paths, by name."""
    return {
        name: CurveInFile(len(each.path), each.path.element_kind, each.deviation) for name, each in paths.items()
    }

"""``construct``: the construction of a cam as lectures teach it, with a table of stations and a drawing."""

from dataclasses import dataclass
from functools import cached_property
from math import degrees
from typing import Any

import numpy as np

from camopt.core.quantities.display import Drawable
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.mechanisms.geometry import cam_curves
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.show.drawing.construction.inversion import FinePicture, Inversion
from camopt.show.drawing.construction.stations import USUAL_PARTS, StationPlan
from camopt.solve.tables.result import NUMERIC, Cell, Result, Table


@dataclass(frozen=True)
class Construction(Result, Drawable):
    """The construction of a cam with ruler and compasses, with its stations; ``plot`` draws it.

    Attributes
    ----------
    scene : Scene
        The scene of the cam.
    parts : int
        Equal parts of each stroke.

    Examples
    --------
    >>> found = camopt.construct(camopt.find_scene("two-pauses"))
    >>> [row["letter"] for row in found.records()][:3]
    ['A', 'B', 'C']
    """

    scene: Scene
    parts: int

    picture = "drawing.construction.sheet"
    main_rows = "stations"

    @cached_property
    def inversion(self) -> Inversion:
        """The follower seen from the cam, with all steps of the profile."""
        picture = FinePicture(self.scene, resolve_design(self.scene))
        return Inversion(picture, StationPlan(picture, self.parts))

    def records(self) -> list[dict[str, Any]]:
        """A record for each station: number, letter, cam angle, displacement, and two points.

        ``point`` is set off by the construction (the trace point, or the foot on a flat face); ``profile`` is the
        contact on the cam. They are radius [mm] and polar angle [deg, from 0 below 360]; on a developed surface x
        and y [mm].
        """
        inversion, problem = self.inversion, self.inversion.problem
        stations = inversion.plan.stations
        angles, levels = (
            np.array(each) for each in zip(*((s.angle, s.displacement) for s in stations), strict=True)
        )
        curves = cam_curves(problem.setup.mechanism, problem.design, problem.programme, angles)
        pairs = []
        for points in (inversion.follower_point_in_cam_frame(angles, levels), curves.profile[0]):
            polar = np.abs(points), np.degrees(np.angle(points)) % 360.0
            first, second = (points.real, points.imag) if inversion.is_developed else polar
            pairs.append(zip(first.tolist(), second.tolist(), strict=True))
        unit = degrees(1.0) if inversion.angular else 1.0
        return [
            {
                "station": station.number,
                "letter": station.letter,
                "cam_angle_deg": degrees(station.angle),
                "displacement": unit * station.displacement,
                "point": point,
                "profile": profile,
            }
            for station, point, profile in zip(stations, *pairs, strict=True)
        ]

    def values_for_json(self) -> dict[str, Any]:
        """A record for each station."""
        return {"scene": self.scene.name, "stations": self.records()}

    def table(self) -> Table:
        """A table with a row for each station, in shown units."""
        length, inversion = unit_in_shown_system("mm"), self.inversion
        kinds = [f"x, {length}", f"y, {length}"] if inversion.is_developed else [f"r, {length}", "φ, deg"]
        pairs = [f"{name} {kind}" for name in ("point", "profile") for kind in kinds]
        heads = ["cam, deg", f"y, {'deg' if inversion.angular else length}", *pairs]
        rows = []
        for row in self.records():
            y = row["displacement"] if inversion.angular else to_shown_unit(row["displacement"], "mm")
            numbers = [f"{row['cam_angle_deg']:.4g}", f"{round(y, 3) + 0.0:.3f}"]
            for first, second in (row["point"], row["profile"]):
                other = to_shown_unit(second, "mm") if inversion.is_developed else second
                numbers += [f"{round(value, 3) + 0.0:.3f}" for value in (to_shown_unit(first, "mm"), other)]
            rows.append([row["station"], row["letter"], *(text.replace("-", "−") for text in numbers)])
        title = f"{self.scene.name}: stations of the construction"
        return Table.from_texts(title, ["", "", *(Cell(text, NUMERIC) for text in heads)], rows)


def construct(scene: SceneSource, parts: int = USUAL_PARTS) -> Construction:
    """Construct a cam as lectures teach it: numbered stations, kinematic inversion, envelope.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with all sizes, whose follower has one contact.
    parts : int, default 6
        Equal parts of each stroke, an even number from 4 to 24.

    Returns
    -------
    Construction
        Its table by station; ``plot`` draws the sheet.

    Raises
    ------
    BadInput
        If the number of parts is another one, the follower has two contacts, or the mechanism cannot be put
        together.

    References
    ----------
    R. S. Khurmi and J. K. Gupta, Theory of Machines, ch. 20.

    Examples
    --------
    >>> construction = camopt.construct(camopt.find_scene("two-pauses"), parts=8)
    >>> figure = camopt.plot(construction, "construction.pdf")
    """
    construction = Construction(scene_from(scene), parts)
    assert construction.inversion  # raises BadInput for a cam that cannot be constructed
    return construction

"""The picture of a design: the cam to scale, beside diagrams of motion, pressure angle, curvature and loads."""

from math import ceil
from typing import Any, NamedTuple

import numpy as np

from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.model.effects.rib import RIB_THICKNESS
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.show.drawing import diagrams
from camopt.show.drawing.cam import draw_disc
from camopt.show.drawing.groove import draw_groove
from camopt.show.drawing.labels import Label, place_labels
from camopt.show.drawing.loads import load_panels
from camopt.show.drawing.panels import Panel, motion_panels
from camopt.show.drawing.picture import Picture, four_digit_text, value_with_unit
from camopt.show.drawing.style import (
    ALARM,
    HEADING_SIZE,
    INK,
    MUTED,
    PAGE_TITLE,
    TITLE_SIZE,
    Figure,
    Target,
    new_figure,
)
from camopt.solve.tables.designs import Design
from camopt.solve.verdicts.evaluation import Evaluation
from camopt.solve.verdicts.limit_verdicts import relative_excesses_by_limit, violated_limit_names


def draw(what: Scene | Evaluation | Design, path: Target = None) -> "Figure":
    """Draw a cam with its follower and diagrams; with a path, also save it as PNG, SVG or PDF."""
    scene = what if isinstance(what, Scene) else what.scene
    picture = Picture(scene, resolve_design(scene))
    shown = all_panels_in_shown_units(picture)
    page = _groove_layout(len(shown)) if picture.is_developed else _disc_layout(len(shown))
    with new_figure(path, (FIGURE_WIDTH, page.height)) as figure:
        axes = [figure.add_axes(page.box_in_figure_shares(box)) for box in page.panels]
        _draw_header(figure, picture)
        labels = diagrams.draw_diagrams(axes, picture, shown, page.heads, page.feet)
        cam = figure.add_axes(page.box_in_figure_shares(page.cam))
        labels += _draw_cam_to_scale(cam, picture)
        if picture.can_assemble:
            handles, names = cam.get_legend_handles_labels()
            figure.legend(
                handles,
                names,
                loc="lower center",
                bbox_to_anchor=(page.legend[0], page.legend[1] / page.height),
                ncols=len(names) if picture.is_developed else min(len(names), 4),
                columnspacing=1.8,
            )
        place_labels(figure, labels)
    return figure


def all_panels_in_shown_units(picture: Picture) -> list[Panel]:
    """Diagrams of motion, pressure angle, curvature and computed loads, in the units that are shown."""
    return [panel.in_shown_units() for panel in (*motion_panels(picture), *load_panels(picture))]


def draw_main_diagram(axes: Any, what: Scene | Evaluation | Design) -> None:
    """Draw the cam to scale at cam angle 0."""
    scene = what if isinstance(what, Scene) else what.scene
    place_labels(axes.figure, _draw_cam_to_scale(axes, Picture(scene, resolve_design(scene))))


def _draw_cam_to_scale(axes: Any, picture: Picture) -> list[Label]:
    """Draw the cam to scale; return the labels to place."""
    if not picture.can_assemble:
        axes.set_axis_off()
        axes.text(0.5, 0.5, "This mechanism cannot be assembled.", ha="center", color=ALARM, fontsize=TITLE_SIZE)
        return []
    return draw_groove(axes, picture) if picture.is_developed else draw_disc(axes, picture)


TEXT_SEPARATOR = "  ·  "  # between texts on one line
FIGURE_WIDTH = 15.5  # inches
HEADER_LETTERS = 200  # characters of a heading that fit the width of the figure
COLUMN_ENDS, COLUMN_WIDTH = (0.045, 0.54), 0.44  # left ends and width of diagrams, as shares of the figure
PANEL_HEIGHT_INCHES = 1.0333  # height of a diagram
Corners = tuple[float, float, float, float]


class FigureLayout(NamedTuple):
    """Places on the figure: horizontally in shares of its width, vertically in inches."""

    height: float
    cam: Corners
    legend: tuple[float, float]
    panels: list[Corners]
    heads: tuple[int, ...]
    """Diagrams with the names of the strokes above them."""
    feet: tuple[int, ...]
    """Diagrams with the cam angle below them."""

    def box_in_figure_shares(self, box: Corners) -> Corners:
        """A box in shares of the figure."""
        left, bottom, width, height = box
        return left, bottom / self.height, width, height / self.height


def _disc_layout(count: int) -> FigureLayout:
    """Layout with six diagrams beside the cam, the others below in two columns, row by row."""
    rows, step = ceil(max(count - 6, 0) / 2), PANEL_HEIGHT_INCHES + 0.34
    below = rows * step
    lift = 0.65 if rows else 0.0  # room for the names of the strokes
    places = [(0, k) if k < 6 else (k % 2, 6 + (k - 6) // 2) for k in range(count)]
    panels = [
        (COLUMN_ENDS[k], below + 8.5 - PANEL_HEIGHT_INCHES - row * step, COLUMN_WIDTH, PANEL_HEIGHT_INCHES)
        for k, row in places
    ]
    heads = (0, 7) if count > 7 else (0,)
    feet = tuple({COLUMN_ENDS.index(left): place for place, (left, *_) in enumerate(panels)}.values())
    cam = (0.53, below + 1.25 + lift, 0.45, 7.45 - lift)
    return FigureLayout(below + 10.0, cam, (0.755, below + 0.2 + lift), panels, heads, feet)


def _groove_layout(count: int) -> FigureLayout:
    """Layout with the groove on top and the diagrams below in two columns, column by column."""
    rows, step = ceil(count / 2), PANEL_HEIGHT_INCHES + 0.45
    height = 6.0 + rows * step - 0.45
    places = [divmod(k, rows) for k in range(count)]
    panels = [
        (COLUMN_ENDS[k], height - 5.4 - PANEL_HEIGHT_INCHES - row * step, COLUMN_WIDTH, PANEL_HEIGHT_INCHES)
        for k, row in places
    ]
    cam, legend = (0.045, height - 4.0, 0.935, 2.5), (0.5, height - 4.75)
    return FigureLayout(height, cam, legend, panels, (0, rows), (rows - 1, count - 1))


def _draw_header(figure: Any, picture: Picture) -> None:
    """Write the name of the scene, its mechanism and sizes, the main results, undercut and broken limits."""
    name, problem = picture.scene.name, picture.problem
    shown = name if len(name) <= 90 else name[:89] + "…"
    inch = 1.0 / figure.get_figheight()
    figure.text(0.045, 1.0 - 0.42 * inch, shown, fontsize=PAGE_TITLE, fontweight="bold")
    sizes = mechanism_and_sizes_line(picture)
    fitting = HEADING_SIZE * min(1.0, HEADER_LETTERS / len(sizes))
    figure.text(0.045, 1.0 - 0.66 * inch, sizes, fontsize=fitting, color=MUTED)
    figure.text(0.045, 1.0 - 0.87 * inch, geometry_results_line(picture), fontsize=HEADING_SIZE, color=INK)
    if picture.can_assemble:
        columns = {name: np.atleast_1d(value) for name, value in picture.quantity_values.items()}
        excess = relative_excesses_by_limit(problem.limits, columns, problem.design)
        broken = str(violated_limit_names(problem.limits, excess)[0]) if problem.limits else ""
        names = [name.replace("_", " ") for name in broken.split(",") if name and name != "undercut"]
        faults = ["undercut"] if picture.undercut else []
        faults += [f"broken limits: {', '.join(names)}"] if names else []
        style = {"fontsize": TITLE_SIZE, "color": ALARM, "ha": "right", "fontweight": "bold"}
        figure.text(0.98, 1.0 - 0.42 * inch, TEXT_SEPARATOR.join(faults), **style)


def mechanism_and_sizes_line(picture: Picture) -> str:
    """Mechanism, speed, sizes and laws of a design, as one line under a title."""
    scene, values = picture.scene, picture.quantity_values
    words = [
        f"{scene.cam.form} cam, {scene.follower.motion} {scene.follower.contact} follower",
        scene.cam.rotation,
        *([] if scene.cam.rpm is None else [f"{scene.cam.rpm:g} rev/min"]),
    ]
    round_body = "face radius" if scene.follower.contact == "spherical" else "roller radius"
    names = {
        "base_radius_mm": "base radius",
        "mean_radius_mm": "mean radius",
        "roller_radius_mm": round_body,
        "offset_mm": "offset",
        "arm_length_mm": "arm",
        "centre_distance_mm": "pivot distance",
        "face_offset_mm": "face offset",
        "roller_spacing_mm": "roller spacing",
    }
    sizes = [f"{words} {value_with_unit(values[key])}" for key, words in names.items() if values.get(key)]
    seconds = {f"second_{key}": words for key, words in names.items() if f"second_{key}" in values}
    differing = [
        f"{words} {value_with_unit(values[key])}"
        for key, words in seconds.items()
        if values[key] != values[key.removeprefix("second_")]
    ]
    second = [f"second disc: {', '.join(differing) or 'the same sizes'}"] if seconds else []
    laws = [f"{kind} {values[f'law_{kind}']}" for kind in ("rise", "return") if values[f"law_{kind}"]]
    return TEXT_SEPARATOR.join([*words, *sizes, *second, *laws])


def geometry_results_line(picture: Picture) -> str:
    """Largest pressure angles, smallest radius and other results of geometry, as one line under a title."""
    values = picture.quantity_values
    names = {"pressure_angle_max_rise_deg": "rise", "pressure_angle_max_return_deg": "return"}
    body = "" if picture.problem.setup.train is None else " of the follower"
    angles = [f"{word}{body} {four_digit_text(values[key])}°" for key, word in names.items()]
    square, least = values["pressure_angle_max_deg"] == 0.0, values["profile_radius_min_mm"]
    shaft = "shaft_clearance_mm"
    convex, reach = np.isfinite(least) and least > 0.0 and not picture.undercut, ""
    if "face_reach_min_mm" in values:
        low, high = (values[f"face_reach_{end}_mm"] for end in ("min", "max"))
        reach = f"contact on the face from {four_digit_text(to_shown_unit(low, 'mm'))} to {value_with_unit(high)}"
    words = (
        "pressure angle 0" if square else f"largest pressure angle: {', '.join(angles)}",
        f"smallest convex radius of the profile {value_with_unit(least)}" if convex else "",
        f"rib thickness {value_with_unit(values[RIB_THICKNESS])}" if RIB_THICKNESS in values else "",
        reach,
        f"shaft clearance {value_with_unit(values[shaft])}" if shaft in values else "",
    )
    return TEXT_SEPARATOR.join(filter(None, words))

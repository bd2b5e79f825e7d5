"""The page of a machine: turning cams, a timing diagram with one cursor, results, and a section per station."""

from io import BytesIO
from typing import Any

import numpy as np
from PIL import Image

from camopt.core.quantities.unit_systems import INCH_MM, to_shown_unit, unit_in_shown_system
from camopt.show.drawing.frames import render_frames
from camopt.show.drawing.picture import Picture
from camopt.show.drawing.style import DATE_METADATA, new_figure
from camopt.show.machines.animated_machine import EDGE, Tool, animated_machine_figure, machine_tools, timing_height
from camopt.show.machines.timing_diagram import READING_WIDTH, TEXT, TimingDiagram
from camopt.show.machines.timing_spans import TimingData, phase_and_ratio_text
from camopt.show.reporting.cam_data import cam_data, rounded_numbers_for_page
from camopt.show.reporting.cams import Chapter, ShownCam, cam_chapters
from camopt.show.reporting.page import data_url, render_page
from camopt.show.reporting.sections import limits_table, quantities_table
from camopt.show.sheet.marks import CAPITAL_HEIGHT, MarkBox, add_paper_axes
from camopt.solve.machine.evaluation import MachineEvaluation, station_verdict
from camopt.solve.machine.stations import ResolvedStation
from camopt.solve.tables.result import Cell, Table
from camopt.solve.verdicts.evaluation import Evaluation
from camopt.solve.verdicts.verdict_words import worst_verdict

WIDTH, STEPS = 290.0, 720  # mm: width of the timing diagram; samples of a turn
SHAFT_ANGLES = np.linspace(0.0, 2 * np.pi, STEPS + 1)


def machine_page(result: MachineEvaluation, *, full: bool = False) -> str:
    """The HTML page of a machine. A ``full`` page prints the scenes of its stations too."""
    data, parts = machine_page_data_and_template_values(result)
    return render_page("machine", result.machine.name, data, **parts, full=full)


def machine_page_data_and_template_values(result: MachineEvaluation) -> tuple[dict[str, Any], dict[str, Any]]:
    """The data of a machine's page for its program, and the values for its template."""
    data = TimingData.from_machine(result)
    diagram = TimingDiagram(data, MarkBox(0j, complex(WIDTH, timing_height(data))), READING_WIDTH)
    (verdict, *sentences), tables = [each for each in result.sections() if isinstance(each, str)], result.tables()
    stations = data.stations
    height = diagram.box.high.imag
    rooms = [diagram.lift_curve_levels(number) for number in range(len(stations))]
    rows = [
        {"name": each.name, "start": height - low, "middle": height - (row.low + row.high - TEXT) / 2}
        for each, row, (low, _) in zip(stations, diagram.station_clearance_and_torque_rows[0], rooms, strict=True)
    ]
    tools = machine_tools(data.machine, stations)
    return (
        {
            "cams": [
                cam_data(Picture(each.scene, each.problem))
                | {"panels": [], "shift": each.station.phase, "ratio": each.station.ratio}
                for each in stations
            ],
            "labels": [station.name for station in stations],
            "words": [[phase_and_ratio_text(station)] for station in stations],
            "timing": {
                "left": diagram.left,
                "right": diagram.right,
                "stations": [
                    {
                        "lift": rounded_numbers_for_page(to_shown_unit(each.lift.value(SHAFT_ANGLES), each.unit)),
                        "largest": float(to_shown_unit(each.lift.largest().value, each.unit)),
                        "unit": unit_in_shown_system(each.unit),
                        "low": height - low,
                        "high": height - high,
                    }
                    for each, (low, high) in zip(stations, rooms, strict=True)
                ],
            },
            "tools": _tools_data(tools, stations) if tools else None,
        },
        {
            "lines": [
                Cell(verdict, result.verdict),
                *map(Cell, sentences),
                *(Cell(f"{note}.") for note in result.notes),
            ],
            "tables": tables,
            "sections": [_station_chapter(station, result.stations[station.name]) for station in stations],
            "rows": rows,
            "timing": timing_diagram_image_url(diagram),
            "still": still_machine_image_url(result),
            "width": WIDTH,
            "height": height,
            "left": diagram.left,
            "top": height - diagram.top,
            "bottom": height - diagram.bottom,
            "end": WIDTH,
            "letters": TEXT / CAPITAL_HEIGHT,
        },
    )


def _tools_data(tools: list[Tool], stations: tuple[ResolvedStation, ...]) -> dict[str, Any]:
    """Outlines of tools and bodies and their motion over a turn, and the box of all [mm]."""
    records, reach = [], []
    for tool in tools:
        path, rotation = tool.path(SHAFT_ANGLES), tool.rotation(SHAFT_ANGLES)
        moved = path + (tool.outline[:, None] - tool.origin) * np.exp(1j * rotation)
        reach.append(moved.ravel())
        middle = complex(np.mean([tool.outline.real.min(), tool.outline.real.max()]), tool.outline.imag.mean())
        records.append(
            {
                "name": tool.name,
                "outline": [rounded_numbers_for_page(part) for part in (tool.outline.real, tool.outline.imag)],
                "middle": [middle.real, middle.imag],
                "station": None if tool.station is None else stations.index(tool.station),
                "x": rounded_numbers_for_page((path - tool.origin).real),
                "y": rounded_numbers_for_page((path - tool.origin).imag),
                "turned": rounded_numbers_for_page(np.degrees(rotation)) if np.any(rotation) else None,
                "pivot": [tool.origin.real, tool.origin.imag],
            }
        )
    points = np.concatenate(reach)
    low, high = complex(points.real.min(), points.imag.min()), complex(points.real.max(), points.imag.max())
    edge = 0.04 * max((high - low).real, (high - low).imag, 1.0) * (1 + 1j)
    low, high = low - edge, high + edge
    return {"tools": records, "box": [low.real, low.imag, high.real, high.imag]}


def _station_chapter(station: ResolvedStation, evaluation: Evaluation) -> Chapter:
    """The section of a station: limits, quantities, inputs, effects and scene."""
    problem, shown = station.problem, ShownCam(station.name, station.scene)
    tables: list[Table] = [
        limits_table(evaluation, problem),
        quantities_table([evaluation], [problem], ["value"]),
        *(table for chapter in cam_chapters(shown, problem, pictures=False) for table in chapter.tables),
    ]
    title = f"{station.name} — {station.scene.name}: {worst_verdict([station_verdict(evaluation)])}"
    return Chapter(title, tables, text=station.scene.to_toml())


def timing_diagram_image_url(diagram: TimingDiagram) -> str:
    """The timing diagram as the data URL of an SVG, whose letters are drawn as lines."""
    import matplotlib as mpl

    file, size = BytesIO(), diagram.box.size
    with new_figure(None, (size.real / INCH_MM, size.imag / INCH_MM)) as figure:
        diagram.draw(add_paper_axes(figure, size.real, size.imag))
        with mpl.rc_context({"svg.fonttype": "path"}):
            figure.savefig(file, format="svg", metadata=DATE_METADATA[".svg"])
    return data_url(file.getvalue(), "image/svg+xml")


def still_machine_image_url(result: MachineEvaluation) -> str:
    """The cams and tools at angle 0 of the shaft, as the data URL of a PNG."""
    file = BytesIO()
    with animated_machine_figure(result) as stage:
        pixels, height = next(render_frames(stage)), stage.figure.get_size_inches()[1] * INCH_MM
    below = (timing_height(TimingData.from_machine(result)) + EDGE) / height
    Image.fromarray(pixels[: int(len(pixels) * (1.0 - below))]).save(file, format="PNG", optimize=True)
    return data_url(file.getvalue(), "image/png")

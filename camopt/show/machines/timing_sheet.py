"""The timing diagram of a machine on a sheet: A3, or size B in inches, with frame, legend and title block.

Sheets for many stations are larger.
"""

from pathlib import Path
from typing import Any

from camopt.core.quantities.unit_systems import INCH_MM
from camopt.core.storage.version import VERSION
from camopt.scene.machine import Machine
from camopt.show.drawing.picture import four_digit_text
from camopt.show.drawing.style import Figure, Target, new_figure
from camopt.show.machines.timing_diagram import (
    BAR_HEIGHT,
    BAR_STYLES,
    LINE_STEP,
    SMALL_TEXT,
    TEXT,
    TimingDiagram,
    draw_words,
    fill_bar,
)
from camopt.show.machines.timing_spans import CLEARANCE, MOST_CLEARANCES, TimingData
from camopt.show.sheet.marks import MarkBox, add_paper_axes, draw_marks, shift_marks, text_width, wrap_text
from camopt.show.sheet.paper import BLOCK_HEIGHT, BLOCK_ROW, BLOCK_WIDTH, AnsiPaper, Field, Paper, title_block
from camopt.show.sheet.standards import sheet_standard
from camopt.solve.machine.evaluation import MachineEvaluation

LEAST_ROW, MARGIN = 11.0, 4.0  # mm
LARGER_PAPERS = {
    "A2": (Paper("A1", 841.0, 594.0), Paper("A0", 1189.0, 841.0)),
    "D": (AnsiPaper("E", 44.0 * INCH_MM, 34.0 * INCH_MM, (INCH_MM, INCH_MM, 0.5 * INCH_MM), (8, 8)),),
}
"""Papers for many stations, by the largest paper of a standard for cams."""
NOTE = (
    "Bars: segments of each tool; numbers: angles of the shaft at which they change. Curves: lift of each tool "
    "above its lowest position, each to its own scale."
)


def draw(machine: Machine | MachineEvaluation, path: Target = None) -> Figure:
    """Draw the timing diagram of a machine on a sheet; with a path, also save it as PNG, SVG or PDF.

    Each station has a row with its segments and its lift over a turn of the shaft. Below are the ranges of the
    clearances, and the torque on the shaft.

    Raises
    ------
    BadInput
        If a scene leaves a size to its search, or the file does not end in .png, .svg or .pdf.
    OSError
        If the file cannot be written.
    """
    data = TimingData.from_machine(machine)
    _, *papers = sheet_standard().papers
    for paper in (*papers, *LARGER_PAPERS[papers[-1].name]):  # the first whose rows have room for their texts
        low, high = paper.frame
        box = MarkBox(low + complex(MARGIN, BLOCK_HEIGHT + MARGIN), high - complex(MARGIN, MARGIN))
        diagram = TimingDiagram(data, box)
        row = diagram.station_clearance_and_torque_rows[0][0]
        if row.high - row.low >= LEAST_ROW:
            break
    with new_figure(path, (paper.width / INCH_MM, paper.height / INCH_MM)) as figure:
        axes = add_paper_axes(figure, paper.width, paper.height)
        corner = complex(paper.frame.high.real - BLOCK_WIDTH, paper.frame.low.imag)
        draw_marks(axes, [*paper.marks(), *shift_marks(title_block(_block_fields(data, paper)), corner)])
        diagram.draw(axes)
        low = paper.frame.low + complex(MARGIN, MARGIN)
        _draw_legend(axes, MarkBox(low, complex(corner.real - MARGIN, low.imag + BLOCK_HEIGHT - MARGIN)), diagram)
    return figure


def _block_fields(data: TimingData, paper: Paper) -> list[Field]:
    """The fields of the title block."""
    machine, seconds, total = data.machine, data.seconds_per_turn, data.total_torque
    speed = "" if machine.shaft_rpm is None else f"{four_digit_text(machine.shaft_rpm)} rev/min"
    return [
        Field(0, 27, 45, BLOCK_ROW, "Speed of the shaft", speed),
        Field(45, 27, 45, BLOCK_ROW, "Time of a turn", "" if seconds is None else f"{four_digit_text(seconds)} s"),
        Field(90, 27, 40, BLOCK_ROW, "Stations", f"{len(data.stations)}"),
        Field(130, 27, 50, BLOCK_ROW, "Peak torque", "" if total is None else total.peak_words),
        Field(0, 18, 45, BLOCK_ROW, "Created by"),
        Field(45, 18, 45, BLOCK_ROW, "Approved by"),
        Field(90, 18, 40, BLOCK_ROW, "Document type", "Timing diagram"),
        Field(130, 18, 32, BLOCK_ROW, "Source", f"camopt {VERSION}"),
        Field(162, 18, 18, BLOCK_ROW, "Format", paper.name),
        Field(0, 0, 45, 2 * BLOCK_ROW, "Legal owner"),
        Field(45, 0, 85, 2 * BLOCK_ROW, "Title", machine.name),
        Field(130, 9, 50, BLOCK_ROW, "Identification number"),
        Field(130, 0, 10, BLOCK_ROW, "Rev."),
        Field(140, 0, 28, BLOCK_ROW, "Date of issue"),
        Field(168, 0, 12, BLOCK_ROW, "Sheet", "1/1"),
    ]


def _draw_legend(axes: Any, box: MarkBox, diagram: TimingDiagram) -> None:
    """Draw samples of the bars that the diagram has, and notes."""
    data = diagram.data
    names = {span.name for spans in (*data.spans, [span for _, span in data.clearances]) for span in spans}
    x, low = box.low.real, box.high.imag - BAR_HEIGHT
    for name in BAR_STYLES:
        if name not in names:
            continue
        text = "clearance must hold" if name == CLEARANCE else name
        fill_bar(axes, x, low, 8.0, BAR_HEIGHT, name)
        draw_words(axes, x + 9.5, low + (BAR_HEIGHT - TEXT) / 2, text, TEXT, va="baseline")
        x += 14.0 + text_width(text, TEXT)
    left_out = sum(map(len, data.spans)) - sum(map(len, diagram.change_labels))
    more, file = len(data.machine.clear) - MOST_CLEARANCES, Path(data.machine.file)
    dots = " Dots: largest torques." if data.total_torque else ""
    notes = [
        f"{NOTE}{dots}" + (f" {left_out} numbers have no room." if left_out else ""),
        *([f"{more} more clearances are not drawn."] if more > 0 else []),
        *([f"File: {file.name}"] if file.suffix == ".toml" else []),
    ]
    for text in (line for note in notes for line in wrap_text(note, box.size.real - MARGIN, SMALL_TEXT)):
        low -= LINE_STEP * SMALL_TEXT + 0.4
        draw_words(axes, box.low.real, low, text, SMALL_TEXT, va="baseline")

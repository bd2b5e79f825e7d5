"""What is wrong with a drawn sheet: words on words, words on lines, and what leaves its place."""

import numpy as np
from shapely import LineString, Polygon, STRtree, box

from camopt.show.sheet.marks import Words, text_width

TOUCH = 0.05  # mm


def shape(mark):
    """The box of words, or a line, for shapely."""
    points = mark.corners if isinstance(mark, Words) else mark.points
    columns = np.column_stack([points.real, points.imag])
    return Polygon(columns).buffer(-TOUCH) if isinstance(mark, Words) else LineString(columns)


def faults_of(sheet):
    """Words that meet words or, unless they interrupt them, lines; marks that leave the frame or the paper."""
    words = [mark for mark in sheet.marks if isinstance(mark, Words)]
    lines = [mark for mark in sheet.marks if not isinstance(mark, Words)]
    boxes, paths = [shape(mark) for mark in words], [shape(mark) for mark in lines]
    pairs = STRtree(boxes).query(boxes, predicate="intersects").T
    found = [f"{words[a].text!r} on {words[b].text!r}" for a, b in pairs if a < b]
    tree = STRtree(paths)
    for mark, here in zip(words, boxes, strict=True):
        if not mark.backed and (hit := tree.query(here, predicate="intersects")).size:
            found.append(f"{mark.text!r} on {hit.size} lines")
    low, high = sheet.paper.frame
    frame = box(low.real, low.imag, high.real, high.imag).buffer(0.01)
    own = {
        mark.corners.tobytes() if isinstance(mark, Words) else mark.points.tobytes() for mark in sheet.paper.marks()
    }
    for mark, here in zip([*words, *lines], [*boxes, *paths], strict=True):
        place = mark.corners if isinstance(mark, Words) else mark.points
        if place.tobytes() not in own and not frame.covers(here):
            found.append(f"{getattr(mark, 'text', 'a line')!r} leaves the frame")
    paper = box(0, 0, sheet.paper.width, sheet.paper.height)
    return found + [
        f"{mark.text!r} leaves the paper" for mark, here in zip(words, boxes, strict=True) if not paper.covers(here)
    ]


def words_outside(fields, marks):
    """Words of a title block that leave its fields."""
    outside = []
    for mark in marks:
        if isinstance(mark, Words) and text_width(mark.text, mark.height):
            low, high = mark.corners[0], mark.corners[2]
            if not any(
                f.x <= low.real
                and high.real <= f.x + f.width + 0.01
                and f.y <= low.imag + 0.6
                and high.imag <= f.y + f.height
                for f in fields
            ):
                outside.append(mark.text)
    return outside

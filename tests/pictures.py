"""What a drawn picture shows: its texts where they are drawn, and what hides what."""

from itertools import combinations
from unittest.mock import patch

from matplotlib.text import Text

TOUCH = 0.5  # pixels that boxes of texts may share


def texts_of(figure):
    """(text, box in pixels) of every text that drawing the figure draws: no ticks that are out of sight."""
    drawn, draw = {}, Text.draw

    def noted(self, renderer, *args, **kwargs):
        if self.get_visible() and self.get_text().strip():
            drawn[id(self)] = (self.get_text(), self.get_window_extent(renderer))
        return draw(self, renderer, *args, **kwargs)

    with patch.object(Text, "draw", noted):
        figure.canvas.draw()
    return list(drawn.values())


def faults_of(figure):
    """Texts that lie on another text, leave the figure, or are an offset or exponent of an axis."""
    texts = texts_of(figure)
    assert len(texts) > 3
    found = [f"{a!r} on {b!r}" for (a, box), (b, other) in combinations(texts, 2) if _meet(box, other)]
    page = figure.bbox
    found += [
        f"{text!r} leaves the figure"
        for text, box in texts
        if box.x0 < page.x0 or box.y0 < page.y0 or box.x1 > page.x1 or box.y1 > page.y1
    ]
    offsets = [axis.get_offset_text().get_text() for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    return found + [f"offset {text!r}" for text in offsets if text]


def _meet(box, other):
    return (
        min(box.x1, other.x1) - max(box.x0, other.x0) > TOUCH
        and min(box.y1, other.y1) - max(box.y0, other.y0) > TOUCH
    )

"""What a drawn picture shows: its texts where they are drawn, and what hides what."""

from itertools import combinations
from unittest.mock import patch

import numpy as np
from matplotlib.text import Text

TOUCH = 0.5  # pixels that boxes of texts may share
LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)  # of red, green, blue
DARK = 150  # of 255: the luminance of a line; grids, shades and fills are lighter


def drawn_texts(figure):
    """(artist, box in pixels) of every text that drawing the figure draws: no ticks that are out of sight.

    Besides, the colours of the figure without them, in rows of pixels.
    """
    texts = {}

    def noted(self, renderer, *args, **kwargs):
        if self.get_visible() and self.get_text().strip():
            texts[id(self)] = (self, self.get_window_extent(renderer))

    with patch.object(Text, "draw", noted):
        figure.canvas.draw()
    return list(texts.values()), np.asarray(figure.canvas.buffer_rgba())[..., :3]


def faults_of(figure):
    """Texts that lie on another text or on a line, leave the figure, or are an offset or exponent of an axis."""
    artists, colours = drawn_texts(figure)
    texts = [(artist.get_text(), box) for artist, box in artists]
    assert len(texts) > 3
    found = [f"{a!r} on {b!r}" for (a, box), (b, other) in combinations(texts, 2) if _meet(box, other)]
    page = figure.bbox
    found += [
        f"{text!r} leaves the figure"
        for text, box in texts
        if box.x0 < page.x0 or box.y0 < page.y0 or box.x1 > page.x1 or box.y1 > page.y1
    ]
    found += [f"{text.get_text()!r} on a line" for text in crossed_texts(artists, colours)]
    offsets = [axis.get_offset_text().get_text() for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    return found + [f"offset {text!r}" for text in offsets if text]


def crossed_texts(artists, colours):
    """The texts without a background of their own under which the figure is dark."""
    rows = len(colours)
    plain = [(text, box) for text, box in artists if text.get_bbox_patch() is None]
    under = [colours[int(rows - b.y1) : int(rows - b.y0), int(b.x0) : int(b.x1)] for _, b in plain]
    return [text for (text, _), pixels in zip(plain, under, strict=True) if (pixels @ LUMINANCE < DARK).any()]


def _meet(box, other):
    return (
        min(box.x1, other.x1) - max(box.x0, other.x0) > TOUCH
        and min(box.y1, other.y1) - max(box.y0, other.y0) > TOUCH
    )

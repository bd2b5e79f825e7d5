"""The matplotlib figure of every picture, which notebooks show without pyplot."""

from io import BytesIO
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

FILE_DPI = 160
SCREEN_DPI = 90  # dots per inch in a notebook


class EmptyFigure(Figure):
    """An empty white figure of a size in inches."""

    def __init__(self, size: tuple[float, float], **options: Any) -> None:
        super().__init__(figsize=size, dpi=FILE_DPI, facecolor="white", **options)
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        image = BytesIO()
        self.savefig(image, format="png", dpi=SCREEN_DPI)
        return image.getvalue()

"""What shows itself in a notebook, and what has a picture."""

from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from camopt.scene.scene import Scene
    from camopt.tables.layout import Table


class Drawn:
    """What ``plot`` draws."""

    __slots__ = ()
    picture: ClassVar[str]
    """The module of ``drawing`` whose ``draw`` makes the picture, imported when something is drawn."""
    together: ClassVar[bool] = False
    """Whether it takes a list of them."""


class Shown:
    """A result that a notebook shows as HTML: its table, with a picture of the cam where it has one."""

    __slots__ = ()

    def table(self) -> "Table | None":
        """What the result says as a table, for every printer; None if it has no rows."""
        return None

    @property
    def shown_cam(self) -> "Scene | None":
        """The scene of the cam that is shown beside the table."""
        return None

    def _repr_html_(self) -> str:
        from camopt.drawing.notebook import html_of  # it draws the cam

        return html_of(self)

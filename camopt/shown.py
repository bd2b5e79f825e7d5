"""Results that show themselves in a notebook, and objects that have a picture."""

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from camopt.scene.scene import Scene
    from camopt.tables.layout import Table


class Drawn:
    """An object that ``plot`` draws."""

    __slots__ = ()
    picture: ClassVar[str]
    """The module of ``drawing`` whose ``draw`` makes the picture, imported when something is drawn."""
    together: ClassVar[bool] = False
    """Whether it takes a list of them."""


class HasHtml:
    """A result that a notebook shows as HTML: its table, with a picture of the cam where it has one."""

    __slots__ = ()
    html: ClassVar[Callable[["HasHtml"], str]]
    """What makes the HTML. The package sets it, for it draws the cam, and drawing stands above all results."""

    def table(self) -> "Table | None":
        """The result as a table, for every printer; None if it has no rows."""
        return None

    @property
    def shown_cam(self) -> "Scene | None":
        """The scene of the cam that is shown beside the table."""
        return None

    def _repr_html_(self) -> str:
        return HasHtml.html(self)

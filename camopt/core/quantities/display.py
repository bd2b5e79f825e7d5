"""Results that show themselves in a notebook, and objects that have a picture."""

from collections.abc import Callable
from typing import Any, ClassVar


class Drawable:
    """An object that ``plot`` draws."""

    __slots__ = ()
    picture: ClassVar[str]
    """The module of the package whose ``draw`` makes the picture, imported when something is drawn."""
    together: ClassVar[bool] = False
    """Whether it takes a list of them."""


class HasHtml:
    """What a notebook shows as HTML, with a picture of the cam where it has one.

    Scenes are shown so too, so nothing here names the types of what results have.
    """

    __slots__ = ()
    html: ClassVar[Callable[["HasHtml"], str]]
    """What makes the HTML. The package sets it, for it draws the cam, and drawing stands above all results."""

    @property
    def shown_cam(self) -> Any:
        """The ``Scene`` of the cam that is shown beside the table; None if there is none."""
        return None

    def _repr_html_(self) -> str:
        return HasHtml.html(self)

"""Base classes of results that a notebook shows, and of objects that ``plot`` draws."""

from collections.abc import Callable
from typing import Any, ClassVar


class Drawable:
    """An object that ``plot`` draws."""

    __slots__ = ()
    picture: ClassVar[str]
    """Module whose ``draw`` makes the picture. It is imported when an object is drawn."""
    together: ClassVar[bool] = False
    """Whether ``draw`` takes a list of the objects."""


class HasHtml:
    """A result that a notebook shows as HTML, with a picture of the cam if it has one.

    Scenes are such results too, so no type of the scene is named here.
    """

    __slots__ = ()
    html: ClassVar[Callable[["HasHtml"], str]]
    """Function that makes the HTML. The package sets it: drawing the cam belongs to a higher folder."""

    @property
    def shown_cam(self) -> Any:
        """The ``Scene`` of the cam that is shown beside the table, or None."""
        return None

    def _repr_html_(self) -> str:
        return HasHtml.html(self)

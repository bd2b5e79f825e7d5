"""What shows itself in a notebook, and what has a picture."""

from typing import ClassVar


class Drawn:
    """What ``plot`` draws."""

    __slots__ = ()
    picture: ClassVar[str]
    """The module of ``drawing`` whose ``draw`` makes the picture, imported when something is drawn."""
    together: ClassVar[bool] = False
    """Whether it takes a list of them."""


class Shown:
    """A result that a notebook shows as HTML, a table with a picture of the cam where it has one."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        from camopt.drawing.notebook import html_of  # pages are made of results: it imports all of them

        return html_of(self)

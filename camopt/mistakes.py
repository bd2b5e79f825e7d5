"""Errors: mistakes of a user, each one line; limits that cannot be met; a solver that fails; stopped work."""

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

LONGEST_SHOWN = 100  # characters of a value
ALIKE = 0.75  # share of two words that is the same, in those that mean the same
MOST_LISTED, MOST_MEANT = 30, 3  # known names; those that may have been meant


@dataclass(frozen=True)
class Mistake:
    """One mistake. ``allowed`` completes the sentence "must be …", or says what is wrong if ``bare``."""

    file: str
    key: str
    value: Any
    allowed: str
    bare: bool = False

    def __str__(self) -> str:
        shown = "" if self.value is None else f" = {_short(self.value)}"
        return printable(f"{self.file}: {self.key}{shown}: {'' if self.bare else 'must be '}{self.allowed}")


def printable(text: str) -> str:
    """A line for a terminal: what is no printable character (line ends, escape sequences) as Python writes it."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def _short(value: Any) -> str:
    """A value as Python writes it, in a part of a line."""
    text = repr(value)
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}…"


class BadInput(ValueError):
    """Mistakes in what was asked, all of them at once.

    Parameters
    ----------
    mistakes : iterable of Mistake
        Each with its place (``file``, ``key``), the ``value`` there, and what is ``allowed``.

    Examples
    --------
    >>> try:
    ...     camopt.find_scene("two-pauses").replace(**{"cam.rpm": -1, "cam.base_radus": 30})
    ... except camopt.BadInput as error:
    ...     [mistake.key for mistake in error.mistakes]
    ['cam.rpm', 'cam.base_radus']
    """

    def __init__(self, mistakes: Iterable[Mistake]) -> None:
        self.mistakes = tuple(mistakes)
        super().__init__(self.mistakes)  # what pickle makes it from again, in another process

    def __str__(self) -> str:
        return "\n".join(str(mistake) for mistake in self.mistakes)


class UnknownName(KeyError):
    """A mapping has no such key; the message names the most similar ones.

    Examples
    --------
    >>> camopt.evaluate(camopt.find_scene("two-pauses"))["undercutt"]
    Traceback (most recent call last):
    camopt.mistakes.UnknownName: 'undercutt' is no quantity of this evaluation; did you mean undercut? ...
    """

    def __str__(self) -> str:
        return str(self.args[0])  # a KeyError would show it in quotes


class Unmet(Exception):
    """No new motion law meets all limits; the message says why, as far as it is known.

    Examples
    --------
    >>> coarse = {"synthesis.pieces": 12, "search.base_radius": {"start": 2, "stop": 3}}
    >>> try:
    ...     camopt.synthesise(camopt.find_scene("roller-1000rpm").replace(**coarse))
    ... except camopt.Unmet:
    ...     print("no motion law makes so small a cam")
    no motion law makes so small a cam
    """


class Unsolved(ArithmeticError):
    """The convex solver failed; the message says how.

    Examples
    --------
    >>> coarse = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
    >>> try:
    ...     found = camopt.synthesise(coarse)
    ... except camopt.Unsolved as error:
    ...     print(f"try other [synthesis] pieces: {error}")
    """


class Stopped(Exception):
    """The ``progress`` of a caller returned False, which ends the work; the message says what is kept, if any.

    Examples
    --------
    >>> try:
    ...     camopt.optimise(camopt.find_scene("roller-1000rpm"), progress=lambda done, total: False)
    ... except camopt.Stopped as error:
    ...     print(error)
    stopped by the caller
    """


def nearest(word: str, known: Iterable[str]) -> str:
    """What may have been meant, as the end of a message; and what is known."""
    known = list(known)
    close = (
        get_close_matches(word, known, n=1, cutoff=ALIKE)
        or _with_such_a_part(word, known)
        or get_close_matches(word, known, n=1, cutoff=0.5)
    )
    listed = known if len(known) <= MOST_LISTED else get_close_matches(word, known, n=MOST_LISTED, cutoff=0.0)
    rest = f" and {len(known) - len(listed)} more" if len(listed) < len(known) else ""
    return (f"did you mean {' or '.join(close)}? " if close else "") + f"known: {', '.join(listed)}{rest}"


def _with_such_a_part(word: str, known: list[str]) -> list[str]:
    """The first names with a part, between underscores, that is much like a word: pressure_… for presure."""
    parts = dict.fromkeys(part for name in known for part in name.split("_"))
    close = get_close_matches(word, parts, n=1, cutoff=ALIKE)
    return [name for name in known if close and close[0] in name.split("_")][:MOST_MEANT]

"""Errors of camopt: mistakes in the input, a line each; limits that cannot be met; failed solvers; stopped work."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from typing import Any

LONGEST_SHOWN, LONGEST_NAME, LONGEST_LINE = 100, 200, 1000  # characters of a value, of a file or key, of a message
NOTHING_FEASIBLE, BAD_INPUT, FILE_TROUBLE, NOT_REACHED = 1, 2, 3, 4  # exit codes of commands
MOST_SHOWN = 20  # mistakes
ALIKE_SHARE, LIKE_SHARE = 0.75, 0.5  # least similarity of a misspelling; of a distant suggestion
MOST_LISTED, MOST_SUGGESTED = 40, 3  # most known names in a message; most suggestions


@dataclass(frozen=True)
class Mistake:
    """One mistake. ``allowed`` completes "must be …"; if ``bare``, it is the whole sentence."""

    file: str
    key: str
    value: Any
    allowed: str
    bare: bool = False

    def __str__(self) -> str:
        value = shorten(self.value, 2 * LONGEST_SHOWN) if isinstance(self.value, str) else self.value
        shown = "" if value is None else f" = {shorten(repr(value))}"
        place = f"{shorten(self.file, LONGEST_NAME)}: {shorten(self.key, LONGEST_NAME)}"
        return to_terminal_line(f"{place}{shown}: {'' if self.bare else 'must be '}{self.allowed}")


def escape_unprintable(text: str) -> str:
    """A line for a terminal: line ends and other unprintable characters are escaped as in Python."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def shorten(text: str, most_characters: int = LONGEST_SHOWN) -> str:
    """A text of at most ``most_characters`` characters: a longer one loses its middle."""
    if len(text) <= most_characters:
        return text
    end = (most_characters - 1) // 2
    return f"{text[: most_characters - 1 - end]}…{text[-end:]}"


def to_terminal_line(text: str) -> str:
    """A message as a line for a terminal, shortened if it is long."""
    return shorten(escape_unprintable(shorten(text, LONGEST_LINE)), LONGEST_LINE)


def join_words(words: Sequence[Any], most_listed: int = MOST_LISTED) -> str:
    """Words joined by commas; after ``most_listed`` words, the number of the rest."""
    more = f" and {len(words) - most_listed:,} more" if len(words) > most_listed else ""
    return ", ".join(shorten(str(word)) for word in words[:most_listed]) + more


class CamoptError(Exception):
    """Base class of all errors that camopt raises on purpose, with messages for users.

    Examples
    --------
    >>> try:
    ...     camopt.find_scene("two-pause")
    ... except camopt.CamoptError as error:
    ...     print(type(error).__name__)
    BadInput
    """


class BadInput(CamoptError, ValueError):
    """All mistakes in the input, together.

    Parameters
    ----------
    mistakes : iterable of Mistake
        Each with its place (``file``, ``key``), the ``value`` there, and the ``allowed`` values.
    scene : Scene, optional
        The refused scene without its wrong values, from which a picture can show the mistake.

    Examples
    --------
    >>> try:
    ...     camopt.find_scene("two-pauses").replace(**{"cam.rpm": -1, "cam.base_radus": 30})
    ... except camopt.BadInput as error:
    ...     [mistake.key for mistake in error.mistakes]
    ['cam.rpm', 'cam.base_radus']
    """

    def __init__(self, mistakes: Iterable[Mistake], scene: Any = None) -> None:
        self.mistakes, self.scene = tuple(mistakes), scene
        super().__init__(self.mistakes)  # pickle rebuilds the error from it, in another process

    def __str__(self) -> str:
        more = len(self.mistakes) - MOST_SHOWN
        lines = [str(mistake) for mistake in self.mistakes[:MOST_SHOWN]]
        return "\n".join([*lines, *([f"and {more:,} more mistakes"] if more > 0 else [])])


class UnknownName(CamoptError, KeyError):
    """A mapping does not have the key; the message names similar keys.

    Examples
    --------
    >>> camopt.evaluate(camopt.find_scene("two-pauses"))["undercutt"]
    Traceback (most recent call last):
    camopt.core.mistakes.UnknownName: 'undercutt' is not a quantity of this evaluation; did you mean undercut? ...
    """

    def __str__(self) -> str:
        return str(self.args[0])  # a KeyError would show it in quotes


class Unmet(CamoptError):
    """No computed motion law meets all limits; the message says why, as far as known.

    Examples
    --------
    >>> coarse = {"synthesis.pieces": 12, "search.base_radius": {"start": 2, "stop": 3}}
    >>> try:
    ...     camopt.synthesise(camopt.find_scene("roller-1000rpm").replace(**coarse))
    ... except camopt.Unmet:
    ...     print("no motion law makes so small a cam")
    no motion law makes so small a cam
    """


class Unsolved(CamoptError, ArithmeticError):
    """The convex solver failed; the message gives its status.

    Examples
    --------
    >>> coarse = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
    >>> try:
    ...     found = camopt.synthesise(coarse)
    ... except camopt.Unsolved as error:
    ...     print(f"try other [synthesis] pieces: {error}")
    """


class Stopped(CamoptError):
    """The caller's ``progress`` returned False and ended the work; the message says which results are kept.

    Examples
    --------
    >>> try:
    ...     camopt.optimise(camopt.find_scene("roller-1000rpm"), progress=lambda done, total: False)
    ... except camopt.Stopped as error:
    ...     print(error)
    stopped by the caller
    """


def similar_name(word: str, known_names: Iterable[str]) -> str:
    """The known name most similar to a word; empty if none is near."""
    return next(iter(get_close_matches(shorten(word), [*known_names], n=1, cutoff=ALIKE_SHARE)), "")


def suggest_names(word: str, known_names: Iterable[str]) -> str:
    """The end of a message: similar names, and all known names if they are few."""
    return _cached_suggestion(shorten(word), tuple(known_names))


@lru_cache(100)
def _cached_suggestion(word: str, known_names: tuple[str, ...]) -> str:
    """As ``suggest_names``, cached: a wrong word may occur a thousand times."""
    close = (
        get_close_matches(word, known_names, n=1, cutoff=ALIKE_SHARE)
        or _names_with_similar_part(word, known_names)
        or get_close_matches(word, known_names, n=1, cutoff=LIKE_SHARE)
    )
    meant = f"did you mean {' or '.join(map(shorten, close))}? " if close else ""
    if len(known_names) <= MOST_LISTED:
        return f"{meant}known: {join_words(known_names)}"
    return f"{meant}{len(known_names)} names are known"


def _names_with_similar_part(word: str, known_names: Sequence[str]) -> list[str]:
    """The first names with a part between underscores that is similar to a word: pressure_… for presure."""
    parts = dict.fromkeys(part for name in known_names for part in name.split("_"))
    close = get_close_matches(word, parts, n=1, cutoff=ALIKE_SHARE)
    return [name for name in known_names if close and close[0] in name.split("_")][:MOST_SUGGESTED]

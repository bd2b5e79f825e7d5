"""Errors: mistakes of a user, each one line; limits that cannot be met; a solver that fails; stopped work."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from typing import Any

LONGEST_SHOWN, LONGEST_NAME, LONGEST_LINE = 100, 200, 1000  # characters of a value, of a file or key, of a message
NOTHING_FEASIBLE, BAD_INPUT, FILE_TROUBLE, NOT_REACHED = 1, 2, 3, 4  # exit codes of commands
MOST_SHOWN = 20  # mistakes
ALIKE_SHARE, LIKE_SHARE = 0.75, 0.5  # share in common: of a word and its misspelling; of words that are like
MOST_LISTED, MOST_SUGGESTED = 40, 3  # known names; those that may have been meant


@dataclass(frozen=True)
class Mistake:
    """One mistake. ``allowed`` completes the sentence "must be …", or says what is wrong if ``bare``."""

    file: str
    key: str
    value: Any
    allowed: str
    bare: bool = False

    def __str__(self) -> str:
        shown = "" if self.value is None else f" = {shorten(_python_text(self.value))}"
        place = f"{shorten(self.file, LONGEST_NAME)}: {shorten(self.key, LONGEST_NAME)}"
        return line_of(f"{place}{shown}: {'' if self.bare else 'must be '}{self.allowed}")


def printable(text: str) -> str:
    """A line for a terminal: what is no printable character (line ends, escape sequences) as Python writes it."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def shorten(text: str, most: int = LONGEST_SHOWN) -> str:
    """A text of at most ``most`` characters: a longer one loses its middle."""
    if len(text) <= most:
        return text
    end = (most - 1) // 2
    return f"{text[: most - 1 - end]}…{text[-end:]}"


def line_of(text: str) -> str:
    """A message as a line for a terminal, shortened if what it quotes is long."""
    return shorten(printable(shorten(text, LONGEST_LINE)), LONGEST_LINE)


def join_words(words: Sequence[Any], most: int = MOST_LISTED) -> str:
    """Words after each other, and how many more there are."""
    more = f" and {len(words) - most:,} more" if len(words) > most else ""
    return ", ".join(shorten(str(word)) for word in words[:most]) + more


def _python_text(value: Any) -> str:
    """A value as Python writes it; of a long one only the ends."""
    if isinstance(value, str) and len(value) > 2 * LONGEST_SHOWN:
        value = shorten(value, 2 * LONGEST_SHOWN)
    return repr(value)


class CamoptError(Exception):
    """The base of the errors that camopt raises on purpose: their messages are for readers.

    Examples
    --------
    >>> try:
    ...     camopt.find_scene("two-pause")
    ... except camopt.CamoptError as error:
    ...     print(type(error).__name__)
    BadInput
    """


class BadInput(CamoptError, ValueError):
    """Mistakes in the input, all of them at once.

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
        more = len(self.mistakes) - MOST_SHOWN
        lines = [str(mistake) for mistake in self.mistakes[:MOST_SHOWN]]
        return "\n".join([*lines, *([f"and {more:,} more mistakes"] if more > 0 else [])])


class UnknownName(CamoptError, KeyError):
    """A mapping has no such key; the message names the most similar ones.

    Examples
    --------
    >>> camopt.evaluate(camopt.find_scene("two-pauses"))["undercutt"]
    Traceback (most recent call last):
    camopt.core.mistakes.UnknownName: 'undercutt' is no quantity of this evaluation; did you mean undercut? ...
    """

    def __str__(self) -> str:
        return str(self.args[0])  # a KeyError would show it in quotes


class Unmet(CamoptError):
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


class Unsolved(CamoptError, ArithmeticError):
    """The convex solver failed; the message says how.

    Examples
    --------
    >>> coarse = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
    >>> try:
    ...     found = camopt.synthesise(coarse)
    ... except camopt.Unsolved as error:
    ...     print(f"try other [synthesis] pieces: {error}")
    """


class Stopped(CamoptError):
    """The caller's ``progress`` returned False, which ends the work; the message says what is kept.

    Examples
    --------
    >>> try:
    ...     camopt.optimise(camopt.find_scene("roller-1000rpm"), progress=lambda done, total: False)
    ... except camopt.Stopped as error:
    ...     print(error)
    stopped by the caller
    """


def similar_name(word: str, known: Iterable[str]) -> str:
    """The known name that is much like a word; empty if there is none."""
    return next(iter(get_close_matches(shorten(word), [*known], n=1, cutoff=ALIKE_SHARE)), "")


def suggest_names(word: str, known: Iterable[str]) -> str:
    """The known names as the end of a message: all of a few, and those that a word may mean."""
    return _cached_suggestion(shorten(word), tuple(known))


@lru_cache(100)
def _cached_suggestion(word: str, known: tuple[str, ...]) -> str:
    """The same, cached: one wrong word may occur a thousand times."""
    close = (
        get_close_matches(word, known, n=1, cutoff=ALIKE_SHARE)
        or _names_with_part(word, known)
        or get_close_matches(word, known, n=1, cutoff=LIKE_SHARE)
    )
    meant = f"did you mean {' or '.join(map(shorten, close))}? " if close else ""
    if len(known) <= MOST_LISTED:
        return f"{meant}known: {join_words(known)}"
    return f"{meant}{len(known)} names are known"


def _names_with_part(word: str, known: Sequence[str]) -> list[str]:
    """The first names with a part, between underscores, that is much like a word: pressure_… for presure."""
    parts = dict.fromkeys(part for name in known for part in name.split("_"))
    close = get_close_matches(word, parts, n=1, cutoff=ALIKE_SHARE)
    return [name for name in known if close and close[0] in name.split("_")][:MOST_SUGGESTED]

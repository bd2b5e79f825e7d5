"""A stage of a train: its keys in scenes, and the links that they make."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from camopt.trains.link import Link, Unassembled

Keys = Mapping[str, Any]
"""The values of a stage by key, mm and deg: those that it needs, and of the others those that are given."""


@dataclass(frozen=True)
class Stage:
    """A kind of stage."""

    name: str
    words: str
    needs: tuple[str, ...]
    """The keys that it has to have."""
    others: tuple[str, ...]
    """Those that it may have."""
    turns: Callable[[Keys, bool], bool]
    """Whether what it moves is an angle, if what comes to it is one or not."""
    links: Callable[[Keys, bool], Sequence[Link]]
    """Its links from values by key, and whether what comes to it is an angle; raises ``Unassembled``."""

    def made(self, keys: Keys, turns: bool) -> Sequence[Link]:
        """Its links from values by key, and whether what comes to it is an angle.

        Raises
        ------
        Unassembled
            If a key is missing or is none of its own, or it cannot be put together.
        """
        own = (*self.needs, *self.others)
        if missing := [key for key in self.needs if keys.get(key) is None]:
            raise Unassembled(f"{self.words} needs {', '.join(missing)}")
        if strange := [key for key, value in keys.items() if value is not None and key not in own]:
            raise Unassembled(f"{self.words} has no {strange[0]}; known: {', '.join(own)}")
        return self.links({key: value for key, value in keys.items() if value is not None}, turns)

"""The record of a key of a scene, which stands beside its type: what the key is, and the unit of its number."""

from dataclasses import dataclass

NO_UNIT = "no unit"
"""The unit of a number that has none."""


@dataclass(frozen=True)
class Key:
    """What a key of a scene is, in a sentence without its full stop, and the unit of its number."""

    sentence: str
    unit: str = ""
    """Empty for what is no number."""
    turning: str = ""
    """The unit where what the key is about turns, if that is another one."""

    @property
    def units(self) -> str:
        """Both units, as people read them."""
        return f"{self.unit}, oscillating {self.turning}" if self.turning else self.unit

    def unit_of(self, *, turns: bool) -> str:
        """The unit where what the key is about turns, or slides."""
        return self.turning if turns and self.turning else self.unit

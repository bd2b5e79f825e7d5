"""A quantity: its symbol, unit and sentence, and from which side it can be bounded."""

import re
from dataclasses import dataclass, field

AT_MOST, AT_LEAST = "≤", "≥"
UNBOUNDED_EFFECTS = ("sizes", "limits", "proof")
"""Effects whose quantities are what is asked, or its answer."""


def column_suffix(unit: str) -> str:
    """What the name of a quantity ends with for its unit, as _N_m_per_rad for N·m/rad; of s no per, as _m_s2."""
    text = re.sub(r"/(?=s[²³]?$)|·", "_", unit).replace("1/", "per_").replace("/", "_per_")
    return f"_{text}".translate(str.maketrans("²³µ", "23u")) if text else ""


@dataclass(frozen=True)
class Quantity:
    """One reportable quantity. ``effect`` names the effect that computes it; ``kind`` is its column type."""

    name: str
    symbol: str
    unit: str
    effect: str
    sentence: str
    kind: type = float
    least: bool = field(default=False, kw_only=True)
    """Whether one wants at least so much of it; of others at most."""
    signed: bool = field(default=False, kw_only=True)
    """Whether it may be below 0, and bounds on it too."""
    place: bool = field(default=False, kw_only=True)
    """Whether it says where or how something is, not how much, so that nothing bounds it."""

    @property
    def relation(self) -> str:
        """The relation to its bound, ≤ or ≥; empty if it cannot be bounded."""
        if self.place or self.kind is not float or self.effect in UNBOUNDED_EFFECTS:
            return ""
        return AT_LEAST if self.least else AT_MOST

    @property
    def side(self) -> float:
        """−1 for a quantity bounded from below, else 1."""
        return -1.0 if self.relation == AT_LEAST else 1.0

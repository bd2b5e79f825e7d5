"""A quantity: its name, symbol, unit and sentence, and the side from which a limit bounds it."""

import re
from dataclasses import dataclass, field

AT_MOST, AT_LEAST = "≤", "≥"
UNBOUNDED_EFFECTS = ("sizes", "limits", "proof")
"""Effects whose quantities are inputs or verdicts, which no limit bounds."""


def column_suffix(unit: str) -> str:
    """End of a quantity's name for a unit: _N_m_per_rad for N·m/rad, but _m_s2 for m/s²."""
    text = re.sub(r"/(?=s[²³]?$)|·", "_", unit).replace("1/", "per_").replace("/", "_per_")
    return f"_{text}".translate(str.maketrans("²³µ", "23u")) if text else ""


@dataclass(frozen=True)
class Quantity:
    """A quantity that camopt reports. ``effect`` computes it; ``kind`` is the type of its column."""

    name: str
    symbol: str
    unit: str
    effect: str
    sentence: str
    kind: type = float
    least: bool = field(default=False, kw_only=True)
    """Whether a limit is a lower bound; else it is an upper bound."""
    signed: bool = field(default=False, kw_only=True)
    """Whether its values and its limits may be below 0."""
    place: bool = field(default=False, kw_only=True)
    """Whether it is a place or a description, which no limit bounds."""

    @property
    def relation_to_limit(self) -> str:
        """Relation to its limit, ≤ or ≥; empty if no limit can bound it."""
        if self.place or self.kind is not float or self.effect in UNBOUNDED_EFFECTS:
            return ""
        return AT_LEAST if self.least else AT_MOST

    @property
    def limit_sign(self) -> float:
        """−1 for a lower limit, else 1."""
        return -1.0 if self.relation_to_limit == AT_LEAST else 1.0

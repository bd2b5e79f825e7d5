"""The table ``[limits]`` of a scene: what the cam must hold."""

from typing import Annotated, Any

from pydantic import ConfigDict

from camopt.core.quantities import AT_LEAST, BOUNDED, Quantity
from camopt.core.quantities.key import NO_UNIT, Key
from camopt.core.quantities.limit_keys import LIMIT_KEYS
from camopt.scene.tables import Anywhere, Positive, TableOfRecords, Within, with_keys


def _key_of(quantity: Quantity) -> Key:
    """The key that is the name of a quantity."""
    words = "Least allowed" if quantity.relation == AT_LEAST else "Most allowed"
    return Key(f"{words} ``{quantity.name}``", quantity.unit or NO_UNIT)


KEYS: dict[str, tuple[Any, Key]] = {
    key: (Annotated[float, Within(**each.allowed)], each) for key, each in LIMIT_KEYS.items()
} | {
    name: (Anywhere if each.signed else Positive, _key_of(each))
    for name, each in BOUNDED.items()
    if name not in LIMIT_KEYS
}


@with_keys(KEYS)
class Limits(TableOfRecords):
    """What the cam must hold, by a short key or by the name of any quantity; each is optional."""

    model_config = ConfigDict(extra="allow")  # names of the scene's own quantities, which the scene checks
    __pydantic_extra__: dict[str, Anywhere | None]

    @property
    def given(self) -> dict[str, float]:
        """The bounds that are set, by key."""
        return {key: bound for key, bound in self if bound is not None}

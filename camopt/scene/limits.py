"""The table ``[limits]`` of a scene: limits that the cam must meet."""

from typing import Annotated, Any

from pydantic import ConfigDict

from camopt.core.quantities import AT_LEAST, BOUNDED_QUANTITIES
from camopt.core.quantities.key import NO_UNIT, Key
from camopt.core.quantities.limit_keys import LIMIT_KEYS
from camopt.scene.tables import BoundedNumber, Positive, SignedNumber, TableOfRecords, with_optional_keys

LIMIT_TABLE_KEYS: dict[str, tuple[Any, Key]] = {
    key: (Annotated[float, BoundedNumber(**each.allowed)], each) for key, each in LIMIT_KEYS.items()
} | {
    name: (
        SignedNumber if each.signed else Positive,
        Key(
            f"{'Least' if each.relation_to_limit == AT_LEAST else 'Largest'} allowed `{name}`", each.unit or NO_UNIT
        ),
    )
    for name, each in BOUNDED_QUANTITIES.items()
    if name not in LIMIT_KEYS
}


@with_optional_keys(LIMIT_TABLE_KEYS)
class Limits(TableOfRecords):
    """Limits that the cam must meet, by a short key or by the name of any quantity; each is optional."""

    model_config = ConfigDict(extra="allow")  # for quantities that the scene defines, which it checks itself
    __pydantic_extra__: dict[str, SignedNumber | None]

    @property
    def bounds_by_key(self) -> dict[str, float]:
        """The bounds that are set, by key."""
        return {key: bound for key, bound in self if bound is not None}

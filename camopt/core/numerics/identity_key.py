"""Keys for caches of results that belong to one object."""

from typing import Any, Generic, TypeVar

KeyedValue = TypeVar("KeyedValue")


class IdentityKey(Generic[KeyedValue]):
    """A key that is equal only for the same object, which it keeps alive."""

    def __init__(self, value: KeyedValue) -> None:
        self.value = value

    def __hash__(self) -> int:
        return id(self.value)

    def __eq__(self, other: Any) -> bool:
        return isinstance(other, IdentityKey) and other.value is self.value

"""Keys by which results are remembered of one and the same object."""

from typing import Any, Generic, TypeVar

Value = TypeVar("Value")


class Same(Generic[Value]):
    """A key that is equal for one and the same object, which it keeps."""

    def __init__(self, value: Value) -> None:
        self.value = value

    def __hash__(self) -> int:
        return id(self.value)

    def __eq__(self, other: Any) -> bool:
        return isinstance(other, Same) and other.value is self.value

"""A cache of results that belong to one object."""

from collections.abc import Callable, Hashable
from functools import lru_cache, wraps
from typing import Any, TypeVar, cast

CachedFunction = TypeVar("CachedFunction", bound=Callable[..., Any])


class IdentityKey:
    """A key that is equal only for the same object, which it keeps alive."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __hash__(self) -> int:
        return id(self.value)

    def __eq__(self, other: Any) -> bool:
        return isinstance(other, IdentityKey) and other.value is self.value


def cached_by_identity(maxsize: int) -> Callable[[CachedFunction], CachedFunction]:
    """Decorator: as ``lru_cache``, for a function whose first argument is equal only to itself."""

    def decorate(function: CachedFunction) -> CachedFunction:
        @lru_cache(maxsize)
        def find_result(key: IdentityKey, *others: Hashable) -> Any:
            return function(key.value, *others)

        @wraps(function)
        def call_with_cached_result(owner: Any, *others: Hashable) -> Any:
            return find_result(IdentityKey(owner), *others)

        return cast(CachedFunction, call_with_cached_result)

    return decorate

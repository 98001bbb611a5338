"""What was computed last, so that it is not computed again where nothing has changed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

T = TypeVar("T")


class Latest(Generic[T]):
    """The latest results of a function of numbers, ``count`` of them at most. They must not be changed."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._kept: list[tuple[bytes, T]] = []

    def of(self, given: bytes, compute: Callable[[], T]) -> T:
        """The result for what is ``given``, to the last bit; ``compute`` finds it if it is a new one."""
        for before, result in reversed(self._kept):
            if before == given:
                return result
        result = compute()
        self._kept = [*self._kept[1 - self._count :], (given, result)]
        return result

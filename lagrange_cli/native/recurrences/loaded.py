"""Values that are loaded where they are asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

K = TypeVar("K")
X = TypeVar("X")


class Loaded(dict[K, X]):
    """A mapping to what ``load`` writes, each time that it is asked for, or to what has been set; ``has``
    tells for which keys there are values."""

    def __init__(self, load: Callable[[K], X], has: Callable[[K], bool] = lambda key: True) -> None:
        self._load, self._has = load, has

    def __missing__(self, key: K) -> X:
        return self._load(key)

    def __contains__(self, key: object) -> bool:
        return self._has(key)  # type: ignore[arg-type]

    def get(self, key: K, default: X = None) -> X:  # type: ignore[assignment, override]
        return self[key] if self._has(key) else default

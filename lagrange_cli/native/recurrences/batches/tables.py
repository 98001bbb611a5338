"""Constant tables of the code of batches: places, and numbers."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from lagrange_cli.expression.node import Node
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.records import dataclass, field

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

N = TypeVar("N", int, float)


@dataclass
class Tables:
    """Constant tables of the code: places in ``%work`` and ``%constants``, and numbers; and how many doubles
    of ``@scratch`` it takes."""

    constants: Constants
    places: array[int] = field(default_factory=lambda: array("i"))
    numbers: array[float] = field(default_factory=lambda: array("d"))
    seen: dict[tuple[object, ...], int] = field(default_factory=dict)
    scratch: int = 0

    def of_places(self, listed: Sequence[int]) -> int:
        """Where the table has these places, in whole vectors: the last one is repeated."""
        return self._listed(self.places, listed)

    def of_array(self, listed: Places) -> int:
        """The same for many places."""
        if not len(listed):
            return 0
        whole = np.append(listed, np.repeat(listed[-1:], -len(listed) % LANES)).astype(np.int32).tobytes()
        key = (whole,)
        if key not in self.seen:
            self.seen[key] = len(self.places)
            self.places.frombytes(whole)
        return self.seen[key]

    def of_numbers(self, listed: Sequence[float]) -> int:
        """The same for numbers."""
        return self._listed(self.numbers, listed)

    def _listed(self, table: array[N], listed: Sequence[N]) -> int:
        key = (table.typecode, *listed)
        if key not in self.seen:
            self.seen[key] = len(table)
            table.extend(filled(listed))
        return self.seen[key]

    def of_constants(self, nodes: Sequence[Node]) -> int:
        """The places of constants of the motion in ``%constants``."""
        return self.of_places([self.constants.slot(node) for node in nodes])

    def text(self) -> str:
        """Both tables."""
        rows = (("places", self.places), ("factors", self.numbers))
        return "".join(data(name, row.tobytes() or bytes(8)) for name, row in rows)


def filled(listed: Sequence[N]) -> list[N]:
    """Whole vectors of these."""
    return list(listed) + list(listed[-1:]) * (-len(listed) % LANES)


def data(name: str, content: bytes) -> str:
    """A constant array of bytes."""
    text = "\\" + content.hex("\\").upper()
    return f'@{name} = private constant [{len(content)} x i8] c"{text}", align 64\n'

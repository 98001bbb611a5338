"""Where an expression of a family stands: its indices, for all its members; and which are written alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lagrange_cli.expression.index_arrays import taken
from lagrange_cli.expression.syntax import Tree
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.indexed.conditions import Condition, Loop
from lagrange_cli.symbolic.indexed.whole import Whole


class Split(Exception):
    """Members differ in kind: where ``condition`` holds they are of one."""

    def __init__(self, condition: Condition) -> None:
        super().__init__()
        self.condition = condition


class Frame(dict[str, Any]):
    """Where an expression stands: the values of indices for all its ``count`` members (and sizes), and what
    they are in terms of the indices of the loops around it (``names``), whose values are ``arrays``."""

    def __init__(
        self, values: Mapping[str, Any], count: int, names: Mapping[str, Whole], arrays: Mapping[str, Any]
    ) -> None:
        super().__init__(values)
        self.count, self.names, self.arrays = count, names, arrays

    def part(self, which: Any) -> Frame:
        """The same for some of the members."""
        arrays = {name: np.broadcast_to(one, self.count)[which] for name, one in self.arrays.items()}
        return Frame(taken(self, which), len(which), self.names, arrays)


@dataclass(frozen=True)
class Kind:
    """Members of a family that are written alike: the ``loops`` through them, the ``indices`` of a member,
    and where their expression stands."""

    loops: tuple[Loop, ...]
    indices: tuple[Whole, ...]
    tree: Tree
    frame: Frame

"""The values of a system of families at a state, by arrays of numpy: each expression once for all members."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import NONE, Array, Chain, Slots, Source, Term, Total
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.spec import Spec

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.float64]

FUNCTIONS: dict[str, np.ufunc] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "exp": np.exp, "log": np.log, "sqrt": np.sqrt,
    "atan2": np.arctan2,
}  # fmt: skip


class Doubles:
    """How numbers of arrays are computed: as doubles."""

    functions: Mapping[str, Callable[..., Any]] = FUNCTIONS
    exact: Any = None
    """The module of numbers with many digits."""

    def number(self, value: Any) -> Any:
        """A number of an expression."""
        return float(value)

    def array(self, values: Any) -> Any:
        """Numbers as an array."""
        return np.asarray(values, dtype=np.float64)

    def zeros(self, *shape: int) -> Any:
        """An array of zeros."""
        return np.zeros(shape)

    def add(self, made: Any, targets: Any, values: Any) -> None:
        """Add values to those at the places ``targets``."""
        if made.ndim == 1:
            made += np.bincount(targets, values, len(made))
        elif np.all(np.diff(targets) > 0):
            made[targets] += values
        else:
            np.add.at(made, targets, values)


DOUBLES = Doubles()


class Described(Protocol):
    """What expressions of families are made of."""

    @property
    def spec(self) -> Spec: ...
    @property
    def slots(self) -> Slots: ...
    @property
    def q(self) -> Array: ...
    @property
    def v(self) -> Array: ...
    @property
    def given(self) -> Array: ...
    @property
    def time(self) -> Node: ...
    @property
    def parameters(self) -> Mapping[str, Node]: ...


class FamilyValues:
    """The values at one state: ``q``, ``v`` (coordinates,), t, ``parameters`` in the file's order, and those
    of ``others``; numbers of a ``kind``. At several states q and v are (coordinates, states), t is (states,),
    and so are values: of each member, those at all states."""

    def __init__(
        self,
        system: Described,
        t: float | Values,
        q: Values,
        v: Values,
        parameters: Values,
        others: Mapping[Array, Values] | None = None,
        kind: Doubles = DOUBLES,
    ) -> None:
        self.slots, self.kind = system.slots, kind
        self._states = q.shape[1:]
        self._arrays: dict[Array, Values] = {system.q: q, system.v: v, system.given: self._each(parameters)}
        self._arrays |= others or {}
        names = names_of(system.spec.parameters).starts
        self._scalars: dict[Node, Any] = {system.time: t}
        self._scalars |= {node: parameters[names[name]] for name, node in system.parameters.items()}

    def of(self, total: Total) -> Values:
        """The sums of a total (count,), or (count, states)."""
        if total not in self._arrays:
            values = self.added(total.count, total.terms)
            self._arrays[total] = along(total, values) if isinstance(total, Chain) else values
        return self._arrays[total]

    def added(self, count: int, terms: Sequence[Term], *, sizes: bool = False) -> Values:
        """The sums of terms at ``count`` places; with ``sizes``, of the terms' absolute values."""
        made: Values = self.kind.zeros(count, *self._states)
        for term in terms:
            values = np.broadcast_to(self.node(term.node), (term.domain.count, *self._states))
            self.kind.add(made, term.targets, np.abs(values) if sizes else values)
        return made

    def _each(self, numbers: Values) -> Values:
        """Numbers of members as they stand beside those at all states."""
        return numbers.reshape(-1, *(1 for _ in self._states))

    def node(self, node: Node) -> Any:
        """An expression of each member of a domain (members,), or a number that all have."""
        known: dict[Node, Any] = {}
        for one in reachable([node]):
            known[one] = self._value(one, [known[argument] for argument in one.arguments])
        return known[node]

    def _value(self, node: Node, arguments: Sequence[Any]) -> Any:
        if node.kind is Kind.SYMBOL:
            if node in self._scalars:
                return self._scalars[node]
            slot = self.slots.of[node]
            if slot.array.source is Source.WHOLE:
                return self._each(self.kind.array(slot.table))
            array = self.of(slot.array) if isinstance(slot.array, Total) else self._arrays[slot.array]
            return array[slot.table]
        return OPERATIONS[node.kind](node.data, arguments, self.kind)


def along(chain: Chain, values: Values) -> Values:
    """Numbers added up along a chain."""
    assert chain.tree is not None
    if np.array_equal(chain.tree.parents, np.arange(-1, len(values) - 1)):
        return np.flip(np.cumsum(np.flip(values, 0), axis=0), 0) if chain.back else np.cumsum(values, axis=0)
    listed, parents = [*values] if values.ndim > 1 else values.tolist(), chain.tree.parents.tolist()
    order = chain.tree.order.tolist()
    for member in reversed(order) if chain.back else order:
        parent = parents[member]
        if parent != NONE:
            if chain.back:
                listed[parent] = listed[parent] + listed[member]
            else:
                listed[member] = listed[member] + listed[parent]
    return np.array(listed)


def _sum(data: Any, arguments: Sequence[Any], kind: Doubles) -> Any:
    constant, coefficients = data
    made = kind.number(constant)
    for coefficient, one in zip(coefficients, arguments):
        made = made + kind.number(coefficient) * one
    return made


def _product(data: Any, arguments: Sequence[Any], kind: Doubles) -> Any:
    made: Any = 1.0
    for exponent, one in zip(data, arguments):
        made = made * (one if exponent == 1 else one ** kind.number(exponent))
    return made


def _switch(data: Any, arguments: Sequence[Any], kind: Doubles) -> Any:
    u, above, below = arguments
    at = (above + below) / 2 if data == 0 else above if data > 0 else below
    return np.where(u > 0, above, np.where(u < 0, below, at))


OPERATIONS: Mapping[Kind, Callable[[Any, Sequence[Any], Doubles], Any]] = {
    Kind.NUMBER: lambda data, arguments, kind: kind.number(data),
    Kind.SUM: _sum,
    Kind.PRODUCT: _product,
    Kind.POWER: lambda data, arguments, kind: arguments[0] ** arguments[1],
    Kind.SWITCH: _switch,
    Kind.FUNCTION: lambda data, arguments, kind: kind.functions[str(data)](*arguments),
}

"""The algebra of columns: values that differ between the members of an ensemble, evaluated for all at once.

Sums, products and quotients are numpy's, which rounds as Python does; powers and functions are Python's own,
number by number, for numpy's may differ from them in the last bit. So each member gets the very numbers
that it would get alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.expression.reals import FADED
from lagrange_cli.expression.syntax import Tree

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Mask = NDArray[np.bool_]

T = TypeVar("T")


class Column:
    """One number for each member: ``values`` (members,).

    Where Python would raise, the value is nan and the member is noted in ``failed`` (members,), which all
    columns of an ensemble share.
    """

    __slots__ = ("failed", "values")
    __array_ufunc__ = None  # an array on the left leaves the operation to the column

    def __init__(self, values: Array, failed: Mask) -> None:
        self.values, self.failed = values, failed

    def __add__(self, other: Column | float) -> Column:
        return Column(self.values + numbers(other), self.failed)

    def __sub__(self, other: Column | float) -> Column:
        return Column(self.values - numbers(other), self.failed)

    def __rsub__(self, other: float) -> Column:
        return Column(other - self.values, self.failed)

    def __mul__(self, other: Column | float) -> Column:
        return self._kept(np.asarray(self.values * numbers(other)), self.values, numbers(other))

    def __truediv__(self, other: Column | float) -> Column:
        if not isinstance(other, Column) and other == 0:
            raise ZeroDivisionError
        return self._quotient(self.values, numbers(other))

    def __rtruediv__(self, other: float) -> Column:
        return self._quotient(other, self.values)

    def __pow__(self, other: Column | float) -> Column:
        power = self.each(pow, (self, other))
        return self._kept(power.values, self.values, 1.0)

    def __rpow__(self, other: float) -> Column:
        power = self.each(pow, (other, self))
        return self._kept(power.values, other, 1.0)

    def __neg__(self) -> Column:
        return Column(-self.values, self.failed)

    __radd__, __rmul__ = __add__, __mul__

    def _quotient(self, left: Array | float, right: Array | float) -> Column:
        self.failed |= right == 0
        return self._kept(np.asarray(left / right), left, 1.0)

    def _kept(self, values: Array, left: Array | float, right: Array | float) -> Column:
        """A product or quotient; it fails where it is 0 and neither of the numbers is."""
        self.failed |= (values == 0) & (left != 0) & (right != 0)
        return Column(values, self.failed)

    def each(self, function: Callable[..., Any], arguments: Sequence[Column | float]) -> Column:
        """A function of Python's floats applied member by member."""
        count = len(self.values)
        rows = [x.values.tolist() if isinstance(x, Column) else [x] * count for x in arguments]
        try:
            return Column(np.fromiter(map(function, *rows), float, count), self.failed)
        except (ArithmeticError, ValueError, TypeError):  # TypeError: a power that is complex
            return Column(np.fromiter(self._where_possible(function, rows), float, count), self.failed)

    def _where_possible(self, function: Callable[..., Any], rows: list[list[float]]) -> Iterable[float]:
        for member, arguments in enumerate(zip(*rows)):
            try:
                value = function(*arguments)
            except (ArithmeticError, ValueError):
                value = None
            self.failed[member] |= not isinstance(value, float)
            yield value if isinstance(value, float) else float("nan")


class ColumnAlgebra(NumberAlgebra):
    """``Algebra[Column | float]``: values that do not differ between members stay one float. Operations that
    Python would refuse for some members is noted in ``failed`` (members,), and so is an exp that is 0, unless
    it ``fades``.
    """

    def __init__(self, members: int, *, fades: bool = False) -> None:
        super().__init__()
        self.fades = fades
        self.failed: Mask = np.zeros(members, dtype=bool)

    def column(self, values: Array) -> Column:
        """The members' values (members,) of something that is given."""
        return Column(values, self.failed)

    def function(self, name: str, arguments: Sequence[Any]) -> Any:
        column = next((x for x in arguments if isinstance(x, Column)), None)
        if column is None:
            return super().function(name, arguments)
        found = column.each(self.FUNCTIONS[name], arguments)
        if name == "exp" and self.fades:
            return Column(np.where(found.values < FADED, 0.0, found.values), self.failed)
        if name == "exp":
            self.failed |= found.values == 0
        return found

    def side(self, u: Any, at: int) -> int | None:
        return None if isinstance(u, Column) else super().side(u, at)

    def switch(self, u: Column, above: Any, below: Any, at: int) -> Column:
        self.failed |= np.isnan(u.values)
        first = u.values > 0 if at < 0 else u.values >= 0
        return Column(np.where(first, numbers(above), numbers(below)), self.failed)

    def both(
        self, chosen: Column, above: Callable[[], Value], below: Callable[[], Value]
    ) -> tuple[Value, Value]:
        """Both branches; a member has failed if its valid branch has."""
        before, failed = self.failed.copy(), []
        values = []
        for branch in (above, below):
            self.failed[:] = before
            values.append(branch())
            failed.append(self.failed.copy())
        self.failed[:] = np.where(chosen.values > 0, *failed)
        return values[0], values[1]

    def finite(self, tree: Tree, value: Any, *, fades: bool = False) -> Any:
        if not isinstance(value, Column):
            return super().finite(tree, value, fades=fades)
        self.failed |= ~np.isfinite(value.values)
        return value

    def positive(self, value: Any) -> bool:
        if not isinstance(value, Column):
            return super().positive(value)
        self.failed |= ~(value.values > 0)
        return True

    def fault(self, check: Callable[[Sequence[float]], T | None], values: Sequence[Any]) -> T | None:
        if not any(isinstance(one, Column) for one in values):
            return super().fault(check, values)
        rows = np.broadcast_arrays(self.failed, *map(numbers, values))[1:]
        self.failed |= np.array([check(member) is not None for member in zip(*(x.tolist() for x in rows))])
        return None


def numbers(operand: Column | float) -> Array | float:
    """The array or number for numpy."""
    return operand.values if isinstance(operand, Column) else operand

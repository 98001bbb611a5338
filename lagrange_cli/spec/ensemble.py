"""The numbers of an ensemble: those of every member's run, evaluated for all members at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from lagrange_cli.decimals import exact
from lagrange_cli.errors import LagrangeError, UsageError
from lagrange_cli.expression.columns import Column, ColumnAlgebra
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.values import Values, evaluate_run, resolve_values

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.spec.spec import Spec

    Array = NDArray[np.float64]

DIFFERENT = "its constraints depend on each other differently from those of the other members"

Number: TypeAlias = "float | Array"
"""The value of all members, or one number for each, of shape (members,)."""


@dataclass(frozen=True)
class EnsembleValues:
    """Parameters by name, and the initial state: ``q`` and ``v`` in the order of the coordinates.

    ``times`` are those of ``solve`` that depend on parameters. Members that are ``refused`` have no
    start: why not, by their numbers. ``otherwise`` has the constraints that depend on others in
    those members where these are not those of the first one. ``remainder`` is the rest of the numbers of the
    only member, if they are known to more digits than a double has.
    """

    members: int
    parameters: Mapping[str, Number]
    q: tuple[Number, ...]
    v: tuple[Number, ...]
    times: Mapping[str, Number] = field(default_factory=dict)
    refused: Mapping[int, str] = field(default_factory=dict)
    otherwise: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    remainder: Values | None = None

    @property
    def parts(self) -> tuple[EnsembleValues | Values, ...]:
        """The numbers, and the rest of them."""
        return (self,) if self.remainder is None else (self, self.remainder)

    @property
    def differing(self) -> dict[str, Array]:
        """The parameters that differ between members, (members,) each."""
        return {name: x for name, x in self.parameters.items() if isinstance(x, np.ndarray)}

    @property
    def common(self) -> dict[str, float]:
        """The parameters that all members share."""
        return {name: x for name, x in self.parameters.items() if not isinstance(x, np.ndarray)}

    def several(self, most: int = 32) -> Iterator[Values]:
        """The numbers of some members: of those with the smallest parameters beside their velocities, and of
        others, evenly spaced."""
        spaced = np.linspace(0, self.members - 1, min(most, self.members)).astype(int).tolist()
        smallest = np.argsort(self._smallness(), kind="stable")[:most].tolist()
        for i in dict.fromkeys([*smallest, *spaced]):
            yield self.of(i)

    def _smallness(self) -> Array:
        """The product of the two smallest parameters, by the square of the largest velocity (members,)."""
        ones = np.ones(self.members)
        sizes, speeds = (
            np.abs(np.array([ones, ones, *(np.broadcast_to(x, self.members) for x in given)]))
            for given in (self.parameters.values(), self.v)
        )
        sizes[sizes == 0.0] = 1.0
        with np.errstate(under="ignore"):
            products: Array = np.prod(np.sort(np.fmin(sizes, 1.0), axis=0)[:2], axis=0)
            found: Array = products / np.max(speeds, axis=0) ** 2
        return found

    def without(self, members: Iterable[int]) -> EnsembleValues:
        """The same with these ``members`` refused that are ``otherwise``."""
        gone = [*members]
        left = {member: names for member, names in self.otherwise.items() if member not in gone}
        return replace(self, refused={**self.refused, **dict.fromkeys(gone, DIFFERENT)}, otherwise=left)

    def of(self, member: int) -> Values:
        """The numbers of one."""
        parameters = {name: number_of(x, member) for name, x in self.parameters.items()}
        q, v = (tuple(number_of(x, member) for x in row) for row in (self.q, self.v))
        return Values(parameters, q, v)


def number_of(given: Number, member: int) -> float:
    """The number of a member."""
    return float(given[member]) if isinstance(given, np.ndarray) else given


def resolve_ensemble(
    spec: Spec, overrides: Mapping[str, str], columns: Mapping[str, Array]
) -> EnsembleValues:
    """The numbers of an ensemble; ``columns`` (members,) are what is given for each member, by the names the
    spec has, ``overrides`` those of ``--set``. To the last bit those that ``resolve_values`` gives for each.

    Raises:
        UsageError, SpecError: as ``resolve_values``; or for the first member that it would refuse.
    """
    members = len(next(iter(columns.values())))
    algebra = ColumnAlgebra(members)
    given = {name: algebra.column(values) for name, values in columns.items()}
    with np.errstate(all="ignore"):  # what is no number is found at the end
        parameters, q, v, times = evaluate_run(spec, overrides, algebra, given)
    if algebra.failed.any():
        refuse(spec, overrides, columns, algebra)
    return EnsembleValues(
        members,
        {name: plain(value) for name, value in parameters.items()},
        tuple(map(plain, q)),
        tuple(map(plain, v)),
        {name: plain(value) for name, value in times.items()},
    )


def refuse(
    spec: Spec, overrides: Mapping[str, str], columns: Mapping[str, Array], algebra: ColumnAlgebra
) -> None:
    """Raise what the first member that failed would raise by itself, and say which and how many they are."""
    member, count = int(algebra.failed.argmax()), int(algebra.failed.sum())
    try:
        member_values(spec, overrides, columns, member)
    except LagrangeError as error:
        more = f" (and {count - 1} more)" if count > 1 else ""
        raise UsageError(f"member {member}{more} cannot be run: {error}") from error


def member_values(
    spec: Spec, overrides: Mapping[str, str], columns: Mapping[str, Array], member: int
) -> Values:
    """The numbers of one member by itself, as ``--set`` would give them."""
    own = {name: exact(values[member]) for name, values in columns.items()}
    return resolve_values(spec, {**overrides, **own})


def plain(value: Any) -> Number:
    """A column's array, or a number as it is."""
    return value.values if isinstance(value, Column) else float(value)

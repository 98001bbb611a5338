"""``Recording``: which datasets a run writes, and how each is made from what compiled code computes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from functools import reduce
from operator import add
from typing import TYPE_CHECKING, Any, TypeVar

from lagrange_cli.native.state import StateLayout
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Series = Mapping[str, Array]
    """Rows by name, each of shape (c,): observed quantities, or quadratures."""


T = TypeVar("T", bound=Any)


class Making(Enum):
    """How a dataset is made from its ``sources``, names of observed quantities unless it says otherwise."""

    STATE = "state"  # the coordinates or velocities of the members
    SUM = "sum"
    STACK = "stack"  # the members of a family, the components of a vector
    BALANCE = "balance"  # of each, x - x(0) - its quadrature, where it has one
    INTEGRAL = "integral"  # the quadrature that goes by the dataset's path


class ObservedPlaces(dict[str, int]):
    """The places of observed quantities, by name, in the arrays that have them."""

    def __init__(self, names: Sequence[str]) -> None:
        super().__init__(zip(names, range(len(names))))
        self._found: dict[tuple[str, ...], Any] = {}

    def of(self, names: tuple[str, ...]) -> Any:
        """Those of several: a slice where they are side by side. Raises ``KeyError`` for an unknown name."""
        found = self._found.get(names)
        if found is None:
            listed = [self[name] for name in names]
            first = listed[0] if listed else 0
            beside = listed == list(range(first, first + len(listed)))
            found = self._found[names] = slice(first, first + len(listed)) if beside else listed
        return found


class Rows(Mapping[str, "Array"]):
    """Observed quantities (c,) by name; ``values`` (quantities, c) are those at the ``places``."""

    def __init__(self, places: ObservedPlaces, values: Array) -> None:
        self.places, self.array = places, values

    def __len__(self) -> int:
        return len(self.places)

    def __iter__(self) -> Iterator[str]:
        return iter(self.places)

    def __getitem__(self, name: str) -> Array:
        row: Array = self.array[self.places[name]]
        return row

    def block(self, names: tuple[str, ...]) -> Array:
        """Several of them (names, c)."""
        found: Array = self.array[self.places.of(names)]
        return found

    def until(self, count: int) -> Rows:
        """The first samples."""
        return Rows(self.places, self.array[:, :count])


@dataclass(frozen=True)
class Dataset:
    """One series of the output: its path, the shape of one sample, what it is, and how it is made.

    The shape is that of a family, whose indices are called ``axes``, then the number of ``components`` of a
    vector (0: a scalar). A family without some of its members has one axis, along which are those at these
    ``places``.
    """

    path: str
    shape: tuple[int, ...]
    long_name: str
    making: Making = Making.SUM
    sources: tuple[str, ...] = ()
    axes: tuple[str, ...] = ()
    components: int = 0
    places: tuple[tuple[int, ...], ...] = ()

    def quadrature(self, source: str) -> str:
        """The name of what a member's balance subtracts: the dataset's path with the member's index."""
        return self.path + "".join(source.partition("[")[1:])

    def make(self, observed: Series, integrals: Series, first: Mapping[str, float | Array]) -> Array:
        """Its samples (c, *shape); ``first`` holds the observed quantities at the start, one number each, or
        one for each sample where these are not all of one motion."""
        import numpy as np

        if self.making is Making.STACK and isinstance(observed, Rows) and self.shape:
            return np.ascontiguousarray(observed.block(self.sources).T).reshape(-1, *self.shape)
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is written as it is
            return self.shaped(self.parts(observed, integrals, first))

    def parts(
        self, observed: Mapping[str, T], integrals: Mapping[str, T], first: Mapping[str, Any]
    ) -> list[T]:
        """The same, number by number: rows (c,), or anything that can be added."""
        if self.making is Making.INTEGRAL:
            return [integrals[self.path]]
        rows = [observed[name] for name in self.sources]
        if self.making is Making.SUM:
            return [reduce(add, rows)]
        if self.making is Making.BALANCE:
            rows = [row - first[name] for row, name in zip(rows, self.sources)]
            names = map(self.quadrature, self.sources)
            rows = [row - integrals[name] if name in integrals else row for row, name in zip(rows, names)]
        return rows

    def shaped(self, rows: Sequence[Array]) -> Array:
        """Rows (c,) as samples (c, *shape)."""
        if not self.shape:
            return rows[0]
        import numpy as np

        return np.stack(list(rows), axis=1).reshape(-1, *self.shape)


NARROW, SWITCHES, CUTS, EDGES = "narrow", "switches", "cuts", "edges"
"""Hidden forces (see ``mechanics.defect``), changes of switches (see ``mechanics.guards``), and jumps with
atan2 (see ``mechanics.switching.cuts``)."""


INDICES = "ijklmn"


@dataclass(frozen=True)
class EventGroup:
    """The ``members`` of a family of events, or one event: their crossings are in one group of the file."""

    name: str
    shape: tuple[int, ...]
    members: tuple[str, ...]

    @property
    def indices(self) -> tuple[str, ...]:
        """The names of the members' indices."""
        return tuple(INDICES[: len(self.shape)])

    @property
    def path(self) -> str:
        """The path of the group."""
        return f"events/{self.name}"

    def places(self, numbers: NDArray[np.int64]) -> Sequence[NDArray[np.int64]]:
        """The indices of the members of these numbers, index by index."""
        import numpy as np

        if not self.shape:
            return ()
        if len(self.members) == math.prod(self.shape):
            return list(np.unravel_index(numbers, self.shape))
        names = (self.members[k][len(self.name) + 1 : -1] for k in numbers.tolist())  # of name[0,1]
        found = [tuple(map(int, one.split(","))) for one in names]
        return list(np.array(found, dtype=np.int64).reshape(-1, len(self.shape)).T)


@dataclass(frozen=True)
class Recording:
    """The datasets beyond ``t``, in the file's order: ``states``, those of q and then of v, and ``made``.

    ``conserved`` names the observed quantities that every motion keeps. ``undetected`` is what the method's
    steps may pass over, of ``NARROW``, ``SWITCHES``, ``CUTS`` and ``EDGES``. ``events`` are in the order of
    the model, and ``at_events`` are the datasets of q and v at their crossings. Outputs that are ``left_out``
    would take members of families written out, which are too many. ``undefined`` says which observables have
    no values, and why.
    """

    coordinates: tuple[str, ...]
    states: tuple[Dataset, ...]
    made: tuple[Dataset, ...]
    conserved: tuple[str, ...]
    undetected: tuple[str, ...] = ()
    events: tuple[EventGroup, ...] = ()
    at_events: tuple[Dataset, ...] = ()
    left_out: tuple[str, ...] = ()
    undefined: tuple[str, ...] = ()

    @property
    def datasets(self) -> tuple[Dataset, ...]:
        """Every dataset but ``t``, in the file's order."""
        return self.states + self.made

    def series(
        self, states: Array, integrals: Sequence[str], observed: Series, first: Mapping[str, float | Array]
    ) -> dict[str, Array]:
        """The samples (c, *shape) of every dataset, by path.

        ``states`` (rows, c) holds q, v and the ``integrals``; for ``first`` see ``Dataset.make``.
        """
        found = self.state_series(states)
        layout = StateLayout(len(self.coordinates), len(integrals))
        quadratures = dict(zip(integrals, states[layout.integrals]))
        for made in self.made:
            found[made.path] = made.make(observed, quadratures, first)
        return found

    def state_series(self, states: Array) -> dict[str, Array]:
        """The series of q and v."""
        return self._parts_of(states, self.states)

    def crossing_series(self, states: Array) -> dict[str, Array]:
        """q and v at crossings of events, from states (rows, k) there."""
        return self._parts_of(states, self.at_events)

    def _parts_of(self, states: Array, datasets: Sequence[Dataset]) -> dict[str, Array]:
        found = {}
        layout = StateLayout(len(self.coordinates))
        row = {"q": layout.q.start, "v": layout.v.start}
        for dataset in datasets:
            kind, count = dataset.path[0], math.prod(dataset.shape)
            found[dataset.path] = states[row[kind] : row[kind] + count].T.reshape(-1, *dataset.shape)
            row[kind] += count
        return found

    def as_data(self) -> dict[str, Any]:
        """All of it in terms of JSON."""
        return {
            "coordinates": self.coordinates,
            "states": list(map(_as_list, self.states)),
            "made": list(map(_as_list, self.made)),
            "conserved": self.conserved,
            "undetected": self.undetected,
            "events": [[one.name, one.shape, one.members] for one in self.events],
            "at_events": list(map(_as_list, self.at_events)),
            "left_out": self.left_out,
            "undefined": self.undefined,
        }

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Recording:
        """What ``as_data`` gave, after JSON."""
        states, made, there = (tuple(map(_dataset, data[kind])) for kind in ("states", "made", "at_events"))
        events = tuple(
            EventGroup(name, tuple(shape), tuple(members)) for name, shape, members in data["events"]
        )
        conserved, undetected = (tuple(data[one]) for one in ("conserved", "undetected"))
        missing = tuple(data["left_out"]), tuple(data["undefined"])
        return cls(tuple(data["coordinates"]), states, made, conserved, undetected, events, there, *missing)


def _as_list(one: Dataset) -> list[Any]:
    known = [one.path, one.shape, one.long_name, one.making.value, one.sources, one.axes, one.components]
    return [*known, one.places]


def _dataset(data: list[Any]) -> Dataset:
    path, shape, long_name, making, sources, axes, components, places = data
    listed = tuple(map(tuple, places))
    return Dataset(
        path, tuple(shape), long_name, Making(making), tuple(sources), tuple(axes), components, listed
    )

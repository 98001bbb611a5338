"""What chooses the members of an ensemble in Python: grids, distributions and tables as texts and arrays."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from lagrange_cli.api.given import count_of, is_whole
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.processors import processors
from lagrange_cli.run.ensembles.draws import KINDS, Draws

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


class Columns(Protocol):
    """A table of pandas, polars or astropy."""

    columns: Any

    def __getitem__(self, name: Any, /) -> Any: ...


Over: TypeAlias = "Mapping[str, str | ArrayLike]"
Random: TypeAlias = "Mapping[str, str | tuple[str, float, float]]"
Table: TypeAlias = "str | os.PathLike[str] | Mapping[str, ArrayLike] | Columns | NDArray[Any]"


def draws_of(
    over: Over | None, random: Random | None, table: Table | None, members: int | None, seed: int
) -> Draws:
    """The arguments; raises ``UsageError`` for values of a wrong type."""
    for name, given in (("over", over), ("random", random)):
        if given is not None and not isinstance(given, Mapping):
            raise UsageError(f"{name} must be a mapping from names to values, not {given!r:.60}")
    if not is_whole(seed) or seed < 0:
        raise UsageError(f"seed must be a whole number, 0 or greater, not {seed!r:.60}")
    found: Any = table
    columns = columns_of(found)
    if columns is not None:
        found = {str(name): numbers(f"table: {name}", found[name]) for name in columns}
        if not found:
            raise UsageError("table: it has no columns")
    elif isinstance(table, (str, os.PathLike)):
        found = os.fspath(table)
    elif table is not None:
        raise UsageError(f"table must be the name of a CSV file, or columns by name, not {table!r:.60}")
    return Draws(
        tuple((name, values_of(name, given)) for name, given in (over or {}).items()),
        tuple((name, distribution(name, given)) for name, given in (random or {}).items()),
        found,
        None if members is None else count_of("members", members),
        int(seed),
    )


def columns_of(table: Any) -> list[Any] | None:
    """The names of the columns of a mapping, of a table of pandas and the like, or of a structured array;
    None for anything else."""
    if isinstance(table, Mapping):
        return [*table]
    for names in (getattr(table, "columns", None), getattr(getattr(table, "dtype", None), "names", None)):
        if names is not None:
            return [*names]
    return None


def threads_of(jobs: int | None) -> int:
    """So many threads, or as many as there are processors."""
    return processors() if jobs is None else count_of("jobs", jobs)


def values_of(name: str, given: Any) -> Any:
    """A grid as a text, or values as an array."""
    return given if isinstance(given, str) else numbers(f"over: {name}", given)


def numbers(what: str, given: Any) -> Any:
    """Values (count,) as doubles. What numpy merely takes for numbers, such as None, is refused."""
    wrong = UsageError(f"{what} must be a sequence of numbers, not {given!r:.60}")
    try:
        listed = np.asarray(given)
        if listed.dtype.kind in "bSU" or any(one is None for one in listed.flat if listed.dtype.kind == "O"):
            raise wrong
        return np.atleast_1d(np.array(given, dtype=np.float64))
    except (TypeError, ValueError) as error:
        raise wrong from error


def distribution(name: str, given: Any) -> str:
    """A distribution as a text: ``normal(0,0.1)`` for ``("normal", 0, 0.1)``."""
    if isinstance(given, str):
        return given
    if isinstance(given, Sequence) and len(given) == 3 and given[0] in KINDS:
        kind, a, b = given
        return f"{kind}({float(a)!r},{float(b)!r})"
    known = ", ".join(kind + arguments for kind, arguments in KINDS.items())
    raise UsageError(f"random: {name} must be a distribution, one of {known}, not {given!r:.60}")

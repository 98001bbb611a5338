"""The arguments of a Python program in place of options: numbers and texts, as texts by name."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from decimal import Decimal
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, TypeAlias

from lagrange_cli.decimals import decimal, exact
from lagrange_cli.errors import UsageError
from lagrange_cli.expression.vocabulary import family_name, velocity_name
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.run.request import Request
from lagrange_cli.run.source import count_of as plural
from lagrange_cli.spec.content import groups_of
from lagrange_cli.spec.spec import SolveDefaults, Spec
from lagrange_cli.spec.whole import WrittenFamily

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.run.certify import Demand

Value: TypeAlias = "float | str"
"""A number, or an expression in parameters."""
Values: TypeAlias = "Mapping[str, float | str | Sequence[Any] | NDArray[Any]]"
"""Values by name. A sequence, or an array, has those of a family."""

DIGITS = 6.0
"""Digits of a certificate by default."""


def text_of(name: str, value: Any) -> str:
    """A number as it is written in full, or an expression as it is; ``name`` says what it is for."""
    if getattr(value, "ndim", None) == 0:
        value = value.item()  # numpy's
    if isinstance(value, str) and value.strip():
        return value.strip()
    if isinstance(value, Integral) and not isinstance(value, bool):
        return str(int(value))
    if isinstance(value, Real) and not isinstance(value, bool):
        return exact(value)
    if isinstance(value, Decimal) and value.is_finite():
        return str(value)
    if type(value).__module__.partition(".")[0] == "sympy" and getattr(value, "is_real", False):
        return exact(value)
    raise UsageError(f"{name} must be a number or an expression, not {value!r:.60}")


def texts_of(what: str, values: Values | None) -> dict[str, str]:
    """Texts by name; those of a family by the names of its members. ``what`` is the argument's name."""
    found: dict[str, str] = {}
    for name, text in pairs(what, values or {}):
        if name in found:
            raise UsageError(f"{what}: {name} is given twice, as {found[name]} and as {text}: leave one out")
        found[name] = text
    return found


def pairs(what: str, values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Each name with its text."""
    if not isinstance(values, Mapping):
        raise UsageError(f"{what} must be a mapping from names to values, not {values!r:.60}")
    for name, value in values.items():
        if not isinstance(name, str):
            raise UsageError(f"{what} must be a mapping from names to values, and {name!r:.60} is not a name")
        for indices, one in members((), value):
            member = f"{name}[{','.join(map(str, indices))}]" if indices else name
            yield member, text_of(f"{what}: {member}", one)


def sizes_given(size: Mapping[str, int | str] | None) -> dict[str, str]:
    """Sizes by name, as texts: numbers, not sequences of them."""
    if isinstance(size, Mapping):
        size = {name: text_of(f"size: {name}", one) for name, one in size.items()}
    return texts_of("size", size)


def check_lengths(spec: Spec, values: Values | None) -> None:
    """Raise ``UsageError`` where a sequence has not as many values as its family has members."""
    coordinates = sizes_of(spec.coordinates)
    velocities = Counter({velocity_name(name): size for name, size in coordinates.items()})
    sizes = coordinates + velocities + sizes_of(spec.parameters)
    for name, value in (values or {}).items():
        listed = [*members((), value)]
        one = len(listed) == 1 and not listed[0][0]
        if not one and name in sizes and len(listed) != sizes[name]:
            given = "1 value is" if len(listed) == 1 else f"{len(listed)} values are"
            raise UsageError(f"set: {name} has {plural(sizes[name], 'member')}, but {given} given")


def sizes_of(section: Sequence[Any]) -> Counter[str]:
    """The number of members by name, 1 for what is no family."""
    sizes = Counter[str]()
    for one in groups_of(section):
        sizes[family_name(one.name)] += len(one) if isinstance(one, WrittenFamily) else 1
    return sizes


def members(indices: tuple[int, ...], value: Any) -> Iterator[tuple[tuple[int, ...], Any]]:
    """The numbers of nested sequences, each with its indices."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, Sequence) and not isinstance(value, (str, bytes, bytearray)):
        for i, one in enumerate(value):
            yield from members((*indices, i), one)
    else:
        yield indices, value


def names_of(outputs: str | Iterable[str] | None) -> tuple[str, ...] | None:
    """``"q,v"`` or ``["q", "v"]`` as a tuple of names."""
    if outputs is None:
        return None
    listed = outputs.split(",") if isinstance(outputs, str) else outputs
    found = [str(name).strip() for name in listed] if isinstance(listed, Iterable) else []
    found = [name for name in found if name]
    if not found:
        raise UsageError("outputs must be a list of names, as in outputs=['q', 'h']")
    return tuple(found)


def request_of(
    *,
    set: Values | None,
    size: Mapping[str, int | str] | None,
    times: Mapping[str, Value | None],
    samples: int | None = None,
    tolerance: float | None = None,
    method: str | None = None,
    outputs: str | Iterable[str] | None = None,
    precision: str = DOUBLE,
    portable: bool = False,
    proven: bool = False,
    project_initial: bool = False,
    cache: bool = True,
    threads: int | None = None,
) -> Request:
    """The request for a run; raises ``UsageError`` for arguments of a wrong type."""
    if samples is not None and not is_whole(samples):
        raise UsageError(f"samples must be a whole number, not {samples!r:.60}")
    options = SolveDefaults(
        samples=None if samples is None else int(samples),
        tolerance=None if tolerance is None else number_of("tolerance", tolerance),
        method=None if method is None else str(method),
        outputs=names_of(outputs),
    )
    return Request(
        options,
        {name: text_of(name, value) for name, value in times.items() if value is not None},
        texts_of("set", set),
        sizes_given(size),
        cache=flag_of("cache", cache),
        precision=precision,
        portable=flag_of("portable", portable),
        proven=flag_of("proven", proven),
        projected=flag_of("project_initial", project_initial),
        threads=threads,
    )


def flag_of(name: str, given: Any) -> bool:
    """Yes or no; raises ``UsageError`` for anything else, as a text such as ``"no"`` would be yes."""
    given = given.item() if getattr(given, "ndim", None) == 0 else given  # numpy's
    if not isinstance(given, bool):
        raise UsageError(f"{name} must be True or False, not {given!r:.60}")
    return given


def is_whole(given: object) -> bool:
    """Whether it is an integer, of Python or of numpy."""
    return isinstance(given, Integral) and not isinstance(given, bool)


def count_of(name: str, given: int) -> int:
    """How many there are of something, 1 or more; raises ``UsageError`` for anything else."""
    if not is_whole(given) or given < 1:
        raise UsageError(f"{name} must be a whole number greater than 0, not {given!r:.60}")
    return int(given)


def number_of(name: str, given: float) -> float:
    """A number; raises ``UsageError`` for anything else."""
    if isinstance(given, bool) or not isinstance(given, Real):
        raise UsageError(f"{name} must be a number, not {given!r:.60}")
    return float(given)


def finite_of(name: str, given: float) -> float:
    """A finite number; raises ``UsageError`` for anything else."""
    found = number_of(name, given)
    if not math.isfinite(found):
        raise UsageError(f"{name} must be a finite number, not {decimal(found)}")
    return found


def demand_of(certify: bool, digits: float | None, target_error: float | None) -> Demand | None:
    """The demand for a certificate; None where none is requested."""
    if not flag_of("certify", certify) and digits is None and target_error is None:
        return None
    from lagrange_cli.run.certify import Demand

    wanted = DIGITS if digits is None else number_of("digits", digits)
    if not 1 <= wanted <= 15:
        raise UsageError(f"digits must be a number from 1 to 15, not {decimal(wanted)}")
    error = None if target_error is None else number_of("target_error", target_error)
    if error is not None and not error > 0:
        raise UsageError(f"the target error must be a positive number, not {decimal(error)}")
    return Demand(wanted, error)

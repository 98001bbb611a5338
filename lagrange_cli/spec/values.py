"""The numbers of a run: parameters, masses and the initial state, with ``--set`` applied."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.evaluation import constants_of
from lagrange_cli.spec.initial import evaluate_run
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.settable import settable
from lagrange_cli.spec.spec import Spec


@dataclass(frozen=True)
class Values:
    """Parameters by name, and the initial state: ``q`` and ``v`` in the order of the coordinates.

    Values that are not given are 0 until they are found from constraints (``left_open`` has their names).
    ``times`` are those of ``solve`` that depend on parameters. ``remainder`` is the rest of numbers that are
    known to more digits than a double has, and None otherwise.
    """

    parameters: Mapping[str, float]
    q: tuple[float, ...]
    v: tuple[float, ...]
    remainder: Values | None = None
    times: Mapping[str, float] = field(default_factory=dict)


def resolve_values(
    spec: Spec, overrides: Mapping[str, str] | None = None, problems: Problems | None = None
) -> Values:
    """The numbers ``spec`` is run with; ``overrides`` are those of ``--set``, name to expression.

    With ``problems`` those that the numbers have are added to those that the file has already.

    Raises:
        UsageError: an override of an unknown name, or one that cannot be evaluated.
        SpecError: everything in the file that has no finite value, a mass that is not positive, or an
            initial value that is missing; not with ``problems``.
    """
    parameters, q, v, times = evaluate_run(spec, overrides or {}, NumberAlgebra(), {}, problems)
    return Values(parameters, q, v, times=times)


def left_open(spec: Spec, given: Iterable[str]) -> frozenset[str]:
    """The coordinates and velocities whose initial values neither the file has nor those that are ``given``
    by name."""
    named = {settable(spec, name, f"--set {name}") for name in given}
    found = {one.name for one in spec.coordinates if one.initial is None}
    found |= {velocity_name(one.name) for one in spec.coordinates if one.velocity is None}
    return frozenset(found - named)


def resolve_long_values(
    spec: Spec, overrides: Mapping[str, str] | None = None, problems: Problems | None = None
) -> Values:
    """The same in double-double: decimals as they are written, functions and pi to as many digits."""
    from lagrange_cli.expression.exact import LongNumberAlgebra, in_two_parts

    parameters, q, v, times = evaluate_run(spec, overrides or {}, LongNumberAlgebra(), {}, problems)

    def part(i: int, remainder: Values | None = None) -> Values:
        named = {name: in_two_parts(value)[i] for name, value in parameters.items()}
        start, speed = (tuple(in_two_parts(x)[i] for x in row) for row in (q, v))
        return Values(named, start, speed, remainder, {name: float(time) for name, time in times.items()})

    return part(0, part(1))


def rounding_of(
    spec: Spec, values: Values, start: float, overrides: Mapping[str, str] | None = None
) -> Values:
    """By how much the numbers as they are written, in the file and in ``overrides``, exceed ``values``.

    So does the time of the ``start``: it is written as an expression in parameters, or as a decimal.
    """
    from lagrange_cli.expression.exact import LongNumberAlgebra, less

    algebra = LongNumberAlgebra()
    parameters, q, v, times = evaluate_run(spec, overrides or {}, algebra, {})
    begins = times.get("start")
    if begins is None or float(begins) != start:
        begins = algebra.number(repr(start))
    return Values(
        {name: less(value, values.parameters[name]) for name, value in parameters.items()},
        tuple(map(less, q, values.q)),
        tuple(map(less, v, values.v)),
        times={"start": less(begins, start)},
    )


def resolve_portable_values(
    spec: Spec, overrides: Mapping[str, str] | None = None, problems: Problems | None = None
) -> Values:
    """The doubles nearest to those: the same on every machine, whatever its C library."""
    return replace(resolve_long_values(spec, overrides, problems), remainder=None)


def resolve_parameters(
    spec: Spec, overrides: Mapping[str, str] | None = None, problems: Problems | None = None
) -> dict[str, float]:
    """The parameters alone, in the file's terms; masses are checked too, the initial state is not.

    Raises:
        UsageError, SpecError: as ``resolve_values``.
    """
    evaluation = constants_of(spec, overrides or {}, NumberAlgebra(), {}, problems)
    if problems is None:
        evaluation.problems.stop_if_any()
    return evaluation.values

"""Initial states at which an energy has no value, as a logarithm of a negative number.

The force of an energy log(u) contains u'/u, which has values where the energy has none. So such a motion is
refused at its start. (Other functions have no derivatives where they have no values.)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.vocabulary import TIME, velocity_name
from lagrange_cli.records import replace
from lagrange_cli.spec.content import written
from lagrange_cli.spec.spec import distinct

if TYPE_CHECKING:
    from lagrange_cli.expression.syntax import Tree
    from lagrange_cli.spec.ensemble import EnsembleValues
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values

PARTIAL = ("log",)
"""Functions that have no value where their derivative has one."""


def check_domain(spec: Spec, values: Values, t: float) -> None:
    """Raise ``SpecError`` if an energy has no value where the motion begins."""
    if may_end(spec) and without_value(spec, values.parameters, (*values.q, *values.v), t, 1):
        raise refusal(spec, values, t)


def within_domain(spec: Spec, values: EnsembleValues, t: float) -> EnsembleValues:
    """The members of an ensemble, of which those are refused that begin where an energy has no value.

    Raises ``SpecError`` where none is left.
    """
    if not may_end(spec):
        return values
    lost = without_value(spec, values.parameters, (*values.q, *values.v), t, values.members)
    errors = {member: refusal(spec, values.of(member), t) for member in lost if member not in values.refused}
    refused = {**values.refused, **{member: one.problems[0].message for member, one in errors.items()}}
    if errors and len(refused) == values.members:
        raise errors[min(errors)]
    return replace(values, refused=refused)


def may_end(spec: Spec) -> bool:
    """Whether an energy is written with such a function."""
    from lagrange_cli.expression.syntax import calls

    energies = [*written(spec.potential), *([] if spec.lagrangian is None else [spec.lagrangian])]
    return any(calls(one.tree, PARTIAL) for one in distinct((*energies, *written(spec.definitions))))


def without_value(
    spec: Spec, parameters: Mapping[str, Any], state: Sequence[Any], t: float, members: int
) -> list[int]:
    """The members whose energy is no number; what is not an array is the same for all."""
    import numpy as np

    from lagrange_cli.expression.arrays import evaluate
    from lagrange_cli.run.jumps import symbolic

    model = symbolic(spec)
    names = [one.name for one in spec.coordinates]
    known = dict(zip([*names, *map(velocity_name, names)], state))
    energy = model.potential if model.lagrangian is None else model.lagrangian
    (found,) = evaluate([energy], {**parameters, **known, TIME: t})
    lost: list[int] = np.flatnonzero(np.broadcast_to(np.isnan(found), members)).tolist()
    return lost


def refusal(spec: Spec, values: Values, t: float) -> SpecError:
    """The message for such a state, at the first place that shows it."""
    from lagrange_cli.expression.syntax import Call
    from lagrange_cli.run.causes import arguments, text
    from lagrange_cli.spec.source import Source
    from lagrange_cli.symbolic.direct import Dual

    numbers = {name: Dual((x, 0.0, 0.0)) for name, x in values.parameters.items()}
    numbers[TIME] = Dual((t, 0.0, 0.0))
    for one, q, v in zip(spec.coordinates, values.q, values.v):
        numbers |= {one.name: Dual((q, 0.0, 0.0)), velocity_name(one.name): Dual((v, 0.0, 0.0))}
    source, hint = Source(spec.filename, spec.text), "start from another state"
    try:
        found = [
            (conditional(expression.tree, border.whole), expression, border, float(built.value[0]))
            for expression, border, _, built in arguments(spec, numbers)
            if isinstance(border.whole, Call) and border.whole.function in PARTIAL and built.value[0] < 0.0
        ]
    except SpecError as error:
        return error
    except (ValueError, ArithmeticError):  # a position or a definition has no value either
        found = []
    if found:
        _, expression, border, value = min(found, key=lambda one: one[0])
        argument = text(expression, border.argument)
        whole = text(expression, border.whole)
        message = f"{whole} has no value where the motion begins: {argument} is {value:g}"
        return source.error(expression.at(border.whole.span), message, hint)
    energy = [spec.lagrangian] if spec.lagrangian is not None else [*spec.potential.values()]
    place = energy[0].at(energy[0].tree.span)
    return source.error(place, "the energy has no value where the motion begins", hint)


def conditional(tree: Tree, inner: Tree) -> bool:
    """Whether a part of an expression may not count, as it stands in a ``where``."""
    from lagrange_cli.expression.syntax import Call, children

    pending = [tree]
    while pending:
        one = pending.pop()
        within = one.span.start <= inner.span.start and inner.span.stop <= one.span.stop
        if within and isinstance(one, Call) and one.function == "where":
            return True
        pending += children(one) if within else ()
    return False

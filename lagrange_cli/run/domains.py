"""Initial states at which an energy, a force or a position has no value, as 1/x where x is 0.

The expressions of the file are evaluated there. Where one has no value, neither has what it is part of,
unless it cancels: all that is evaluated by the graph, too. (The force of an energy log(u) contains u'/u,
which has values where the energy has none. So of logarithms, the energy alone counts.)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import SpecError
from lagrange_cli.expression.vocabulary import TIME, velocity_name
from lagrange_cli.records import replace
from lagrange_cli.spec.content import written
from lagrange_cli.spec.spec import distinct

if TYPE_CHECKING:
    from lagrange_cli.expression.borders import Border
    from lagrange_cli.expression.syntax import Tree
    from lagrange_cli.spec.ensemble import EnsembleValues
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values

PARTIAL = ("log",)
"""Functions that have no value where their derivative has one."""
FEW = 60
"""Coordinates up to which all expressions are evaluated: sums over pairs of more take time. The energy of
more is computed by families."""


def check_domain(spec: Spec, values: Values, t: float) -> None:
    """Raise ``SpecError`` if an energy, a force or a position is certain to have no value where the motion
    begins, or a force no series."""
    if may_end(spec) and without_value(spec, values.parameters, (*values.q, *values.v), t, 1):
        raise refusal(spec, values, t)
    expressions = chain(spec.in_equations, written(spec.definitions))
    if len(spec.coordinates) > FEW or not any(may_lack_value(one.tree) for one in expressions):
        return
    known = known_at(spec, values, t)
    lost = written_without_value(spec, known)
    if lost is not None and not has_values(spec, known):
        raise refusal(spec, values, t, lost)
    if lost is None:
        from lagrange_cli.run.roots import without_series

        lost = without_series(spec, known)
        if lost is not None:
            raise lost


def may_lack_value(tree: Tree) -> bool:
    """Whether an expression contains a quotient, a power or a function that has not a value everywhere."""
    from lagrange_cli.expression.syntax import Binary, Call, Number, parts

    for one in parts(tree):
        if isinstance(one, Binary) and one.operator in ("/", "**") and not isinstance(one.right, Number):
            return True
        if isinstance(one, Binary) and one.operator == "**" and not one.right.text.isdecimal():  # type: ignore[union-attr]
            return True
        if isinstance(one, Call) and one.function in ("sqrt", "norm", "log", "asin", "acos"):
            return True
    return False


def known_at(spec: Spec, values: Values, t: float) -> dict[str, float]:
    """The values of all symbols but multipliers."""
    names = [one.name for one in spec.coordinates]
    state = zip([*names, *map(velocity_name, names)], (*values.q, *values.v))
    return {**values.parameters, **dict(state), TIME: t}


def written_without_value(spec: Spec, known: Mapping[str, float]) -> SpecError | None:
    """What is said of the first expression of the equations that has no value; None where all have one, if
    perhaps one that is too large for a double: the graph may be without it."""
    from lagrange_cli.expression.numbers import NumberAlgebra
    from lagrange_cli.model.scope import Scope

    try:
        scope = Scope(spec, NumberAlgebra(known))
    except SpecError as error:
        return None if overflows(error) else error
    except (LookupError, NotImplementedError):  # a multiplier, or a velocity
        return None
    for one in spec.in_equations:
        try:
            scope.build(one)
        except SpecError as error:
            if not overflows(error):
                return error
        except (LookupError, NotImplementedError):
            pass
    return None


def overflows(error: BaseException | None) -> bool:
    """Whether it was caused by a number that is too large."""
    while error is not None and not isinstance(error, OverflowError):
        error = error.__cause__
    return error is not None


def has_values(spec: Spec, known: Mapping[str, float]) -> bool:
    """Whether everything that the equations are made of has a value, or may have one: on a switch, it is that
    of one side; dry friction is as large as is needed where it holds the motion."""
    import numpy as np

    from lagrange_cli.expression.arrays import evaluate
    from lagrange_cli.expression.node import Kind, reachable
    from lagrange_cli.mechanics.guards.vectors import at_rest
    from lagrange_cli.mechanics.variables import graph_of
    from lagrange_cli.run.jumps import symbolic

    model = symbolic(spec)
    nodes = [model.potential if model.lagrangian is None else model.lagrangian, model.dissipation]
    nodes += model.generalized_forces
    for particle in model.particles:
        nodes += [particle.mass, *particle.position, *particle.force]
    for node in nodes:
        parts = reachable([node])
        if any(one.kind is Kind.SYMBOL and one.data not in known for one in parts):
            continue
        if all(np.isfinite(value) for value in evaluate([node], known)):
            continue
        if np.isfinite(evaluate([at_rest(graph_of(model), node, model.v)], known)[0]):
            continue
        sides = [one.arguments[0] for one in parts if one.kind is Kind.SWITCH]
        if not any(x == 0.0 for x in evaluate(sides, known)):
            return False
    return True


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

    if members == 1 and len(spec.coordinates) > FEW:
        from lagrange_cli.families.energies import energy

        one = energy(spec, parameters, np.array(state, dtype=np.float64), t)
        if one is not None:
            return [0] if np.isnan(one) else []
    model = symbolic(spec)
    names = [one.name for one in spec.coordinates]
    known = dict(zip([*names, *map(velocity_name, names)], state))
    whole = model.potential if model.lagrangian is None else model.lagrangian
    (found,) = evaluate([whole], {**parameters, **known, TIME: t})
    lost: list[int] = np.flatnonzero(np.broadcast_to(np.isnan(found), members)).tolist()
    return lost


def refusal(spec: Spec, values: Values, t: float, lost: SpecError | None = None) -> SpecError:
    """The message for such a state, at the first place that shows it; what is ``lost``, or that of the
    energy, where none is found."""
    from lagrange_cli.run.causes import arguments, text
    from lagrange_cli.spec.source import Source
    from lagrange_cli.symbolic.direct import Dual

    known = known_at(spec, values, t)
    numbers = {name: Dual((float(x), 0.0, 0.0)) for name, x in known.items()}
    source, hint = Source(spec.filename, spec.text), "start from another state"
    try:
        found = [
            (conditional(expression.tree, border.whole), expression, border, float(built.value[0]))
            for expression, border, _, built in arguments(spec, numbers)
            if beyond(border, float(built.value[0]), known) and (lost is not None or of_logarithm(border))
        ]
    except SpecError as error:
        return lost or error
    except (ValueError, ArithmeticError):  # a position or a definition has no value either
        found = []
    if found:
        _, expression, border, value = min(found, key=lambda one: one[0])
        argument = text(expression, border.argument)
        whole = text(expression, border.whole)
        message = f"{whole} has no value where the motion begins: {argument} is {decimal(value)}"
        return source.error(expression.at(border.whole.span), message, hint)
    if lost is not None:
        return lost
    energy = [spec.lagrangian] if spec.lagrangian is not None else [*spec.potential.values()]
    place = energy[0].at(energy[0].tree.span)
    return source.error(place, "the energy has no value where the motion begins", hint)


def of_logarithm(border: Border) -> bool:
    """Whether it is the end of such a function."""
    from lagrange_cli.expression.syntax import Call

    return isinstance(border.whole, Call) and border.whole.function in PARTIAL


def beyond(border: Border, value: float, known: Mapping[str, float]) -> bool:
    """Whether a function, a quotient or a power has no value where its argument has this one."""
    from lagrange_cli.expression.numbers import evaluate
    from lagrange_cli.expression.syntax import Binary, Call, ExpressionError

    whole = border.whole
    if isinstance(whole, Binary) and whole.operator == "/":
        return value == 0.0
    if isinstance(whole, Binary):
        try:
            exponent = evaluate(whole.right, known.__getitem__)
        except (ExpressionError, LookupError):
            return False
        return exponent % 1.0 != 0.0 if value < 0.0 else value == 0.0 > exponent
    if not isinstance(whole, Call) or whole is border.argument:  # a length
        return False
    if len(border.ends) > 1:
        return abs(value) > 1.0
    return value < 0.0 or (value == 0.0 and whole.function == "log")


def conditional(tree: Tree, inner: Tree) -> bool:
    """Whether a part of an expression may not count, as it stands in a ``where``."""
    from lagrange_cli.expression.syntax import Call, parts

    return any(
        isinstance(one, Call)
        and one.function == "where"
        and one.span.start <= inner.span.start
        and inner.span.stop <= one.span.stop
        for one in parts(tree)
    )

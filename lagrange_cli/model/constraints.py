"""The constraints of a system file, over any algebra."""

from __future__ import annotations

from lagrange_cli.expression.algebra import E
from lagrange_cli.model.model import Constraint
from lagrange_cli.model.scope import Scope, multiplier_name
from lagrange_cli.spec.kinds import NO_COORDINATE, NO_VELOCITY
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.spec import Expression


def built_constraints(scope: Scope[E]) -> tuple[Constraint[E], ...]:
    """The holonomic constraints, then the others.

    Raises:
        SpecError: where a holonomic constraint contains no coordinate, and another one no velocity.
    """
    state = frozenset(scope.q), frozenset(scope.v)
    problems = Problems(Source(scope.spec.filename, scope.spec.text))
    holonomic = [
        _built(scope, *one, state, problems, holonomic=True) for one in scope.spec.constraints.items()
    ]
    others = [
        _built(scope, *one, state, problems, holonomic=False) for one in scope.spec.nonholonomic.items()
    ]
    problems.stop_if_any()
    return (*holonomic, *others)


def _built(
    scope: Scope[E],
    name: str,
    written: Expression,
    state: tuple[frozenset[E], frozenset[E]],
    problems: Problems,
    *,
    holonomic: bool,
) -> Constraint[E]:
    """One of them; ``state`` has the symbols of coordinates, and of velocities. Mistakes are reported."""
    expression = scope.scalar(written)
    symbols = {*scope.algebra.symbols(expression)}
    moves, turns = (not symbols.isdisjoint(some) for some in state)
    if not (moves if holonomic else turns):
        message, hint = NO_COORDINATE if holonomic else NO_VELOCITY
        problems.add_once(written.place, message.format(name), hint)
    multiplier, of = scope.algebra.symbol(multiplier_name(name)), scope.spec.massless.get(name, "")
    return Constraint(name, expression, multiplier, holonomic, of)


def without_force(constrained: bool, idle: bool = False) -> str:
    """Why a momentum is kept, as far as forces go; ``constrained`` where the system has constraints, whose
    forces are ``idle`` where they might act on it."""
    if idle:
        return "the forces of constraint along it cancel, or are 0"
    if constrained:
        return "neither a generalized force nor a force of constraint acts on it"
    return "no generalized force acts on it"


def without_work(applied: bool, constrained: bool, idle: bool = False) -> str:
    """The same of h, as the end of a sentence; ``applied`` where there are generalized forces."""
    if idle:
        return ", and the forces of constraint, which might do work, do none along any motion"
    if applied and constrained:
        return ", and neither the generalized forces nor the forces of constraint do work"
    if applied or constrained:
        return f", and the {'generalized forces' if applied else 'forces of constraint'} do no work"
    return ""

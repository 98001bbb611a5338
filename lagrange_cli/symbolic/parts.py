"""What can be printed of a system whose equations of motion are too long to print."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial

import sympy

from lagrange_cli.model.model import Constraint, Model
from lagrange_cli.symbolic.constraints import TOO_LONG, multiplier_symbols, with_symbols
from lagrange_cli.symbolic.derive import kinetic_energy, textbook_order
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.layouts import lines_of
from lagrange_cli.symbolic.notations import Text, Unicode
from lagrange_cli.symbolic.order import Role
from lagrange_cli.symbolic.render import Notation
from lagrange_cli.symbolic.slopes import slope
from lagrange_cli.symbolic.statements import KINDS, Section, Statement, Writer
from lagrange_cli.symbolic.textbook import neat
from lagrange_cli.symbolic.work import attempt, size_of

LONGEST = 1000
"""Terms and factors of the longest expression that is printed beside equations that are too long."""
STEPS_A_PART = 500_000
"""The most work for one of them."""
OMITTED = "..."
WITHOUT = f"{TOO_LONG}; 'check' and 'solve' do not need them printed"
NOTATIONS: dict[str, Callable[[], Notation]] = {"text": Text, "unicode": Unicode}


def parts_as_written(
    model: Model[sympy.Expr],
    noted: Mapping[str, sympy.Expr],
    free: str,
    kept: Iterable[tuple[str, str]],
    format_: str,
) -> str:
    """Energies, constraints and momenta of a model as far as they are short, in one of the ``NOTATIONS``.

    Those that are ``noted`` by name are known. ``free`` are its degrees of freedom in words, ``kept`` has
    what is conserved, as `h = T + U`, and why.
    """
    symbols = multiplier_symbols([each.name for each in model.constraints], "lambda", [*model.q, *model.v])
    writer = Writer(NOTATIONS[format_](), textbook_order(model, (), symbols))
    said = tuple(Statement("", "", writer.prose(f"`{what}`: {because}")) for what, because in kept)
    nothing = Statement("", "", "nothing that follows from a symmetry of the Lagrangian")
    content = [
        *sections(with_symbols(model, symbols), noted, writer),
        Section("Equations of motion", (Statement("", "", WITHOUT),), True),
        Section("Conserved", said or (nothing,), True),
    ]
    return lines_of(model.name, free, content)


def sections(model: Model[sympy.Expr], noted: Mapping[str, sympy.Expr], writer: Writer) -> list[Section]:
    """What stands above the equations of motion."""
    order = writer.order
    if model.lagrangian is None:
        kinetic = kinetic_energy(model)
        lagrangian = kinetic - model.potential
        parts: dict[str, Callable[[], sympy.Expr]] = {
            "T": partial(tidy, kinetic, order),
            "U": partial(neat, model.potential, order, Role.COORDINATE),
            "L": partial(neat, lagrangian, order, Role.COORDINATE),
        }
    else:
        lagrangian = model.lagrangian
        parts = {"L": partial(neat, lagrangian, order, Role.VELOCITY)}

    def momentum(velocity: sympy.Expr) -> sympy.Expr:
        return tidy(slope(lagrangian, velocity), order)

    def found(parts: Mapping[str, Callable[[], sympy.Expr]]) -> dict[str, sympy.Expr | None]:
        return {
            name: short(partial(noted.__getitem__, name) if name in noted else one)
            for name, one in parts.items()
        }

    energies = found(parts)
    momenta = found(
        {
            f"p_{name}": partial(momentum, velocity)
            for name, velocity in zip(model.coordinates, model.v, strict=True)
        }
    )
    constraints = tuple(
        bound(each, short(partial(neat, each.expression, order, Role.VELOCITY)), writer)
        for each in model.constraints
    )
    return [
        Section("Lagrangian", listed(energies, writer)),
        *([Section("Constraints", constraints)] if constraints else []),
        Section("Momenta", listed(momenta, writer)),
    ]


def bound(each: Constraint[sympy.Expr], one: sympy.Expr | None, writer: Writer) -> Statement:
    """A constraint, or that it is too long."""
    remark = writer.notation.words(each.name + KINDS[each.holonomic])
    if one is None:
        return Statement(OMITTED, "0", f"{remark}, {TOO_LONG}")
    return Statement(writer.text(one), "0", remark)


def short(derived: Callable[[], sympy.Expr]) -> sympy.Expr | None:
    """An expression, None where it is too long or takes too much work."""
    found = attempt(STEPS_A_PART, derived)
    return None if found is None or size_of(found) > LONGEST else found


def listed(values: dict[str, sympy.Expr | None], writer: Writer) -> tuple[Statement, ...]:
    """``name = expression`` for each; that it is too long where it is."""
    return tuple(
        Statement(writer.names(name), OMITTED, TOO_LONG) if one is None else writer.statement(name, one)
        for name, one in values.items()
    )

"""The forms of the equations besides the usual one, as sections of statements."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.hamilton import REMARK, hamilton_form, vakonomic_form
from lagrange_cli.symbolic.reactions import Reaction
from lagrange_cli.symbolic.statements import (
    Section,
    Statement,
    Writer,
    constraint_sections,
    equation_statements,
    multiplier_sections,
    named_section,
)


def hamilton_sections(equations: Equations, momenta: Writer) -> list[Section]:
    """H and the canonical equations."""
    form = hamilton_form(equations)
    writer = Writer(momenta.notation, form.order)
    rates = [velocity_name(str(symbol)) for symbol in form.p]
    canonical = named_section("", rates, form.rates, writer).statements
    if not form.solved:
        title = "Momenta, which determine the velocities"
        return [
            named_section(title, form.p, equations.momenta, momenta),
            Section("Hamiltonian, with these velocities", (writer.statement("H", form.H),)),
            *constraint_sections(equations, writer, form.constraints),
            Section("Canonical equations, with these velocities", canonical),
        ]
    velocities = named_section("", equations.v, form.velocities, writer).statements
    return [
        Section("Hamiltonian", (writer.statement("H", form.H),)),
        *constraint_sections(equations, writer, form.constraints),
        Section("Canonical equations", (*velocities, *canonical)),
        named_section("Momenta", form.p, equations.momenta, momenta),
    ]


def matrix_sections(equations: Equations, writer: Writer) -> list[Section]:
    """M a = f, or M a = f + A^T lambda and A a = b, where there are constraints."""
    notation, constraints = writer.notation, equations.constraints

    def column(symbols: Iterable[sympy.Expr]) -> str:
        return notation.matrix([[writer.text(one)] for one in symbols])

    def matrix(rows: Sequence[Sequence[sympy.Expr]]) -> str:
        return notation.matrix([[writer.text(entry) for entry in row] for row in rows])

    system, right = [Statement("M a", "f"), Statement("a", column(equations.a))], []
    pushed = any(each.pushes for each in constraints)
    if constraints:
        letter, factor = notation.symbol("lambda"), notation.transposed("A")
        if pushed:
            factor = notation.parentheses(f"{factor}{notation.plus}B")
        system = [
            Statement("M a", f"f{notation.plus}{factor} {letter}"),
            Statement("A a", "b"),
            system[1],
            Statement(letter, column(each.multiplier for each in constraints)),
        ]
        slopes = Statement("A", matrix([each.slopes for each in constraints]))
        if pushed:
            rows = [[each.pushes[k] for each in constraints] for k in range(len(equations.q))]
            right.append(Section("Forces by the multipliers", (Statement("B", matrix(rows)),)))
        right += [
            *constraint_sections(equations, writer),
            Section(
                "Accelerations allowed by the constraints",
                (slopes, Statement("b", column(each.rate for each in constraints))),
            ),
        ]
    return [
        Section("Equations of motion", tuple(system)),
        Section("Mass matrix", (Statement("M", matrix(equations.mass_matrix)),)),
        Section("Force", (Statement("f", column(equations.force)),)),
        *right,
    ]


def vakonomic_sections(equations: Equations, writer: Writer) -> list[Section]:
    """The equations of motion, and beside them what Hamilton's principle gives."""
    form = vakonomic_form(equations)
    other = Writer(writer.notation, form.order)
    right = tuple(equation_statements(equations.coordinates, equations.equations, writer))
    wrong = tuple(equation_statements(equations.coordinates, form.equations, other))
    total = writer.notation.plus.join([writer.names("L"), f"{writer.names('mu')} g"])
    return [
        *constraint_sections(equations, writer),
        Section("Equations of motion", right),
        Section(
            "Hamilton's principle applied to the constraints",
            (Statement(total, other.text(form.lagrangian)), *wrong),
        ),
        Section("Remark", (Statement("", "", writer.prose(REMARK)),), True),
    ]


def reaction_sections(equations: Equations, writer: Writer) -> list[Section]:
    """R = m a - F on each particle, and the multipliers. Raises ``UsageError`` where none is known."""
    if not equations.reactions:
        raise UsageError("no --form reactions: no force on a particle is known")
    statements = [one for each in equations.reactions for one in reaction_statements(each, writer)]
    found = [Section("Forces of constraint, R = m a - F", tuple(statements))]
    if equations.unknown_reactions:
        reasons = tuple(
            Statement("", "", writer.notation.words(one)) for one in equations.unknown_reactions.values()
        )
        found.append(Section("Not known", reasons, True))
    if equations.constraints:
        found += constraint_sections(equations, writer, acting=True)
        if equations.multipliers is None:
            found.append(Section("Multipliers", (Statement("", "", equations.unsolved),), True))
        else:
            found += multiplier_sections(equations, equations.multipliers, writer)
    return found


def reaction_statements(each: Reaction, writer: Writer) -> list[Statement]:
    """Its components, and its size where that is a single expression."""
    found = [writer.statement(name, x) for name, x in zip(each.names, each.components, strict=True)]
    if each.size is not None:
        size = writer.notation.call("abs", [writer.names(each.symbol)])
        found.append(Statement(size, writer.notation.call("abs", [writer.text(each.size)])))
    return found


FORMS: Mapping[str, Callable[[Equations, Writer], list[Section]]] = {
    "hamilton": hamilton_sections,
    "matrix": matrix_sections,
    "vakonomic": vakonomic_sections,
    "reactions": reaction_sections,
}
"""The sections of each."""

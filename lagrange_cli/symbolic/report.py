"""The content of each form, as sections of statements. The notations lay them out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from lagrange_cli.errors import UsageError
from lagrange_cli.model.events import HOW
from lagrange_cli.records import replace
from lagrange_cli.symbolic.constraints import TOO_LONG
from lagrange_cli.symbolic.equations import Changing, Conserved, Equations, Event
from lagrange_cli.symbolic.render import Notation
from lagrange_cli.symbolic.statements import (
    Section,
    Statement,
    Writer,
    constraint_sections,
    equation_statements,
    lagrangian_section,
    multiplier_sections,
    named_section,
)

NOTHING = Statement("", "", "nothing that follows from a symmetry of the Lagrangian")


def sections(equations: Equations, form: str, notation: Notation) -> list[Section]:
    """The sections of a form. Raises ``UsageError`` where the system has no such form."""
    writer = Writer(notation, equations.order)
    if form == "explicit":
        refuse_unsolved(equations)
        found = [*explicit_sections(equations, writer), *constraint_sections(equations, writer)]
    elif form == "lagrange":
        found = lagrange_sections(equations, writer)
    else:
        from lagrange_cli.symbolic.forms import FORMS  # and what derives them

        found = FORMS[form](equations, writer)
    events = tuple(event_statement(each, writer) for each in equations.events)
    if equations.replaced:
        given = tuple(writer.statement(name, value) for name, value in equations.replaced.items())
        found = [Section("Coordinates", given), *found]
    return [*found, *([Section("Events", events, True)] if events else [])]


def lagrange_sections(equations: Equations, writer: Writer) -> list[Section]:
    """Energies, L, momenta, Euler-Lagrange equations, accelerations, h, and conserved quantities."""
    momenta = [f"p_{name}" for name in equations.coordinates]
    of_motion = equation_statements(equations.coordinates, equations.equations, writer)
    found = [
        lagrangian_section(equations.T, equations.U, equations.L, writer),
        *constraint_sections(equations, writer, acting=True),
        named_section("Momenta", momenta, equations.momenta, writer),
        Section("Equations of motion", tuple(of_motion)),
    ]
    if equations.accelerations is None:
        hint = f"{equations.unsolved}; --form matrix shows `{linear_system(equations)}`"
        title = "Accelerations and multipliers" if equations.constraints else "Accelerations"
        found.append(Section(title, (Statement("", "", writer.prose(hint)),), True))
    else:
        found += explicit_sections(equations, writer)
    found.append(Section("Energy function", (writer.statement("h", equations.h),)))
    conserved = tuple(conserved_statement(*with_sums(each, writer)) for each in equations.conserved)
    found.append(Section("Conserved", conserved or (NOTHING,), True))
    return [*found, *changing_sections(equations.changing, writer)]


def refuse_unsolved(equations: Equations) -> None:
    """Raise ``UsageError`` where there are no explicit accelerations."""
    if equations.accelerations is None:
        raise UsageError(f"{without_solution(equations)}: use --form matrix ({linear_system(equations)})")


def explicit_sections(equations: Equations, writer: Writer) -> list[Section]:
    """The accelerations and multipliers as functions of q, v, t."""
    found = [named_section("Accelerations", equations.a, equations.accelerations or (), writer)]
    return [*found, *multiplier_sections(equations, equations.multipliers or (), writer)]


def without_solution(equations: Equations) -> str:
    """Why there are no explicit accelerations, as a sentence."""
    what = "accelerations and multipliers" if equations.constraints else "accelerations"
    if equations.unsolved == TOO_LONG:
        return f"the explicit {what} are {TOO_LONG}"
    return f"there are no explicit {what}, since {equations.unsolved}"


def linear_system(equations: Equations) -> str:
    """The equations that accelerations and multipliers solve, in letters."""
    return "M a = f + A^T lambda, A a = b" if equations.constraints else "M a = f"


def with_sums(each: Conserved, writer: Writer) -> tuple[Conserved, Writer]:
    """A conserved quantity with sums over the members of families, and what writes them."""
    if not any("[" in symbol.name for symbol in each.expression.free_symbols):
        return each, writer
    from lagrange_cli.symbolic.indexed.folding import Folding

    folding = Folding(writer.order)
    return replace(each, expression=folding.folded(each.expression)), Writer(writer.notation, folding.order)


def conserved_statement(each: Conserved, writer: Writer) -> Statement:
    """``p_theta`` (its expression is listed with the momenta) and the reason; for others the expression."""
    listed = each.quantity in ("h", "T + U") or each.quantity.startswith("p_")
    right = "" if listed else writer.text(each.expression)
    return Statement(writer.names(each.quantity), right, writer.prose(each.because))


def event_statement(
    each: Event, writer: Writer, members: str = "", of: Mapping[str, str] = MappingProxyType({})
) -> Statement:
    """``when = 0``, and the direction and what happens there in words; the ``members`` that it stands for,
    and those ``of`` what is set, by name."""
    what = "the motion ends" if each.stops else "recorded"
    if each.changes:
        becomes = writer.notation.becomes
        what = ", ".join(
            writer.notation.inline(f"{writer.names(name)}{becomes}{writer.text(value)}") + of.get(name, "")
            for name, value in each.changes.items()
        )
    remark = ", ".join(filter(None, (writer.notation.words(each.name), HOW[each.direction], members)))
    remark = f"{remark}: {what}"
    return Statement(writer.text(each.when), "0", remark)


def changing_sections(changing: Sequence[Changing], writer: Writer) -> list[Section]:
    """``dh/dt = ...`` and the reason, of what is not conserved; no section where there is nothing."""
    said = (
        Statement(writer.rate(each.quantity), writer.text(each.rate), writer.prose(each.because))
        for each in changing
    )
    return [Section("Not conserved", tuple(said), True)] if changing else []

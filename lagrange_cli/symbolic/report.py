"""The content of each form, as sections of statements. The notations lay them out."""

from __future__ import annotations

import re
from collections.abc import Iterable

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.model.events import HOW
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.equations import Changing, Conserved, Equations, Event
from lagrange_cli.symbolic.hamilton import Hamiltonian, hamilton_form
from lagrange_cli.symbolic.order import Order
from lagrange_cli.symbolic.render import Level, Notation, Renderer

FORMS = ("lagrange", "explicit", "hamilton", "matrix")

_NAME = re.compile(r"[^\W\d]\w*(?:\[[\d,]+\])?")


def plain(sentence: str) -> str:
    """The sentence without the backticks around its formulas."""
    return sentence.replace("`", "")


@dataclass(frozen=True)
class Statement:
    """``left = right`` and a remark, as text in some notation; ``left`` and ``right`` may be empty."""

    left: str
    right: str = ""
    remark: str = ""


@dataclass(frozen=True)
class Section:
    """A title and its statements; ``verbal`` where these are sentences, not formulas."""

    title: str
    statements: tuple[Statement, ...]
    verbal: bool = False


def sections(equations: Equations, form: str, notation: Notation) -> list[Section]:
    """The sections of a form. Raises ``UsageError`` where the system has no such form."""
    writer = Writer(notation, equations.order)
    if form == "explicit":
        if equations.accelerations is None:
            raise UsageError("the explicit accelerations are too long to print: use --form matrix (M a = f)")
        found = [explicit_section(equations, writer)]
    elif form == "hamilton":
        found = hamilton_sections(equations, hamilton_form(equations), notation)
    elif form == "matrix":
        found = matrix_sections(equations, writer)
    else:
        found = lagrange_sections(equations, writer)
    events = tuple(event_statement(each, writer) for each in equations.events)
    return [*found, *([Section("Events", events, True)] if events else [])]


class Writer:
    """Expressions, symbols and derivatives in one notation."""

    def __init__(self, notation: Notation, order: Order) -> None:
        self.notation = notation
        self.renderer = Renderer(notation, order)

    def text(self, expression: sympy.Expr) -> str:
        """An expression."""
        return self.renderer.at(expression, Level.SUM)

    def names(self, quantity: str) -> str:
        """``p_theta`` or ``T + U``: names with plus signs between them."""
        return self.notation.plus.join(self.notation.symbol(name) for name in quantity.split(" + "))

    def rate(self, quantity: str) -> str:
        """The time derivative of a quantity."""
        text = self.names(quantity)
        return self.notation.rate(self.notation.parentheses(text) if " + " in quantity else text)

    def prose(self, sentence: str) -> str:
        """A sentence with formulas between backticks, such as `h = T + U`: names joined by signs."""

        symbol, inline, words = self.notation.symbol, self.notation.inline, self.notation.words
        parts = sentence.split("`")
        parts[::2] = [words(part) for part in parts[::2]]
        parts[1::2] = [inline(_NAME.sub(lambda name: symbol(name[0]), part)) for part in parts[1::2]]
        return "".join(parts)

    def statement(self, name: str, expression: sympy.Expr) -> Statement:
        """``name = expression``."""
        return Statement(self.names(name), self.text(expression))


def lagrange_sections(equations: Equations, writer: Writer) -> list[Section]:
    """Energies, L, momenta, Euler-Lagrange equations, accelerations, h, and conserved quantities."""
    energies = [
        writer.statement(name, value)
        for name, value in (("T", equations.T), ("U", equations.U), ("L", equations.L))
        if value is not None
    ]
    found = [
        Section("Lagrangian", tuple(energies)),
        Section(
            "Momenta",
            tuple(
                writer.statement(f"p_{name}", momentum)
                for name, momentum in zip(equations.coordinates, equations.momenta, strict=True)
            ),
        ),
        Section("Equations of motion", tuple(equation_statements(equations, writer))),
    ]
    if equations.accelerations is None:
        hint = "too long to print; --form matrix shows `M a = f`"
        found.append(Section("Accelerations", (Statement("", "", writer.prose(hint)),), True))
    else:
        found.append(explicit_section(equations, writer))
    found.append(Section("Energy function", (writer.statement("h", equations.h),)))
    conserved = tuple(conserved_statement(each, writer) for each in equations.conserved)
    nothing = Statement("", "", "nothing that follows from a symmetry of the Lagrangian")
    found.append(Section("Conserved", conserved or (nothing,), True))
    if equations.changing:
        statements = tuple(changing_statement(each, writer) for each in equations.changing)
        found.append(Section("Not conserved", statements, True))
    return found


def equation_statements(equations: Equations, writer: Writer) -> Iterable[Statement]:
    """The Euler-Lagrange equations, each with the factor by which it has been divided, unless that is 1."""
    for name, equation in zip(equations.coordinates, equations.equations, strict=True):
        remark = writer.prose(f"`{name}`")
        if equation.factor != 1:
            remark += f", divided by {writer.notation.inline(writer.text(equation.factor))}"
        yield Statement(writer.text(equation.left), writer.text(equation.right), remark)


def explicit_section(equations: Equations, writer: Writer) -> Section:
    """The accelerations as functions of q, v, t."""
    return Section(
        "Accelerations",
        tuple(
            writer.statement(str(symbol), value)
            for symbol, value in zip(equations.a, equations.accelerations or (), strict=True)
        ),
    )


def hamilton_sections(equations: Equations, form: Hamiltonian, notation: Notation) -> list[Section]:
    """H and the canonical equations."""
    writer = Writer(notation, form.order)
    canonical = [
        *(
            writer.statement(str(symbol), value)
            for symbol, value in zip(equations.v, form.velocities, strict=True)
        ),
        *(
            writer.statement(velocity_name(str(symbol)), value)
            for symbol, value in zip(form.p, form.rates, strict=True)
        ),
    ]
    momenta = Writer(notation, equations.order)
    return [
        Section("Hamiltonian", (writer.statement("H", form.H),)),
        Section("Canonical equations", tuple(canonical)),
        Section(
            "Momenta",
            tuple(
                momenta.statement(str(symbol), value)
                for symbol, value in zip(form.p, equations.momenta, strict=True)
            ),
        ),
    ]


def matrix_sections(equations: Equations, writer: Writer) -> list[Section]:
    """M a = f."""
    rows = [[writer.text(entry) for entry in row] for row in equations.mass_matrix]
    column = [[writer.text(entry)] for entry in equations.force]
    unknowns = [[writer.names(str(symbol))] for symbol in equations.a]
    matrix = writer.notation.matrix
    return [
        Section("Equations of motion", (Statement("M a", "f"), Statement("a", matrix(unknowns)))),
        Section("Mass matrix", (Statement("M", matrix(rows)),)),
        Section("Force", (Statement("f", matrix(column)),)),
    ]


def conserved_statement(each: Conserved, writer: Writer) -> Statement:
    """``p_theta`` (its expression is listed with the momenta) and the reason."""
    return Statement(writer.names(each.quantity), "", writer.prose(each.because))


def event_statement(each: Event, writer: Writer) -> Statement:
    """``when = 0``, and the direction and what happens there in words."""
    what = "the motion ends" if each.stops else "recorded"
    if each.changes:
        becomes = writer.notation.becomes
        what = ", ".join(
            writer.notation.inline(f"{writer.names(name)}{becomes}{writer.text(value)}")
            for name, value in each.changes.items()
        )
    remark = f"{writer.notation.words(each.name)}, {HOW[each.direction]}: {what}"
    return Statement(writer.text(each.when), "0", remark)


def changing_statement(each: Changing, writer: Writer) -> Statement:
    """``dh/dt = ...`` and the reason."""
    return Statement(writer.rate(each.quantity), writer.text(each.rate), writer.prose(each.because))

"""The printed forms of a system of families: pages for people."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.vocabulary import ACCELERATION_SUFFIX, VELOCITY_SUFFIX
from lagrange_cli.records import replace
from lagrange_cli.spec.spec import freedom
from lagrange_cli.symbolic.equations import Event
from lagrange_cli.symbolic.families.equations import EventLine, FamilyEquations
from lagrange_cli.symbolic.families.hamilton import INVERSE, OFFSET, hamilton_form
from lagrange_cli.symbolic.families.lines import Line
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.indexed.members import names_in
from lagrange_cli.symbolic.latex import Latex, blocks, displayed
from lagrange_cli.symbolic.layouts import lines_of
from lagrange_cli.symbolic.mathml import MathML, fragment
from lagrange_cli.symbolic.notations import Text, Unicode
from lagrange_cli.symbolic.render import Notation
from lagrange_cli.symbolic.report import NOTHING, changing_sections, conserved_statement, event_statement
from lagrange_cli.symbolic.statements import (
    KINDS,
    Section,
    Statement,
    Writer,
    equation_statements,
    lagrangian_section,
)

PAGES: Mapping[str, Callable[[], Notation]] = {"text": Text, "unicode": Unicode, "latex": Latex}


def as_page(equations: FamilyEquations, format_: str, form: str) -> str:
    """The equations as text, unicode or LaTeX."""
    notation = PAGES[format_]()
    content = sections(equations, form, notation)
    if isinstance(notation, Latex):
        return blocks(equations.name, content)
    free = freedom(equations.degrees_of_freedom, equations.first_order)
    return lines_of(equations.name, free, content)


def as_mathml(equations: FamilyEquations) -> str:
    """The equations as a part of a web page."""
    return fragment(sections(equations, "lagrange", MathML()))


def as_display(equations: FamilyEquations) -> str:
    """The formulas as one display, as notebooks show it."""
    return displayed(sections(equations, "lagrange", Latex()))


def sections(equations: FamilyEquations, form: str, notation: Notation) -> list[Section]:
    """The sections of a form."""
    writer = Writer(notation, equations.order)
    found = sections_of_motion(equations, form, writer)
    events = tuple(event_line(one, writer) for one in equations.events)
    return [*found, *([Section("Events", events, True)] if events else [])]


def event_line(each: EventLine, writer: Writer) -> Statement:
    """Events that are alike."""
    line, changes = each.line, {one.symbol.name: one.value for one in each.changes}
    event = Event(line.name(), line.expression, each.direction, each.stops, changes)
    of = {one.symbol.name: f" ({writer.notation.members(one.loops)})" for one in each.changes if one.loops}
    return event_statement(event, writer, writer.notation.members(line.loops), of)


def sections_of_motion(equations: FamilyEquations, form: str, writer: Writer) -> list[Section]:
    """Those without events."""
    used = names_used(equations)
    sizes = tuple(
        Statement(writer.names(name), str(size)) for name, size in equations.sizes.items() if name in used
    )
    first = [Section("Sizes", sizes)] if sizes else []
    if form in OTHER_FORMS:
        return [*first, *OTHER_FORMS[form](equations, writer)]
    of_motion = [
        Statement(one.left, one.right, with_members(one.remark, line.loops, writer))
        for line, equation in equations.equations
        for one in equation_statements([line.name()], [equation], writer)
    ]
    conserved = tuple(conserved_statement(each, writer) for each in equations.conserved)
    if equations.constraints:
        conserved = (*conserved, Statement("", "", NOT_LOOKED_FOR))
    return [
        *first,
        *trees(equations, writer),
        *places(equations, writer),
        lagrangian_section(equations.T, equations.U, equations.L, writer),
        *constraints(equations, writer),
        momenta_section(equations, writer),
        Section("Equations of motion", tuple(of_motion)),
        accelerations(equations, writer, form),
        Section("Energy function", (writer.statement("h", equations.h),)),
        Section("Conserved", conserved or (NOTHING,), True),
        *changing_sections(equations.changing, writer),
    ]


def hamilton_sections(equations: FamilyEquations, momenta: Writer) -> list[Section]:
    """H and the canonical equations, with the inverse of M where that is not known with indices."""
    form = hamilton_form(equations)
    writer = Writer(momenta.notation, form.order)
    canonical = [
        *(line_statement(one, one.name("", VELOCITY_SUFFIX), writer) for one in form.velocities),
        *(line_statement(one, one.name("p_", VELOCITY_SUFFIX), writer) for one in form.rates),
    ]
    with_velocities = "" if form.solved else ", with these velocities"
    found = [
        *([] if form.solved else [*trees(equations, momenta), *places(equations, momenta)]),
        Section("Hamiltonian", (writer.statement("H", form.H),)),
        *constraints(equations, momenta),
        Section("Canonical equations" + with_velocities, tuple(canonical)),
        momenta_section(equations, momenta),
    ]
    if not form.solved:
        at_rest = tuple(line_statement(one, one.name(OFFSET), momenta) for one in form.offsets)
        found += [Section("Momenta at rest", at_rest)] if at_rest else []
        inverse = Statement("", "", momenta.prose(INVERSE))
        found += [mass_section(equations, momenta), Section("Inverse", (inverse,), True)]
    return found


def matrix_sections(equations: FamilyEquations, writer: Writer) -> list[Section]:
    """M a = f, or with constraints M a = f + A^T lambda and A a = b."""
    rates = (line_statement(one, one.name("f_"), writer) for one in equations.rates or ())
    found = [
        *trees(equations, writer), *places(equations, writer), mass_section(equations, writer),
        Section("Force", tuple(rates)),
    ]  # fmt: skip
    if not equations.constraints:
        return [Section("Equations of motion", (Statement("M a", "f"),)), *found]
    pull = f"{writer.notation.transposed(writer.names('A'))} {writer.names('lambda')}"
    whole = writer.notation.plus.join(["f", pull])
    pulls = (line_statement(one, one.name("r_"), writer) for one in equations.pulls)
    said = Statement("M a", whole), Statement("A a", "b"), Statement("r", pull)
    return [
        Section("Equations of motion", said),
        *found,
        Section("Force of the constraints", tuple(pulls)),
        *constraints(equations, writer),
        Section("Accelerations allowed by the constraints", zeros(equations, equations.allowed, writer)),
    ]


def mass_section(equations: FamilyEquations, writer: Writer) -> Section:
    """The diagonal of M, or its entries."""
    if equations.diagonal is not None:
        diagonal = (line_statement(one, one.name("M_"), writer) for one in equations.diagonal)
        return Section("Mass matrix, which is diagonal", tuple(diagonal))
    listed = [one for one in equations.masses or () if one.expression != 0]
    others = equations.blocks is not None or len(listed) < len(equations.masses or ())
    title = "Mass matrix, which is symmetric" + "; entries that are not listed are 0" * others
    return Section(title, tuple(line_statement(one, one.name(), writer) for one in listed))


def explicit_sections(equations: FamilyEquations, writer: Writer) -> list[Section]:
    """The accelerations, or the equations whose solution they are."""
    section = accelerations(equations, writer, "explicit")
    return (
        [section] if equations.accelerations is not None else [section, *matrix_sections(equations, writer)]
    )


def reaction_sections(equations: FamilyEquations, writer: Writer) -> list[Section]:
    """R = m a - F on each particle."""
    if equations.reactions is None:
        raise Unsuited
    form = equations.reactions
    known = replace(equations, places=form.places, paths=form.paths)
    forces = (line_statement(one, one.name(), writer) for one in form.lines)
    return [
        *trees(known, writer),
        *places(known, writer),
        Section("Forces of constraint, R = m a - F", tuple(forces)),
        *constraints(equations, writer),
    ]


OTHER_FORMS: Mapping[str, Callable[[FamilyEquations, Writer], list[Section]]] = {
    "explicit": explicit_sections,
    "hamilton": hamilton_sections,
    "matrix": matrix_sections,
    "reactions": reaction_sections,
}
"""The sections of further forms."""


def momenta_section(equations: FamilyEquations, writer: Writer) -> Section:
    """The momenta in terms of velocities."""
    return Section("Momenta", tuple(line_statement(one, one.name("p_"), writer) for one in equations.momenta))


def accelerations(equations: FamilyEquations, writer: Writer, form: str) -> Section:
    """The accelerations, or what they follow from."""
    if equations.accelerations is None:
        title, said = "Accelerations", TOGETHER
        if equations.constraints:
            rates = "derivatives" if equations.nonholonomic else "second derivatives"
            title, said = "Accelerations and multipliers", BOUND.format(rates)
        said += "; see --form matrix" * (form != "explicit")
        if equations.first_order:
            whole = equations.first_order == sum(len(one.members) for one in equations.coordinates)
            said = RATES if whole else PARTLY
        return Section(title, (Statement("", "", writer.notation.words(said)),), True)
    listed = (
        line_statement(one, one.name("", ACCELERATION_SUFFIX), writer) for one in equations.accelerations
    )
    return Section("Accelerations", tuple(listed))


NOT_LOOKED_FOR = "with constraints, momenta are examined only where all members are written out"
TOGETHER = "the solution of all equations of motion together, which are linear in them"
RATES = "the rates of the velocities, which the equations of motion give"
PARTLY = (
    "those of coordinates without mass are the rates of their velocities, which their equations of motion "
    "give; the others are the solution of the other equations of motion"
)
BOUND = "the solution of all equations of motion and the {} of the constraints together"


def constraints(equations: FamilyEquations, writer: Writer) -> Iterator[Section]:
    """The constraints, if there are any."""
    if equations.constraints:
        yield Section("Constraints", zeros(equations, equations.constraints, writer))


def zeros(equations: FamilyEquations, lines: Sequence[Line], writer: Writer) -> tuple[Statement, ...]:
    """What constraints keep at 0, with the names of their members."""
    return tuple(
        Statement(
            writer.text(one.expression), "0",
            with_members(
                writer.notation.words(one.name() + KINDS[one.family.name not in equations.nonholonomic]),
                one.loops, writer,
            ),
        )
        for one in lines
    )  # fmt: skip


def trees(equations: FamilyEquations, writer: Writer) -> Iterator[Section]:
    """What paths along trees are."""
    said: list[Statement] = []
    for path in equations.paths:
        name = writer.names(f"{path.name}[i,j]")
        said.append(Statement(name, "", writer.prose(ON_THE_PATH)))
        for loop, parent in zip(path.loops, path.parents):
            own = writer.notation.inline(writer.notation.whole(parent.text))
            own = writer.prose(f"the parent of `{loop.index}` is ") + own
            said.append(Statement("", "", with_members(own, (loop,), writer)))
    if said:
        yield Section("Trees", tuple(said), True)


ON_THE_PATH = "1 where `j` is `i`, the parent of `i`, the parent of that, and so on; 0 elsewhere"


def places(equations: FamilyEquations, writer: Writer) -> Iterator[Section]:
    """Places that have names, and their rates."""
    if equations.places:
        said = (
            Statement(
                writer.names(one.symbol.name), writer.text(one.expression),
                with_members("", one.loops, writer),
            )
            for one in equations.places
        )  # fmt: skip
        yield Section("Positions", tuple(said))


def names_used(equations: FamilyEquations) -> set[str]:
    """The names of indices and sizes in the equations."""
    found = names_in(equations.L)
    forces = () if equations.reactions is None else equations.reactions.lines
    events = (one.line for one in equations.events)
    listed = *equations.momenta, *(equations.accelerations or ()), *equations.constraints, *forces, *events
    for line in listed:
        found |= names_in(line.expression)
        found.update(*(one.names for one in line.loops), *(one.names for one in line.indices))
    return found


def line_statement(line: Line, name: str, writer: Writer) -> Statement:
    """``name = expression`` of some members."""
    return Statement(writer.names(name), writer.text(line.expression), with_members("", line.loops, writer))


def with_members(remark: str, loops: Sequence[Loop], writer: Writer) -> str:
    """A remark, and the members to which it applies."""
    return ", ".join(filter(None, (remark, writer.notation.members(loops))))

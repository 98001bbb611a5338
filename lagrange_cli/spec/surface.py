"""An expression of the command line in the names of a system file, whose zeros are looked for: a surface in
the space of states, such as ``theta`` or ``x - l*sin(omega*t)``."""

from __future__ import annotations

import re
from collections.abc import Iterable

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.bounds import Bounds
from lagrange_cli.expression.syntax import ExpressionError, Name
from lagrange_cli.expression.vocabulary import TIME, family_name, velocity_name
from lagrange_cli.records import replace
from lagrange_cli.spec.content import by_name, groups_by_name
from lagrange_cli.spec.event import Event
from lagrange_cli.spec.events.readers import read_when
from lagrange_cli.spec.kinds import Kind, comes_to
from lagrange_cli.spec.lookups import changed
from lagrange_cli.spec.meanings import scalar
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.nodes import Scalar
from lagrange_cli.spec.order import on_demand
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.settling import check_scalar
from lagrange_cli.spec.source import Passage, Source
from lagrange_cli.spec.spec import SURFACE, Expression, Spec, grouped

KEYS = re.compile(r"'(when|direction): ([^']*)'")
"""Keys of the file in a hint, where options are meant."""
DECLARED = re.compile(r"(; or| Or) add it to the parameters: '[^']*'$")
"""The end of a hint about an unknown name in a file."""
OUTPUTS = "; energies and momenta are written with these"
"""Its end here, where the name may be that of an output."""


def with_surface(spec: Spec, text: str, direction: int = 0) -> Spec:
    """The system with a last event, called ``SURFACE``, where the expression ``text`` becomes 0.

    Raises ``UsageError`` where it is no scalar expression in the system's names that varies along a motion.
    """
    source = Source(SURFACE, text)
    problems = Problems(source)
    names = names_of(spec, problems)
    when = read_when(Scalar(Passage(source, text, (0, 0), (0, len(text))), False), SURFACE, problems)
    when = changed(when, lambda name: spec.tables.get(name.identifier), problems)
    if when is not None and problems.trusts(when.tree):
        check_scalar(names, when, "events", SURFACE)
        kinds, _ = names.check(when, "events", SURFACE)
        if not problems.found and kinds <= {Kind.PARAMETER, Kind.SIZE}:
            problems.add(when.place, "this never changes", "let it depend on a coordinate, a velocity or t")
    if problems.found or when is None:
        first = problems.found[0]
        message = first.message.removesuffix(f" in {SURFACE}").replace(f"{SURFACE} needs", "a surface needs")
        hint = KEYS.sub(r"--\1 '\2'", first.hint).replace("--when", SURFACE)
        hint = DECLARED.sub(lambda end: OUTPUTS if end[1].startswith(";") else "", hint)
        raise UsageError(f"{SURFACE} {text}: {message}" + (f"; {hint}" if hint else ""))
    surface = Event(when, direction, False, (), when.place)
    return replace(spec, events=by_name({**groups_by_name(spec.events), SURFACE: surface}))


def check_constant(name: Name, spec: Spec, hint: str) -> None:
    """Raise ``ExpressionError`` where a definition in an option changes, with this ``hint``, or has no such
    member or component."""
    known = names_of(spec, Problems(Source(spec.filename, spec.text)))
    meaning = known.table[name.base]
    if meaning.kinds - {Kind.PARAMETER, Kind.SIZE}:
        raise ExpressionError(name.span, f"'{name.base}' is not constant", hint)
    known.check_indices(name, meaning)
    component = name.identifier.partition(".")[2]
    if component:
        known.check_component(name, meaning, name.base, component)


def names_of(spec: Spec, problems: Problems) -> Names:
    """The table of names of a system that has been read, for expressions that stand elsewhere."""
    names = Names(problems, spec.sizes, {row.key: row.rule for row in SECTIONS.rows})
    names.declare(TIME, Kind.TIME, None, scalar())
    for size, value in spec.sizes.items():
        names.declare(size, Kind.SIZE, None, Bounds(float(value)))
        names.settle(size, frozenset(), Bounds(float(value)))

    def declare(section: str, members: Iterable[str], what: Kind, value: object = None) -> None:
        families = spec.families.get(section, {})
        if what is Kind.PARTICLE:
            families = {**spec.families.get("masses", {}), **families}
        for family in grouped(members, families):
            names.declare(family.name, what, None, value, family if family.shape else None)
            if what is Kind.COORDINATE:
                speed = velocity_name(family.name)
                names.declare(
                    speed, Kind.VELOCITY, None, value, family.renamed(speed) if family.shape else None
                )

    declare("coordinates", (one.name for one in spec.coordinates), Kind.COORDINATE, scalar())
    declare("parameters", (one.name for one in spec.parameters), Kind.PARAMETER, scalar())
    particles = {k: one for k, one in spec.embedding.items() if k not in spec.bodies}
    bodies = {name: spec.embedding[name] for name in spec.bodies}
    sections = {
        "definitions": (Kind.DEFINITION, spec.definitions),
        "embedding": (Kind.PARTICLE, particles),
        "bodies": (Kind.BODY, bodies),
    }
    members = dict[str, dict[str, tuple[str, Kind]]]()
    for section, (what, given) in sections.items():
        declare(section, given, what)
        for name in given:
            members.setdefault(family_name(name), {})[name] = section, what

    def compute(name: str) -> None:
        section, what = members[family_name(name)][name]
        settle(names, name, what, sections[section][1][name], section)

    for base in spec.order:
        names.awaited.add(base)
        on_demand(members.get(base, ()), compute)
        names.awaited.discard(base)
    return names


def settle(names: Names, name: str, what: Kind, expression: Expression, section: str) -> None:
    """Set the kinds and bounds of a definition or a particle."""
    kinds, bounds = names.check(expression, section, "")
    if what in (Kind.PARTICLE, Kind.BODY):
        kinds, bounds = comes_to(what), bounds if isinstance(bounds, tuple) else (bounds,)
    names.settle(name, kinds, bounds)

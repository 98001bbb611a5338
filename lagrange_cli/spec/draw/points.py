"""Points of the section ``draw``: lines through them, lists of them, and what a list hides."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from lagrange_cli.expression.indices import integer
from lagrange_cli.expression.loops import repeated
from lagrange_cli.expression.near import known_hint, near_hint, shown
from lagrange_cli.expression.syntax import ExpressionError, Name, Number, Span, plain_names
from lagrange_cli.expression.vocabulary import CONSTANTS, member_name
from lagrange_cli.limits import whole
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.draft import Draft
from lagrange_cli.spec.draw.readers import Several, Strand, plain_name
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import WHOLE_FILE
from lagrange_cli.spec.spec import Expression, by_family
from lagrange_cli.spec.wanted import Path

SECTION = "draw"


@dataclass
class Points:
    """The draft, the table of names, and where problems go."""

    draft: Draft
    names: Names
    problems: Problems
    particles: dict[str, list[str]] = field(default_factory=dict)
    """The members of each family of particles or bodies; a particle of its own is its only member."""
    flat: bool = False
    """Whether all particles are on a line, so that a number is a place."""

    def __post_init__(self) -> None:
        every = [one.name for one in (*self.draft.entries("embedding"), *self.draft.bodies)]
        self.particles = by_family((name, name) for name in every)
        places = [self.names.values.get(name) for name in every]
        self.flat = bool(every) and all(isinstance(one, tuple) and len(one) == 1 for one in places)

    def lines(self, given: Several | None, where: str) -> tuple[Path, ...] | None:
        """The lines through points, as often as loops repeat them."""
        if given is None:
            return None
        return tuple(path for strand in given.strands for path in self._repeated(strand, where))

    def points(self, given: Several | None, where: str) -> tuple[Expression, ...] | None:
        """The points of a list; the name of a family stands for all of its members."""
        if given is None:
            return None
        if given.all:
            return tuple(_named(name) for members in self.particles.values() for name in members)
        found: list[Expression] = []
        for strand in given.strands:
            name = plain_name(strand.points[0])
            members = self.particles.get(name.identifier, []) if name and not name.indices else []
            if "[" in "".join(members[:1]):
                found += [_named(one) for one in members]
            else:
                found += [path[0] for path in self._repeated(strand, where)]
        return tuple(found)

    def _repeated(self, strand: Strand, where: str) -> Iterator[Path]:
        """The points of a strand for each value of its loops; each of them is checked."""
        for indices in self._indices(strand, where):
            path = tuple(replace(one, indices=indices) if indices else one for one in strand.points)
            for one in path:
                self.point(one, where)
            yield path

    def _indices(self, strand: Strand, where: str) -> Iterator[dict[str, int]]:
        try:
            for loop in strand.loops:
                self.names.check_index(loop.index, loop.span)
            yield from repeated(strand.loops, self.names.sizes, whole("members"))
        except ExpressionError as error:
            if not self._broken(strand):
                self.problems.add_expression(strand.text, error, where)

    def _broken(self, strand: Strand) -> bool:
        """Whether a range follows from a size that is wrong."""
        used = [bound for loop in strand.loops for bound in (*loop.bounds, *loop.conditions)]
        return any(plain_names(one) & self.problems.broken for one in used)

    def point(self, expression: Expression | None, where: str) -> Expression | None:
        """The expression, checked to be a point: a vector, or 0 for the origin."""
        if expression is None:
            return None
        name = plain_name(expression)
        if name is not None and self.particles and not self._has(name.base, expression):
            self.problems.add_expression(expression, self._unknown(name), where)
            return expression
        _, bounds = self.names.check(expression, SECTION, where)
        if bounds is None or isinstance(bounds, tuple) or self.flat or _is_origin(expression):
            return expression
        hint = "write 0 for the origin, or (x, y)"
        if name is not None:
            meaning = self.names.table.get(name.base)
            hint = f"'{name.base}' is a {meaning.what.value}: {hint}" if meaning else hint
        span = Span(0, len(expression.text)) if expression.text else expression.tree.span
        error = ExpressionError(
            expression.tree.span if name else span, "expected a point, found a number", hint
        )
        self.problems.add_expression(expression, error, where)
        return expression

    def hidden(self, given: Several | None) -> frozenset[str]:
        """The particles and bodies that are not shown."""
        if given is None:
            return frozenset()
        if given.all:
            return frozenset(name for members in self.particles.values() for name in members)
        found: set[str] = set()
        for strand in given.strands:
            name = plain_name(strand.points[0])
            if name is None:
                error = ExpressionError(Span(0, len(strand.text.text)), "expected the name of a particle", "")
                self.problems.add_expression(strand.text, error, "hide")
                continue
            try:
                for indices in self._indices(strand, "hide"):
                    found |= {*self._hidden(name, indices)}
            except ExpressionError as error:
                self.problems.add_expression(strand.text, error, "hide")
        return frozenset(found)

    def _has(self, name: str, expression: Expression) -> bool:
        """Whether a name in an expression is known, or follows from a mistake."""
        known = self.names.table, self.problems.broken, self.names.bound, CONSTANTS, expression.indices
        return any(name in names for names in known)

    def _unknown(self, name: Name) -> ExpressionError:
        hint = near_hint(name.base, self.particles) or known_hint(self.particles)
        return ExpressionError(name.span, f"unknown particle {shown(name.base)}", hint)

    def _hidden(self, name: Name, indices: Mapping[str, int]) -> Sequence[str]:
        if name.identifier in self.problems.broken:
            return ()
        members = self.particles.get(name.identifier)
        if members is None:
            raise self._unknown(name)
        if not name.indices:
            return members
        known = {**self.names.sizes, **indices}
        member = member_name(name.identifier, [integer(index, known) for index in name.indices])
        if member not in members:
            family = self.names.table[name.identifier].family
            hint = family.hint(member) if family else f"write {name.identifier}"
            raise ExpressionError(name.span, f"no member '{member}'", hint)
        return (member,)


def _named(name: str) -> Expression:
    """A particle as an expression."""
    return Expression(name, Name(name, Span(0, len(name))), WHOLE_FILE)


def _is_origin(expression: Expression) -> bool:
    """Whether it is the number 0."""
    return isinstance(expression.tree, Number) and float(expression.tree.text) == 0

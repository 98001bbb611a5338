"""Forces of constraint on the particles of families, R[i] = m[i] a[i] - F[i], with their indices.

F is what is applied: forces, and those of U and of Rayleigh's D as functions of positions and velocities
(``mechanics.constrained.reactions``). Where these contain a coordinate that is itself a component of a place,
that component is meant.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, TypeAlias

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.vocabulary import BODY_COMPONENTS, COMPONENTS, velocity_name
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.groups import particle_families
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import Family, Spec, grouped
from lagrange_cli.symbolic.families.bodies import orienting
from lagrange_cli.symbolic.families.chains import Path
from lagrange_cli.symbolic.families.derivatives import Part, parts, spans_within, within
from lagrange_cli.symbolic.families.given import Given
from lagrange_cli.symbolic.families.kinds import LETTERS
from lagrange_cli.symbolic.families.lines import Line
from lagrange_cli.symbolic.families.places import RATES, NamedPlace
from lagrange_cli.symbolic.families.space import InSpace
from lagrange_cli.symbolic.families.sums import finished
from lagrange_cli.symbolic.indexed.conditions import Condition, Loop, changed, decided, relation
from lagrange_cli.symbolic.indexed.members import KNOWN, Summed, member, renamed
from lagrange_cli.symbolic.indexed.whole import Whole

FORCE = "R"
Written: TypeAlias = "tuple[tuple[Loop, ...], tuple[Whole, ...], sympy.Expr]"
"""The loops through members that are written alike, the indices of one, and what a component of it is."""


@dataclass(frozen=True)
class ReactionForm:
    """The components of the forces of constraint, a line for particles that are alike, and the ``places``
    and ``paths`` along trees that they contain by name."""

    lines: tuple[Line, ...]
    places: tuple[NamedPlace, ...]
    paths: tuple[Path, ...]


def reactions_of(system: FamilySystem, spec: Spec | None = None) -> ReactionForm:
    """The forces of constraint on particles. Raises ``UsageError`` where these are not known, and
    ``Unsuited`` or ``Split`` where they cannot be written with indices."""
    return _Reactions(system, spec, naming=True).form()


class _Reactions(Given):
    def form(self) -> ReactionForm:
        """The forces, and the places that they contain."""
        if self.spec.lagrangian is not None:
            raise UsageError("no --form reactions: the file gives L, in which there are no particles")
        self.families = grouped(self.spec.embedding, particle_families(self.spec))
        self.kinds_of = {family.name: [*self.placed_kinds(family)] for family in self.families}
        if self.system.vector is not None:
            raise Unsuited  # the rate of dU/dv is a force, too
        counts = {name: len(listed[0][1]) for name, listed in self.kinds_of.items()}
        if any(len(one[1]) != counts[name] for name, listed in self.kinds_of.items() for one in listed):
            raise Unsuited
        self._written: dict[str, Sequence[Written]] = {}
        self.space = InSpace(self.spec, counts)
        self.acting = self.applied_in_space()
        lines = [line for family in self.families for line in self.of_particles(family)]
        used = {KNOWN[s.name][0] for one in lines for s in symbols_of(one.expression) if s.name in KNOWN}
        places = [
            replace(one, expression=self.lines.shown(one.expression, {}, one.loops))
            for one in self.builder.written_places(used)
        ]
        return ReactionForm(
            tuple(one.of(self.finished(one.expression, one.loops)) for one in lines),
            tuple(replace(one, expression=self.finished(one.expression, one.loops)) for one in places),
            tuple(self.builder.paths),
        )

    def finished(self, expression: sympy.Expr, loops: Sequence[Loop]) -> sympy.Expr:
        """An expression as it is printed."""
        used = self.builder.taken | {one.index for one in loops}
        letters = [one for one in LETTERS if one not in used]
        return finished(expression, letters, {one.name for one in self.builder.paths})

    def placed_kinds(
        self, family: Family
    ) -> Iterator[tuple[tuple[Any, ...], tuple[sympy.Expr, ...], sympy.Expr, tuple[Whole, ...]]]:
        """Particles of a family that are written alike: loops, place, mass and indices."""
        for kind in self.kinds(family, self.spec.embedding):
            mass = self.elsewhere(kind, family, self.spec.masses)
            where = self.elsewhere(kind, family, self.spec.embedding)
            for loops, (place, (own,)) in self.values(kind, where, mass):
                yield loops, place, own, kind.indices

    def of_particles(self, family: Family) -> Iterator[Line]:
        """The lines of a family's components. What nothing but forces moves feels no force of constraint."""
        listed = self.kinds_of[family.name]
        free = not self.spec.constrained and self.system.joints is None
        plain = set(self.plain().values())
        for k, axis in enumerate(COMPONENTS[: len(listed[0][1])]):
            own = Family(f"R_{family.name}_{axis}", family.shape, family.members, family.axes)
            force = [
                Part(mass * self.builder.rate(self.builder.rate(place[k])), loops, indices)
                for loops, place, mass, indices in listed
            ]
            component = family.name, k
            force = [] if free and component in plain else [*force, *self.acting.get(component, ())]
            for line, sums in self.lines.of(own, {FORCE: force}):
                yield line.of(sums[FORCE])

    def plain(self) -> dict[str, tuple[str, int]]:
        """The families of coordinates that are components of places themselves: which ones."""
        found: dict[str, tuple[str, int]] = {}
        twice: set[str] = set()
        for name, listed in self.kinds_of.items():
            for _, place, _, indices in listed:
                for k, one in enumerate(place):
                    for symbol in symbols_of(one):
                        base = KNOWN.get(symbol.name, (symbol.name, ()))[0]
                        if base in found and found[base] != (name, k):
                            twice.add(base)
                        if one != (member(base, indices) if indices else sympy.Symbol(base)):
                            twice.add(base)
                        found[base] = name, k
        names = {one.name for one in self.builder.coordinates}
        return {base: one for base, one in found.items() if base in names and base not in twice}

    def applied_in_space(self) -> dict[tuple[str, int], list[Part]]:
        """-F by the component of a family of particles."""
        spec, space, plain = self.spec, self.space, self.plain()
        energies = [(space.scalar(one), 0) for one in spec.potential.values()]
        energies += [(space.scalar(one), 1) for one in spec.forces.get("dissipation", {}).values()]
        found: dict[tuple[str, int], list[Part]] = {}
        for expression, rate in energies:
            for name, count in space.components.items():
                for k in range(count):
                    base = f"{name}.{RATES[rate][k]}"
                    found.setdefault((name, k), []).extend(self.actual(parts(expression, base, nothing)))
            for family in self.builder.coordinates:
                base = velocity_name(family.name) if rate else family.name
                slopes = [*parts(expression, base, nothing)]
                if slopes and family.name not in plain:
                    self.refuse("the dissipation contains the velocity of" if rate else "U contains", family)
                if slopes:
                    found.setdefault(plain[family.name], []).extend(self.actual(slopes))
        self.add_forces(found)
        return found

    def add_forces(self, found: dict[tuple[str, int], list[Part]]) -> None:
        """Add the forces that the file gives."""
        spec, plain = self.spec, self.plain()
        written = spec.forces.get("generalized_forces", {})
        for family in grouped(written, spec.families.get("generalized_forces", {})):
            if family.name not in plain:
                self.refuse("a generalized force is given along", family)
            for kind in self.kinds(family, written):
                for loops, ((force,),) in self.values(kind, self.written(kind)):
                    found.setdefault(plain[family.name], []).append(Part(-force, loops, kind.indices))
        written = spec.forces.get("forces", {})
        for family in grouped(written, {**particle_families(spec), **spec.families.get("forces", {})}):
            for kind in self.kinds(family, written):
                for loops, (acting,) in self.values(kind, self.written(kind)):
                    for k, force in enumerate(acting):
                        found.setdefault((family.name, k), []).append(Part(-force, loops, kind.indices))

    def refuse(self, what: str, family: Family) -> None:
        """Raise ``UsageError``: forces along a coordinate do not say what acts on which particle. Where there
        are as many coordinates as components, they may, and ``Unsuited`` is raised."""
        if sum(self.space.components[one.name] * len(one.members) for one in self.families) == len(
            self.spec.coordinates
        ):
            raise Unsuited
        raise UsageError(
            f"no --form reactions: the forces on particles are not known, since {what} the coordinate "
            f"'{family.members[0]}'; write it in positions, such as {self.families[0].members[0]}.x"
        )

    def actual(self, found: Iterable[Part]) -> Iterator[Part]:
        """Parts with the places that particles have, where these are no sums; of particles that are written
        in several ways a part for each of these."""
        for part in found:
            names = {loop.index for loop in part.loops} | self.lines.sizes.keys()
            symbols = sorted(symbols_of(part.factor), key=str)
            several = [one for one in symbols if len(self.written_kinds(one.name)) > 1]
            if not several:
                yield Part(self.inserted(part.factor), part.loops, part.indices)
                continue
            _, wholes = KNOWN[several[0].name]
            if any(not one.names <= names for one in wholes):
                raise Unsuited
            alike = [one for one in several if same_member(one.name, several[0].name)]
            for number, (loops, indices, _) in enumerate(self.written_kinds(several[0].name)):
                chosen = self.among(part.loops, [*places_within(loops, indices, wholes)])
                if chosen is None:
                    continue
                known = {one: self.value_of(self.written_kinds(one.name)[number], wholes) for one in alike}
                yield from self.actual([Part(part.factor.xreplace(known), chosen, part.indices)])

    def among(self, loops: tuple[Loop, ...], conditions: Sequence[Condition]) -> tuple[Loop, ...] | None:
        """Loops with conditions besides; None where these never hold."""
        spans = spans_within(loops, self.lines.sizes)
        known = [decided(one, spans) for one in conditions]
        if False in known:
            return None
        more = tuple(one for one, holds in zip(conditions, known) if holds is None)
        if not more:
            return loops
        *others, last = loops
        return *others, Loop(last.index, last.start, last.stop, last.step, (*last.conditions, *more))

    def inserted(self, expression: sympy.Expr) -> sympy.Expr:
        """An expression with what components are in place of their names."""
        if isinstance(expression, Summed):
            return Summed(self.inserted(expression.body), expression.args[1])
        if expression.is_Symbol:
            written = self.written_kinds(expression.name)
            if len(written) > 1:
                raise Unsuited
            wholes = KNOWN.get(expression.name, ("", ()))[1]
            return self.value_of(written[0], wholes) if written else expression
        return expression.func(*map(self.inserted, expression.args)) if expression.args else expression

    def value_of(self, written: Written, wholes: Sequence[Whole]) -> sympy.Expr:
        """What a component of the member with these indices is, if that is written so."""
        _, indices, made = written
        return renamed(made, {one.text: whole for one, whole in zip(indices, wholes)}, self.lines.sizes)

    def written_kinds(self, symbol: str) -> Sequence[Written]:
        """In which ways a component of a place, a velocity or an orientation is written; none of other
        symbols."""
        base, _ = KNOWN.get(symbol, (symbol, ()))
        if base not in self._written:
            self._written[base] = [*self.found_kinds(*base.partition(".")[::2])]
        return self._written[base]

    def found_kinds(self, name: str, axis: str) -> Iterator[Written]:
        """The same by the name of a particle and of its component: a name where that is a sum."""
        builder = self.builder
        if axis in BODY_COMPONENTS:
            for kind in builder.of_family(builder.bodies[name]):
                for loops, one in builder.kinds(kind.loops, kind.frame, orienting(builder, name, kind)):
                    yield loops, kind.indices, one.turning.component(axis)
        elif axis and name in self.kinds_of:
            rate = next(r for r, listed in enumerate(RATES) if axis in listed)
            for loops, place, _, indices in self.kinds_of[name]:
                made = place[RATES[rate].index(axis)]
                for _ in range(rate):
                    made = builder.rate(made)
                yield loops, indices, made


def same_member(one: str, other: str) -> bool:
    """Whether two symbols are of places, or of orientations, of one member."""
    (base, wholes), (second, others) = KNOWN[one], KNOWN[other]
    (name, _, axis), (another, _, further) = base.partition("."), second.partition(".")
    turning = (axis in BODY_COMPONENTS) == (further in BODY_COMPONENTS)
    return name == another and wholes == others and turning


def places_within(
    loops: Sequence[Loop], indices: Sequence[Whole], wholes: Sequence[Whole]
) -> Iterator[Condition]:
    """That the members with indices ``wholes`` are among those with ``indices``, as loops run."""
    known = {one.text: whole for one, whole in zip(indices, wholes)}
    running = {loop.index: loop for loop in loops}
    for index, whole in zip(indices, wholes):
        if index.text not in running:
            yield relation(whole, "==", index)
            continue
        loop = running[index.text]
        yield from within(loop, whole)
        yield from (changed(one, lambda own: own.with_names(known)) for one in loop.conditions)


def nothing(base: str, wholes: Sequence[Whole]) -> None:
    """Names stand for themselves."""


def symbols_of(expression: sympy.Expr) -> Iterator[sympy.Symbol]:
    """The symbols of an expression, and of sums in it."""
    for one in sympy.preorder_traversal(expression):
        if isinstance(one, Summed):
            yield from symbols_of(one.body)
        elif one.is_Symbol:
            yield one

"""Forces of constraint on the particles of families, R[i] = m[i] a[i] - F[i], with their indices.

F is what is applied: forces, and those of U and of Rayleigh's D as functions of positions and velocities
(``mechanics.constrained.reactions``). Where these contain a coordinate that is itself a component of a place,
that component is meant.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.vocabulary import (
    AXES_COMPONENTS,
    AXES_RATES,
    BODY_COMPONENTS,
    BODY_SPIN,
    COMPONENTS,
    SPACE_SPIN,
    velocity_name,
)
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.groups import Group, particle_families
from lagrange_cli.model.orientation import Turning
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import Family, Spec, grouped
from lagrange_cli.symbolic.families.bodies import orienting
from lagrange_cli.symbolic.families.builder import Oriented
from lagrange_cli.symbolic.families.chains import Path
from lagrange_cli.symbolic.families.derivatives import Part, parts
from lagrange_cli.symbolic.families.frames import Frame
from lagrange_cli.symbolic.families.given import Given
from lagrange_cli.symbolic.families.kinds import LETTERS
from lagrange_cli.symbolic.families.lines import Line
from lagrange_cli.symbolic.families.places import RATES, NamedPlace, WrittenPlaces
from lagrange_cli.symbolic.families.sums import finished
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.indexed.members import KNOWN, Summed, member, renamed
from lagrange_cli.symbolic.indexed.whole import Whole

FORCE = "R"


@dataclass(frozen=True)
class ReactionForm:
    """The components of the forces of constraint, a line for particles that are alike, and the ``places``
    and ``paths`` along trees that they contain by name."""

    lines: tuple[Line, ...]
    places: tuple[NamedPlace, ...]
    paths: tuple[Path, ...]


class InSpace(WrittenPlaces):
    """A builder for which every component of a particle's place is a quantity of its own, and so are the
    orientations of bodies."""

    def __init__(self, spec: Spec, components: Mapping[str, int]) -> None:
        super().__init__(spec, naming=False)
        self.components = components

    def of_group(self, group: Group, wholes: Sequence[Whole], values: Sequence[Any], frame: Frame) -> Any:
        name = group.family.name
        if name not in self.components:
            return super().of_group(group, wholes, values, frame)
        found = tuple(placed(name, k, 0, wholes) for k in range(self.components[name]))
        return found if len(found) > 1 else found[0]

    def oriented(self, name: str, wholes: Sequence[Whole], values: Sequence[Any], frame: Frame) -> Oriented:
        def symbols(names: Sequence[str]) -> tuple[sympy.Expr, ...]:
            return tuple(member(f"{name}.{one}", wholes) for one in names)

        axes, rates = (
            tuple(symbols(names[k::3]) for k in range(3)) for names in (AXES_COMPONENTS, AXES_RATES)
        )
        return Oriented("", Turning(axes, rates, symbols(SPACE_SPIN), symbols(BODY_SPIN)), (), {})

    def rate(self, expression: sympy.Expr) -> sympy.Expr:
        """The velocity of a component, by its name."""
        base, wholes = KNOWN.get(expression.name, ("", ())) if expression.is_Symbol else ("", ())
        name, _, axis = base.partition(".")
        if name in self.components and axis in RATES[0]:
            return placed(name, RATES[0].index(axis), 1, wholes)
        if axis in AXES_COMPONENTS:
            return member(f"{name}.v{axis}", wholes)
        return super().rate(expression)


def placed(name: str, axis: int, rate: int, wholes: Sequence[Whole]) -> sympy.Symbol:
    """The symbol of a component of a place (``rate`` 0) or a velocity (1)."""
    base = f"{name}.{RATES[rate][axis]}"
    return member(base, wholes) if wholes else sympy.Symbol(base)


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
        counts = {name: len(listed[0][1]) for name, listed in self.kinds_of.items()}
        if any(len(one[1]) != counts[name] for name, listed in self.kinds_of.items() for one in listed):
            raise Unsuited
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

    def actual(self, found: Iterator[Part] | Sequence[Part]) -> Iterator[Part]:
        """Parts with the places that particles have, where these are no sums."""
        for part in found:
            yield Part(self.inserted(part.factor), part.loops, part.indices)

    def inserted(self, expression: sympy.Expr) -> sympy.Expr:
        """An expression with what components are in place of their names."""
        if isinstance(expression, Summed):
            return Summed(self.inserted(expression.body), expression.args[1])
        if expression.is_Symbol:
            return self.meaning(expression)
        return expression.func(*map(self.inserted, expression.args)) if expression.args else expression

    def meaning(self, symbol: sympy.Symbol) -> sympy.Expr:
        """What a component of a place or a velocity is: a name where that is a sum."""
        base, wholes = KNOWN.get(symbol.name, (symbol.name, ()))
        name, _, axis = base.partition(".")
        if name not in self.kinds_of or not axis:
            return symbol
        if axis in BODY_COMPONENTS:
            return self.turned(name, axis, wholes)
        if len(self.kinds_of[name]) > 1:
            raise Unsuited
        ((_, place, _, indices),) = self.kinds_of[name]
        rate = next(r for r, listed in enumerate(RATES) if axis in listed)
        made = place[RATES[rate].index(axis)]
        for _ in range(rate):
            made = self.builder.rate(made)
        return renamed(made, {one.text: whole for one, whole in zip(indices, wholes)}, self.lines.sizes)

    def turned(self, name: str, component: str, wholes: Sequence[Whole]) -> sympy.Expr:
        """A component of how a body turns."""
        kinds = [*self.builder.of_family(self.builder.bodies[name])]
        found = [
            one.turning.component(component)
            for kind in kinds
            for _, one in self.builder.kinds(kind.loops, kind.frame, orienting(self.builder, name, kind))
        ]
        if len(found) > 1:
            raise Unsuited
        indices = dict(zip((one.text for one in kinds[0].indices), wholes))
        return renamed(found[0], indices, self.lines.sizes)


def nothing(base: str, wholes: Sequence[Whole]) -> None:
    """Names stand for themselves."""


def symbols_of(expression: sympy.Expr) -> Iterator[sympy.Symbol]:
    """The symbols of an expression, and of sums in it."""
    for one in sympy.preorder_traversal(expression):
        if isinstance(one, Summed):
            yield from symbols_of(one.body)
        elif one.is_Symbol:
            yield one

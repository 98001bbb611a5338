"""Where particles on chains and trees are, by name: ``bob[i].x`` in place of the sum that it is."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import count, pairwise
from typing import Any

import sympy

from lagrange_cli.expression.syntax import Binary, Tree
from lagrange_cli.expression.vocabulary import ACCELERATION_COMPONENTS, COMPONENTS, VELOCITY_COMPONENTS
from lagrange_cli.families.groups import Group, group_of, particle_families
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Spec
from lagrange_cli.symbolic.families.chains import WrittenChains, shortened, together
from lagrange_cli.symbolic.families.frames import Frame
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.indexed.members import KNOWN, Summed, hidden, member, renamed
from lagrange_cli.symbolic.indexed.whole import Whole, named
from lagrange_cli.symbolic.notations import joined_component

RATES = COMPONENTS, VELOCITY_COMPONENTS, ACCELERATION_COMPONENTS
"""Components of places, velocities and accelerations."""


@dataclass(frozen=True, eq=False)
class Place:
    """Where the members of a family of particles are, as ``loops`` run."""

    name: str
    loops: tuple[Loop, ...]
    shape: tuple[int, ...]
    components: tuple[sympy.Expr, ...]


@dataclass(frozen=True, eq=False)
class NamedPlace:
    """A component of a place, velocity or acceleration by name, and what it is, as ``loops`` run."""

    symbol: sympy.Symbol
    loops: tuple[Loop, ...]
    shape: tuple[int, ...]
    expression: sympy.Expr

    @property
    def base(self) -> str:
        """The name where only letters, digits and underscores may stand: ``bob_vx``."""
        return joined_component(self.symbol.name).partition("[")[0]


class WrittenPlaces(WrittenChains):
    """A builder that gives places names, if ``naming``, where they are sums."""

    def __init__(self, spec: Spec, *, naming: bool) -> None:
        super().__init__(spec)
        self.naming = naming
        self.places: dict[str, Place] = {}
        self.count = (f"p{k}" for k in count())
        self._asked: set[str] = set()
        self._meanings: dict[str, tuple[Place, int, int]] = {}

    def of_group(self, group: Group, wholes: Sequence[Whole], values: Sequence[Any], frame: Frame) -> Any:
        place = self.place(group)
        if place is None:
            return super().of_group(group, wholes, values, frame)
        names = [f"{place.name}.{axis}" for axis in COMPONENTS[: len(place.components)]]
        return together([member(name, wholes) for name in names])

    def place(self, group: Group) -> Place | None:
        """Where the particles of a group are, if that has a name."""
        name = group.family.name
        if not self.naming or name not in particle_families(self.spec):
            return None
        own = self.own(group)
        if own is not self.groups.get(name) or any(own is growing for growing, _ in self._growing):
            return None
        if name not in self._asked:
            self._asked.add(name)
            found = self.named_place(own)
            if found is not None:
                self.places[name] = found
                for k in range(len(found.components)):
                    bases = [f"{name}.{listed[k]}" for listed in RATES]
                    self.rates |= dict(pairwise(bases))
                    self._meanings |= {base: (found, k, rate) for rate, base in enumerate(bases)}
        return self.places.get(name)

    def named_place(self, group: Group) -> Place | None:
        """The same of a group whose members are all written alike, with sums, or are one."""
        family = group.family
        alike = group_of(family, self.spec.masses) if self.follows(group) else group
        if not family.shape or len(alike.trees) > 1:
            return None
        (kind,) = self.of_family(alike)
        found = [*self.kinds(kind.loops, kind.frame, self.among(group, kind))]
        if len(found) != 1 or len(kind.loops) != len(group.family.shape):
            return None
        value = found[0][1]
        components = value if isinstance(value, tuple) else (value,)
        if not any(one.has(Summed) for one in components):
            return None
        return Place(group.family.name, kind.loops, group.family.shape, components)

    def _value(self, tree: Tree, indices: Any) -> Any:
        made = super()._value(tree, indices)
        if not self._meanings or not isinstance(tree, Binary):
            return made
        known = {**self.sizes, **indices.arrays}
        listed = [
            one.replace(lambda part: part.is_Add, lambda part: self.apart(part, known))
            for one in (made if isinstance(made, tuple) else (made,))
        ]
        return tuple(listed) if isinstance(made, tuple) else listed[0]

    def apart(self, expression: sympy.Expr, known: Mapping[str, Any]) -> sympy.Expr:
        """A difference of places with names as what it is, if that is no sum."""
        named_ones = {}
        for symbol in expression.free_symbols:
            meaning = self.meaning(*KNOWN[symbol.name]) if symbol.name in KNOWN else None
            if meaning is not None:
                named_ones[symbol] = meaning
        if len(named_ones) < 2:
            return expression
        closed = shortened(sympy.expand_mul(expression.xreplace(named_ones)), known)
        return expression if closed.has(Summed) else closed

    def meaning(self, base: str, wholes: Sequence[Whole]) -> sympy.Expr | None:
        """What a name of a place, velocity or acceleration stands for, with indices of sums that nothing else
        has."""
        if base not in self._meanings:
            return None
        place, component, rate = self._meanings[base]
        indices = dict(zip((one.index for one in place.loops), wholes))
        return renamed(hidden(self.moved(place, component, rate), self.count), indices, {})

    def moved(self, place: Place, component: int, rate: int) -> sympy.Expr:
        """A component of a place (``rate`` 0), of its velocity (1) or acceleration (2), as it is written."""
        made = place.components[component]
        for _ in range(rate):
            made = self.rate(made)
        return made

    def written_places(self, used: Collection[str]) -> Iterator[NamedPlace]:
        """The names of places, velocities and accelerations that are ``used``, and what they stand for."""
        for base, (place, component, rate) in self._meanings.items():
            if base in used or (not rate and any(f"{place.name}.{one[component]}" in used for one in RATES)):
                symbol = member(base, [named(loop.index) for loop in place.loops])
                yield NamedPlace(symbol, place.loops, place.shape, self.moved(place, component, rate))

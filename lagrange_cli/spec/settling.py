"""The kinds and bounds of parameters and definitions, each after those that it uses."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from lagrange_cli.expression.near import shown
from lagrange_cli.expression.syntax import names, plain_names
from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.draft import Written
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.meanings import scalar
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.order import chain, dependency_order, on_demand
from lagrange_cli.spec.spec import Expression, Family, distinct


def check_scalar(names: Names, expression: Expression, section: str, where: str) -> frozenset[Kind]:
    """Check an expression that must be a scalar. Returns the kinds of its names."""
    kinds, bounds = names.check(expression, section, where)
    if isinstance(bounds, tuple):
        names.problems.add_once(
            expression.place,
            f"expected a scalar in {where}, found a vector",
            "vectors are written under 'definitions'"
            if section == "parameters"
            else vector_hint(names, expression),
        )
    return kinds


def vector_hint(known: Names, expression: Expression) -> str:
    """How a scalar is made of the vectors of an expression."""
    tree = expression.tree
    vectors = [one for one in plain_names(tree) if isinstance(known.values.get(one), tuple)]
    for one in sorted(vectors):
        components = any(name.identifier.startswith(f"{one}.") for name in names(tree))
        if components and known.table[one].what is Kind.PARTICLE:  # m1*g*m1.y: the first m1 should be a mass
            return f"{shown(one)} is a position: write its mass as a parameter M, with 'masses: {{{one}: M}}'"
    hint = f"take a component, as in {min(vectors, default='bead')}.x, or norm() or dot()"
    return f"{shown(vectors[0])} is a vector: {hint}" if len(vectors) == 1 else hint


@dataclass
class Settling:
    """The table of names, and the families by section."""

    names: Names
    families: Mapping[str, Mapping[str, Family]]

    def settle_all(
        self,
        entries: Sequence[Written],
        values: Mapping[str, Expression | None],
        what: Kind,
        section: str,
    ) -> list[str]:
        """Check and settle parameters or definitions; the order in which each uses earlier ones only.

        Families are put in order as a whole, then the members of each among themselves.
        """
        families: dict[str, list[Written]] = {}
        for entry in entries:
            families.setdefault(family_name(entry.name), []).append(entry)
        uses = {name: _uses(one, values) for name, one in families.items()}
        for name in self.families[section]:
            uses[name].discard(name)
        order, cycles = dependency_order(uses)
        places = {entry.name: entry.place for entry in entries}
        for stuck in families.keys() - set(order):
            for entry in families[stuck]:
                self.settle(entry.name, what, frozenset(), None)
        found = []
        for name in order:
            if name in self.families[section] and name in self.names.table:
                kinds = self.names.table[name].kinds - {what}  # its own members are no further kind
                self.names.table[name] = replace(self.names.table[name], kinds=kinds)
            members = {entry.name: entry for entry in families[name]}

            def compute(member: str, members: Mapping[str, Written] = members) -> None:
                self._settle_one(members[member], values[member], what, section)

            settled, circles = on_demand(members, compute)
            found += settled
            cycles += circles
            for entry in families[name]:
                if entry.name not in self.names.values:
                    self.settle(entry.name, what, frozenset(), None)
        for cycle in cycles:
            self.names.problems.add_once(
                places.get(cycle[0], families[family_name(cycle[0])][0].place),
                f"{what.value} '{cycle[0]}' depends on itself: {chain(cycle)}",
                "break the cycle: give one of them a value that does not use the others",
            )
        return found

    def _settle_one(self, entry: Written, value: Expression | None, what: Kind, section: str) -> None:
        if value is None:
            self.settle(entry.name, what, frozenset(), None)
            return
        where = f"{what.value} '{entry.key.label}'"
        if what is Kind.PARAMETER:
            check_scalar(self.names, value, section, where)
            self.settle(entry.name, what, frozenset({what}), scalar())
        else:
            kinds, bounds = self.names.check(value, section, where)
            self.settle(entry.name, what, kinds, bounds)

    def settle(self, name: str, what: Kind, kinds: frozenset[Kind], value: Any) -> None:
        """Set the kinds and bounds of one; the kinds of a family are those of all its members."""
        meaning = self.names.table.get(family_name(name))
        if meaning is not None and meaning.what is what:
            if meaning.family is not None and meaning.value is not None:
                kinds |= meaning.kinds
            self.names.settle(name, kinds, value)


def _uses(entries: Iterable[Written], values: Mapping[str, Expression | None]) -> set[str]:
    """The names that the expressions of some members use."""
    given = (value for entry in entries if (value := values[entry.name]) is not None)
    return {name.base for one in distinct(given) for name in names(one.tree)}

"""The values of parameters and definitions over any algebra of numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.build import Builder, NoMember
from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.expression.syntax import ExpressionError, Tree, names
from lagrange_cli.expression.vocabulary import COMPONENTS, family_name, member_name
from lagrange_cli.spec.content import groups_by_name, groups_of, names_of, statements
from lagrange_cli.spec.family import MemberNames
from lagrange_cli.spec.meanings import Unsound
from lagrange_cli.spec.order import Needs, chain, on_demand
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.spec import Expression, Spec
from lagrange_cli.spec.whole import Part, WrittenFamily

if TYPE_CHECKING:
    from lagrange_cli.spec.together import Together

MANY = 100
"""The number of members of a family from which on they are evaluated together."""


class Evaluation:
    """One evaluation: the values so far, and the problems found."""

    def __init__(
        self,
        spec: Spec,
        overrides: Mapping[str, str],
        algebra: NumberAlgebra,
        given: Mapping[str, Any],
        problems: Problems | None,
    ) -> None:
        self.spec = spec
        self.algebra = algebra
        self.given = given
        self.problems = problems or Problems(Source(spec.filename, spec.text))
        self.texts: dict[str, str] = {}
        self.overrides: dict[str, Tree] = {}
        if overrides:
            from lagrange_cli.spec.settable import named_once, parsed

            self.texts = named_once(spec, overrides)
            self.overrides = {name: parsed(spec, name, text) for name, text in self.texts.items()}
        self.trees: dict[str, list[Tree]] = {}
        """The trees of parameters and definitions, those of all members of a family together."""
        for base, one in groups_by_name(spec.definitions).items():
            self.trees[base] = [written.tree for written in statements(one)]
        for each in groups_of(spec.parameters):
            self.trees[each.name] = [written.value.tree for written in statements(each)]
        for name, tree in self.overrides.items():
            if name in self.trees:  # it is no member of a family
                self.trees[name] = [tree]
            elif family_name(name) in self.trees:
                self.trees[family_name(name)].append(tree)
        self.unknown = set(names_of(spec.parameters))
        """Parameters that have no value yet."""
        self.values: dict[str, Any] = {}
        self.times: dict[str, Any] = {}
        self.definitions: dict[str, Value] = {}
        self.builder = Builder(self._scope, algebra, spec.sizes)
        self.states = Builder(self._scope, algebra, spec.sizes, fades=True)
        """For initial values, where exp(-1000) is as good as 0: the tail of a bump over many members."""
        self.arrays: dict[str, Any] = {}
        """The values of families as arrays, where they have been asked for."""

    def parameters(self) -> None:
        """Evaluate all of them; an override may change what depends on what."""
        known = names_of(self.spec.parameters)
        groups, cycles = known.bases, list[list[str]]()
        heads: dict[str, tuple[WrittenFamily[Any], Part[Any]]] = {}
        """The first members of parts of families whose members are made of others."""

        def compute(name: str) -> None:
            group = groups.get(name)
            if isinstance(group, WrittenFamily):
                for part in group.parts:
                    if group.name in _bases(part.item.value.tree):
                        heads[member_name(group.name, next(part.places))] = group, part
                    else:
                        self._take(group, part, self.together(part, part.item.value))
                on_demand([one for one in heads if one in self.unknown], compute)
                rest = [one for one in group.names if one in self.unknown]
                cycles.extend(on_demand(rest, compute)[1])
                return
            if name in heads:
                group, part = heads[name]
                self._take(group, part, self.in_sequence(group, part, part.item.value))
                if name in self.values:
                    return
            if name in self.given or name in self.overrides:
                value = self.override(name)
            else:
                value = self.value(known.item(name).value, f"parameter '{name}'")
            if value is not None:
                self.values[name] = value
            self.unknown.discard(name)

        cycles += on_demand(groups, compute)[1]
        for cycle in cycles:
            name = next((one for one in cycle if one in self.overrides), cycle[0])
            raise UsageError(f"--set {name}={self.texts.get(name, '')}: depends on itself: {chain(cycle)}")
        self.unknown.clear()
        self.values = {
            name: self.values[name] for name in names_of(self.spec.parameters) if name in self.values
        }

    def _take(self, group: WrittenFamily[Any], part: Part[Any], numbers: Sequence[float] | None) -> None:
        """Use the values of parameters that the file gives, but for those given otherwise."""
        found = {} if numbers is None else dict(zip(group.names_of_part(part), numbers))
        replaced = {*self.given, *self.overrides}
        new = {name: value for name, value in found.items() if name not in replaced}
        self.values |= new
        self.unknown.difference_update(new)  # in place: `-=` with keys makes another set

    def constants(self) -> None:
        """Evaluate those definitions that masses, initial values and times use: they are made of parameters
        only."""
        users = [one.tree for group in groups_by_name(self.spec.masses).values() for one in statements(group)]
        users += [one.tree for one in self.spec.solve.times.values()]
        users += [x.tree for body in self.spec.written_bodies for x in body.inertia.entries]
        parameters = names_of(self.spec.parameters)
        users += [tree for name, tree in self.overrides.items() if name not in parameters]
        for group in groups_of(self.spec.coordinates):
            for one in statements(group):
                users += [x.tree for x in (one.initial, one.velocity) if x is not None]
        needed = set().union(*map(_bases, users))
        pending = [*needed]
        while pending:
            for tree in self.trees.get(pending.pop(), ()):
                pending += _bases(tree) - needed
                needed |= _bases(tree)
        for name, definition in groups_by_name(self.spec.definitions).items():
            if name in needed and not isinstance(definition, WrittenFamily):
                self._constant(name, definition)
            elif name in needed and isinstance(definition, WrittenFamily):
                self._constants(definition)

    def _constants(self, group: WrittenFamily[Expression]) -> None:
        """Evaluate a family of definitions."""
        if any(group.name in _bases(part.item.tree) for part in group.parts):
            self._sequences(group)
            return
        for part in group.parts:
            found = self.together(part, part.item)
            if found is not None:
                self.definitions.update(zip(group.names_of_part(part), found))
            else:
                for name, definition in zip(group.names_of_part(part), group.of_part(part)):
                    self._constant(name, definition)

    def _sequences(self, group: WrittenFamily[Expression]) -> None:
        """Evaluate a family of definitions whose members are made of others, in its order."""
        assert isinstance(group.family.members, MemberNames)
        tried: set[int] = set()
        for name, place in zip(group.names, group.order or group.family.members.places):
            if name in self.definitions:
                continue
            part = group.part_at(place)
            found = None if id(part) in tried else self.in_sequence(group, part, part.item)
            tried.add(id(part))
            if found is not None:
                self.definitions.update(zip(group.names_of_part(part), found))
            else:
                self._constant(name, group.at(place))

    def _constant(self, name: str, definition: Expression) -> None:
        """Evaluate a definition."""
        if not self.problems.trusts(definition.tree):
            return
        try:
            self.definitions[name] = self.builder.build(definition.tree, definition.indices)
        except Unsound:
            return
        except ExpressionError as error:
            self.blame(definition, error, f"definition '{name}'")

    def settle_times(self) -> None:
        """Evaluate the times of ``solve`` that depend on parameters."""
        for name, expression in self.spec.solve.times.items():
            value = self.value(expression, f"{name} of solve")
            if value is not None:
                self.times[name] = value

    def together(
        self, part: Part[Any], expression: Expression, *, fades: bool = False
    ) -> Sequence[float] | None:
        """The numbers of many members at once; None where they have to be found one by one."""
        return self._at_once(part, expression, lambda many: many.of_part(expression.tree, part), fades=fades)

    def in_sequence(
        self, group: WrittenFamily[Any], part: Part[Any], expression: Expression
    ) -> Sequence[float] | None:
        """The same where each member is a sum of its neighbour and others, all of which the file gives."""
        if any(family_name(one) == group.name for one in (*self.given, *self.overrides)):
            return None
        return self._at_once(
            part, expression, lambda many: many.of_sequence(expression.tree, part, group.family)
        )

    def _at_once(
        self,
        part: Part[Any],
        expression: Expression,
        numbers: Callable[[Together], Any],
        *,
        fades: bool = False,
    ) -> Sequence[float] | None:
        """The ``numbers`` of many members."""
        if type(self.algebra) is not NumberAlgebra or part.count < MANY:
            return None
        if not self.problems.trusts(expression.tree):
            return None
        from lagrange_cli.spec.together import Together

        try:
            found = numbers(Together(self._scope, self._array, self.spec.sizes, fades=fades))
        except (NoMember, Unsound):
            return None
        return None if found is None else found.tolist()

    def _array(self, base: str) -> Any:
        """The values of a complete family of numbers in its shape, if all of them are known."""
        from lagrange_cli.spec.together import array_of

        if base not in self.arrays:
            for section, known in (("parameters", self.values), ("definitions", self.definitions)):
                family = self.spec.families.get(section, {}).get(base)
                if family is not None and (found := array_of(family, known)) is not None:
                    self.arrays[base] = found
        return self.arrays.get(base)

    def _scope(self, name: str) -> Value:
        base, _, component = name.partition(".")
        if base in self.values:
            return self.values[base]
        if base in self.unknown:
            raise Needs(base)
        if base in self.definitions:
            value = self.definitions[base]
            return value[COMPONENTS.index(component)] if component else value
        family = self.spec.families.get("parameters", {}).get(family_name(base))
        known = base in self.spec.definitions or base in names_of(self.spec.parameters)
        if known or family is None or self.problems.found:
            raise Unsound  # follows from a problem already noted
        raise NoMember(family.hint(base))

    def override(self, name: str) -> Any:
        """The number that something is given besides the file; None where a problem of the file has it
        unknown."""
        if name in self.given:
            return self.given[name]
        try:
            from lagrange_cli.spec.constants import builder

            tree = self.overrides[name]
            return self.algebra.finite(
                tree, builder([tree], self.spec, self._scope, self.algebra).build(tree)
            )
        except Unsound:  # follows from a problem of the file
            return None
        except ExpressionError as error:
            from lagrange_cli.spec.settable import wrong_usage

            raise wrong_usage(f"--set {name}={self.texts[name]}", error) from error

    def value(self, expression: Expression, where: str, builder: Builder | None = None) -> Any:
        """The number, or None where there is none, which is noted at its place."""
        try:
            if not self.problems.trusts(expression.tree):
                return None
            builder = builder or self.builder
            value = builder.build(expression.tree, expression.indices)
            return self.algebra.finite(expression.tree, value, fades=builder.fades)
        except Unsound:
            return None
        except ExpressionError as error:
            self.blame(expression, error, where)
            return None

    def blame(self, expression: Expression, error: ExpressionError, where: str) -> None:
        """Note a problem of the file, unless the command line is what caused it."""
        causes = {family_name(name): name for name in self.overrides}
        pending = [expression.tree]
        seen: set[str] = set()
        while pending:
            for base in _bases(pending.pop()) - seen:
                seen.add(base)
                if base in causes:
                    name = causes[base]
                    raise UsageError(
                        f"--set {name}={self.texts[name]}: {error.message} in {where}; {error.hint}"
                    )
                pending += self.trees.get(base, ())
        self.problems.add_once(expression.at(error.span), f"{error.message} in {where}", error.hint)


def _bases(tree: Tree) -> set[str]:
    return {name.base for name in names(tree)}

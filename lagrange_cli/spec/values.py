"""The numbers of a run: parameters, masses and the initial state, with ``--set`` applied."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.errors import Problem, SpecError, UsageError
from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.build import build
from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.numbers import NumberAlgebra, evaluate
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.syntax import ExpressionError, Span, Tree, names
from lagrange_cli.expression.vocabulary import COMPONENTS, CONSTANTS, velocity_name
from lagrange_cli.records import dataclass
from lagrange_cli.spec.order import chain, dependency_order
from lagrange_cli.spec.source import Place, Source
from lagrange_cli.spec.spec import Expression, Spec


@dataclass(frozen=True)
class Values:
    """Parameters by name, and the initial state: ``q`` and ``v`` in the order of the coordinates."""

    parameters: Mapping[str, float]
    q: tuple[float, ...]
    v: tuple[float, ...]


def resolve_values(spec: Spec, overrides: Mapping[str, str] | None = None) -> Values:
    """The numbers ``spec`` is run with; ``overrides`` are those of ``--set``, name to expression.

    Raises:
        UsageError: an override of an unknown name, or one that cannot be evaluated.
        SpecError: everything in the file that has no finite value, a mass that is not positive, or an
            initial value that is missing.
    """
    run = _Run(spec, overrides or {})
    run.parameters()
    run.constants()
    run.masses()
    q = [run.initial(coordinate.name, coordinate.initial, None) for coordinate in spec.coordinates]
    v = [
        run.initial(velocity_name(coordinate.name), coordinate.velocity, 0.0)
        for coordinate in spec.coordinates
    ]
    for coordinate, value in zip(spec.coordinates, q, strict=True):
        if value is None:
            run.add(
                coordinate.place,
                f"coordinate '{coordinate.name}' has no initial value",
                f"write {coordinate.name}: {{initial: 0.1}}, or --set {coordinate.name}=0.1",
            )
    run.stop_if_any()
    return Values(run.values, tuple(x or 0.0 for x in q), tuple(x or 0.0 for x in v))


def resolve_parameters(spec: Spec, overrides: Mapping[str, str] | None = None) -> dict[str, float]:
    """The parameters alone, in the file's terms; masses are checked too, the initial state is not.

    Raises:
        UsageError, SpecError: as ``resolve_values``.
    """
    run = _Run(spec, overrides or {})
    run.parameters()
    run.constants()
    run.masses()
    run.stop_if_any()
    return run.values


class _Run:
    """One evaluation: the values so far, and the problems found."""

    def __init__(self, spec: Spec, overrides: Mapping[str, str]) -> None:
        self.spec = spec
        self.source = Source(spec.filename, spec.text)
        self.problems: list[Problem] = []
        self.texts = overrides
        self.overrides = {name: self._parsed(name, text) for name, text in overrides.items()}
        self.trees: dict[str, Tree] = {name: one.tree for name, one in spec.definitions.items()}
        self.trees |= {one.name: self.overrides.get(one.name, one.value.tree) for one in spec.parameters}
        self.values: dict[str, float] = {}
        self.definitions: dict[str, Value] = {}

    def add(self, place: Place, message: str, hint: str) -> None:
        self.problems.append(self.source.problem(place, message, hint))

    def stop_if_any(self) -> None:
        if self.problems:
            raise SpecError(self.spec.filename, self.problems)

    def _parsed(self, name: str, text: str) -> Tree:
        parameters = [parameter.name for parameter in self.spec.parameters]
        coordinates = [coordinate.name for coordinate in self.spec.coordinates]
        settable = [*parameters, *coordinates, *map(velocity_name, coordinates)]
        if name not in settable:
            hint = near_hint(name, settable) or known_hint(settable)
            raise UsageError(f"--set {name}={text}: unknown name '{name}'; {hint}")
        try:
            tree = parse(text)
            for one in names(tree):
                if one.identifier not in parameters and one.identifier not in CONSTANTS:
                    special = one.identifier.lower() in ("nan", "inf", "infinity")
                    raise ExpressionError(
                        one.span,
                        f"'{one.identifier}' is not a finite number"
                        if special
                        else f"unknown name '{one.identifier}'",
                        "write a number"
                        if special
                        else near_hint(one.identifier, parameters) or known_hint(parameters),
                    )
        except ExpressionError as error:
            raise _usage(name, text, error) from error
        return tree

    def parameters(self) -> None:
        """Evaluate all of them; an override may change what depends on what."""
        given = {parameter.name: parameter.value for parameter in self.spec.parameters}
        order, cycles = dependency_order({name: _bases(self.trees[name]) for name in given})
        for cycle in cycles:
            name = next((one for one in cycle if one in self.overrides), cycle[0])
            raise UsageError(f"--set {name}={self.texts.get(name, '')}: depends on itself: {chain(cycle)}")
        for name in order:
            if name in self.overrides:
                self.values[name] = self._override(name)
            else:
                value = self._value(given[name], f"parameter '{name}'")
                if value is not None:
                    self.values[name] = value
        self.stop_if_any()
        self.values = {name: self.values[name] for name in given}

    def constants(self) -> None:
        """Evaluate those definitions that masses and initial values use: they are made of parameters only."""
        users = [*self.spec.masses.values()]
        users += [x for one in self.spec.coordinates for x in (one.initial, one.velocity) if x is not None]
        needed = {name for user in users for name in _bases(user.tree)}
        for name, definition in reversed(list(self.spec.definitions.items())):
            if name in needed:
                needed |= _bases(definition.tree)
        for name, definition in self.spec.definitions.items():
            if name in needed:
                try:
                    self.definitions[name] = build(definition.tree, self._scope, NumberAlgebra())
                except ExpressionError as error:
                    self._blame(definition, error, f"definition '{name}'")
        self.stop_if_any()

    def masses(self) -> None:
        """Check that each is greater than 0."""
        for particle, mass in self.spec.masses.items():
            value = self._value(mass, f"mass of '{particle}'")
            if value is not None and value <= 0:
                span = Span(0, len(mass.text))
                error = ExpressionError(span, f"the mass is {value:g}", "a mass must be greater than 0")
                self._blame(mass, error, f"mass of '{particle}'")

    def initial(self, name: str, expression: Expression | None, default: float | None) -> float | None:
        """The initial value of the coordinate or velocity ``name``, or ``default`` where none is given."""
        if name in self.overrides:
            return self._override(name)
        if expression is None:
            return default
        value = self._value(expression, f"initial value of '{name}'")
        return 0.0 if value is None else value

    def _scope(self, name: str) -> Value:
        base, _, component = name.partition(".")
        if base in self.values:
            return self.values[base]
        value = self.definitions[base]
        return value[COMPONENTS.index(component)] if component else value

    def _override(self, name: str) -> float:
        try:
            return evaluate(self.overrides[name], self._scope)
        except ExpressionError as error:
            raise _usage(name, self.texts[name], error) from error

    def _value(self, expression: Expression, where: str) -> float | None:
        """The number, or None where there is none, which is noted at its place."""
        if _bases(expression.tree) - CONSTANTS - self.values.keys() - self.definitions.keys():
            return None  # follows from a problem already noted
        try:
            return evaluate(expression.tree, self._scope)
        except ExpressionError as error:
            self._blame(expression, error, where)
            return None

    def _blame(self, expression: Expression, error: ExpressionError, where: str) -> None:
        """Note a problem of the file, unless the command line is what caused it."""
        pending = [expression.tree]
        seen: set[str] = set()
        while pending:
            for base in _bases(pending.pop()) - seen:
                seen.add(base)
                if base in self.overrides:
                    raise UsageError(
                        f"--set {base}={self.texts[base]}: {error.message} in {where}; {error.hint}"
                    )
                if base in self.trees:
                    pending.append(self.trees[base])
        self.add(expression.at(error.span), f"{error.message} in {where}", error.hint)


def _bases(tree: Tree) -> set[str]:
    return {name.identifier.partition(".")[0] for name in names(tree)}


def _usage(name: str, text: str, error: ExpressionError) -> UsageError:
    return UsageError(f"--set {name}={text}: {error.message}" + (f"; {error.hint}" if error.hint else ""))

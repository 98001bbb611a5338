"""The section ``transformations`` of the system file: other coordinates, and what they replace."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.syntax import ExpressionError, Name, names
from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.records import dataclass
from lagrange_cli.spec import nodes
from lagrange_cli.spec.declarations import read_coordinates
from lagrange_cli.spec.draft import Declared, Draft, WrittenTransformation
from lagrange_cli.spec.fields import read_named, read_scalar
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.nodes import Node
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.readers import Entries
from lagrange_cli.spec.settling import check_scalar
from lagrange_cli.spec.spec import Coordinate, Expression, Transformation
from lagrange_cli.spec.table import Row, Table, read_table

TRANSFORMATION = Table(
    "transformation",
    (
        Row(
            "coordinates",
            read_coordinates,
            "the new coordinates: a list of names, or name -> `{initial, unit, description}`",
            also="new variables coords q to",
        ),
        Row(
            "replace",
            Entries(read_scalar, "replaced coordinate", "x: r*cos(phi)", "coordinate"),
            "coordinate of the file -> its value as an expression in the new coordinates, t and parameters",
            also="replaces old replaced where from with map subs substitute substitution "
            "substitutions expressions inverse equations",
        ),
    ),
)
EXAMPLE = "{coordinates: [r, phi], replace: {x: r*cos(phi), y: r*sin(phi)}}"


def read_transformations(node: Node, where: str, problems: Problems) -> tuple[WrittenTransformation, ...]:
    """Transformations: a mapping with the keys of ``TRANSFORMATION`` for each name."""
    hint, found = f"write 'transformations: {{polar: {EXAMPLE}}}'", []
    for name, key, value in read_named(node, "transformation", "transformations", hint, problems):
        label = f"transformation '{name.label}'"
        fields: dict[str, Any] = {}
        if name.axes:
            problems.add(key.place, f"{label} takes no index", f"write {name.name}: {EXAMPLE}")
        elif isinstance(value, nodes.Mapping):
            fields = read_table(value, TRANSFORMATION, label, problems)
            for needed in TRANSFORMATION.keys:
                if needed not in fields:
                    problems.add(key.place, f"{label} has no '{needed}'", f"write {name.text}: {EXAMPLE}")
        else:
            problems.add(value.place, f"{label} must be a mapping", f"write {name.text}: {EXAMPLE}")
        new, old = fields.get("coordinates", ()), fields.get("replace", ())
        if new and old:
            found.append(WrittenTransformation(name.name, key.place, name, key.passage, new, old))
        elif len(fields) == len(TRANSFORMATION.keys):
            problems.add(key.place, f"{label} replaces nothing", f"write {name.text}: {EXAMPLE}")
    return tuple(found)


def check_transformations(draft: Draft, known: Names, problems: Problems) -> dict[str, Transformation]:
    """The transformations by name; mistakes are added to ``problems``."""
    coordinates = [one.name for one in draft.declared("coordinates")]
    return {
        one.name: _Checker(one, known.copy(), problems).checked(coordinates) for one in draft.transformations
    }


@dataclass
class _Checker:
    written: WrittenTransformation
    names: Names
    problems: Problems

    def checked(self, coordinates: list[str]) -> Transformation:
        """The transformation of a system that has these coordinates."""
        written, label = self.written, f"transformation '{self.written.name}'"
        before = len(self.problems.found)
        declared = {family_name(one.name): one for one in reversed(written.coordinates)}
        self.names.declare_coordinates(
            [(name, one.place, written.families.get(name)) for name, one in reversed(declared.items())]
        )
        replaced: dict[str, Expression] = {}
        for entry in written.entries:
            if entry.name not in coordinates:
                hint = near_hint(entry.name, coordinates) or known_hint(coordinates)
                self.problems.add_once(
                    entry.place, f"{label} replaces '{entry.name}', which is not a coordinate", hint
                )
            elif entry.value is not None:
                replaced[entry.name] = entry.value
        used: set[str] = set()
        for name, value in replaced.items():
            check_scalar(self.names, value, "transformations", f"'{name}' of {label}")
            used |= self._used(value, replaced)
        new, old = len(written.coordinates), len(replaced)
        if new != old and len(self.problems.found) == before:
            message = f"{label} replaces {_counted(old)} by {_counted(new)}"
            self.problems.add(written.place, message, "give as many new coordinates as are replaced")
        for name, one in reversed(declared.items()):
            if name not in used and len(self.problems.found) == before:
                message = f"no coordinate of the file depends on the new coordinate '{name}' of {label}"
                self.problems.add(one.place, message, "use it under 'replace', or leave it out")
        made = tuple(self._coordinate(one) for one in written.coordinates)
        return Transformation(made, replaced, written.families, written.place)

    def _used(self, value: Expression, replaced: Mapping[str, Expression]) -> set[str]:
        """The names that an expression uses; what is replaced cannot be used."""
        found = set()
        for name in names(value.tree):
            meaning = self.names.table.get(name.base)
            found.add(name.base)
            try:
                if meaning is not None and meaning.what is Kind.DEFINITION:
                    hint = "write it out in the new coordinates, t and parameters"
                    raise ExpressionError(name.span, f"the definition '{name.base}' cannot be used", hint)
                if meaning is not None and meaning.what is Kind.COORDINATE and _replaced(name, replaced):
                    message = f"'{name.identifier}' is itself replaced and cannot be used"
                    own = [one.name for one in self.written.coordinates]
                    raise ExpressionError(name.span, message, known_hint(own))
            except ExpressionError as error:
                self.problems.add_expression(value, error, f"transformation '{self.written.name}'")
                break
        return found

    def _coordinate(self, one: Declared) -> Coordinate:
        """A new coordinate; its initial value is where the search for the true one begins."""
        fields, label = one.fields, f"coordinate '{one.key.label}' of transformation '{self.written.name}'"
        if fields.get("velocity") is not None:
            self.problems.add_once(
                one.place, f"the velocity of {label} follows from those of the file", "leave it out"
            )
        if fields.get("initial") is not None:
            check_scalar(self.names, fields["initial"], "coordinates", f"initial of {label}")
        unit, description = fields.get("unit", ""), fields.get("description", "")
        return Coordinate(one.name, one.place, fields.get("initial"), None, unit, description)


def _replaced(name: Name, replaced: Mapping[str, Expression]) -> bool:
    """Whether it stands for a coordinate that is replaced, as far as its indices are seen."""
    if not name.indices:
        return name.identifier in replaced
    return any(family_name(one) == name.base for one in replaced)


def _counted(count: int) -> str:
    return f"{count} coordinate{'' if count == 1 else 's'}"

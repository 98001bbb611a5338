"""The readers of sections that have an expression for each name.

Only the form is checked here. ``spec.check`` looks up the names.
"""

from __future__ import annotations

from lagrange_cli.expression.syntax import Key
from lagrange_cli.records import dataclass
from lagrange_cli.spec import nodes
from lagrange_cli.spec.draft import Entry
from lagrange_cli.spec.fields import Reader, read_key, read_scalar
from lagrange_cli.spec.nodes import Node, Scalar
from lagrange_cli.spec.problems import Problems


@dataclass(frozen=True)
class Entries:
    """The reader of a section ``name: expression``, each expression read by ``value``.

    In messages an entry is a ``what``, and its expression ``label`` and the name; ``example`` is an entry.
    The names may be ``free`` texts, and stand for ``families``; expressions may have ``several`` components.
    """

    value: Reader
    what: str
    example: str
    label: str
    free: bool = False
    families: bool = True
    several: bool = False

    def __call__(self, node: Node, where: str, problems: Problems) -> tuple[Entry, ...]:
        if isinstance(node, Scalar) and node.empty:
            return ()
        if not isinstance(node, nodes.Mapping):
            hint = f"write '{where}: {{{self.example}}}'"
            problems.add(node.place, f"{where} must be a mapping with a name for each {self.what}", hint)
            return ()
        found = []
        for key, inner in (nodes.continued(node) if self.several else node).entries:
            name = Key(key.text, key.text) if self.free else read_key(key, problems, self.what, self.families)
            if name is not None:
                expression = self.value(inner, f"{self.label} '{name.label}'", problems)
                found.append(Entry(name.name, key.place, name, key.passage, expression))
        return tuple(found)


@dataclass(frozen=True)
class Single:
    """The reader of a section that is one expression: an entry with the section's own name."""

    what: str

    def __call__(self, node: Node, where: str, problems: Problems) -> tuple[Entry, ...]:
        name, value = Key(self.what, self.what), read_scalar(node, where, problems)
        return (Entry(self.what, node.place, name, None, value),)


@dataclass(frozen=True)
class Terms:
    """The reader of a section that is one expression, or a mapping of terms to be summed."""

    what: str

    def __call__(self, node: Node, where: str, problems: Problems) -> tuple[Entry, ...]:
        if isinstance(node, nodes.Mapping):
            several = Entries(read_scalar, self.what, f"{self.what}: ...", self.what, free=True)
            return several(node, where, problems)
        return Single(self.what)(node, where, problems)

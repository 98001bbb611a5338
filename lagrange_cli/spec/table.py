"""A mapping of the system file read by a table of its keys, a row each.

The tables themselves are beside what reads them: that of the whole file in ``spec.sections``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from functools import cached_property
from importlib import import_module
from typing import Any

from lagrange_cli.expression.confusions import KINETIC, elsewhere
from lagrange_cli.expression.near import known_hint, look_alike_hint, near_match, shown
from lagrange_cli.expression.vocabulary import VELOCITY_SUFFIX
from lagrange_cli.records import dataclass, field
from lagrange_cli.spec import nodes
from lagrange_cli.spec.fields import Reader, read_words
from lagrange_cli.spec.kinds import ANYTHING, Kind, Rule
from lagrange_cli.spec.nodes import Scalar
from lagrange_cli.spec.problems import Problems

SHORTEST = 3
"""The letters of an abbreviation."""
MISSPELT = 0.75
"""The part of its letters that a misspelt key has in common with the key: ``camera`` is no ``name``."""


@dataclass(frozen=True)
class Rare:
    """The reader of what few files have: the function ``name`` of a ``module`` of this package, which is
    imported when it reads."""

    module: str
    name: str

    def loaded(self) -> Callable[..., Any]:
        """The function itself."""
        function: Callable[..., Any] = getattr(import_module(f"{__package__}.{self.module}"), self.name)
        return function

    def __call__(self, *given: Any) -> Any:
        return self.loaded()(*given)


@dataclass(frozen=True)
class Row:
    """One key: what it means, and how its value is read and checked.

    ``meaning`` is its line in the documentation, in Markdown. ``alias`` is a second word for the same key,
    ``also`` has words that other programs use for it: a message names the key for them.

    The rest concerns keys with expressions. ``label`` stands before an entry's name in messages ("force on").
    ``rule`` says what the expressions may depend on; each is a ``vector`` like its particle's position, or a
    scalar, or a vector that stands for ``several`` scalars. ``of`` is what the entries' names must belong
    to, None where an entry declares a name. ``family`` is "all" where each member of a family must be given,
    "some" where some may be, and empty where there are no families. A ``force`` is one of the keys that add
    to the generalized forces (see ``model.forces``).
    """

    key: str
    read: Reader
    meaning: str = ""
    alias: str = ""
    also: str = ""
    label: str = ""
    rule: Rule = ANYTHING
    vector: bool = False
    several: bool = False
    of: Kind | None = None
    family: str = ""
    force: bool = False


@dataclass(frozen=True)
class Table:
    """The keys of one kind of mapping: the file itself (``name`` is empty), a coordinate, ``solve``, ...

    ``hints`` are for words that no key alone can replace: each hint, and the words that it is for.
    """

    name: str
    rows: tuple[Row, ...]
    hints: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def by_word(self) -> dict[str, Row]:
        """The rows by their keys, and by the aliases of these."""
        return {word: row for row in self.rows for word in (row.key, row.alias) if word}

    @cached_property
    def lists(self) -> frozenset[str]:
        """The keys whose values are lists of words."""
        return frozenset(word for word, row in self.by_word.items() if row.read is read_words)

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys."""
        return tuple(row.key for row in self.rows)

    def key_of(self, word: str) -> str:
        """The key that a word of the file is; an unknown word as it is."""
        return self.by_word[word].key if word in self.by_word else word

    def meant(self, word: str) -> tuple[str, str]:
        """The key that another program calls ``word``, and a hint; nothing where there is none."""
        for row in self.rows:
            if word in row.also.split():
                nearer = row.alias if row.alias.startswith(word) else row.key
                return row.key, f"write '{nearer}'"
        hint = next((hint for hint, words in self.hints.items() if word in words.split()), "")
        return "", hint or (elsewhere(word) if not self.name else "")

    def near(self, word: str) -> str:
        """The key that a word misspells or abbreviates; nothing where it may be another word."""
        begun = {row.key for known, row in self.by_word.items() if known.startswith(word)}
        if len(word) >= SHORTEST and len(begun) == 1:
            return begun.pop()
        return self.key_of(near_match(word, self.by_word, MISSPELT))

    def read_as(self, word: str) -> str:
        """The key that a word of the file is read as, right or wrong; nothing where it is none."""
        if word in self.by_word:
            return self.by_word[word].key
        meant, hint = self.meant(word)
        return meant if hint else self.near(word)


def read_table(node: nodes.Mapping, table: Table, where: str, problems: Problems) -> dict[str, Any]:
    """Each key by the reader its row has for it; an unknown one as the key that was probably meant."""
    found: dict[str, Any] = {}
    node = nodes.continued(node, table.lists)
    written = {table.key_of(key.text) for key, _ in node.entries}
    above = ""
    for key, value in node.entries:
        name = table.key_of(key.text)
        if name not in table.by_word:
            name = _unknown_key(key, table, where, written, above, problems)
            if name in written:
                name = ""
            if not name and isinstance(value, nodes.Mapping):  # what it declares may be used elsewhere
                problems.broken |= {inner.text.partition("[")[0].strip() for inner, _ in value.entries}
        elif name in found:
            message = f"'{name}' and '{table.by_word[name].alias}' are two words for the same section"
            problems.add(key.place, message, "leave one of them out")
            found[name] += table.by_word[name].read(value, key.text, problems)
            name = ""
        if key.text in table.by_word:
            above = key.text if isinstance(value, Scalar) and value.empty else ""
        if name:
            label = key.text if key.text in table.by_word else name
            read = table.by_word[name].read
            found[name] = read(value, f"{label} of {where}" if where else label, problems)
    return found


def read_part(
    table: Table, node: nodes.Node, where: str, problems: Problems, hint: str = ""
) -> Mapping[str, Any]:
    """A mapping with the keys of ``table``, which may be left empty."""
    if isinstance(node, Scalar) and node.empty:
        return {}
    if not isinstance(node, nodes.Mapping):
        problems.add(node.place, f"{where} must be a mapping", hint or known_hint(table.keys))
        return {}
    return read_table(node, table, where, problems)


def _unknown_key(
    key: Scalar, table: Table, where: str, written: Collection[str], above: str, problems: Problems
) -> str:
    """Report an unknown key. Returns the key that was meant, or nothing. ``written`` are the keys that there
    are, ``above`` is the known one before it if that has no value."""
    text = key.text
    name, equals, rest = (part.strip() for part in text.partition("=" if "=" in text else ":"))
    begun = re.match(r"(\w+)\s*:?\s*([{[].*)", text)
    if begun and begun[1] in table.by_word:  # masses {bob: 1}
        problems.broken |= {*re.findall(r"[^\W\d]\w*", begun[2])}
        rest = key.passage.source.line(key.place.line - 1).partition(begun[1])[2].lstrip(" :")
        meant, hint = "", f"write '{begun[1]}: {rest.strip()}', with a colon and a space"
    elif equals and name in table.by_word:
        meant, hint = "", f"write {name}: {rest}" + (", with a space" if equals == ":" else "")
    elif not table.name and "lagrangian" in written and is_energy(text, table):
        problems.broken.add(text)
        meant, hint = "", f"write it under 'definitions', as in 'definitions: {{{text}: ...}}'"
    elif "velocity" in table.keys and text.endswith((VELOCITY_SUFFIX, "dot", "'")):
        meant, hint = "velocity", "write 'velocity'"
    else:
        meant, hint = table.meant(text)
        if above and hint:
            problems.broken.add(text)
            meant, hint = "", f"{hint}, or indent it, if it belongs to '{above}'"
    if not hint:
        meant = table.near(text)
        near = look_alike_hint(text, table.keys) or f"did you mean '{meant}'?"
        hint = near if meant else known_hint(table.keys)
        if above and not meant:
            problems.broken.add(text)  # it may be used elsewhere
            hint = f"indent it, if it belongs to '{above}'"
    problems.add(key.place, f"unknown key {shown(text)}{f' in {where}' if where else ''}", hint)
    return meant


def is_energy(word: str, table: Table) -> bool:
    """Whether it is what T or U is called elsewhere, each of which is a part of L."""
    return table.meant(word)[0] == "potential" or elsewhere(word) == KINETIC

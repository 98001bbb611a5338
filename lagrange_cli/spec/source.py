"""The text of a system file, places in it, and expressions that stand there."""

from __future__ import annotations

import re
from collections.abc import Mapping

from lagrange_cli.errors import Problem, SpecError
from lagrange_cli.expression.syntax import Span, Tree
from lagrange_cli.records import dataclass, field, replace

_LINE_BREAK = re.compile("\r\n|[\n\r\x85\u2028\u2029]")  # what YAML takes for the end of a line

HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
"""The first bytes of an HDF5 file, which is no system file."""


@dataclass(frozen=True)
class Place:
    """A stretch of a line of the file: ``line`` and ``column`` count from 1."""

    line: int
    column: int
    length: int = 1


_WRITTEN = re.compile(r"\S")
_CONTINUED = re.compile(r"\\\s*\Z")
_BLOCKS = ("|", ">")
_QUOTES = ("'", '"')
_ESCAPES = {"\\x": 4, "\\u": 6, "\\U": 10}
_FARTHEST = 10_000  # characters of one scalar that are told apart; no expression is longer

MAX_DEPTH = 20
TOO_DEEP = f"the file is nested more than {MAX_DEPTH} deep", "no section needs that"
WHOLE_FILE = Place(0, 0)
"""The place of a mistake that has no line of its own."""


class Source:
    """A system file's name, text and lines."""

    def __init__(self, filename: str, text: str) -> None:
        self.filename = filename
        self.text = text
        self.lines = tuple(_LINE_BREAK.split(text))

    def line(self, number: int) -> str:
        """A line of the file, counted from 0; empty beyond the last."""
        return self.lines[number] if number < len(self.lines) else ""

    def problem(self, place: Place, message: str, hint: str = "") -> Problem:
        """The problem with the line it is in."""
        excerpt = self.lines[place.line - 1] if 0 < place.line <= len(self.lines) else ""
        return Problem(place.line, place.column, message, place.length, hint, excerpt)

    def error(self, place: Place, message: str, hint: str = "") -> SpecError:
        """One problem as an error."""
        return SpecError(self.filename, [self.problem(place, message, hint)])


@dataclass(frozen=True)
class Passage:
    """A scalar of the file: its ``text`` as YAML reads it, and the stretch of the file it was read from.

    Lines and columns count from 0 here, as YAML's marks do. ``style`` is how the scalar begins: ``'``, ``"``,
    ``|``, ``>``, or nothing for a plain one.
    """

    source: Source
    text: str
    start: tuple[int, int]
    stop: tuple[int, int]
    style: str = ""

    def place(self, span: Span | None = None) -> Place:
        """Where ``span`` of the text (all of it by default) stands in the file, up to the end of its line."""
        first, after = (span.start, span.stop) if span else (0, len(self.text))
        line, end = self.stop
        start = end - len(self.text)
        if start >= 0 and self.source.line(line)[start:end] == self.text:  # all on one line as it is
            first = min(first, max(0, len(self.text) - 1))
            return Place(line + 1, start + first + 1, max(1, min(after, len(self.text)) - first))
        positions = self._positions(min(after, _FARTHEST))
        if not positions:
            return Place(self.start[0] + 1, self.start[1] + 1)
        line, column = positions[min(first, len(positions) - 1)]
        last = max((c for at, c in positions[first:] if at == line), default=column)
        return Place(line + 1, column + 1, max(1, last - column + 1))

    def _positions(self, count: int) -> list[tuple[int, int]]:
        """The line and column of each of the first ``count`` characters of the text.

        The file shows the same characters in the same order; between them are line breaks, indentation and
        escapes, which are walked over here as YAML folds them.
        """
        line, column = self._beginning()
        found: list[tuple[int, int]] = []
        for character in self.text[:count]:
            if not character.isspace():
                line, column = self._next_written(line, column)
            found.append((line, column))
            shown = self.source.line(line)[column : column + 1]
            if shown and (shown.isspace() or shown == "\\" or not character.isspace()):
                column += self._written_length(line, column)
        return found

    def _beginning(self) -> tuple[int, int]:
        line, column = self.start
        if self.style in _BLOCKS:
            return line + 1, 0
        if self.style in _QUOTES:  # perhaps after an anchor
            return line, self.source.line(line).find(self.style, column) + 1
        return line, column

    def _next_written(self, line: int, column: int) -> tuple[int, int]:
        """From here the first place that is neither white space nor a line break, escaped or not."""
        while line <= self.stop[0]:
            text = self.source.line(line)
            seen = _WRITTEN.search(text, column)
            if seen and not (self.style == '"' and _CONTINUED.match(text, seen.start())):
                return line, seen.start()
            line, column = line + 1, 0
        return self.stop

    def _written_length(self, line: int, column: int) -> int:
        """How many characters of the file stand for the one at this place."""
        written = self.source.line(line)[column : column + 2]
        if self.style == "'" and written == "''":
            return 2
        if self.style == '"' and written.startswith("\\"):
            return _ESCAPES.get(written, 2)
        return 1


@dataclass(frozen=True)
class Expression:
    """An expression: its text, its tree, and where in the file it stands.

    ``tree`` is a ``Vector`` (or a vector-valued tree) where a vector is due and scalar-valued otherwise:
    this has been checked, and every name in it is known. ``passages`` are the pieces of the file the text
    was put together from, each with its offset in ``text``. ``indices`` are the values of the indices that
    stand in it, where it is that of a member of a family. Parts of the tree may be from ``others``, whose
    texts are thought of as standing behind its own.
    """

    text: str
    tree: Tree
    place: Place
    passages: tuple[tuple[int, Passage], ...] = field(default=(), repr=False, compare=False)
    indices: Mapping[str, int] = field(default_factory=dict)
    others: str = field(default="", repr=False, compare=False)

    def at(self, span: Span) -> Place:
        """Where ``span`` of the text stands in the file."""
        for offset, passage in reversed(self.passages):
            if offset <= span.start:
                return passage.place(Span(span.start - offset, span.stop - offset))
        return self.place

    @property
    def whole(self) -> str:
        """The text, and those of others that parts of the tree are from."""
        return self.text + self.others

    def excerpt(self, span: Span) -> str:
        """What is written there."""
        return self.whole[span.start : span.stop]

    def followed_by(self, other: Expression) -> Expression:
        """The same with the text of another one behind it, so that its tree may have parts of that."""
        start = len(self.whole)
        passages = ((start + offset, passage) for offset, passage in other.passages)
        return replace(self, others=self.others + other.text, passages=(*self.passages, *passages))

    def member(self, name: str, indices: Mapping[str, int]) -> Expression:
        """The one of a member of a family."""
        return replace(self, indices=indices)

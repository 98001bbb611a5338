"""The text of a system file, and places in it."""

from __future__ import annotations

import re
from dataclasses import dataclass

from lagrange_cli.errors import Problem, SpecError
from lagrange_cli.expression.syntax import Span

_LINE_BREAK = re.compile("\r\n|[\n\r\x85\u2028\u2029]")  # what YAML takes for the end of a line


@dataclass(frozen=True)
class Place:
    """A stretch of a line of the file: ``line`` and ``column`` count from 1."""

    line: int
    column: int
    length: int = 1


WHOLE_FILE = Place(0, 0)
"""The place of a mistake that has no line of its own."""


class Source:
    """A system file's name, text and lines."""

    def __init__(self, filename: str, text: str) -> None:
        self.filename = filename
        self.text = text
        self.lines = tuple(_LINE_BREAK.split(text))

    def problem(self, place: Place, message: str, hint: str = "") -> Problem:
        """The problem with the line it is in."""
        excerpt = self.lines[place.line - 1] if 0 < place.line <= len(self.lines) else ""
        return Problem(place.line, place.column, message, place.length, hint, excerpt)

    def error(self, place: Place, message: str, hint: str = "") -> SpecError:
        """That one problem as an error."""
        return SpecError(self.filename, [self.problem(place, message, hint)])


@dataclass(frozen=True)
class Passage:
    """A scalar of the file: its ``text`` as YAML reads it, and the stretch of the file it was read from.

    Lines and columns count from 0 here, as YAML's marks do; ``block`` is a text after ``|`` or ``>``.
    """

    source: Source
    text: str
    start: tuple[int, int]
    stop: tuple[int, int]
    block: bool = False

    def place(self, span: Span | None = None) -> Place:
        """Where ``span`` of the text (all of it by default) stands in the file, up to the end of its line."""
        positions = self._positions()
        if not positions:
            return Place(self.start[0] + 1, self.start[1] + 1)
        first = min(span.start if span else 0, len(positions) - 1)
        last = min(max(span.stop if span else len(positions), first + 1), len(positions)) - 1
        line, column = positions[first]
        while positions[last][0] > line:
            last -= 1
        return Place(line + 1, column + 1, max(1, positions[last][1] - column + 1))

    def _positions(self) -> list[tuple[int, int]]:
        """The line and column of each character of the text.

        The file shows the same characters in the same order, with quotes, escapes, indentation and folded
        line breaks between them: so each is looked for from where the last one was found.
        """
        line, column = self._beginning()
        found: list[tuple[int, int]] = []
        for character in self.text:
            if character.isspace():
                found.append((line, column))
                if self._character(line, column).isspace():
                    column += 1
                continue
            seen = self._find(character, line, column)
            if seen is None:  # written as an escape
                found.append((line, column))
                continue
            found.append(seen)
            line, column = seen[0], seen[1] + 1
        return found

    def _beginning(self) -> tuple[int, int]:
        line, column = self.start
        if self.block:
            return line + 1, 0
        end_line, end = self.stop
        if self.source.lines[end_line][max(0, end - len(self.text)) : end] == self.text:
            return end_line, end - len(self.text)  # plain, on one line, perhaps after an anchor
        return line, column

    def _character(self, line: int, column: int) -> str:
        text = self.source.lines[line] if line < len(self.source.lines) else ""
        return text[column : column + 1]

    def _find(self, character: str, line: int, column: int) -> tuple[int, int] | None:
        while line <= self.stop[0] and line < len(self.source.lines):
            seen = self.source.lines[line].find(character, column)
            if seen >= 0 and (line, seen) < self.stop:
                return line, seen
            line, column = line + 1, 0
        return None

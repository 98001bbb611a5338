"""The messages for text that is not YAML, with the place of the mistake and a way out."""

from __future__ import annotations

import re

import yaml

from lagrange_cli.errors import SpecError
from lagrange_cli.spec.source import TOO_DEEP, WHOLE_FILE, Place, Source

_SPACES = "replace each tab by spaces"
_COMMENTED = re.compile(r"[:,[]\s(#[0-9a-fA-F]{3,6})\b[^\s#]*$")
"""A colour at the end of a line, which YAML takes for a comment."""
_CLOSING = re.compile(r"expected ',' or '([]}])'")
_KEY = re.compile(
    r"(?P<indentation> *)(?P<name>\w+)(?:(?P<colon>:)(?=\s|$)|\s*[=:])?"
    r"\s*(?P<value>[^#]*?)\s*(?:#.*)?$"
)
"""A line with a key, or with a possible key."""
_NESTED = re.compile(r"(\w+): +(\w+)$")
"""Two keys in a row, before a second colon."""
_TWO_VALUES = re.compile(r"""[:,{\[]\s+[^:,{}\[\]]+\s(\w+)$|[}\]"']\s*$""")
"""What is before the colon of a second key, or before a second value, where no comma separates them."""
_STRANGE_SPACE = re.compile("[\u00a0\u1680\u2000-\u200a\u202f\u205f\u3000]")
"""A space that YAML takes for a letter, such as one that keeps words together."""
_LONGEST = 200
"""The number of characters of a line that are searched for it."""
_HINTS: tuple[tuple[str, str], ...] = (
    ("tab character", _SPACES),
    ("'\\t'", _SPACES),
    ("cannot start any token", "put the text in quotes"),
    ("mapping values are not allowed", "write 'key: value', one per line, with equal indentation"),
    ("',' or ']'", 'put each item that has [ ] { } or a comma in quotes, or write a vector as "(x, y)"'),
    ("',' or '}'", "put each value that has [ ] { } or a comma in quotes, or write one key per line"),
    ("alphabetic or numeric character", "put the text in quotes: it begins with '*' or '&'"),
    ("undefined alias", "put the text in quotes: in YAML a leading '*' means an alias"),
    ("could not find expected ':'", "write 'key: value', one per line"),
    ("expected ':'", "write 'key: value', one per line"),
    ("expected key", "indent all keys of a section equally"),
    ("<block end>", "indent all keys of a section equally"),
    ("'-' indicator", "indent all items of a list equally, each after '- '"),
    ("<document start>", "leave out the line '...', which ends the file"),
    ("end of stream", "close what was opened: a quote, a bracket or a brace"),
    ("comment or line break", "write abs(x) for |x|; a text of several lines begins below the | or >"),
    ("escape character", "use single quotes, where a backslash means itself"),
    ("node content", "leave the bracket out or put the text in quotes"),
    (
        "sequence entries",
        "put each '- item' on a line of its own; for a minus sign leave out the space after it",
    ),
)


def translated(source: Source, error: yaml.YAMLError) -> SpecError:
    """The error of YAML's parser as that of a system file."""
    mark = getattr(error, "problem_mark", None)
    problem = getattr(error, "problem", None)
    if mark is None or problem is None:
        return source.error(WHOLE_FILE, f"YAML syntax error: {error}", "a system file is text in UTF-8")
    if "nesting depth" in problem:  # the parser's own bound, which is larger
        return source.error(Place(mark.line + 1, mark.column + 1), *TOO_DEEP)
    context, opened = getattr(error, "context", None), getattr(error, "context_mark", None)
    line, column = min(mark.line, len(source.lines) - 1), mark.column
    if line < mark.line:  # behind a last line without an end
        column = len(source.lines[line])
    while line > 0 and not source.lines[line].strip():  # the end of the file: show the last line there is
        line -= 1
        column = len(source.lines[line])
    character = source.lines[line][column : column + 1]
    sought = f"{problem} {character!r}" if character == "\t" else problem
    hint = next((hint for words, hint in _HINTS if words in sought), "check the indentation and the quotes")
    if "mapping values" in problem and re.match(r"[^:]*: +\S", source.lines[line][:column]):
        problem, hint = (
            "a second ': ' in a line",
            "put a text with ': ' in quotes, or write one 'key: value' per line",
        )
    if "cannot start any token" in problem and character != "\t":
        context, problem = None, f"no text can begin with {character!r}"
    closing = _CLOSING.search(problem)
    if closing and character and character in "]}" and character != closing[1]:
        hint = f"write '{closing[1]}' before this '{character}'"
    elif closing and not character and opened is not None and opened.line == line:
        hint = f"write '{closing[1]}' at the end: what column {opened.column + 1} opens is not closed"
    elif closing and (apart := _TWO_VALUES.search(source.lines[line][:column][-_LONGEST:])):
        hint = _comma_missing(apart, source.lines[line][column:]) or hint
    misplaced = "mapping values" in problem or "could not find expected ':'" in problem
    if misplaced and (cause := _line_before(source, line)):
        line, column, problem, hint = cause
        context = None
    nested = _NESTED.search(source.lines[line][:column][-_LONGEST:]) if character == ":" else None
    if nested and "',' or '}'" in problem:
        hint = f"put what belongs to '{nested[1]}' in braces, as in {nested[1]}: {{{nested[2]}: ...}}"
    if problem.startswith("did not find expected ',' or") and source.lines[line][column:].startswith("for "):
        hint = "put the item with its loop in quotes, or write its list in parentheses: (a, b) for i in ..."
    if context and "flow" in context and opened is not None and opened.line < line:
        bracket = source.lines[opened.line][opened.column]
        hint = f"the '{bracket}' of line {opened.line + 1} is still open: close it, or write a comma"
        line_of_it = source.lines[opened.line]
    elif context and "quoted" in context and opened is not None and "end of stream" in problem:
        line, column, context, problem = opened.line, opened.column, None, "a quote is not closed"
        line_of_it = source.lines[line]
        hint = f"add a {line_of_it[column]} where the text ends"
    else:
        line_of_it = source.lines[line]
    if colour := _COMMENTED.search(line_of_it[:_LONGEST]):
        hint = f"put '{colour[1]}' in quotes: without them a # begins a comment"
    message = f"YAML syntax error: {context + ', ' if context else ''}{problem}"
    if hint == _SPACES:
        message = "a tab where YAML expects spaces"
    elif strange := _strange_space(source, line):
        line, column = strange
        name = f"U+{ord(source.lines[line][column]):04X}"
        message, hint = f"the character {name} where YAML expects a space", "replace it by a space"
    return source.error(Place(line + 1, column + 1), message, hint)


def _comma_missing(before: re.Match[str], rest: str) -> str:
    """The hint where a second key or value begins without a comma; nothing where that is not sure."""
    if not rest:
        return ""
    if not before[1]:
        return f"write a comma before '{re.split('[^a-zA-Z0-9_]', rest)[0] or rest[0]}'"
    if not rest.startswith(":"):
        return ""
    return "write ',' in place of ';'" if ";" in before[0] else f"write a comma before '{before[1]}'"


def _strange_space(source: Source, line: int) -> tuple[int, int] | None:
    """Where the line of a mistake, or the last one before it, has a space that is none to YAML."""
    before = next((i for i in range(line - 1, -1, -1) if source.lines[i].strip()), line)
    for number in (before, line):
        if found := _STRANGE_SPACE.search(source.lines[number]):
            return number, found.start()
    return None


def _line_before(source: Source, line: int) -> tuple[int, int, str, str] | None:
    """The mistake in the line before one in which YAML does not expect a key: line, column, message and hint.

    YAML takes ``g = 9.81`` for a text that goes on in the next line.
    """
    own = source.lines[line]
    before = next((i for i in range(line - 1, -1, -1) if source.lines[i].strip()), -1)
    if before < 0 or not (key := _KEY.match(source.lines[before][:_LONGEST])):
        return None
    indentation = len(own) - len(own.lstrip())
    column = len(key["indentation"])
    if not key["colon"] and column >= indentation:
        hint = f"write '{key['name']}: {key['value'] or '...'}', with a space after the colon"
        return before, column, "missing ': '", hint
    indented = _KEY.match(own[:_LONGEST])
    if (
        indented
        and indented["colon"]
        and key["colon"]
        and key["value"]
        and len(key["indentation"]) < indentation
    ):
        hint = f"indent it like line {before + 1}, which has a value of its own"
        return line, indentation, "unexpected indentation", hint
    return None

"""YAML text to plain nodes: each scalar is its text and its place, and nothing is guessed from it.

PyYAML's parser (libyaml's, where it is there) gives events; the nodes are put together here, so that
nesting, size and the growth by aliases are bounded, duplicate keys are found, and ``no``, ``y`` or ``1e-3``
remain what was written.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Container, Iterator
from typing import Any, TypeAlias

import yaml

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.near import shown
from lagrange_cli.limits import way_out, whole
from lagrange_cli.records import dataclass
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import HDF5_SIGNATURE, MAX_DEPTH, TOO_DEEP, WHOLE_FILE, Passage, Place, Source

MAX_BYTES = whole("bytes")
MAX_NODES = whole("values")
_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_BINARY = "the file is binary, not text"
_EXAMPLE = "'lagrange systems pendulum' shows an example"
_NOT_YAML = "[^\t\x20-\x7e\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"
"""Compiled only for files that have characters that do not print: it takes longer than to read most files."""
_INDEXED = re.compile(r"(?<=\w)\[[^][\n]*\]")
_LOOKUPS = 8
"""How deep the brackets of indices may be in one another, as in ``x[a[n]]``."""
_KEY = re.compile(r"[^\W\d]\w*(?:\s*(?:\[|=|$)|\s+\w)")
"""What a key begins with, right or wrong: a name, a family, ``name=value``, or words."""
_GUARDED = {ord("["): 0xE000, ord("]"): 0xE001, ord(","): 0xE002}  # to characters without a meaning
_UNGUARDED = {own: sign for sign, own in _GUARDED.items()}


@dataclass(frozen=True)
class Scalar:
    """A text; ``plain`` if without quotes."""

    passage: Passage
    plain: bool
    size: int = 1

    @property
    def text(self) -> str:
        return self.passage.text

    @property
    def place(self) -> Place:
        return self.passage.place()

    @property
    def empty(self) -> bool:
        """Nothing was written, or one of YAML's words for it."""
        return self.plain and self.text in ("", "~", "null")


@dataclass(frozen=True)
class Sequence:
    """A list."""

    items: tuple[Node, ...]
    place: Place
    size: int


@dataclass(frozen=True)
class Mapping:
    """Keys and values in the file's order; no key is given twice."""

    entries: tuple[tuple[Scalar, Node], ...]
    place: Place
    size: int


Node: TypeAlias = Scalar | Sequence | Mapping


def decode(data: bytes | str, filename: str) -> Source:
    """The file's text, which must be UTF-8 without control characters and of a sensible size.

    Raises:
        SpecError: where it is not.
    """
    hint = "a system file is text in UTF-8"
    if isinstance(data, bytes) and data.startswith(HDF5_SIGNATURE):
        shown_by = "'plot', 'animate' and 'view' show outputs"
        raise _unreadable(filename, "the file is an HDF5 file, not a system file", shown_by)
    if len(data) > MAX_BYTES:
        raise _unreadable(
            filename, f"the file is larger than {MAX_BYTES} bytes", f"{hint}, {way_out('bytes')}"
        )
    try:
        text = data.decode("utf-8-sig") if isinstance(data, bytes) else data
        text.encode()
    except UnicodeError as error:
        if isinstance(data, bytes) and b"\0" in data and not data.startswith(_UTF_16):
            raise _unreadable(filename, _BINARY, hint) from error
        raise _not_utf8(data, filename, error) from error
    if "\0" in text:
        raise _unreadable(filename, _BINARY, hint)
    if not text.strip():
        raise _unreadable(filename, "the file is empty", _EXAMPLE)
    source = Source(filename, text.removeprefix("\ufeff"))
    for number, line in enumerate(source.lines, 1):
        if not line.isprintable() and (strange := re.search(_NOT_YAML, line)):
            raise source.error(
                Place(number, strange.start() + 1),
                f"the character {strange.group()!r} is not allowed in a text file",
                "delete it",
            )
    return source


def _unreadable(filename: str, message: str, hint: str) -> SpecError:
    return Source(filename, "").error(WHOLE_FILE, message, hint)


def _not_utf8(data: bytes | str, filename: str, error: UnicodeError) -> SpecError:
    """The error of a text in another encoding, at its first character that UTF-8 has not."""
    message, hint = "the file is not text in UTF-8", "save it in the encoding UTF-8"
    if isinstance(data, str) or data.startswith(_UTF_16) or not isinstance(error, UnicodeDecodeError):
        return _unreadable(filename, message, hint)
    before = data[: error.start].decode("utf-8-sig").splitlines(keepends=True) or [""]
    if before[-1].endswith("\n"):
        before.append("")
    source = Source(filename, data.decode("utf-8-sig", "replace"))
    return source.error(Place(len(before), len(before[-1]) + 1), message, hint)


def compose(source: Source, problems: Problems) -> Node:
    """The file's one document as a node.

    Raises:
        SpecError: where the text is not YAML, or passes the bounds.
    """
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        return _Composer(source, problems, loader).document()
    except yaml.YAMLError as error:
        from lagrange_cli.spec.yaml_errors import translated

        raise translated(source, error) from error


class _Composer:
    """Puts nodes together from the parser's events."""

    def __init__(self, source: Source, problems: Problems, loader: Any) -> None:
        self.source = source
        self.problems = problems
        # In [u[0], u[1]] or {initial: x[i]} YAML would take the brackets of an index for its own: while it
        # reads, other characters stand in their place.
        text, self.guarded = source.text, not any(chr(own) in source.text for own in _UNGUARDED)
        if self.guarded:
            for _ in range(_LOOKUPS):
                text, found = _INDEXED.subn(lambda match: match.group().translate(_GUARDED), text)
                if not found:
                    break
        self.events: Iterator[Any] = yaml.parse(text, Loader=loader)
        self.anchors: dict[str, Node] = {}
        self.size = 0

    def document(self) -> Node:
        root: Node | None = None
        for event in self.events:
            if isinstance(event, yaml.DocumentStartEvent):
                if root is not None:
                    raise self._error(
                        event, "a system file is one document", "put each system in its own file"
                    )
                root = self._node(next(self.events), 0)
        if root is None:
            raise _unreadable(self.source.filename, "the file is empty", _EXAMPLE)
        return root

    def _node(self, event: Any, depth: int) -> Node:
        if depth > MAX_DEPTH:
            raise self._error(event, *TOO_DEEP)
        if isinstance(event, yaml.AliasEvent):
            node = self.anchors.get(str(event.anchor))
            if node is None:
                raise self._error(
                    event,
                    f"'*{event.anchor}' is an unknown YAML alias",
                    "put the text in quotes: in YAML a leading '*' means an alias",
                )
            self._count(event, node.size)
            return node
        if event.tag is not None and event.tag != "!":
            raise self._error(event, "YAML tags are not supported", "leave out the word that begins with '!'")
        self._count(event, 1)
        node = self._fresh(event, depth)
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        return node

    def _fresh(self, event: Any, depth: int) -> Node:
        start, stop = event.start_mark, event.end_mark
        if isinstance(event, yaml.ScalarEvent):
            ends = (start.line, start.column), (stop.line, stop.column)
            text = event.value.translate(_UNGUARDED) if self.guarded else event.value
            passage = Passage(self.source, text, *ends, style=event.style or "")
            return Scalar(passage, plain=not event.style)
        before = self.size
        place = Place(start.line + 1, start.column + 1)
        children: list[Node] = []
        ending = yaml.SequenceEndEvent if isinstance(event, yaml.SequenceStartEvent) else yaml.MappingEndEvent
        while not isinstance(child := next(self.events), ending):
            children.append(self._node(child, depth + 1))
        if isinstance(event, yaml.SequenceStartEvent):
            items = self._rejoined(children) if event.flow_style else children
            return Sequence(tuple(items), place, 1 + self.size - before)
        pairs = list(zip(children[::2], children[1::2], strict=True))
        if event.flow_style:
            pairs = self._rejoined_pairs(pairs)
        return Mapping(tuple(self._entries(pairs)), place, 1 + self.size - before)

    def _entries(self, pairs: list[tuple[Node, Node]]) -> Iterator[tuple[Scalar, Node]]:
        seen: dict[str, Place] = {}
        for key, value in pairs:
            if not isinstance(key, Scalar):
                self.problems.add(key.place, "a key must be a name", "write 'name: value'")
            elif key.plain and key.text == "<<":
                self.problems.add(key.place, "merge keys are not supported", "write the keys out")
            elif key.text in seen:
                self.problems.add(
                    key.place,
                    f"the key {shown(key.text)} is given twice",
                    f"it is already in line {seen[key.text].line}",
                )
            else:
                seen[key.text] = key.place
                yield key, value

    def _rejoined(self, items: list[Node]) -> list[Node]:
        """``[atan2(y, x), 0]``: YAML splits at every comma, we only outside parentheses."""
        joined: list[Node] = []
        for item in items:
            last = joined[-1] if joined else None
            if _is_open(last) and isinstance(item, Scalar) and item.plain:
                assert isinstance(last, Scalar)
                joined[-1] = _join(last, item)
            else:
                joined.append(item)
        return joined

    def _rejoined_pairs(self, pairs: list[tuple[Node, Node]]) -> list[tuple[Node, Node]]:
        """``{bead: (x, y), ...}``: the pieces after the first come as keys without values, as do those of
        ``{bead: x, -y}`` and of a number with a decimal comma. In ``{at(1, 0): 2}``, those before the last
        do."""
        joined: list[tuple[Node, Node]] = []
        for key, value in pairs:
            if joined and isinstance(key, Scalar) and key.plain:
                name, last = joined[-1]
                if _is_bare(last) and _is_open(name):
                    assert isinstance(name, Scalar)
                    joined[-1] = _join(name, key), value
                    continue
                if _is_bare(value) and isinstance(last, Scalar) and (_is_open(last) or _goes_on(last, key)):
                    joined[-1] = name, _join(last, key)
                    continue
            joined.append((key, value))
        return joined

    def _count(self, event: Any, nodes: int) -> None:
        self.size += nodes
        if self.size > MAX_NODES:
            raise self._error(
                event,
                f"the file has more than {MAX_NODES} values with its aliases expanded",
                f"shorten it, {way_out('values')}",
            )

    def _error(self, event: Any, message: str, hint: str) -> SpecError:
        mark = event.start_mark
        return self.source.error(Place(mark.line + 1, mark.column + 1), message, hint)


def continued(node: Mapping, takes: Container[str] | None = None) -> Mapping:
    """``{bob: x, y}``: keys without values go on with the value before them, on the same line, where its key
    ``takes`` more than one (all do by default)."""
    joined: list[tuple[Scalar, Node]] = []
    for key, value in node.entries:
        name, last = joined[-1] if joined else (key, value)
        goes_on = joined and key.plain and _is_bare(value) and (takes is None or name.text in takes)
        if goes_on and isinstance(last, Scalar) and last.plain and last.text and _on_a_line(last, key):
            joined[-1] = name, _join(last, key)
        else:
            joined.append((key, value))
    return Mapping(tuple(joined), node.place, node.size)


def _on_a_line(first: Scalar, second: Scalar) -> bool:
    return first.passage.stop[0] == second.passage.start[0]


def _join(first: Scalar, second: Scalar) -> Scalar:
    (line, column), start = first.passage.stop, second.passage.start
    text = f"{first.text}{',' if start == (line, column + 1) else ', '}{second.text}"
    return Scalar(Passage(first.passage.source, text, first.passage.start, second.passage.stop), plain=True)


def _is_open(node: Node | None) -> bool:
    return isinstance(node, Scalar) and node.plain and node.text.count("(") > node.text.count(")")


def _goes_on(first: Scalar, second: Scalar) -> bool:
    """Whether a text without brackets goes on after a comma: ``bob: l*sin(a), -l*cos(a)``, ``step: 0,1``. The
    second piece is no key, then: that would begin with a letter, and have no operators but in an index."""
    return first.plain and first.text != "" and not _KEY.match(second.text)


def _is_bare(node: Node) -> bool:
    """Whether it is the value of a key without one."""
    return isinstance(node, Scalar) and node.empty and node.text == ""

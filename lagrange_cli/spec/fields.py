"""Nodes to values: a text, a number, an expression, a vector, a name. Only their form is judged here."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterator
from typing import Any

from lagrange_cli.expression.confusions import DEGREES, RADIANS
from lagrange_cli.expression.keys import parse_key
from lagrange_cli.expression.near import shown
from lagrange_cli.expression.numbers import evaluate
from lagrange_cli.expression.parse import read
from lagrange_cli.expression.quantities import is_unit, quantity
from lagrange_cli.expression.scan import WORDS
from lagrange_cli.expression.syntax import ExpressionError, Key, Number, Span, Tree, Vector, names
from lagrange_cli.expression.vocabulary import POINT, velocity_name
from lagrange_cli.spec import nodes
from lagrange_cli.spec.nodes import Node, Scalar
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Passage, Place
from lagrange_cli.spec.spec import Expression

_NOT_FINITE = frozenset({".nan", ".inf"})  # what YAML calls them; the plain words are unknown names
_FORTRAN = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)[dD][-+]?[0-9]+"

Reader = Callable[[Node, str, Problems], Any]
"""Reads the value of a key: the node, what to call it in messages, and where to put problems."""


def read_text(node: Node, where: str, problems: Problems) -> str:
    """A text, taken as it is written."""
    if not isinstance(node, Scalar):
        problems.add(node.place, f"{where} must be text", "put it in quotes if it has [ ] { } or ': '")
        return ""
    control = control_character(node.text)
    if control:
        name = "character NUL" if control == "\0" else f"control character U+{ord(control):04X}"
        problems.add(node.place, f"{where} contains the {name}", "leave it out")
        return ""
    return "" if node.empty else node.text.strip()


BREAKS, TURNS = "\u2028\u2029", "\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
"""Ends of lines, and what changes the direction of the text that follows, up to the end of the line."""


def control_character(text: str) -> str:
    """The first character that a terminal would obey instead of showing it; empty where there is none."""
    strange = ((c < " " and c not in "\n\t") or "\x7f" <= c <= "\x9f" or c in BREAKS + TURNS for c in text)
    return next((c for c, one in zip(text, strange) if one), "")


def read_scalar(node: Node, where: str, problems: Problems) -> Expression | None:
    """One expression; that its value is a scalar is checked later."""
    if isinstance(node, nodes.Mapping):
        axes = all(key.text in ("x", "y", "z") for key, _ in node.entries)
        hint = "write its components as a list: [x, y, z]" if axes else "write it on one line"
        drags = [
            (key.text, value.text.strip() or "c") for key, value in node.entries if isinstance(value, Scalar)
        ]
        if where == "dissipation" and drags:  # a coefficient for each coordinate, or particle
            name, drag = drags[0]
            hint = f"write {' + '.join(f'{drag}*{velocity_name(name)}**2/2' for name, drag in drags)}"
            hint += f"; for a particle, {drag}*({name}.vx**2 + {name}.vy**2)/2"
        elif not axes and len(node.entries) == 1 and isinstance(node.entries[0][1], Scalar):
            hint = f"write {node.entries[0][1].text.strip() or 'one expression'}"
        problems.add(node.place, f"{where} must be an expression, not a mapping", hint)
        return None
    if isinstance(node, nodes.Sequence):
        hint = "write one expression"
        if "[" in where:
            hint += ", as in x0[i] with 'parameters: {x0: [1, 2]}'"
        problems.add(node.place, f"{where} must be a scalar, not a vector", hint)
        return None
    return _parsed((node,), where, problems)


LONGEST_LIST = 40
"""Characters of a list that are shown in a hint."""


def read_list(node: Node, where: str, problems: Problems) -> Expression | tuple[Expression, ...] | None:
    """An expression, or a list of expressions."""
    if not isinstance(node, nodes.Sequence):
        if isinstance(node, Scalar) and len(node.text.split(",")) > 3 and "(" not in node.text:
            problems.add(node.place, f"{where} is a list without brackets", f"write [{node.text}]")
            return None
        return read_scalar(node, where, problems)
    if not node.items:
        problems.add(node.place, f"the list of {where} is empty", "write [1.0, 2.0]")
        return None
    if any(isinstance(item, nodes.Sequence) for item in node.items):
        inner = [one for item in node.items if isinstance(item, nodes.Sequence) for one in item.items]
        texts = ", ".join(one.text.strip() for one in inner if isinstance(one, Scalar))
        texts = texts if len(texts) <= LONGEST_LIST else f"{texts[:LONGEST_LIST]}..."
        width = max(len(item.items) for item in node.items if isinstance(item, nodes.Sequence))
        problems.add(
            node.place,
            f"{where} is a list of lists",
            f"write one list, [{texts}], whose item {width}*i + j is that of row i and column j",
        )
        return None
    items = [read_scalar(item, f"{where}, item {number}", problems) for number, item in enumerate(node.items)]
    found = tuple(item for item in items if item is not None)
    return found if len(found) == len(items) else None


def read_vector(node: Node, where: str, problems: Problems) -> Expression | None:
    """An expression, or a list of the one to three components of a vector."""
    if isinstance(node, Scalar) and (line := _item_without_space(node)):
        hint = f"write '- {line}', with a space after the '-' of an item; or write a sum on one line"
        problems.add(node.place, f"{where} is no list", hint)
        return unreadable(node.place, problems)
    if not isinstance(node, nodes.Sequence):
        return read_scalar(node, where, problems)
    if not 1 <= len(node.items) <= 3:
        problems.add(
            node.place, f"{where} must have one to three components, not {len(node.items)}", "write [x, y, z]"
        )
        return None
    scalars = [item for item in node.items if isinstance(item, Scalar)]
    for item in node.items:
        if not isinstance(item, Scalar):
            problems.add(item.place, f"a component of {where} must be an expression", "write [x, y, z]")
    return _parsed(scalars, where, problems, vector=True) if len(scalars) == len(node.items) else None


def _item_without_space(scalar: Scalar) -> str:
    """The first of several lines that all begin with ``-``, as of a list without the spaces after its ``-``,
    which YAML takes for one text; empty for any other text."""
    start, column = scalar.passage.start
    lines = scalar.passage.source.lines[start : scalar.passage.stop[0] + 1]
    if not scalar.plain or lines[0][:column].strip():
        return ""
    items = [line.strip() for line in lines if line.strip() and line[:column].strip() == ""]
    return items[0] if len(items) > 1 and all(item.startswith("-") for item in items) else ""


def _parsed(
    scalars: tuple[Scalar, ...] | list[Scalar], where: str, problems: Problems, vector: bool = False
) -> Expression | None:
    """The expression of one scalar, or the vector whose components are the scalars."""
    text = "(" if vector else ""
    passages: list[tuple[int, Passage]] = []
    trees: list[Tree] = []
    sound = True
    for scalar in scalars:
        if passages:
            text += ", "
        passages.append((len(text), scalar.passage))
        tree, errors = _tree(scalar, where, len(text))
        draft = Expression(scalar.text, tree, scalar.place, ((len(text), scalar.passage),))
        for error in errors:
            problems.add_expression(draft, error, where)
        sound = sound and not errors
        trees.append(tree)
        text += scalar.text
    text += (",)" if len(scalars) == 1 else ")") if vector else ""
    tree = Vector(tuple(trees), Span(0, len(text))) if vector else trees[0]
    if not sound:
        problems.distrust(tree)
    return Expression(text, tree, scalars[0].place, tuple(passages))


def _tree(scalar: Scalar, where: str, offset: int) -> tuple[Tree, list[ExpressionError]]:
    """What a scalar was probably meant to be, and all that is wrong with it."""
    text, span = scalar.text, Span(offset, offset + max(1, len(scalar.text)))
    unit = quantity(text)
    if scalar.empty:
        error = ExpressionError(span, "missing value", "write a number or an expression")
    elif text.lower().lstrip("+-") in _NOT_FINITE:
        error = ExpressionError(span, f"'{text}' is not a finite number", "write a number")
    elif re.fullmatch(_FORTRAN, text):
        number = re.sub("[dD]", "e", text)
        error = ExpressionError(span, f"unknown notation of a number: '{text}'", f"write {number}")
    elif unit and unit[1] not in DEGREES | RADIANS:
        error = ExpressionError(span, "number with a unit", _quantity_hint(*unit, where))
    else:
        return read(text, offset)
    return Number("1", span), [error]


def unreadable(place: Place, problems: Problems) -> Expression:
    """Stands for a value that could not be read: it is not missing."""
    expression = Expression("0", Number("0", Span(0, 1)), place)
    problems.distrust(expression.tree)
    return expression


def _quantity_hint(number: str, unit: str, where: str) -> str:
    if where.endswith("of solve"):
        return "write the number alone, in the unit of time of the parameters; 'time: s' names it"
    hint = f"write {number}"
    if where.startswith("parameter"):
        hint = f"write {{value: {number}, unit: {unit}}}"
    elif "of coordinate" in where:
        own = unit.removesuffix("/s") if where.startswith("velocity") else unit
        hint = f"write {number}, and the unit of the coordinate as 'unit: {own}'"
    return f"{hint}, or {number}*{unit} for a product" if unit.isidentifier() and len(unit) == 1 else hint


def read_number(node: Node, where: str, problems: Problems) -> float | None:
    """A number, or an expression of numbers."""
    expression = read_scalar(node, where, problems)
    if expression is None:
        return None
    for name in names(expression.tree):
        if name.identifier != "pi":
            special = name.identifier.lower() in ("nan", "inf", "infinity")
            shown_name = f"'{name.identifier}'"
            message = (
                f"{shown_name} is not a finite number"
                if special
                else f"expected a number, found {shown_name}"
            )
            error = ExpressionError(name.span, message, "write a number")
            problems.add_expression(expression, error, where)
    if not problems.trusts(expression.tree):
        return None
    try:
        return evaluate(expression.tree)
    except ExpressionError as error:
        problems.add_expression(expression, error, where)
        return None


def read_count(node: Node, where: str, problems: Problems) -> int | None:
    """A whole number."""
    value = read_number(node, where, problems)
    if value is None:
        return None
    if value != int(value):
        problems.add(node.place, f"{where} must be a whole number", f"write {max(2, round(value))}")
        return None
    return int(value)


def read_words(node: Node, where: str, problems: Problems) -> tuple[str, ...] | None:
    """A list of words, or one text with commas between them."""
    for item in node.items if isinstance(node, nodes.Sequence) else (node,):
        read_text(item, where, problems)
    return tuple(word for word, _ in words_of(node))


def words_of(node: Node) -> Iterator[tuple[str, Place]]:
    """The words of such a list, each with its place."""
    for item in node.items if isinstance(node, nodes.Sequence) else (node,):
        if isinstance(item, Scalar) and not item.empty:
            for match in re.finditer(r"[^\s,](?:[^,]*[^\s,])?", item.text):
                yield match.group(), item.passage.place(Span(*match.span()))


def read_key(key: Scalar, problems: Problems, what: str, families: bool = True) -> Key | None:
    """The key as a name of the expression language, or members of a family; None where it is neither."""
    name = unicodedata.normalize("NFKC", key.text)  # as Python's parser does with names in expressions
    indexed = "[" in name
    try:
        found = parse_key(key.text)
        if families or not indexed:
            return found
    except ExpressionError as error:
        if indexed and families:
            one = "an" if what[0] in "aeiou" else "a"
            problems.broken.add(name.partition("[")[0].strip())
            problems.add(
                key.passage.place(error.span),
                f"{error.message} {'as the key' if error.span.start == 0 else 'in the name'} of {one} {what}",
                error.hint or "write theta[i in range(N)]",
            )
            return None
    hint = "a name begins with a letter and has only letters, digits and _"
    joined = re.sub(r"[\s-]+", "_", name.strip())
    if joined != name and re.fullmatch(r"[^\W\d]\w*", joined):
        hint = f"call it {joined}: {hint}"
    if name in WORDS:
        hint = f"'{name}' is a word of expressions: call it {name}_ or another name"
    forgotten = re.fullmatch(r"([^\W\d]\w*)\s*[ =:]\s*([-+.\d]\S*)", key.text)
    united = re.fullmatch(r"([^\W\d]\w*)\s*\((.*)\)", key.text)
    if united and is_unit(united[2]):
        problems.broken.add(united[1])
        hint = f"write {united[1]}: {{..., unit: {united[2]}}}"
        if what == "coordinate" and united[2] == "t":
            hint = f"write {united[1]}: coordinates have no '(t)'"
    point = re.match(rf"([^\W\d]\w*)\.{POINT}\b", key.text)
    if point and what in ("force", "torque"):
        of = f"{point[1]}: cross({point[1]}.{POINT}(a, b, c) - {point[1]}, (Fx, Fy, Fz))"
        hint = f"write the force on {point[1]}, which acts at its centre of mass, and 'torques: {{{of}}}'"
    if forgotten:
        problems.broken.add(forgotten[1])
        value = f"{{initial: {forgotten[2]}}}" if what == "coordinate" else forgotten[2]
        hint = f"write {forgotten[1]}: {value}" + (", with a space" if ":" in key.text else "")
    problems.add(key.place, f"the {what} cannot be called {shown(key.text)}", hint)
    return None


def read_named(
    node: Node, what: str, where: str, hint: str, problems: Problems
) -> Iterator[tuple[Key, Scalar, Node]]:
    """The entries of a section ``where`` whose keys name a ``what`` each: the name, its key and the value;
    none if it is empty. What is no mapping, or no name, is reported; ``hint`` says how to write a section."""
    if isinstance(node, Scalar) and node.empty:
        return
    if not isinstance(node, nodes.Mapping):
        items = node.items if isinstance(node, nodes.Sequence) else ()
        if any(isinstance(one, nodes.Mapping) for one in items):
            hint += ", without '- '"
        problems.add(node.place, f"{where} must be a mapping with names", hint)
        for one in items:
            listed = [key for key, _ in one.entries] if isinstance(one, nodes.Mapping) else [one]
            problems.broken |= {name.text for name in listed if isinstance(name, Scalar)}
        return
    for key, value in node.entries:
        name = read_key(key, problems, what)
        if name is not None:
            yield name, key, value

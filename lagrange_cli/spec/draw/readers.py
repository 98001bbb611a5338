"""The section ``draw``: the values of its keys, read from their nodes. Names are checked later."""

from __future__ import annotations

from lagrange_cli.expression.confusions import DEGREES
from lagrange_cli.expression.listed import Listed, read_listed
from lagrange_cli.expression.near import near_hint, shown
from lagrange_cli.expression.quantities import quantity
from lagrange_cli.expression.syntax import ExpressionError, Key, Loop, Name, Number, Span
from lagrange_cli.records import dataclass
from lagrange_cli.spec import nodes
from lagrange_cli.spec.draft import Written
from lagrange_cli.spec.fields import read_named, read_scalar, read_vector
from lagrange_cli.spec.nodes import Node, Scalar
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Place
from lagrange_cli.spec.spec import Expression

NONE, ALL = "none", "all"
AXES = ("y", "z", "-y", "-z")
"""The axes that can point upward."""
EXAMPLES = {
    "rods": "[[0, bob]]",
    "springs": "[[(0, 0), block]]",
    "points": "[bob, (0, l)]",
    "trails": "[bob]",
    "hide": "[bob]",
}


@dataclass(frozen=True)
class Strand:
    """Points, and the ``loops`` that repeat them; ``text`` is the expression in which the loops stand."""

    points: tuple[Expression, ...]
    loops: tuple[Loop, ...]
    place: Place
    text: Expression


@dataclass(frozen=True)
class Several:
    """A list of strands; ``all`` of what there is, where the file says so."""

    strands: tuple[Strand, ...] = ()
    all: bool = False


@dataclass(frozen=True)
class WrittenColour(Written):
    """A name and its colour."""

    colour: str = ""


# ------------------------------------------------------------------ lists of points


def read_lines(node: Node, where: str, problems: Problems) -> Several | None:
    """Lines, each a list of two points or more: ``[[0, A], [A, B]]``; ``none`` for none at all."""
    return read_strands(node, where, problems, least=2)


def read_points(node: Node, where: str, problems: Problems) -> Several | None:
    """Points: ``[bob, (0, l)]``; ``none`` for none at all."""
    return read_strands(node, where, problems, least=1)


def read_names(node: Node, where: str, problems: Problems) -> Several | None:
    """Points, or ``all`` that there are."""
    if isinstance(node, Scalar) and node.text.strip() == ALL:
        return Several(all=True)
    return read_strands(node, where, problems, least=1)


def read_strands(node: Node, where: str, problems: Problems, least: int) -> Several | None:
    """A list of strands of at least so many points each; None where there is nothing."""
    hint = f"write '{where.partition(' ')[0]}: {EXAMPLES.get(where.partition(' ')[0], '[[0, bob]]')}'"
    if isinstance(node, Scalar):
        if node.empty:
            return None
        if node.text.strip() == NONE:
            return Several()
        strand = _of_text(node, where, problems, least, hint, several=True)
        if least > 1 or strand is None:
            return Several(() if strand is None else (strand,))
        return Several(
            tuple(Strand((one,), strand.loops, strand.place, strand.text) for one in strand.points)
        )
    if isinstance(node, nodes.Mapping):
        problems.add(node.place, f"{where} must be a list", hint)
        return None
    found = []
    for item in node.items:
        if isinstance(item, Scalar):
            strand = _of_text(item, where, problems, least, hint, several=least > 1)
        elif isinstance(item, nodes.Sequence) and least > 1:
            strand = _of_list(item, where, problems, hint)
        elif isinstance(item, nodes.Sequence):
            point = read_vector(item, f"a point of {where}", problems)
            strand = None if point is None else Strand((point,), (), item.place, point)
        else:
            problems.add(item.place, f"an item of {where} must be a list of points", hint)
            strand = None
        if strand is not None:
            found.append(strand)
    return Several(tuple(found))


def _of_text(
    scalar: Scalar, where: str, problems: Problems, least: int, hint: str, *, several: bool
) -> Strand | None:
    """``(bead[i], bead[i + 1]) for i in range(N - 1)``."""
    listed, text = _listed(scalar, where, problems, several=several)
    if listed is None:
        return None
    if len(listed.items) < least:
        error = ExpressionError(Span(0, len(scalar.text)), "a line joins two points or more", hint)
        problems.add_expression(text, error, where)
        return None
    points = tuple(Expression(scalar.text, item, scalar.place, text.passages) for item in listed.items)
    return Strand(points, listed.loops, scalar.place, text)


def _listed(
    scalar: Scalar, where: str, problems: Problems, *, several: bool
) -> tuple[Listed | None, Expression]:
    """What a text lists, None where it could not be read; and the text itself."""
    passages = ((0, scalar.passage),)
    listed, errors = read_listed(scalar.text, several=several)
    text = Expression(scalar.text, listed.items[0], scalar.place, passages)
    for error in errors:
        problems.add_expression(text, error, where)
    return None if errors else listed, text


def _of_list(node: nodes.Sequence, where: str, problems: Problems, hint: str) -> Strand | None:
    """``[A, (0, l), [x, y]]``; the last one may be followed by loops, which repeat all of them."""
    if len(node.items) < 2:
        problems.add(node.place, f"a line of {where} joins two points or more", hint)
        return None
    points: list[Expression] = []
    loops: tuple[Loop, ...] = ()
    for number, item in enumerate(node.items):
        if not isinstance(item, Scalar):
            point = read_vector(item, f"a point of {where}", problems)
        else:
            listed, point = _listed(item, where, problems, several=False)
            if listed is None:
                point = None
            elif listed.loops and number < len(node.items) - 1:
                error = ExpressionError(
                    listed.loops[0].span, "the loop must come last", "write it after all points"
                )
                problems.add_expression(point, error, where)
            elif listed.loops:
                loops = listed.loops
        if point is not None:
            points.append(point)
    complete = len(points) == len(node.items)
    return Strand(tuple(points), loops, node.place, points[-1]) if complete else None


# ------------------------------------------------------------------ colours


def read_colours(node: Node, where: str, problems: Problems) -> tuple[WrittenColour, ...]:
    """Names and their colours."""
    hint = f"write '{where.partition(' ')[0]}: {{bob: red}}'"
    return tuple(
        WrittenColour(name.name, key.place, name, key.passage, _colour(value, name, problems))
        for name, key, value in read_named(node, "colour", where, hint, problems)
    )


def _colour(node: Node, name: Key, problems: Problems) -> str:
    """A colour; empty where it is none."""
    from lagrange_cli.spec.draw.colours import NAMES, is_colour

    text = node.text.strip() if isinstance(node, Scalar) else ""
    if is_colour(text):
        return text
    hint = "write a colour of CSS, such as red, or '#rrggbb' in quotes"
    if not text and isinstance(node, Scalar):
        message, hint = f"'{name.label}' has no colour", f"{hint}: without quotes a # begins a comment"
    else:
        message = f"unknown colour of '{name.label}'" + (f": {shown(text)}" if text else "")
    problems.add(node.place, message, near_hint(text, sorted(NAMES)) or hint)
    return ""


# ------------------------------------------------------------------ camera


def read_up(node: Node, where: str, problems: Problems) -> str:
    """An axis, such as ``y`` or ``-z``."""
    text = node.text.strip() if isinstance(node, Scalar) else ""
    if text in AXES:
        return text
    problems.add(node.place, f"{where} must be an axis", f"write one of {', '.join(AXES)}")
    return ""


def read_point(node: Node, where: str, problems: Problems) -> Expression | None:
    """One point."""
    return read_vector(node, where, problems)


def read_degrees(node: Node, where: str, problems: Problems) -> Expression | None:
    """An angle in degrees, which has no unit."""
    unit = quantity(node.text) if isinstance(node, Scalar) else None
    if unit is None or unit[1] not in DEGREES or not isinstance(node, Scalar):
        return read_scalar(node, where, problems)
    error = ExpressionError(Span(0, len(node.text)), f"{where} is in degrees", f"write {unit[0]}")
    number = Expression(node.text, Number(unit[0], error.span), node.place, ((0, node.passage),))
    problems.add_expression(number, error)
    return number


def plain_name(expression: Expression) -> Name | None:
    """The name that an expression is, without a component; None where it is something else."""
    tree = expression.tree
    return tree if isinstance(tree, Name) and "." not in tree.identifier else None

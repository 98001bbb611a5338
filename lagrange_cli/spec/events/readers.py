"""The keys of an event: where it happens, and what is done then. Names are checked later."""

from __future__ import annotations

import re

from lagrange_cli.expression.confusions import PRIMES
from lagrange_cli.expression.keys import parse_key
from lagrange_cli.expression.near import known_hint, near_match, shown
from lagrange_cli.expression.parse import parse, read
from lagrange_cli.expression.syntax import Axis, Comparison, ExpressionError, Key, Logic, Name, Tree, Vector
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.records import replace
from lagrange_cli.spec import nodes
from lagrange_cli.spec.draft import Entry
from lagrange_cli.spec.fields import read_scalar
from lagrange_cli.spec.nodes import Node, Scalar
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.spec import Expression
from lagrange_cli.spec.table import Table, read_table
from lagrange_cli.spec.vanishing import difference, is_zero

DIRECTIONS = {"either": 0, "rising": 1, "falling": -1}
_DIRECTIONS_ELSEWHERE = {
    "either": "both any all 0 none always",
    "rising": "up upward upwards increasing rise rises positive plus + +1 1 +1.0 1.0",
    "falling": "down downward downwards decreasing fall falls negative minus - -1 -1.0",
}
RECORD, STOP = "record", "stop"
_ACTIONS_ELSEWHERE = {
    RECORD: "log store save write count note continue none detect mark",
    STOP: "terminal terminate end halt finish exit abort break quit",
}
IMPACTS = (
    *("bounce", "reflect", "reverse", "reflection", "impact", "impulse", "kick", "jump"),
    *("reset", "collide", "collision", "restitution", "flip"),
)
SET = "action: {set: {x_dot: -x_dot}}"
_ASSIGNED = re.compile(r"\s*([^\W\d]\w*(?:\[[^][]*\])?)\s*:?=\s*(.*\S)\s*")
_LONGEST = 60
"""Characters of a text that a hint repeats."""


def read_when(node: Node, where: str, problems: Problems) -> Expression | None:
    """The expression whose zeros are the event. A condition is a mistake, but shows which expression was
    meant."""
    if not isinstance(node, Scalar):
        return read_scalar(node, where, problems)
    tree, errors = read(node.text)
    hint = ""
    if isinstance(tree, Comparison | Logic):
        hint, tree = _zero_of(tree, node.text), _compared(tree)
        errors = [error for error in errors if " outside 'where'" not in error.message]
    elif assigned := re.fullmatch(r"(.*[^=<>!])=(?!=)(.*)", node.text, re.DOTALL):
        tree, errors = read(assigned[1])[0], []
        hint = _written(assigned[1].strip(), assigned[2].strip(), 0)
    if not hint:
        return read_scalar(node, where, problems)
    expression = Expression(node.text, tree, node.place, ((0, node.passage),))
    problems.distrust(tree)
    label = where.removeprefix("when of ")
    problems.add(node.place, f"{label} needs an expression that becomes 0, not a condition", hint)
    for error in errors:
        problems.add_expression(expression, error, where)
    return expression


def _compared(tree: Tree) -> Tree:
    """The parts of a condition, which are checked nevertheless."""
    if isinstance(tree, Comparison | Logic):
        return Vector(tuple(map(_compared, tree.operands)), tree.span)
    return tree


def _zero_of(tree: Comparison | Logic, text: str) -> str:
    """How to write the event at which a condition begins to hold."""
    if isinstance(tree, Logic) or len(tree.operators) > 1:
        return "write an event for each comparison, with the difference of its two sides"
    left, right = (text[one.span.start : one.span.stop] for one in tree.operands)
    direction = {"<": -1, ">": 1}.get(tree.operators[0][0], 0)
    return _written(left, right, direction)


def _written(left: str, right: str, direction: int) -> str:
    """``when`` for a comparison of two sides; where it begins to hold their difference rises or falls."""
    direction = -direction if is_zero(left) and not is_zero(right) else direction
    left = difference(left, right)
    words = {number: word for word, number in DIRECTIONS.items()}
    return f"write 'when: {left}'" + (f" and 'direction: {words[direction]}'" if direction else "")


def read_direction(node: Node, where: str, problems: Problems) -> int:
    """+1, -1 or 0 for the word."""
    text = node.text.strip() if isinstance(node, Scalar) else ""
    if text in DIRECTIONS:
        return DIRECTIONS[text]
    meant = _meant(text.lower(), _DIRECTIONS_ELSEWHERE, tuple(DIRECTIONS))
    hint = f"write {meant}" if meant else known_hint(("rising", "falling", "either"))
    problems.add(node.place, f"unknown {where}" + (f": {shown(text)}" if text else ""), hint)
    return DIRECTIONS.get(meant, 0)


def read_action(table: Table, node: Node, where: str, problems: Problems) -> tuple[bool, tuple[Entry, ...]]:
    """Whether the motion stops, and what is set; ``table`` has the keys of an action that is a mapping."""
    hint = f"known: record, stop, or a mapping as in '{SET}'"
    if isinstance(node, nodes.Sequence):
        problems.add(node.place, f"{where} must be one action", hint)
        return False, ()
    if isinstance(node, nodes.Mapping):
        label = where.removeprefix("action of ")
        if not node.entries:
            problems.add(node.place, f"{where} is empty", hint)
        for key, value in node.entries:
            if key.text != "set" and not (table.meant(key.text)[1] or near_match(key.text, table.keys)):
                stops = key.text.lower() in (STOP, *_ACTIONS_ELSEWHERE[STOP].split())
                instead = f"write 'action: {{set: {{{key.text}: ...}}}}'"
                if stops and any(other.text == "set" for other, _ in node.entries):
                    instead = "leave it out: an action either stops the motion or sets something"
                elif key.text == RECORD or stops:
                    instead = f"write 'action: {STOP if stops else RECORD}'"
                elif key.text.lower() in IMPACTS or isinstance(value, nodes.Mapping):
                    instead = f"write '{SET}'"
                problems.add(key.place, f"unknown key {shown(key.text)} in the {where}", instead)
                node = replace(node, entries=tuple(one for one in node.entries if one[0] is not key))
        return False, read_table(node, table, label, problems).get("set", ())
    text = node.text.strip()
    if text in (RECORD, STOP):
        return text == STOP, ()
    assigned = _ASSIGNED.fullmatch(text)
    meant = _meant(text.lower(), _ACTIONS_ELSEWHERE, (RECORD, STOP))
    if assigned and len(text) < _LONGEST:
        hint = f"write 'action: {{set: {{{assigned[1]}: {assigned[2]}}}}}'"
    elif text.lower() in IMPACTS or text == "set":
        hint = f"write '{SET}'"
    elif meant:
        hint = f"write {meant}"
    problems.add(node.place, f"unknown {where}" + (f": {shown(text)}" if text else ""), hint)
    return meant == STOP, ()


def _meant(word: str, elsewhere: dict[str, str], known: tuple[str, ...]) -> str:
    """The word for one from other programs, or for a misspelt one."""
    return next((one for one, words in elsewhere.items() if word in words.split()), near_match(word, known))


def read_changes(node: Node, where: str, problems: Problems) -> tuple[Entry, ...]:
    """The entries of ``set``: a name and its new value each."""
    label = where.removeprefix("set of ")
    if not isinstance(node, nodes.Mapping):
        assigned = _ASSIGNED.fullmatch(node.text) if isinstance(node, Scalar) else None
        hint = "write 'set: {x_dot: -x_dot}'"
        if assigned and len(assigned[0]) < _LONGEST:
            hint = f"write 'set: {{{assigned[1]}: {assigned[2]}}}'"
        empty = isinstance(node, Scalar) and node.empty
        problems.add(node.place, f"{where} {'is empty' if empty else 'must be a mapping'}", hint)
        return ()
    if not node.entries:
        problems.add(node.place, f"{where} is empty", "name what changes, or write 'action: record'")
    found = []
    for key, value in node.entries:
        name = _target(key, value, label, problems)
        if name is not None:
            expression = read_scalar(value, f"the new {name.label} of {label}", problems)
            found.append(Entry(name.name, key.place, name, key.passage, expression))
    return tuple(found)


def _target(key: Scalar, value: Node, label: str, problems: Problems) -> Key | None:
    """The target of an action: a name, members of a family, or a component, which is reported later as one
    that cannot be."""
    try:
        return parse_key(key.text)
    except ExpressionError as error:
        try:
            tree = parse(key.text)
        except ExpressionError:
            tree = None
        if isinstance(tree, Name):
            axes = tuple(Axis("", (index,), index.span) for index in tree.indices)
            return Key(tree.identifier, key.text, axes)
        assigned = _ASSIGNED.fullmatch(key.text)
        if "[" in key.text and not assigned:
            place = key.passage.place(error.span)
            problems.add(place, f"{error.message} in what {label} sets", error.hint)
            return None
        hint = "coordinates, velocities and parameters can be set, as in 'set: {x_dot: -x_dot}'"
        bare = key.text.rstrip("".join(PRIMES))
        if bare != key.text and bare.isidentifier():
            hint = f"write {velocity_name(bare)} for the velocity of {bare}"
        if assigned and len(key.text) < _LONGEST:
            hint = f"write {assigned[1]}: {assigned[2]}"
        problems.add(key.place, f"{label} cannot set {shown(key.text)}", hint)
        return None

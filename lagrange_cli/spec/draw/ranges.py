"""What has ranges in the section ``draw``, read from its nodes: curves, surfaces and sliders."""

from __future__ import annotations

from typing import Any

from lagrange_cli.expression.near import shown
from lagrange_cli.records import dataclass
from lagrange_cli.spec import nodes
from lagrange_cli.spec.draft import Written
from lagrange_cli.spec.draw.readers import NONE, Several, read_strands
from lagrange_cli.spec.fields import read_key, read_named, read_scalar, read_vector
from lagrange_cli.spec.nodes import Node, Scalar
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Place
from lagrange_cli.spec.spec import Expression

AT, THROUGH = "at", "through"
CURVE = "{at: [u, u**2], u: [-1, 1]}"


@dataclass(frozen=True)
class WrittenRange(Written):
    """A name and its range, None where it is left open or could not be read."""

    ends: tuple[Expression, Expression] | None = None


@dataclass(frozen=True)
class WrittenCurve(Written):
    """A curve: a point and ranges, or points. Parts that could not be read are None."""

    point: Expression | None = None
    ranges: tuple[WrittenRange, ...] = ()
    through: Several | None = None


def read_curves(node: Node, where: str, problems: Problems) -> tuple[WrittenCurve, ...] | None:
    """Curves by name: a point, a mapping with ``at`` or ``through``, or a list of points."""
    if isinstance(node, Scalar) and node.text.strip() == NONE:
        return ()
    if isinstance(node, Scalar) and node.empty:
        return None
    hint = f"write 'curves: {{wire: {CURVE}}}'"
    found = []
    for name, key, value in read_named(node, "curve", where, hint, problems):
        if name.axes:
            problems.add(key.place, f"the curve '{name.label}' is not a family", "write each curve by itself")
            continue
        label = f"curve '{name.label}'"
        given: dict[str, Any] = {}
        if isinstance(value, nodes.Mapping):
            given = _curve_of(value, key.place, label, problems)
        elif isinstance(value, nodes.Sequence) and any(
            isinstance(one, nodes.Sequence) for one in value.items
        ):
            given = {"through": _through(value, label, problems)}
        else:
            given = {"point": read_vector(value, label, problems)}
        found.append(WrittenCurve(name.name, key.place, name, key.passage, **given))
    return tuple(found)


def _through(node: Node, label: str, problems: Problems) -> Several | None:
    """The points that a line goes through: two of them, or loops that make them."""
    if isinstance(node, nodes.Sequence) and len(node.items) < 2:
        repeated = [one for one in node.items if isinstance(one, Scalar) and " for " in one.text]
        if not repeated:
            problems.add(node.place, f"{label} must have two points or more", "write [[0, 0], [1, 0]]")
            return None
    return read_strands(node, label, problems, least=1)


def _curve_of(node: nodes.Mapping, place: Place, label: str, problems: Problems) -> dict[str, Any]:
    """``{at: ..., NAME: [low, high]}`` or ``{through: ...}``."""
    found: dict[str, Any] = {}
    ranges: list[WrittenRange] = []
    words = {key.text for key, _ in node.entries}
    for key, value in node.entries:
        if key.text == AT:
            found["point"] = read_vector(value, f"{AT} of {label}", problems)
        elif key.text == THROUGH:
            found["through"] = _through(value, f"{THROUGH} of {label}", problems)
        elif THROUGH in words:
            hint = f"leave it out: a curve has '{THROUGH}', or '{AT}' and ranges"
            problems.add(key.place, f"unknown key {shown(key.text)} in {label}", hint)
        else:
            ranges += _range_of(key, value, label, problems)
    if AT not in words and THROUGH not in words:
        problems.add(place, f"{label} has neither '{AT}' nor '{THROUGH}'", f"write {CURVE}")
    elif AT in words and THROUGH in words:
        problems.add(place, f"{label} has both '{AT}' and '{THROUGH}'", "leave one of them out")
    elif len(ranges) > 2:
        message = f"{label} has {len(ranges)} ranges: a curve has one, a surface two"
        problems.add(place, message, "leave the others out")
    return {**found, "ranges": tuple(ranges)}


def _range_of(key: Scalar, value: Node, where: str, problems: Problems) -> list[WrittenRange]:
    """A name and its range, which may be left open."""
    name = read_key(key, problems, "range")
    if name is None:
        return []
    ends = None
    if not (isinstance(value, Scalar) and value.empty):
        ends = read_range(value, f"range of '{name.label}' in {where}", problems)
    return [WrittenRange(name.name, key.place, name, key.passage, ends)]


def read_range(node: Node, where: str, problems: Problems) -> tuple[Expression, Expression] | None:
    """``[low, high]``."""
    if not isinstance(node, nodes.Sequence) or len(node.items) != 2:
        problems.add(node.place, f"{where} must be a list of two numbers", "write [0, 1]")
        return None
    low, high = (read_scalar(item, where, problems) for item in node.items)
    return None if low is None or high is None else (low, high)


def read_sliders(node: Node, where: str, problems: Problems) -> tuple[WrittenRange, ...]:
    """Names and their ranges."""
    found = []
    for name, key, value in read_named(node, "slider", where, "write 'sliders: {l: [0.1, 5]}'", problems):
        ends = read_range(value, f"slider '{name.label}'", problems)
        found.append(WrittenRange(name.name, key.place, name, key.passage, ends))
    return tuple(found)

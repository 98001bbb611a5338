"""The norms of quaternions, which are constraints: |q|^2 - 1 of each, called ``BODY.norm``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lagrange_cli.expression.syntax import Binary, Number, Span, Tree
from lagrange_cli.records import replace
from lagrange_cli.spec.spec import Body, Expression, Family, Orientation

NORM = ".norm"


def norms(bodies: Mapping[str, Body]) -> dict[str, Expression]:
    """The constraint |q|^2 - 1 of each quaternion, called ``BODY.norm`` by the first body that has it: bodies
    that turn together may share one."""
    found: dict[tuple[Any, ...], str] = {}
    for name, one in bodies.items():
        if is_bound(one):
            entries = one.orientation.entries
            found.setdefault(tuple((each.text.strip(), *each.indices.items()) for each in entries), name)
    return {norm_name(name): norm(bodies[name].orientation) for name in found.values()}


def is_bound(body: Body) -> bool:
    """Whether its orientation has a norm to be kept."""
    return body.orientation.form == "quaternion"


def norm_name(body: str) -> str:
    """``plate.norm`` for ``plate``, ``plate.norm[2]`` for ``plate[2]``."""
    base, bracket, index = body.partition("[")
    return base + NORM + bracket + index


def norm(orientation: Orientation) -> Expression:
    """|q|^2 - 1."""
    first = orientation.entries[0]
    text, passages = "", []
    tree: Tree | None = None
    for one in orientation.entries:
        text += " + (" if text else "("
        passages += [(offset + len(text), passage) for offset, passage in one.passages]
        shifted = Span(len(text), len(text) + len(one.text))
        text += f"{one.text})**2"
        square = Binary("**", one.tree, Number("2", shifted), shifted)
        tree = square if tree is None else Binary("+", tree, square, Span(0, shifted.stop))
    assert tree is not None
    whole = Span(0, len(text))
    tree = Binary("-", tree, Number("1", whole), whole)
    return replace(first, text=f"{text} - 1", tree=tree, place=orientation.place, passages=tuple(passages))


def with_families(
    families: Mapping[str, Mapping[str, Family]], bodies: Mapping[str, Body]
) -> Mapping[str, Mapping[str, Family]]:
    """The families by section: bodies are among the particles, and norms of quaternions among constraints."""
    own = families.get("bodies", {})
    if not own:
        return families
    kept = norms(bodies).keys()
    bound = {
        name + NORM: one.renamed(name + NORM)
        for name, one in own.items()
        if kept >= set(map(norm_name, one.members))
    }
    embedding = {**families.get("embedding", {}), **own}
    return {**families, "embedding": embedding, "constraints": {**families.get("constraints", {}), **bound}}

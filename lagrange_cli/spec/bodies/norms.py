"""The norms of quaternions, which are constraints: |q|^2 - 1 of each, called ``BODY.norm``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from lagrange_cli.expression.syntax import Binary, Number, Span, Tree
from lagrange_cli.records import replace
from lagrange_cli.spec.body import Body, Orientation
from lagrange_cli.spec.content import by_name, groups_by_name, statements
from lagrange_cli.spec.spec import Expression, Family
from lagrange_cli.spec.whole import WrittenFamily

NORM = ".norm"


def norms(bodies: Mapping[str, Body]) -> Mapping[str, Expression]:
    """The constraint |q|^2 - 1 of each quaternion, called ``BODY.norm`` by the first body that has it: bodies
    that turn together may share one. Those of a family are a family, unless only some have one."""
    made: dict[str, Any] = {}
    sharing = [*shared(bodies)]
    found: dict[tuple[Any, ...], str] = {}
    for name, one in groups_by_name(bodies).items():
        if name in sharing or not isinstance(one, WrittenFamily):
            members = zip(one.names, one) if isinstance(one, WrittenFamily) else [(name, one)]
            for member, body in members:
                if is_bound(body) and found.setdefault(written(body), member) == member:
                    made[norm_name(member)] = norm(body.orientation)
        elif is_bound(one.parts[0].item):
            own = WrittenFamily(one.family.renamed(name + NORM), one.parts, one.order)
            made[name + NORM] = own.mapped(lambda body: norm(body.orientation))
    return by_name(made)


def shared(bodies: Mapping[str, Body]) -> Iterator[str]:
    """The families whose members are looked at one by one: some have no norms, or may share them."""
    seen: dict[tuple[str, ...], list[str]] = {}
    for name, group in groups_by_name(bodies).items():
        parts = statements(group)
        if len({is_bound(one) for one in parts}) > 1:
            yield name
        for one in parts:
            if is_bound(one):
                seen.setdefault(texts(one), []).append(name)
    for names in seen.values():
        if len(names) > 1:
            yield from names


def texts(body: Body) -> tuple[str, ...]:
    """The orientation as it is written."""
    return tuple(one.text.strip() for one in body.orientation.entries)


def written(body: Body) -> tuple[Any, ...]:
    """The same with the values of indices."""
    return tuple((one.text.strip(), *one.indices.items()) for one in body.orientation.entries)


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
    families: Mapping[str, Mapping[str, Family]], norms: Mapping[str, Expression]
) -> Mapping[str, Mapping[str, Family]]:
    """The families by section: bodies are among the particles, and norms of quaternions among constraints."""
    own = families.get("bodies", {})
    if not own:
        return families
    bound = {
        name + NORM: one.renamed(name + NORM)
        for name, one in own.items()
        if name + NORM in groups_by_name(norms) or all(norm_name(member) in norms for member in one.members)
    }
    embedding = {**families.get("embedding", {}), **own}
    return {**families, "embedding": embedding, "constraints": {**families.get("constraints", {}), **bound}}

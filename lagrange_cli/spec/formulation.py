"""How a file gives its system: by a Lagrangian, or by particles and bodies, each of which is complete; and
whether some coordinates may have no mass, by the names in expressions alone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

from lagrange_cli.expression.near import near_hint
from lagrange_cli.expression.syntax import Binary, Call, Tree, Vector, names, parts
from lagrange_cli.expression.vocabulary import COMPONENTS, velocity_name
from lagrange_cli.spec.content import (
    bases_of,
    by_name,
    groups_by_name,
    groups_of,
    names_of,
    written,
    written_by_family,
)
from lagrange_cli.spec.draft import Draft, Entry
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import WHOLE_FILE
from lagrange_cli.spec.whole import WrittenFamily

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec

SPACE = 3
"""The dimensions of space."""


def check_formulation(draft: Draft, problems: Problems) -> None:
    """Note a file with both or neither, and particles without a mass or a position."""
    places = draft.places
    if "lagrangian" in places:
        others = [one for one in ("masses", "embedding", "bodies", "potential") if one in places]
        if others:
            words = " and ".join(f"'{draft.words.get(one, one)}'" for one in others)
            problems.add(
                places["lagrangian"],
                f"'lagrangian' cannot be given together with {words}",
                "a Lagrangian replaces masses, positions, bodies and potential: leave one or the other out",
            )
        return
    if "masses" not in places and "embedding" not in places:
        if draft.strange or draft.bodies or ("bodies" in places and problems.found):
            return
        problems.add(
            WHOLE_FILE,
            "the system has no masses and no Lagrangian",
            "write 'masses' with 'positions' (or 'embedding'), or 'lagrangian'",
        )
        return
    word = draft.words.get("embedding", "positions")
    masses, embedding = _by_name(draft.entries("masses")), _by_name(draft.entries("embedding"))
    unread = ("masses" in places and not masses) or ("embedding" in places and not embedding)
    if not (unread and problems.found):  # what could not be read is not missing
        _partners(masses, embedding, "a mass but no position", f"{word}: {{%s: [x, y]}}", problems)
        massless = "masses: {%s: 1.0}, or write it under 'definitions' if it has no mass"
        heavy, placed = groups_by_name(masses).keys(), groups_by_name(embedding).keys()
        if heavy - placed:  # whose components these are
            problems.broken.update((placed - heavy).intersection(COMPONENTS))
        _partners(embedding, masses, "a position but no mass", massless, problems)
    if not masses and not embedding and not draft.bodies and not problems.found:
        place = places.get("masses", places.get("embedding", WHOLE_FILE))
        problems.add(place, "the system has no particles", "write 'masses: {bead: m}'")


def _partners(
    entries: Mapping[str, Entry], partners: Mapping[str, Entry], what: str, example: str, problems: Problems
) -> None:
    """Note each entry without a partner of its name."""
    families = groups_by_name(partners)
    for base, group in groups_by_name(entries).items():
        other = families.get(base)
        if base in problems.broken:  # its partner may be what could not be read
            continue
        if not isinstance(group, WrittenFamily):
            alone = [group] if base not in partners else []
        elif isinstance(other, WrittenFamily) and group.family.members == other.family.members:
            continue
        else:
            alone = [entry for entry in group if entry.name not in partners]
        for entry in alone:
            near = near_hint(entry.name, [one for one in partners if one not in entries])
            if base in families:
                near = "declare the same members in both"
            problems.add_once(
                entry.place, f"the particle '{entry.name}' has {what}", near or f"add {example % entry.name}"
            )


def _by_name(entries: Sequence[Entry]) -> Mapping[str, Entry]:
    found: dict[str, Any] = {}
    for entry in groups_of(entries):
        found.setdefault(entry.name, entry)
    return by_name(found)


def may_have_massless(spec: Spec) -> bool:
    """Whether there may be coordinates without mass: positions do not depend on them, or L seems to be linear
    in their velocities."""
    coordinates = {*bases_of(names_of(spec.coordinates))}
    trees = {name: [one.tree for one in own] for name, own in written_by_family(spec.definitions).items()}
    if spec.lagrangian is None:
        moving = chain(written(spec.embedding), *(one.expressions for one in spec.written_bodies))
        unused = coordinates - used_in([one.tree for one in moving], trees)
        return bool(unused) or components(spec, trees) < len(spec.coordinates)
    velocities = {velocity_name(name) for name in coordinates}
    squared = set[str]()
    for one in chain.from_iterable(map(parts, [spec.lagrangian.tree, *chain(*trees.values())])):
        if isinstance(one, Call):
            squared |= used_in(one.arguments, trees)
        elif isinstance(one, Binary) and one.operator in ("*", "/", "**"):
            left, right = (used_in([each], trees) & velocities for each in (one.left, one.right))
            if one.operator == "**" or (left and right):
                squared |= left | right
    return bool(velocities - squared)


def components(spec: Spec, definitions: Mapping[str, Sequence[Tree]]) -> int:
    """What moves, at most: the components of positions, and the ways in which bodies do."""
    count = 2 * SPACE * len(spec.bodies)
    for one in groups_by_name(spec.embedding).values():
        listed = (
            [(part.item, part.count) for part in one.parts] if isinstance(one, WrittenFamily) else [(one, 1)]
        )
        for place, members in listed:
            wide = isinstance(place.tree, Vector) or used_in([place.tree], {}) & definitions.keys()
            count += members * (SPACE if wide else 1)
    return count


def used_in(trees: Iterable[Tree], definitions: Mapping[str, Sequence[Tree]]) -> set[str]:
    """The names in trees, and in definitions that are used there."""
    pending, found = [one.base for tree in trees for one in names(tree)], set[str]()
    while pending:
        name = pending.pop()
        if name not in found:
            found.add(name)
            pending += [one.base for tree in definitions.get(name, ()) for one in names(tree)]
    return found

"""How a file gives its system: by a Lagrangian, or by particles and bodies, each of which is complete."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lagrange_cli.expression.near import near_hint
from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.spec.content import by_name, groups_by_name, groups_of
from lagrange_cli.spec.draft import Draft, Entry
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import WHOLE_FILE
from lagrange_cli.spec.whole import WrittenFamily


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

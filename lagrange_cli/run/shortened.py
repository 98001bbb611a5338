"""Long lists, families and expressions in short."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import prod
from typing import TYPE_CHECKING

from lagrange_cli.expression.vocabulary import velocity_name

if TYPE_CHECKING:
    from lagrange_cli.expression.loops import Ranges
    from lagrange_cli.spec.spec import Family, Spec


MOST_LINES = 20
"""Entries of one list that are shown."""
LONGEST = 200
"""Characters of an expression that is shown."""


def listed(words: Sequence[str]) -> str:
    """``a, b and c``."""
    return " and ".join([*([", ".join(words[:-1])] if words[1:] else []), words[-1]])


def in_short(names: Sequence[str], spec: Spec, sections: Sequence[str] = ("coordinates",)) -> list[str]:
    """The names, with all members of a family as one: ``u[0..19,0..9]``, or ``45 of u[1..9,0..8]``; of some
    members, those side by side, or at equal distances, ``u[0], u[3], ..., u[27]``."""
    families = {name: one for key in sections for name, one in spec.families.get(key, {}).items()}
    present = set(names)
    ends = dict[str, str]()
    for family in families.values():
        if present.issuperset(family.members):
            ends |= dict.fromkeys(family.members, all_of(family))
        elif not present.isdisjoint(family.members):
            from lagrange_cli.spec.blocks import blocks

            for ranges, members in blocks(family, present):
                ends |= dict.fromkeys(members, block(family.name, ranges, members))
    return [*dict.fromkeys(ends.get(name, name) for name in names)]


def block(name: str, ranges: Ranges, members: Sequence[str]) -> str:
    """Members as one."""
    if all(one.step == 1 or len(one) == 1 for one in ranges):
        ends = ",".join(f"{one[0]}..{one[-1]}" if len(one) > 1 else f"{one[0]}" for one in ranges)
        return f"{name}[{ends}]"
    return f"{members[0]}, {members[1]}, ..., {members[-1]}"


def all_of(family: Family) -> str:
    """All members of a family as one."""
    ends = [(0, size - 1) for size in family.shape]
    if not family.complete:
        ends = [(min(values), max(values)) for values in zip(*family.places)]
    whole = f"{family.name}[{','.join(f'{low}..{high}' for low, high in ends)}]"
    count = len(family.members)
    return whole if count == prod(high - low + 1 for low, high in ends) else f"{count} of {whole}"


def readable(expression: str) -> str:
    """An expression, or where it is long, how many terms it has."""
    if len(expression) <= LONGEST:
        return expression
    depth, count = 0, 1
    for before, letter, after in zip(expression, expression[1:], expression[2:]):
        depth += (letter in "([") - (letter in ")]")
        count += depth == 0 and letter in "+-" and before == after == " "
    return f"a sum of {count} terms, see --json" if count > 1 else "a long expression, see --json"


def together(lines: Mapping[str, str], spec: Spec) -> list[str]:
    """The ``lines`` of conserved quantities, with one for the momenta of a family if all of them say the
    same, each of its own member: ``p_u[i] = dL/du_dot[i]: ...   [for i in range(20)]``. Likewise for parts of
    the energy function, each of members with one index."""
    shown = dict(lines)
    for family in spec.coordinate_families.values():
        speed, index = velocity_name(family.label), family.label.removeprefix(family.name)
        range_ = spelled(map(range, family.shape))
        momenta = [member for member in family.members if f"p_{member}" in lines]
        every = len(momenta) == len(family.members)
        alike: list[tuple[str, Sequence[str]]] = [(range_, momenta)] if every and len(momenta) > 1 else []
        if momenta and not every:
            from lagrange_cli.spec.blocks import blocks

            alike = [(spelled(ranges), members) for ranges, members in blocks(family, {*momenta})]
        for ranges, members in alike:
            found = set()
            for member in members:
                line = lines[f"p_{member}"].replace(member, family.label)
                line = line.replace(velocity_name(member), speed)
                # the event of its own index: 'wall[3]'
                found.add(line.replace(f"{member.removeprefix(family.name)}'", f"{index}'"))
            if len(found) == 1:
                shown |= dict.fromkeys((f"p_{member}" for member in members), f"{found.pop()}{ranges}")
        parts = [f"h_{member}" for member in family.members]
        if len(parts) > 1 and len(family.shape) == 1 and family.complete and lines.keys() >= {*parts}:
            found = {lines[part].replace(f"[{k}]", index) for part, (k,) in zip(parts, family.places)}
            if len(found) == 1:
                shown |= dict.fromkeys(parts, f"{found.pop()}{range_}")
    return [*dict.fromkeys(shown.values())]


def spelled(ranges: Iterable[range]) -> str:
    """The values of the indices of a line."""
    return f"   [{' '.join(f'for {i} in {text_of(one)}' for i, one in zip('ijklmn', ranges))}]"


def text_of(values: range) -> str:
    """``range(20)``, or what else it is."""
    begin = f"{values.start}, " if values.start or values.step > 1 else ""
    return f"range({begin}{values[-1] + 1}{f', {values.step}' if values.step > 1 else ''})"


def by_template(lines: Mapping[str, str], spec: Spec) -> list[str]:
    """The ``lines`` of constraints, with one for a family with one index if all of its members say the same,
    each of what has its own index."""
    shown = dict(lines)
    for family in spec.families.get("nonholonomic", {}).values():
        if len(family.shape) != 1 or len(family.members) < 2 or not lines.keys() >= {*family.members}:
            continue
        found = {
            lines[member].replace(f"[{k}]", family.label.removeprefix(family.name))
            for member, (k,) in zip(family.members, family.places)
        }
        if len(found) == 1:
            range_ = f"   [for i in range({family.shape[0]})]"
            if not family.complete:
                range_ = f"   [for {all_of(family)}]"
            shown |= dict.fromkeys(family.members, f"{found.pop()}{range_}")
    return [*dict.fromkeys(shown.values())]


def cut(lines: Sequence[str], total: int | None = None) -> list[str]:
    """The lines, and how many more there are, if they are many."""
    left = (len(lines) if total is None else total) - MOST_LINES
    return [*lines[:MOST_LINES], *([f"and {left} more, see --json"] if left > 0 else [])]


def section(title: str, lines: Sequence[str], none: str, total: int | None = None) -> list[str]:
    """A titled list, one line for each entry as long as there are not too many; ``none`` if it is empty. Of
    ``total`` entries, at least those that are shown are among the ``lines``."""
    shown = [f"    {line}" for line in cut(lines, total)]
    return [f"  {title}:", *shown] if lines else [f"  {title}: {none}"]

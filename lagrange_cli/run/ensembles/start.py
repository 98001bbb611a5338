"""The starts of the members of an ensemble: states that satisfy the constraints."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING

from lagrange_cli.errors import SpecError
from lagrange_cli.portions import portion
from lagrange_cli.records import replace
from lagrange_cli.run.start import NOTHING, Begin, consistent_values
from lagrange_cli.run.start_notes import notes

if TYPE_CHECKING:
    from lagrange_cli.spec.ensemble import EnsembleValues
    from lagrange_cli.spec.spec import Spec


def consistent_ensemble(
    spec: Spec, values: EnsembleValues, t: float, given: Collection[str], *, forced: bool = False
) -> tuple[Spec, EnsembleValues, tuple[str, ...]]:
    """A consistent start of each member of an ensemble, as ``consistent_values`` finds it; and what the user
    is told.

    A member that has no consistent start is refused, and the others go on. The system is that without the
    constraints that depend on others in the first member.

    Raises ``SpecError`` where no member has one.
    """
    if not spec.restricted:
        return spec, values, ()
    if values.remainder is not None:
        long = replace(values.of(0), remainder=values.remainder)
        spec, long, begin = consistent_values(spec, long, t, given, forced=forced, exact=True)
        return spec, replace(values, q=long.q, v=long.v, remainder=long.remainder), tuple(notes(begin))
    import numpy as np

    refused: dict[int, str] = {}
    otherwise: dict[int, tuple[str, ...]] = {}
    states = np.array([np.broadcast_to(x, values.members) for x in (*values.q, *values.v)], dtype=np.float64)
    begins: list[Begin] = []
    faint: set[str] = set()
    in_turn: set[str] = set()
    tied: set[tuple[str, ...]] = set()
    first: tuple[str, ...] | None = None
    error: SpecError | None = None
    with portion(values.members) as work:
        for member in range(values.members):
            work.reach(member)
            try:
                one, found, begin = consistent_values(spec, values.of(member), t, given, forced=forced)
            except SpecError as problem:
                error, refused[member] = error or problem, problem.problems[0].message
                continue
            if first is None:
                first = one.left_out
            if one.left_out != first:
                otherwise[member] = one.left_out
            faint.update(one.faint)
            in_turn.update(one.in_turn)
            tied.update(one.tied)
            states[:, member] = (*found.q, *found.v)
            begins.append(begin)
    if first is None:
        assert error is not None
        raise error
    rows = [row if np.ptp(row) else float(row[0]) for row in states]
    size = len(values.q)
    values = replace(values, q=tuple(rows[:size]), v=tuple(rows[size:]), refused=refused, otherwise=otherwise)
    spec = replace(spec, left_out=first, in_turn=tuple(sorted(in_turn)), faint=tuple(sorted(faint)))
    spec = replace(spec, tied=tuple(sorted(tied)))
    return spec, values, tuple(notes_of_members(begins))


def notes_of_members(begins: Collection[Begin]) -> Iterator[str]:
    """The messages about the starts of many motions."""
    if len(begins) == 1:
        yield from notes(next(iter(begins)))
        return
    moved, found = sum(bool(one.moved) for one in begins), sum(bool(one.found) for one in begins)
    by = next(iter(begins)).by if begins else ""
    if moved:
        yield f"initial values of {members(moved)} moved to satisfy {by}"
    if found:
        yield f"initial values of {members(found)} found from {by}"
    dependent = [(one.redundant, one.undetermined) for one in begins]
    for redundant, undetermined in dict.fromkeys(dependent):
        (said,) = [*notes(replace(NOTHING, redundant=redundant, undetermined=undetermined)), ""][:1]
        if len({*dependent}) > 1:
            count = dependent.count((redundant, undetermined))
            said = said.replace("warning: ", f"warning: in {members(count)} ")
        if said:
            yield said
    singular = sum(bool(one.singular) for one in begins)
    if singular:
        yield f"warning: constraints of {members(singular)} depend on each other at the start, and only there"


def members(count: int) -> str:
    """So many of them."""
    return f"{count} member{'' if count == 1 else 's'}"

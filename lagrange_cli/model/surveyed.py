"""What is surveyed apart, or once: definitions with multipliers, and coordinates that are written alike."""

from __future__ import annotations

from lagrange_cli.expression.syntax import names
from lagrange_cli.expression.vocabulary import MULTIPLIER
from lagrange_cli.spec.content import groups_by_name, statements
from lagrange_cli.spec.order import leading_to
from lagrange_cli.spec.spec import Coordinate, Spec


def with_multipliers(spec: Spec) -> list[str]:
    """The definitions that contain multipliers, or what does: energies and constraints do not use them."""
    uses: dict[str, set[str]] = {}
    for name, group in groups_by_name(spec.definitions).items():
        used = [one.identifier for written in statements(group) for one in names(written.tree)]
        uses[name] = {MULTIPLIER if one.endswith(f".{MULTIPLIER}") else one.partition(".")[0] for one in used}
    return leading_to(uses, [MULTIPLIER])


def alike(coordinates: list[Coordinate]) -> list[Coordinate]:
    """One coordinate of each that is written, as members of a family share expressions."""
    found: dict[tuple[object, ...], Coordinate] = {}
    for one in coordinates:
        trees = (None if given is None else id(given.tree) for given in (one.initial, one.velocity))
        found.setdefault((one.unit, *trees), one)
    return list(found.values())

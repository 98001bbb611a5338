"""What a system of families conserves, with reasons, and how h changes where it does not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import sympy

from lagrange_cli.expression.vocabulary import COMPONENTS, TIME, velocity_name
from lagrange_cli.families.conserved.breaks import actions_of
from lagrange_cli.families.conserved.conservation import constants_of
from lagrange_cli.families.conserved.rigid import Rigid
from lagrange_cli.mechanics.conserved.displacements import TURNS
from lagrange_cli.model.constraints import without_force, without_work
from lagrange_cli.model.events import between_events
from lagrange_cli.records import replace
from lagrange_cli.spec.blocks import blocks, several
from lagrange_cli.spec.family import Family
from lagrange_cli.symbolic.equations import Changing, Conserved
from lagrange_cli.symbolic.families.given import Given
from lagrange_cli.symbolic.families.lines import Line, symbol_of
from lagrange_cli.symbolic.families.sums import gathered
from lagrange_cli.symbolic.from_graph import number
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.indexed.members import Loops, Summed

INDICES = "ijklmn"


def balance(
    given: Given,
    lagrangian: sympy.Expr,
    momenta: Sequence[Line],
    forces: Sequence[Line],
    drawn: sympy.Expr,
    h: sympy.Expr,
) -> tuple[list[Conserved], list[Changing]]:
    """The conserved quantities with reasons, and those that are not conserved; ``drawn`` is the power of the
    forces of constraint, and ``h`` the energy function."""
    constants = constants_of(given.system, actions_of(given.spec))
    bound, drawn = given.spec.constrained, tidy(drawn, given.order)
    kept = [each for each in constants.conserved if each.quantity == "h" or not bound]
    names = {each.quantity: each.breaks for each in kept}
    conserved = [*cyclic(given, names, momenta)]
    changing = []
    if "h" in names and drawn == 0:
        because = "`L` does not contain `t` explicitly" + without_work(given.system.driven, bound)
        plain = "; `h = T + U` (no `t` in the embedding, no velocities in `U`)"
        straight = given.system.vector is None and not given.system.moved_in_time
        because += plain if given.spec.lagrangian is None and straight else ""
        conserved.append(between(Conserved("h", sympy.S.Zero, because), names["h"]))
    else:
        reasons = ["`L` contains `t` explicitly"] if constants.timed else []
        power = sympy.Add(
            *(
                Summed(tidy(one.expression * symbol_of(one, velocity_name(one.family.name)), given.order),
                       Loops(one.loops))
                for one in forces
            )
        )  # fmt: skip
        working = "generalized forces or friction" * (power != 0), "forces of constraint" * (drawn != 0)
        reasons += [" and ".join(filter(None, working)) + " do work"] * any(working)
        rate = tidy(power + drawn - given.explicit_rate(lagrangian), given.order)
        changing.append(Changing("h", rate, " and ".join(reasons)))
    texts = dict(displaced(given, momenta))
    for each in kept:
        if each.quantity in texts:
            expression = gathered(given.neat(texts[each.quantity]), given.order)
            conserved.append(Conserved(each.quantity, expression, each.because, each.breaks))
    conserved += of_parts(given, names, momenta, h)
    return conserved, changing


def of_parts(
    given: Given, names: Mapping[str, Sequence[str]], momenta: Sequence[Line], h: sympy.Expr
) -> Iterator[Conserved]:
    """The energies of parts, one for a family each of whose members is in a part of its own, if h is a sum
    over these."""
    found = summand(given, h)
    if found is None:
        return
    loop, energy = found
    for family in given.builder.coordinates:
        kept = [f"h_{name}" for name in family.members if f"h_{name}" in names]
        own = [one for one in momenta if one.family is family]
        if len(kept) < len(family.members) or len(own) > 1 or own[0].loops != (loop,):
            continue
        every = tuple(dict.fromkeys(event for name in kept for event in names[name]))
        because = f"no other member is in the same terms of `L` as `{own[0].name()}`, nor is `t`"
        yield between(Conserved(own[0].name("h_"), energy, because), every)


def summand(given: Given, h: sympy.Expr) -> tuple[Loop, sympy.Expr] | None:
    """What the members of one loop have of an energy that is a sum over these, none of which contains
    coordinates of another; None where it is of another kind."""
    loops, parts = set[Loop](), []
    coordinates = {one.name for one in given.builder.coordinates}
    coordinates |= {velocity_name(name) for name in coordinates}
    for term in sympy.Add.make_args(h):
        factors = sympy.Mul.make_args(term)
        sums = [one for one in factors if isinstance(one, Summed)]
        if len(sums) != 1 or len(sums[0].loops) != 1 or sums[0].body.atoms(Loops):
            return None
        loop, own = sums[0].loops[0], sympy.Mul(*(sums[0].body if one is sums[0] else one for one in factors))
        loops.add(loop)
        parts.append(own)
        for symbol in own.free_symbols:
            name, bracket, _ = symbol.name.partition("[")
            if name in coordinates and symbol.name != f"{name}{bracket}{loop.index}]":
                return None
    return (loops.pop(), sympy.Add(*parts)) if len(loops) == 1 else None


def between(each: Conserved, breaks: Sequence[str]) -> Conserved:
    """A conserved quantity with the events that may change it."""
    because = f"{each.because}; {between_events(breaks)}" if breaks else each.because
    return replace(each, because=because, breaks=tuple(breaks))


def cyclic(given: Given, names: Mapping[str, Sequence[str]], momenta: Sequence[Line]) -> Iterator[Conserved]:
    """Momenta of cyclic coordinates: one for a family, if all of its members are cyclic, and one for members
    side by side or at equal distances, if some are. The ``names`` of what is conserved come with the events
    that may change it."""
    for family in given.builder.coordinates:
        own = [line for line in momenta if line.family is family]
        kept = [name for name in family.members if f"p_{name}" in names]
        if len(kept) == len(family.members):
            shown: Iterable[tuple[str, sympy.Expr, str, Sequence[str]]] = (
                (name, one.expression, "", [name] if f"p_{name}" in names else kept)
                for one in own
                for name in [one.name()]
            )
        else:
            shown = in_blocks(family, kept)
        for name, expression, which, members in shown:
            because = f"`{name}` is cyclic{which}: `L` does not contain it, and {without_force(False)}"
            breaks = dict.fromkeys(event for member in members for event in names[f"p_{member}"])
            yield between(Conserved(f"p_{name}", expression, because), [*breaks])


def in_blocks(family: Family, kept: Sequence[str]) -> Iterator[tuple[str, sympy.Expr, str, Sequence[str]]]:
    """Some members of a family, those together whose indices are in ranges: what they are called, 0, for
    which indices, and which they are."""
    found = dict[str, tuple[str, sympy.Expr, str, Sequence[str]] | None]()
    for ranges, members in blocks(family, {*kept}):
        indices = [index if len(one) > 1 else str(one[0]) for index, one in zip(INDICES, ranges)]
        which = " and ".join(f"`{i}` = {several(one)}" for i, one in zip(INDICES, ranges) if len(one) > 1)
        block = f"{family.name}[{','.join(indices)}]", sympy.S.Zero, f" for {which}", members
        found |= {name: block if name == members[0] else None for name in members}
    for name in kept:
        one = found.get(name, (name, sympy.S.Zero, "", [name]))
        if one is not None:
            yield one


def displaced(given: Given, momenta: Sequence[Line]) -> Iterator[tuple[str, sympy.Expr]]:
    """What displacements of all particles, or of all members of a family, conserve."""
    if given.spec.lagrangian is not None or not given.system.straight:
        for family in given.builder.coordinates:
            yield f"P_{family.name}", of_family(momenta, family.name)
    if given.spec.lagrangian is not None:
        return
    if not given.system.straight:
        yield from of_coordinates(given, momenta)
        return
    particles = [*given.particles()]
    rate, t = given.builder.rate, sympy.Symbol(TIME)

    def total(of: object) -> sympy.Expr:
        return sympy.Add(*(Summed(of(place, mass), Loops(loops)) for loops, place, mass in particles))  # type: ignore[operator]

    axes = max(len(place) for _, place, _ in particles)
    for k in range(axes):
        momentum = total(lambda x, m, k=k: m * rate(x[k]) if len(x) > k else sympy.S.Zero)
        centre = total(lambda x, m, k=k: m * x[k] if len(x) > k else sympy.S.Zero)
        yield f"P_{COMPONENTS[k]}", momentum
        yield f"K_{COMPONENTS[k]}", t * momentum - centre
    for name, (i, j) in TURNS.items():
        if max(i, j) < min(len(place) for _, place, _ in particles):
            yield f"L_{name}", total(lambda x, m, i=i, j=j: m * (x[i] * rate(x[j]) - x[j] * rate(x[i])))


def of_family(momenta: Sequence[Line], family: str, other: str = "") -> sympy.Expr:
    """The sum of the momenta of a family, each times the same member of another, if one is named."""
    found = []
    for line in momenta:
        if line.family.name == family:
            factor = symbol_of(line, other) if other else sympy.S.One
            found.append(Summed(factor * line.expression, Loops(line.loops)))
    return sympy.Add(*found)


def of_coordinates(given: Given, momenta: Sequence[Line]) -> Iterator[tuple[str, sympy.Expr]]:
    """What displacements of all particles on chains and trees, or in a field, conserve: momenta of what
    changes."""
    rigid = Rigid(given.system)
    particles = [*given.particles()]
    for k, name in enumerate(COMPONENTS):
        for kind in "PKL":
            parts = rigid.parts(f"{kind}_{name}")
            if parts is None:
                continue
            made = sympy.Add(
                *(
                    number(one.factor)
                    * of_family(momenta, one.family.name, one.other.name if one.other else "")
                    for one in parts
                )
            )
            if kind == "K":
                centre = (Summed(m * x[k], Loops(loops)) for loops, x, m in particles if len(x) > k)
                made = sympy.Symbol(TIME) * made - sympy.Add(*centre)
            yield f"{kind}_{name}", made

"""The cases of a seed."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from benchmarks.truth.case import Case, Draw
from benchmarks.truth.families import (
    barriers,
    ends,
    friction,
    impacts,
    integrals,
    products,
    pulses,
    quadratures,
    rest,
    switches,
    walls,
)
from benchmarks.truth.families.line import Kind, beside

FAMILIES: Mapping[str, Sequence[Kind]] = {
    "walls": walls.KINDS,
    "friction": friction.KINDS,
    "switches": switches.KINDS,
    "pulses": pulses.KINDS,
    "barriers": barriers.KINDS,
    "ends": ends.KINDS,
    "impacts": impacts.KINDS,
    "quadratures": quadratures.KINDS,
    "rest": rest.KINDS,
    "integrals": integrals.KINDS,
    "products": products.KINDS,
}
"""The kinds of motions by family."""
DRAWS = 3
"""How many cases of each kind there are."""
PLAIN = ("q", "v", "h")
BESIDE = 0.25
"""How often another coordinate moves beside, where only these outputs are asked for."""


def cases(seed: int, draws: int = DRAWS, only: Sequence[str] = ()) -> Iterator[Case]:
    """All cases of a seed, or those whose family or kind is named; each depends on the seed and its name
    alone."""
    for family, kinds in FAMILIES.items():
        for kind in kinds:
            for k in range(draws):
                name = f"{kind.__name__}_{k}"
                if not only or {family, kind.__name__, name} & {*only}:
                    yield made(seed, family, kind, name)


def made(seed: int, family: str, kind: Kind, name: str) -> Case:
    """One case with its file."""
    source = random.Random(f"{seed} {name}")
    draw = Draw(source)
    case = kind(draw)
    if source.random() < BESIDE and case.outputs == PLAIN:
        case = beside(draw, case)
    text = case.system.written(draw.numbers, source, case.over)
    return replace(case, family=family, name=name, text=text)

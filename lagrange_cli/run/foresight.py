"""Large systems are refused before they are derived, where the same file with smaller sizes shows that their
equations are certain to be too large.

Members of a family are alike: what the derivation of N of them takes grows at least as it does for a few, and
not more slowly from some N on. Where that may be otherwise (the file has large whole numbers beside indices,
or the growth slackens), nothing is foreseen.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from itertools import pairwise
from typing import TYPE_CHECKING

from lagrange_cli.errors import LagrangeError
from lagrange_cli.limits import Work, allow_nodes
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.mechanics.residual import Residual
    from lagrange_cli.spec.spec import Spec

STEP = 12
"""Coordinates that a smaller system has more than the one before it, and members if each has one."""
FEWEST = 4
"""Members that it has more at least."""
COUNT = 4
"""How many smaller systems are derived."""
LEAST = 200
"""The size from which on this saves time."""
SHORT = 1_000_000
"""Steps of work that a smaller system may take: about a second."""
MARGIN = 1.25
"""How many times the limit what is foreseen has to be: conditions such as i % 10 == 0 make growth uneven."""
INDEXED = re.compile(r"\[[^\[\]]*\]|range\([^()]*\)|\bif\b[^()\[\]]*|\w+\s*[<>=]=\s*\w+|\w+\s*[<>]\s*\w+")
WHOLE = re.compile(r"(?<![\w.])\d+(?![\w.])")
EXPONENT = re.compile(r"(?<=[\d.])[eE][-+]?\d+")


@dataclass(frozen=True)
class Measure:
    """What the equations of a system take: ``count`` finds it for each of their formulations, and ``refuse``
    raises ``TooLarge`` where so much at least is too much, for equations like those given."""

    count: Callable[[Residual], Mapping[str, int]]
    refuse: Callable[[int, Residual], object]


def foresee_sizes(
    spec: Spec,
    derive: Callable[[Spec, int], tuple[Work, Residual]],
    measures: Callable[[], Sequence[Measure]] = list,
) -> None:
    """Raise ``TooLarge`` where deriving the equations, or what they take then by any of the ``measures``, is
    certain to be too much.

    ``derive`` returns the work that a smaller system took, for which it may take so many steps, and its
    equations.
    """
    large = [name for name, size in spec.sizes.items() if size > COUNT * STEP]
    if len(large) != 1 or spec.sizes[large[0]] < LEAST:
        return
    (name,) = large
    step = step_of(spec.text, len(spec.coordinates) / spec.sizes[name])
    if not alike(spec.text, step):
        return
    from lagrange_cli.spec.read import read_spec

    counts, steps, nodes, found = [], [], [], []
    with suppress(LagrangeError):
        for size in smaller_sizes(step):
            sizes = {one: f"{given}" for one, given in spec.sizes.items()} | {name: f"{size}"}
            smaller = read_spec(spec.text, spec.filename, sizes)
            work, residual = derive(smaller, SHORT)
            counts.append(len(smaller.coordinates))
            steps.append(work.spent - work.tried)
            nodes.append(work.nodes - work.tried_nodes)
            found.append(residual)
    if len(counts) < COUNT or not all(a < b for a, b in pairwise(counts)):
        return

    def foreseen(values: Sequence[int]) -> int:
        even = "%" not in spec.text and "//" not in spec.text
        return int(least(values, spec.sizes[name], even, step) / MARGIN)

    allow_nodes(foreseen(nodes))
    Work().foresee(foreseen(steps))
    for measure in measures():
        taken = []
        with suppress(LagrangeError):
            taken = [measure.count(residual) for residual in found]
        if taken and all(taken[-1].keys() <= one.keys() for one in taken):
            measure.refuse(min(foreseen([one[name] for one in taken]) for name in taken[-1]), found[-1])


def step_of(text: str, each: float) -> int:
    """How many members a smaller system has more than the one before it, where each has so many coordinates:
    few if they have many, but more than any whole number beside indices."""
    largest = max(written_beside_indices(text), default=0)
    return max(FEWEST, math.ceil(STEP / each), min(largest + 1, STEP))


def smaller_sizes(step: int) -> Sequence[int]:
    """The sizes of the smaller systems."""
    return [step * k for k in range(1, COUNT + 1)]


def alike(text: str, step: int = STEP) -> bool:
    """Whether a file has only whole numbers beside indices that are small next to the sizes of the smaller
    systems, so that what holds for these holds for all."""
    return all(number < step for number in written_beside_indices(text))


def written_beside_indices(text: str) -> Sequence[int]:
    """The whole numbers beside indices."""
    text = EXPONENT.sub(".0", re.sub(r"#.*", "", text))
    return [int(number) for part in INDEXED.findall(text) for number in WHOLE.findall(part)]


def least(values: Sequence[int], size: int, even: bool, step: int = STEP) -> float:
    """What is reached at a size at least, from the ``values`` at ``smaller_sizes``; 0 where growth slackens.
    Where it is ``even``, so are its differences."""
    growth = [b - a for a, b in pairwise(values)]
    bends = [b - a for a, b in pairwise(growth)]
    if min(growth) <= 0 or MARGIN * growth[-1] < max(growth):
        return 0.0
    further = (size - COUNT * step) / step
    if even and min(bends) > 0:
        return values[-1] + further * growth[-1] + further * (further + 1) / 2 * min(bends)
    return values[-1] + further * min(growth)

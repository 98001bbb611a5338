"""Large systems are refused before they are derived, where the same file with smaller sizes shows that their
equations are certain to be too large.

Members of a family are alike: what the derivation of N of them takes grows at least as it does for a few, and
not more slowly from some N on. Where that may be otherwise (the file has large whole numbers beside indices,
or the growth slackens), nothing is foreseen.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import pairwise
from typing import TYPE_CHECKING

from lagrange_cli.errors import LagrangeError
from lagrange_cli.limits import Work, allow_nodes

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec

STEP = 12
SMALLER = STEP, 2 * STEP, 3 * STEP, 4 * STEP
"""The sizes of the smaller systems."""
LEAST = 200
"""The size from which on this saves time."""
SHORT = 1_000_000
"""Steps of work that a smaller system may take: about a second."""
MARGIN = 1.25
"""How many times the limit what is foreseen has to be: conditions such as i % 10 == 0 make growth uneven."""
INDEXED = re.compile(r"\[[^\[\]]*\]|range\([^()]*\)|\bif\b[^()\[\]]*|\w+\s*[<>=]=\s*\w+|\w+\s*[<>]\s*\w+")
WHOLE = re.compile(r"(?<![\w.])\d+(?![\w.])")


def foresee_sizes(spec: Spec, derive: Callable[[Spec, int], Work]) -> None:
    """Raise ``TooLarge`` where deriving the equations is certain to take too much.

    ``derive`` returns the work that a smaller system took, for which it may take so many steps.
    """
    large = [name for name, size in spec.sizes.items() if size > SMALLER[-1]]
    if len(large) != 1 or spec.sizes[large[0]] < LEAST or not alike(spec.text):
        return
    from lagrange_cli.spec.read import read_spec

    (name,) = large
    counts, steps, nodes = [], [], []
    with suppress(LagrangeError):
        for size in SMALLER:
            sizes = {one: f"{given}" for one, given in spec.sizes.items()} | {name: f"{size}"}
            smaller = read_spec(spec.text, spec.filename, sizes)
            work = derive(smaller, SHORT)
            counts.append(len(smaller.coordinates))
            steps.append(work.spent - work.tried)
            nodes.append(work.nodes - work.tried_nodes)
    if len(counts) < len(SMALLER) or not all(a < b for a, b in pairwise(counts)):
        return
    even = "%" not in spec.text and "//" not in spec.text
    allow_nodes(least(nodes, spec.sizes[name], even) / MARGIN)
    Work().foresee(int(least(steps, spec.sizes[name], even) / MARGIN))


def alike(text: str) -> bool:
    """Whether a file has only whole numbers beside indices that are small next to the sizes of the smaller
    systems, so that what holds for these holds for all."""
    text = re.sub(r"#.*", "", text)
    written = (number for part in INDEXED.findall(text) for number in WHOLE.findall(part))
    return all(int(number) < STEP for number in written)


def least(values: Sequence[int], size: int, even: bool) -> float:
    """What is reached at a size at least, from the ``values`` at ``SMALLER``; 0 where growth slackens. Where
    it is ``even``, so are its differences."""
    growth = [b - a for a, b in pairwise(values)]
    bends = [b - a for a, b in pairwise(growth)]
    if min(growth) <= 0 or MARGIN * growth[-1] < max(growth):
        return 0.0
    further = (size - SMALLER[-1]) / STEP
    if even and min(bends) > 0:
        return values[-1] + further * growth[-1] + further * (further + 1) / 2 * min(bends)
    return values[-1] + further * min(growth)

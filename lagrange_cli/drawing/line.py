"""Particles with one component: where they are drawn when all of them would lie on each other.

The components are elongations from places of rest that the file does not tell. Few of them are drawn beside
each other, as in a textbook; a long chain is drawn like a string, with the elongations across it. The wall
that holds a spring without a length at rest is drawn away from it, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from lagrange_cli.drawing.scene import Place, Scene
from lagrange_cli.drawing.springs import Spring
from lagrange_cli.expression.node import Node
from lagrange_cli.records import replace

FEW = 4
"""Up to this many are moved apart along their line."""
APART = 3.0
"""The distance, in units of their amplitude."""


def spread(scene: Scene, springs: list[Spring]) -> list[Spring]:
    """Move the flat particles of the scene apart, if they start where others are; the springs with the ends
    that they have then."""
    flat = [name for name in scene.positions if name in scene.flat]
    alone = len(flat) == 1
    if not flat or scene.dimension != 2 or not (alone or lie_together(_starts(scene, flat))):
        return springs
    size, along = scene.swing(), 1 if scene.upright else 0
    last = len(flat) - 1
    string = len(flat) > FEW

    def there(k: int, value: Node) -> Place:
        """The place of number ``k``."""
        if string:
            return (scene.graph.constant(8 * size * (k + 1) / (last + 2)), value)
        return scene.lifted((value + APART * size * k,))

    for k, name in enumerate(flat):
        scene.positions[name] = there(k, scene.positions[name][along])
    found = []
    taken = set[int]()
    for one in springs:
        if isinstance(one.start, tuple) and one.slack and one.end in scene.flat:
            k = flat.index(one.end)
            beyond = k + 1 if k == last and (not alone or -1 in taken) else k - 1
            taken.add(beyond)
            one = replace(one, start=there(beyond, one.start[along]))
        found.append(one)
    return found


def _starts(scene: Scene, flat: list[str]) -> list[float]:
    """Where flat particles start."""
    along = 1 if scene.upright else 0
    return [scene.now(scene.positions[name])[along] for name in flat]


def lie_together(start: Sequence[float]) -> bool:
    """Whether particles start in another order than that of the file, or some of them at one place."""
    steps = [b - a for a, b in pairwise(start)]
    one_way = all(step > 0 for step in steps) or all(step < 0 for step in steps)
    return not one_way or min(map(abs, steps)) < 0.05 * max(map(abs, steps))

"""What is drawn at random: which cases of exhaustive suites are run, how many examples hypothesis tries.

``@pytest.mark.exhaustive(keep=4)`` marks a suite of too many cases for every day. With ``-m exhaustive
--times 1`` four of them are run, other ones each time; the last lines of the run give the seed, and
``--seed`` repeats the draw. Where a case takes long, one is run now and then: with ``keep=0.5`` in half of
these runs. With ``--times 2`` it is twice as many cases of each, and two where usually none is run; without
options it is the part ``USUAL`` of them.
``-m exhaustive`` alone runs all cases of all such suites (or ``most`` of them), and hypothesis tries more
examples. A case that is named on the command line is always run.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

import pytest
from hypothesis import settings

MARKER = "exhaustive"
USUAL = 0.6
"""The part of ``keep`` that is run without options: README's line for the tests is to take minutes."""
THOROUGH = 5
"""So many times as many examples are tried under ``-m exhaustive`` without ``--times``."""
_thorough = False


def be_thorough() -> None:
    """From now on ``examples`` are many; called before the tests are imported."""
    global _thorough
    _thorough = True


def examples(count: int) -> settings:
    """Hypothesis tries ``count`` examples, and ``THOROUGH`` times as many where all cases are run."""
    return settings(max_examples=count * THOROUGH if _thorough else count)


def sampled(
    items: Sequence[pytest.Item], seed: int, everything: bool, times: float | None = None
) -> list[pytest.Item]:
    """The items without the cases of exhaustive suites that are not drawn: ``everything`` keeps them all, or
    so many ``times`` as many as each suite is to ``keep``."""
    suites: dict[str, list[pytest.Item]] = {}
    for item in items:
        if item.get_closest_marker(MARKER) is not None:
            suites.setdefault(item.nodeid.partition("[")[0], []).append(item)
    left_out: set[pytest.Item] = set()
    for name, cases in suites.items():
        marker = cases[0].get_closest_marker(MARKER)
        assert marker is not None
        chance = random.Random(f"{seed} {name}")
        keep = marker.kwargs.get("keep", 1)
        if not everything:
            count = int(keep * USUAL + chance.random())
        elif times is None:
            count = marker.kwargs.get("most", len(cases))
        else:
            count = int((keep or 1) * times + chance.random())
        drawn = chance.sample(cases, min(count, len(cases)))
        left_out |= {*cases} - {*drawn}
    return [item for item in items if item not in left_out]

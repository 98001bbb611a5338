"""Crossings as datasets."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from lagrange_cli.integrate import event_log
from lagrange_cli.integrate.event_log import EventLog
from lagrange_cli.integrate.events import Crossings
from tests.families.test_events import followed, keep_families, ready

BEADS = """
sizes: {N: 4}
coordinates: {"x[i in range(N)]": {initial: "10*i", velocity: "-i**2"}}
masses: {"bead[i in range(N)]": 1}
positions: {"bead[i in range(N)]": ["x[i]"]}
potential: 0
events:
  "meet[i in range(N), j in range(i)]": {when: "x[i] - x[j] - 1/2"}
  "pass[i in range(1, N)]": {when: "x[i] - 9"}
  "apart[i in range(N), j in range(N) if i != j]": {when: "x[i] - x[j] - 1"}
"""


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("whole", [True, False])
def test_crossings_have_the_indices_of_their_members(whole: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """x[i] - x[j] = (10 - (i + j) t)(i - j), also of families that are not all pairs."""
    keep_families(monkeypatch, whole=whole)
    found = followed(ready(BEADS), BEADS, 9.99)

    def listed(name: str, *indices: str) -> list[tuple[int, ...]]:
        return list(zip(*(found[f"events/{name}/{index}"].astype(int).tolist() for index in indices)))

    def when(i: int, j: int, distance: float) -> float:
        return (10.0 - distance / (i - j)) / (i + j)

    pairs = [(i, j) for i in range(4) for j in range(i)]
    assert listed("meet", "i", "j") == sorted(pairs, key=lambda one: when(*one, 0.5))
    assert listed("pass", "i") == sorted(
        ((i,) for i in range(1, 4)), key=lambda one: (10 * one[0] - 9) / one[0] ** 2
    )
    both = [(i, j) for i in range(4) for j in range(4) if i != j and when(i, j, 1.0) < 9.99]
    assert listed("apart", "i", "j") == sorted(both, key=lambda one: when(*one, 1.0))


@pytest.mark.parametrize(("rows", "handed"), [(2, 1), (2**17, 9)])
def test_crossings_are_handed_over_before_they_take_much_memory(
    rows: int, handed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those of large systems are 1 MB each here, and 8 MB are kept at most; no crossing is lost."""
    group, found = SimpleNamespace(members=("floor",)), list[int]()
    prepared = SimpleNamespace(recording=SimpleNamespace(events=(group,)))
    monkeypatch.setattr(
        event_log, "crossing_datasets", lambda _, gathered: {"t": [one.t for one in gathered]}
    )
    log = EventLog(prepared, SimpleNamespace(balances=False), lambda data: found.append(len(data["t"])))
    for k in range(9 * 8):
        one = np.full(1, float(k))
        log.crossed(Crossings(np.zeros(1, np.int64), one, one, np.zeros((1, rows)), one < 0.0, 0.0 * one))
    log.hand_over()
    assert found == [9 * 8 // handed] * handed

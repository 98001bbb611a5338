"""The estimated errors of families beside the true ones, known to 31 digits."""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.families import consistency
from lagrange_cli.integrate.certify.certificate import FOLDER
from tests.families import test_closed_chains, test_constraints, test_events, test_reactions, test_switches
from tests.families.test_kinds import RING
from tests.integrate.certify.test_certificate import COVERAGE, Number, certified, coverage

KINKS = "\n  - 0.7*sum(max(0, u[i] - 0.2)**2 for i in range(N))\nsolve:"
TREE = test_closed_chains.CHAIN.replace("x[i - 1]", "x[(i - 1)//2]").replace("y[i - 1]", "y[(i - 1)//2]")
CHAINS, SWITCHES = test_closed_chains.CASES, ("stops on both sides", "a ring", "times", "walls", "rods")
EVENTS = "sums, velocities and time", "walls", "kicks", "a parameter"
SHAPES = "a chain", "sums of halves", "wires"


def tree() -> str:
    """A binary tree, one of whose tips is pinned."""
    ends = [" + ".join(f"l*{turn}(-A + {i}*h)" for i in (0, 2, 6)) for turn in ("cos", "sin")]
    constraints = f"right: x[6] - ({ends[0]})\n  level: y[6] - ({ends[1]})"
    return TREE.format(count=7, begin="", speed="", more="", constraints=constraints)


def rods(shape: str) -> str:
    """A system in Cartesian coordinates."""
    start, constraints = test_constraints.SHAPES[shape]
    coordinates = test_constraints.PLACES.format(**start, u="0", w="0")
    potential = test_constraints.POTENTIALS["weights"].format(m="(1 + i/7)")
    return test_constraints.SYSTEM.format(
        count=5, k=0.7, coordinates=coordinates, masses=test_constraints.BEADS.format(mass="1 + i/7"),
        positions=test_constraints.AT, potential=potential, forces="", constraints=constraints,
    )  # fmt: skip


def texts() -> Mapping[str, str]:
    """All systems."""
    ring = RING.format(count=3, nonlinear=2.5, stop=20)
    found = {"a ring": ring, "a ring with kinks": ring.replace("\nsolve:", KINKS), "a tree": tree()}
    found |= {f"a chain, {case}": test_closed_chains.chain(case, 6) for case in CHAINS}
    found |= {f"switches, {case}": test_switches.written(case, 4) for case in SWITCHES}
    for case in EVENTS:
        form, events = test_events.CASES[case]
        found[f"events, {case}"] = form.format(count=4, events=events)
    for case in ("forces", "bodies", "kinks"):
        form, given = test_reactions.MOVED[case]
        found[f"reactions, {case}"] = form.format(count=4, **given)
    return found | {f"places, {shape}": rods(shape) for shape in SHAPES}


TEXTS = texts()


def shares(data: Mapping[str, NDArray[np.float64]], exact: Mapping[str, NDArray[np.float64]]) -> list[float]:
    """The share of samples that are covered, of each number that is estimated."""
    found = []
    for path in (one.removeprefix(FOLDER) for one in data if one.startswith(FOLDER) and "as_run" not in one):
        rows = data[path], data[FOLDER + path], exact[path], exact[f"low/{path}"]
        for run, estimate, *parts in zip(*(one.reshape(len(one), -1).T for one in rows)):
            with mpmath.workdps(50):
                truth = [Number(high) + Number(low) for high, low in zip(*(part.tolist() for part in parts))]
            found.append(coverage({path: run, FOLDER + path: estimate}, path, truth))
    return found


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("name", TEXTS)
@pytest.mark.parametrize("stop", [0.05, 2.0])
def test_the_estimated_error_of_a_family_covers_the_true_one(
    name: str, stop: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of early samples, too: what run and companions have in common at the start is rounded differently."""
    text = TEXTS[name]
    test_events.keep_families(monkeypatch, whole=True)
    monkeypatch.setattr(consistency, "FEWEST", 0)
    outputs = ("q", "v", *(["multipliers"] if "constraints:" in text else []))
    outputs += ("reactions",) if name.startswith("reactions") else ()
    data, _ = certified(text, stop, 22, outputs=outputs)
    _, exact = test_closed_chains.exactly_followed(text, frozenset(outputs), stop, 22)
    found = shares(data, exact.data)
    assert len(found) >= 6 and np.mean(found) >= COVERAGE
    assert all(np.max(data[path]) < 1e-9 for path in data if path.startswith(FOLDER))

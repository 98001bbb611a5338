"""Actions of events on chains and trees with constraints: beside the same systems written out, the mass
matrix beside T, and conservation."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.families.events import random_state
from lagrange_cli.families.impacts.actions import LONG
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.integrate.impacts import impulses
from lagrange_cli.native.families.constraints.matrix import MatrixOfConstraints
from lagrange_cli.spec.read import read_spec
from tests.families.test_bodies import drawn
from tests.families.test_closed_chains import chain
from tests.families.test_locked import CART, CHAIN, HEAD, SPACE, TREE
from tests.support.families import alike, followed

OUTPUTS = frozenset(["q", "v", "h", "constraints", "multipliers", "ledger"])
EVENT = """
events:
  "hit[i in range(N)]":
    {{when: "a[i] - (-A + h*i) - 0.05", direction: rising, action: {{set: {{{sets}}}}}}}
"""
KICK = """
events:
  kick: {{when: "t - 0.2", action: {{set: {{"a_dot[i in range(N)]": "a_dot[i] + 0.3*sin(i)"}}}}}}
"""
ACTIONS = {
    "all turn back": EVENT.replace("{sets}", '"a_dot[j in range(N)]": "-a_dot[j]"'),
    "more weight": EVENT.replace("{sets}", '"g": "1.1*g"'),
    "a kick": KICK,
    "a kick of one": KICK.replace("i in range(N)", "0").replace("[i]", "[0]").replace("sin(i)", "1"),
    "a place": KICK.replace('"a_dot[i in range(N)]": "a_dot[i] + 0.3*sin(i)"', '"a[0]": "a[0] + 0.02"'),
}


@pytest.mark.exhaustive(keep=0.15, most=12)
@pytest.mark.parametrize("few", [64, 0])
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("count", [3, 8, 9])
@pytest.mark.parametrize("action", ACTIONS)
@pytest.mark.parametrize("case", ["pinned", "on a bent rail", "on a rod", "two angles are tied"])
def test_constraints_have_impulses_as_written_out(
    case: str, action: str, count: int, method: str, few: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    count = max(count, 6) if case == "two angles are tied" else count
    text = chain(case, count) + ACTIONS[action].format()
    monkeypatch.setattr(impulses, "FEW", few)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    together, motion = followed(text, OUTPUTS, 0.4, 4, method)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 10**9)
    systems._LATEST.clear()
    apart, expected = followed(text, OUTPUTS, 0.4, 4, method)
    assert together.machine.program.loops and not apart.machine.program.loops
    assert motion.data.keys() == expected.data.keys()
    assert together.recording.conserved == apart.recording.conserved
    alike(motion.data, expected.data, 2.0**-32)


TIES = {
    "a chain": "bob[N - 1].x + bob[N - 2].y*a[0]",
    "a tree": "bob[N - 1].x + bob[N - 2].y**2",
    "a chain in space": "bob[N - 1].x*bob[N - 2].z",
    "a chain on a cart": "bob[N - 1].y - x*a[1]",
    "hinged rods": "body[N - 1].y - 0.1*body[N - 2].z",
    "gyroscopes on a chain": "body[N - 1].y + c[0]",
    "rods on ball joints": "body[N - 1].x*body[0].y",
}
CHAINS = {"a chain": CHAIN, "a tree": TREE, "a chain in space": SPACE, "a chain on a cart": CART}


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("count", [3, 8, 9])
@pytest.mark.parametrize("case", TIES)
def test_the_matrix_of_impulses_is_that_of_the_energy(
    case: str, count: int, monkeypatch: pytest.MonkeyPatch, pytestconfig: pytest.Config
) -> None:
    """M is d2T/dq_dot2, and A is df/dq, by differences that are exact for squares, and by small ones."""
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    if case in CHAINS:
        text = (HEAD + CHAINS[case]).format(count=count, start="0.3", speed="1")
    else:
        text = drawn(random.Random(f"{pytestconfig.option.seed} {case}"), case, count)
    system = systems.made(read_spec(f'{text}\nconstraints: {{tie: "{TIES[case]}"}}\n', "system.yaml"))
    t, q, v, parameters = random_state(system, 3)
    assert system.bonds is not None
    matrix, n, count = MatrixOfConstraints(system), len(q), system.bonds.count
    found = np.zeros((n + count, n + count))
    places = np.array(matrix.pattern).T
    found[places[0], places[1]] = FamilyValues(system, t, q, v, parameters).of(matrix.entries)
    unit = np.eye(n)
    states = np.array([0.0 * unit[0], *unit, *(unit[i] + unit[j] for i in range(n) for j in range(n))]).T
    moving = FamilyValues(system, t, np.repeat(q[:, None], states.shape[1], axis=1), states, parameters)
    rest, *energies = np.ravel(moving.node(system.kinetic))
    single, both = np.array(energies[:n]), np.array(energies[n:]).reshape(n, n)
    expected = both - single[:, None] - single + rest
    assert np.allclose(found[:n, :n], expected, rtol=0.0, atol=1e-12 * np.max(both))
    above, below = (
        FamilyValues(system, t, q[:, None] + step * unit, 0.0 * unit, parameters).of(system.bonds.values)
        for step in (1e-6, -1e-6)
    )
    assert np.allclose(-found[n:, :n], (above - below) / 2e-6, rtol=0.0, atol=1e-7)
    assert np.array_equal(found, found.T)


@pytest.mark.exhaustive(keep=0.2)
def test_a_kick_obeys_the_constraints_and_takes_the_least_energy(monkeypatch: pytest.MonkeyPatch) -> None:
    """A pinned chain of 60 links at rest: one velocity is set, and the others follow."""
    text = chain("pinned", 60) + ACTIONS["a kick of one"].format()
    _, motion = followed(text, OUTPUTS, 0.4, 9, "taylor")
    data = motion.data
    for path in ("right", "level"):
        assert np.max(np.abs(data[f"diagnostics/constraints/{path}"])) <= 1e-14
    h = data["diagnostics/h"]
    before, after = data["t"] < 0.2, data["t"] > 0.2
    assert np.allclose(h[before], h[0], atol=1e-13) and np.allclose(h[after], h[-1], atol=1e-12)


def test_very_long_chains_are_written_out() -> None:
    text = chain("pinned", 800) + ACTIONS["a kick"].format()
    spec = read_spec(text, "system.yaml")
    assert systems.any_family_system(spec) is None and systems.reason(spec) == LONG

"""Chains and trees in relative coordinates whose hinges have stops that reduce the speed: beside the same
systems written out."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from tests.families.test_coupled_contacts import motion
from tests.families.test_relative_joints import ANGLES, MASSES, drawn, is_relative, text
from tests.support.families import followed

EVENT = '"{name}[i in range({first}, N)]": {{when: "{when}", direction: {way}, action: {{set: {{{sets}}}}}}}'
LOW, HIGH = ("phi[i] - ({seed}*sin(i + {seed}) {sign} 0.1 {sign} 0.02*i)".replace("{sign}", s) for s in "-+")
SLOWER = '"phi_dot[i]": "-{e}*phi_dot[i]"'
PULLED = SLOWER + ', "phi_dot[i - 1]": "phi_dot[i - 1] + 0.3*(1 + {e})*phi_dot[i]"'
CASES = {
    "stops": [("low", 0, LOW, "falling", SLOWER)],
    "stops on both sides": [("low", 0, LOW, "falling", SLOWER), ("high", 0, HIGH, "rising", SLOWER)],
    "stops that pull the link before": [("low", 1, LOW, "falling", PULLED)],
    "stops that move": [("low", 0, LOW + " + 0.05*sin(3*t)", "falling",
                         SLOWER.replace('"-{e}', '"-0.15*(1 + {e})*cos(3*t) - {e}'))],
    "stops between joints": [("low", 1, "phi[i] - phi[i - 1] + 1.2", "falling",
                              '"phi_dot[i]": "phi_dot[i] - (1 + {e})*(phi_dot[i] - phi_dot[i - 1])"')],
}  # fmt: skip


def stopped(case: str, angles: str, masses: str, count: int, e: float, seed: float) -> str:
    """An arm with stops."""
    events = "\n  ".join(
        EVENT.format(name=name, first=first, when=when.format(seed=seed), way=way, sets=sets.format(e=e))
        for name, first, when, way, sets in CASES[case]
    )
    return text(count, angles, masses, "fixed", "none", seed) + f"\nevents:\n  {events}\n"


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("count", [2, 3, 8, 9])
@pytest.mark.parametrize("angles", ANGLES)
@pytest.mark.parametrize("case", CASES)
def test_links_rest_as_written_out(
    case: str, angles: str, count: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance, seed, _ = drawn(pytestconfig, angles, case, count)
    e = chance.choice([0.0, 0.3, 0.6])
    masses = chance.choice([*MASSES])
    given, *others = (
        stopped(case, angles, masses, count, e, one) for one in (seed, seed + 2.0**-41, seed - 2.0**-41)
    )
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    assert is_relative(given)
    found, expected = (motion(given, 0.4, whole=whole, patch=monkeypatch) for whole in (True, False))
    beside = [motion(other, 0.4, whole=True, patch=monkeypatch) for other in others]
    for path in (one for one in expected if not one.startswith("events/")):
        size = max(1.0, float(np.max(np.abs(expected[path]))))
        # rounding errors grow as the distances from motions that begin beside it; these have such errors,
        # too, which are most of them where M is badly conditioned, so that they scatter
        apart = max(float(np.max(np.abs(found[path] - other[path]))) for other in beside)
        most = max(2.0**-33 * size, 4.0 * apart)
        assert np.max(np.abs(found[path] - expected[path])) <= most, (path, given)


@pytest.mark.exhaustive(keep=0.4)
def test_links_of_long_arms_rest_at_their_stops() -> None:
    """40 links. With members written out 30 were refused."""
    given = stopped("stops", "one after the other", "points", 40, 0.0, 0.5)
    _, found = followed(given, frozenset(["q", "v"]), 0.2)
    starts = np.array([0.5 * np.sin(i + 0.5) for i in range(40)])
    limits = starts - 0.1 - 0.02 * np.arange(40)
    assert np.all(found["q/phi"] >= limits - 1e-12)
    held = found["v/phi"][-1] == 0.0
    assert np.any(held) and np.max(np.abs(found["q/phi"][-1] - limits)[held]) < 1e-12

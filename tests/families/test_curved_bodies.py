"""Rigid bodies with more coordinates than joints have, beside the same systems written out."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from tests.families.test_closed_chains import exactly_followed
from tests.families.test_curved_masses import curved, in_loops
from tests.support.families import alike, followed

OF_BODIES = "angular_velocities", "angular_momenta", "rotational_energies", "orientations"
OUTPUTS = frozenset(
    ["q", "v", "p", "h", "T", "U", "energy", "positions", "conserved", "ledger", "action", *OF_BODIES]
)
SLIDING = """
sizes: {{N: {count}}}
coordinates:
  x[i in range(N)]: {{initial: i, velocity: 0.1}}
  y[i in range(N)]: {{initial: 0.3, velocity: 0}}
  a[i in range(N)]: {{initial: 0.1, velocity: 0.3}}
  b[i in range(N)]: {{initial: {tilt}, velocity: 0}}
  c[i in range(N)]: {{initial: 0.2*i, velocity: 20}}
bodies:
  top[i in range(N)]:
    mass: 1 + i/9
    inertia: {inertia}
    position: ["x[i] + sin(b[i])*sin(a[i])", "y[i] - sin(b[i])*cos(a[i])", "cos(b[i])"]
    orientation: {{sequence: zxz, euler: ["a[i]", "b[i]", "c[i]"]}}
potential: sum(9.81*top[i].z for i in range(N)) + {potential}
{forces}
"""
"""Tops whose tips slide on a plane."""
INERTIAS = ["[0.6, 0.6, 0.2]", "[0.6, 0.5, 0.2 + i/50]"]
POTENTIALS = {
    "nothing": "0",
    "springs": "sum(4*(x[i + 1] - x[i] - 1)**2 + (y[i + 1] - y[i])**2 for i in range(N - 1))",
    "wells": "sum(x[i]**2 + a[i]**2/3 for i in range(N))",
}
FORCES = {"nothing": "", "drag": "dissipation: sum(c_dot[i]**2/50 + x_dot[i]**2/9 for i in range(N))"}


def text_of(
    count: int, tilt: float, inertia: str, potential: str = "nothing", forces: str = "nothing"
) -> str:
    """The text of a system."""
    return SLIDING.format(
        count=count, tilt=tilt, inertia=inertia, potential=POTENTIALS[potential], forces=FORCES[forces]
    )


def bodies_in_loops(monkeypatch: pytest.MonkeyPatch, *, loops: bool) -> None:
    """Members are followed in loops however few, or never."""
    in_loops(monkeypatch, loops=loops)
    monkeypatch.setattr(systems, "FEWEST_SLIDING", 0 if loops else 10**9)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("case", range(12))
def test_bodies_move_as_they_do_one_by_one(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} sliding {case}")
    text = text_of(
        chance.choice([3, 8, 9]), chance.uniform(0.2, 1.2), chance.choice(INERTIAS),
        chance.choice(sorted(POTENTIALS)), chance.choice(sorted(FORCES)),
    )  # fmt: skip
    method = chance.choice(["taylor", "ias15", "DOP853"])
    bodies_in_loops(monkeypatch, loops=True)
    assert curved(text).bodies
    together, found = followed(text, OUTPUTS, method=method)
    assert together.machine.program.loops
    bodies_in_loops(monkeypatch, loops=False)
    apart, expected = followed(text, OUTPUTS, method=method)
    assert not apart.machine.program.loops
    known = {path: values for path, values in expected.data.items() if "conserved" not in path}
    assert known.keys() <= found.data.keys()
    alike(found.data, known, 2.0**-38 if method != "DOP853" else 1e-8, text, method)
    for path, values in found.data.items():
        if "conserved" in path:
            size = np.max(np.abs(values))
            assert np.ptp(values) < (1e-12 if method != "DOP853" else 1e-8) * (1 + size), (path, text)


@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_sliding_tops_close_to_the_vertical_keep_all_digits(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    text, outputs = text_of(9, 0.001, INERTIAS[0]), frozenset(["q", "v"])
    bodies_in_loops(monkeypatch, loops=False)
    _, exact = exactly_followed(text, outputs)
    bodies_in_loops(monkeypatch, loops=True)
    ready, motion = followed(text, outputs, stop=0.2, samples=3, method=method)
    assert ready.machine.program.loops and motion.outcome.steps < 25
    for path in "q/a", "q/b", "q/c":
        assert np.max(np.abs(motion[path] - exact[path])) < 1e-14 * np.max(np.abs(exact[path])), path


def test_many_sliding_tops_are_followed_in_loops() -> None:
    ready, motion = followed(text_of(300, 0.8, INERTIAS[0], "springs"), frozenset(["q", "h"]))
    assert ready.machine.program.loops and np.ptp(motion["diagnostics/h"]) < 1e-10

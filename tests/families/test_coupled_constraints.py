"""Constraints where M is constant but not diagonal, beside the same systems written out member by member."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.spec.read import read_spec
from tests.support.families import alike, followed

SIZES = 3, 4, 8, 9, 17
OUTPUTS = frozenset(["q", "v", "p", "h", "T", "U", "constraints", "multipliers", "conserved"])
PLACES = {"u": "0.2*({} + 1) + sin({})/9", "w": "cos(2*({}))/2"}
"""The coordinates at the start."""
OWN = "sum((1 + i/7)*u_dot[i]**2/2 + k*w_dot[i]**2 for i in range(N))"
KINETIC = {
    "neighbours": f"{OWN} + sum(u_dot[i]*u_dot[i + 1]/4 for i in range(N - 1))",
    "elements": (
        "sum(k*(u_dot[i]**2 + u_dot[i]*u_dot[i + 1] + u_dot[i + 1]**2)/6 for i in range(N - 1))"
        " + sum((w_dot[i] + w_dot[(i + 1) % N]/3)**2/2 for i in range(N))"
    ),
    "two families": f"{OWN} + sum(u_dot[i]*w_dot[i]/(3 + i) for i in range(N))",
    "all": f"{OWN} + sum(u_dot[i]*u_dot[j]/(4*N) for i in range(N) for j in range(N))",
    "some": f"{OWN} + sum(u_dot[i]*w_dot[(3*i) % N]/5 for i in range(N) if i % 2)",
}
PARTICLES = """
masses: {'bead[i in range(N)]': '1 + i/7', 'other[i in range(N)]': 2.0}
embedding:
  bead[i in range(N)]: ["u[i] - w[(i + 1) % N]/3", "k*u[i]"]
  other[i in range(N)]: "k*w[i] + u[(2*i) % N]/2"
"""
POTENTIALS = {
    "springs": "sum(k*(u[i + 1] - u[i])**2/2 for i in range(N - 1)) + sum(w[i]**2 for i in range(N))",
    "waves": "sum(cos(u[i] + 2*w[i]) for i in range(N))",
    "pairs": "sum(u[i]*w[i] + (u[i] - w[(i + 1) % N])**4/4 for i in range(N))",
}
FORCES = {
    "none": "",
    "pushes": "generalized_forces: {'u[i in range(N)]': 0.3*sin(2*t + i)}",
    "drag": "dissipation: sum(u_dot[i]**2/20 + w_dot[i]*u_dot[i]/30 for i in range(N))",
}
HOLONOMIC = {
    "a pin": "pin: u[0] - {u0}",
    "links": "link[i in range(N//3)]: u[3*i] - w[3*i + 1] - ({u3} - {w3})",
    "curves": "curve[i in range(N//2)]: sin(u[2*i]) + w[2*i]*u[2*i] - sin({u2}) - {w2}*{u2}",
    "a mean": "mean: sum(u[i] for i in range(N)) - sum({ui} for i in range(N))",
    "a sphere": "whole: sum(u[i]**2 + w[i]**2 for i in range(N)) - sum({ui}**2 + {wi}**2 for i in range(N))",
    "a drive": "drive: w[0] - {w0} - t**2/3",
    "a turning line": "line: u[1]*cos(t) + w[1]*sin(t) - {u1}",
}
NONHOLONOMIC = {
    "a skate": "skate: cos(u[2])*u_dot[1] - sin(u[2])*w_dot[2]",
    "rolling": "roll[i in range(N//2)]: w_dot[2*i + 1] - u[2*i]*u_dot[2*i]",
    "a speed": "speed: u_dot[N - 1] + w_dot[N - 1]/2 - cos(t)/5",
}


def places() -> dict[str, str]:
    """The coordinates at the start, as constraints need them."""
    found = {}
    for name, text in PLACES.items():
        for key, index in {"0": "0", "1": "1", "3": "3*i", "2": "2*i", "i": "i"}.items():
            value = text.format(index, index)
            found[f"{name}{key}"] = f"({value})"
    found["w3"] = f"({PLACES['w'].format('3*i + 1')})"
    return found


def drawn(chance: random.Random) -> str:
    """The text of a random system."""
    potential = POTENTIALS[chance.choice(sorted(POTENTIALS))]
    if chance.random() < 0.3:
        kinetic = f"{PARTICLES}potential: {potential}"
    else:
        kinetic = f"lagrangian: >-\n  {KINETIC[chance.choice(sorted(KINETIC))]}\n  - ({potential})"
    bound = chance.sample(sorted(HOLONOMIC), chance.randint(0, 2))
    rolling = chance.sample(sorted(NONHOLONOMIC), chance.randint(0 if bound else 1, 1))
    return text_of(
        kinetic, chance.choice(SIZES), FORCES[chance.choice(sorted(FORCES))],
        [HOLONOMIC[one] for one in bound], [NONHOLONOMIC[one] for one in rolling],
    )  # fmt: skip


def text_of(kinetic: str, count: int, forces: str, holonomic: list[str], nonholonomic: list[str]) -> str:
    """The text of a system."""
    known = places()
    lines = [f"sizes: {{N: {count}}}", "parameters: {k: 1.5}", "coordinates:"]
    for name, value in PLACES.items():
        lines.append(f'  {name}[i in range(N)]: {{initial: "{value.format("i", "i")}"}}')
    lines += [kinetic, forces]
    for key, listed in (("constraints", holonomic), ("nonholonomic", nonholonomic)):
        written = [one.format(**known).split(": ", 1) for one in listed]
        lines += [f"{key}:"] * bool(listed) + [f'  {name}: "{text}"' for name, text in written]
    return "\n".join(lines)


def coupled(text: str) -> FamilySystem:
    """A system that is one of families, with constraints and an M that is not diagonal."""
    system = systems.family_system(read_spec(text, "system.yaml"))
    assert system is not None and system.saddle is not None, text
    return system


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("case", range(60))
def test_motions_are_those_of_the_members(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} coupled {case}")
    text, method = drawn(chance), chance.choice(["taylor", "taylor", "ias15", "DOP853", "Radau"])
    for least in ("FEWEST", "FEWEST_BOUND"):
        monkeypatch.setattr(systems, least, 0)
    coupled(text)
    together, found = followed(text, OUTPUTS, method=method)
    assert together.machine.program.loops
    for least in ("FEWEST", "FEWEST_BOUND"):
        monkeypatch.setattr(systems, least, 10**9)
    apart, expected = followed(text, OUTPUTS, method=method)
    assert not apart.machine.program.loops
    own, others = ({one.path for one in each.recording.datasets} for each in (together, apart))
    assert {path for path in own ^ others if "conserved" not in path} == set()
    shared = {path: values for path, values in expected.data.items() if path in found.data}
    alike(found.data, shared, 2.0**-40 if method in ("taylor", "ias15") else 1e-8, text, method)
    for path, values in found.data.items():
        if "conserved" in path or ("constraints" in path and method != "DOP853"):
            assert np.ptp(values) < 1e-9 if method == "DOP853" else 1e-13, (path, text)

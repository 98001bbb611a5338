"""Forces and torques on some members of a family, beside the same systems written out member by member."""

from __future__ import annotations

import pytest

from lagrange_cli.errors import UsageError
from lagrange_cli.families import system as systems
from lagrange_cli.run.family_equations import DerivedFamilies, derive_printed
from lagrange_cli.run.verification import verify_families
from lagrange_cli.spec.read import read_spec
from tests.support.families import alike, begun, followed

OUTPUTS = frozenset(["q", "v", "h", "energy", "ledger", "reactions"])
HEAD = "sizes: {N: 5}\nparameters: {kind: [0, 1, 1, 0, 1], g: 9.81}\n"
PARTICLES = """\
coordinates: {x[i in range(N)]: {initial: 0.1*i, velocity: 0.2}, y[i in range(N)]: {initial: 0.3 - 0.1*i}}
masses: {p[i in range(N)]: 1 + i}
embedding: {p[i in range(N)]: [x[i], y[i]]}
potential: sum(p[i].x**2 + p[i].y**4 for i in range(N)) + sum(x[i]*y[i - 1] for i in range(1, N))
forces:
"""
CHAIN = """\
coordinates: {a[i in range(N)]: {initial: 0.1*i + 0.3, velocity: 0.2}}
masses: {p[i in range(N)]: 1 + i}
embedding:
  p[i in range(N)]: [sum(sin(a[j]) for j in range(i + 1)), -sum(cos(a[j]) for j in range(i + 1))]
potential: sum((1 + i)*g*p[i].y for i in range(N))
forces:
"""
BODIES = """\
coordinates:
  a[i in range(N)]: {initial: 0.4 + 0.1*i, velocity: 0.3}
  b[i in range(N)]: {initial: 1, velocity: 0.1*i}
  c[i in range(N)]: {initial: 0.2, velocity: 0.7}
bodies:
  p[i in range(N)]:
    mass: 1 + i
    inertia: [1, 2, 2.5]
    position: [0, 0, 0]
    orientation: {euler: [a[i], b[i], c[i]]}
potential: sum(g*cos(b[i]) for i in range(N))
torques:
"""
ON = {
    "particles": (PARTICLES, "[-x[i]*y[i], sin(x[i] + i)]"),
    "a chain": (CHAIN, "[-p[i].vx, sin(a[i] + i)]"),
    "bodies": (BODIES, "[-p[i].wx, 0.2*i, p[i].w3]"),
}
SOME = ["i in range(N) if kind[i] == 1", "i in range(1, N, 2)", "i in range(3, N) if i % 2 == 0"]


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("some", SOME)
@pytest.mark.parametrize("on", ON)
def test_what_acts_on_some_members_acts_on_them_alone(
    on: str, some: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    head, force = ON[on]
    text = f"{HEAD}{head}  p[{some}]: {force}\n  p[0]: [1, 0{', 0' * (on == 'bodies')}]\n"
    for name in ("FEWEST", "FEWEST_JOINTED", "FEWEST_TURNING"):
        monkeypatch.setattr(systems, name, 0)
    assert systems.family_system(begun(text)[0]) is not None
    together, motion = followed(text, OUTPUTS)
    printed = derive_printed(read_spec(text, "system.yaml"), "lagrange", indexed=True)
    assert isinstance(printed, DerivedFamilies)
    assert verify_families(printed, {}).difference < 1e-12
    for name in ("FEWEST", "FEWEST_JOINTED", "FEWEST_TURNING"):
        monkeypatch.setattr(systems, name, 10**9)
    apart, expected = followed(text, OUTPUTS)
    assert together.machine.program.loops and not apart.machine.program.loops
    alike(motion.data, expected.data, 2.0**-40)


def test_forces_that_are_not_printed_with_indices_are_said_to_be_the_reason() -> None:
    head = PARTICLES.replace("forces:\n", "")
    text = f"{HEAD}{head}generalized_forces: {{x[i in range(N)]: 'where(x[i//2] > 0, 1, -1)*t'}}\n"
    with pytest.raises(UsageError, match="its forces are of a kind that is not printed with indices"):
        derive_printed(read_spec(text, "system.yaml"), "lagrange", indexed=True)

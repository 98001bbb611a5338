"""Particles in families of several pieces, definitions with sums, and forces: as they are printed."""

from __future__ import annotations

import random

import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.run.family_equations import derive_families, families_as_data, families_as_written
from lagrange_cli.spec.read import read_spec
from tests.symbolic.families.test_equations import holds

PIECES = (
    "sum(far[i, j]**2/7 for i in range(N) for j in range(N))",
    "sum(mean*u[i] for i in range(N))",
    "mean**3/5",
    "sum(near[i]**4 for i in range(N))",
    "sum(cos(p[i].x - q[j].x)*m[i] for i in range(N - 1, -1, -1) for j in range(i, N) if (i - j) % 2 == 0)",
    "sum(u[i]*w[j] for i in range(N - 1, 0, -2) for j in range(i, -1, -3))",
    "sum(sum(u[k] for k in range(i))**2 for i in range(N))",
    "sum(exp(-sum((u[i] - w[k])**2 for k in range(N) if k != i)) for i in range(N))",
    "sum(norm(p[i] - (1, w[0] + 3))*(1 + i)**2/(N + 1) for i in range(0, N, 2))",
    "sum(where(2*i == N or i % 3 == 1, u[i]**2, w[N - 1 - i]**2/2) for i in range(N))",
    "sum(u[i*i % N]*w[i//2] for i in range(N))",
    "sum(u[i]**(i + 1)/9 for i in range(N))",
    "m[0]*sum(sin(t + i)*dot(p[i], p[(i + 1) % N]) for i in range(N))",
    "s*sum(u[i]*w[j]*u[k] for i in range(N) for j in range(i) for k in range(j))",
    "sum(sum(u[j]*w[i] for j in range(i, N)) for i in range(1, N) if i != 2)",
)
FORCES = (
    "",
    'generalized_forces: {"u[i in range(N)]": "where(i == 0, sin(t), -0.1*u_dot[i]*(i + 1))", s: "-s_dot"}',
    'forces: {"p[i in range(N)]": ["-p[i].vx", "where(i > 1, t, 0)"]}',
    "dissipation: sum((u_dot[i] - u_dot[i - 1])**2/3 for i in range(1, N)) + s_dot**2*mean**2",
    'forces: {"p[0]": [cos(t), s]}',
)
PLACES = (
    '"p[i in range(N)]": ["u[i] + i", "2*w[i]"]',
    '"p[0]": ["u[0]", "w[0]"], "p[i in range(1, N)]": ["3*u[i]", "w[i] - m[i]"]',
)
MASSES = "m[i]", "where(i == 0, 2, 1 + i/3)"
SYSTEM = """
sizes: {{N: {count}}}
parameters: {{c: 1.5, "m[i in range(N)]": "1 + 0.5*sin(i)**2"}}
coordinates:
  u[i in range(N)]: {{initial: "0.5*sin(3 + i)"}}
  w[i in range(N)]: {{initial: "0.2*cos(2*i)", velocity: 0.1}}
  s: {{initial: 0.3}}
definitions:
  mean: sum(u[i]/N for i in range(N))
  far[i in range(N), j in range(N)]: where(i == j, u[i]*c, u[i] - w[j])
  near[i in range(N)]: u[(i + 1) % N] - u[i]
masses: {{"p[i in range(N)]": "{mass}", "q[i in range(N)]": 2, one: 3}}
embedding:
  {{{place}, "q[i in range(N)]": ["u[i]/2", 1], one: [s, 0]}}
potential: {potential}
{forces}
"""


def drawn(chance: random.Random) -> str:
    """The text of a random system."""
    count = chance.choice([1, 2, 3, 4, 7])
    return SYSTEM.format(
        count=count,
        potential=" + ".join(f"({one})" for one in chance.sample(PIECES, chance.randint(1, 4))),
        forces=chance.choice(FORCES[:3] if count == 1 else FORCES),
        place=chance.choice(PLACES[:1] if count == 1 else PLACES),
        mass=chance.choice(MASSES),
    )


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("case", range(60))
def test_what_is_printed_is_integrated(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(systems, "FEWEST", 0)
    spec = read_spec(drawn(random.Random(f"{pytestconfig.option.seed} particles {case}")), "system.yaml")
    derived = derive_families(spec)
    if derived is None:
        assert systems.family_system(spec) is None, spec.text
        return
    holds(derived)
    for format_ in ("text", "unicode", "latex", "python"):
        assert families_as_written(derived, format_, "lagrange", {})
    assert families_as_data(derived, {})["equations"]

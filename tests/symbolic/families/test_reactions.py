"""Forces of constraint with indices, beside those of the same systems written out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.arrays import evaluate
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.vocabulary import TIME, acceleration_name, velocity_name
from lagrange_cli.families import system as systems
from lagrange_cli.mechanics.constrained.reactions import Reactions
from lagrange_cli.mechanics.explicit import at_rates
from lagrange_cli.model.build import build_model
from lagrange_cli.records import replace
from lagrange_cli.run.family_equations import DerivedFamilies, derive_printed, written
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from lagrange_cli.symbolic.families.readback import ReadBack
from tests.support.motion import SYSTEMS

HEAD = """
sizes: {N: 4}
parameters: {k: 2, l: 0.7, c: 0.1, g: 9.8, a: 3, "m[i in range(N)]": 1 + i/3}
"""
PLANE = f"""{HEAD}
coordinates: {{"x[i in range(N)]": {{initial: a*i}}, "y[i in range(N)]": {{initial: -l}}}}
masses: {{"b[i in range(N)]": "m[i]*l"}}
positions: {{"b[i in range(N)]": ["x[i]", "y[i]"]}}
constraints: {{"rod[i in range(N)]": "(x[i] - a*i)**2 + y[i]**2 - l**2"}}
"""
HUNG = f"""{HEAD}
coordinates: {{X: {{initial: 1}}, "q[i in range(N)]": {{initial: 0.3*i + 0.1}}}}
masses: {{cart: l, "b[i in range(N)]": "m[i]"}}
definitions: {{"s[i in range(N)]": sum(l*sin(q[j]) for j in range(i + 1))}}
positions:
  cart: [X, a]
  b[i in range(N)]: ["X + s[i]", "-sum(l*cos(q[j]) for j in range(i + 1))"]
"""
CASES = {
    "a ring": f"{PLANE}potential: sum(m[i]*k*(norm(b[i] - b[(i + 1) % N]) - l)**2/2 for i in range(N))",
    "in coordinates": f"{PLANE}potential: sum(m[i]*g*y[i] + k*(x[i] - x[i - 1])**2 for i in range(1, N))",
    "driven": f"""{PLANE}
potential: sum(m[i]*g*b[i].y for i in range(N))
forces: {{"b[i in range(N)]": ["-c*b[i].vx + sin(t)", "-c*b[i].vy"]}}
generalized_forces: {{"y[i in range(N)]": l*i}}
dissipation: sum(c*(x_dot[i] - b[i - 1].vx)**2/2 for i in range(1, N))
""",
    "pendulums": (SYSTEMS / "n_pendulum.yaml").read_text(encoding="utf-8"),
    "between two pins": f"""{(SYSTEMS / "n_pendulum.yaml").read_text(encoding="utf-8")}
constraints: {{right: bob[N - 1].x - l, level: bob[N - 1].y}}
""",
    "tops": f"""{HEAD}
coordinates: {{"q[i in range(N)]": {{initial: 0.5}}, "u[i in range(N)]": {{initial: 0.1*i}}}}
bodies:
  b[i in range(N)]:
    mass: m[i]
    inertia: [l, l, c]
    position: ["l*sin(q[i])*sin(u[i])", "-l*sin(q[i])*cos(u[i])", "l*cos(q[i])"]
    orientation: {{euler: ["u[i]", "q[i]", "t"], sequence: zxz}}
potential: >
  sum(g*m[i]*b[i].at(0, 0, a).z + k*norm(b[i].at(l, 0, 0) - b[i - 1].at(0, l, c))**2/2 for i in range(1, N))
dissipation: sum(c*b[i].at(0, 0, l).vx**2/2 for i in range(N))
forces: {{"b[i in range(N)]": ["sin(t)", "-c*b[i].vy", 0]}}
torques: {{"b[i in range(N)]": [0, 0, c]}}
""",
    "on two lines": f"""{HEAD}
coordinates: {{"q[i in range(N)]": {{initial: 0.5}}}}
masses: {{"b[i in range(N)]": "m[i]"}}
positions:
  b[0]: [l*sin(q[0]), -l*cos(q[0])]
  b[i in range(1, N)]: ["i + where(i % 2 == 0, 1, c)*sin(q[i])", "-2*l*cos(q[i])"]
potential: sum(m[i]*g*b[i].y for i in range(N)) + sum(k*norm(b[i] - b[i - 1])**2/2 for i in range(1, N))
dissipation: sum(c*(b[i].vx - b[0].vx)**2/2 for i in range(N))
""",
    "beside a hub": f"""{HEAD}
coordinates: {{X: {{initial: 1}}, "q[i in range(N)]": {{initial: 0.5}}, "y[i in range(N)]": {{initial: i}}}}
bodies:
  hub:
    {{mass: l, solid: {{sphere: l}}, position: [X, 0, 0], orientation: {{euler: [X, 0, 0], sequence: zxz}}}}
  b[0]:
    mass: l
    solid: {{disc: l}}
    position: [0, "y[0]", 0]
    orientation: {{euler: ["q[0]", 0, 0], sequence: zxz}}
  b[i in range(1, N)]:
    mass: m[i]
    inertia: [l, l, l]
    position: [i, "y[i]", 0]
    orientation: {{euler: [0, "q[i]", 0], sequence: zxz}}
potential: sum(k*norm(b[i].at(l, 0, a) - hub.at(0, l, 0))**2/2 for i in range(N))
""",
    "on a cart": f"{HUNG}potential: sum(m[i]*g*b[i].y + k*dot(b[i] - cart, b[i] - cart) for i in range(N))",
}


@pytest.fixture(autouse=True)
def however_small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Short chains and few bodies are families, too."""
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)


def indexed(text: str, size: int) -> DerivedFamilies:
    spec = read_spec(text.encode(), "system.yaml", {"N": str(size)})
    found = derive_printed(spec, "reactions", indexed=True)
    assert isinstance(found, DerivedFamilies) and found.equations.reactions is not None
    return found


def by_members(text: str, size: int, values: dict[str, Any]) -> dict[str, float]:
    """R by the name that its components have."""
    model = build_model(read_spec(text.encode(), "system.yaml", {"N": str(size)}), GraphAlgebra())
    listed: list[tuple[str, Node]] = []
    for particle, nodes in Reactions(model).on_particles.items():
        base, bracket, index = particle.partition("[")
        parts = at_rates(model, nodes)[1]
        listed += [(f"R_{base}_{axis}{bracket}{index}", one) for axis, one in zip("xyz", parts)]
    found = evaluate([one for _, one in listed], values)
    return {name: float(x) for (name, _), x in zip(listed, found)}


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("size", [2, 5])
def test_forces_with_indices_are_those_written_out(name: str, size: int) -> None:
    derived = indexed(CASES[name], size)
    form, spec = derived.equations.reactions, derived.spec
    assert form is not None
    chance = np.random.default_rng(size)
    q, v, a = chance.uniform(-1, 1, (3, len(spec.coordinates)))
    parameters = resolve_values(spec).parameters
    values = {**parameters, TIME: 0.4}
    for k, one in enumerate(spec.coordinates):
        values |= {one.name: q[k], velocity_name(one.name): v[k], acceleration_name(one.name): a[k]}
    expected = by_members(CASES[name], size, values)
    read = ReadBack(derived.system, replace(derived.equations, paths=form.paths))
    state = 0.4, q, v, a, np.array([*parameters.values()])
    found = {}
    for line in form.lines:
        read.first[line.family.name] = 0
        places, indices = read.members(line)
        numbers, _ = read.value(line.expression, indices, len(places), state)
        found |= {line.family.members[p].replace(line.family.name.split("_")[1], line.family.name): x
                  for p, x in zip(places.tolist(), numbers.tolist())}  # fmt: skip
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.exhaustive(keep=0.35)
def test_a_family_takes_a_line_however_many_it_has() -> None:
    texts = [written(indexed(CASES["driven"], size), "text", "reactions", {}) for size in (5, 500)]
    assert texts[0].count("\n") == texts[1].count("\n") < 25
    assert "R_b_y[i] = l*m[i]*y_ddot[i]" in texts[1]


@pytest.mark.exhaustive(keep=0.25)
def test_no_sum_is_over_members_that_are_written_otherwise() -> None:
    text = written(indexed(CASES["beside a hub"], 50), "text", "reactions", {})
    assert "R_hub_x = " in text and " if i" not in text


@pytest.mark.exhaustive(keep=0.7)
def test_what_nothing_constrains_feels_no_force_of_constraint() -> None:
    text = written(indexed((SYSTEMS / "fpu_chain.yaml").read_text(), 60), "text", "reactions", {})
    assert "R_bead_x[i] = 0   [for i in range(N)]" in text


@pytest.mark.exhaustive(keep=0.55)
def test_a_force_along_a_coordinate_does_not_tell_on_what_it_acts() -> None:
    with pytest.raises(
        UsageError, match=r"U contains the coordinate 'q\[0\]'; write it in positions.*cart\.x"
    ):
        indexed(f"{HUNG}potential: sum(k*q[i]**2 for i in range(N))", 4)

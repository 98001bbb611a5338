"""A spec over an algebra: positions, velocities by the chain rule, potentials that use them."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
import sympy

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.expression.sloped import SlopedAlgebra
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.limits import Work
from lagrange_cli.model.build import build_model
from lagrange_cli.model.forces.table import FORCES
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.values import resolve_values

SYSTEMS = Path(__file__).parents[2] / "systems"
HOOP = """\
parameters: {m: 1, a: 0.5, omega: 2, c: 0.1}
coordinates: {theta: {initial: 0.3}, z: {initial: 0}}
definitions:
  phi: omega*t
  outward: [cos(phi), sin(phi)]
masses: {bead: 2*m, stone: m}
embedding:
  bead: [a*sin(theta)*outward.x, a*sin(theta)*outward.y, -a*cos(theta)]
  stone: z
potential:
  gravity: m*bead.z
  lift: c*dot(bead, bead)*stone.vx
forces: {stone: -c*stone.vx, bead: [0, 0, -c*bead.vz]}
generalized_forces: {z: theta_dot}
dissipation: c*z_dot**2
observables: {speed: "norm((bead.vx, bead.vy, bead.vz))"}
"""


def symbolic(text: str) -> Model[sympy.Expr]:
    return build_model(read_spec(text, "hoop.yaml"), SympyAlgebra())


def test_velocities_are_total_time_derivatives() -> None:
    model = symbolic(HOOP)
    functions = [sympy.Function(name)(model.time) for name in model.coordinates]
    along = dict(zip(model.q, functions, strict=True))
    rates = {rate: function.diff(model.time) for rate, function in zip(model.v, functions, strict=True)}
    for particle in model.particles:
        for position, velocity in zip(particle.position, particle.velocity, strict=True):
            expected = position.subs(along).diff(model.time)
            assert sympy.simplify(velocity.subs(rates).subs(along) - expected) == 0


@pytest.mark.exhaustive(keep=0.45)
def test_names_reach_particles_definitions_and_velocities() -> None:
    model = symbolic(HOOP)
    m, a, c, omega = (model.parameters[name] for name in ("m", "a", "c", "omega"))
    (theta, z), (theta_dot, z_dot), t = model.q, model.v, model.time
    bead, stone = model.particles
    assert model.coordinates == ("theta", "z")
    assert bead.mass == 2 * m
    assert bead.position[0] == a * sympy.sin(theta) * sympy.cos(omega * t)
    assert stone.position == (z,)
    assert stone.velocity == (z_dot,)
    assert stone.force == (-c * z_dot,)
    assert bead.force == (0, 0, -c * a * sympy.sin(theta) * theta_dot)
    assert sympy.simplify(model.potential - (-m * a * sympy.cos(theta) + c * a**2 * z_dot)) == 0
    assert model.lagrangian is None
    assert model.generalized_forces == (0, theta_dot)
    assert model.dissipation == c * z_dot**2
    speed = a * sympy.sqrt(theta_dot**2 + omega**2 * sympy.sin(theta) ** 2)
    assert sympy.simplify(model.observables["speed"] ** 2 - speed**2) == 0


def test_absent_sections_are_zero() -> None:
    model = symbolic("coordinates: [x]\nmasses: {p: 1}\nembedding: {p: x}")
    assert (model.potential, model.dissipation, model.generalized_forces) == (0, 0, (0,))
    assert model.particles[0].force == ()
    assert model.observables == {}


@pytest.mark.exhaustive(keep=0.45)
def test_a_given_lagrangian_over_numbers_is_its_value() -> None:
    spec = read_spec((SYSTEMS / "gauge_oscillator.yaml").read_bytes(), "gauge_oscillator.yaml")
    values = resolve_values(spec)
    x, x_dot, t = 0.7, -1.3, 0.4
    model = build_model(spec, NumberAlgebra({**values.parameters, "x": x, "x_dot": x_dot, "t": t}))
    m, k, c, w = (values.parameters[name] for name in "mkcw")
    gauge = c * math.cos(w * t) * x * x_dot - c * w * math.sin(w * t) * x**2 / 2
    assert model.particles == ()
    assert model.lagrangian == pytest.approx(m * x_dot**2 / 2 - k * x**2 / 2 + gauge, rel=1e-14)


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("path", sorted(SYSTEMS.glob("*.yaml")), ids=lambda path: path.stem)
def test_every_shipped_system_becomes_a_model(path: Path) -> None:
    spec = read_spec(path.read_bytes(), path.name)
    model = build_model(spec, SympyAlgebra())
    known = {model.time, *model.q, *model.v, *model.parameters.values()}
    total = model.potential + sum(p.mass * sum(v**2 for v in p.velocity) for p in model.particles)
    used = (total if model.lagrangian is None else model.lagrangian).free_symbols
    assert used <= known
    assert used & set(model.v)


def test_what_an_algebra_refuses_is_shown_at_its_place() -> None:
    spec = read_spec("coordinates: [x]\nlagrangian: 1 + x_dot/x", "file.yaml")
    with pytest.raises(SpecError) as caught:
        build_model(spec, NumberAlgebra({"x": 0.0, "x_dot": 1.0, "t": 0.0}))
    (problem,) = caught.value.problems
    assert (problem.line, problem.column, problem.length) == (2, 17, 7)
    assert problem.message == "division by zero"


def test_every_key_that_gives_forces_says_how_they_act():
    assert set(FORCES) == {row.key for row in SECTIONS.rows if row.force}


def test_the_actions_of_several_keys_add_up(monkeypatch):
    """Each key given twice doubles all that it does."""
    spec = read_spec(
        "coordinates: {x: {initial: 1}}\nparameters: {c: 3}\nmasses: {a: 1}\nembedding: {a: [x]}\n"
        "forces: {a: [c]}\ngeneralized_forces: {x: c*x}\ndissipation: c*x_dot**2\n",
        "a.yaml",
    )
    once = build_model(spec, SympyAlgebra())
    for key, law in list(FORCES.items()):
        monkeypatch.setitem(FORCES, f"{key} again", law)
    again = {f"{key} again": given for key, given in spec.forces.items()}
    twice = build_model(replace(spec, forces={**spec.forces, **again}), SympyAlgebra())
    assert twice.particles[0].force == (2 * once.particles[0].force[0],)
    assert twice.generalized_forces == (2 * once.generalized_forces[0],)
    assert twice.dissipation == 2 * once.dissipation
    assert all(expression.free_symbols for expression in (*once.generalized_forces, once.dissipation))


def test_a_power_of_zero_has_no_slope_by_its_exponent() -> None:
    algebra = SlopedAlgebra({}, ["x"], (0.0, [1.0], [0.0]), Work())
    for base in ("0", "-1"):
        with pytest.raises(ArithmeticError, match="no derivative by its exponent"):
            algebra.number("1") * algebra.number(base) ** algebra.symbol("x")

"""What ``check`` says of a system is true of the system as it is written: held against sympy's T and L."""

from __future__ import annotations

from random import Random

import pytest
import sympy
from hypothesis import HealthCheck, given, settings

from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.mechanics.omitted_work import engine, has_forces
from lagrange_cli.model.build import build_model
from tests.mechanics.test_random_systems import systems
from tests.support.motion import NAMES, model_of, residual_of, spec_of

LARGE = {"lattice", "fpu_chain", "n_pendulum", "solar_system", "kovalevskaya_top", "lagrange_top"}
CASES = [
    # polar Kepler: diag(m, m*r**2), reduced by Routh to diag(m)
    "parameters: {m: 2}\ncoordinates: {r: {initial: 1}, phi: {initial: 0}}\nmasses: {p: m}\n"
    "positions: {p: [r*cos(phi), r*sin(phi)]}\npotential: -1/r\n",
    # a mass matrix that is full until a cyclic coordinate is eliminated
    "coordinates: {x: {initial: 1}, y: {initial: 0}}\n"
    "lagrangian: x_dot**2 + x_dot*y_dot + (2 + x**2)*y_dot**2\n",
    "coordinates: {x: {initial: 1}, y: {initial: 0}}\nlagrangian: x_dot**2 + y_dot**2 - x*y\nforces: {}\n"
    "generalized_forces: {x: -y, y: x}\n",
    "coordinates: {x: {initial: 1}}\nmasses: {p: 1}\nembedding: {p: [x + t, sin(x)**2 + cos(x)**2]}\n"
    "generalized_forces: {x: 0*x}\n",
]


def vanishes(expression: sympy.Expr) -> bool:
    """Whether it is 0 at random arguments."""
    source = Random(1)
    symbols = sorted(expression.free_symbols, key=str)
    values = [{one: sympy.Float(source.uniform(0.3, 1.2), 40) for one in symbols} for _ in range(3)]
    return all(abs(expression.evalf(30, subs=each)) < 1e-20 for each in values)


def hold(system: str) -> None:
    """Hold each statement against its definition."""
    model, residual = build_model(spec_of(system), SympyAlgebra()), derive(model_of(system))
    kinetic = sum((p.mass * u**2 / 2 for p in model.particles for u in p.velocity), sympy.S.Zero)
    lagrangian = model.lagrangian if model.lagrangian is not None else kinetic - model.potential
    matrix = sympy.Matrix([[sympy.diff(lagrangian, u, v) for v in model.v] for u in model.v])
    forces = [
        Q - sympy.diff(model.dissipation, v) + sum(
            (F * sympy.diff(x, q) for p in model.particles if p.force for F, x in zip(p.force, p.position)),
            sympy.S.Zero,
        )
        for Q, q, v in zip(model.generalized_forces, model.q, model.v)
    ]  # fmt: skip
    said = engine(residual)
    moving = [*model.q, *model.v, model.time]
    for fact in said:
        if fact.startswith("the mass matrix contains parameters only"):
            assert all(vanishes(sympy.diff(entry, symbol)) for entry in matrix for symbol in moving)
        if fact.startswith("the mass matrix is diagonal"):
            assert all(vanishes(matrix[i, k]) for i in range(len(model.q)) for k in range(i))
    assert any("after Routh's reduction" in fact for fact in said) <= bool(residual.cyclic_momenta)
    assert has_forces(residual) != all(map(vanishes, forces))
    given = [x for p in model.particles for x in p.position] if model.lagrangian is None else [lagrangian]
    assert residual.scleronomic == all(vanishes(sympy.diff(x, model.time)) for x in given)
    cyclic = [str(q) for q in model.q if vanishes(sympy.diff(lagrangian, q))]
    assert list(residual.cyclic) == cyclic
    kept = {each.quantity for each in residual.conserved}
    assert {name for name in kept if name != "h"} == {
        f"p_{q}" for q, force in zip(model.q, forces) if str(q) in cyclic and vanishes(force)
    }
    power = sum((Q * v for Q, v in zip(forces, model.v)), sympy.S.Zero)
    assert ("h" in kept) == (vanishes(sympy.diff(lagrangian, model.time)) and vanishes(power))
    for each in residual.conserved:
        if each.expression == "T + U":
            h = sum((v * sympy.diff(lagrangian, v) for v in model.v), sympy.S.Zero) - lagrangian
            assert vanishes(h - kinetic - model.potential)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("system", [name for name in NAMES if name not in LARGE])
def test_of_shipped_systems(system: str) -> None:
    hold(system)


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("system", CASES)
def test_of_systems_that_are_reduced_or_look_like_others(system: str) -> None:
    hold(system)


@pytest.mark.exhaustive(keep=0)
@settings(max_examples=6, derandomize=True, deadline=None, suppress_health_check=list(HealthCheck))
@given(systems())
def test_of_random_systems(system: str) -> None:
    hold(system)


def test_polar_kepler_has_no_constant_mass_matrix() -> None:
    (fact,) = [fact for fact in engine(residual_of(CASES[0])) if "parameters only" in fact]
    assert fact.startswith("the mass matrix after Routh's reduction")


@pytest.mark.parametrize(
    ("action", "often"), [("stop", "once per run,"), ("{set: {m: 2*m}}", "each event that")]
)
def test_an_event_may_change_what_is_computed_from_parameters(action: str, often: str) -> None:
    said = engine(residual_of(f"{CASES[0]}events: {{e: {{when: r - 2, action: {action}}}}}\n"))
    assert all(often in fact for fact in said if "not once per step" in fact)
    assert any("not once per step" in fact for fact in said)

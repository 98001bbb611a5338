"""Equations with modes in place of what changes in switches."""

from __future__ import annotations

import pytest

from lagrange_cli.limits import Work
from lagrange_cli.mechanics.guards.equations import guarded
from lagrange_cli.mechanics.switching.switches import switches, vanishes_with
from tests.support.motion import residual_of

LINE = """
name: a line
coordinates: {{x: {{initial: 1, velocity: 0}}}}
masses: {{p: 1}}
embedding: {{p: [x]}}
potential: {potential}
generalized_forces: {{x: "{force}"}}
"""


def of(potential: str = "0", force: str = "0"):
    residual = residual_of(LINE.format(potential=potential, force=force))
    return residual, guarded(residual, {})


def test_a_system_without_switches_stays_as_it_is():
    residual, found = of("x**2/2", "-x_dot")
    assert found.residual is residual
    assert not found.guards


@pytest.mark.exhaustive(keep=14)
@pytest.mark.parametrize(
    ("potential", "force", "guards", "auxiliary"),
    [
        ("abs(x)", "0", 1, 1),  # the force jumps: it may hold the motion
        ("max(0, x)**2", "0", 1, 0),  # it does not
        ("((x + abs(x))/2)**2.5", "0", 1, 0),
        ("0", "-sign(x_dot)", 1, 1),
        ("0", "-x_dot/abs(x_dot)", 1, 1),
        ("0", "where(t > 1 and t < 2, 1, 0)", 2, 0),  # time is not held
        ("0", "where(x > 1, -sign(x_dot), 0)", 3, 1),  # one says whether there is friction
        ("0", "max(0, sign(1 - x_dot))", 1, 1),  # one guard, not one within the other
        ("0", "where(x_dot > 0, 1, where(x_dot < 0, -1, 0))", 1, 1),
        ("0", "sign(x_dot) - 2*sign(x_dot - 1)", 2, 2),
        ("0", "x*sign(x) - abs(x)", 0, 0),
        ("1/abs(x)", "0", 1, 0),  # nothing is held at a pole
        ("1/abs(x)", "-sign(x_dot)", 2, 1),
        ("1/sqrt(2 - 2*cos(x))", "-x_dot/abs(x_dot)", 2, 1),
        ("0", "-sign(x)*(1 + 1/(3*x)**2)", 1, 0),
        ("0", "where(x > 0, 1/x, -1)", 1, 0),
        ("0", "where(x > -2, sign(x)/x**2, 1/x)", 2, 1),  # a pole on both sides of -2
        ("0", "where(x > 2, sign(x)/x**2, 1/x)", 1, 1),  # x has one sign beyond 2
        ("0", "where(x < 2, sign(2*x - 5), 1/x)", 1, 1),  # so has 2 x - 5 before it
        ("(max(0, -x) + max(0, x - 2))**2.5", "0", 2, 0),  # no branch has both, and none is held
        ("0", "where(x > 2, 1/x_dot, 0) - sign(x_dot)", 2, 2),  # a pole on one of them
        ("0", "-sign(x_dot)/(1 + x_dot**2)", 1, 1),
        ("0", "-sign(x)*(1 - exp(-1/x**2))", 1, 1),  # bounded
        ("0", "-sign(x)/x_dot", 1, 1),  # unbounded elsewhere
        ("0", "-1/abs(x_dot)", 1, 1),  # an end that is reached
    ],
)
def test_each_argument_has_one_guard(potential, force, guards, auxiliary):
    residual, found = of(potential, force)
    assert len(found.guards) == guards
    assert found.auxiliary == auxiliary
    assert not switches(found.residual.residual, residual.variables)
    assert len(found.residual.residual) == 1 + auxiliary
    assert not switches([one.argument for one in found.guards], residual.variables)


def test_what_vanishes_with_an_argument():
    residual, _ = of()
    graph, x = residual.graph, residual.model.q[0]
    a = graph.symbol("a")
    assert vanishes_with(graph, (x - a) * x, x - a)
    assert vanishes_with(graph, (x**2 + a**2 - 4.0) ** 3, a**2 + x**2 - 4.0)
    assert not vanishes_with(graph, x, x - a)
    assert not vanishes_with(graph, graph.one, x)


def test_the_matrix_with_multipliers_is_counted_as_work(monkeypatch):
    """Of N bodies with N**2 kinks it has N**4 entries."""
    counted = {}
    charge = Work.charge

    def noted(self, steps, what="deriving the equations"):
        counted[what] = steps
        charge(self, steps, what)

    monkeypatch.setattr(Work, "charge", noted)
    of("abs(x - 0.123)", "-sign(x_dot)")
    assert counted["a matrix of 1 coordinates and 2 multipliers"] == 9


@pytest.mark.parametrize(("friction", "auxiliary"), [("0", 0), ("-sign(a_dot[i])", 5)])
def test_charges_on_a_ring_hold_one_another_by_friction_alone(friction, auxiliary):
    residual = residual_of(f"""
        name: charges on a ring
        sizes: {{N: 5}}
        coordinates: {{a[i in range(N)]: {{initial: 2*pi*i/N}}}}
        masses: {{b[i in range(N)]: 1}}
        positions: {{b[i in range(N)]: [cos(a[i]), sin(a[i])]}}
        potential: sum(1/norm(b[i] - b[j]) for i in range(N) for j in range(i))
        generalized_forces: {{a[i in range(N)]: {friction}}}
    """)
    found = guarded(residual, {})
    assert len(found.guards) == 10 + auxiliary
    assert found.auxiliary == auxiliary

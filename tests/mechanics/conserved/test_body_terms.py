"""Polynomials in a body's angular velocity and a direction in space: those of the literature are found."""

from __future__ import annotations

import pytest

from lagrange_cli.expression.build import build
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conserved.body_terms import variables_of_body
from tests.mechanics.conserved.test_polynomial_integrals import searched
from tests.support.rates import rates

BODY = """
parameters: {{A: 1.0, B: 2.1, C: 2.5, k: 1.2, m: 1.3, R: 0.7}}
coordinates: {{{coordinates}}}
bodies:
  b: {{mass: m, position: [{centre}], inertia: [A, B, C], orientation: {{{orientation}}}}}
potential: k*(A*b.R31**2 + B*b.R32**2 + C*b.R33**2)/2
{constraints}
"""
G = "(b.R31, b.R32, b.R33)"
M = "(A*b.w1, B*b.w2, C*b.w3)"
ADJ = "(B*C*b.R31**2 + C*A*b.R32**2 + A*B*b.R33**2)"
W = "(b.w1, b.w2, b.w3)"
ROLLING = f"({M} + m*R**2*({W} - dot({W}, {G})*{G}))"
EULER = {
    "coordinates": "al: {initial: 0.4, velocity: 1}, be: {initial: 1, velocity: 2}, ga: {initial: 0.3}",
    "orientation": "euler: [al, be, ga], sequence: zxz",
    "centre": "0, 0, 0",
    "constraints": "",
}
QUATERNION = {
    "coordinates": "q: {initial: 0.8}, x: {initial: 0.6}, y: {initial: 0, velocity: 0.6}, "
    "z: {initial: 0, velocity: 0.45}",
    "orientation": "quaternion: [q, x, y, z]",
    "centre": "0, 0, 0",
}
CASES = {
    "Brun 1893, in angles": (EULER, f"dot({M}, {M}) - k*{ADJ}"),
    "Suslov's constraint": (
        QUATERNION | {"constraints": "nonholonomic: {s: b.w3}"},
        "A*b.w1**2 + k*(B - C)*b.R32**2",
    ),
    "Veselova 1986": (
        QUATERNION
        | {
            "coordinates": QUATERNION["coordinates"].replace("0.45", "-0.45"),
            "constraints": "nonholonomic: {s: b.wz}",
        },
        f"dot({M}, {M}) - dot({M}, {G})**2 - k*{ADJ}",
    ),
    "Kozlov 1985, Chaplygin's ball": (
        QUATERNION
        | {
            "coordinates": "X: {initial: 0, velocity: 0.294}, Y: {initial: 0}, " + QUATERNION["coordinates"],
            "centre": "X, Y, R",
            "constraints": "nonholonomic: {s: X_dot - R*b.wy, r: Y_dot + R*b.wx}",
        },
        f"dot({ROLLING}, {ROLLING}) - k*{ADJ} + k*m*R**2*(A*b.R31**2 + B*b.R32**2 + C*b.R33**2)",
    ),
}


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("case", CASES)
def test_integrals_of_bodies_are_found(case):
    """A published integral is a function of h and of the one that is found. The formula of this is right, and
    its rate of change 0 in doubles, too."""
    given, published = CASES[case]
    observables = f'\nobservables: {{published: "{published}", spin: "dot({M}, {G})"}}\n'
    search, _ = searched(BODY.format(**given) + observables)
    *sums, found = search.found()  # of angular momentum, where it is conserved
    known, observed = [*search.known, search.noether.energy], search.model.observables
    known += [observed["spin"]] * search.states.conserves(observed["spin"])
    assert search.rank([*known, observed["published"]]) == search.rank(known)
    model, names = search.model, dict[str, object]()
    for given in variables_of_body(model, search.noether):
        names |= dict(zip((*given.names, *given.speed_names), (*given.places, *given.speeds)))
    written = build(
        parse(found.text), lambda name: names.get(name, model.algebra.symbol(name)), model.algebra
    )
    assert is_zero(written - found.node)
    for each, sizes in rates(model, [one.node for one in (*sums, found)]):
        assert all(abs(rate) < 1e-9 * size for rate, size in zip(each, sizes))

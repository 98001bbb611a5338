"""Conserved polynomials in the velocities: those of the literature are found, and no others."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.expression.build import build
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.residues import LARGE
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.polynomial_integrals import PolynomialIntegrals
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from lagrange_cli.mechanics.switching.saturation import released
from tests.support.motion import follow, residual_of

PLANE = """
parameters: {{A: 1.3, B: 0.7, d: 0.4}}
coordinates: {{x: {{initial: 0.8, velocity: 0.3}}, y: {{initial: 0.3, velocity: 0.2}}}}
masses: {{p: 1}}
positions: {{p: [x, y]}}
potential: {}
"""
SPACE = """
parameters: {{a: 1.0, b: 1.7, c: 2.9, g: 0.7}}
coordinates:
  x: {{initial: 0.6, velocity: 0.2}}
  y: {{initial: 0.48, velocity: 0.1}}
  z: {{initial: 0.64, velocity: -0.2625}}
definitions: {{r: [x, y, z], v: [x_dot, y_dot, z_dot], l: "cross(r, v)"}}
masses: {{p: 1}}
positions: {{p: [x, y, z]}}
{}
"""
LINE = """
sizes: {{N: 3}}
coordinates: {{"q[i in range(N)]": {{initial: 0.9*i + 0.1*i**2, velocity: 0.2 - 0.1*i}}}}
masses: {{"p[i in range(N)]": 1}}
positions: {{"p[i in range(N)]": ["q[i]"]}}
potential: {}
"""
KERR = """
parameters: {M: 0.1, a: 0.05}
definitions:
  S: r**2 + a**2*cos(th)**2
  D: r**2 - 2*M*r + a**2
  PS: -(1 - 2*M*r/S)*s_dot - 2*M*r*a*sin(th)**2*ph_dot/S
  PH: -2*M*r*a*sin(th)**2*s_dot/S + (r**2 + a**2 + 2*M*r*a**2*sin(th)**2/S)*sin(th)**2*ph_dot
  H: (PS*s_dot + PH*ph_dot + S/D*r_dot**2 + S*th_dot**2)/2
coordinates:
  s: {initial: 0, velocity: 1.1}
  r: {initial: 2, velocity: 0.1}
  th: {initial: 1, velocity: 0.1}
  ph: {initial: 1, velocity: 0.2}
lagrangian: H
"""
LIOUVILLE = """
parameters: {a: 1.2, k: 0.7}
coordinates: {u: {initial: 0.8, velocity: 0.1}, w: {initial: 0.3, velocity: 0.6}}
definitions: {F: cosh(u) + cos(w) + 3, U: (a*exp(u) + k*sin(w))/F}
lagrangian: F*(u_dot**2 + w_dot**2)/2 - U
"""
HYPERSPHERE = """
parameters: {{k: 0.4}}
coordinates:
  ch: {{initial: 0.7, velocity: 0.1}}
  th: {{initial: 1, velocity: 0.2}}
  ph: {{initial: 0.3, velocity: 0.9}}
definitions: {{p_ch: ch_dot, p_th: sin(ch)**2*th_dot, p_ph: (sin(ch)*sin(th))**2*ph_dot}}
lagrangian: (p_ch*ch_dot + p_th*th_dot + p_ph*ph_dot)/2 {}
"""
TODA = LINE.format('"sum(exp(q[i] - q[(i + 1) % N]) for i in range(N))"')
CALOGERO = LINE.format('"sum(0.7/(q[i] - q[j])**2 for i in range(N) for j in range(i))"')
CASES = {
    "Henon 1974, the Toda lattice": (
        TODA,
        "q_dot[0]*q_dot[1]*q_dot[2] - q_dot[0]*exp(q[1] - q[2]) - q_dot[1]*exp(q[2] - q[0])"
        " - q_dot[2]*exp(q[0] - q[1])",
    ),
    "Moser 1975, Calogero's particles": (
        CALOGERO,
        "sum(q_dot[i]**3/3 for i in range(N))"
        " + sum(0.7*(q_dot[i] + q_dot[j])/(q[i] - q[j])**2 for i in range(N) for j in range(i))",
    ),
    "Greene 1981, Henon and Heiles 1:6": (
        PLANE.format("(A*x**2 + B*y**2)/2 + x**2*y + 2*y**3"),
        "x**4 + 4*x**2*y**2 - 4*x_dot*(x_dot*y - y_dot*x) + 4*A*x**2*y + (4*A - B)*(x_dot**2 + A*x**2)",
    ),
    "Hall 1983, Henon and Heiles 1:16": (
        PLANE.format("(A*x**2 + 16*A*y**2)/2 + x**2*y + 16*y**3/3"),
        "9*(x_dot**2 + A*x**2)**2 + 12*x_dot*x**2*(3*x_dot*y - y_dot*x) - 2*x**4*(6*y**2 + x**2 + 6*A*y)",
    ),
    "Ramani 1982, quartic 1:6:8": (
        PLANE.format("x**4 + 6*x**2*y**2 + 8*y**4"),
        "x_dot**4 + (24*x**2*y**2 + 4*x**4)*x_dot**2 - 16*x**3*y*x_dot*y_dot + 4*x**4*y_dot**2"
        " + 4*x**8 + 16*x**6*y**2 + 16*x**4*y**4",
    ),
    "Holt 1982": (
        PLANE.format("3*y**(4/3)/4 + (x**2 + d)*y**(-2/3)"),
        "2*x_dot**3 + 3*x_dot*y_dot**2 + 3*x_dot*(2*(x**2 + d)*y**(-2/3) - 3*y**(4/3)) + 18*y_dot*x*y**(1/3)",
    ),
    "Fokas and Lagerstrom 1980": (
        PLANE.format("(x**2 - y**2)**(-2/3)"),
        "(x_dot**2 - y_dot**2)*(x*y_dot - y*x_dot) - 4*(y*x_dot + x*y_dot)*(x**2 - y**2)**(-2/3)",
    ),
    "an oscillator 1:3": (
        PLANE.format("A*(x**2 + 9*y**2)/2"),
        "(x*y_dot - y*x_dot)*x_dot**2 + A*(3*x**2*y*x_dot - x**3*y_dot/3)",
    ),
    "Garnier 1919": (
        PLANE.format("(x**2 + y**2)**2 + A*x**2 + B*y**2"),
        "(x*y_dot - y*x_dot)**2 + (B - A)*(x_dot**2 + 2*A*x**2 + 2*x**2*(x**2 + y**2))",
    ),
    "Neumann 1859, Uhlenbeck 1982": (
        SPACE.format(
            "potential: (a*x**2 + b*y**2 + c*z**2)/2\nconstraints: {sphere: x**2 + y**2 + z**2 - 1}"
        ),
        "x**2 + dot(l, [0, 0, 1])**2/(a - b) + dot(l, [0, 1, 0])**2/(a - c)",
    ),
    "Joachimsthal, geodesics on an ellipsoid": (
        SPACE.format("constraints: {ellipsoid: (x/a)**2 + (y/b)**2 + (z/c)**2 - 1}")
        .replace("0.6, velocity: 0.2", "0.6*a, velocity: 0.2*a")
        .replace("0.48, velocity: 0.1", "0.48*b, velocity: 0.1*b")
        .replace("0.64, velocity: -0.2625", "0.64*c, velocity: -0.2625*c"),
        "(x**2/a**4 + y**2/b**4 + z**2/c**4)*(x_dot**2/a**2 + y_dot**2/b**2 + z_dot**2/c**2)",
    ),
    "Poincare 1896, a magnetic monopole": (
        SPACE.format("forces: {p: g*cross(v, r)/norm(r)**3}"),
        "dot(l, [1, 0, 0]) - g*x/norm(r)",
    ),
    "Carter 1968, a rotating black hole": (
        KERR,
        "(S*th_dot)**2 + cos(th)**2*(PH**2/sin(th)**2 - a**2*(2*H + PS**2))",
    ),
    "Higgs 1979, a sphere's oscillator in gnomonic coordinates": (
        """
parameters: {m: 1.3, k: 0.4, a: 0.6}
coordinates: {x: {initial: 0.7, velocity: 0.2}, y: {initial: 0.3, velocity: 0.9}}
definitions: {D: 1 + a*(x**2 + y**2)}
lagrangian: m/2*((x_dot**2 + y_dot**2)/D - a*(x*x_dot + y*y_dot)**2/D**2) - k/2*(x**2 + y**2)
""",
        "m*(x_dot/D)**2 + k*x**2",
    ),
    "Higgs 1979, in three dimensions": (
        HYPERSPHERE.format("-k*tan(ch)**2"),
        "(cos(th)*p_ch - sin(th)*p_th/tan(ch))**2 + 2*k*(tan(ch)*cos(th))**2",
    ),
    "Schroedinger 1940, Kepler's problem on a sphere": (
        "parameters: {k: 0.4}\n"
        "coordinates: {th: {initial: 0.7, velocity: 0.2}, ph: {initial: 0.3, velocity: 0.9}}\n"
        "lagrangian: (th_dot**2 + (sin(th)*ph_dot)**2)/2 + k/tan(th)\n",
        "sin(th)**2*ph_dot*(sin(ph)*th_dot + sin(th)*cos(th)*cos(ph)*ph_dot) - k*cos(ph)",
    ),
    "the same with a constraint": (
        SPACE.format("potential: -a*z/sqrt(x**2 + y**2)\nconstraints: {sphere: x**2 + y**2 + z**2 - 1}"),
        "dot(l, [0, 0, 1])*dot(l, [1, 0, 0]) + a*x/sqrt(x**2 + y**2)",
    ),
    "Liouville 1849": (LIOUVILLE, "(F*u_dot)**2 + 2*a*exp(u) - (F*(u_dot**2 + w_dot**2) + 2*U)*cosh(u)"),
}


def searched(text, published=None):
    """The search, with what is known before it, and a published integral."""
    lines = text if published is None else text + f'\nobservables: {{published: "{published}"}}\n'
    residual = residual_of(lines)
    model, noether = residual.model, Noether(residual.model)
    momenta = {f"p_{name}": p for name, p in zip(model.coordinates, noether.energetics.momenta)}
    known = [{**momenta, "h": noether.energy}[one.quantity] for one in residual.conserved]
    return PolynomialIntegrals(model, noether, known), model.observables.get("published")


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("case", CASES)
def test_published_integrals_are_found(case):
    """A published integral is a function of those that are found, and not of h and momenta."""
    search, published = searched(*CASES[case])
    before = [*search.known]
    assert search.states.conserves(published)
    alone = search.rank(before)
    assert search.rank([*before, published]) == alone + 1
    after = [*before, *(one.node for one in search.found())]
    rank = search.rank(after)
    assert rank > alone
    assert search.rank([*after, published]) == rank


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("case", CASES)
def test_motions_keep_them(case):
    text, _ = CASES[case]
    residual = residual_of(text)
    found = [one.conserved.quantity for one in symmetries(residual.model, residual.conserved)]
    assert any(name.startswith("I_") for name in found)
    motion = follow(text, 1.0, 11, outputs=("conserved",))
    for name in found:
        series = motion[f"diagnostics/conserved/{name}"]
        assert np.ptp(series) < 1e-12 * max(1, np.abs(series).max()), name


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("case", [*CASES, "a sum as a function"])
def test_formulas_are_what_is_computed(case):
    search, _ = searched(
        CASES[case][0] if case in CASES else LIOUVILLE.replace("k*sin(w)", "k*sin(w)*(2 + w)")
    )
    model, noether = search.model, search.noether
    names = {f"p_{name}": p for name, p in zip(model.coordinates, noether.energetics.momenta)}
    for one in model.particles:
        names |= {f"{one.name}.{axis}": x for axis, x in zip("xyz", one.position)}
        names |= {f"{one.name}.v{axis}": u for axis, u in zip("xyz", one.velocity)}
    names["h"] = noether.energy
    for found in search.found():
        written = build(
            parse(found.text), lambda name: names.get(name, model.algebra.symbol(name)), model.algebra
        )
        assert is_zero(written - found.node)


NOTHING = {
    "Henon and Heiles": PLANE.format("(x**2 + y**2)/2 + x**2*y - y**3/3"),
    "a number that is a parameter": PLANE.format("(x**2 + y**2)/2 + x**2*y + B*y**3"),
    "quartic": PLANE.format("x**4 + 5*x**2*y**2 + 8*y**4"),
    "an oscillator with any frequencies": PLANE.format("A*x**2 + B*y**2 + x*y**3"),
    "unequal masses of the Toda lattice": TODA.replace('i in range(N)]": 1}', 'i in range(N)]": 1 + i}'),
    "another power of Calogero's": CALOGERO.replace("**2 for", "**4 for"),
    "a sphere and a cubic potential": CASES["Neumann 1859, Uhlenbeck 1982"][0].replace(
        "c*z**2)/2", "z**3)/2"
    ),
    "a monopole and a field": SPACE.format("forces: {p: g*cross(v, r)/norm(r)**3}\npotential: a*x*y"),
    "Liouville's with one term more": LIOUVILLE.replace("k*sin(w)", "k*sin(w) + u*w"),
}


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("case", NOTHING)
def test_nothing_else_is_claimed(case):
    """What holds at some values of the parameters is no integral of the system in the file."""
    residual = residual_of(NOTHING[case])
    found = [one.conserved.quantity for one in symmetries(residual.model, residual.conserved)]
    assert not [name for name in found if name.startswith("I_")]


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    "coefficient", ["A", "A - B", "4*A - B", "(A - B)*(A + 2*B)/A**2", "A*sqrt(3)", "0.37"]
)
def test_coefficients_are_functions_of_the_parameters(coefficient):
    """Greene's integral, where x^2 y + 2 y^3 has a coefficient e."""
    e = f"({coefficient})"
    search, published = searched(
        PLANE.format(f"(A*x**2 + B*y**2)/2 + {e}*(x**2*y + 2*y**3)"),
        f"{e}**2*(x**4 + 4*x**2*y**2) - 4*{e}*x_dot*(x_dot*y - y_dot*x) + 4*A*{e}*x**2*y"
        " + (4*A - B)*(x_dot**2 + A*x**2)",
    )
    (one,) = search.found()
    assert one.degree == 2
    assert search.rank([*search.known, published]) == search.rank(search.known) == 2


@pytest.mark.exhaustive(keep=0.7)
def test_integrals_of_low_degree_come_first():
    """Winternitz's oscillator has shorter ones of the third degree."""
    search, _ = searched(SPACE.format("potential: (x**2 + y**2 + z**2)/2 + a/x**2 + b/y**2 + c/z**2"))
    search.known += (one.node for one in symmetries(search.model) if one.conserved.quantity[:2] == "h_")
    assert [one.degree for one in search.found()] == [2, 2]


@pytest.mark.exhaustive(keep=0.75)
def test_what_is_not_conserved_is_not_proven():
    search, _ = searched(CASES["Holt 1982"][0])
    (one,) = search.found()
    graph, model = search.graph, search.model
    assert search.states.conserves(one.node)
    assert not search.states.conserves(one.node + graph.constant(2.0**-60) * model.q[0])
    assert not any(search.states.conserves(x) for x in (*model.q, *model.v))
    assert LARGE.bit_length() == 521


PAIRS = {
    "Toda, a ring": ("sum(0.8*exp(1.2*(q[i] - q[(i + 1) % N])) for i in range(N))", True),
    "Toda, a chain": ("sum(exp(q[i] - q[i + 1]) for i in range(N - 1))", True),
    "Calogero": ("sum(0.7/(q[i] - q[j])**2 for i in range(N) for j in range(i))", True),
    "Sutherland": ("sum(0.7/sinh(q[i] - q[j])**2 for i in range(N) for j in range(i))", True),
    "another power": ("sum(0.7/(q[i] - q[j])**4 for i in range(N) for j in range(i))", False),
}


@pytest.mark.exhaustive(keep=1.5)
@pytest.mark.parametrize("case", PAIRS)
@pytest.mark.parametrize("count", [5, 6])
def test_as_many_integrals_as_particles_act_on_each_other_in_pairs(case, count):
    """Of every degree (Henon 1974, Moser 1975), with a mass other than 1."""
    potential, integrable = PAIRS[case]
    text = (
        LINE.format(f'"{potential}"')
        .replace("N: 3", f"N: {count}")
        .replace('range(N)]": 1}', 'range(N)]": 1.3}')
    )
    model = released(residual_of(text).model)
    search = PolynomialIntegrals(model, Noether(model), [])
    assert [one.degree for one in search.of_pairs()] == [*range(3, count + 1)] * integrable

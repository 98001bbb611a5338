"""Systems in curvilinear coordinates of flat space: what the particle conserves in Cartesian ones."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conserved.flat import flat_space
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from tests.support.command import lagrange
from tests.support.motion import follow, residual_of

POLAR = "m/2*(r_dot**2 + r**2*phi_dot**2)"
SPHERICAL = "m/2*(r_dot**2 + r**2*th_dot**2 + (r*sin(th)*phi_dot)**2)"
CYLINDER = "m/2*(r_dot**2 + r**2*phi_dot**2 + z_dot**2)"
ATWOOD = "(m + {M})/2*r_dot**2 + m/2*r**2*th_dot**2 - g*r*({M} - m*cos(th))"
LAPLACE, FRADKIN = {"A_x", "A_y"}, {"F_xx", "F_xy"}
CASES = {
    "Kepler in a plane": ("r phi", f"{POLAR} + k/r", LAPLACE),
    "the angle first": ("phi r", f"{POLAR} + k/r", LAPLACE),
    "Kepler in Cartesian coordinates": (
        "x y",
        "m/2*(x_dot**2 + y_dot**2) + k/sqrt(x**2 + y**2)",
        {"L_z", *LAPLACE},
    ),
    "Kepler in space": ("r th phi", f"{SPHERICAL} + k/r", {"L_x", "L_y", "A_z", *LAPLACE}),
    "Kepler in parabolic coordinates": (
        "u w",
        "m/2*(u**2 + w**2)*(u_dot**2 + w_dot**2) + 2*k/(u**2 + w**2)",
        {"L_z", *LAPLACE},
    ),
    "the logarithm of r": ("s phi", "m/2*exp(2*s)*(s_dot**2 + phi_dot**2) + k*exp(-s)", LAPLACE),
    "another origin": ("r phi", "m/2*(r_dot**2 + (r - m)**2*phi_dot**2) + k/(r - m)", LAPLACE),
    "Stark 1914": ("r phi z", f"{CYLINDER} + k/sqrt(r**2 + z**2) + g*z", {"A_z"}),
    "Fradkin 1965": ("r phi", f"{POLAR} - k*r**2/2", FRADKIN),
    "Fradkin 1965, in space": (
        "r th phi",
        f"{SPHERICAL} - k*r**2/2",
        {"L_x", "L_y", "F_xz", "F_yy", "F_yz", *FRADKIN},
    ),
    "a projectile": ("r phi", f"{POLAR} - m*g*r*sin(phi)", {"P_x", "C_1", "A_y"}),
    "a magnetic field": ("r phi", f"{POLAR} + g*r**2*phi_dot/2", {"C_1", "C_2"}),
    "two masses": ("r phi z", "m/2*(r_dot**2 + r**2*phi_dot**2) + k/2*z_dot**2 - r**2", FRADKIN),
    "an oscillator on a cone": ("r phi", "m/2*(r_dot**2 + r**2*sin(k)**2*phi_dot**2) - g*r**2/2", FRADKIN),
    "Tufillaro 1986, Atwood's swinging machine": ("r th", ATWOOD.format(M="3*m"), {"A_y"}),
}
CURVED = {
    "Atwood's swinging machine, 2:1": ("r th", ATWOOD.format(M="2*m")),
    "any masses": ("r th", ATWOOD.format(M="k")),
    "a cone": ("r phi", "m/2*(r_dot**2 + r**2*sin(k)**2*phi_dot**2) - m*g*r"),
    "another power": ("r phi", f"{POLAR} + k/r**3"),
    "a sphere": ("th phi", "m/2*(th_dot**2 + sin(th)**2*phi_dot**2) - k*cos(th)"),
    "a double pendulum": (
        "a b",
        "m*a_dot**2 + m/2*b_dot**2 + m*a_dot*b_dot*cos(a - b) + m*g*(2*cos(a) + cos(b))",
    ),
    "rotating coordinates": ("r phi", "m/2*(r_dot**2 + r**2*(phi_dot + g)**2) + k/r"),
    "damped": ("r phi", f"exp(g*t)*({POLAR} + k/r)"),
}


def text_of(coordinates, lagrangian):
    each = (
        f"{name}: {{initial: {1 + 0.1 * i}, velocity: {0.4 - 0.1 * i}}}"
        for i, name in enumerate(coordinates.split())
    )
    return f"""
parameters: {{m: 0.3, k: 0.9, g: 0.4}}
coordinates: {{{", ".join(each)}}}
lagrangian: {lagrangian}
"""


def found_in(text):
    residual = residual_of(text)
    return {one.conserved.quantity: one for one in symmetries(residual.model, residual.conserved)}


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("case", CASES)
def test_it_conserves_what_the_particle_does(case):
    coordinates, lagrangian, expected = CASES[case]
    assert found_in(text_of(coordinates, lagrangian)).keys() == expected


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("case", CASES)
def test_motions_keep_it(case):
    coordinates, lagrangian, expected = CASES[case]
    motion = follow(text_of(coordinates, lagrangian), 1.0, 11, outputs=("conserved",))
    for name in expected:
        series = motion[f"diagnostics/conserved/{name}"]
        assert np.ptp(series) < 1e-12 * max(1, np.abs(series).max()), name


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("case", CURVED)
def test_nothing_else_is_claimed(case):
    assert not found_in(text_of(*CURVED[case]))


@pytest.mark.parametrize(
    "case", ["Kepler in space", "two masses", "Tufillaro 1986, Atwood's swinging machine"]
)
def test_the_particle_has_the_same_energies(case):
    model = residual_of(text_of(*CASES[case][:2])).model
    space = flat_space(model)
    assert is_zero(Noether(space).energetics.lagrangian - model.lagrangian)


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize("case", [*CASES, *CURVED])
def test_looking_for_it_costs_little(case):
    model = residual_of(text_of(*(CASES | CURVED)[case][:2])).model
    work = model.algebra.graph.work
    before = work.spent
    flat_space(model)
    assert work.spent - before < 60_000


@pytest.mark.exhaustive(keep=0.8)
def test_tufillaros_integral():
    """N. Tufillaro, J. Physique 47, 1495, 1986: r^2 th_dot (r_dot cos(th/2) - r/2 th_dot sin(th/2))
    + g r^2 sin(th/2) cos(th/2)^2, up to a factor."""
    text = text_of("r th", ATWOOD.format(M="3*m"))
    published = "r**2*th_dot*(r_dot*cos(th/2) - r*th_dot*sin(th/2)/2) + g*r**2*sin(th/2)*cos(th/2)**2"
    residual = residual_of(f"{text}observables: {{published: {published}}}\n")
    (one,) = symmetries(residual.model, residual.conserved)
    m = residual.model.parameters["m"]
    assert is_zero(one.node + 2.0 * m * residual.model.observables["published"])


@pytest.mark.exhaustive(keep=0.8)
def test_the_reason_says_where_the_particle_is():
    found = found_in(text_of("r th", ATWOOD.format(M="3*m")))
    assert found["A_y"].conserved.because.endswith(
        "the system moves like one particle of mass 4*m at (r*cos(th/2), r*sin(th/2))"
    )


@pytest.mark.exhaustive(keep=0.55)
def test_components_are_printed_as_in_textbooks(tmp_path):
    """Orthogonal coordinates leave no determinants behind."""
    (tmp_path / "kepler.yaml").write_text(text_of("r th phi", f"{SPHERICAL} + k/r"))
    said = lagrange("equations", "kepler.yaml", cwd=tmp_path).stdout
    assert "L_x = -m*r**2*sin(phi)*th_dot - m*r**2*sin(th)*cos(th)*cos(phi)*phi_dot\n" in said

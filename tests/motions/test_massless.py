"""Coordinates without mass: their equations of motion contain no accelerations."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.cli.main import main
from lagrange_cli.expression.syntax import children
from lagrange_cli.run.massless import with_equations_of_the_massless
from lagrange_cli.run.start import consistent_values
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values

METHODS = "taylor", "ias15", "DOP853", "Radau"
CLOSE = {"taylor": 1e-14, "ias15": 1e-13, "DOP853": 1e-8, "Radau": 1e-8}

MAXWELL = """
parameters: {m: 1.3, k: 2, c: 0.7}
coordinates: {x: {initial: 0.4, velocity: -0.1}, z: {initial: 0.1}}
masses: {bob: m}
positions: {bob: x}
potential: k*z**2/2
dissipation: c*(x_dot - z_dot)**2/2
"""


@pytest.mark.parametrize("method", METHODS)
def test_a_spring_and_a_damper_in_series(method: str) -> None:
    """m x'' = -k z and z' = x' - k z/c: z'' + k z'/c + k z/m = 0, a damped oscillator."""
    m, k, c = 1.3, 2.0, 0.7
    found = lagrange.solve(MAXWELL, stop=4, samples=9, outputs="q,v,multipliers,constraints", method=method)
    rate, own = -k / (2 * c), complex(k / m - (k / (2 * c)) ** 2) ** 0.5
    z0, w0 = 0.1, -0.1 - k * 0.1 / c
    t = found.t
    z = (np.exp(rate * t) * (z0 * np.cos(own * t) + (w0 - rate * z0) * np.sin(own * t) / own)).real
    rates = (
        np.exp(rate * t)
        * (w0 * np.cos(own * t) - (z0 * own**2 + rate * (rate * z0 - w0)) * np.sin(own * t) / own)
    ).real
    assert np.allclose(found.q["z"], z, rtol=0, atol=CLOSE[method])
    assert np.allclose(found.v["z"], rates, rtol=0, atol=10 * CLOSE[method])
    assert np.allclose(found.v["x"], rates + k * z / c, rtol=0, atol=10 * CLOSE[method])
    assert np.max(np.abs(found.multipliers["equation of z"])) < 10 * CLOSE[method]


SERIES = """
parameters: {m: 1.3, k: 2, r: 3}
coordinates: {x: {initial: 0.4}, z: {}}
masses: {bob: m}
positions: {bob: x}
potential: k*z**2/2 + r*(x - z)**2/2
"""


@pytest.mark.parametrize("method", METHODS)
def test_springs_in_series(method: str) -> None:
    found = lagrange.solve(SERIES, stop=4, samples=9, outputs="q,h", method=method)
    stiffness = 2 * 3 / (2 + 3)
    x = 0.4 * np.cos(math.sqrt(stiffness / 1.3) * found.t)
    assert np.allclose(found.q["x"], x, rtol=0, atol=CLOSE[method])
    assert np.allclose(found.q["z"], 3 * x / 5, rtol=0, atol=CLOSE[method])
    assert found.attributes["h_drift"] < 10 * CLOSE[method]


VORTICES = """
sizes: {{N: {count}}}
parameters: {{"G[i in range(N)]": 1 + i/3}}
coordinates:
  x[i in range(N)]: {{initial: "cos(2.3*i) + 0.1*i"}}
  y[i in range(N)]: {{initial: "sin(2.3*i)"}}
lagrangian: >-
  sum(G[i]*y[i]*x_dot[i] for i in range(N))
  + sum(G[i]*G[j]*log((x[i] - x[j])**2 + (y[i] - y[j])**2)/(4*pi) for i in range(N) for j in range(i))
"""


@pytest.mark.parametrize("method", METHODS)
def test_two_vortices_go_round_each_other(method: str) -> None:
    """At a distance d, with the angular velocity (G1 + G2)/(2 pi d^2), about G1 r1 + G2 r2."""
    found = lagrange.solve(VORTICES.format(count=2), stop=20, samples=5, outputs="q", method=method)
    strength = np.array([1.0, 4 / 3])
    z = found.q["x"] + 1j * found.q["y"]
    centre = z @ strength / strength.sum()
    angle = strength.sum() / (2 * math.pi * abs(z[0, 0] - z[0, 1]) ** 2) * found.t
    expected = centre[0] + (z[0] - centre[0]) * np.exp(1j * angle)[:, None]
    assert np.max(np.abs(z - expected)) < 10 * CLOSE[method]


@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_vortices_keep_their_impulses(precision: str) -> None:
    """sum G x, sum G y and sum G (x^2 + y^2), and h."""
    text = VORTICES.format(count=5)
    found = lagrange.solve(text, stop=3, samples=7, outputs="q,h", precision=precision)
    strength = 1 + np.arange(5) / 3
    x, y = found.q["x"], found.q["y"]
    small = 1e-13 if precision == "double" else 4e-15
    for kept in (x @ strength, y @ strength, (x**2 + y**2) @ strength):
        assert np.ptp(kept) < small
    assert found.attributes["h_drift"] < (1e-14 if precision == "double" else 1e-29)
    assert "h" in lagrange.check(text).conserved


@pytest.mark.parametrize("method", METHODS)
def test_a_hard_spring_in_series(method: str) -> None:
    """z^3 = x - z holds at all times, and h is kept."""
    text = SERIES.replace("k*z**2/2 + r*(x - z)**2/2", "z**4/4 + (x - z)**2/2").replace("0.4", "2")
    found = lagrange.solve(text, stop=8, samples=9, outputs="q,v,h", method=method)
    x, z = found.q["x"], found.q["z"]
    assert np.max(np.abs(z**3 + z - x)) < 10 * CLOSE[method]
    assert np.max(np.abs((3 * z**2 + 1) * found.v["z"] - found.v["x"])) < 10 * CLOSE[method]
    assert found.attributes["h_drift"] < 10 * CLOSE[method]
    assert np.min(x) < -1.5


def test_a_vortex_moves_on_a_level_of_its_energy_backward_in_time() -> None:
    text = "coordinates: {x: {initial: 1}, y: {initial: 0.2}}\nlagrangian: x*y_dot - x**2/2 - y**4/4\n"
    found = lagrange.solve(text, start=0, stop=-5, samples=11, outputs="q,v,h")
    assert np.allclose(found.v["y"], found.q["x"], rtol=0, atol=1e-14)
    assert np.allclose(found.v["x"], -(found.q["y"] ** 3), rtol=0, atol=1e-14)
    assert found.attributes["h_drift"] < 1e-14


def test_steps_that_are_proven_are_as_long_as_with_a_mass() -> None:
    """What is hidden in exp has to be proven to be met; the multiplier in the equation of w is 0."""
    text = "coordinates: {x: {initial: 1}, w: {initial: 0.3}}\ndissipation: w_dot**2/2\n"
    for potential in ("exp(-w**2)", "exp(-x**2)"):
        found = lagrange.solve(
            text + f"lagrangian: x_dot**2/2 - {potential} - (x - w)**2/2\n", stop=1, outputs="q,v"
        )
        assert found.attributes["steps"] < 20
        w, x = found.q["w"], found.q["x"]
        force = 2 * w * np.exp(-(w**2)) if "w" in potential else 0.0
        assert np.allclose(found.v["w"], x - w + force, rtol=0, atol=1e-14)


def test_velocities_that_are_almost_undetermined_are_found() -> None:
    """The determinant of the equations of a and b is 0.0016: velocities are as large as 10^4."""
    text = """
coordinates: {a: {initial: 1.35}, b: {initial: 1.44}}
lagrangian: 0.48*b*a_dot + 0.52*a*b_dot - b**4/3 - b**2*a - a**2
dissipation: 1.27*(a_dot - b_dot)**2/2
"""
    found = lagrange.solve(text, stop=1e-4, samples=2, outputs="q,v")
    (a, _), (b, _) = found.q["a"], found.q["b"]
    speeds = np.linalg.solve([[1.27, -1.31], [-1.23, 1.27]], [-(b**2) - 2 * a, -4 * b**3 / 3 - 2 * a * b])
    assert np.allclose([found.v["a"][0], found.v["b"][0]], speeds, rtol=1e-11)
    assert np.min(np.abs(speeds)) > 5e3


DRAWN = """
coordinates:
  x: {{initial: 0.5}}
  y: {{initial: -0.2, velocity: 0.3}}
  z: {{initial: 0.1}}
  w: {{initial: 0.2}}
lagrangian: >-
  x_dot**2/2 + (1 + x**2)*y_dot**2/2 + {a}*z*x_dot{mass}
  - {b}*cos(z - x) - {c}*(w - y)**2 - x**2 - y**2 - z**2*w/9
dissipation: "{d}*(z_dot - x_dot)**2/2 + {e}*(w_dot - z_dot)**2/2 + (1 + x**2)*w_dot**2/5"
generalized_forces: {{z: "sin({f}*t)", w: 0.2*x}}
"""


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("case", range(12))
def test_motions_are_limits_of_those_with_small_masses(case: int, pytestconfig: pytest.Config) -> None:
    """Which are stiff, and are off by the mass."""
    chance = random.Random(f"{pytestconfig.option.seed} massless {case}")
    numbers = {name: f"{chance.uniform(0.4, 1.5):.2f}" for name in "abcdef"}
    without, near = (
        lagrange.solve(
            DRAWN.format(mass=mass, **numbers), stop=2, samples=5, outputs="q", method=method, tolerance=1e-9
        )
        for mass, method in (("", "taylor"), (" + 1e-7*(z_dot**2 + w_dot**2)/2", "Radau"))
    )
    for name in "xyzw":
        assert np.max(np.abs(without.q[name] - near.q[name])) < 2e-6, numbers


BOB = """
parameters: {m: 1, k: 40, c: 3, g: 9.81}
coordinates: {x: {initial: 0.6}, y: {initial: 0.8}, z: {initial: 0.1}}
masses: {bob: mLIGHT}
positions: {bob: [x, y]PLACE}
potential: k*z**2/2 + m*g*y
dissipation: c*(y_dot - z_dot)**2/2
"""
BESIDE = {
    "a rod": "constraints: {rod: x**2 + y**2 - 1}\n",
    "a floor": ("events: {floor: {when: y, direction: falling, action: {set: {y_dot: -0.8*y_dot}}}}\n"),
    "a kink": "generalized_forces: {x: -max(0, x - 0.5) - 0.3*x_dot}\n",
    "dry friction": "generalized_forces: {x: 3*sin(2*t) - 2*sign(x_dot)}\n",
}


@pytest.mark.parametrize("kind", BESIDE)
def test_beside_others_they_move_as_small_masses_do(kind: str) -> None:
    """Velocities that are left out are 0 of what has a mass; at the start, z' = y' - k z/c."""
    text = BOB + BESIDE[kind]
    found = lagrange.solve(text.replace("LIGHT", "").replace("PLACE", ""), stop=3, samples=7, outputs="q,v")
    light = text.replace("LIGHT", ", dot_: 1e-7").replace("PLACE", ", dot_: z")
    near = lagrange.solve(light, stop=3, samples=7, outputs="q,v", method="Radau", tolerance=1e-10)
    assert found.v["x"][0] == found.v["y"][0] == 0.0
    assert found.v["z"][0] == pytest.approx(-40 * 0.1 / 3, rel=1e-14)
    for name in "xyz":
        assert np.max(np.abs(found.q[name] - near.q[name])) < 1e-6


@pytest.mark.parametrize(
    "text", [MAXWELL, SERIES, VORTICES.format(count=3)], ids=["damper", "springs", "vortices"]
)
def test_printed_equations_are_those_that_are_solved(text: str, tmp_path, capsys) -> None:
    path = tmp_path / "system.yaml"
    path.write_text(text, encoding="utf-8")
    for form in ("lagrange", "matrix"):
        assert main(["equations", "--verify", "--form", form, str(path)]) == 0, capsys.readouterr()
    assert main(["equations", str(path)]) == 0
    shown = capsys.readouterr().out
    assert "lambda_" not in shown


@pytest.mark.parametrize("replaced", ["z: x - w", "x: w + s, z: w - s", "x: 2*w"])
def test_other_coordinates(replaced: str, tmp_path, capsys) -> None:
    """Of which one has no mass, or M is singular."""
    new = "[w, s]" if "s" in replaced else "[w]"
    text = MAXWELL + f"transformations: {{other: {{coordinates: {new}, replace: {{{replaced}}}}}}}\n"
    path = tmp_path / "system.yaml"
    path.write_text(text, encoding="utf-8")
    assert main(["equations", "--verify", "--coordinates", "other", str(path)]) == 0
    shown = capsys.readouterr().out
    assert "the equations keep their form" in shown and "equations agree" in shown


def test_a_coordinate_without_mass_that_meets_no_other() -> None:
    """c w' = k (x - w): the matrix of the constraint and the coordinate has no mass at all."""
    text = MAXWELL.replace("z", "w").replace("k*w**2/2", "k*(x - w)**2/2").replace("(x_dot - w_dot)", "w_dot")
    found, other = (lagrange.solve(one, stop=4, samples=9, outputs="q,v") for one in (text, MAXWELL))
    assert np.allclose(found.v["w"], 2 * (found.q["x"] - found.q["w"]) / 0.7, rtol=0, atol=1e-13)
    start = text.replace("w: {initial: 0.1}", "w: {initial: 0.3}")  # as x - z there
    assert np.allclose(
        lagrange.solve(start, stop=4, samples=9, outputs="q").q["x"], other.q["x"], rtol=0, atol=1e-13
    )


def test_equations_of_coordinates_without_mass_are_printed_as_they_are() -> None:
    shown = lagrange.equations(MAXWELL).write()
    assert "-c*x_dot + c*z_dot + k*z = 0   [z]" in shown
    assert "m*x_ddot + c*x_dot - c*z_dot = 0   [x]" in shown
    assert "dh/dt = -c*(x_dot - z_dot)**2" in shown
    assert "onstraint" not in shown.partition("Conserved")[0] and "of constraint" not in shown
    assert shown.startswith("text: 1 degree of freedom and 1 coordinate of first order\n")
    checked = lagrange.check(MAXWELL)
    assert checked.degrees_of_freedom == 1


@pytest.mark.parametrize(
    ("force", "message"),
    [
        ("-z_dot**3", "equation of motion of 'z', which has no mass, is not linear in velocities"),
        ("-z_dot*abs(x_dot) - z_dot", "equation of motion of 'z', which has no mass, is not linear"),
        ("0*z", "no kinetic energy depends on the velocity of 'z'"),
        ("x", "no kinetic energy depends on the velocity of 'z'"),
    ],
)
def test_what_does_not_determine_them_is_refused(force: str, message: str) -> None:
    text = "coordinates: {x: {initial: 1}, z: {initial: 0}}\nlagrangian: x_dot**2/2 - x**2\n"
    text += f"generalized_forces: {{z: '{force}'}}\n"
    for command in (lagrange.check, lagrange.equations, lambda one: lagrange.solve(one, stop=1)):
        with pytest.raises(lagrange.SpecError, match=message):
            command(text)


def test_equations_of_a_thousand_terms_are_not_deep() -> None:
    text = "coordinates: {x: {initial: 1}, z: {}}\nsizes: {N: 1200}\n"
    text += "lagrangian: x_dot**2/2 - z**2 - sum(cos(k*(x - z))/k**3 for k in range(1, N))\n"
    spec = with_equations_of_the_massless(read_spec(text, "system.yaml"))
    tree, depth = spec.constraints["equation of z"].tree, 0
    level = [tree]
    while level:
        depth, level = depth + 1, [one for each in level for one in children(each)]
    assert depth < 40


def test_many_of_them_are_written_out_and_refused_in_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those whose equations give places."""
    text = """
sizes: {N: 26}
coordinates: {"x[i in range(N)]": {initial: 0.1*i}, "z[i in range(N)]": {}}
masses: {"bob[i in range(N)]": 1}
positions: {"bob[i in range(N)]": "x[i]"}
potential: sum(z[i]**2 + (x[i] - z[i])**4 + (x[i] - z[i])**2 for i in range(N))
"""
    monkeypatch.setenv("LAGRANGE_LIMITS", "convolutions=100")
    with pytest.raises(lagrange.SpecError, match="members are written out for coordinates without mass"):
        lagrange.solve(text, stop=0.1)
    with pytest.raises(
        lagrange.UsageError, match="with coordinates without mass every member is written out"
    ):
        lagrange.equations(text, indexed=True)


def test_values_that_their_equations_exclude_are_refused() -> None:
    with pytest.raises(lagrange.SpecError, match="'equation of z' is not satisfied by the initial values"):
        lagrange.solve(SERIES.replace("z: {}", "z: {initial: 0}"), stop=1)


def test_their_equations_keep_all_digits() -> None:
    """Also those of 1/pi and 0.1: in double-double, initial velocities have 31 digits."""
    text = """
parameters: {a: 1.1}
coordinates: {x: {initial: 0.1, velocity: 1}, y: {initial: 0.3}}
masses: {bob: 1}
positions: {bob: x}
potential: 0
dissipation: (y_dot - a*x*x_dot/pi + 0.1*y)**2/2
"""
    spec = with_equations_of_the_massless(read_spec(text, "system.yaml"))
    _, values, _ = consistent_values(spec, resolve_long_values(spec, {}), 0.0, (), exact=True)
    assert values.remainder is not None
    with mpmath.workdps(40):
        exact = mpmath.mpf("0.11") / mpmath.pi - mpmath.mpf("0.03")
        found = mpmath.mpf(values.v[1]) + values.remainder.v[1]
        assert abs(found - exact) < 1e-33

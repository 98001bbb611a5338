"""What rests where forces cancel in large systems, and forces that begin: steps do not follow rounding."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.families.long_values import LongNumbers
from lagrange_cli.families.static_forces import rounding_at_rest
from lagrange_cli.families.system import any_family_system
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.spec.read import read_spec
from tests.motions.test_double_double import solved
from tests.support.families import followed
from tests.support.motion import SYSTEMS

PLACES = """
sizes: {{N: {N}}}
parameters: {{m: {m}, k: {k}, g: 9.81, A: {A}, w: {w}, "d[i in range(N)]": m*g*(N - i)/k}}
coordinates: {{"x[i in range(N)]": {{initial: {rest}}}}}
masses: {{"p[i in range(N)]": m}}
embedding: {{"p[i in range(N)]": ["x[i]"]}}
potential: >
  k*(x[0] + d[0])**2/2 + sum(k*(x[i] - x[i - 1] + d[i])**2/2 for i in range(1, N))
  - sum(m*g*x[i] for i in range(N))
generalized_forces: {{"x[1]": "where(t > 0.3, A*(1 - cos(w*(t - 0.3))), 0)"}}
"""
LENGTHS = """
sizes: {{N: {N}}}
parameters: {{m: {m}, k: {k}, g: 9.81, A: {A}, w: {w}, "d[i in range(N)]": m*g*(N - i)/k}}
coordinates: {{"x[i in range(N)]": {{initial: {rest}}}}}
masses: {{"p[i in range(N)]": m}}
embedding: {{"p[i in range(N)]": ["sum(x[j] for j in range(i + 1))"]}}
potential: sum(k*(x[i] + d[i])**2/2 for i in range(N)) - sum(m*g*p[i].x for i in range(N))
generalized_forces:
  "x[0]": "where(t > 0.3, A*(1 - cos(w*(t - 0.3))), 0)"
  "x[1]": "where(t > 0.3, A*(1 - cos(w*(t - 0.3))), 0)"
"""
FORMS = {"places": PLACES, "lengths": LENGTHS}
"""Masses one below the other on springs, at rest: by their places, and by the lengths of the springs, which
makes them a chain of joints. A force on the second one begins at t = 0.3."""


def moved(count: int, m: float, k: float, A: float, w: float, s: float) -> NDArray[np.float64]:
    """Where the masses are a time s after the force has begun, by normal modes."""
    springs = np.eye(count) - np.diag(np.ones(count - 1), -1)
    squares, modes = np.linalg.eigh(k / m * springs.T @ springs)
    free, forced = np.sqrt(squares) * s, w * s
    twice = 2 * np.sin((free + forced) / 2) * np.sin((free - forced) / 2)  # cos(forced) - cos(free)
    amplitude = (2 * np.sin(free / 2) ** 2 / squares - twice / (squares - w**2)) * (A / m)
    return np.asarray(modes @ (amplitude * modes[1]))


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("form", FORMS)
def test_masses_at_rest_on_springs_are_pushed(form: str, method: str, request: pytest.FixtureRequest) -> None:
    source = random.Random(f"{form} {method} {request.config.option.seed}")
    for count in (2, 40, 150):
        scales = {"m": (-1, 1), "k": (2, 3.5), "A": (-2, 1), "w": (-0.5, 1)}
        given = {name: float(f"{10 ** source.uniform(*both):.3g}") for name, both in scales.items()}
        print(count, given)
        text = FORMS[form].format(N=count, rest=0, **given)
        _, motion = followed(text, frozenset(["q"]), stop=1.0, samples=2, method=method)
        assert motion.outcome.ending is Ending.COMPLETE
        assert motion.outcome.steps <= 200 + 60 * (given["k"] / given["m"]) ** 0.5
        found = motion["q/x"][-1]
        known = moved(count, s=float(motion.t[-1]) - 0.3, **given)
        rounding = 1e-12 * count * given["m"] * 9.81 / given["k"]
        assert abs(found - (known if form == "places" else np.diff(known, prepend=0))).max() <= (
            1e-11 * abs(known).max() + rounding
        )


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("form", FORMS)
def test_masses_are_pushed_in_double_double(form: str, tmp_path: Path) -> None:
    """Against the same in doubles, whose rounding errors are 2^53 times as large."""
    given = {"m": 0.3, "k": 500, "A": 2, "w": 5}
    text, end = FORMS[form].format(N=30, rest=0, **given), ["--stop", "0.6", "--samples", "2"]
    said, longer = solved(tmp_path, text, *end, "--precision", "double-double")
    _, shorter = solved(tmp_path, text, *end)
    assert said["steps"] <= 1000
    assert all(abs(a - b) <= 1e-14 for a, b in zip(longer["q/x"], shorter["q/x"], strict=True))


HANGING = """
sizes: {{N: {N}}}
parameters: {{m: {m}, g: 9.81, l: {l}, k: {k}, d: N*m*g/k, A: {A}, w: {w}}}
coordinates: {{"x[i in range(N)]": {{initial: 0}}, "y[i in range(N)]": {{initial: -l*i - 1}}}}
masses: {{"p[i in range(N)]": m}}
embedding: {{"p[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum(m*g*p[i].y for i in range(N)) + k*((y[0] + 1 - d)**2 + x[0]**2)/2
constraints:
  rod[i in range(1, N)]: (x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2 - l**2
generalized_forces: {{"{where}": "where(t > 0.3, A*(1 - cos(w*(t - 0.3))), 0)"}}
"""


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("where", ["x[2]", "y[2]"])
def test_rods_at_rest_are_pushed(where: str, request: pytest.FixtureRequest) -> None:
    """What holds them cancels their weight: by two methods."""
    source = random.Random(f"{where} {request.config.option.seed}")
    scales = {"m": (-1, 1), "k": (2, 3.5), "A": (-2, 0), "w": (-0.5, 1), "l": (-1, 0)}
    given = {name: float(f"{10 ** source.uniform(*both):.3g}") for name, both in scales.items()}
    print(given)
    text = HANGING.format(N=60, where=where, **given)
    found = []
    for method in ("taylor", "ias15"):
        _, motion = followed(text, frozenset(["q"]), stop=0.8, samples=2, method=method)
        assert motion.outcome.ending is Ending.COMPLETE
        assert motion.outcome.steps <= 3000
        found.append([motion[f"q/{one}"][-1] for one in "xy"])
    (x, y), (other_x, other_y) = found
    assert abs(x - other_x).max() <= 1e-9 * abs(x).max() + 1e-14
    assert abs(y - other_y).max() <= 1e-12


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize(("form", "rest"), [("places", 0), ("places", "0.7"), ("lengths", "0.7")])
def test_what_hangs_at_rest_stays_there_in_few_steps(form: str, rest: object, method: str) -> None:
    """Also where coordinates are far from 0; lengths of springs then have another rest."""
    text = FORMS[form].format(N=60, m=0.3, k=1000, A=0, w=1, rest=rest)
    text = text.replace('d[i in range(N)]": m*g*(N - i)/k', f'd[i in range(N)]": m*g*(N - i)/k - {rest}')
    if form == "places":
        text = text.replace("(x[i] - x[i - 1] + d[i])", f"(x[i] - x[i - 1] + d[i] + {rest})")
    _, motion = followed(text, frozenset(["q"]), stop=2.0, samples=5, method=method)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.steps <= 2000
    assert abs(motion["q/x"] - float(str(rest))).max() <= 1e-11


DROPPED = """
sizes: {{N: {N}}}
parameters: {{l: 0.1, g: 9.81, m: 1, M: 5}}
coordinates:
  x: {{initial: 0}}
  y: {{initial: 0}}
  "a[i in range(N)]": {{initial: {tilt} + 0.1*sin(7*i)}}
masses: {{hull: M, "p[i in range(N)]": m}}
positions:
  hull: [x, y]
  "p[0]": hull + l*[sin(a[0]), -cos(a[0])]
  "p[i in range(1, N)]": p[i - 1] + l*[sin(a[i]), -cos(a[i])]
potential: M*g*y + sum(m*g*p[i].y for i in range(N))
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("tilt", [0, 0.4, 1.5])
@pytest.mark.parametrize("count", [20, 60, 200])
def test_a_chain_that_is_dropped_falls_as_it_is(count: int, tilt: float) -> None:
    """No link turns: what the weights of all others do to it cancels but for rounding."""
    _, motion = followed(DROPPED.format(N=count, tilt=tilt), frozenset(["q"]), stop=1.0, samples=5)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.steps <= 200
    assert abs(motion["q/a"] - motion["q/a"][0]).max() <= 1e-9
    assert abs(motion["q/y"] + 9.81 * motion["t"] ** 2 / 2).max() <= 1e-11


NET = """
sizes: {N: 9}
parameters: {m: 0.3, k: 700, g: 9.81, l: 0.9}
coordinates: {"x[i in range(N)]": {initial: 0}, "y[i in range(N)]": {initial: 0}}
masses: {"p[i in range(N)]": m}
embedding: {"p[i in range(N)]": ["x[i]", "y[i]"]}
potential: >
  sum(k*(norm(p[i] - p[i - 1]) - l)**2/2 + k/(norm(p[i] - p[i - 1])) for i in range(1, N))
  + sum(m*g*p[i].y + cos(3*x[i]) for i in range(N))
"""


@pytest.mark.exhaustive(keep=0.65)
def test_sizes_are_those_of_rounding_errors(request: pytest.FixtureRequest) -> None:
    """Of a chain far from the origin, whose distances are known to fewer digits than places: forces as they
    are computed in doubles, and with many digits."""
    numbers = np.random.default_rng(request.config.option.seed)
    system = any_family_system(read_spec(NET, "system.yaml"))
    assert system is not None
    sizes, parameters, largest = rounding_at_rest(system), np.array([0.3, 700.0, 9.81, 0.9]), 0.0
    assert sizes is not None
    for _ in range(20):
        q = np.concatenate([40 + np.arange(9), np.zeros(9)]) + 0.1 * numbers.random(18)
        here = FamilyValues(system, 0.0, q, np.zeros(18), parameters)
        kind = LongNumbers()
        longer = map(kind.array, (q, np.zeros(18), parameters))
        exact = FamilyValues(system, kind.number(0.0), *longer, kind=kind).of(system.forces)
        errors = abs((here.of(system.forces) - exact).astype(float)) / 2.0**-53
        assert (errors <= here.of(sizes)).all()
        largest = max(largest, (errors / here.of(sizes)).max())
    assert largest >= 0.002


def test_errors_of_roots_and_poles_are_bounded() -> None:
    """Next to a pole no more than some 2^12 units of the force are taken for rounding."""
    system = any_family_system(read_spec(NET.replace("k*(norm", "(norm"), "system.yaml"))
    assert system is not None
    sizes = rounding_at_rest(system)
    assert sizes is not None
    q = np.concatenate([40 + np.arange(9.0), np.zeros(9)])
    q[1] = np.nextafter(q[0], 50)
    here = FamilyValues(system, 0.0, q, np.zeros(18), np.array([0.3, 700.0, 9.81, 0.9]))
    size, force = here.of(sizes)[:2], 700 / (q[1] - q[0]) ** 2
    assert (size > 2**11 * force).all() and (size < 2**16 * force).all()


def test_only_forces_at_rest_that_cancel_have_errors() -> None:
    for name in ("lattice", "fpu_chain", "solar_system"):
        system = any_family_system(read_spec((SYSTEMS / f"{name}.yaml").read_text(), name))
        assert system is None or rounding_at_rest(system) is None
    still = NET.replace("+ k/(norm(p[i] - p[i - 1]))", "").replace("m*g*p[i].y + cos(3*x[i])", "{}")
    for term, known in (("x[i]*log(x[i])", False), ("x[i]*log(1 + x[i]**2)", True), ("cos(x[i])", True)):
        system = any_family_system(read_spec(still.replace("{}", term), "system.yaml"))
        assert system is not None and (rounding_at_rest(system) is not None) == known

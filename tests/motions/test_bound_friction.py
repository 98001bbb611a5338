"""Dry friction beside constraints that hold the same bodies, so that forces are not determined: motions are
the limit of those under smooth friction."""

from __future__ import annotations

import random
import re
from functools import partial
from math import sin

import numpy as np
import pytest

from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE, FULL_DOUBLE_DOUBLE
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.mechanics.guards import modes
from lagrange_cli.native import guards
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values, resolve_values
from tests.support.motion import Motion, run

METHODS = {"taylor": 1e-12, "ias15": 1e-12, "DOP853": 1e-9, "Radau": 1e-8}
PENDULUM = """
parameters: {g: 9.81, F: 0.6, G: 0.4, T: 3}
coordinates: {x: {initial: 0.6}, y: {initial: -0.8}}
masses: {p: 1}
embedding: {p: [x, y]}
potential: "g*y - x*T*sin(2*t)"
constraints: {rod: "x**2 + y**2 - 1"}
generalized_forces: {x: "-F*sign(x_dot)", y: "-G*sign(y_dot)"}
"""
PENDULUMS = """
parameters: {g: 9.81, F: 0.6, G: 0.4, T: 3}
coordinates: {x: {initial: 0.6}, y: {initial: -0.8}, u: {initial: 1.2}, w: {initial: -1.6}}
masses: {p: 1, q: 0.7}
embedding: {p: [x, y], q: [u, w]}
potential: "g*y + 0.7*g*w - u*T*sin(2*t)"
constraints: {rod: "x**2 + y**2 - 1", link: "(u - x)**2 + (w - y)**2 - 1"}
generalized_forces: {x: "-F*sign(x_dot)", y: "-G*sign(y_dot)", u: "-F*sign(u_dot)", w: "-G*sign(w_dot)"}
"""
CRANK = """
parameters: {l: 2.5, F: 0.4, G: 0.3, T: 3}
coordinates:
  {a: {initial: 0.5}, b: {initial: "-asin(sin(0.5)/l)"}, x: {initial: "cos(0.5) + l*cos(asin(sin(0.5)/l))"}}
lagrangian: "0.5*a_dot**2 + 0.3*b_dot**2 + 0.7*x_dot**2 + T*a*sin(1.3*t)"
constraints: {along: "cos(a) + l*cos(b) - x", across: "sin(a) + l*sin(b)"}
generalized_forces: {a: "-F*sign(a_dot)", b: "-G*sign(b_dot)", x: "-G*sign(x_dot)"}
"""
FOUR_BARS = """
parameters: {F: 0.3, T: 2}
coordinates: {a: {initial: 1.2}, b: {initial: 0.2868114322881009}, c: {initial: 1.5169975014024714}}
lagrangian: "0.5*a_dot**2 + 0.4*b_dot**2 + 0.6*c_dot**2 + T*a*sin(1.3*t)"
constraints: {along: "cos(a) + 2*cos(b) - 1.5*cos(c) - 2.2", across: "sin(a) + 2*sin(b) - 1.5*sin(c)"}
generalized_forces: {FORCES}
"""
ALONE = '{a: "-F*sign(a_dot)", b: "-F*sign(b_dot)", c: "-F*sign(c_dot)"}'
HINGES = """{a: "-F*sign(a_dot) + F*sign(b_dot - a_dot)",
  b: "-F*sign(b_dot - a_dot) + F*sign(c_dot - b_dot)", c: "-F*sign(c_dot) - F*sign(c_dot - b_dot)"}"""
WIRE = """
parameters: {F: 0.5, G: 0.6, T: 3}
coordinates: {x: {initial: 0}, y: {initial: 0}}
masses: {p: 1}
embedding: {p: [x, y]}
potential: "-x*T*sin(2*t) + 2*y"
constraints: {wire: "y - sin(x)"}
generalized_forces: {x: "-F*sign(x_dot)", y: "-G*sign(y_dot)"}
"""
SLED = """
parameters: {F: 0.4, G: 0.5, T: 2}
coordinates: {x: {initial: 0}, y: {initial: 0}}
masses: {p: 1}
embedding: {p: [x, y]}
potential: "-x*T*sin(2*t)"
nonholonomic: {edge: "sin(0.5)*x_dot - cos(0.5)*y_dot"}
generalized_forces: {x: "-F*sign(x_dot)", y: "-G*sign(y_dot)"}
"""
COUPLED = """
parameters: {F: 0.4, G: 0.5, T: 3}
coordinates: {x: {initial: 0.6}, y: {initial: -0.8}}
lagrangian: "0.5*x_dot**2 + 0.6*y_dot**2 + 0.3*x_dot*y_dot - 5*y + x*T*sin(2*t)"
constraints: {rod: "x**2 + y**2 - 1"}
generalized_forces: {x: "-F*sign(x_dot)", y: "-G*sign(y_dot)"}
"""


def beads(count: int) -> str:
    """Beads joined by rods, and pulled by springs, on a table with friction along x and along y."""
    each = range(count)
    springs = (
        f"k*(x{i} - {0.8 * i} - V*t*{sin(i * i + 1)!r})**2/2 + (y{i} - 0.6*sin(2*t + {i}))**2" for i in each
    )
    places = (f"x{i}: {{initial: {0.8 * i}}}, y{i}: {{initial: {0.6 * (i % 2)}}}" for i in each)
    rods = (f'r{i}: "(x{i} - x{i - 1})**2 + (y{i} - y{i - 1})**2 - 1"' for i in each[1:])
    rubs = (f'x{i}: "-F*sign(x{i}_dot)", y{i}: "-F*{1 + i / 5!r}*sign(y{i}_dot)"' for i in each)
    return f"""
parameters: {{k: 2, V: 0.7, F: 0.4}}
coordinates: {{{", ".join(places)}}}
masses: {{{", ".join(f"p{i}: {1 + i / 7!r}" for i in each)}}}
embedding: {{{", ".join(f"p{i}: [x{i}, y{i}]" for i in each)}}}
potential: "{" + ".join(springs)}"
constraints: {{{", ".join(rods)}}}
generalized_forces: {{{", ".join(rubs)}}}
"""


SYSTEMS = {
    "a pendulum": PENDULUM,
    "two pendulums": PENDULUMS,
    "a slider-crank": CRANK,
    "four bars": FOUR_BARS.replace("{FORCES}", ALONE),
    "four bars with friction in hinges": FOUR_BARS.replace("{FORCES}", HINGES),
    "a bead on a wire": WIRE,
    "a sled": SLED,
    "masses that couple": COUPLED,
    **{f"{count} beads": beads(count) for count in (2, 3, 4, 6, 8)},
}


def motion(text: str, method: str, outputs: frozenset[str] = frozenset({"q", "v"})) -> Motion:
    """The motion of a system to t = 3."""
    spec, asked = read_spec(text, "system.yaml"), Compilation(method, METHODS[method], outputs)
    return run(prepare_system(spec, derive_system, None, asked), resolve_values(spec, {}), 0.0, 3.0, 31)


def near_limit(text: str, *methods: str) -> None:
    """Motions are that under tanh(u/w) in place of sign(u), where w is small."""
    expected = motion(re.sub(r"sign\(([^()]*)\)", r"tanh((\1)/1e-5)", text), "Radau")
    assert expected.outcome.ending is Ending.COMPLETE
    for method in methods:
        found = motion(text, method)
        assert found.outcome.ending is Ending.COMPLETE, (method, found.outcome.message)
        assert found.outcome.steps < 200 or method == "Radau"
        for path in (one for one in expected.data if one.startswith("q/")):
            assert np.max(np.abs(found[path] - expected[path])) <= 1e-3, (method, path)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", SYSTEMS)
def test_friction_is_the_limit_of_smooth_forces(case: str, method: str) -> None:
    near_limit(SYSTEMS[case], method)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("_", range(10))
def test_random_limits_and_forces(_: int) -> None:
    seed = random.randrange(10**6)
    print(f"{seed = }")
    source = random.Random(seed)
    case = source.choice([*SYSTEMS])
    changed = partial(re.sub, r"\b([FGTkV]): ([0-9.]+)", lambda found: (
        f"{found[1]}: {float(found[2]) * source.uniform(0.3, 3.0):.3f}"
    ))  # fmt: skip
    near_limit(changed(SYSTEMS[case]), "taylor", "DOP853")


def test_a_wire_at_its_limit_where_the_motion_begins() -> None:
    """F + G is exactly the pull of 2, and what follows leads back: the bead rests. It must not seem to be
    held by forces of which none holds."""
    found = motion(WIRE.replace("F: 0.5, G: 0.6", "F: 1.097, G: 0.903"), "taylor")
    assert np.all(found["q/x"][found["t"] <= 1.5] == 0.0)
    assert found["q/x"][-1] == pytest.approx(-1.0497, abs=1e-3)


def test_modes_of_what_rides_are_known_to_both() -> None:
    assert (guards.RIDES, guards.RIDDEN) == (modes.RIDES, modes.RIDDEN)


@pytest.mark.parametrize("case", ["a pendulum", "3 beads"])
def test_multipliers_where_friction_holds(case: str) -> None:
    """They are those under smooth friction, or nan where several forces hold what one would."""
    smooth, outputs = re.sub(r"sign\((\w+)\)", r"tanh(\1/1e-5)", SYSTEMS[case]), frozenset({"multipliers"})
    found, expected = motion(SYSTEMS[case], "taylor", outputs), motion(smooth, "Radau", outputs)
    for path in (one for one in found.data if one.startswith("multipliers/")):
        known = np.isfinite(found[path])
        assert np.count_nonzero(known) >= 20
        assert np.allclose(found[path][known], expected[path][known], rtol=0.0, atol=1e-2), path


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("case", ["a pendulum", "a sled", "masses that couple", "3 beads"])
def test_double_double(case: str) -> None:
    spec, tolerance = read_spec(SYSTEMS[case], "system.yaml"), FULL_DOUBLE_DOUBLE
    asked = Compilation("taylor", tolerance, frozenset({"q", "v"}), precision=DOUBLE_DOUBLE)
    ready = prepare_system(spec, partial(derive_system, resting=True, exact=True), None, asked)
    found, expected = (
        run(ready, resolve_long_values(spec, {}), 0.0, 3.0, 31),
        motion(SYSTEMS[case], "taylor"),
    )
    assert found.outcome.ending is Ending.COMPLETE
    for path in (one for one in expected.data if one.startswith("q/")):
        assert np.allclose(found[path], expected[path], rtol=0.0, atol=1e-13), path

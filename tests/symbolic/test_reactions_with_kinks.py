"""Forces of constraint where friction, walls and switches act: what is applied is no part of them."""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np
import pytest
import sympy

from lagrange_cli.run.equations import Derived, as_written, derive, of_form
from tests.support.motion import follow, spec_of

PARAMETERS = "parameters: {m: 1, g: 9.81, k: 2, l: 0.5, mu: 0.3, alpha: 0.4}\nmasses: {block: m}\n"
IN_THE_PLANE = """
coordinates: {x: {initial: 1.1}, y: {initial: 0}}
positions: {block: [x, y]}
"""
PLACES = {
    "free": IN_THE_PLANE,
    "turned": """
coordinates: {s: {initial: 1.1}, n: {initial: 0.7}}
positions: {block: [s*cos(alpha) + n*sin(alpha), n*cos(alpha) - s*sin(alpha)]}
""",
    "incline": """
coordinates: {s: {initial: 1.1}}
positions: {block: [s*cos(alpha), -s*sin(alpha)]}
""",
    "floor": IN_THE_PLANE + "constraints: {surface: y}\n",
    "plane": IN_THE_PLANE.replace("1.1", "0") + "constraints: {surface: x*sin(alpha) + y*cos(alpha)}\n",
}
SPEEDS = {
    "free": ["x_dot", "block.vy"],
    "turned": ["s_dot", "n_dot", "block.vx"],
    "incline": ["s_dot", "block.vx"],
    "floor": ["x_dot"],
    "plane": ["(x_dot*cos(alpha) - y_dot*sin(alpha))"],
}
ALONG = {
    "free": ("{}", "{}"),
    "floor": ("{}", "0"),
    "turned": ("{}*cos(alpha)", "-{}*sin(alpha)"),
    "incline": ("{}*cos(alpha)", "-{}*sin(alpha)"),
    "plane": ("{}*cos(alpha)", "-{}*sin(alpha)"),
}
LENGTHS = ["{0}", "({0} - 2)", "(2*{0} - 3)", "(l - {0})", "(l - 0.3*{0})", "(-{0})", "({0}/2 + 1/3)"]
WALLS = [
    "abs({0})**3", "max(0, {0})**2/2", "min({0}, 0)**2", "max(0, {0})**(5/2)", "abs({0})", "max({0}, l)",
    "min({0}, l, 1)**2", "where({0} > 0, k*{0}**2/2, 0)", "where({0} < 0, {0}, 3*{0})", "{0}*abs({0})",
    "sqrt({0}**2)", "abs({0})**2.5", "max(abs({0}), l)", "k*(norm(({0}, 0)) - l)**2",
]  # fmt: skip
RATES = ["{0}", "({0} - l)", "(2*{0} + l*k)", "(-{0})", "({0} - 0.7*l)"]
FRICTION = [
    "mu*m*g*sign({0})", "mu*abs({0})*{0}", "mu*where({0} > 0, 2, -2)", "mu*where({0} > 0, 2, -1)",
    "mu*where({0} >= 0, k, -l)", "mu*min(l, abs({0}))*sign({0})", "max(-l, min(l, {0}))",
    "mu*{0}**2*sign({0})",
    "mu*{0}/abs({0})", "where(t > 1, {1}, -{1})", "where(1 < t < 2, mu*{1}, k)", "mu*{0}*max(0, {1})",
    "mu*abs({1})*sign({0})", "where({1} < l, 1, 0)",
]  # fmt: skip
WITH_PRESSURE = ["mu*surface.multiplier*sign({0})", "mu*abs(surface.multiplier)*sign({0})"]


def system_of(place: str, seed: int) -> str:
    """A block with random walls and springs in both directions, and random friction along its way."""
    source = Random(f"{place} {seed}")
    walls = [
        source.choice(WALLS).format(source.choice(LENGTHS).format(source.choice(["block.x", "block.y"])))
        for _ in range(source.choice([1, 2]))
    ]
    laws = FRICTION + 4 * WITH_PRESSURE if "surface" in PLACES[place] else FRICTION
    rate = source.choice(RATES).format(source.choice(SPEEDS[place]))
    force = source.choice(laws).format(rate, source.choice(["block.x", "block.y"]))
    forces = ", ".join(f'"{one.format(f"(-({force}))")}"' for one in ALONG[place])
    potential = " + ".join(["m*g*block.y", *(f"k*{wall}" for wall in walls)])
    return f'{PARAMETERS}{PLACES[place]}potential: "{potential}"\nforces: {{block: [{forces}]}}\n'


def reactions_of(derived: Derived) -> tuple[sympy.Expr, ...]:
    """The components of the force on the block."""
    with derived.bounded():
        return of_form(derived, "reactions").reactions[0].components


@pytest.mark.exhaustive(keep=0.8)
@pytest.mark.parametrize("seed", range(15))
@pytest.mark.parametrize("place", PLACES)
def test_only_what_is_across_the_way_is_a_reaction(place: str, seed: int) -> None:
    components = reactions_of(derive(spec_of(system_of(place, seed))))
    cos, sin = sympy.cos(sympy.Symbol("alpha")), sympy.sin(sympy.Symbol("alpha"))
    if place in ("free", "turned"):
        assert components == (0, 0)
    elif place == "floor":
        assert components[0] == 0
    else:
        assert sympy.simplify(components[0] * cos - components[1] * sin) == 0


INCLINE = PARAMETERS + PLACES["incline"] + "potential: m*g*block.y\n"
ON_A_PLANE = PARAMETERS + PLACES["plane"] + "potential: m*g*block.y\n"
SPRING = PARAMETERS + "coordinates: {x: {initial: 1}}\npositions: {block: [x, 0]}\n"
BEAD = """
parameters: {m: 1, g: 9.81, R: 0.5, mu: 0.3}
coordinates: {x: {initial: R}, y: {initial: 0}}
masses: {bead: m}
positions: {bead: [x, y]}
potential: m*g*bead.y
constraints: {wire: FORM}
forces: {bead: ["FRICTION*x_dot/norm((x_dot, y_dot))", "FRICTION*y_dot/norm((x_dot, y_dot))"]}
"""


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    ("text", "lines"),
    [
        (
            INCLINE + "forces: {block: ['-N*cos(alpha)', 'N*sin(alpha)']}\n"
            "definitions: {N: mu*m*g*cos(alpha)*sign(s_dot)}\n",
            ["R_block_y = m*g*cos(alpha)**2", "abs(R_block) = abs(m*g*cos(alpha))"],
        ),
        (
            ON_A_PLANE + "forces: {block: ['-F*cos(alpha)', 'F*sin(alpha)']}\n"
            "definitions: {F: mu*surface.multiplier*sign(x_dot)}\n",
            ["R_block_y = m*g*cos(alpha)**2", "abs(R_block) = abs(m*g*cos(alpha))"],
        ),
        (
            SPRING + "potential: m*g*block.y + k*block.x**2/2\n"
            "forces: {block: [-mu*m*g*sign(x_dot), 0]}\n",
            ["R_block_x = 0", "R_block_y = m*g\n"],
        ),
        (
            BEAD.replace("FORM", "norm(bead) - R").replace("FRICTION", "-mu*abs(wire.multiplier)"),
            ["R_bead_x = lambda_wire*x/sqrt(x**2 + y**2)", "abs(R_bead) = abs(lambda_wire)"],
        ),
    ],
    ids=["incline", "plane", "spring", "wire"],
)  # fmt: skip
def test_friction_reads_as_in_a_textbook(text: str, lines: list[str]) -> None:
    found = as_written(derive(spec_of(text)), "text", "reactions", {})
    assert all(line in found for line in lines), found


@pytest.mark.parametrize("law", ["mu*m*g*cos(alpha)*sign(s_dot)", "3*mu*m*g*cos(alpha)*sign(s_dot)"])
def test_what_friction_holds_presses_on_the_incline_as_before(law: str) -> None:
    """It slides with the lesser friction, and sticks with the other one."""
    text = INCLINE + "forces: {block: ['-N*cos(alpha)', 'N*sin(alpha)']}\n" + f"definitions: {{N: {law}}}\n"
    motion = follow(text, 1.0, 5, outputs=("q", "v", "reactions"))
    m, g, alpha = (motion.values.parameters[name] for name in ("m", "g", "alpha"))
    normal = [float(m * g * sympy.cos(alpha) * one) for one in (sympy.sin(alpha), sympy.cos(alpha))]
    assert abs(motion["reactions/block"] - normal).max() < 1e-14 * m * g
    assert (motion["v/s"][-1] == 0) == law.startswith("3")


def test_a_velocity_in_a_quotient_is_not_taken_for_zero() -> None:
    text = SPRING + "potential: k*block.x**2/2\nforces: {block: ['-mu*block.vx/abs(block.vx)', 0]}\n"
    assert "m*x_ddot" in as_written(derive(spec_of(text)), "text", "lagrange", {})


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("seed", range(100, 110))
@pytest.mark.parametrize("place", ["turned", "incline", "floor", "plane"])
def test_printed_forces_are_those_along_the_motion(place: str, seed: int) -> None:
    text = system_of(place, seed).replace("1.1}", "1.1, velocity: 0.3}").replace("abs(surface", "(surface")
    module: dict[str, Any] = {}
    exec(as_written(derive(spec_of(text)), "python", "reactions", {}), module)
    motion = follow(text, 0.3, 4, outputs=("q", "v", "reactions"))
    for i, t in enumerate(motion["t"]):
        q, v = ([motion[f"{kind}/{name}"][i] for name in module["COORDINATES"]] for kind in "qv")
        # where friction may hold the block, the printed force is that of one side
        if min(map(abs, v)) < 1e-3 and place != "floor":
            continue
        (found,) = module["reactions"](t, q, v, dict(motion.values.parameters))
        expected = motion["reactions/block"][i]
        assert np.abs(np.array(found) - expected).max() < 1e-10 * (1 + np.abs(expected).max())

"""Forces of constraint on particles, as printed."""

from __future__ import annotations

import json

import numpy as np
import pytest

from lagrange_cli.errors import UsageError
from lagrange_cli.run.equations import as_data, as_written, derive
from lagrange_cli.run.reactions import with_reactions
from tests.support.motion import follow, spec_of
from tests.support.systems import spec_of as shipped
from tests.symbolic.test_constraints import CHAIN, DRIVEN, KNIFE, PENDULUM


def written(spec, format_="text"):
    return as_written(derive(spec), format_, "reactions", {})


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    ("name", "lines"),
    [
        (
            "pendulum",
            (
                "R_bob_x = -sin(theta)*(m*l*theta_dot**2 + m*g*cos(theta))",
                "R_bob_y = cos(theta)*(m*l*theta_dot**2 + m*g*cos(theta))",
                "abs(R_bob) = abs(m*l*theta_dot**2 + m*g*cos(theta))",
            ),
        ),
        ("incline", ("abs(R_block) = abs(m*g*cos(alpha))", "R_block_y = m*g*cos(alpha)**2")),
        ("atwood", ("R_left_y = 2*m1*m2*g/(m1 + m2)", "R_right_y = 2*m1*m2*g/(m1 + m2)")),
        ("parabola_bead", ("R_bead_y = m*(2*k*x_dot**2 + g)/(1 + 4*k**2*x**2)",)),
        ("spherical_pendulum", ("= abs(m*l*theta_dot**2 + m*l*sin(theta)**2*phi_dot**2 + m*g*cos(theta))",)),
        ("free_particles", (" = 0\n",)),
    ],
)
def test_textbook_results(name, lines):
    text = written(shipped(name))
    assert all(line in text for line in lines), text


@pytest.mark.exhaustive(keep=0.6)
def test_a_force_that_vanishes_has_no_size():
    assert "abs(" not in written(shipped("free_particles"))


@pytest.mark.exhaustive(keep=0.45)
def test_with_constraints_the_multipliers_are_beside_them():
    text = written(spec_of(PENDULUM))
    assert "R_bob_x = m*x*(-x_dot**2 - y_dot**2 + g*y)/(x**2 + y**2)" in text
    assert "lambda_rod = m*(-x_dot**2 - y_dot**2 + g*y)/(2*(x**2 + y**2))" in text
    assert r"R_{\mathrm{bob},y} &=" in written(spec_of(PENDULUM), "latex")
    long = "R_p_x[1] = 2*lambda_link[2]*(x[1] - x[2]) - 2*lambda_link[1]*(x[0] - x[1])"
    assert long in written(spec_of(CHAIN))


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("text", [DRIVEN, CHAIN, shipped("double_pendulum").text])
def test_printed_and_computed_forces_are_the_same(text):
    module: dict = {}
    exec(as_written(derive(spec_of(text)), "python", "reactions", {}), module)
    motion = follow(text, 1.0, 4, outputs=("q", "v", "reactions"))
    known = dict(motion.values.parameters)
    names = [name.replace("[", "|") for name in module["COORDINATES"]]
    paths = [name.replace("|", "[") for name in names]
    for i, t in enumerate(motion["t"]):
        q, v = ([motion[f"{kind}/{path}"][i] for path in paths] for kind in "qv")
        found = module["reactions"](t, q, v, known)
        for particle, force in zip(module["PARTICLES"], found, strict=True):
            base, bracket, index = particle.partition("[")
            series = motion[f"reactions/{base}"]
            expected = series[i, int(index[:-1])] if bracket else series[i]
            assert np.abs(np.array(force) - expected).max() < 1e-11 * (1 + np.abs(expected).max())


def test_data():
    data = json.loads(json.dumps(as_data(derive(shipped("pendulum")), "reactions", {})))
    assert data["reactions"]["bob"][0] == "-sin(theta)*(m*l*theta_dot**2 + m*g*cos(theta))"
    assert data["reaction_sizes"] == {"bob": "m*l*theta_dot**2 + m*g*cos(theta)"}


@pytest.mark.exhaustive(keep=0.8)
def test_what_is_not_known_is_said():
    with pytest.raises(UsageError, match="no --form reactions: the file gives L"):
        written(spec_of(KNIFE))
    angle = shipped("pendulum").text.replace("bob.y", "(-l*cos(theta))")
    with pytest.raises(UsageError, match="the force on 'bob' is not known, since U contains the coordinate"):
        written(spec_of(angle))


def test_some_are_known_and_others_not():
    spec = spec_of("""
        parameters: {l: 2}
        coordinates: {theta: {initial: 0}, x: {initial: 0}}
        masses: {bob: 1, cart: 1}
        embedding: {bob: [l*sin(theta), -l*cos(theta)], cart: [x, 0]}
        potential: cos(theta)
        """)
    found = with_reactions(spec, derive(spec).equations)
    assert [each.particle for each in found.reactions] == ["cart"] and set(found.unknown_reactions) == {"bob"}
    assert "Not known\n  the force on 'bob' is not known" in written(spec)

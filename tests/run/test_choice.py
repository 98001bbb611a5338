"""``--method auto``: what is chosen depends on the system, the outputs and the tolerance alone."""

from __future__ import annotations

import re

import numpy as np
import pytest

import lagrange_cli
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.run.settings.settings import resolve_settings
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import SolveDefaults
from tests.support.command import SYSTEMS, lagrange
from tests.test_imports import modules_imported_by

BODIES = """
name: cluster
sizes: {{N: {count}}}
parameters: {{eps: 0.1}}
coordinates:
  x[i in range(N)]: {{initial: cos(2.4*i)*sqrt(i)}}
  y[i in range(N)]: {{initial: sin(2.4*i)*sqrt(i)}}
  z[i in range(N)]: {{initial: 0.1*sin(3*i)}}
masses: {{body[i in range(N)]: 1/N}}
embedding: {{body[i in range(N)]: [x[i], y[i], z[i]]}}
potential: {potential}
solve: {{stop: 0.05, samples: 3}}
"""
ALL_PAIRS = "-sum(1/N**2/sqrt({r2} + eps**2) for i in range(N) for j in range(i))".format(
    r2="dot(body[i] - body[j], body[i] - body[j])"
)
NEIGHBOURS = "sum((x[i] - x[i - 1])**2/2 for i in range(1, N))"
STEEP = "sum(({r2})**-6 for i in range(N) for j in range(i))".format(
    r2="dot(body[i] - body[j], body[i] - body[j])"
)
NARROW = ALL_PAIRS.replace("-sum(", "sum(exp(-1000*x[i]**2)*")
SHELL = ALL_PAIRS.replace("-sum(", "sum(exp(-1000*(x[i]**2 + y[i]**2 - 1)**2)*")
DISTANCE = "norm(body[i] - body[j])"
YUKAWA = f"sum(exp(-3*{DISTANCE})/{DISTANCE} for i in range(N) for j in range(i))"
QUARTIC = STEEP.replace("**-6", "**2")
MORSE = f"sum((1 - exp(-({DISTANCE} - 2)/eps))**2 for i in range(N) for j in range(i))"
BROKEN = f"sum({DISTANCE}**2.5 for i in range(N) for j in range(i))"
CORES = "sum(exp(-dot(body[i] - body[j], body[i] - body[j])/eps**2) for i in range(N) for j in range(i))"


POLAR = """
sizes: {{N: {count}}}
coordinates:
  r[i in range(N)]: {{initial: 1 + 0.05*i}}
  phi[i in range(N)]: {{initial: 2.4*i, velocity: (1 + 0.05*i)**-1.5}}
masses: {{body[i in range(N)]: 0.001}}
embedding: {{body[i in range(N)]: ["r[i]*cos(phi[i])", "r[i]*sin(phi[i])"]}}
potential: >
  -sum(0.001/r[i] for i in range(N)) - sum(1e-6/norm(body[i] - body[j]) for i in range(N) for j in range(i))
solve: {{stop: 0.5, samples: 3}}
"""
BEADS_ON_WIRES = """
sizes: {{N: 10}}
coordinates:
  "x[i in range(N)]": {{initial: 0.1*cos(i)}}
  "y[i in range(N)]": {{}}
masses: {{"bead[i in range(N)]": 1}}
positions: {{"bead[i in range(N)]": [x[i], {place}]}}
potential: sum(9.8*bead[i].y for i in range(N))
solve: {{stop: 1}}
{more}
"""


@pytest.mark.exhaustive(keep=6)
@pytest.mark.parametrize(
    ("count", "potential", "options", "expected"),
    [
        (40, ALL_PAIRS, {}, "ias15"),
        (40, ALL_PAIRS, {"outputs": ("q", "ledger")}, "taylor"),
        (40, ALL_PAIRS, {"method": "taylor"}, "taylor"),
        (40, ALL_PAIRS, {"method": "AUTO"}, "ias15"),
        (40, ALL_PAIRS, {"stop": -1.0}, "taylor"),
        (40, NEIGHBOURS, {}, "taylor"),
        (40, NARROW, {}, "ias15"),
        (40, SHELL, {}, "taylor"),
        (40, YUKAWA, {}, "ias15"),
        (40, CORES, {}, "ias15"),
        (34, QUARTIC, {}, "ias15"),
        (34, QUARTIC, {"tolerance": 1e-6}, "taylor"),
        (4, BROKEN, {}, "ias15"),
        (40, MORSE, {}, "ias15"),
        (40, MORSE.replace("- 2)/eps", "- 2/eps)/3"), {}, "ias15"),
        (3, CORES, {}, "taylor"),
        (4, ALL_PAIRS.replace("eps**2", "0"), {}, "taylor"),
        (40, YUKAWA, {"tolerance": 1e-4}, "ias15"),
        (40, YUKAWA, {"tolerance": 1e-16}, "taylor"),
        (40, STEEP, {}, "ias15"),
        (40, f"abs(x[0]) + {ALL_PAIRS}", {}, "taylor"),
        (8, ALL_PAIRS, {}, "taylor"),
    ],
)
def test_the_method(count: int, potential: str, options: dict[str, object], expected: str) -> None:
    spec = read_spec(BODIES.format(count=count, potential=potential), "cluster.yaml")
    settings = resolve_settings(spec, SolveDefaults(**options))
    assert settings.method == expected
    if expected == "ias15":
        assert settings.chosen_because


@pytest.mark.exhaustive(keep=0.8)
def test_the_summary_says_why(tmp_path) -> None:
    (tmp_path / "cluster.yaml").write_text(BODIES.format(count=40, potential=ALL_PAIRS))
    told = lagrange("solve", "cluster.yaml", cwd=tmp_path)
    assert told.returncode == 0
    said = re.search(r"method ias15, as a Taylor step takes as long as (\d+) evaluations", told.stdout)
    assert said and int(said[1]) > 61


OSCILLATORS = """
name: oscillators
sizes: {N: 60}
coordinates: {"u[i in range(N)]": {initial: 3*sin(13*i)}}
masses: {"o[i in range(N)]": 1}
embedding: {"o[i in range(N)]": "u[i]"}
potential: "-sum(cos(u[i] - u[j])/N for i in range(N) for j in range(i))"
solve: {stop: 0.05, samples: 3}
"""


@pytest.mark.exhaustive(keep=0.65)
def test_series_of_few_convolutions_are_chosen_where_terms_are_many(tmp_path) -> None:
    """A sine takes two convolutions an order, and in an evaluation as long as a root and many products."""
    (tmp_path / "oscillators.yaml").write_text(OSCILLATORS)
    told = lagrange("solve", "oscillators.yaml", cwd=tmp_path)
    said = re.search(r"method taylor, as a Taylor step takes as long as (\d+) .* replaces (\d+)", told.stdout)
    assert said and int(said[1]) <= int(said[2])


GRAINS = """
name: grains
sizes: {N: 60}
parameters: {c: 0.1}
coordinates: {"x[i in range(N)]": {initial: i}, "y[i in range(N)]": {initial: 0}}
masses: {"grain[i in range(N)]": 1 + i/10}
embedding: {"grain[i in range(N)]": ["x[i]", "y[i]"]}
potential: sum((1 + i/10)*grain[i].y for i in range(N))
forces: {"grain[i in range(N)]": "-c*norm((x_dot[i], y_dot[i]))*(x_dot[i], y_dot[i])"}
solve: {stop: 2, samples: 3}
"""


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("", ""),
        ("norm((x_dot[i], y_dot[i]))", "sqrt(grain[i].vx**2 + grain[i].vy**2)"),
        ("norm((x_dot[i], y_dot[i]))", "dot((x_dot[i], y_dot[i]), (x_dot[i], y_dot[i]))**0.5"),
    ],
)
def test_grains_fall_from_rest_with_drag(old: str, new: str) -> None:
    """v = -u tanh(t/tau) with u^2 = m g/c, where Taylor series in loops have no series at the start."""
    motion = lagrange_cli.solve(GRAINS.replace(old, new) if old else GRAINS)
    assert motion.attributes["method"] == "ias15"
    i = np.arange(60)
    mass = 1 + i / 10
    u = np.sqrt(mass / 0.1)
    assert motion.v["y"][-1] == pytest.approx(-u * np.tanh(2 / u), rel=1e-13)
    assert motion.q["y"][-1] == pytest.approx(-u * u * np.log(np.cosh(2 / u)), rel=1e-13)


CHAIN = """
name: chain
sizes: {N: 12}
coordinates: {"a[i in range(N)]": {initial: 0.5}}
masses: {"bob[i in range(N)]": 1}
embedding:
  bob[i in range(N)]: ["sum(sin(a[j]) for j in range(i + 1))", "-sum(cos(a[j]) for j in range(i + 1))"]
potential: "sum(9.81*bob[i].y for i in range(N))"
forces: {"bob[i in range(N)]": "-0.1*norm((bob[i].vx, bob[i].vy))*(bob[i].vx, bob[i].vy)"}
solve: {stop: 0.5, samples: 3}
"""
BOUNCING = GRAINS.replace("for i in range(N))", "+ 1e4*max(0, -grain[i].y - 1)**2.5 for i in range(N))")


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("text", [CHAIN, BOUNCING])
def test_chains_and_bouncing_grains_pass_with_drag(text: str) -> None:
    found, expected = (lagrange_cli.solve(text, method=one, tolerance=1e-9) for one in ("auto", "Radau"))
    assert (found.attributes["method"], found.status) == ("DOP853", "complete")
    name = next(iter(found.q))
    assert found.q[name] == pytest.approx(expected.q[name], abs=1e-6)


def test_damping_and_small_systems_keep_series() -> None:
    for text in (GRAINS.replace("norm((x_dot[i], y_dot[i]))", "2"), GRAINS.replace("N: 60", "N: 3")):
        settings = resolve_settings(read_spec(text, "grains.yaml"), SolveDefaults(), cached=False)
        assert settings.method == "taylor"


@pytest.mark.exhaustive(keep=0.25)
def test_the_choice_is_kept(tmp_path) -> None:
    """A command whose program is in the cache does not derive anything to choose its method."""
    (tmp_path / "grains.yaml").write_text(GRAINS)
    command = ["solve", "grains.yaml", "--force"]
    modules_imported_by(command, tmp_path)
    modules = modules_imported_by(command, tmp_path)
    assert not modules & {"lagrange_cli.expression.graph", "lagrange_cli.families.system"}


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("count", [300, 1000])
def test_many_bodies_are_followed(count: int, tmp_path) -> None:
    (tmp_path / "cluster.yaml").write_text(BODIES.format(count=count, potential=ALL_PAIRS))
    told = lagrange("solve", "cluster.yaml", "--quiet", cwd=tmp_path)
    assert (told.returncode, told.stderr) == (0, "")


def test_motions_of_a_sweep_do_not_go_side_by_side_where_forces_would_hide() -> None:
    """Side by side members are written out, where steps of ias15 are not bounded by tails of forces."""
    spec = read_spec(BODIES.format(count=4, potential=YUKAWA), "cluster.yaml")
    outputs = frozenset({"q"})
    for method, loops in (("ias15", True), ("taylor", False)):
        found = family_run(spec, Compilation(method, 2.0**-52, outputs, ensemble=True))
        assert (found is not None) == loops


def test_steps_that_cannot_be_proven_in_loops_are_those_of_ias15() -> None:
    """Written out, 60 bodies in polar coordinates would be refused, and 20 take ten times as long."""
    for count, expected in ((4, "taylor"), (60, "ias15")):
        spec = read_spec(POLAR.format(count=count), "polar.yaml")
        settings = resolve_settings(spec, SolveDefaults())
        assert settings.method == expected
        assert ("have to be proven" in settings.chosen_because) == (expected == "ias15")
    spec = read_spec(POLAR.format(count=60), "polar.yaml")
    assert family_run(spec, Compilation("ias15", 2.0**-52, frozenset({"q", "v"}))) is not None


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize(
    ("place", "more"),
    [
        ("y[i]", 'constraints: {"wire[i in range(N)]": "y[i] - asin(x[i]/2)"}'),
        ("y[i]", 'constraints: {"wire[i in range(N)]": "y[i] - cosh(x[i])"}'),
        ("cosh(x[i]) + y[i]", ""),
    ],
)
def test_places_and_constraints_of_many_members_need_proofs_too(place: str, more: str) -> None:
    """With Taylor series, 600 members on wires would be refused."""
    text = BEADS_ON_WIRES.format(place=place, more=more)
    for count, expected in ("10", "taylor"), ("600", "ias15"):
        spec = read_spec(text, "wires.yaml", {"N": count})
        settings = resolve_settings(spec, SolveDefaults())
        assert settings.method == expected
        assert ("have to be proven" in settings.chosen_because) == (expected == "ias15")


@pytest.mark.exhaustive(keep=0.35)
def test_distances_of_places_are_no_drag() -> None:
    """Springs between members of a chain: their lengths are not those of velocities."""
    text = (SYSTEMS / "n_pendulum.yaml").read_text(encoding="utf-8")
    springs = " + sum((norm(bob[i] - bob[i - 2]) - l)**2 for i in range(2, N))"
    text = text.replace("for i in range(N))\nsolve", f"for i in range(N)){springs}\nsolve")
    spec = read_spec(text, "chain.yaml", {"N": "30"})
    assert springs in text and resolve_settings(spec, SolveDefaults()).method == "taylor"

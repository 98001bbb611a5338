"""Chains and trees whose families stay families, beside the same systems written out member by member."""

from __future__ import annotations

import random
from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import j1

from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.family_program import compiled_accelerations
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.families import alike, followed
from tests.support.motion import run

OUTPUTS = frozenset(["q", "v", "p", "h", "energy", "positions", "observables"])
SIZES = 1, 2, 3, 8, 9, 17
DEAR = "cords", "pairs", "springs", "bent rods"
"""What takes long to derive member by member."""
SUPPORTS = {
    "none": ("0", "0"),
    "a cart": ("s", "0"),
    "driven": ("0.1*sin(3*t)", "0.05*cos(2*t)"),
    "both": ("s", "0.1*t**2"),
}
SHAPES = {
    "components": (
        '"x[0]": "{sx} + {x0}", "y[0]": "{sy} + {y0}"',
        '"x[i in range(1, N)]": "x[{up}] + {x}", "y[i in range(1, N)]": "y[{up}] + {y}"',
        '["x[i]", "y[i]"]',
    ),
    "vectors": (
        '"r0[i in range(N)]": ["{x}", "{y}"], "w[0]": "[{sx}, {sy}] + r0[0]"',
        '"w[i in range(1, N)]": "w[{up}] + r0[i]"',
        '"w[i]"',
    ),
    "sums": (
        '"x[i in range(N)]": "{sx} + sum({xj} for j in range(i + 1))", '
        '"y[i in range(N)]": "{sy} + sum({yj} for j in range(i + 1))"',
        "",
        '["x[i]", "y[i]"]',
    ),
    "sums of vectors": ("", "", '"[{sx}, {sy}] + sum([{xj}, {yj}] for j in range(i + 1))"'),
    "sums from the end": (
        '"x[i in range(N)]": "{sx} + sum({xj} for j in range(i, N))", '
        '"y[i in range(N)]": "{sy} - sum(-({yj}) for j in range(i, N))"',
        "",
        '["x[i]", "y[i]"]',
    ),
}
PARENTS = "i - 1", "(i - 1)//2", "(i - 1)//3", "i - 1 - (i + 1) % 2", "0"
STEPS = {
    "rods": ("l*sin(th[{i}])", "-l*cos(th[{i}])"),
    "rods of their own": ("(l + {i}/9)*sin(th[{i}])", "-(l + {i}/9)*cos(th[{i}])"),
    "springs": ("(l + r[{i}])*sin(th[{i}])", "-(l + r[{i}])*cos(th[{i}])"),
    "bent rods": ("l*sin(th[{i}]) + 0.2*cos(2*th[{i}])", "-l*cos(th[{i}]) + 0.1*th[{i}]"),
    "pulsing rods": ("(l + 0.1*sin(t))*sin(th[{i}])", "-(l + 0.1*sin(t))*cos(th[{i}])"),
}
POTENTIALS = {
    "weights": "sum(g*(1 + i/7)*bob[i].y for i in range(N))",
    "twists": "sum(k*(th[i] - th[i - 1])**2/2 for i in range(1, N))",
    "cords": "sum(k*(norm(bob[i] - bob[i - 1]) - 1.5*l)**2/2 for i in range(2, N))",
    "a field": "sum(k*sin(bob[i].x + {b}*t) for i in range(N))",
    "pairs": "-sum(k/sqrt(3 + (bob[i].x - bob[j].x)**2 + (bob[i].y - bob[j].y)**2)"
    " for i in range(N) for j in range(i))",
}
FORCES = {
    "none": "",
    "friction": 'generalized_forces: {{"th[i in range(N)]": "-0.1*th_dot[i]"}}',
    "drive": 'generalized_forces: {{"th[0]": "cos({b}*t)"}}',
    "wind": 'forces: {{"bob[i in range(N)]": ["0.3 - 0.1*bob[i].vx", "-0.1*bob[i].vy"]}}',
    "damping": (
        "dissipation: sum((th_dot[i] - th_dot[i - 1])**2/10 for i in range(1, N)) + bob[N - 1].vx**2/9"
    ),
}
SYSTEM = """
sizes: {{N: {count}}}
parameters: {{l: 1.0, g: 2.0, k: {k}}}
coordinates:
  th[i in range(N)]: {{initial: "0.5*sin({seed} + i)", velocity: "0.1*cos({seed}*i)"}}
  {coordinates}
definitions: {{{definitions}}}
masses: {{{masses}}}
embedding: {{{embedding}}}
potential: "{potential}"
{forces}
observables:
  lean[j in range(2)]: sum(th[i]*sin(pi*(i + 1)*(j + 1)/(N + 1)) for i in range(N))
  tip: bob[N - 1].vx
solve: {{stop: 0.5, step: 0.1}}
"""


def drawn(chance: random.Random, count: int = 0) -> str:
    """The text of a random system."""
    count = count or chance.choice(SIZES)
    known = [name for name in POTENTIALS if count <= 3 or name not in DEAR]
    steps = [name for name in STEPS if count <= 9 or name not in DEAR]
    shape, support = chance.choice([*SHAPES]), chance.choice([*SUPPORTS])
    step, up = chance.choice(steps), chance.choice(PARENTS)
    (sx, sy), (x, y) = SUPPORTS[support], STEPS[step]
    given = {
        "sx": sx, "sy": sy, "up": up, "x": x.format(i="i"), "y": y.format(i="i"), "x0": x.format(i="0"),
        "y0": y.format(i="0"), "xj": x.format(i="j"), "yj": y.format(i="j"),
    }  # fmt: skip
    first, more, place = (one.format(**given) for one in SHAPES[shape])
    definitions = ", ".join(one for one in (first, more if count > 1 else "") if one)
    at = place.strip('"') if place.startswith('"') else place.replace('"', "")
    coordinates, masses, potentials = [], ['"bob[i in range(N)]": "1 + i/7"'], []
    places = [f'"bob[i in range(N)]": {place}']
    if sx == "s":
        coordinates.append("s: {initial: 0.2}")
        masses.append("cart: 2.5")
        places.append('cart: ["s", "0.5"]')
        potentials.append("s**2")
    if "r[" in x:
        coordinates.append('"r[i in range(N)]": {initial: "0.1*cos(i)"}')
        potentials.append("sum(4*r[i]**2 for i in range(N))")
    if chance.random() < 0.3:  # a rod's middle, behind its parent or before its own end
        masses.append('"middle[i in range(N)]": 0.5')
        places.append(f'"middle[i in range(N)]": "{at} - [l/2*sin(th[i]), -l/2*cos(th[i])]"')
    if chance.random() < 0.3:  # pendulums that hang from every bob
        coordinates.append('"ps[i in range(N)]": {initial: "0.3*cos(i)"}')
        masses.append('"lamp[i in range(N)]": "0.3 + i/5"')
        places.append(f'"lamp[i in range(N)]": "{at} + [0.5*sin(ps[i]), -0.5*cos(ps[i])]"')
        potentials.append("sum(g*lamp[i].y for i in range(N))")
    if chance.random() < 0.2:  # others that hang nowhere, with two coordinates
        coordinates.append('"u[i in range(2)]": {initial: "0.4 + i"}')
        masses.append("free: 1.5")
        places.append('free: ["u[0]*cos(u[1])", "u[0]*sin(u[1])"]')
        potentials.append("(u[0] - bob[0].x)**2")
    potentials += [POTENTIALS[name] for name in chance.sample(known, chance.randint(1, 3))]
    given = {
        "count": count, "k": chance.choice([0.7, 1.5]), "seed": chance.randint(1, 9),
        "definitions": definitions, "coordinates": "\n  ".join(coordinates),
        "masses": ", ".join(masses), "embedding": ", ".join(places),
        "potential": " + ".join(potentials).format(b=chance.choice([0, 0, 1])),
        "forces": FORCES[chance.choice([*FORCES])].format(b=chance.choice([0.5, 2])),
    }  # fmt: skip
    return SYSTEM.format(**given)


def fewest(monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    """Systems from this size on stay families."""
    monkeypatch.setattr(systems, "FEWEST", count)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", count)


@pytest.mark.exhaustive(keep=0.2, most=12)
@pytest.mark.parametrize("case", range(60))
def test_chains_move_as_their_members_do(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} {case}")
    text, method = drawn(chance), chance.choice(["taylor", "ias15"])
    outputs = chance.choice([OUTPUTS, frozenset("qv")])
    fewest(monkeypatch, 0)
    assert systems.family_system(read_spec(text, "system.yaml")) is not None, text
    together, found = followed(text, outputs, method=method)
    fewest(monkeypatch, 10**9)
    apart, expected = followed(text, outputs, method=method)
    assert together.recording.datasets == apart.recording.datasets
    assert set(together.recording.conserved) <= set(apart.recording.conserved)
    alike(found.data, expected.data, 2.0**-40, text)


PENDULUM = """
sizes: {N: COUNT}
parameters: {l: 1.0, g: 9.81}
coordinates:
  th[i in range(N)]: {initial: "0.5 + 0.3*sin(i)"}
definitions:
  x[0]: l*sin(th[0])
  y[0]: -l*cos(th[0])
  x[i in range(1, N)]: x[PARENT] + l*sin(th[i])
  y[i in range(1, N)]: y[PARENT] - l*cos(th[i])
masses: {"bob[i in range(N)]": "1 + i/N"}
embedding: {"bob[i in range(N)]": ["x[i]", "y[i]"]}
potential: "sum(g*(1 + i/N)*y[i] for i in range(N))"
solve: {stop: 0.5, step: 0.1}
"""


def pendulum(count: int, parent: str = "i - 1") -> str:
    """A chain or a tree of rods."""
    return PENDULUM.replace("COUNT", str(count)).replace("PARENT", parent)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("parent", ["i - 1", "i//2", "(i - 1)//5*5"])
def test_a_thousand_rods_keep_their_energy(parent: str) -> None:
    _, found = followed(pendulum(1000, parent), OUTPUTS)
    h = found["diagnostics/h"]
    assert np.max(np.abs(h / h[0] - 1)) < 2.0**-45
    assert np.max(np.abs(found["q/th"][-1] - found["q/th"][0])) > 0.01


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("parent", ["i - 1", "(i - 1)//2"])
def test_the_code_of_a_chain_does_not_grow_with_it(parent: str) -> None:
    def counted(count: int) -> tuple[int, int]:
        spec = read_spec(pendulum(count, parent), "system.yaml")
        system = systems.family_system(spec)
        assert system is not None and system.joints is not None
        ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, OUTPUTS))
        return len(system.slots.graph.nodes), len(ready.machine.program.text.splitlines())

    assert counted(72) == counted(200)


@pytest.mark.exhaustive(keep=0.55)
def test_a_step_of_a_chain_takes_work_in_proportion_to_it() -> None:
    def operations(count: int) -> int:
        spec = read_spec(pendulum(count), "system.yaml")
        program = prepare_system(
            spec, derive_system, None, Compilation("taylor", 2.0**-52, OUTPUTS)
        ).machine.program
        return int(program.work)

    few, many = operations(104), operations(1000)
    assert many / few < 1.05 * 1000 / 104


def test_hanging_rods_swing_as_a_hanging_rope() -> None:
    """Small swings of N rods, N large: those of a rope, J0(2 w sqrt(L/g)) = 0 (D. Bernoulli 1732)."""
    text = pendulum(400).replace("l: 1.0", "l: 1/N").replace("1 + i/N", "where(i == N - 1, 1/2, 1)/N")
    spec = read_spec(text, "system.yaml")
    system = systems.family_system(spec)
    assert system is not None
    accelerations = compiled_accelerations(system)
    values = resolve_values(spec, {})
    parameters = np.array([values.parameters[one.name] for one in spec.parameters])
    count, small = 400, 1e-6
    depth = (np.arange(count) + 0.5) / count
    root, g = 2.404825557695773, 9.81
    shape = j1(root * np.sqrt(1 - depth)) / np.sqrt(1 - depth)
    rates = accelerations(0.0, small * shape, np.zeros(count), parameters)
    w2 = g * root**2 / 4
    assert np.max(np.abs(rates + w2 * small * shape)[:-1]) < 1e-4 * w2 * small * np.max(shape)


SPACE = """
sizes: {N: 9}
parameters: {g: 2.0, "l[i in range(N)]": 1 - i/20}
coordinates:
  a[i in range(N)]: {initial: "1.1 + 0.1*cos(i)", velocity: 0.2}
  b[i in range(N)]: {initial: "0.1*i", velocity: 0.1}
definitions:
  step[i in range(N)]: "[l[i]*sin(a[i])*cos(b[i]), l[i]*sin(a[i])*sin(b[i]), -l[i]*cos(a[i])]"
  w[0]: step[0]
  w[i in range(1, N)]: w[(i - 1)//2] + step[i]
masses: {"bob[i in range(N)]": "1 + i/5"}
embedding: {"bob[i in range(N)]": "w[i]"}
potential: sum(g*bob[i].z for i in range(N)) + sum((bob[i].x - bob[i - 1].y)**2/5 for i in range(1, N))
observables: {tip: "bob[N - 1].vx"}
"""


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_a_tree_in_space_moves_as_its_members_do(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    fewest(monkeypatch, 0)
    together, found = followed(SPACE, OUTPUTS, method=method)
    fewest(monkeypatch, 10**9)
    apart, expected = followed(SPACE, OUTPUTS, method=method)
    assert len(together.machine.program.text) < len(apart.machine.program.text)
    alike(found.data, expected.data, 2.0**-44)


@pytest.mark.exhaustive(keep=0.7)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_what_rests_beside_what_moves_does_not_shorten_steps(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A planar motion in space: the rates of the other angle are rounding errors where joints are mixed."""
    fewest(monkeypatch, 0)
    text = (
        SPACE.replace("0.1*i, velocity: 0.1", "0.3")
        .replace('"0.1*i"', "0.3")
        .replace(", velocity: 0.1}", "}")
    )
    spec = read_spec(text.partition(" + sum((bob")[0] + "\n", "system.yaml")
    ready = prepare_system(spec, derive_system, None, Compilation(method, 2.0**-52, frozenset(["q"])))
    assert ready.machine.program.loops
    motion = run(ready, resolve_values(spec, {}), 0.0, 0.5, 6)
    assert np.max(np.abs(motion.data["q/b"] - 0.3)) < 1e-13
    assert motion.outcome.steps < 100


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("parent", ["i - 1", "(i - 1)//2"])
def test_chains_without_weight_keep_their_angular_momentum(
    parent: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What all angles alike conserve is L_z of all particles."""
    heavy = pendulum(5, parent).replace("0.3*sin(i)", '0.3*sin(i)", velocity: "0.2*i')
    outputs = frozenset(["conserved"])

    def conserved(text: str, count: int) -> Mapping[str, NDArray[np.float64]]:
        fewest(monkeypatch, count)
        spec = read_spec(text, "system.yaml")
        ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, outputs))
        return run(ready, resolve_values(spec, {}), 0.0, 0.5, 6).data

    light = heavy.replace('potential: "sum(g*(1 + i/N)*y[i] for i in range(N))"', 'potential: "0"')
    together, apart = conserved(light, 0), conserved(light, 10**9)
    total = together["diagnostics/conserved/L_z"]
    assert not any("P_th" in name for name in together)
    assert np.max(np.abs(total / apart["diagnostics/conserved/L_z"] - 1)) < 1e-12
    assert not any("L_z" in name or "P_th" in name for name in conserved(heavy, 0))

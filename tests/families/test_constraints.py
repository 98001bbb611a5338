"""Families with constraints that stay families, beside the same systems written out member by member."""

from __future__ import annotations

import random
from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.families import consistency
from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.family_program import compiled_accelerations
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.model.start import linear
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import Values
from tests.support.families import begun, followed
from tests.support.motion import run

OUTPUTS = frozenset(
    ["q", "v", "p", "h", "T", "U", "positions", "constraints", "multipliers", "reactions", "conserved"]
)
SIZES = 3, 4, 8, 9, 17
PLACES = """
  x[i in range(N)]: {{initial: "{x}", velocity: "{u}"}}
  y[i in range(N)]: {{initial: "{y}", velocity: "{w}"}}
"""
BEADS = '"bead[i in range(N)]": {mass}'
AT = '"bead[i in range(N)]": ["x[i]", "y[i]"]'
ROD = "(x[i] - x[{j}])**2 + (y[i] - y[{j}])**2 - l**2"
HELD = "rod[0]: x[0]**2 + y[0]**2 - l**2"
SHAPES: Mapping[str, tuple[Mapping[str, str], str]] = {
    "a ring": (
        {"x": "l/(2*sin(pi/N))*cos(2*pi*i/N)", "y": "l/(2*sin(pi/N))*sin(2*pi*i/N)"},
        "rod[i in range(N)]: " + ROD.format(j="(i + 1) % N"),
    ),
    "a chain": (
        {"x": "sum(l*sin(1 + j/9) for j in range(i + 1))", "y": "-sum(l*cos(1 + j/9) for j in range(i + 1))"},
        f"{HELD}\n  rod[i in range(1, N)]: " + ROD.format(j="i - 1"),
    ),
    "a tree": ({"x": "TREE", "y": "TREE"}, f"{HELD}\n  rod[i in range(1, N)]: " + ROD.format(j="(i - 1)//2")),
    "pairs": (
        {"x": "2*(i//2) + (i % 2)*l*0.6", "y": "(i % 2)*l*0.8 + cos(i//2)"},
        "rod[i in range(N//2)]: " + ROD.replace("[i]", "[2*i + 1]").format(j="2*i"),
    ),
    "a ladder": (
        {"x": "0.1*i", "y": "0.3*sin(i)"},
        "rung[i in range(N)]: (x[i] - a[i])**2 + (y[i] - b[i])**2 - l**2",
    ),
    "sloping rails": (
        {"x": "0.1*i", "y": "0.05*i*(1 + i/N)"},
        "rail[i in range(N)]: y[i] - x[i]*(1 + i/N)/2",
    ),
    "wires": ({"x": "0.3 + 0.1*i", "y": "sin(0.3 + 0.1*i)"}, "wire[i in range(N)]: y[i] - sin(x[i])"),
    "a mean": ({"x": "0.1*i", "y": "cos(2*pi*i/N)"}, "level: sum(y[i] for i in range(N))"),
    "a ring about a point": (
        {"x": "l/(2*sin(pi/N))*cos(2*pi*i/N)", "y": "l/(2*sin(pi/N))*sin(2*pi*i/N)"},
        "rod[i in range(N)]: "
        + ROD.format(j="(i + 1) % N")
        + "\n  along: sum(x[i] for i in range(N)) + y[1] - l/(2*sin(pi/N))*sin(2*pi/N)",
    ),
    "a sphere": ({"x": "cos(i)", "y": "sin(i)"}, "whole: sum(x[i]**2 + y[i]**2 for i in range(N)) - N"),
    "sums of halves": (
        {"x": "0.1*i", "y": "0.3*sin(i)"},
        "half[h in range(2)]: "
        "sum((x[i] - 0.1*i)*(i + 1)/l for i in range(N) if i % 2 == h) + y[h]*h - h*0.3*sin(h)",
    ),
    "a driven support": (
        {"x": "l*0.6*(i + 1)", "y": "-l*0.8*(i + 1)"},
        "rod[0]: (x[0] - sin(3*t)/9)**2 + y[0]**2 - l**2\n  rod[i in range(1, N)]: " + ROD.format(j="i - 1"),
    ),
}
POTENTIALS = {
    "weights": "sum(g*{m}*bead[i].y for i in range(N))",
    "springs": "sum(k*((x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2)/2 for i in range(2, N))",
    "a trap": "sum(k*(x[i]**2 + y[i]**2)/2 for i in range(0, N, 3))",
    "pairs": "-sum(k/sqrt(3 + (x[i] - x[j])**2 + (y[i] - y[j])**2) for i in range(N) for j in range(i))",
    "nothing": "0",
}
FORCES = {
    "none": "",
    "friction": 'generalized_forces: {"x[i in range(N)]": "-0.1*x_dot[i]"}',
    "wind": 'forces: {"bead[i in range(N)]": ["0.3 - 0.1*bead[i].vx", "0"]}',
    "drive": 'generalized_forces: {"y[0]": "cos(2*t)"}',
}
SYSTEM = """
sizes: {{N: {count}}}
parameters: {{l: 0.7, g: 2.0, k: {k}}}
coordinates:{coordinates}
masses: {{{masses}}}
positions: {{{positions}}}
potential: "{potential}"
{forces}
constraints:
  {constraints}
"""


def tree(count: int) -> tuple[str, str]:
    """Where the nodes of a binary tree of rods are, as expressions in i."""
    x, y = [0.0] * count, [0.0] * count
    for i in range(count):
        parent = (i - 1) // 2
        x[i] = 0.7 * np.sin(0.4 + i) + (x[parent] if i else 0.0)
        y[i] = -0.7 * np.cos(0.4 + i) + (y[parent] if i else 0.0)
    both = (
        " + ".join(f"where(i == {i}, {one!r}, 0)" for i, one in enumerate(map(float, row))) for row in (x, y)
    )
    first, second = both
    return first, second


def drawn(chance: random.Random) -> str:
    """The text of a random system."""
    shape, count = chance.choice([*SHAPES]), chance.choice(SIZES)
    start, constraints = SHAPES[shape]
    x, y = tree(count) if shape == "a tree" else (start["x"], start["y"])
    moving = shape in ("a ring", "a chain", "a tree", "pairs") and chance.random() < 0.5
    coordinates = PLACES.format(x=x, y=y, u="-0.2*y[i]" if moving else "0", w="0.2*x[i]" if moving else "0")
    coordinates = coordinates.replace("-0.2*y[i]", f"-0.2*({y})").replace("0.2*x[i]", f"0.2*({x})")
    mass = chance.choice(["1", "1 + i/7"])
    masses, positions = BEADS.format(mass=mass), AT
    if shape == "a ladder":  # two families that are tied together
        coordinates += '  a[i in range(N)]: {initial: "0.1*i + 0.42"}\n'
        coordinates += '  b[i in range(N)]: {initial: "0.3*sin(i) - 0.56"}\n'
        masses += ', "foot[i in range(N)]": 2.5'
        positions += ', "foot[i in range(N)]": ["a[i]", "b[i]"]'
    if shape == "a driven support":
        coordinates = coordinates.replace('velocity: "0"', 'velocity: "0"').replace(
            'x[i in range(N)]: {initial: "l*0.6*(i + 1)", velocity: "0"}',
            'x[i in range(N)]: {initial: "l*0.6*(i + 1)"}',
        )
        coordinates = coordinates.replace(', velocity: "0"', "")
    given = chance.sample([*POTENTIALS], chance.randint(1, 2))
    potential = " + ".join(POTENTIALS[name].format(m=f"({mass})") for name in given)
    return SYSTEM.format(
        count=count, k=chance.choice([0.7, 1.5]), coordinates=coordinates, masses=masses, positions=positions,
        potential=potential, forces=FORCES[chance.choice([*FORCES])], constraints=constraints,
    )  # fmt: skip


@pytest.mark.exhaustive(keep=0.2, most=16)
@pytest.mark.parametrize("case", range(60))
def test_families_with_constraints_move_as_their_members_do(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = drawn(random.Random(f"{pytestconfig.option.seed} {case}"))
    monkeypatch.setattr(systems, "FEWEST_BOUND", 0)
    found = systems.family_system(begun(text)[0])
    assert found is not None and found.bonds is not None, text
    together, motion = followed(text, OUTPUTS)
    monkeypatch.setattr(systems, "FEWEST_BOUND", 10**9)
    apart, expected = followed(text, OUTPUTS)
    own = [one.path for one in together.recording.datasets if "conserved" not in one.path]
    assert own == [one.path for one in apart.recording.datasets if "conserved" not in one.path]
    assert set(together.recording.conserved) <= set(apart.recording.conserved), text
    for path, values in motion.data.items():
        if path in expected.data:
            size = np.max(np.abs(expected.data[path]), initial=1.0)
            assert np.max(np.abs(values - expected.data[path])) <= 2.0**-40 * size, (path, text)
    assert np.max(np.abs(motion.data["diagnostics/constraints/" + constraint(text)])) < 1e-14


def constraint(text: str) -> str:
    """The name of the constraints."""
    return text.partition("constraints:\n  ")[2].partition(":")[0].partition("[")[0]


def ring(count: int) -> str:
    """A ring of rods that turns and is stretched by a trap."""
    start, constraints = SHAPES["a ring"]
    coordinates = PLACES.format(x=start["x"], y=start["y"], u=f"-0.2*({start['y']})", w=f"0.2*({start['x']})")
    return SYSTEM.format(
        count=count, k=1.5, coordinates=coordinates, masses=BEADS.format(mass="1 + i/7"), positions=AT,
        potential=POTENTIALS["a trap"], forces="", constraints=constraints,
    )  # fmt: skip


@pytest.mark.exhaustive(keep=0.2)
def test_what_is_said_of_constraints_does_not_grow_with_them() -> None:
    def counted(count: int) -> tuple[int, int]:
        spec, _ = begun(ring(count))
        system = systems.family_system(spec)
        assert system is not None and system.bonds is not None
        ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, OUTPUTS))
        rounds = len(system.bonds.elimination.rounds)  # each has loops of its own
        return len(system.slots.graph.nodes), len(ready.machine.program.text.splitlines()) // rounds

    (nodes, lines), (more, longer) = counted(96), counted(384)
    assert nodes == more
    assert longer <= lines


@pytest.mark.exhaustive(keep=0.3)
def test_a_step_takes_work_in_proportion_to_the_constraints() -> None:
    def work(count: int) -> int:
        spec, _ = begun(ring(count))
        ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, frozenset(["q"])))
        return int(ready.machine.program.work)

    assert work(720) / work(90) < 1.02 * 8


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("count", [400])
def test_a_ring_in_a_trap_keeps_what_a_textbook_says(count: int) -> None:
    """h, and nothing of what the trap takes away; the rods keep their lengths."""
    ready, motion = followed(ring(count), OUTPUTS, stop=0.1)
    assert ready.recording.conserved[:1] == ("h",)
    h = motion.data["diagnostics/h"]
    assert np.max(np.abs(h / h[0] - 1)) < 1e-13
    assert np.max(np.abs(motion.data["diagnostics/constraints/rod"])) < 1e-12
    kept = {name.rpartition("/")[2] for name in motion.data if "conserved" in name}
    assert kept == {"h", "L_z"}


@pytest.mark.exhaustive(keep=0.4)
def test_a_free_ring_turns_evenly() -> None:
    """Rods of equal beads on a circle, turning about its middle: x = R cos(w t + 2 pi i/N) is a motion."""
    text = ring(80).replace("1 + i/7", "1").replace(POTENTIALS["a trap"], "0")
    _, motion = followed(text, OUTPUTS, stop=2.0)
    angle = 0.2 * motion.t[:, None] + 2 * np.pi * np.arange(80) / 80
    radius = 0.7 / (2 * np.sin(np.pi / 80))
    assert np.max(np.abs(motion.data["q/x"] - radius * np.cos(angle))) < 1e-13 * radius
    assert np.max(np.abs(motion.data["q/y"] - radius * np.sin(angle))) < 1e-13 * radius
    # each rod pulls its ends together: 2 lambda l 2 sin(pi/N) = -m R w^2
    pull = motion.data["multipliers/rod"]
    assert np.max(np.abs(pull * 4 * 0.7 * np.sin(np.pi / 80) / (-(0.2**2) * radius) - 1)) < 1e-9


@pytest.mark.exhaustive(keep=0.5)
def test_what_is_said_of_conserved_quantities_is_what_members_say(monkeypatch: pytest.MonkeyPatch) -> None:
    from lagrange_cli.families.conserved.conservation import constants_of
    from lagrange_cli.mechanics.conserved.symmetries import symmetries

    monkeypatch.setattr(systems, "FEWEST_BOUND", 0)
    for name, potential in (("a ring", "nothing"), ("a ring", "a trap"), ("a chain", "weights")):
        start, constraints = SHAPES[name]
        text = SYSTEM.format(
            count=3, k=1.5, coordinates=PLACES.format(x=start["x"], y=start["y"], u="0", w="0"),
            masses=BEADS.format(mass="1 + i/7"), positions=AT, forces="", constraints=constraints,
            potential=POTENTIALS[potential].format(m="1"),
        )  # fmt: skip
        spec, _ = begun(text)
        system = systems.family_system(spec)
        assert system is not None
        found = constants_of(system)
        residual = derive_system(spec)
        assert found.cyclic == residual.cyclic
        every = [
            *residual.conserved,
            *(one.conserved for one in symmetries(residual.model, residual.conserved)),
        ]
        reasons = {one.quantity: one.because for one in every}
        for one in found.conserved:
            assert reasons[one.quantity] == one.because


def test_the_accelerations_are_those_of_the_equations(monkeypatch: pytest.MonkeyPatch) -> None:
    """A bead on y = sin(x): x'' = (sin(x) x'^2 cos(x) - g cos(x))/(1 + cos(x)^2)."""
    monkeypatch.setattr(systems, "FEWEST_BOUND", 0)
    start, constraints = SHAPES["wires"]
    text = SYSTEM.format(
        count=9, k=1, coordinates=PLACES.format(x=start["x"], y=start["y"], u="0", w="0"),
        masses=BEADS.format(mass="1"), positions=AT, potential=POTENTIALS["weights"].format(m="1"), forces="",
        constraints=constraints,
    )  # fmt: skip
    spec, values = begun(text)
    system = systems.family_system(spec)
    assert system is not None
    x, u = np.array(values.q[:9]), np.linspace(-1, 1, 9)
    q, v = np.concatenate([x, np.sin(x)]), np.concatenate([u, np.cos(x) * u])
    parameters: NDArray[np.float64] = np.array([*values.parameters.values()])
    found = compiled_accelerations(system)(0.0, q, v, parameters)
    expected = (np.sin(x) * u**2 * np.cos(x) - 2.0 * np.cos(x)) / (1 + np.cos(x) ** 2)
    assert np.max(np.abs(found[:9] - expected)) < 1e-14


def start_of(text: str, monkeypatch: pytest.MonkeyPatch, *, together: bool) -> tuple[Spec, Values]:
    """The consistent start, from the numbers of all members together, or of one after the other."""
    with monkeypatch.context() as patch:
        if not together:
            patch.setattr(consistency, "whole", lambda spec, exact: None)
        return begun(text)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "change",
    {
        "nothing": ("", ""),
        "given values that are off": ("sin(2*pi*i/N)", "sin(2*pi*i/N + 1e-9*sin(i))"),
        "velocities that are off": ("0.2*(", "0.2*(1e-9*sin(i) + "),
        "velocities that are not given": (', velocity: "0.2', ', unit: m, velocity: "0.2'),
    }.items(),
    ids=lambda change: change[0],
)
def test_starts_are_those_of_members(
    change: tuple[str, tuple[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    text = ring(110)
    old, new = change[1]
    if old:
        assert old in text
        text = text.replace(old, new)
    spec, values = start_of(text, monkeypatch, together=True)
    other, expected = start_of(text, monkeypatch, together=False)
    assert (spec.left_out, spec.faint) == (other.left_out, other.faint)
    assert np.max(np.abs(np.array(values.q) - expected.q)) < 1e-13
    assert np.max(np.abs(np.array(values.v) - expected.v)) < 1e-13


@pytest.mark.exhaustive(keep=0.4)
def test_constraints_that_depend_on_others_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every third rod of a ring is written twice: those are found, and the motion is that without them."""
    monkeypatch.setattr(systems, "FEWEST_BOUND", 0)
    monkeypatch.setattr(consistency, "DENSE", 10)
    monkeypatch.setattr(linear, "DENSE", 10)
    rods = SHAPES["a ring"][1].partition(": ")[2]
    third = rods.replace("[i]", "[3*i]").replace("(i + 1)", "(3*i + 1)")
    text = ring(24) + f"  again[i in range(8)]: 2*({third})\n"
    spec, values = begun(text)
    assert spec.left_out == tuple(f"again[{i}]" for i in range(8))
    system = systems.family_system(spec)
    assert system is not None and system.bonds is not None and system.bonds.count == 24
    outputs = frozenset(["q", "h"])
    ready = prepare_system(spec, derive_system, None, Compilation("taylor", 2.0**-52, outputs))
    found = run(ready, values, 0.0, 0.2, 3)
    _, expected = followed(ring(24), outputs, stop=0.2)
    assert np.max(np.abs(found.data["q/x"][-1] - expected.data["q/x"][-1])) < 1e-13

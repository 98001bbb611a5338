"""Chains of angles with constraints that stay families: beside the same systems written out member by member,
in Cartesian coordinates, and in equilibrium."""

from __future__ import annotations

import random
from functools import partial

import numpy as np
import pytest

from lagrange_cli.families import bonds, consistency
from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE, FULL_DOUBLE_DOUBLE
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.start import consistent_values
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_long_values
from tests.support.families import alike, followed
from tests.support.motion import Motion, run

OUTPUTS = frozenset(
    ["q", "v", "p", "h", "T", "U", "positions", "constraints", "multipliers", "conserved", "ledger", "action"]
)
EVENTS = """
events:
  turning: {{when: b[{0}].vx}}
  "fast[i in range(N)]": {{when: "a_dot[i] - 2"}}
"""
CHAIN = """
sizes: {{N: {count}}}
parameters: {{l: 3/N, m: 3/N, g: 9.81, A: 1.2, h: 2*A/(N - 1), d: l*sin(N*h/2)/sin(h/2), w: 2, X: 3}}
coordinates:
  a[i in range(N)]: {{initial: -A + h*i{speed}}}
definitions:
  x[0]: {begin}l*cos(a[0])
  x[i in range(1, N)]: x[i - 1] + l*cos(a[i])
  y[0]: l*sin(a[0])
  y[i in range(1, N)]: y[i - 1] + l*sin(a[i])
masses: {{"b[i in range(N)]": m*(1 + i/N)}}
embedding: {{"b[i in range(N)]": [x[i], y[i]]}}
potential: sum(g*m*(1 + i/N)*b[i].y for i in range(N))
{more}
constraints:
  {constraints}
"""
PINNED = "right: x[N - 1] - d\n  level: y[N - 1]"
CASES = {
    "pinned": ("", "", "", PINNED),
    "moving supports": ("0.1*sin(w*t) + ", "", "", "right: x[N - 1] - d - 0.1*sin(2*w*t)\n  level: y[N - 1]"),
    "on a straight rail": ("", "", "", "rail: y[N - 1] - 0.3*(x[N - 1] - d)"),
    "on a bent rail": ("", "", "", "rail: b[N - 1].y - 0.3*sin(b[N - 1].x - d)"),
    "on a rod": ("", "", "", "rod: (x[N - 1] - d - 1)**2 + y[N - 1]**2 - 1"),
    "pinned in the middle, with friction": (
        "",
        "",
        'generalized_forces: {"a[i in range(N)]": "-0.01*a_dot[i]"}',
        "middle: x[N//2 - 1] - d/2\n  " + PINNED,
    ),
    "two angles are tied": ("", "", "", "tie: a[3] - a[1]**2 - (-A + 3*h) + (-A + h)**2\n  " + PINNED),
    "a mean height": (
        "",
        "",
        "",
        "mean: sum(y[i] for i in range(N)) - sum(l*sin(-A + h*j)*(N - j) for j in range(N))",
    ),
}


def chain(case: str, count: int) -> str:
    """The text of a system."""
    begin, speed, more, constraints = CASES[case]
    return CHAIN.format(count=count, begin=begin, speed=speed, more=more, constraints=constraints)


def outputs_of(case: str) -> frozenset[str]:
    """All that loops compute: where positions depend on t, integrals go through the members."""
    return OUTPUTS - {"ledger", "action"} if case == "moving supports" else OUTPUTS


@pytest.mark.exhaustive(keep=0.2, most=8)
@pytest.mark.parametrize("case", [*CASES])
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_chains_move_as_their_members_do(case: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text, outputs = chain(case, 14) + EVENTS.format(3), outputs_of(case)
    together, motion = followed(text, outputs, 0.3, 4, method)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 10**9)
    apart, expected = followed(text, outputs, 0.3, 4, method)
    assert together.machine.program.loops and not apart.machine.program.loops
    assert together.recording.conserved == apart.recording.conserved
    assert set(motion.data) == set(expected.data)
    for path, values in motion.data.items():
        size = np.max(np.abs(expected.data[path]), initial=1.0)
        assert np.max(np.abs(values - expected.data[path])) <= 2.0**-40 * size, path
        if "constraints" in path:
            assert np.max(np.abs(values)) < 4e-15, path


@pytest.mark.exhaustive(keep=0.2, most=8)
@pytest.mark.parametrize("case", [*CASES])
def test_chains_move_as_their_members_do_in_double_double(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = chain(case, 6)
    monkeypatch.setattr(consistency, "FEWEST", 0)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    outputs = outputs_of(case) - {"T", "U", "conserved"}
    together, motion = exactly_followed(text, outputs)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 10**9)
    monkeypatch.setattr(consistency, "FEWEST", 10**9)
    apart, expected = exactly_followed(text, outputs)
    assert together.machine.program.loops and not apart.machine.program.loops
    alike(motion.data, expected.data, 2.0**-94)


def exactly_followed(
    text: str, outputs: frozenset[str], stop: float = 0.2, samples: int = 3
) -> tuple[Prepared, Motion]:
    """The same in double-double."""
    spec = read_spec(text, "system.yaml")
    spec, values, _ = consistent_values(spec, resolve_long_values(spec, {}), 0.0, (), exact=True)
    compilation = Compilation("taylor", FULL_DOUBLE_DOUBLE, outputs, precision=DOUBLE_DOUBLE)
    ready = prepare_system(spec, partial(derive_system, exact=True), None, compilation)
    return ready, run(ready, values, 0.0, stop, samples)


RAILS = """
sizes: {{N: {count}}}
parameters: {{l: 1, m: 1, g: 9.81, A: 0.5}}
coordinates:
  a[i in range(N)]: {{initial: "(A + {off}*sin(1 + i//2))*(1 - 2*(i%2))"}}
definitions:
  x[0]: l*cos(a[0])
  x[i in range(1, N)]: x[i - 1] + l*cos(a[i])
  y[0]: l*sin(a[0])
  y[i in range(1, N)]: y[i - 1] + l*sin(a[i])
masses: {{"b[i in range(N)]": m*(1 + (i*i % 7)/5)}}
embedding: {{"b[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum(g*m*b[i].x + m*g*b[i].y for i in range(N))
constraints: {{"rail[i in range(N//2)]": "y[2*i + 1]"}}
"""


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("count", [2, 9, 18])
def test_dense_multipliers_move_chains_as_their_members_do(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every other joint slides on a rail: 1 to 9 multipliers, less than a vector and more than one."""
    off = random.uniform(0.0, 0.3)
    text = RAILS.format(count=count, off=off)
    for module, name in ((bonds, "MOST"), (consistency, "FEWEST"), (systems, "FEWEST_JOINTED")):
        monkeypatch.setattr(module, name, 0)
    outputs = OUTPUTS - {"T", "U", "conserved", "ledger"}
    together, motion = exactly_followed(text, outputs)
    _, rounded = followed(text, stop=0.2, samples=3, outputs=outputs)
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 10**9)
    apart, expected = exactly_followed(text, outputs)
    assert together.machine.program.loops and not apart.machine.program.loops
    alike(motion.data, expected.data, 2.0**-94, off)
    alike(rounded.data, expected.data, 2.0**-40, off)


TREE = """
sizes: {{N: {count}}}
coordinates: {{"a[i in range(N)]": {{initial: "{start}"}}}}
definitions:
  x[0]: cos(a[0])
  x[i in range(1, N)]: x[{parent}] + cos(a[i])
  y[0]: sin(a[0])
  y[i in range(1, N)]: y[{parent}] + sin(a[i])
masses: {{"b[i in range(N)]": "1 + (i*i % 7)/5"}}
embedding: {{"b[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum(9.81*b[i].y for i in range(N))
{forces}
constraints:
  {constraints}
"""
HELD = (
    "y[{n}] - ({y!r})",
    "y[{n}] - ({y!r}) - {k!r}*(x[{n}] - ({x!r}))",
    "(x[{n}] - ({x!r}) - 1)**2 + (y[{n}] - ({y!r}))**2 - 1",
    "y[{n}] - ({y!r}) - sin(x[{n}] - ({x!r}))/3",
    "a[{n}] - ({a!r}) + {k!r}*(a[{m}] - ({b!r}))",
)
ACTING = (
    "",
    'generalized_forces: {"a[i in range(N)]": "-0.1*a_dot[i]*abs(a_dot[i])"}',
    'forces: {"b[i in range(N)]": ["0.2*b[i].vy", "max(0, b[i].x - 1)"]}',
)


def tree(chance: random.Random) -> str:
    """A random tree: some nodes are on rails, wires or circles, and some angles are tied."""
    count, branches = chance.choice([4, 5, 8, 9, 14]), chance.choice([1, 2, 3])
    angles = [chance.uniform(-1.0, 1.0) for _ in range(count)]
    places = list[complex]()
    for i, angle in enumerate(angles):
        places.append((places[(i - 1) // branches] if i else 0.0) + complex(np.exp(1j * angle)))
    listed = []
    for n in chance.sample(range(1, count), chance.randint(1, count // 2 - 1)):
        m, k = chance.choice([i for i in range(count) if i != n]), chance.uniform(-1.0, 1.0)
        x, y = places[n].real, places[n].imag
        held = chance.choice(HELD).format(n=n, m=m, k=k, x=x, y=y, a=angles[n], b=angles[m])
        listed.append(f"held{n}: {held}")
    start = " + ".join(f"where(i == {i}, {angle!r}, 0)" for i, angle in enumerate(angles))
    return TREE.format(
        count=count,
        start=start,
        parent="i - 1" if branches == 1 else f"(i - 1)//{branches}",
        forces=chance.choice(ACTING),
        constraints="\n  ".join(listed),
    )


@pytest.mark.exhaustive(keep=0.2, most=6)
@pytest.mark.parametrize("case", range(12))
def test_random_trees_move_as_their_members_do(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By loops over full rows, forward and backward in time."""
    chance = random.Random(f"{pytestconfig.option.seed} tree {case}")
    text, stop, found = tree(chance), chance.choice([0.2, -0.2]), list[Motion]()
    outputs, method = (
        frozenset(["q", "v", "p", "multipliers", "constraints"]),
        chance.choice(["taylor", "ias15"]),
    )
    monkeypatch.setattr(bonds, "MOST", 0)
    for few in (0, 10**9):
        monkeypatch.setattr(systems, "FEWEST_JOINTED", few)
        ready, motion = followed(text, outputs, stop, 3, method)
        assert ready.machine.program.loops == (few == 0), text
        found.append(motion)
    one, other = found
    alike(one.data, other.data, 2.0**-38, stop, method, text)


@pytest.mark.exhaustive(keep=0.15)
def test_more_constraints_than_sparse_rows_have_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    """131 multipliers of one chain, by loops over full rows and by tables of single entries."""
    text, outputs = RAILS.format(count=262, off=0.1), frozenset(["q", "h", "multipliers", "constraints"])
    dense, motion = followed(text, stop=0.05, samples=2, outputs=outputs)
    monkeypatch.setattr(bonds, "MOST", 10**6)
    sparse, expected = followed(text, stop=0.05, samples=2, outputs=outputs)
    assert dense.machine.program.loops and sparse.machine.program.loops
    for path, values in motion.data.items():
        assert np.max(np.abs(values - expected.data[path])) <= 2.0**-40 * np.max(
            np.abs(expected.data[path]), initial=1.0
        ), path


CARTESIAN = """
sizes: {{N: {count}}}
parameters: {{l: 3/N, m: 3/N, g: 9.81, A: 1.2, h: 2*A/(N - 1), d: l*sin(N*h/2)/sin(h/2)}}
coordinates:
  x[i in range(N - 1)]: {{initial: "sum(l*cos(-A + h*j) for j in range(i + 1))"}}
  y[i in range(N - 1)]: {{initial: "sum(l*sin(-A + h*j) for j in range(i + 1))"}}
masses: {{"b[i in range(N - 1)]": m*(1 + i/N)}}
embedding: {{"b[i in range(N - 1)]": ["x[i]", "y[i]"]}}
potential: sum(g*m*(1 + i/N)*y[i] for i in range(N - 1))
constraints:
  rod[0]: x[0]**2 + y[0]**2 - l**2
  rod[i in range(1, N - 1)]: (x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2 - l**2
  last: (x[N - 2] - d)**2 + y[N - 2]**2 - l**2
"""


@pytest.mark.exhaustive(keep=0.15)
def test_a_pinned_chain_moves_as_in_cartesian_coordinates() -> None:
    count = 80
    ready, motion = followed(chain("pinned", count), OUTPUTS, stop=0.2, samples=3)
    _, expected = followed(CARTESIAN.format(count=count), OUTPUTS, stop=0.2, samples=3)
    assert ready.machine.program.loops
    assert np.max(np.abs(motion.data["positions/b"][:, :-1] - expected.data["positions/b"])) < 1e-11
    h = motion.data["diagnostics/h"]
    assert np.max(np.abs(h / h[0] - 1)) < 1e-13


@pytest.mark.exhaustive(keep=0.2)
def test_a_chain_hangs_in_equilibrium() -> None:
    """Equal loads at the joints: tan(a[i]) is linear in i, as along a catenary."""
    count = 40
    text = chain("pinned", count).replace("-A + h*i", "atan((i - (N - 1)/2)/9)")
    text = text.replace(
        "d: l*sin(N*h/2)/sin(h/2)", "d: sum(l*cos(atan((j - (N - 1)/2)/9)) for j in range(N))"
    )
    text = text.replace("m*(1 + i/N)", "m")
    ready, motion = followed(text, OUTPUTS, 1.0, 4)
    assert ready.machine.program.loops
    a = motion.data["q/a"]
    # perturbations by rounding oscillate
    assert np.max(np.abs(np.tan(a[-1]) - (np.arange(count) - (count - 1) / 2) / 9)) < 1e-12
    assert np.max(np.abs(motion.data["v/a"])) < 1e-12


@pytest.mark.exhaustive(keep=0.2)
def test_code_and_work_grow_as_they_should() -> None:
    """The code does not grow with the chain, and the arrays grow with its length."""

    def sizes(count: int) -> tuple[int, int]:
        spec = read_spec(chain("pinned", count), "system.yaml")
        program = prepare_system(
            spec, derive_system, None, Compilation("taylor", 2.0**-52, frozenset(["q"]))
        ).machine.program
        return len(program.text.split("@tables")[0].splitlines()), program.work

    (lines, work), (more, larger) = sizes(96), sizes(960)
    assert more <= 1.01 * lines
    assert larger < 10.5 * work


@pytest.mark.exhaustive(keep=0.25)
def test_a_state_is_moved_back_to_the_constraints() -> None:
    """Over many steps, places stay where constraints hold but for rounding, and that is counted."""
    _, motion = followed(chain("on a bent rail", 12), OUTPUTS, stop=4.0, samples=9)
    assert np.max(np.abs(motion.data["diagnostics/constraints/rail"])) < 2e-15
    h = motion.data["diagnostics/h"]
    assert np.max(np.abs(h / h[0] - 1)) < 1e-12

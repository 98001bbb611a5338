"""Systems of many members: the work of deriving them grows as they do, and comes to the same."""

from __future__ import annotations

import random
import sys
from textwrap import dedent

import pytest

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import Node, bits
from lagrange_cli.expression.zero import zeros
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.mechanics.guards.equations import guarded
from lagrange_cli.mechanics.guards.holding import at_a_held_state
from lagrange_cli.mechanics.guards.vectors import vectors
from lagrange_cli.mechanics.matrices import connected
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.rows import Row
from lagrange_cli.mechanics.switching.jumps import refuse_jumps
from lagrange_cli.mechanics.switching.saturation import saturated
from lagrange_cli.mechanics.variables import graph_of, nonzero, variables
from lagrange_cli.model.build import build_model
from lagrange_cli.series.lowering import lower
from lagrange_cli.series.program import Op, SeriesProgram
from lagrange_cli.spec.read import read_spec
from tests.support.motion import SYSTEMS

UNEQUAL = dedent("""
    sizes: {N: 4}
    parameters:
      l[i in range(N)]: 1 + 0.1*i
      m[i in range(N)]: 2 - 0.1*i
      g: 9.81
    coordinates:
      theta[i in range(N)]: {initial: 1}
    definitions:
      x[0]: l[0]*sin(theta[0])
      x[i in range(1, N)]: x[i - 1] + l[i]*sin(theta[i])
      y[0]: -l[0]*cos(theta[0])
      y[i in range(1, N)]: y[i - 1] - l[i]*cos(theta[i])
    masses:
      bob[i in range(N)]: m[i]
    embedding:
      bob[i in range(N)]: [x[i], y[i]]
    potential: sum(m[i]*g*bob[i].y for i in range(N))
""")


def residual(system: str, **sizes: int) -> Residual:
    text = system if "\n" in system else (SYSTEMS / f"{system}.yaml").read_bytes()
    spec = read_spec(text, "system.yaml", {name: str(size) for name, size in sizes.items()})
    return derive(build_model(spec, GraphAlgebra()))


def series(found: Residual) -> SeriesProgram:
    model = found.model
    return lower(found.graph, variables(model), model.q, model.v, model.time, found.residual, ())


def work(found: Residual) -> dict[str, int]:
    """What was made on the way: nodes, derivatives, terms of sums of series."""
    terms = sum(len(one.arguments) for one in series(found).series if one.op is Op.LINEAR)
    return {"nodes": len(found.graph.nodes), "derivatives": len(found.graph._derivatives), "terms": terms}


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("system", ["fpu_chain", "lattice"])
def test_deriving_a_lattice_takes_work_in_proportion_to_its_size(system: str) -> None:
    sizes = {"lattice": ({"N": 10, "M": 6}, {"N": 10, "M": 12})}.get(system, ({"N": 60}, {"N": 120}))
    small, large = (work(residual(system, **one)) for one in sizes)
    for name, amount in large.items():
        assert amount <= 2.1 * small[name], name


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("system", ["n_pendulum", UNEQUAL], ids=["equal", "unequal"])
def test_a_chain_takes_four_convolutions_and_some_additions_a_bob(system: str) -> None:
    for size in (10, 20):
        found = residual(system, N=size)
        assert found.costs["embedding"] == 4 * size
        assert work(found)["terms"] <= 14 * size


def test_the_mass_matrix_of_a_chain_is_the_known_one() -> None:
    """M_jk = (sum of m_i from max(j, k) on) l_j l_k cos(theta_j - theta_k)."""
    found, size = residual(UNEQUAL, N=6), 6
    graph, model = found.graph, found.model
    rods, masses = ([model.parameters[f"{name}[{i}]"] for i in range(size)] for name in "lm")
    source = random.Random(1)
    values = {name: source.uniform(0.5, 2) for name in (*model.parameters, *model.coordinates)}
    for j, row in enumerate(found.mass_matrix):
        for k, entry in enumerate(row):
            carried = graph.sum([(mass, 1.0) for mass in masses[max(j, k) :]])
            known = carried * rods[j] * rods[k] * graph.function("cos", [model.q[j] - model.q[k]])
            both, _ = evaluate([entry, known], values)
            assert both[entry] == pytest.approx(both[known], rel=1e-14)


def test_a_gradient_holds_the_derivatives_that_are_not_zero() -> None:
    graph = Graph()
    symbols = [graph.symbol(f"x{i}") for i in range(20)]
    squares = graph.sum([(x * x, 0.5 * i) for i, x in enumerate(symbols)])
    product = graph.product([(x, i % 3) for i, x in enumerate(symbols)])
    whole = graph.function("sin", [squares + symbols[0] * symbols[1]]) * product + symbols[3] - symbols[3]
    places = {x: i for i, x in enumerate(symbols)}
    fresh = Graph()
    for node in (squares, product, whole, symbols[4], graph.one):
        found = graph.gradient(node, places)
        assert list(found) == sorted(found)
        for i, x in enumerate(symbols):
            assert found.get(i, graph.zero) is graph.diff(node, x)
            assert (i in found) == (not graph.diff(node, x).is_zero)
    assert graph.gradient(squares, places)[7] is graph.sum([(symbols[7], 7.0)])
    assert 0 not in graph.gradient(squares, places)
    assert fresh.gradient(fresh.one, {}) == {}


def test_bits_are_places_of_ones() -> None:
    assert list(bits(0)) == []
    assert list(bits(0b1011 << 200)) == [200, 201, 203]


def test_zeros_are_found_among_what_is_not_zero() -> None:
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")

    def cos(node: Node) -> Node:
        return graph.function("cos", [node])

    def sin(node: Node) -> Node:
        return graph.function("sin", [node])

    hidden = sin(x + y) - sin(x) * cos(y) - cos(x) * sin(y)
    nowhere = graph.function("log", [-1.0 - x * x])
    small = 1e-9 * x
    assert zeros([hidden, x, small, graph.zero, nowhere, hidden * y]) == {hidden, graph.zero, hidden * y}
    assert zeros([]) == set()


def test_blocks_are_what_entries_connect() -> None:
    graph = Graph()
    entries = {(0, 3), (3, 5), (1, 1), (4, 2)}
    matrix = tuple(tuple(graph.one if (j, k) in entries else graph.zero for k in range(6)) for j in range(6))
    assert connected(matrix) == ((0, 3, 5), (1,), (2, 4))
    assert connected(()) == ()


MANY = """
sizes: {{N: {count}}}
parameters: {{k: 2}}
coordinates: {{x[i in range(N)]: {{initial: 0.3*i}}}}
masses: {{b[i in range(N)]: 1}}
embedding: {{b[i in range(N)]: [x[i]]}}
potential: {potential}
"""


@pytest.mark.parametrize(
    "potential",
    [
        "sum(abs(x[i] - i)*x[(i + 1)%N] for i in range(N))",
        "k*(x[0]**2 + 1)*sum(max(x[i], x[(i + 1)%N]) for i in range(N))",
        "sum(1/(1 + exp(x[i] - k)) for i in range(N))",
        "sum(1/cosh(x[i] - x[(i + 1)%N])**2 for i in range(N))",
    ],
)
def test_many_switches_and_exponentials_take_work_in_proportion(potential: str) -> None:
    """Each is looked at beside what changes with it, not beside all others."""
    spent = []
    for count in (30, 60):
        model = build_model(
            read_spec(MANY.format(count=count, potential=potential), "a.yaml"), GraphAlgebra()
        )
        before = graph_of(model).work.spent
        refuse_jumps(model)
        saturated(model)
        spent.append(graph_of(model).work.spent - before)
    assert spent[1] < 2.5 * spent[0]


@pytest.mark.exhaustive(keep=0.25)
def test_a_mass_matrix_takes_memory_for_what_is_coupled() -> None:
    """Of 300 beads each has a mass of its own: 300 entries, not 90,000."""
    matrix = residual("fpu_chain", N=300).mass_matrix
    places = [nonzero(row, row[j].graph.zero, j) for j, row in enumerate(matrix)]
    assert places == [[j] for j in range(300)]
    assert sum(sys.getsizeof(row.places) for row in matrix if isinstance(row, Row)) < 300 * 100
    assert [*matrix[7]] == [matrix[7][k] for k in range(300)] and matrix[7][-293] is matrix[7][7]
    assert matrix[7][5:9] == tuple(matrix[7])[5:9]


@pytest.mark.parametrize("place", [0, 60, 511, 512, 700])
def test_wide_sets_of_symbols_are_kept_once_and_are_those_of_the_arguments(place: int) -> None:
    """Whatever the width: a node's set is the union of its arguments', and equal wide ones are one object."""
    graph = Graph()
    symbols = [graph.symbol(f"x{i}") for i in range(900)]
    one, other = symbols[place], symbols[place + 61]  # Python gives their sets the same hash
    made = [one * other, one + other, graph.function("sin", [one - other]), (one / other) ** 3 + one]
    for node in made:
        assert node.symbols == one.symbols | other.symbols
        assert graph.symbols_of(node) == [one, other]
        assert node.symbols is made[0].symbols or place + 61 < 511
    squares = [x * x for x in symbols]
    assert [x.symbols for x in squares] == [1 << i for i in range(900)]


@pytest.mark.exhaustive(keep=0.8)
def test_equal_sets_of_symbols_cost_once() -> None:
    """Ten expressions of the same two of 20,000 symbols: one set of 2.5 kB, 39 steps, not ten."""
    graph = Graph()
    symbols = [graph.symbol(f"x{i}") for i in range(20000)]
    pair = symbols[0] * symbols[-1]
    before, known = graph.work.spent, len(graph.nodes)
    for i in range(10):
        graph.function("sin", [pair + float(i)])
    assert len(graph.nodes) > known + 18 and graph.work.spent - before < 100


PUCKS = dedent("""
    sizes: {N: 4}
    parameters: {mu: 0.2, g: 9.81}
    coordinates:
      x[i in range(N)]: {initial: i}
      y[i in range(N)]: {initial: 0}
    masses: {"puck[i in range(N)]": 1}
    embedding: {"puck[i in range(N)]": ["x[i]", "y[i]"]}
    definitions: {"speed[i in range(N)]": "norm((x_dot[i], y_dot[i]))"}
    potential: sum((x[i + 1] - x[i] - 1)**2 + (y[i + 1] - y[i])**2 for i in range(N - 1))
    forces: {"puck[i in range(N)]": ["-mu*g*x_dot[i]/speed[i]", "-mu*g*y_dot[i]/speed[i]"]}
""")


RELATIVE = """
sizes: {N: 4}
parameters: {F: 0.5, k: 5, l: 1.0, w: 0.7}
coordinates:
  "x[i in range(N)]": {initial: "1.05*i", velocity: "0.5*sin(3*i + 1)"}
  "y[i in range(N)]": {initial: "0.1*cos(2*i)", velocity: "0.5*cos(5*i)"}
masses: {"p[i in range(N)]": 1 + i % 2}
embedding: {"p[i in range(N)]": ["x[i]", "y[i]"]}
potential: "sum(k*(norm(p[i + 1] - p[i]) - l)**2/2 for i in range(N - 1))"
definitions:
  "u[i in range(N - 1)]": "p[i + 1].vx - p[i].vx"
  "v[i in range(N - 1)]": "p[i + 1].vy - p[i].vy"
dissipation: >-
  sum(F*norm((cos(w*t)*u[i] + sin(w*t)*v[i], cos(w*t)*v[i] - sin(w*t)*u[i])) for i in range(N - 1))
"""


def test_friction_along_relative_vectors_that_turn_takes_work_for_each_vector() -> None:
    """Neither each velocity is looked for in each vector, nor each vector in each equation, which all contain
    the time that it depends on."""
    spent = []
    for count in (15, 30, 60):
        found = residual(RELATIVE, N=count)
        before = found.graph.work.spent
        assert len(guarded(found, {}).guards) == count - 1
        spent.append(found.graph.work.spent - before)
    assert spent[1] < 2.2 * spent[0] and spent[2] < 2.2 * spent[1]
    assert spent[2] < 1_200_000


def test_vectors_with_friction_are_looked_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    found = residual(RELATIVE, N=3)
    known = vectors(found)
    assert len(known) == 2
    monkeypatch.setattr("lagrange_cli.mechanics.guards.vectors.completed", lambda *_: pytest.fail("again"))
    assert vectors(found) is known and len(guarded(found, {}).guards) == 2


@pytest.mark.exhaustive(keep=0.15)
def test_friction_along_a_vector_is_looked_for_where_the_vector_is() -> None:
    """Each puck has a vector of its own, and what is derived for it is what is derived for one: only the
    matrix of the forces that hold grows as the square of their number."""
    spent = []
    for count in (40, 80):
        found = residual(PUCKS, N=count)
        before = found.graph.work.spent
        assert at_a_held_state(found, [found.graph.ddt(v) for v in found.model.v]) is not None
        spent.append(found.graph.work.spent - before)
    assert spent[1] < 3.0 * spent[0]

"""Indexed families: what is written in a line is what would be written out; mistakes are shown once."""

from __future__ import annotations

import random
import re
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli import solve
from lagrange_cli.errors import SpecError, UsageError
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.keys import parse_key
from lagrange_cli.expression.loops import grids, places
from lagrange_cli.expression.node import Node
from lagrange_cli.model.build import build_model
from lagrange_cli.model.model import Model
from lagrange_cli.run import shipped
from lagrange_cli.spec.families import MAX_MEMBERS
from lagrange_cli.spec.family import places_of
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Family, Spec, grouped
from lagrange_cli.spec.values import Values, resolve_values
from tests.support.draws import examples
from tests.support.files import problems, underlined

CHAIN = """\
sizes: {N: 4}
parameters:
  m: [1.0, 0.5, 2.0, 1.0]
  k: 2.0
coordinates:
  u[i in range(N)]: {initial: 0.1*i}
masses:
  bead[i in range(N)]: m[i]
embedding:
  bead[i in range(N)]: [u[i], 0]
potential: sum(k/2*(u[i + 1] - u[i])**2 for i in range(N - 1))
"""

WRITTEN_OUT = """\
parameters:
  m0: 1.0
  m1: 0.5
  m2: 2.0
  m3: 1.0
  k: 2.0
coordinates:
  u0: {initial: 0}
  u1: {initial: 0.1}
  u2: {initial: 0.2}
  u3: {initial: 0.1*3}
masses: {b0: m0, b1: m1, b2: m2, b3: m3}
embedding: {b0: [u0, 0], b1: [u1, 0], b2: [u2, 0], b3: [u3, 0]}
potential: k/2*(u1 - u0)**2 + k/2*(u2 - u1)**2 + k/2*(u3 - u2)**2
"""


def changed(old: str, new: str) -> str:
    assert CHAIN.count(old) == 1, old
    return CHAIN.replace(old, new)


def model(text: str, **sizes: str) -> Model[Node]:
    return build_model(read_spec(text, "a.yaml", sizes), GraphAlgebra())


def text_of(node: Node) -> str:
    """A node as text, in which members have the names that a person would give them."""
    return re.sub(r"(\w)(_dot)?\[(\d)\]", r"\1\3\2", repr(node))


def test_a_family_is_what_it_is_written_out() -> None:
    short, long = model(CHAIN), model(WRITTEN_OUT)
    assert short.coordinates == ("u[0]", "u[1]", "u[2]", "u[3]")
    assert text_of(short.potential) == text_of(long.potential)
    for one, other in zip(short.particles, long.particles, strict=True):
        assert text_of(one.mass) == text_of(other.mass)
        assert list(map(text_of, one.velocity)) == list(map(text_of, other.velocity))
    assert resolve_values(read_spec(CHAIN, "a")).q == resolve_values(read_spec(WRITTEN_OUT, "a")).q


def test_families_are_kept_by_section() -> None:
    spec = read_spec(CHAIN, "a.yaml")
    members = ("u[0]", "u[1]", "u[2]", "u[3]")
    assert spec.sizes == {"N": 4}
    assert spec.families["coordinates"] == {"u": Family("u", (4,), members, ("N",))}
    assert spec.families["parameters"]["m"].axes == ("index_4",)
    assert spec.families["embedding"]["bead"].label == "bead[i]"
    assert [one.name for one in grouped(("x", *members, "y"), spec.families["coordinates"])] == [
        "x",
        "u",
        "y",
    ]


def test_sizes_may_be_changed_and_use_one_another() -> None:
    text = changed("{N: 4}", "{N: 2*M, M: 2}")
    assert read_spec(text, "a").sizes == {"N": 4, "M": 2}
    spec = read_spec(text, "a", {"M": "1"})
    assert spec.sizes == {"N": 2, "M": 1}
    assert len(spec.coordinates) == 2
    assert read_spec(text, "a", {"N": "M + 1"}).sizes == {"N": 3, "M": 2}


def values(text: str = CHAIN, **overrides: str) -> Values:
    names = {name.replace("__", "[") + "]" * ("__" in name): value for name, value in overrides.items()}
    return resolve_values(read_spec(text, "a.yaml"), names)


def test_members_are_set_one_by_one() -> None:
    found = values(m__1="2*k", u__0="m[1]/N", u_dot__3="k", k="3")
    assert found.parameters == {"m[0]": 1.0, "m[1]": 6.0, "m[2]": 2.0, "m[3]": 1.0, "k": 3.0}
    assert found.q == (1.5, 0.1, 0.2, 0.1 * 3)
    assert found.v == (0.0, 0.0, 0.0, 3.0)


def test_the_index_of_a_member_that_is_set_may_be_an_expression() -> None:
    spec = read_spec(CHAIN, "a.yaml")
    assert resolve_values(spec, {"u[N - 1]": "7", "u_dot[ 1 ]": "5"}) == resolve_values(
        spec, {"u[3]": "7", "u_dot[1]": "5"}
    )


def test_an_override_may_turn_the_order_of_members_round() -> None:
    text = changed("k: 2.0", "k: m[1]")
    assert values(text, m__0="k + m[3]").parameters["m[0]"] == 1.5
    with pytest.raises(UsageError, match=r"--set m\[1\]=k: depends on itself: m\[1\] -> k -> m\[1\]"):
        values(text, m__1="k")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("u", "1", "--set u=1: 'u' is a family; write one of its members, u[0] to u[3]"),
        ("u_dot", "1", "'u_dot' is a family; write one of its members, u_dot[0] to u_dot[3]"),
        ("N", "300", "--set N=300: 'N' is a size; --size N=300 sets it"),
        (
            "bead[1]",
            "2",
            "'bead[1]' is a particle; only parameters and initial values can be set; known: m[0]",
        ),
        ("u.x", "1", "'u' is a coordinate and has no components; write u"),
        ("m[4]", "1", "unknown name 'm[4]'; it is a family with members m[0] to m[3]"),
        ("m[-1]", "1", "unknown name 'm[-1]'"),
        ("m[0.5]", "1", "0.5 is not a whole number"),
        ("m[i]", "1", "'i' is neither an index nor a size"),
        ("m[", "1", "unclosed"),
        ("w[0]", "1", "unknown name 'w[0]'"),
        ("m[0]", "m[9]", "no member 'm[9]'; the members are m[0] to m[3]"),
        ("m[0]", "m", "'m' is a family; write one of its members, m[0] to m[3]"),
        ("m[0]", "u[0]", "'u' is a coordinate; values are numbers, or expressions in parameters; known: "),
        ("m[2]", "-1", "the value -1 is not positive in mass of 'bead[2]'"),
    ],
)
def test_wrong_overrides_of_members_are_wrong_usage(name: str, value: str, message: str) -> None:
    with pytest.raises(UsageError) as caught:
        resolve_values(read_spec(CHAIN, "a.yaml"), {name: value})
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("sizes", "message"),
    [
        ({"K": "3"}, "--size K=3: unknown size 'K'; known: N"),
        ({"k": "3"}, "--size k=3: 'k' is a parameter; --set k=3 sets it"),
        ({"m": "3"}, "--size m=3: 'm' is a family; --set m[...]=3 sets a member of it"),
        ({"u_dot": "3"}, "--size u_dot=3: 'u_dot' is a family; --set u_dot[...]=3 sets a member of it"),
        ({"bead": "3"}, "--size bead=3: 'bead' is a particle, and no size; known: N"),
        ({"N": "0"}, "--size N=0: the value is 0; sizes are whole numbers greater than 0"),
        ({"N": "-2"}, "the value is -2"),
        ({"N": "2.5"}, "2.5 is not a whole number"),
        ({"N": "k"}, "'k' is neither an index nor a size here"),
        ({"N": "2 2"}, "missing operator"),
    ],
)
def test_wrong_sizes_are_wrong_usage(sizes: dict[str, str], message: str) -> None:
    with pytest.raises(UsageError) as caught:
        read_spec(CHAIN, "a.yaml", sizes)
    assert message in str(caught.value)


PIECES = """\
sizes: {N: 5}
parameters: {g: 9.81}
coordinates:
  theta[i in range(N)]: {initial: 1}
definitions:
  x[i in range(1, N)]: x[i - 1] + sin(theta[i])
  x[0]: sin(theta[0])
  y[N - 1]: [-cos(theta[N - 1]), g]
  y[i in range(N - 1)]: y[i + 1] - (cos(theta[i]), 0)
masses:
  bob[i in range(N)]: 1
embedding:
  bob[i in range(1, N, 2)]: [x[i], 0]
  bob[i in range(0, N, 2)]: [0, y[i].x]
forces:
  bob[N - 1]: [g, 0]
generalized_forces:
  theta[i in range(2)]: -theta_dot[i]
observables:
  height[i in range(2), j in range(N)]: bob[j].y*i + bob[j].vx
potential: g*y[0].y
"""


def test_members_may_be_given_in_pieces_and_use_one_another() -> None:
    spec = read_spec(PIECES, "a.yaml")
    found = model(PIECES)
    order = list(spec.definitions)
    assert order.index("x[0]") < order.index("x[1]") < order.index("x[4]")
    assert order.index("y[4]") < order.index("y[0]")
    sines = ", ".join(f"function('sin', symbol('theta[{i}]'))" for i in range(4))
    (x, zero) = found.particles[3].position
    assert repr(x) == f"sum((0.0, (1.0, 1.0, 1.0, 1.0)), {sines})"
    assert zero.is_zero
    assert [bool(particle.force) for particle in found.particles] == [False] * 4 + [True]
    assert [force.is_zero for force in found.generalized_forces] == [False, False, True, True, True]
    assert spec.families["observables"]["height"].shape == (2, 5)
    assert list(found.observables)[:2] == ["height[0,0]", "height[0,1]"]
    assert spec.families["observables"]["height"].axes == ("index_2", "N")


@pytest.mark.parametrize("name", ["chain", "fpu_chain"])
def test_a_piece_has_no_members_where_its_range_is_empty(name: str) -> None:
    """A chain of one link has no pairs of neighbours."""
    one, two = (model(shipped.text(name), N=N) for N in "12")
    assert len(one.coordinates) == len(two.coordinates) // 2 > 0
    assert [each.name for each in one.constraints] == [each.name for each in two.constraints][:1]


@given(st.integers(1, 6), st.integers(-2, 3), st.integers(0, 4), st.sampled_from(["<", ">=", "!=", "=="]))
@examples(20)
def test_indices_may_depend_on_one_another(size: int, shift: int, start: int, compares: str) -> None:
    """Members are those of Python's own loops, and have their values; what is left out does not exist."""
    ranges = f"i in range(N), j in range({start}, i + {shift}) if (i + j) % 3 {compares} 1"
    text = f"sizes: {{N: {size}}}\ncoordinates: [x]\ndefinitions:\n  d[{ranges}]: 10*i + j\n"
    text += "  whole: 1\nlagrangian: x_dot**2/2\n"
    holds = {"<": int.__lt__, ">=": int.__ge__, "!=": int.__ne__, "==": int.__eq__}[compares]
    expected = [(i, j) for i in range(size) for j in range(start, i + shift) if holds((i + j) % 3, 1)]
    spec = read_spec(text, "a.yaml")
    if not expected:
        assert "d" not in spec.families["definitions"]
        assert not any(name.startswith("d[") for name in spec.definitions)
        return
    members = spec.families["definitions"]["d"].members
    assert [*members] == [f"d[{i},{j}]" for i, j in expected]
    for i, j in expected:
        one = spec.definitions[f"d[{i},{j}]"]
        assert one.indices == {"i": i, "j": j}


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    "ranges",
    [
        ("i in range(N)", "j in range(N) if i != j"),
        ("i in range(N)", "j in range(N - 1, -1, -1) if (i*j) % 7 < 2 and not j == 5"),
        ("i in range(3)", "j in range(N) if j % (i + 1)", "k in range(j - N + 3)"),
        ("i in range(N)", "j in range(N) if abs(i - j) == 1"),
        (
            "i in range(N - 1, -1, -2)",
            "j in range(N)",
            "k in range(N) if k // 3 == (i + j) // 4 and abs(i - j) < 4",
        ),
    ],
)
def test_many_members_are_those_of_the_loops(ranges: tuple[str, ...]) -> None:
    """Values of an index are examined together from 64 on; members are in few ranges."""
    count, names = 90, "".join(one[0] for one in ranges)
    parsed = parse_key(f"d[{', '.join(ranges)}]")
    loops = " ".join(f"for {one}" for one in ranges)
    expected = eval(f"[({', '.join(names)}) {loops}]", {"N": count})
    assert [place for place, _ in places(parsed.axes, {"N": count}, 10**6)] == expected
    assert [own for _, own in places(parsed.axes, {"N": count}, 10**6)] == [
        dict(zip(names, place)) for place in expected
    ]
    found = grids(parsed.axes, {"N": count}, 10**6)
    members = [place for ranges in found for place in product(*ranges)]
    assert members == sorted(expected)
    made = places_of(found)
    assert [*made] == members == [made[k] for k in range(len(made))]
    assert [made.number(place) for place in members] == [*range(len(members))]
    assert made.number((count, 0)) is None
    assert len(found) < len(members)


GAPS = """
sizes: {N: 1, M: 300}
coordinates: {"x[i in range(N)]": {initial: i, velocity: 1}, "y[k in range(M)]": {initial: sin(k)}}
masses: {"b[i in range(N)]": 1, "c[k in range(M)]": 2}
embedding: {"b[i in range(N)]": ["x[i]", 0], "c[k in range(M)]": ["y[k]", 0]}
definitions:
  d[i in range(N), j in range(i)]: x[i] - x[j]
  e[i in range(N), j in range(N) if i != j]: [d[max(i,j), min(i,j)], 0]
potential: "sum(1/d[i,j] + e[i,j].x for i in range(N) for j in range(i)) + sum(y[k]**2 for k in range(M))"
constraints: {"rod[i in range(N - 1)]": "(x[i + 1] - x[i])**2 - 1"}
forces: {"b[i in range(1, N)]": [-1, 0]}
observables:
  gap[i in range(1, N)]: x[i] - x[i - 1]
  pull: sum(rod[i].multiplier for i in range(N - 1))
events: {"hit[i in range(N), j in range(i)]": "d[i,j]"}
solve: {stop: 1, samples: 2}
"""


@pytest.mark.exhaustive(keep=0.5)
def test_families_may_have_no_members() -> None:
    """One body has no pairs, and no bonds: expressions, and loops over many others, do without them."""
    alone = solve(GAPS, size={"M": 1}, outputs=["q", "observables"])
    assert alone.q["x"][-1] == pytest.approx([1])
    assert alone.status == "complete"
    [*_, last] = solve(GAPS, outputs=["q", "observables"]).q["x"]
    assert last == pytest.approx([1])
    assert len(read_spec(GAPS, "a.yaml", {"N": "3"}).constraints) == 2
    wrong = GAPS.replace(" + sum(y[k]", " + d[1,0] + sum(y[k]")
    [problem] = problems(wrong)
    assert (underlined(problem), problem.message) == ("d[1,0]", "no member 'd[1,0]' in potential")
    assert problem.hint == "'d[i,j]' has no members for these sizes"


def test_a_member_that_was_left_out_does_not_exist() -> None:
    pairs = "definitions: {'d[i in range(N), j in range(i)]': u[i] - u[j]}\npotential: "
    text = changed("potential: ", pairs)
    assert text_of(model(text.replace("u[i + 1] - u[i]", "d[i + 1,i]")).potential) == text_of(
        model(CHAIN).potential
    )
    [problem] = problems(text.replace("u[i + 1] - u[i]", "d[i,i]"))
    assert (underlined(problem), problem.message) == ("d[i,i]", "no member 'd[0,0]', for i = 0 in potential")
    assert "the members are d[1,0] to d[3,2]" in problem.hint


def test_yaml_brackets_of_an_index_just_work() -> None:
    flow = changed("  u[i in range(N)]: {initial: 0.1*i}", "  {u[i in range(N)]: {initial: m[i]}}")
    assert resolve_values(read_spec(flow, "a")).q == (1.0, 0.5, 2.0, 1.0)
    text = changed("[u[i], 0]", "[dot((u[i], 1), (1, m[i])), m[0]]")
    assert read_spec(text, "a").embedding["bead[2]"].text == "(dot((u[i], 1), (1, m[i])), m[0])"
    private = changed("sizes:", "description: '\ue000'\nsizes:").replace("[u[i], 0]", "(u[i], 0)")
    assert read_spec(private, "a").description == "\ue000"


def test_two_axes_of_one_size_have_names_of_their_own() -> None:
    text = changed(
        "  u[i in range(N)]: {initial: 0.1*i}",
        "  u[i in range(N)]: {initial: 0}\n  w[a in range(N), b in range(N)]: {}",
    )
    assert read_spec(text, "a").families["coordinates"]["w"].axes == ("N", "N_2")


POTENTIAL = "sum(k/2*(u[i + 1] - u[i])**2 for i in range(N - 1))"
COORDINATE = "  u[i in range(N)]: {initial: 0.1*i}"
LIST = "[1.0, 0.5, 2.0, 1.0]"

# what to replace, by what, then (line, underlined piece, part of the message, part of the hint) each
BAD = [
    # members
    ("u[i + 1]", "u[i + 2]", [(11, "u[i + 2]", "no member 'u[4]', for i = 2 in potential", "u[0] to u[3]")]),
    ("u[i + 1]", "u[i - 1]", [(11, "u[i - 1]", "no member 'u[-1]', for i = 0", "u[(i - 1) % N]")]),
    ("u[i + 1]", "u[N]", [(11, "u[N]", "no member 'u[4]', for N = 4", "the members are u[0] to u[3]")]),
    ("u[i + 1]", "u[i/2]", [(11, "i/2", "'/' is not allowed between whole numbers", "write //")]),
    ("u[i + 1]", "u[0.5]", [(11, "0.5", "0.5 is not a whole number", "")]),
    ("u[i + 1]", "u[k]", [(11, "k", "'k' is neither an index nor a size", "known: N, i")]),
    (
        "u[i + 1]",
        "u[k]",
        [(11, "k", "", "; sum(... for k in range(N)), or a key such as u[k in range(N)], makes it")],
    ),
    (
        "u[i + 1]",
        "u_{i + 1}",
        [
            (11, "u_", "unknown function 'u_'", "write u[...] for a member of a family"),
            (11, "{", "", ""),
            (11, "}", "", ""),
        ],
    ),
    ("u[i + 1]", "u", [(11, "u", "missing index on the family 'u'", "write u[i] for one")]),
    ("u[i + 1]", "u.vx", [(11, "u.vx", "missing index on the family 'u'", "write u_dot[i] for one")]),
    (
        "u[i + 1]",
        "u[0].vx",
        [(11, "u[0].vx", "the coordinate 'u' has no component", "u[i], or u_dot[i] for its")],
    ),
    (POTENTIAL, "sum(u[i] for i in 1..3)", [(11, "1..3", "an index needs a range", "range(N)")]),
    (
        "u[i + 1]",
        "u[i, 0]",
        [(11, "u[i, 0]", "wrong number of indices on 'u': 2 instead of 1", "write u[i]")],
    ),
    ("u[i + 1]", "k[i]", [(11, "k[i]", "'k' is not a family", "write k")]),
    ("u[i + 1]", "i[0]", [(11, "i[0]", "unknown name 'i'", "pi")]),
    ("u[i + 1]", "pi[0]", [(11, "pi[0]", "'pi' is a number: it takes no index", "write pi")]),
    ("u[i + 1]", "w[i]", [(11, "w[i]", "unknown name 'w'", "known: t, N, u[i], u_dot[i], m[i], k, bead[i]")]),
    ("u[i + 1]", "uu[i]", [(11, "uu[i]", "unknown name 'uu'", "did you mean 'u[i]'?")]),
    ("u[i + 1]", "u_j", [(11, "u_j", "unknown name 'u_j'", "did you mean 'u[j]'?")]),
    ("u[i + 1]", "bead[i].z", [(11, "bead[i].z", "no component 'z'", "bead[i].x, bead[i].y, bead[i].vx")]),
    ("u[i + 1]", "u_ddot[i]", [(11, "u_ddot[i]", "acceleration", "")]),
    (
        POTENTIAL,
        "u[0] + u[sum(1 for i in range(2))]",
        [(11, "sum(1 for i in range(2))", "expected a whole number", "")],
    ),
    # lists
    (
        LIST,
        "[1.0, 0.5]",
        [(8, "m[i]", "no member 'm[2]', for i = 2 in mass of 'bead[i]'", "the members are m[0] to m[1]")],
    ),
    (LIST, "[]", [(3, "[", "the list of parameter 'm' is empty", "")]),
    (LIST, "[1, [2]]", [(3, "[", "parameter 'm' is a list of lists", "")]),
    (LIST, "[1, qq, 3, 4]", [(3, "qq", "unknown name 'qq' in parameter 'm'", "")]),
    (LIST, "1.0", [(8, "m[i]", "'m' is not a family", "")]),
    (
        "m: [1",
        "m[i in range(N)]: [1",
        [(3, "m[i in range(N)]", "lists as members of the family 'm[i]'", "one expression")],
    ),
    # sizes
    ("{N: 4}", "{N: 0}", [(1, "0", "the value is 0 in size 'N'", "greater than 0")]),
    ("{N: 4}", "{N: 2.5}", [(1, "2.5", "2.5 is not a whole number in size 'N'", "")]),
    ("{N: 4}", "{N: k}", [(1, "k", "'k' is neither an index nor a size here in size 'N'", "")]),
    ("{N: 4}", "{N: M, M: N}", [(1, "N", "size 'N' depends on itself: N -> M -> N", "")]),
    ("{N: 4}", "{N: 1e99}", [(1, "1e99", "not a whole number", "")]),
    ("{N: 4}", "[4]", [(1, "[", "sizes must be", ""), (6, "N", "unknown size 'N' in 'u[i]'", "add 'sizes")]),
    ("sizes: {N: 4}\n", "", [(5, "N", "unknown size 'N' in 'u[i]'", "add 'sizes: {N: 10}'")]),
    ("{N: 4}", "{M: 4}", [(6, "N", "unknown size 'N'", "known: M")]),
    ("u[i in range(N)]: {", "u[k]: {", [(6, "k", "unknown size 'k'", "write u[k in range(N)]")]),
    ("u[i in range(N)]: {", "u[N]: {", [(6, "u[N]", "no member 'u[0]'", "as in u[i in range(N)]")]),
    ("u[i in range(N)]: {", "u[0..3]: {", [(6, "0..3", "not indices", "write u[i in range(N)]")]),
    ("{N: 4}", "{t: 4}", [(1, "t", "the name 't' is reserved", ""), (6, "N", "unknown size", "")]),
    (
        "{N: 4}",
        f"{{N: {MAX_MEMBERS + 1}}}",
        [(6, "u[i in range(N)]", f"more than {MAX_MEMBERS} members", "")],
    ),
    # keys
    (COORDINATE, COORDINATE.replace("N", "N - 4"), [(6, "i in range(N - 4)", "empty range for N = 4", "")]),
    (COORDINATE, COORDINATE.replace("N", "1, N"), [(6, "u[i in range(1, N)]", "has no member 'u[0]'", "")]),
    # a force on members of a family with a mistake is no further one
    (
        "  bead[i in range(N)]: [u[i], 0]",
        "  bead[i in range(1, N)]: [u[i], 0]\nforces: {'bead[i in range(1, N)]': [1, 0]}",
        [(10, "bead[i in range(1, N)]", "the family 'bead' has no member 'bead[0]'", "")],
    ),
    (COORDINATE, COORDINATE.replace("N", "-1, N"), [(6, "i in range(-1, N)", "negative index -1", "")]),
    (COORDINATE, COORDINATE.replace("i in", "t in"), [(6, "t", "the name 't' is reserved", "")]),
    (COORDINATE, COORDINATE.replace("range(N)", "N"), [(6, "N", "an index needs a range", "")]),
    (
        COORDINATE,
        COORDINATE.replace("]", ", j in range(i)]"),
        [(6, "u[i in range(N), j in range(i)]", "the family 'u' has no member 'u[0,0]'", "")],
    ),
    (
        COORDINATE,
        "  u[j in range(i), i in range(N)]: {}",
        [(6, "i", "the index 'i' is used before its range in 'u[j,i]'", "write its range first")],
    ),
    (
        COORDINATE,
        "  u[i in range(N), j in range(i - 1, 2)]: {}",
        [(6, "i in range(N)", "negative index -1 in 'u[i,j]'", "indices count from 0")],
    ),
    (
        COORDINATE,
        "  u[i in range(N) if i > N]: {}",
        [(6, "i in range(N) if i > N", "no members in 'u[i]'", "")],
    ),
    (
        COORDINATE,
        "  u[i in range(N) if i > k]: {}",
        [(6, "k", "'k' is a parameter in 'u[i]'", "under 'sizes'")],
    ),
    (
        COORDINATE,
        "  u[i in range(N) if u > i]: {}",
        [(6, "u", "'u' is a coordinate", "conditions of families")],
    ),
    (COORDINATE, COORDINATE + "\n  u[0]: {}", [(7, "u[0]", "'u[0]' is given twice", "in line 6")]),
    (
        COORDINATE,
        COORDINATE + "\n  u: {}",
        [(7, "u", "'u' and 'u[i]' have different numbers of indices", "")],
    ),
    (
        COORDINATE,
        COORDINATE + "\n  u[0, 0]: {}",
        [(7, "u[0, 0]", "different numbers of indices", "same number of indices")],
    ),
    (
        COORDINATE,
        "  - u[i in range(N)]\n  - u[i in range(N)]",
        [(7, "u[i in range(N)]", "is given twice", "")],
    ),
    ("k: 2.0", "k: 2.0\n  i: 3", [(7, "i in range(N)", "the index 'i' has the name of a parameter", "")]),
    ("k: 2.0", "N: 2.0", [(4, "N", "the parameter 'N' has the name of a size", "line 1"), (11, "k", "", "")]),
    # one mistake of all members
    (
        COORDINATE,
        COORDINATE.replace("0.1*i", "1/(i - 2)"),
        [(6, "1/(i - 2)", "division by zero, for i = 2", "")],
    ),
    (
        COORDINATE,
        COORDINATE.replace("0.1*i", "0.1*ii"),
        [(6, "ii", "unknown name 'ii' in initial of", "'i'")],
    ),
    (": m[i]", ": u[i]", [(8, "u[i]", "the coordinate 'u' cannot be used in mass of 'bead[i]'", "")]),
    (
        "  bead[i in range(N)]: m",
        "  bead[i in range(2)]: m",
        [(10, "bead[i in range(N)]", "'bead[2]' has a position", "in both")],
    ),
    (
        "  bead[i in range(N)]: m[i]",
        "  bead: m[0]",
        [(8, "bead", "", "in both"), (10, "bead[i in range(N)]", "", "")],
    ),
    (
        "[u[i], 0]",
        "[u[j], 0]",
        [(10, "j", "'j' is neither an index nor a size here in position of 'bead[i]'", "")],
    ),
    (
        "[u[i], 0]",
        "[sum(u[i] for i in range(2)), 0]",
        [(10, "i", "'i' is already used by an enclosing sum", "")],
    ),
    (
        "  bead[i in range(N)]: [u[i], 0]",
        "  bead[0]: [u[0], 0]\n  bead[i in range(1, N)]: u[i]",
        [(11, "bead[i in range(1, N)]", "'bead[1]' has 1 component, other members 2", "")],
    ),
    (
        "potential",
        "forces: {'bead[4]': [1, 2]}\npotential",
        [(11, "bead[4]", "unknown particle", "bead[0] to bead[3]")],
    ),
    ("potential", "forces: {bead: [1, 2]}\npotential", [(11, "bead", "unknown particle", "write bead[i]")]),
    (
        "potential",
        "forces: {'bead[i in range(9)]': [1, 2]}\npotential",
        [(11, "bead[i in range(9)]", "'bead[4]'", "")],
    ),
    ("potential", "forces: {'bead[i in range(N)]': [1]}\npotential", [(11, "1", "its position 2", "")]),
    (
        "potential",
        "generalized_forces: {'u[9]': 1}\npotential",
        [(11, "u[9]", "unknown coordinate 'u[9]'", "u[3]")],
    ),
    (
        "potential",
        "observables: {'e[i in range(2)]': bead[i]}\npotential",
        [(11, "bead[i]", "expected a scalar", "")],
    ),
    # circles
    (
        "potential",
        "definitions: {'x[i in range(3)]': x[i]}\npotential",
        [(11, "x[i in range(3)]", "x[0] -> x[0]", "")],
    ),
    (
        "potential",
        "definitions: {'x[i in range(3)]': x[(i + 1) % 3]}\npotential",
        [(11, "x[i in range(3)]", "depends on itself: x[0] -> x[1] -> x[2] -> x[0]", "")],
    ),
    (
        "potential",
        "definitions: {'x[i in range(2)]': y[i], 'y[i in range(2)]': x[i]}\npotential",
        [(11, "x[i in range(2)]", "depends on itself: x[0] -> y[0] -> x[0]", "")],
    ),
    ("m: [1", "m[i in range(N)]: m[i]\n  l: [1", [(3, "m[i in range(N)]", "m[0] -> m[0]", "")]),
    # sums
    (
        POTENTIAL,
        "sum(1 for i in range(10000000))",
        [(11, "sum(1 for i in range(10000000))", "terms in all", "")],
    ),
    (POTENTIAL, "sum(u[i] for N in range(2))", [(11, "N", "the index 'N' has the name of a size", "")]),
    (POTENTIAL, "sum(u[i] for i in range(N) if i > k)", [(11, "k", "'k' is neither", "")]),
    (
        POTENTIAL,
        "sum(bead[i] for i in range(N))",
        [(11, "sum(bead[i] for i in range(N))", "expected a scalar", "")],
    ),
    (POTENTIAL, "sum(1/(i - 2) for i in range(N))", [(11, "1/(i - 2)", "division by zero, for i = 2", "")]),
    (POTENTIAL, "sum(u[i] for i in range(0, 4, 0))", [(11, "0", "the step of a range must not be 0", "")]),
]


@pytest.mark.exhaustive(keep=33)
@pytest.mark.parametrize(
    ("old", "new", "expected"), BAD, ids=[f"{old[:12]}-{new[:40]}" for old, new, _ in BAD]
)
def test_mistake_is_shown_once_at_its_place(
    old: str, new: str, expected: list[tuple[int, str, str, str]]
) -> None:
    assert old in CHAIN
    found = problems(CHAIN.replace(old, new, 1))
    assert [problem.line for problem in found] == [line for line, _, _, _ in expected]
    for problem, (_, piece, message, hint) in zip(found, expected, strict=True):
        assert underlined(problem) == piece
        assert message in problem.message
        assert hint in problem.hint
        assert problem.hint


@pytest.mark.parametrize(
    ("old", "new", "line", "piece", "message"),
    [
        (LIST, "[1.0, -0.5, -2.0, 1.0]", 8, "m[i]", "the value -0.5 is not positive in mass of 'bead[1]'"),
        (
            COORDINATE,
            "  u[i in range(N)]: {}",
            6,
            "u[i in range(N)]",
            "coordinate 'u[0]' has no initial value",
        ),
        (
            COORDINATE,
            COORDINATE.replace("0.1*i", "sqrt(1 - m[i])"),
            6,
            "sqrt(1 - m[i])",
            "not a real number, for i = 2",
        ),
        (LIST, "[1, 1/(k - 2), 1/(k - 2), 1]", 3, "1/(k - 2)", "division by zero in parameter 'm[1]'"),
    ],
)
def test_what_has_no_value_is_shown_at_its_place(
    old: str, new: str, line: int, piece: str, message: str
) -> None:
    with pytest.raises(SpecError) as caught:
        resolve_values(read_spec(changed(old, new), "a.yaml"))
    problem = caught.value.problems[0]
    assert (problem.line, underlined(problem)) == (line, piece)
    assert message in problem.message
    places = [(one.line, one.column) for one in caught.value.problems]
    assert len(set(places)) == len(places)


WORDS = [
    "[",
    "]",
    "(",
    ")",
    " for ",
    " in ",
    " if ",
    "range(N)",
    "i",
    "N",
    "u[i]",
    "m",
    "0",
    "-",
    "//",
    "%",
    ",",
]
WORDS += [
    ":",
    "{",
    "}",
    "sum(",
    "bead",
    "\n  ",
    "1",
    "1e9",
    "not ",
    "!=",
    "== ",
    "<",
    ".x",
    ".vx",
    "_dot",
    "'",
]


@pytest.mark.exhaustive(keep=0)
@examples(100)
@given(st.integers(0, 10**9), st.integers(1, 3))
def test_no_typing_slip_does_worse_than_a_spec_error(seed: int, slips: int) -> None:
    text, source = PIECES if seed % 2 else CHAIN, random.Random(seed)
    for _ in range(slips):
        start = source.randrange(len(text))
        text = text[:start] + source.choice(WORDS) + text[start + source.choice([0, 0, 1, 2, 5]) :]
    try:
        spec: Spec = read_spec(text, "slip.yaml")
        resolve_values(spec)
    except SpecError as error:
        assert error.problems and str(error)
    else:
        assert build_model(spec, GraphAlgebra()).coordinates


@pytest.mark.parametrize(
    ("potential", "besides"),
    [
        ("bob[0].vix", ["the particle 'bob' has no component 'vix' in potential"]),
        ("bob[1].vix", ["the particle 'bob' has no component 'vix' in potential"]),
        ("bob[0].z", []),
        ("bob[0].vx", []),
    ],
)
def test_a_component_beside_a_wrong_member_is_left_to_the_member(potential: str, besides: list[str]) -> None:
    """One member of bob is wrong, and so may be what is asked of another; not so where no particle has it."""
    text = f"""
sizes: {{N: 2}}
parameters: {{m: [1.0, 2.0]}}
coordinates: {{"q[i in range(N)]": {{initial: 0}}}}
masses: {{"bob[i in range(N)]": 1}}
embedding: {{"bob[i in range(N)]": ["q[i]", "m[i + 1]"]}}
potential: {potential}
"""
    with pytest.raises(SpecError) as caught:
        read_spec(text, "system.yaml")
    assert [problem.message for problem in caught.value.problems] == [
        "no member 'm[2]', for i = 1 in position of 'bob[i]'",
        *besides,
    ]


def test_a_size_among_the_parameters_is_called_that():
    found = problems(
        "parameters: {N: 4}\ncoordinates: {x[i in range(N)]: {initial: 0}}\nlagrangian: x_dot[0]**2\n"
    )
    assert found[0].hint == "ranges are made of indices and sizes: declare 'N' under 'sizes' instead"


def test_a_size_in_the_other_case_is_not_taken_for_a_unit() -> None:
    text = "sizes: {n: 4}\ncoordinates: {x[i in range(N)]: {initial: 0}}\nlagrangian: x_dot[0]**2\n"
    with pytest.raises(SpecError) as caught:
        read_spec(text, "file.yaml")
    assert caught.value.problems[0].hint == "did you mean 'n'?"

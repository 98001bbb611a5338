"""Families that are kept whole: what is found for all members at once is what each of them has by itself."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable, Sequence
from itertools import product
from textwrap import dedent
from types import FrameType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.syntax import Tree
from lagrange_cli.families.system import family_system
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import key_of
from lagrange_cli.spec import evaluation, names
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.family import Grid, Listed, MemberNames
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.repeated import common
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.together import Together
from lagrange_cli.spec.values import Values, resolve_values
from lagrange_cli.spec.whole import Part
from tests.support.command import SYSTEMS
from tests.support.draws import examples

FAMILIES = """\
sizes: {N: 7, M: 3}
parameters:
  g: 9.81
  k[i in range(N)]: 1 + 0.1*i
  w: [1.0, 0.5, 2.0]
  s: sum(k[i]*w[i % M] for i in range(N) if i != 2)
  r[i in range(N)]: where(i < M, s/(i + 1), r[i - 1]*0.5)
  h[i in range(N)]: where(k[i] > 1.25 and i < 6, sqrt(k[i] - 1.25), min(k[i], 1/(i + 1)))
coordinates:
  x[i in range(N)]: {initial: sin(0.3*k[i]) + d[i]**2, velocity: "where(i < 3, w[i % 3], sqrt(2)*i)"}
  u[i in range(N), j in range(M)]: {initial: exp(-((i - N//2)**2 + 30*j)**2), velocity: -tan(i)*j/7}
  v[0]: {initial: sum(sum(atan2(i, j + 1) for j in range(i)) for i in range(N))}
  v[i in range(1, N, 2)]: {initial: pi**i}
  v[i in range(2, N, 2)]: {initial: -k[i]}
  z: {initial: r[N - 1]}
definitions:
  d[i in range(N - 1, -1, -1)]: k[i]/(3*N)
  c[0]: k[0]
  c[i in range(1, N)]: c[i - 1] + k[i]
masses:
  p[i in range(N)]: c[i]*d[i]
embedding:
  p[i in range(N)]: [x[i] + z, 0]
potential: sum(u[i, j]**2 for i in range(N) for j in range(M)) + sum(v[i]**2 for i in range(N))
  + sum(where(abs(x[i] - x[j]) < h[j] or i > j, h[i]*x[i], i) for i in range(N) for j in range(N))
forces:
  p[i in range(1, N, 2)]: [-p[i].vx, 0]
"""
RECURSIVE = """\
sizes: {N: 7}
parameters:
  m: 1.0
  g: 9.81
  l[i in range(N)]: 1 + 0.1*i
  s[0]: l[0]
  s[i in range(1, N)]: s[i - 1] + l[i]
coordinates:
  theta[i in range(N)]: {initial: 0.1*s[i]}
definitions:
  x[0]: l[0]*sin(theta[0])
  x[i in range(1, N)]: x[i - 1] + l[i]*sin(theta[i])
  y[i in range(1, N)]: y[i - 1] - l[i]*cos(theta[i])
  y[0]: -l[0]*cos(theta[0])
masses:
  bob[i in range(N)]: m
positions:
  bob[i in range(N)]: [x[i], y[i]]
potential: sum(m*g*bob[i].y for i in range(N))
"""
ALONE, TOGETHER = 10**9, 2


def counted(work: Callable[[], Any]) -> tuple[int, Any]:
    """How many functions are called, of Python and of C, and what comes of it."""
    calls = 0

    def note(frame: FrameType, event: str, argument: object) -> None:
        nonlocal calls
        calls += event in ("call", "c_call")

    gc.disable()  # it would call what hypothesis has it call
    sys.setprofile(note)
    try:
        found = work()
    finally:
        sys.setprofile(None)
        gc.enable()
    return calls, found


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    ("system", "few", "many"),
    [
        ("fpu_chain", {"N": "1200"}, {"N": "4800"}),
        ("lattice", {"N": "100", "M": "12"}, {"N": "110", "M": "44"}),
        ("n_pendulum", {"N": "150"}, {"N": "3000"}),
        ("recursive", {"N": "150"}, {"N": "3000"}),
    ],
)
def test_reading_and_deriving_take_the_same_calls_however_many_members_there_are(
    system: str, few: dict[str, str], many: dict[str, str]
) -> None:
    text = RECURSIVE if system == "recursive" else (SYSTEMS / f"{system}.yaml").read_text()
    run = Compilation("taylor", 2.0**-52, frozenset({"q", "v", "h"}))

    def calls(sizes: dict[str, str]) -> list[int]:
        reading, spec = counted(lambda: read_spec(text, system, sizes))
        values, _ = counted(lambda: resolve_values(spec))
        deriving, found = counted(lambda: family_system(spec))
        assert found is not None
        return [reading, values, deriving, counted(lambda: key_of(spec, run))[0]]

    calls(few)  # what is imported, and remembered
    for one, other in zip(calls(few), calls(many), strict=True):
        assert abs(one - other) <= 5


def read(text: str, many: int, monkeypatch: pytest.MonkeyPatch, **sizes: str) -> Spec:
    """The system where so many members are treated together."""
    monkeypatch.setattr(names, "MANY", many)
    monkeypatch.setattr(evaluation, "MANY", many)
    return read_spec(text, "a.yaml", sizes)


PAIRS = """\
sizes: {{N: 16}}
coordinates: {{"x[i in range(N)]": {{initial: i}}}}
masses: {{"a[i in range(N)]": 1}}
embedding: {{"a[i in range(N)]": "x[i]"}}
definitions:
  {key}: {value}
  "d[i in range(N), j in range(i)]": (x[i] - x[j])**2
potential: sum(w[{place}]*d[i, j]/(w[{place}] - {zero}) for i in range(N) for j in range(i))
"""
KEYS = [
    ("w[i in range(N), j in range(i)]", "i, j", "1/15"),
    ("w[i in range(N), j in range(N) if i != j]", "j, i", "(-1/15)"),
    ("w[j in range(N), i in range(j - 1, -1, -1)]", "i, j", "(-1/15)"),
    ("w[i in range(1000000, 1000000 + N), j in range(1000000, i)]", "i + 1000000, j + 1000000", "1/15"),
    ("w[i in range(4000000000, 4000000000 + N), j in range(4000000000, i)]",
     "i + 4000000000, j + 4000000000", "1/15"),
]  # fmt: skip


@pytest.mark.parametrize(("key", "place", "zero"), KEYS)
def test_numbers_of_pairs_are_known_wherever_they_are_used(key: str, place: str, zero: str) -> None:
    """A divisor that is 0 for one pair is found when the file is read, and others are no mistake."""
    text = PAIRS.format(key=f'"{key}"', value="1/(3*i - 3*j)", place=place, zero="ZERO")
    read_spec(text.replace("ZERO", "1"), "a.yaml")
    with pytest.raises(SpecError, match=r"division by zero, for i = 5, j = 0 in potential"):
        read_spec(text.replace("ZERO", zero), "a.yaml")


@pytest.mark.exhaustive(keep=0.7)
def test_reading_pairs_takes_few_calls_for_each() -> None:
    text = PAIRS.format(key='"w[i in range(N), j in range(i)]"', value="1/(i - j)", place="i, j", zero="2")

    def calls(size: str) -> int:
        return counted(lambda: read_spec(text, "a.yaml", {"N": size}))[0]

    calls("60")  # what is imported
    assert calls("120") - calls("60") <= 100 * (7140 - 1770)  # of two families


@pytest.mark.parametrize("count", [90, 130])
def test_a_divisor_that_is_0_for_one_member_is_found(count: int) -> None:
    """However many there are, and members with numbers are not taken for others."""
    text = """\
    coordinates: {"x[i in range(N)]": {initial: i}}
    masses: {"a[i in range(N)]": 1}
    embedding: {"a[i in range(N)]": "x[i]"}
    definitions: {"w[i in range(N)]": 1/(i + 1)}
    potential: sum(x[i]**2/(w[i] - 0.25) for i in range(N))
    """
    with pytest.raises(SpecError, match=r"division by zero, for i = 3 in potential"):
        read_spec(f"sizes: {{N: {count}}}\n{dedent(text)}", "a.yaml")


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("sizes", [{}, {"N": "8", "M": "2"}, {"N": "3", "M": "1"}])
@pytest.mark.parametrize("given", [{}, {"x[0]": "k[0]/3", "u_dot[0,0]": "1e-3", "g": "2"}, {"k[0]": "g*7"}])
def test_numbers_found_together_are_those_found_one_by_one(
    sizes: dict[str, str], given: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    found: list[Values] = []
    together: list[object] = []
    of_part = Together.of_part

    def noted(self: Together, tree: Tree, part: Part[Any]) -> Any:
        together.append(of_part(self, tree, part))
        return together[-1]

    monkeypatch.setattr(Together, "of_part", noted)
    for many in (ALONE, TOGETHER):
        found.append(resolve_values(read(FAMILIES, many, monkeypatch, **sizes), given))
    assert sum(one is not None for one in together) >= 7, "members have been evaluated one by one"
    one, other = ([*x.parameters.items(), *enumerate((*x.q, *x.v))] for x in found)
    assert [(name, x.hex()) for name, x in one] == [(name, x.hex()) for name, x in other]


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("sin(0.3*k[i])", "sin(0.3*q[i])", "unknown name 'q'"),
        ("sin(0.3*k[i])", "1/(i - 5)", "division by zero, for i = 5"),
        ("sin(0.3*k[i])", "log(3 - i)", "log(0) is not a real number"),
        ("pi**i", "(1, 2)", "expected a scalar in initial of coordinate 'v[i]', found a vector"),
        ("sin(0.3*k[i])", "x[i]", "the coordinate 'x' cannot be used"),
        ("1 + 0.1*i", "1/(i - 3)", "division by zero, for i = 3"),
        ("1 + 0.1*i", "exp(800*i)", "number too large"),
        ("1 + 0.1*i", "k[N - 1 - i]", "depends on itself: k[0] -> k[6] -> k[0]"),
        ("1 + 0.1*i", "w[i]", "no member 'w[3]', for i = 3"),
        ("k[i]/(3*N)", "d[i + 1]", "no member 'd[7]'"),
        ("k[i]/(3*N)", "k[i]/(i - 4)", "division by zero, for i = 4"),
        ("k[i]/(3*N)", "(k[i], 1)", "a vector cannot stand in a power"),
        ("c[i - 1] + k[i]", "c[i] + k[i]", "depends on itself: c[1] -> c[1]"),
        ("c[i]*d[i]", "d[i]*(3 - i)", "the value 0 is not positive in mass of 'p[3]'"),
        ("c[i]*d[i]", "x[i]", "the coordinate 'x' cannot be used"),
        ("[x[i] + z, 0]", "[x[i + 1] + z, 0]", "no member 'x[7]', for i = 6"),
        ("[x[i] + z, 0]", "[x[i], 0, 0, 1]", "components"),
        ("p[i in range(1, N, 2)]: [", "p[i in range(1, N + 1, 2)]: [", "unknown particle 'p[7]' in forces"),
        ("[-p[i].vx, 0]", "-p[i].vx", "has 1 component, its position 2"),
        ("v[i in range(2, N, 2)]", "v[i in range(4, N, 2)]", "the family 'v' has no member 'v[2]'"),
        ("v[i in range(2, N, 2)]", "v[i in range(N - 1, 0, -1)]", "'v[5]' is given twice"),
        ("p[i in range(N)]: c", "p[i in range(1, N)]: c", "the family 'p' has no member 'p[0]'"),
        ("p[i in range(N)]: [", "p[i in range(N - 2)]: [", "the particle 'p[5]' has a mass but no position"),
        ("i % M", "i", "no member 'w[3]', for i = 3"),
        ("{initial: r[N - 1]}", "{initial: r[N]}", "no member 'r[7]'"),
        ("[i in range(N)]: 1 + 0.1*i", "[g in range(N)]: 1", "the index 'g' has the name of a parameter"),
        ("d[i in range(N - 1, -1, -1)]: k[i]", "d[i in range(N)]: d[0]", "d[0] -> d[0]"),
    ],
)
def test_mistakes_are_the_same_at_their_first_member(
    old: str, new: str, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert FAMILIES.count(old) >= 1
    said = []
    for many in (ALONE, TOGETHER):
        with pytest.raises(SpecError) as caught:
            resolve_values(read(FAMILIES.replace(old, new), many, monkeypatch))
        said.append(str(caught.value))
    assert message in said[0]
    assert said[0] == said[1]


def test_a_section_is_a_sequence_and_a_mapping_of_its_members() -> None:
    spec = read_spec(FAMILIES, "a.yaml")
    listed = [*spec.coordinates]
    assert len(spec.coordinates) == len(listed) == 7 + 21 + 7 + 1
    assert [one.name for one in listed[:2]] == ["x[0]", "x[1]"] and listed[-1].name == "z"
    assert [spec.coordinates[k] for k in range(len(listed))] == listed
    assert spec.coordinates[-3:] == listed[-3:]
    known = names_of(spec.coordinates)
    assert [*known] == [one.name for one in listed] and [known[k] for k in range(36)] == [*known]
    assert "v[6]" in known and "v[7]" not in known and "v" not in known and "v[06]" not in known
    assert list(spec.masses) == [f"p[{i}]" for i in range(7)] == list(dict(spec.masses.items()))
    assert [one.indices for one in spec.embedding.values()] == [{"i": i} for i in range(7)]
    assert "p[7]" not in spec.embedding and spec.embedding.get("q") is None
    assert list(spec.forces["forces"]) == ["p[1]", "p[3]", "p[5]"]
    assert list(spec.definitions)[-7:] == [f"c[{i}]" for i in range(7)]


def test_families_that_follow_from_each_other_may_be_one_of_vectors() -> None:
    pair = RECURSIVE.replace("x[i - 1] + l[i]", "x[i - 1] + 0*y[i - 1] + l[i]").replace(
        "y[i - 1] - l[i]", "y[i - 1] - 0*x[i - 1] - l[i]"
    )
    with pytest.raises(
        SpecError, match=r"computed one after the other: x -> y -> x.*\n.*\n.*write them as one family"
    ):
        read_spec(pair, "a.yaml")
    start, end = RECURSIVE.index("  x[0]"), RECURSIVE.index("masses:")
    vectors = """\
  r[0]: (l[0]*sin(theta[0]), -l[0]*cos(theta[0]))
  r[i in range(1, N)]: (r[i - 1].x + l[i]*sin(theta[i]), r[i - 1].y - l[i]*cos(theta[i]))
"""
    text = (RECURSIVE[:start] + vectors + RECURSIVE[end:]).replace("[x[i], y[i]]", "r[i]")
    system = family_system(read_spec(text, "a.yaml", {"N": "200"}))
    assert system is not None and system.joints is not None


def test_members_that_follow_from_later_ones_come_after_them() -> None:
    text = FAMILIES.replace("c[0]: k[0]", "c[N - 1]: k[0]").replace(
        "c[i in range(1, N)]", "c[i in range(N - 1)]"
    )
    spec = read_spec(text.replace("c[i - 1]", "c[i + 1]"), "a.yaml")
    assert list(spec.definitions)[-7:] == [f"c[{i}]" for i in reversed(range(7))]
    assert resolve_values(spec).q[0] == resolve_values(read_spec(FAMILIES, "a.yaml")).q[0]


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize(
    "statements",
    [
        {"c[0]": "k[1]/3", "c[i in range(1, N)]": "c[i - 1] + k[i]/7 - sin(i)"},
        {"c[i in range(N - 1)]": "k[i]/7 + c[i + 1] + 1", "c[N - 1]": "k[1]/3"},
        {"c[0]": "k[1]/3", "c[1]": "2", "c[i in range(2, N)]": "c[i - 1] + c[i - 2]"},
        {"c[i in range(N)]": "where(i < 2, k[i], c[i - 1] + k[i])"},
        {"c[0]": "1", "c[i in range(1, N)]": "sum(c[j]/N for j in range(i)) + k[i]"},
        {"c[0]": "1", "c[i in range(1, N, 2)]": "c[i - 1] + k[i]", "c[i in range(2, N, 2)]": "c[i - 1] + 1"},
        {"c[0]": "1", "c[N - 1]": "c[1]", "c[1]": "c[0]*2", "c[i in range(2, N - 1)]": "k[i] - 1 + c[i - 1]"},
        {"c[0]": "1", "c[i in range(1, 4)]": "c[i - 1] + k[1]", "c[i in range(4, N)]": "c[i - 1] - k[0]"},
        {"c[0]": "1", "c[i in range(1, N)]": "exp(-c[i - 1])*k[i]"},
        {"c[i in range(N), j in range(1, 5)]": "c[i, j - 1] + k[i]/(3 + j)", "c[i in range(N), 0]": "k[i]"},
        {"c[i in range(1, N), j in range(5)]": "c[i - 1, j] + k[i]/(3 + j)", "c[0, j in range(5)]": "j"},
        {"c[i in range(N - 1), j in range(5)]": "k[j] + c[i + 1, j]", "c[N - 1, j in range(5)]": "j/7"},
        {
            "c[0, j in range(5)]": "1/3",
            "c[i in range(1, N), 0]": "1",
            "c[i in range(1, N), j in range(1, 5)]": "c[i - 1, j] + c[i, j - 1]*k[i]",
        },
        # mistakes
        {"c[i in range(N)]": "c[i - 1] + k[i]"},
        {"c[0]": "1", "c[i in range(1, N)]": "c[i] + k[i]"},
        {"c[0]": "1", "c[i in range(1, N)]": "c[N - i] + k[i]"},
        {"c[0]": "0", "c[i in range(1, N)]": "c[i - 1] + k[i]/c[i - 1]"},
        {"c[0]": "1", "c[i in range(1, N)]": "c[i - 1] + k[i]/(i - 3)"},
        {"c[0]": "k[0]", "c[i in range(1, N)]": "c[i - 1]*c[i - 1]*c[i - 1] + 1"},
        {"c[0]": "k[0]", "c[i in range(1, N)]": "sin(c[i - 1])"},
        {"c[0]": "c[N - 1]", "c[i in range(1, N)]": "c[i - 1] + k[i]"},
        {"c[0]": "1", "c[i in range(1, N)]": "c[i - 1] + q[i]"},
        {"c[0]": "k[0]", "c[i in range(1, N)]": "(c[i - 1], 1)"},
        {"c[0]": "(1, k[0])", "c[i in range(1, N)]": "c[i - 1] + (1, 2)"},
        {"c[0]": "(1, k[0])", "c[i in range(1, N)]": "c[i - 1] + 2"},
        {"c[0]": "1e308", "c[i in range(1, N)]": "c[i - 1] + k[1]*9e307"},
        {"c[1]": "1", "c[i in range(2, N)]": "c[i - 1] + k[i]"},
    ],
)
@pytest.mark.parametrize("section", ["definitions", "parameters"])
@pytest.mark.parametrize("given", [{}, {"k[1]": "7"}])
def test_members_that_follow_from_others_are_those_found_one_by_one(
    statements: dict[str, str], section: str, given: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    last = "c[N - 1, 4]" if any("," in key for key in statements) else "c[N - 1]"
    last += ".x" * any("(1, k" in value for value in statements.values())
    parts = {
        "parameters": {"k[i in range(N)]": "1 + i/100"} | (statements if section == "parameters" else {}),
        "coordinates": {"x": f"{{initial: '{last}'}}"},
        "definitions": {"d": "0"} | (statements if section == "definitions" else {}),
    }
    text = "sizes: {N: 120}\nlagrangian: x_dot**2 + d\n" + "".join(
        f"{key}:\n" + "".join(f"  {name}: {value}\n" for name, value in entries.items())
        for key, entries in parts.items()
    )
    found: list[object] = []
    for many in (ALONE, TOGETHER):
        try:
            spec = read(text, many, monkeypatch)
            values = resolve_values(spec, given)
        except SpecError as error:
            found.append(str(error))
        else:
            order = [*spec.definitions, *names_of(spec.parameters)]
            found.append([order, values.q[0].hex(), *(x.hex() for x in values.parameters.values())])
    assert found[0] == found[1]


RANGES = st.builds(
    range, st.integers(-3, 12), st.integers(-3, 12), st.sampled_from([-4, -3, -2, -1, 1, 2, 3, 5])
)
FILLED = st.builds(
    lambda start, count, step: range(start, start + count * step, step),
    st.integers(-3, 12), st.integers(1, 9), st.sampled_from([1, 2, 3, 5]),
)  # fmt: skip


@given(RANGES, RANGES.filter(lambda one: one.step > 0))
def test_the_first_number_that_two_ranges_have_in_common(one: range, other: range) -> None:
    assert next(common(one, other), None) == next((x for x in one if x in other), None)


@examples(40)
@given(st.lists(FILLED, min_size=1, max_size=3))
def test_places_of_a_grid_are_numbered_in_order(ranges: Sequence[range]) -> None:
    places = [*product(*ranges)]
    for one in (Grid(tuple(ranges)), Listed(places)):
        assert [*one] == places == [one[k] for k in range(len(one))]
        assert [one.number(place) for place in places] == [*range(len(places))]
        assert one.number(tuple(values[-1] + 1 for values in ranges)) is None
        members = MemberNames("u", one)
        assert [members.number(name) for name in members] == [*range(len(places))]
        assert [members[k] for k in range(len(places))] == [*members]

"""What a right file is read as; YAML's traps either work or get a hint."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.numbers import evaluate
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.syntax import Span, Vector, names
from lagrange_cli.spec import nodes
from lagrange_cli.spec.declarations import COORDINATE, PARAMETER
from lagrange_cli.spec.order import dependency_order
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.settings import SOLVE, TIME
from lagrange_cli.spec.values import resolve_values
from tests.support.draws import examples
from tests.support.files import PENDULUM, changed

SYSTEMS = sorted(Path(__file__).parents[2].glob("systems/*.yaml"))


@pytest.mark.exhaustive(keep=21)
@pytest.mark.parametrize("path", SYSTEMS, ids=lambda path: path.stem)
def test_every_shipped_system_is_right(path: Path) -> None:
    spec = read_spec(path.read_bytes(), path.name)
    assert spec.coordinates
    assert (spec.lagrangian is None) == bool(spec.embedding)
    assert spec.masses.keys() == spec.embedding.keys()


def test_sections_become_fields() -> None:
    text = PENDULUM + (
        "definitions: {speed: l*theta_dot, at: [1, 2]}\n"
        "forces: {bob: (-c*bob.vx, 0)}\n"
        "generalized_forces: {theta: -speed}\n"
        "dissipation: c*theta_dot**2/2\n"
        "observables: {height: bob.y + at.x}\n"
        "solve: {start: 1, stop: 2*pi, samples: 11, method: taylor, tolerance: 1e-9, outputs: [T, U]}\n"
    )
    spec = read_spec(
        text.replace("  m: 1\n", "  m: {value: 2*c, unit: kg, description: of the bob}\n  c: 0.1\n"), "a.yaml"
    )
    assert [parameter.name for parameter in spec.parameters] == ["c", "m", "l", "g"]
    assert spec.parameters[1].unit == "kg"
    assert spec.parameters[1].description == "of the bob"
    assert spec.coordinates[0].initial is not None
    assert spec.coordinates[0].velocity is None
    assert list(spec.definitions) == ["speed", "at"]
    assert isinstance(spec.forces["forces"]["bob"].tree, Vector)
    assert list(spec.potential) == ["potential"]
    assert spec.solve.start == 1
    assert spec.solve.stop == pytest.approx(6.283185307179586, rel=1e-15)
    assert spec.solve.samples == 11
    assert spec.solve.outputs == ("T", "U")
    assert spec.solve.tolerance == 1e-9


def test_name_defaults_to_the_stem() -> None:
    assert read_spec(changed("name: pendulum\n", ""), "some/where.yaml").name == "where"
    assert read_spec(changed("name: pendulum\n", ""), "-").name == "system"


def test_potential_terms_are_kept_apart() -> None:
    spec = read_spec(changed("m*g*bob.y", "{gravity: m*g*bob.y, spring of l: l*theta**2}"), "a")
    assert list(spec.potential) == ["gravity", "spring of l"]


@pytest.mark.parametrize(
    ("written", "expected"), [("no", 2.0), ("y", 2.0), ("on", 2.0), ("NO", 2.0), ("null_", 2.0)]
)
def test_yaml_words_are_names(written: str, expected: float) -> None:
    spec = read_spec(f"parameters: {{{written}: 2}}\ncoordinates: [x]\nlagrangian: {written}*x", "a")
    assert spec.parameters[0].name == written
    assert evaluate(spec.parameters[0].value.tree) == expected


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("1e-3", 1e-3),
        ("1E5", 1e5),
        (".5", 0.5),
        ("1.", 1.0),
        ("-2", -2.0),
        ("+3", 3.0),
        ("'1.5'", 1.5),
        ("010.5", 10.5),
    ],
)
def test_numbers_mean_what_they_say(written: str, value: float) -> None:
    spec = read_spec(changed("9.81", written), "a")
    assert evaluate(spec.parameters[-1].value.tree) == value


@pytest.mark.parametrize(
    "embedding",
    [
        "[l*sin(theta), -l*cos(theta)]",
        "(l*sin(theta), -l*cos(theta))",
        "l*sin(theta), -l*cos(theta)",
        "'[l*sin(theta), -l*cos(theta)]'",
        "\n    - l*sin(theta)\n    - -l*cos(theta)",
        "[l*sin(theta),\n   -l*cos(theta)]",
        "l*(sin(theta), -cos(theta))",
        ">\n   (l*sin(theta),\n    -l*cos(theta))",
    ],
)
def test_a_vector_may_be_written_in_many_ways(embedding: str) -> None:
    plain = read_spec(PENDULUM, "a").embedding["bob"]
    spec = read_spec(changed("[l*sin(theta), -l*cos(theta)]", embedding), "a")
    found = spec.embedding["bob"]
    assert [name.identifier for name in names(found.tree) if name.identifier != "l"] == ["theta", "theta"]
    if isinstance(found.tree, Vector):
        assert len(found.tree.items) == len(plain.tree.items) == 2  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("flow", "items"),
    [
        ("[atan2(l, m), theta]", ["atan2(l, m)", "theta"]),
        ("[atan2(l, atan2(m, 1)), atan2(theta, 1)]", ["atan2(l, atan2(m, 1))", "atan2(theta, 1)"]),
        ("[theta, dot((l, m), (m, l))]", ["theta", "dot((l, m), (m, l))"]),
    ],
)
def test_commas_inside_parentheses_do_not_split(flow: str, items: list[str]) -> None:
    found = read_spec(changed("[l*sin(theta), -l*cos(theta)]", flow), "a").embedding["bob"]
    assert isinstance(found.tree, Vector)
    assert [found.text[item.span.start : item.span.stop] for item in found.tree.items] == items
    for item, text in zip(found.tree.items, items, strict=True):
        place = found.at(item.span)
        assert (
            PENDULUM.replace("[l*sin(theta), -l*cos(theta)]", flow)
            .splitlines()[place.line - 1][place.column - 1 :]
            .startswith(text)
        )


def test_commas_inside_parentheses_do_not_split_mappings() -> None:
    text = (
        PENDULUM.replace("  bob: m", "  {bob: atan2(m, l), }")
        .replace("  bob: [", "  {bob: (")
        .replace(")]", "))}")
    )
    spec = read_spec(text, "a")
    assert spec.masses["bob"].text == "atan2(m, l)"
    assert spec.embedding["bob"].text == "(l*sin(theta), -l*cos(theta))"


def test_aliases_and_documents_and_byte_order_marks_work() -> None:
    text = "---\n" + changed("9.81", "&g 9.81").replace("initial: 0.1", "initial: *g") + "...\n"
    spec = read_spec(b"\xef\xbb\xbf" + text.encode(), "a")
    assert spec.coordinates[0].initial is not None
    assert spec.coordinates[0].initial.text == "9.81"


def test_windows_line_ends_and_tabs_between_values_work() -> None:
    text = changed("g: 9.81", "g:\t9.81").replace("\n", "\r\n")
    assert read_spec(text.encode(), "a").parameters[-1].value.text == "9.81"


def test_a_mass_may_use_a_definition_that_comes_down_to_parameters() -> None:
    spec = read_spec(changed("  bob: m", "  bob: total") + "definitions: {total: 2*m}\n", "a")
    assert spec.masses["bob"].text == "total"


def test_without_the_compiled_parser_the_same_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = read_spec(PENDULUM, "a")
    monkeypatch.delattr(yaml, "CSafeLoader")
    assert read_spec(PENDULUM, "a") == compiled


def test_expressions_know_their_place() -> None:
    spec = read_spec(PENDULUM, "a")
    expression = spec.embedding["bob"]
    assert expression.text == "(l*sin(theta), -l*cos(theta))"
    start = expression.text.index("-l*cos")
    place = expression.at(Span(start + 1, start + 2))
    assert (place.line, place.column, place.length) == (11, 24, 1)


@pytest.mark.exhaustive(keep=0.3)
@given(st.dictionaries(st.sampled_from("abcdefgh"), st.lists(st.sampled_from("abcdefgh"), max_size=3)))
def test_dependency_order_puts_used_names_first(uses: dict[str, list[str]]) -> None:
    order, cycles = dependency_order(uses)
    for position, name in enumerate(order):
        assert {used for used in uses[name] if used in uses} <= set(order[:position])
    assert bool(cycles) == (len(order) < len(uses))
    for cycle in cycles:
        assert cycle[0] == cycle[-1]
        assert all(later in uses[earlier] for earlier, later in pairwise(cycle))


PIECES = [
    "  ",
    "\n",
    ": ",
    "[",
    "]",
    "{",
    "}",
    "&a ",
    "*a",
    "- ",
    "'",
    '"',
    "|\n",
    "(",
    ")",
    ",",
    "theta",
    "bob.x",
]
PIECES += ["**", "\t", "#", "!", "? ", "<<: ", "---\n", "θ", "9", "lagrangian: ", "~"]
FRAGMENTS = st.sampled_from([*PENDULUM.splitlines(keepends=True), *PIECES])


@settings(max_examples=100, deadline=None)
@given(
    st.one_of(st.binary(max_size=200), st.text(max_size=200), st.lists(FRAGMENTS, max_size=30).map("".join))
)
def test_no_file_does_worse_than_a_spec_error(data: bytes | str) -> None:
    try:
        read_spec(data, "fuzz.yaml")
    except SpecError as error:
        assert error.problems
        assert str(error)


@pytest.mark.exhaustive(keep=0)
@examples(100)
@given(st.integers(0, len(PENDULUM)), st.integers(0, 8), st.text(max_size=4) | FRAGMENTS)
def test_no_typing_slip_does_worse_than_a_spec_error(start: int, length: int, typed: str) -> None:
    text = PENDULUM[:start] + typed + PENDULUM[start + length :]
    try:
        spec = read_spec(text, "slip.yaml")
        resolve_values(spec)
    except SpecError as error:
        assert all(problem.message for problem in error.problems)
    else:
        assert all(parse(term.text) == term.tree for term in spec.potential.values())


@pytest.mark.parametrize(
    "time", ["time: d", "time: {unit: d}", "solve: {unit: d}", "time: d\nsolve: {unit: d}"]
)
def test_the_unit_of_t_may_stand_in_either_place(time):
    assert read_spec(f"{PENDULUM}{time}\n", "a.yaml").time_unit == "d"


@pytest.mark.parametrize("time", ["", "time:", "time: {}", "solve: {unit: }", "time: {unit: }"])
def test_the_unit_of_t_need_not_be_given(time):
    assert read_spec(f"{PENDULUM}{time}\n", "a.yaml").time_unit == ""


@pytest.mark.parametrize(
    "table", [SECTIONS, PARAMETER, COORDINATE, SOLVE, TIME], ids=lambda table: table.name
)
def test_every_key_has_a_meaning_and_no_word_stands_for_two(table):
    assert all(row.meaning for row in table.rows)
    also = [word for row in table.rows for word in row.also.split()]
    assert len({*also}) == len(also)
    assert not {*also} & {*table.by_word}
    assert all(table.meant(word)[0] == row.key for row in table.rows for word in row.also.split())


def test_a_file_that_is_a_list_is_told_what_a_system_file_is():
    with pytest.raises(SpecError, match="a system file is a mapping, with a 'key: value' for each section"):
        read_spec("- a\n", "list.yaml")


def test_characters_that_print_are_allowed_in_a_file() -> None:
    """Only lines with others are searched for those that are not."""
    printed = "".join(c for c in map(chr, range(0x110000)) if c.isprintable())
    assert not re.search(nodes._NOT_YAML, printed)


def test_a_name_that_is_none_is_one_mistake_whatever_commas_it_contains():
    text = changed("potential:", "forces: {bob.at(1, 0): [0, 1], other(2,3): 1}\npotential:")
    with pytest.raises(SpecError) as refused:
        read_spec(text, "a")
    named = [one.message for one in refused.value.problems]
    assert [one.partition("called ")[2] for one in named] == ["'bob.at(1, 0)'", "'other(2,3)'"]


@pytest.mark.parametrize("position", ["l*sin(theta), -l*cos(theta)", "theta, l"])
def test_a_list_without_brackets_is_the_same_in_braces_as_on_a_line(position):
    """YAML ends a text in braces at a comma; what follows is no key, as it has operators or no value."""
    line, braces = f"embedding:\n  bob: {position}\n", f"embedding: {{bob: {position}}}\n"
    head = "parameters: {l: 1}\ncoordinates: {theta: {initial: 1}}\nmasses: {bob: 1}\npotential: bob.y\n"
    first, second = (read_spec(head + each, "a").embedding["bob"] for each in (line, braces))
    assert first.text == second.text == position


def test_outputs_need_no_brackets_in_braces():
    settings = [f"solve: {{stop: 1, outputs: {outputs}, samples: 5}}" for outputs in ("q,v,T", "[q, v, T]")]
    first, second = (read_spec(f"{PENDULUM.partition('solve:')[0]}{one}\n", "a").solve for one in settings)
    assert first.outputs == second.outputs == ("q", "v", "T") and first.samples == second.samples == 5

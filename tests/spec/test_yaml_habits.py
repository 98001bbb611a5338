"""Lists, indentation and spaces as people write them who do not know YAML: a message at the place."""

from __future__ import annotations

import pytest

from lagrange_cli.expression.scan import WORDS
from lagrange_cli.spec.read import read_spec
from tests.support.files import PENDULUM, changed, problems, underlined

POSITION = "  bob: [l*sin(theta), -l*cos(theta)]"
THETA = "  theta: {initial: 0.1}"

# what to replace, by what, then the line, the underlined piece, a part of the message and the hint
HABITS = [
    (THETA, "  - theta: 0.3", 7, "", "has only names", "write 'theta: {initial: 0.3}' without the '- '"),
    (THETA, "  - theta: {initial: 1}", 7, "", "only names", "'theta: {initial: ...}' without the '- '"),
    (THETA, "  - {name: theta, at: 1}", 7, "", "only names", "'theta: {initial: ...}' without the '- '"),
    (THETA, "  - {}", 7, "", "has only names", "write 'theta: {initial: 0.1, velocity: 0}'"),
    (THETA, "  - theta = 0.5", 7, "theta = 0.5", "cannot be called", "write theta: {initial: 0.5}"),
    ("  bob: m", "bob: m", 9, "bob", "unknown key 'bob'", "indent it, if it belongs to 'masses'"),
    (THETA, "  theta: {initial: value: 1}", 7, "", "did not find", "in braces, as in initial: {value: ...}"),
    (THETA, "theta: {initial: 0.1}", 7, "theta", "unknown key", "if it belongs to 'coordinates'"),
    ("masses:\n  bob: m", "masses {bob: 2*m}", 8, "masses {bob", "unknown key", "write 'masses: {bob: 2*m}'"),
    ("masses:\n  bob: m", "masses:{bob: m}", 8, "masses:{bob", "unknown key", "write 'masses: {bob: m}'"),
    ("potential: m", "potential:\u00a0m", 12, "", "U+00A0 where YAML expects a space", "by a space"),
    ("  m: 1", "\u3000 m: 1", 3, "", "U+3000 where YAML expects a space", "by a space"),
    (POSITION, "  bob:\n    -l\n    -l*cos(theta)", 12, "-l", "is no list", "write '- -l', with a space"),
    (POSITION, "  bob:\n    -theta\n\n    -1", 12, "-theta", "is no list", "write '- -theta'"),
    ("*bob.y", "*bob.y // weight", 12, "m", "neither an index nor a size", "a comment begins with #"),
    ("*bob.y", "*bob.y % weight", 12, "m", "neither an index nor", "a comment begins with #"),
]


@pytest.mark.parametrize(("old", "new", "line", "piece", "message", "hint"), HABITS)
def test_a_habit_from_elsewhere_is_said_once_with_a_way_out(old, new, line, piece, message, hint):
    found = problems(changed(old, new))
    assert [problem.line for problem in found] == [line]
    assert message in found[0].message and hint in found[0].hint
    assert not piece or underlined(found[0]) == piece


@pytest.mark.parametrize(
    "text", ["  bob: -l*sin(theta)\n    -l*cos(theta)", "  bob:\n    l*sin(theta)\n    -1"]
)
def test_a_sum_on_several_lines_is_one_expression(text):
    assert [one.message for one in problems(changed(POSITION, text))] == [
        "the particle 'bob' has no component 'y' in potential"
    ]


def test_parameters_in_a_list_are_told_to_leave_out_the_dash():
    text = changed("  m: 1\n  l: {value: 0.5, unit: m}\n  g: 9.81", "  - m: 1\n  - l: 0.5\n  - g: 9.81")
    (found,) = problems(text)
    assert found.line == 3 and "without '- '" in found.hint


def test_keys_that_are_not_indented_are_told_so_although_they_may_mean_a_section():
    parameters = "  m: 1\n  l: {value: 0.5, unit: m}\n  g: 9.81"
    found = problems(changed(parameters, parameters.replace("  ", "")))
    assert [underlined(one) for one in found] == ["m", "l", "g"]
    assert found[0].hint == "write 'masses', or indent it, if it belongs to 'parameters'"


@pytest.mark.parametrize("word", sorted(WORDS))
def test_a_word_of_expressions_is_no_name(word):
    found = problems(changed("  m: 1", f"  m: 1\n  {word}: 1"))
    assert underlined(found[0]) == word and f"call it {word}_ or another name" in found[0].hint
    assert not problems(changed("  m: 1", f"  m: {word}_\n  {word}_: 1"))


@pytest.mark.parametrize(("name", "line", "column"), [("pendülum", 1, 11), ("x\n# é", 2, 3)])
def test_a_character_of_another_encoding_is_shown_at_its_place(name, line, column):
    (found,) = problems(changed("pendulum", name).encode("latin-1"))
    assert (found.line, found.column) == (line, column) and "UTF-8" in found.message
    assert not problems(PENDULUM.replace("pendulum", name).encode("utf-8-sig"))


SUMS = [
    ("Sum(x[i] for i in range(2))", "write sum(...) for Sum(...)"),
    ("m*(Σ(m*x[i]**2 for i in range(2)))", "write sum(...) for Σ(...)"),
    ("np.sum(x[i] for i in range(2))", "write sum(...)"),
    ("prod(x[i] for i in range(2))", "there are no products over an index"),
    ("sin(x[i] for i in range(2))", "as in sum("),
    ("m*(x[i] for i in range(2))", "as in sum("),
    ("x[i] for i in range(2)", "as in sum("),
]


@pytest.mark.parametrize(("potential", "hint"), SUMS)
def test_a_loop_outside_a_sum_says_how_sums_are_written(potential, hint):
    text = "parameters: {m: 1}\ncoordinates: {'x[i in range(2)]': {initial: 1}}\n"
    text += "masses: {'p[i in range(2)]': m}\npositions: {'p[i in range(2)]': 'x[i]'}\npotential: "
    assert not problems(f"{text}sum(x[i] for i in range(2))")
    assert hint in problems(f"{text}{potential}")[0].hint


@pytest.mark.parametrize(
    "potential", ["sum(x[i]*x[1 - i for i in range(2))", "sum(x[a[i] for i in range(2))"]
)
def test_an_index_that_is_not_closed_is_no_loop_outside_a_sum(potential):
    text = "parameters: {a: [1, 0]}\ncoordinates: {'x[i in range(2)]': {initial: 1}}\n"
    text += "masses: {'p[i in range(2)]': 1}\npositions: {'p[i in range(2)]': 'x[i]'}\n"
    (found,) = problems(f"{text}potential: {potential}")
    assert found.message == "unclosed '[' in potential" and found.hint == "add a ']'"
    assert underlined(found) == "[" and found.column == 12 + potential.rindex("x[") + 1


@pytest.mark.parametrize("condition", ["x[i] > 0", "kind[i] == 1"])
def test_conditions_of_sums_on_what_is_no_index_say_how_they_are_written(condition):
    text = "coordinates: {'x[i in range(2)]': {initial: 1}}\nmasses: {'p[i in range(2)]': 1}\n"
    text += (
        f"positions: {{'p[i in range(2)]': 'x[i]'}}\npotential: sum(x[i] for i in range(2) if {condition})"
    )
    (found,) = problems(text)
    assert "lists of whole numbers are parameters" in found.hint and "where(condition, a, b)" in found.hint


LISTS = [
    (
        "[[2, -1], [-1, 2]]",
        "is a list of lists",
        "write one list, [2, -1, -1, 2], whose item 2*i + j is that of",
    ),
    ("1, 2, 3, 4", "is a list without brackets", "write [1, 2, 3, 4]"),
    ("1, 2, 3", "expected a scalar in parameter 'a', found a vector", "write a list, [1, 2, 3]"),
    ("(1, 2)", "expected a scalar in parameter 'a', found a vector", "write a list, [1, 2]"),
]


@pytest.mark.parametrize(("value", "message", "hint"), LISTS)
def test_lists_that_are_none_say_how_they_are_written(value, message, hint):
    (found,) = problems(changed("  m: 1", f"  m: 1\n  a: {value}"))
    assert message in found.message and hint in found.hint and found.line == 4


def test_the_number_of_members_is_no_length():
    text = "parameters: {m: [1, 2]}\ncoordinates: {'x[i in range(len(m))]': {initial: 1}}\nlagrangian: 1\n"
    assert "the number of members is a number or one of the sizes" in problems(text)[0].hint


def test_a_name_of_several_lines_is_one_line():
    text = "name: |\n  two\n  lines\ncoordinates: {x: {initial: 1}}\nlagrangian: x_dot**2/2\n"
    assert read_spec(text, "x.yaml").name == "two lines"


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("parameters: {m: 1 l: 2, g: 9.81}", "write a comma before 'l'"),
        ("parameters: {m: 2*(a + b) l: 2}", "write a comma before 'l'"),
        ("parameters: {m: {value: 1, unit: kg} l: 2}", "write a comma before 'l'"),
        ('parameters: {m: {value: "2" unit: m}}', "write a comma before 'unit'"),
        ("draw: {rods: [[0, a] [0, b]]}", "write a comma before '['"),
        ("parameters: {m: 1; l: 2}", "write ',' in place of ';'"),
        ("coordinates: {x: {initial: 1}", "write '}' at the end: what column 14 opens is not closed"),
    ],
)
def test_a_missing_comma_or_brace_is_named(line: str, hint: str) -> None:
    """Before, values were to be put in quotes."""
    (problem,) = problems(line)
    assert problem.hint == hint

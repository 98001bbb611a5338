"""Indices that are looked up in lists and families of whole numbers: networks, trees, lists of neighbours."""

from __future__ import annotations

import random

import numpy as np
import pytest

import lagrange_cli
from lagrange_cli.errors import UsageError
from lagrange_cli.families.system import any_family_system
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import key_of
from lagrange_cli.run.equations import derive
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.support.families import alike, followed
from tests.support.files import problems, underlined
from tests.support.motion import FULL

NETWORK = """\
sizes: {{N: {count}, B: {bonds}}}
parameters:
{parameters}
  k: 2
coordinates:
  x[i in range(N)]: {{initial: cos(i)*(1 + i), velocity: 0.1*i}}
  y[i in range(N)]: {{initial: sin(i)*(1 + i)}}
masses: {{"p[i in range(N)]": 1 + i/7}}
embedding: {{"p[i in range(N)]": ["x[i]", "y[i]"]}}
{definitions}
potential: {potential}
dissipation: {dissipation}
"""
BOND, DRAG = "k*(norm(p[{a}] - p[{b}]) - {rest})**2/2", "0.01*(x_dot[{a}] - x_dot[{b}])**2/2"
TREE = """\
sizes: {{N: {count}}}
parameters: {{{parents} "l[i in range(N)]": 1 + (i % 3)/10, g: 9.81}}
coordinates: {{"th[i in range(N)]": {{initial: 0.1*(i % 7) - 0.2, velocity: 0.05*(i % 5)}}}}
masses: {{"m[i in range(N)]": 1 + (i % 4)/5}}
definitions:
  x[0]: l[0]*sin(th[0])
  y[0]: -l[0]*cos(th[0])
{links}
embedding: {{"m[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum((1 + (i % 4)/5)*g*m[i].y for i in range(N))
"""
OUTPUTS = frozenset({"q", "v", "h"})


def pairs(chance: random.Random, count: int) -> list[tuple[int, int]]:
    """Ends of bonds: each particle is tied to an earlier one, and there are further bonds."""
    chain = [(i, chance.randrange(i)) for i in range(1, count)]
    further = [tuple(chance.sample(range(count), 2)) for _ in range(count // 2)]
    return [*chain, *further]  # type: ignore[list-item]


def network(ends: list[tuple[int, int]], count: int, way: str) -> str:
    """The same network: bonds ``by hand``, from ``lists``, a ``table`` of two indices, or ``definitions``."""
    over = "for n in range(B)"
    ways = {
        "lists": (f"  a: {[a for a, _ in ends]}\n  b: {[b for _, b in ends]}", "", ("a[n]", "b[n]"), "a[n]"),
        "a table": (
            "\n".join(f"  'end[{n},{k}]': {one}" for n, two in enumerate(ends) for k, one in enumerate(two)),
            "", ("end[n, 0]", "end[n, 1]"), "end[n, 0]",
        ),
        "definitions": (
            f"  a: {[a + 1 for a, _ in ends]}\n  b: {[b for _, b in ends]}",
            'definitions: {"c[n in range(B)]": a[n] - 1, "d[n in range(B)]": "b[n]"}',
            ("c[n]", "d[n]"), "(a[n] - 1)",
        ),
    }  # fmt: skip
    if way == "by hand":
        sums = (
            " + ".join(each.format(a=a, b=b, rest=f"(1 + {a}/9)") for a, b in ends) for each in (BOND, DRAG)
        )
        parts = "", "", *sums
    else:
        parameters, definitions, (a, b), number = ways[way]
        sums = (f"sum({each.format(a=a, b=b, rest=f'(1 + {number}/9)')} {over})" for each in (BOND, DRAG))
        parts = parameters, definitions, *sums
    words = dict(zip(("parameters", "definitions", "potential", "dissipation"), parts))
    return NETWORK.format(count=count, bonds=len(ends), **words)


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("way", ["lists", "a table", "definitions"])
@pytest.mark.parametrize("count", [2, 3, 8, 9, 40])
def test_networks_move_as_if_their_bonds_were_written_by_hand(
    count: int, way: str, pytestconfig: pytest.Config
) -> None:
    chance = random.Random(f"{pytestconfig.getoption('seed')} {count} {way}")
    ends = pairs(chance, count)
    looked_up, by_hand = (network(ends, count, one) for one in (way, "by hand"))
    if count == 40:
        assert any_family_system(read_spec(looked_up, "system.yaml")) is not None
    found, expected = (followed(one, OUTPUTS)[1].data for one in (looked_up, by_hand))
    alike(found, expected, 1e-12, looked_up)


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("count", [2, 3, 9, 40])
def test_trees_hang_from_the_parents_in_a_list(count: int, pytestconfig: pytest.Config) -> None:
    chance = random.Random(f"{pytestconfig.getoption('seed')} {count}")
    parents = [0, *(chance.randrange(i) for i in range(1, count))]
    links = "  x[i in range(1, N)]: x[parent[i]] + l[i]*sin(th[i])\n"
    links += "  y[i in range(1, N)]: y[parent[i]] - l[i]*cos(th[i])"
    written = "\n".join(
        f"  x[{i}]: x[{p}] + l[{i}]*sin(th[{i}])\n  y[{i}]: y[{p}] - l[{i}]*cos(th[{i}])"
        for i, p in enumerate(parents)
        if i
    )
    text = TREE.format(count=count, parents=f"parent: {parents},", links=links)
    system = any_family_system(read_spec(text, "system.yaml"))
    assert count < 12 or (system is not None and system.joints is not None)
    found, expected = (
        followed(one, OUTPUTS)[1].data for one in (text, TREE.format(count=count, parents="", links=written))
    )
    alike(found, expected, 1e-11, text)


@pytest.mark.exhaustive(keep=0.15)
def test_lists_of_neighbours_with_ranges_that_are_looked_up() -> None:
    """Each particle has the neighbours that stand from ``first[i]`` to ``first[i + 1]``; half the sum over
    all is the energy of the bonds."""
    chance, count = random.Random(3), 30
    ends = pairs(chance, count)
    near: list[list[int]] = [[] for _ in range(count)]
    for a, b in ends:
        near[a].append(b)
        near[b].append(a)
    first = [sum(map(len, near[:i])) for i in range(count + 1)]
    lists = f"  first: {first}\n  near: {[j for one in near for j in one]}"
    each = BOND.format(a="i", b="near[n]", rest="1")
    looked_up = NETWORK.format(
        count=count, bonds=1, parameters=lists, definitions="", dissipation="0",
        potential=f"sum({each}/2 for i in range(N) for n in range(first[i], first[i + 1]))",
    )  # fmt: skip
    by_hand = NETWORK.format(
        count=count, bonds=1, parameters="", definitions="", dissipation="0",
        potential=" + ".join(BOND.format(a=a, b=b, rest="1") for a, b in ends),
    )  # fmt: skip
    found, expected = (followed(one, OUTPUTS)[1].data for one in (looked_up, by_hand))
    alike(found, expected, 1e-12)


def test_conditions_and_keys_may_look_up() -> None:
    text = """\
sizes: {N: 6}
parameters: {kind: [0, 1, 0, 2, 1, 0], partner: [1, 0, 3, 2, 5, 4]}
coordinates: {"x[i in range(N)]": {initial: i}}
masses: {"p[i in range(N)]": 1}
embedding: {"p[i in range(N)]": ["x[i]"]}
potential: sum(x[i]**2 for i in range(N) if kind[i] == 0) + sum(x[i]*x[partner[i]] for i in range(kind[3]))
generalized_forces: {"x[i in range(N) if kind[i] == 1]": "-x_dot[i]"}
"""
    by_hand = text.replace(text[text.index("potential") :], "").replace("parameters: ", "parameters: {}  # ")
    by_hand += """\
potential: x[0]**2 + x[2]**2 + x[5]**2 + 2*x[0]*x[1]
generalized_forces: {"x[1]": "-x_dot[1]", "x[4]": "-x_dot[4]"}
"""
    found, expected = (followed(one, OUTPUTS)[1].data for one in (text, by_hand))
    alike(found, expected, 1e-14)


MISTAKES = {
    "x[a[3]]": ("there is no a[3]", "a[3]", "members are a[0] to a[2]"),
    "x[a[n]]": ("there is no a[3], for n = 3", "a[n]", "members are a[0] to a[2]"),
    "x[half[n]]": ("'half' cannot be an index: it is not a family of whole numbers", "half[n]", ""),
    "x[length[n]]": ("'length' cannot be an index", "length[n]", ""),
    "x[k[n]]": ("'k' is neither an index nor a size here", "k[n]", ""),
    "x[a[n, 0]]": ("'a' has 1 index, not 2", "a[n, 0]", "give it as many as in its declaration"),
    "x[far[n]]": ("no member 'x[9]', for n = 3", "x[far[n]]", ""),
}


@pytest.mark.parametrize("wrong", MISTAKES)
def test_mistakes_are_reported_with_their_place(wrong: str) -> None:
    message, place, hint = MISTAKES[wrong]
    (found,) = problems(f"""\
sizes: {{N: 4}}
parameters:
  a: [0, 1, 2]
  half: [0, 0.5, 1, 2]
  length: {{value: [1, 2, 3, 0], unit: m}}
  far: [0, 1, 2, 9]
  k: 1
coordinates: {{"x[i in range(N)]": {{initial: 0}}}}
masses: {{"p[i in range(N)]": 1}}
embedding: {{"p[i in range(N)]": ["x[i]"]}}
potential: k*sum({wrong}**2 for n in range(N))
""")
    assert message in found.message and hint in found.hint, found
    assert underlined(found) == place


def test_definitions_that_follow_from_one_another_are_no_tables() -> None:
    text = network([(1, 0), (2, 1)], 3, "definitions").replace(
        '"b[n]"', '"where(n > 0, 1, 0)*d[max(n - 1, 0)]"'
    )
    assert any("'d' is looked up in itself" in one.message for one in problems(text))


def test_what_is_looked_up_cannot_be_set() -> None:
    text = network([(1, 0), (2, 1)], 3, "lists")
    spec = read_spec(text, "system.yaml")
    with pytest.raises(UsageError, match=r"'a\[0\]' is used as an index, which the file decides"):
        resolve_values(spec, {"a[0]": "2"})
    resolve_values(spec, {"k": "2"})
    (found,) = problems(text + "events: {tick: {when: t - 1, action: {set: {'a[0]': 2}}}}\n")
    assert "'a' cannot be set" in found.message


def test_other_numbers_are_other_equations() -> None:
    """Compiled code is not used again for a list with other numbers, though other parameters may differ."""
    asked = Compilation("taylor", FULL, OUTPUTS)
    text = network([(1, 0), (2, 1)], 3, "lists")
    changed, free = text.replace("a: [1, 2]", "a: [1, 0]"), text.replace("k: 2", "k: 3")
    key, other, same = (key_of(read_spec(one, "system.yaml"), asked) for one in (text, changed, free))
    assert key == same != other


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("index", ["a[n]", "a[(n + 1) % B]", "a[a[n]]", "end[a[n], 0]"])
def test_lookups_need_no_quotes_in_lists_and_braces(index: str) -> None:
    """YAML has a meaning for brackets; those of indices are not its own, in one another either."""
    text = f"""\
sizes: {{N: 3, B: 3}}
parameters: {{a: [2, 0, 1], end[n in range(3), m in range(2)]: n}}
coordinates: {{x[i in range(N)]: {{initial: i}}}}
masses: {{p[n in range(B)]: 1}}
embedding: {{p[n in range(B)]: [x[{index}], 0]}}
forces:
  p[n in range(B)]: [-x[{index}], -2*x_dot[{index}]]
"""
    quoted = text.replace(f"[x[{index}], 0]", f"['x[{index}]', 0]")
    quoted = quoted.replace(f"[-x[{index}], -2*x_dot[{index}]]", f"['-x[{index}]', '-2*x_dot[{index}]']")
    found, expected = (followed(one, OUTPUTS)[1].data for one in (text, quoted))
    alike(found, expected, 0.0)


@pytest.mark.exhaustive(keep=0.25)
def test_the_command_line_looks_up_as_the_file_does() -> None:
    text = network([(1, 0), (2, 1)], 3, "lists")
    motions = [lagrange_cli.solve(text, set={name: 3}, stop=0.3) for name in ("x[a[1]]", "x[2]")]
    assert np.array_equal(motions[0].q["x"], motions[1].q["x"]) and motions[0].q["x"][0, 2] == 3.0
    wheres = "x[a[1]] - x[b[0]]/2", "x[2] - x[0]/2"
    sections = [lagrange_cli.section(text, where=where, crossings=1) for where in wheres]
    assert len(sections[0].q["x"]) == 1 and np.array_equal(sections[0].q["x"], sections[1].q["x"])
    for wrong in ({"set": {"x[a[2]]": 3}}, {"where": "x[a[2]]"}):
        with pytest.raises(UsageError, match=r"there is no a\[2\]; members are a\[0\] to a\[1\]"):
            lagrange_cli.section(text, **{"where": "x[0]", "crossings": 1, **wrong})


@pytest.mark.exhaustive(keep=0.15)
def test_other_coordinates_may_look_up() -> None:
    text = (
        network([(1, 0), (2, 1)], 3, "lists")
        + """
transformations:
  shifted: {coordinates: [X, Y, Z], replace: {"x[0]": X, "x[b[1]]": Y + X/3, "x[2]": Z}}
"""
    )
    found = derive(read_spec(text, "system.yaml"), coordinates="shifted").covariance
    assert found is not None and found.states and found.agrees

"""Which members an ensemble has: grids, random numbers, tables, and what is wrong with them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from lagrange_cli.errors import FileError, LagrangeError, UsageError
from lagrange_cli.run.ensembles.draws import Draws, draw_members, grid
from lagrange_cli.run.ensembles.members import Members
from lagrange_cli.run.ensembles.numbers import Numbers
from lagrange_cli.spec.read import read_spec
from tests.support.command import SYSTEMS

HOOP = read_spec((SYSTEMS / "rotating_hoop.yaml").read_bytes(), "hoop.yaml")
CHAIN = read_spec((SYSTEMS / "n_pendulum.yaml").read_bytes(), "chain.yaml")


def members(*over: str, random: tuple[str, ...] = (), **draws: object) -> Members:
    pairs = [tuple((name, text) for name, _, text in (x.partition("=") for x in xs)) for xs in (over, random)]
    return draw_members(HOOP, Draws(*pairs, **draws), {})


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0:10:11", range(11)),
        (" -pi : pi : 3 ", [-math.pi, 0, math.pi]),
        ("1:0:2", [1, 0]),
        ("log:1e-3:10:5", [1e-3, 1e-2, 1e-1, 1, 10]),
        ("1,2.5,pi/2,-1e3", [1, 2.5, math.pi / 2, -1000]),
        ("3", [3]),
    ],
)
def test_grids(text, values):
    found = grid(text, "--over m", Numbers(HOOP, {}, ["m"]))
    np.testing.assert_allclose(found, list(values), rtol=1e-15)
    assert (found[0], found[-1]) == (values[0], values[-1])  # the ends to the last bit


def test_grids_and_distributions_may_contain_parameters_and_constant_definitions():
    spec = read_spec(
        b"sizes: {N: 3}\nparameters: {g: 8, l: 2, k: g/l, c: [1, 4]}\n"
        b"definitions: {period: 2*pi*sqrt(l/g), at: (0, k), d[i in range(N)]: l*i, moving: 2*x}\n"
        b"coordinates: {x: {initial: 0}}\nlagrangian: x_dot**2/2 - k*x**2/2\n",
        "s.yaml",
    )
    over = (("x", "0:period:3"), ("x_dot", "at.y,d[2],c[1],N"))
    found = draw_members(spec, Draws(over=over), {"l": "4*2"})
    assert np.unique(found.columns["x"]).tolist() == [0.0, math.pi, 2 * math.pi]
    assert list(dict.fromkeys(found.columns["x_dot"])) == [1.0, 16.0, 4.0, 3.0]
    drawn = draw_members(spec, Draws(random=(("x", "uniform(g,k + g)"),), members=99), {}).columns["x"]
    assert 8 < drawn.min() < 9 < 11 < drawn.max() < 12


def test_several_grids_make_every_combination_the_first_slowest():
    found = members("omega=1,2", "theta=0:1:3", "m=5,7")
    rows = list(zip(*(found.columns[name].tolist() for name in ("omega", "theta", "m"))))
    assert rows == [(o, q, m) for o in (1, 2) for q in (0, 0.5, 1) for m in (5, 7)]
    assert list(found.shape.items()) == [("omega", 2), ("theta", 3), ("m", 2)]


def test_a_table_is_combined_with_grids_and_draws(tmp_path):
    table = tmp_path / "runs.csv"
    table.write_text("\ufeff theta, theta_dot\n# from the lowest point\n1, 2\n\n-3, 4e-1\n", encoding="utf-8")
    found = members("omega=5,6", random=("m=uniform(1,2)",), members=3, table=str(table))
    assert list(found.shape.values()) == [2, 2, 3]
    assert found.columns["theta"].tolist() == [1] * 6 + [-3] * 6
    assert found.columns["theta_dot"].tolist() == [2] * 6 + [0.4] * 6
    assert found.columns["omega"].tolist() == ([5] * 3 + [6] * 3) * 2
    assert len(set(found.columns["m"])) == 12


def test_members_of_families_are_named_as_the_file_has_them(tmp_path):
    table = tmp_path / "runs.csv"
    table.write_text('"theta[0]","theta_dot[N - 1]"\n1,2\n')
    found = draw_members(CHAIN, Draws(over=(("theta[2*1]", "1,2"),), table=str(table)), {})
    assert set(found.columns) == {"theta[0]", "theta_dot[4]", "theta[2]"}


DISTRIBUTIONS = {
    "normal(2,0.5)": lambda x: (x - 2) / 0.5,
    "lognormal(2,0.5)": lambda x: np.log(x / 2) / 0.5,
    "uniform(-1,3)": lambda x: (x + 1) / 4,
    "loguniform(0.1,10)": lambda x: np.log10(x / 0.1) / 2,
}


@pytest.mark.parametrize("text", DISTRIBUTIONS)
def test_random_numbers_are_distributed_as_asked(text):
    x = np.sort(DISTRIBUTIONS[text](members(random=(f"theta={text}",), members=20000).columns["theta"]))
    normal = np.vectorize(math.erf)(x / math.sqrt(2)) / 2 + 0.5
    expected = normal if "normal" in text else np.clip(x, 0, 1)
    # Kolmogorov and Smirnov's distance: beyond 1.95/sqrt(n) once in a thousand seeds, and the seed is fixed
    assert np.abs(expected - np.arange(0.5, 20000) / 20000).max() < 1.95 / math.sqrt(20000)


def test_the_random_numbers_of_a_member_depend_on_its_name_and_the_seed_alone():
    def drawn(*random, **draws):
        return members(random=random, **draws).columns

    few = drawn("theta=normal(0,1)", members=5)["theta"]
    many = drawn("m=uniform(1,2)", "theta=normal(0,1)", "theta_dot=normal(0,1)", members=500)
    assert few.tolist() == many["theta"][:5].tolist()
    assert few.tolist() == drawn("theta=normal(0,1)", members=5, seed=0)["theta"].tolist()
    assert not np.any(few == drawn("theta=normal(0,1)", members=5, seed=1)["theta"])
    assert abs(np.corrcoef(many["theta"], many["theta_dot"])[0, 1]) < 0.2


@pytest.mark.parametrize(
    ("over", "random", "draws", "message"),
    [
        ((), (), {}, "no members given: add --over"),
        (("omga=1,2",), (), {}, "--over omga=1,2: unknown name 'omga'; did you mean 'omega'?"),
        (("omega=1:2",), (), {}, "'1:2' is not a grid; write START:STOP:COUNT"),
        (
            ("omega=1:2:x",),
            (),
            {},
            "COUNT is the number of values, an integer, not 'x'; write START:STOP:COUNT",
        ),
        (("omega=1:2:2.5",), (), {}, "an integer, not '2.5'"),
        (("omega=[1,2]",), (), {}, "expected a number, not '[1'; write START:STOP:COUNT"),
        (("omega=4..5",), (), {}, "expected a number, not '4..5'; write START:STOP:COUNT"),
        (("omega=normal(0,1)",), (), {}, "normal(0,1) is a distribution: write it with --random"),
        (("omega=-1e308:1e308:3",), (), {}, "the ends are too far apart"),
        (("omega=0:1:" + "9" * 5000,), (), {}, "COUNT is the number of values"),
        ((), ("omega=0:1:3",), {"members": 5}, "(and a list or a grid with --over)"),
        (("omega=1:2:1",), (), {}, "a grid has at least 2 values"),
        (("omega=1:2:999999999",), (), {}, "999999999 values are more than the limit of 1e8 members"),
        (("omega=0:1:10001", "m=0:1:10001"), (), {}, "1e8 members are more than the limit"),
        (("omega=log:0:1:5",), (), {}, "both ends of a logarithmic grid must be positive"),
        (("omega=lin:0:1:5",), (), {}, "is not a grid"),
        (("omega=1,,2",), (), {}, "expected a number, not ''; write START:STOP:COUNT"),
        (("omega=1,two",), (), {}, "unknown name 'two'; known: m, g, a, omega"),
        (
            ("omega=theta:2:3",),
            (),
            {},
            "'theta' is not constant; write numbers, or expressions in parameters",
        ),
        (("omega=t,2",), (), {}, "'t' is the time; write numbers"),
        (("omega=1,omega",), (), {}, "'omega' differs between the members of the sweep; --table"),
        (("a=1,2", "theta=0,omega"), (), {}, "--over theta=0,omega: 'omega' differs between the members"),
        (("a=1,2",), ("theta=normal(0,a)",), {"members": 5}, "'a' differs between the members"),
        (("omega=1,nan",), (), {}, "nan is not a finite number"),
        (("omega=0:1e999:3",), (), {}, "1e999 is not a finite number"),
        (("omega=1/0,2",), (), {}, "division by zero"),
        (("omega=1,2", "omega=3,4"), (), {}, "'omega' is given more than once"),
        (("theta=1,2",), ("theta=normal(0,1)",), {}, "'theta' is given more than once"),
        ((), ("theta=normal(0,1)",), {}, "add --members 1000"),
        (("theta=1,2",), (), {"members": 5}, "--members is the number of draws of --random"),
        (
            (),
            ("theta=cauchy(0,1)",),
            {"members": 5},
            "not a distribution; write one of normal(mean,deviation)",
        ),
        ((), ("theta=normal(0)",), {"members": 5}, "is not a distribution"),
        ((), ("theta=normal(0,0)",), {"members": 5}, "the width of normal must be positive, not 0"),
        ((), ("theta=normal(0,x)",), {"members": 5}, "unknown name 'x'"),
        ((), ("theta=uniform(1,1)",), {"members": 5}, "the upper limit must be greater"),
        (
            (),
            ("theta=lognormal(0,1)",),
            {"members": 5},
            "the first number of lognormal must be positive, not 0",
        ),
        (
            (),
            ("theta=loguniform(-1,1)",),
            {"members": 5},
            "the first number of loguniform must be positive, not -1",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(over, random, draws, message):
    with pytest.raises(UsageError) as raised:
        members(*over, random=random, **draws)
    assert message in str(raised.value) and "\n" not in str(raised.value)


def test_two_columns_cannot_name_the_same_member_of_a_family(tmp_path):
    table = tmp_path / "runs.csv"
    table.write_text('"theta[4]","theta[N - 1]"\n1,2\n')
    with pytest.raises(UsageError, match=r"column 'theta\[N - 1\]': an earlier column gives 'theta\[4\]'"):
        draw_members(CHAIN, Draws(table=str(table)), {})


def test_what_is_set_cannot_be_swept_and_sizes_neither():
    with pytest.raises(UsageError, match="'omega' is given more than once"):
        draw_members(HOOP, Draws(over=(("omega", "1,2"),)), {"omega": "3"})
    with pytest.raises(UsageError, match=r"'N' is a size.*--size N="):
        draw_members(CHAIN, Draws(over=(("N", "1,2"),)), {})


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty: the first line must name the columns"),
        (b"\n\n", "is empty"),
        (b"theta\n", "has no rows"),
        (b"theta,theta\n1,2\n", ":1: two columns are called 'theta'"),
        (b"theta,\n1,2\n", ":1: a column has no name"),
        (b"thata\n1\n", "column 'thata': unknown name 'thata'; did you mean 'theta'?"),
        (b"theta;m\n1;2\n", ":1: separate the columns by commas"),
        (b"theta\tm\n1\t2\n", ":1: separate the columns by commas"),
        (b"theta m\n1 2\n", ":1: separate the columns by commas"),
        (b"theta,m\n1,2\n\n1\n", ":4: expected 2 values, found 1"),
        (b"theta,m\n1,2\n1,2,3\n", ":3: expected 2 values, found 3"),
        (b"theta,m\n1,2\n1,two\n", ":3: m: expected a number, not 'two'"),
        (b"theta,m\n1,2\n1,\n", ":3: m: expected a number, not ''"),
        (b"theta\n1\n-inf\n", ":3: theta: -inf is not a finite number"),
        (b"theta\n1\n1\x002\n", ":3: "),
        (b'theta\n1\n"2\n', ":3: "),
        (b"theta\n\xff\xfe\n", "it is not UTF-8 text"),
        (b"\x89HDF\r\n\x1a\n", "it is not UTF-8 text"),
    ],
)
def test_a_bad_table_is_refused_with_its_line(tmp_path, content, message):
    path = tmp_path / "runs.csv"
    path.write_bytes(content)
    with pytest.raises(UsageError) as raised:
        members(table=str(path))
    assert message in str(raised.value) and "\n" not in str(raised.value)


@pytest.mark.parametrize("name", ["nosuch.csv", ".", "x" * 5000, "a\0b"])
def test_a_table_that_cannot_be_read(tmp_path, name):
    with pytest.raises(LagrangeError) as raised:
        members(table=str(Path(tmp_path) / name))
    assert isinstance(raised.value, FileError) and "could not be read" in str(raised.value)


@pytest.mark.parametrize(("count", "said"), [(1, "1 row of the table x 1 draw of --random"),
                                             (2, "2 rows of the table x 2 draws of --random")])  # fmt: skip
def test_one_is_singular(count, said):
    table = {"omega": [1.0, 2.0][:count]}
    found = members(
        random=("theta=normal(0,1)",), members=count, table={k: np.array(x) for k, x in table.items()}
    )
    assert found.in_words == said

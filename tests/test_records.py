"""``records`` does what ``dataclasses`` does, as far as it goes."""

import copy
import dataclasses
import pickle
import subprocess
import sys
from typing import Generic, TypeVar

import pytest

from lagrange_cli import records
from tests.support.command import environment

T = TypeVar("T")
BOTH = pytest.mark.parametrize("module", [records, dataclasses], ids=["records", "dataclasses"])


def point(module, **options):
    @module.dataclass(**{"frozen": True, **options})
    class Point:
        x: float
        y: float = 0.0
        labels: dict = module.field(default_factory=dict, compare=False)
        note: str = module.field(default="-", repr=False)

        @property
        def norm(self):
            return abs(self.x) + abs(self.y)

    return Point


@BOTH
def test_arguments_by_place_and_by_name_with_defaults(module):
    Point = point(module)
    for one in (Point(1, 2), Point(x=1, y=2), Point(1, y=2), Point(y=2, x=1)):
        assert (one.x, one.y, one.labels, one.note, one.norm) == (1, 2, {}, "-", 3)
    assert Point(1).y == 0.0
    assert Point(1).labels is not Point(1).labels
    whole = Point(1, 2, {"a": 1}, "n")
    assert (whole.labels, whole.note) == ({"a": 1}, "n")


@BOTH
@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ((), {}),
        ((), {"y": 1}),
        ((1,), {"x": 2}),
        ((1,), {"z": 2}),
        ((1, 2, {}, "", 5), {}),
        ((1, 2), {"y": 3}),
    ],
)
def test_arguments_that_do_not_fit_are_refused(module, arguments, named):
    with pytest.raises(TypeError):
        point(module)(*arguments, **named)


@BOTH
def test_records_are_equal_by_what_is_compared_and_of_one_class(module):
    Point, Other = point(module), point(module)
    assert Point(1, 2, {"a": 1}) == Point(1, 2) and hash(Point(1, 2, {"a": 1})) == hash(Point(1, 2))
    assert Point(1, 2) != Point(1, 3) and Point(1, 2, note="a") != Point(1, 2)
    assert Point(1, 2) != Other(1, 2) and Point(1, 2) != (1, 2)
    assert len({Point(1), Point(1), Point(2)}) == 2
    assert repr(Point(1, 2, note="hidden")).endswith("Point(x=1, y=2, labels={})")


@BOTH
def test_what_is_frozen_stays_as_it_is_and_what_is_not_has_no_hash(module):
    one = point(module)(1)
    for change in (lambda: setattr(one, "x", 2), lambda: setattr(one, "new", 2), lambda: delattr(one, "x")):
        with pytest.raises(AttributeError):
            change()
    assert one.x == 1
    loose = point(module, frozen=False)(1)
    loose.x = 2
    assert loose.x == 2
    with pytest.raises(TypeError):
        hash(loose)


@BOTH
def test_order_is_that_of_the_fields(module):
    Point = point(module, order=True)
    assert sorted([Point(2, 1), Point(1, 3), Point(1, 2)]) == [Point(1, 2), Point(1, 3), Point(2, 1)]
    with pytest.raises(TypeError):
        Point(1) < (1, 2)  # noqa: B015
    with pytest.raises(TypeError):
        point(module)(1) < point(module)(2)  # noqa: B015


@BOTH
def test_fields_are_inherited_and_methods_kept(module):
    Point = point(module)

    @module.dataclass(frozen=True)
    class Solid(Point):
        z: float = 5.0

        def __repr__(self):
            return "solid"

        def __eq__(self, other):
            return True

        __hash__ = None

    assert (Solid(1).z, Solid(1, 2, {}, "", 7).z, Solid(z=8, x=1).z) == (5.0, 7, 8)
    assert repr(Solid(1)) == "solid" and Solid(1) == 3
    assert not hasattr(Point(1), "z")


@BOTH
def test_what_follows_initialization_is_done(module):
    @module.dataclass
    class Sum:
        terms: list
        total: int = 0

        def __post_init__(self):
            self.total = sum(self.terms)

    assert Sum([1, 2]).total == 3


@BOTH
def test_replace_makes_another(module):
    one = point(module)(1, 2)
    assert module.replace(one, y=3) == point_like(one, 1, 3)
    assert one.y == 2
    with pytest.raises(TypeError):
        module.replace(one, nosuch=1)


def point_like(one, *arguments):
    return type(one)(*arguments)


@records.dataclass(frozen=True)
class Pair(Generic[T]):
    first: T
    second: T


def test_records_may_be_generic_copied_and_pickled():
    pair = Pair[int](1, [2])
    assert copy.copy(pair) == copy.deepcopy(pair) == pickle.loads(pickle.dumps(pair)) == pair
    assert records.fields_of(pair) == records.fields_of(Pair) == ("first", "second")


def test_the_commands_do_without_the_slower_ones(tmp_path):
    script = "import sys; from lagrange_cli.cli.main import main; main(['--help']); print(*sys.modules)"
    run = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        env=environment(),
        capture_output=True,
        text=True,
        check=True,
    )
    assert "lagrange_cli.records" in run.stdout.split() and "dataclasses" not in run.stdout.split()

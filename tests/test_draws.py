"""How many cases of exhaustive suites are run."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from tests.support.draws import sampled


class Case:
    def __init__(self, nodeid: str, given: dict[str, Any]) -> None:
        self.nodeid, self.given = nodeid, given

    def get_closest_marker(self, _: str) -> Any:
        return SimpleNamespace(kwargs=self.given)


def cases(name: str, count: int, **given: Any) -> list[Any]:
    return [Case(f"{name}[{k}]", given) for k in range(count)]


@pytest.mark.parametrize(
    ("given", "times", "usual", "everything"),
    [
        ({}, None, {0, 1}, {9}),
        ({"keep": 5, "most": 7}, None, {3}, {7}),
        ({"keep": 20}, None, {9}, {9}),
        ({"keep": 0}, None, {0}, {9}),
        ({"keep": 0.5}, None, {0, 1}, {9}),
        ({"keep": 2.5}, 1, {1, 2}, {2, 3}),
        ({"keep": 0.5}, 2, {0, 1}, {1}),
        ({"keep": 0.5}, 1, {0, 1}, {0, 1}),
        ({}, 3, {0, 1}, {3}),
        ({"keep": 0}, 2, {0}, {2}),
    ],
)
def test_so_many_cases_are_drawn_and_others_each_time(given, times, usual, everything):
    suite = cases("suite", 9, **given)
    runs = [sampled(suite, seed, False, times) for seed in range(100)]
    assert {len(one) for one in runs} == usual
    assert {len(sampled(suite, seed, True, times)) for seed in range(20)} == everything
    assert runs == [sampled(suite, seed, False, times) for seed in range(100)]
    assert {one.nodeid for run in runs for one in run} == {one.nodeid for one in suite} or usual == {0}


def test_about_so_many_suites_of_those_that_are_run_now_and_then():
    suites = [one for k in range(400) for one in cases(f"suite{k}", 2, keep=0.25)]
    assert 30 < len(sampled(suites, 1, False)) < 90
    assert 60 < len(sampled(suites, 1, True, 1)) < 140


def test_a_seed_is_drawn(request):
    """In every process: that of a worker is the one which is printed at the end."""
    assert isinstance(request.config.option.seed, int)

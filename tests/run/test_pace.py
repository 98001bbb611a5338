"""Runs that would take years say so once."""

import pytest

import lagrange_cli as lagrange
from lagrange_cli.run.pace import Pace


def told(stop: float, reached: list[tuple[float, float]]) -> list[str]:
    """What is told of a run that has ``reached`` times at so many seconds; all of them are shown."""
    said, shown = list[str](), list[float]()
    seconds = iter([passed for passed, _ in reached])
    pace = Pace(stop, shown.append, said.append, lambda: next(seconds))
    for _, t in reached:
        pace(t)
    assert shown == [t for _, t in reached]
    return said


@pytest.mark.parametrize("sign", [1, -1])
def test_a_run_that_takes_years_says_so_once(sign):
    said = told(sign * 1e300, [(10, 0.0), (12, sign * 2e6), (16, sign * 6e6), (30, sign * 2e7)])
    assert len(said) == 1
    assert "after 6 s: at this pace" in said[0] and "takes 3.2e286 years; end it" in said[0]


def test_a_resumed_run_is_judged_by_its_own_progress():
    (said,) = told(2e9, [(0, 1e9), (5, 1e9 + 10)])
    assert "takes 16 years" in said


@pytest.mark.parametrize("stop", [1e300, 1.7e308])
def test_one_that_does_not_move_takes_as_long_as_can_be_told(stop):
    (said,) = told(stop, [(0, 0.0), (6, 0.0)])
    assert "takes 1e300 years" in said


@pytest.mark.parametrize("reached", [[(0, 0.0), (4.9, 1e-9)], [(0, 0.0), (6, 1.0)], [(0, 0.0)]])
def test_other_runs_say_nothing(reached):
    assert told(1e6, reached) == []


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
def test_times_whose_powers_overflow_are_the_reason_that_is_given(method):
    """Before, a singularity was blamed, though a free particle has none."""
    free = "{coordinates: {x: {initial: 1, velocity: 1}}, lagrangian: x_dot**2/2}"
    with pytest.raises(lagrange.MotionError, match="as the stop time is so large"):
        lagrange.solve(free, stop=1e300, method=method, samples=2)
    assert lagrange.solve(free, stop=1e60, method=method, samples=2).q["x"][-1] == pytest.approx(1e60)

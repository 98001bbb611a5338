"""Runs that would take years say so once."""

import pytest

import lagrange_cli as lagrange
from lagrange_cli.api.warned import warn
from lagrange_cli.run.monitor import Silence
from lagrange_cli.run.pace import Pace, PaceOfMany


class Shown(Silence):
    """What is shown of a run."""

    def __init__(self, seen: list[float]) -> None:
        self._seen = seen

    def show(self, reached: float) -> None:
        """It has come so far."""
        self._seen.append(reached)


def told(stop: float, reached: list[tuple[float, float]], kind: type[Pace] = Pace) -> list[str]:
    """What is told of a run that has ``reached`` times at so many seconds; all of them are shown."""
    said, shown = list[str](), list[float]()
    seconds = iter([passed for passed, _ in reached])
    pace = kind(stop, Shown(shown), said.append, lambda: next(seconds))
    for _, t in reached:
        pace.show(t)
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


def test_motions_on_their_way_count_in_parts():
    (said,) = told(16, [(0, 0.0), (6, 1e-7)], PaceOfMany)
    assert "6.2e-7 % of all motions after 6 s: at this pace, the sweep takes 30 years" in said


@pytest.mark.parametrize("system", ["pendulum", "bouncing_ball"])
def test_a_sweep_knows_how_far_its_motions_are(system, monkeypatch):
    """Of those in lanes and of those that are followed alone; 1e9 takes a minute at least."""
    seen = list[float]()

    def show(self: Pace, done: float) -> None:
        seen.append(done)
        if done > 0:
            raise KeyboardInterrupt

    monkeypatch.setattr(Pace, "show", show)
    with pytest.raises(KeyboardInterrupt):
        lagrange.sweep(f"systems/{system}.yaml", over={"g": [9, 10, 11]}, stop=1e9)
    assert 0 < seen[-1] < 3


def test_bench_ends_where_no_sample_comes_within_the_budget():
    with pytest.raises(lagrange.MotionError, match="exceed budget; end the motion earlier with stop"):
        lagrange.bench("systems/pendulum.yaml", stop=1e300, budget=0.01)


def test_a_warning_points_at_the_program_that_called():
    with pytest.warns(lagrange.LagrangeWarning) as seen:
        exec("warn('at once: --stop')", {"warn": warn, "__name__": "lagrange_cli.inside"})
    assert seen[0].filename == __file__ and str(seen[0].message) == "at once: stop"

"""How choices of a method are judged."""

import math

import pytest

from benchmarks.motions.followed import Curves, Point
from benchmarks.motions.varied import GROUPS, Varied, varied
from benchmarks.suites.choice import judged, least_time
from lagrange_cli.spec.read import read_spec


def point(method: str, tolerance: float, seconds: float, error: float) -> Point:
    """A run of which only time and error matter."""
    return Point(method, tolerance, seconds, 0.0, error, 1, 1)


def test_times_between_two_runs_are_powers_of_the_error() -> None:
    runs = [point("taylor", 1e-6, 1.0, 1e-6), point("taylor", 1e-10, 4.0, 1e-10)]
    assert least_time(runs, 1e-8) == pytest.approx(2.0)
    assert least_time(runs, 1e-5) == 1.0
    assert least_time(runs, 1e-11) == math.inf


def test_a_choice_is_compared_at_its_own_error() -> None:
    """DOP853 is faster at its tolerance, but not for the error that the chosen method has."""
    motion = Varied("driven", "any", "", 1.0)
    points = [
        *(point("taylor", tolerance, 1.0, tolerance / 10) for tolerance in (1e-6, 1e-10)),
        *(point("DOP853", *one) for one in ((1e-6, 0.1, 1e-4), (1e-10, 0.5, 1e-8), (1e-12, 2.0, 1e-12))),
    ]
    chosen = {tolerance: ("taylor", tolerance) for tolerance in (1e-6, 1e-10)}
    loose, tight = judged(motion, Curves(chosen, points, 1e-16))
    assert (loose.best, loose.fair) == ("DOP853", False)
    assert 2.0 < loose.ratio < 10.0
    assert (tight.best, tight.ratio, tight.fair) == ("taylor", 1.0, True)


def test_a_choice_may_have_a_finer_tolerance() -> None:
    points = [
        point("taylor", 1e-6, 1.0, 1e-7),
        point("Radau", 1e-6, 0.1, 1e-5),
        point("Radau", 1e-8, 0.3, 1e-7),
    ]
    (found,) = judged(Varied("stiff", "any", "", 1.0), Curves({1e-6: ("Radau", 1e-8)}, points, 1e-16))
    assert (found.tolerance, found.method, found.ratio) == (1e-6, "Radau", 1.0)


@pytest.mark.exhaustive(keep=0.4)
def test_all_motions_can_be_read() -> None:
    motions = list(varied(1))
    assert {one.group for one in motions} == set(GROUPS)
    assert len({one.name for one in motions}) == len(motions)
    for one in motions:
        if int(one.sizes.get("N", "1")) <= 10 and one.group != "systems":
            assert read_spec(one.text, one.kind, one.sizes).coordinates

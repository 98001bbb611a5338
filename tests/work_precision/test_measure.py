"""Contenders: their errors beside a closed form and how they fall, and those that do not come to the end."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import End
from lagrange_cli.records import replace
from lagrange_cli.work_precision.measure import Contender, Result, Rules, measure_all
from lagrange_cli.work_precision.recommend import choose
from lagrange_cli.work_precision.reference import Reference
from lagrange_cli.work_precision.trajectory import SAMPLES, evenly, follow
from tests.support.motion import prepared, values_of

TIMES = evenly(0.0, 20.0)
VALUES = values_of("harmonic_oscillator")
REFERENCE = Reference(
    TIMES, np.cos(2 * TIMES.chunk(0, SAMPLES))[:, None], np.ones(1), error=1e-14, steps=1, asked=20.0
)
"""x = cos(2 t) itself, known to 1e-14."""
PULSATING = """coordinates: {r: {initial: 1, velocity: 0}}
masses: {p: 1}
embedding: {p: r}
potential: 2*r**2 + 1/(2*r**2)
"""
"""The distance in a plane of (cos(2 t), sin(2 t)/2) from the origin: its series converge only so far."""
DISTANCE = replace(
    REFERENCE,
    q=np.hypot(np.cos(2 * TIMES.chunk(0, SAMPLES)), np.sin(2 * TIMES.chunk(0, SAMPLES)) / 2)[:, None],
)
RULES = Rules(runs=2, budget=60.0)


def prepare(contender):
    return prepared("harmonic_oscillator", contender.method, contender.tolerance)


def results_of(entries, prepare=prepare, rules=RULES, interrupted=lambda: False):
    return list(measure_all(entries, prepare, VALUES, REFERENCE, rules, interrupted))


def slope(tolerances, results):
    """The power of the tolerance that the error falls with."""
    assert [each.contender.tolerance for each in results] == list(tolerances)
    assert {each.status for each in results} == {"complete"}
    return np.polyfit(np.log(tolerances), np.log([each.error for each in results]), 1)[0]


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize(
    ("method", "least", "most"), [("DOP853", 0.8, 1.2), ("Radau", 1.1, 1.4), ("LSODA", 0.7, 1.2)]
)
def test_errors_fall_with_the_tolerance_as_the_method_promises(method, least, most):
    """The local error is held to the tolerance, so that the global one falls in proportion, about. Radau's
    falls with h^5 and its estimate with h^4, so that the power is 5/4."""
    tolerances = (1e-4, 1e-6, 1e-8)
    results = results_of({method: tolerances})
    assert least < slope(tolerances, results) < most
    assert all(later.steps > earlier.steps for earlier, later in pairwise(results))


@pytest.mark.exhaustive(keep=0.6)
def test_errors_of_taylor_series_fall_with_the_tolerance():
    """Whose order rises with the tolerance, too. (On a cosine, whose series converges everywhere, higher
    orders are better than they are taken to be.)"""
    tolerances = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)

    def pulsating(contender):
        return prepared(PULSATING, tolerance=contender.tolerance)

    entries = {"taylor": tolerances}
    results = list(measure_all(entries, pulsating, values_of(PULSATING), DISTANCE, RULES, lambda: False))
    assert 0.9 < slope(tolerances, results) < 1.2
    assert all(each.error < each.contender.tolerance for each in results)


def test_the_error_is_that_beside_the_closed_form():
    (result,) = results_of({"DOP853": [1e-6]})
    followed = follow(prepare(result.contender), VALUES, TIMES, 60.0, lambda: False)
    assert followed.q.shape == (SAMPLES, 1)
    assert result.error == np.max(np.abs(followed.q[:, 0] - np.cos(2 * TIMES.chunk(0, SAMPLES))))
    assert not result.bounded and 1e-8 < result.error < 1e-3
    assert result.runs == 2 and result.seconds > 0 and result.evaluations > result.steps


@pytest.mark.exhaustive(keep=0.65)
def test_an_error_below_that_of_the_reference_is_only_bounded():
    (result,) = results_of({"taylor": [2.0**-52]})
    assert result.bounded and result.error == REFERENCE.error


def test_tolerances_are_tried_from_the_loosest_on_and_none_after_one_that_is_too_slow():
    results = results_of({"LSODA": [1e-9, 1e-6, 1e-12]}, rules=Rules(5, 1e-9))
    assert [each.contender.tolerance for each in results] == [1e-6, 1e-9, 1e-12]
    cut, *skipped = results
    assert (cut.status, cut.seconds, cut.error) == ("cut", None, None)
    assert cut.message.startswith("stopped after 1e-9 s (--budget) at t = ")
    assert [each.status for each in skipped] == ["skipped", "skipped"]
    assert skipped[1].message == "LSODA at 1e-6 already exceeded the budget"


def test_what_is_refused_or_fails_has_its_reason_and_does_not_disturb_the_others():
    class Collides:
        def follow(self, start, observer, threads):
            return End(Ending.STEP_UNDERFLOW, 1.5, start.state, 3, 4)

    def some(contender):
        if contender.tolerance == 1e-3:
            raise UsageError("too loose")
        ready = prepare(contender)
        return replace(ready, follower=Collides()) if contender.tolerance == 1e-5 else ready

    refused, failed, complete = results_of({"DOP853": [1e-3, 1e-5, 1e-7]}, some)
    assert (refused.status, refused.message) == ("refused", "too loose")
    assert failed.status == "failed" and failed.message.startswith(
        f"{Ending.STEP_UNDERFLOW.value} at t = 1.5"
    )
    assert (failed.steps, failed.evaluations, failed.seconds) == (3, 4, None)
    assert complete.status == "complete"
    assert choose([refused, failed], 1e-9).because == "no method reached the end"


def test_an_interrupt_ends_the_comparison_with_what_there_is():
    asked = []

    def prepare_some(contender):
        asked.append(contender)
        return prepare(contender)

    results = results_of(
        {"DOP853": [1e-4, 1e-6], "taylor": [1e-6]}, prepare_some, interrupted=lambda: len(asked) > 1
    )
    assert [each.contender for each in results] == asked[:1]


def result(method, tolerance, seconds, error):
    return Result(Contender(method, tolerance), "complete", seconds=seconds, runs=1, error=error)


def test_the_fastest_that_reaches_the_error_is_recommended():
    results = [
        result("taylor", 1e-6, 1.0, 1e-6),
        result("taylor", 1e-9, 2.0, 1e-9),
        result("taylor", 1e-12, 2.5, 1e-12),
        result("DOP853", 1e-9, 1.5, 1e-8),
        result("DOP853", 1e-12, 40.0, 1e-11),
    ]
    best = choose(results, 1e-9)
    assert best.result is results[1]
    assert best.because == "the fastest of 3 with this accuracy; DOP853 at 1e-12 takes 20 times as long"
    assert choose(results, 1e-8).result is results[3]
    assert choose(results, 1e-8).because.endswith("taylor at 1e-9 takes 1.3 times as long")
    assert choose(results, 1e-12).because == "the only one with this accuracy"
    assert choose(results[:3], 1e-9).because == "the fastest of 2 with this accuracy, all of the same method"


def test_where_none_reaches_it_the_nearest_is_named():
    best = choose([result("taylor", 1e-6, 1.0, 1e-6), result("BDF", 1e-9, 2.0, math.nan)], 1e-9)
    assert best.result is None
    assert best.because == "no method reaches this accuracy; the smallest error is 1.0e-6, of taylor at 1e-6"

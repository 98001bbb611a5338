"""A few motions of ``benchmarks.truth``, with numbers that are drawn anew."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.truth.drawing import cases
from benchmarks.truth.judge import DOUBLE_DOUBLE, MODES, RIGHT, SOLVE, SWEEP, judge

IN_EVERY_MODE = (
    "curved_line",
    "driven",
    "escaping",
    "falling",
    "falling_in_air",
    "large_argument",
    "oblique_corner",
    "pendulum",
    "relativistic",
    "vanishing_mass",
    "repelled",
    "end_of_time",
)
IN_DOUBLES = ("morse", "hole", "flat_well", "comb", "ramp", "two_pulses")


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize(
    ("kind", "modes"),
    [*((kind, MODES) for kind in IN_EVERY_MODE), *((kind, (SOLVE, SWEEP)) for kind in IN_DOUBLES)],
)
def test_the_motion_is_the_true_one(
    kind: str, modes: tuple[str, ...], tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    for case in cases(request.config.option.seed, 1, [kind]):
        for verdict in judge(case, modes, tmp_path):
            assert (verdict.verdict, verdict.because) == (RIGHT, ""), f"{verdict.mode}\n{case.text}"


def test_the_modes_are_those_of_the_suite() -> None:
    assert {SOLVE, SWEEP, DOUBLE_DOUBLE} == {*MODES}

"""A few motions of ``benchmarks.truth``, with numbers that are drawn anew."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.truth.drawing import FAMILIES, cases
from benchmarks.truth.judge import MODES, RIGHT, judge

OPEN = {"contact", "power_of_distance", "root_of_the_velocity", "on_a_belt", "pulled_by_a_spring"}
"""Kinds that are not always right yet; and so are these families:"""
OPEN_FAMILIES = {"impacts", "quadratures", "products"}
KINDS = [
    kind.__name__
    for family, kinds in FAMILIES.items()
    for kind in kinds
    if family not in OPEN_FAMILIES and kind.__name__ not in OPEN
]


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize("name", [f"{kind}_0" for kind in KINDS])
def test_the_motion_is_the_true_one(name: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    for case in cases(request.config.option.seed, 1, [name]):
        for verdict in judge(case, MODES, tmp_path):
            assert (verdict.verdict, verdict.because) == (RIGHT, ""), f"{verdict.mode}\n{case.text}"

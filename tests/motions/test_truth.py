"""A few motions of ``benchmarks.truth``, with numbers that are drawn anew; that script runs all kinds."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.truth.drawing import FAMILIES, cases
from benchmarks.truth.judge import RIGHT, judge
from benchmarks.truth.running import MODES

OPEN = {"repelled", "total_derivative"}
"""Kinds whose last digits in double-double are not always right."""
KINDS = [kind.__name__ for family, kinds in FAMILIES.items() for kind in kinds if kind.__name__ not in OPEN]


@pytest.mark.exhaustive(keep=0.2, most=30)
@pytest.mark.parametrize("name", [f"{kind}_0" for kind in KINDS])
def test_the_motion_is_the_true_one(name: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    for case in cases(request.config.option.seed, 1, [name]):
        for verdict in judge(case, MODES, tmp_path):
            assert (verdict.verdict, verdict.because) == (RIGHT, ""), f"{verdict.mode}\n{case.text}"

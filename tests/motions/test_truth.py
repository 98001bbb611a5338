"""A few motions of ``benchmarks.truth``, with numbers that are drawn anew."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.truth.drawing import cases
from benchmarks.truth.judge import MODES, RIGHT, judge

IN_EVERY_MODE = tuple(
    """
    one_sided_spring box ball_on_springy_floor wedge dead_zone saturated_spring bilinear_spring wall_in_time
    oblique_corner sliding_to_rest on_a_spring rough_patch from_a_time_on inclined_plane two_blocks quadratic_drag
    on_from_a_place window_in_space window_in_time gears governor thrust_until relay two_wells greater_of_two levels
    moving_front stiffness_at_a_time square_wave rectified braking_zone product_of_roots ramp comb two_pulses
    large_argument passed reflected step flat_well logarithm arcsine tangent blow_up end_of_time vanishing_mass
    repelled damped_oscillator slowed_down driven falling falling_in_air pendulum morse hole escaping relativistic
    curved_line
    """.split()
)


@pytest.mark.exhaustive(keep=4)
@pytest.mark.parametrize("kind", IN_EVERY_MODE)
def test_the_motion_is_the_true_one(kind: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    for case in cases(request.config.option.seed, 1, [kind]):
        for verdict in judge(case, MODES, tmp_path):
            assert (verdict.verdict, verdict.because) == (RIGHT, ""), f"{verdict.mode}\n{case.text}"

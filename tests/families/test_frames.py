"""Joints that move with t: h is conserved in frames that turn evenly, and in no others."""

from __future__ import annotations

import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.families.conserved.conservation import constants_of
from lagrange_cli.families.system import any_family_system
from lagrange_cli.run.check import classify
from lagrange_cli.run.classification import as_text
from lagrange_cli.spec.read import read_spec

TURNING = """
sizes: {{N: 20}}
parameters: {{w: 3, l: 1, g: 9.81, m: 1}}
coordinates: {{"a[i in range(N)]": {{initial: 0.1}}, "b[i in range(N)]": {{initial: 0.3 + i/40}}}}
masses: {{"p[i in range(N)]": m, "q[i in range(N)]": m}}
positions:
  "p[i in range(N)]": "[l*sin(a[i])*cos({turned}), l*sin(a[i])*sin({turned}), -l*cos(a[i])]"
  "q[i in range(N)]": "p[i] + [l*sin(b[i])*cos({turned}), l*sin(b[i])*sin({turned}), -l*cos(b[i])]"
potential: sum(m*g*(p[i].z + q[i].z) for i in range(N))
"""


@pytest.mark.parametrize(
    ("turned", "kept"),
    [
        ("w*t", True),
        ("2 - w*t/3", True),
        ("w*t + t**2/9", False),
        ("w*sin(t)", False),
        ("w*exp(-(t - 30)**2)", False),  # all but 0 where L is compared
        ("w*max(0, t - 9)", False),
    ],
)
def test_h_is_conserved_where_frames_turn_evenly(turned: str, kept: bool) -> None:
    system = any_family_system(read_spec(TURNING.format(turned=turned), "system.yaml"))
    assert system is not None and (system.driven_joints or not kept)
    found = constants_of(system)
    assert ("h" in {one.quantity for one in found.conserved}) == kept == (not found.timed)


def test_h_of_a_turning_frame_drifts_by_rounding() -> None:
    motion = lagrange.solve(TURNING.format(turned="w*t"), stop=3, samples=31, outputs="h")
    assert motion.attributes["h_drift"] < 1e-11
    faster = lagrange.solve(TURNING.format(turned="w*t + t**2"), stop=1, samples=31, outputs="h")
    assert np.isnan(faster.attributes["h_drift"])


def test_parts_of_the_energy_that_members_keep_are_one_line() -> None:
    text = as_text(classify(read_spec(TURNING.format(turned="w*t"), "system.yaml")), verbose=False)
    lines = [line for line in text.splitlines() if "the part of h" in line]
    assert [line.split(" = ")[0].strip() for line in lines] == ["h_a[i]"]
    assert lines[0].endswith("   [for i in range(20)]") and "with a[i], b[i]:" in lines[0]

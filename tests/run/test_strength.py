"""Singularities too weak to be felt are not leapt over; and only these cost anything."""

import math
import random
import re

import pytest

from lagrange_cli.run.strength import is_weak, suspicious
from tests.support.command import SYSTEMS, lagrange
from tests.support.motion import spec_of, values_of

LINE = "parameters: {{k: {k!r}}}\ncoordinates: {{x: {{initial: -1, velocity: {v!r}}}, y: {{initial: 0}}}}\n"
POTENTIALS = ["k/x", "-k/x**2", "k*log(-x)", "-k/sqrt(x**2 + y**2)", "-k*(x**2 + y**2)**-0.5 + y**2/2"]


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("potential", POTENTIALS)
@pytest.mark.parametrize("weak_by", ["strength", "speed"])
def test_a_pole_that_is_not_felt_ends_the_motion(tmp_path, potential, weak_by, request):
    source = random.Random(request.config.option.seed)
    k, v = 10 ** source.uniform(-40, -18), source.uniform(0.5, 2)
    if weak_by == "speed":
        k, v = 1.0, 10 ** source.uniform(9, 12)
    lagrangian = f"lagrangian: x_dot**2/2 + y_dot**2/2 - ({potential})\n"
    (tmp_path / "a.yaml").write_text(LINE.format(k=k, v=v) + lagrangian)
    done = lagrange("solve", "a.yaml", "--stop", 5 / v, "--samples", 3, cwd=tmp_path)
    assert done.returncode == 4
    told = re.search(r" reaches 0 in .* at t = (.*), where", done.stderr)
    assert told is not None
    felt = math.sqrt(k) / v if weak_by == "strength" else 0.0  # -k/x**2 is, where |x| is less than this
    assert float(told[1]) == pytest.approx(1 / v, rel=1e-8 + 4 * felt)


def test_members_of_a_sweep_are_looked_at_as_well(tmp_path):
    (tmp_path / "a.yaml").write_text(
        LINE.format(k=1.0, v=1.0) + "lagrangian: x_dot**2/2 + y_dot**2/2 - k/x\n"
    )
    done = lagrange("sweep", "a.yaml", "--over", "k=1e-22,1e-30", "--stop", 5, cwd=tmp_path)
    assert done.returncode == 4
    assert "2 of 2 members failed" in done.stderr


@pytest.mark.parametrize("system", [path.stem for path in sorted(SYSTEMS.glob("*.yaml"))])
def test_no_shipped_system_is_even_suspected(system):
    assert not suspicious(spec_of(system), values_of(system))


@pytest.mark.parametrize("potential", ["k*x**2", "k/(1 + x**2)", "k*exp(-x**2)", "1/x + k*x"])
def test_what_is_weak_without_a_singularity_needs_no_proof(potential):
    text = LINE.format(k=1e-30, v=1.0) + f"lagrangian: x_dot**2/2 + y_dot**2/2 - ({potential})\n"
    assert suspicious(spec_of(text), values_of(text))
    assert not is_weak(spec_of(text), 0.0, values_of(text))

"""Systems with events from the command line: members of a sweep, and what is refused."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from tests.support.command import lagrange

SPRING = """
name: a spring whose constant is switched, and a wall
parameters: {K: 3, k: 1, e: 0.8}
coordinates: {x: {initial: 1, velocity: 0}}
masses: {p: 1}
embedding: {p: [x]}
potential: k*x**2/2
events:
  switch: {when: x, action: {set: {k: 'where(k > 1.5, 1, K)'}}}
  wall: {when: x + 0.4, direction: falling, action: {set: {x_dot: -e*x_dot}}}
solve: {stop: 30, outputs: [q, v, h, ledger]}
"""


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("sampled", [True, False])
def test_members_of_a_sweep_are_what_they_are_alone(sampled, tmp_path):
    (tmp_path / "spring.yaml").write_text(SPRING)
    samples = ["--samples", "31", "--outputs", "q,v,h,ledger"] if sampled else []
    done = lagrange("sweep", "spring.yaml", "--over", "K=2,5", "-o", "all.h5", *samples, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    done = lagrange("solve", "spring.yaml", "--set", "K=5", "--samples", "31", "-o", "one.h5", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "all.h5") as every, h5py.File(tmp_path / "one.h5") as alone:
        for path in ("q/x", "v/x", "diagnostics/h", "diagnostics/ledger/h", "diagnostics/ledger/p/x"):
            member, known = np.asarray(every[path])[1], np.asarray(alone[path])
            if sampled:
                assert np.array_equal(member, known), path
            else:
                assert member == pytest.approx(known[-1], abs=1e-13), path
        assert np.abs(np.asarray(alone["diagnostics/ledger/h"])).max() < 1e-13


LEAKING = """
name: a cart that loses its load
parameters: {load: 1, lost: LOST, k: 1}
coordinates: {x: {initial: 1}, y[i in range(2)]: {initial: i}}
definitions: {mass: load/2}
masses: {cart: mass, other[i in range(2)]: i + mass}
embedding: {cart: [x], other[i in range(2)]: ["y[i]"]}
potential: k*x**2/2
events: {rising: x_dot, loses: {when: x, action: {set: {load: load - lost}}}}
"""


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_a_motion_ends_before_an_event_that_leaves_no_mass(precision, tmp_path):
    said = "a mass is no longer greater than 0 at t = {}, where "
    told = "(event 'loses' makes the mass of '{}' {}); let the action keep all masses greater than 0"
    for lost, t, mass in (
        ("1.5", "1.11072073", "-0.25"),
        ("1", "1.11072073", "0"),
        ("1/2", "2.68151706", "0"),
    ):
        (tmp_path / "leaking.yaml").write_text(LEAKING.replace("LOST", lost))
        options = ["--stop", "10", "--precision", precision, "--force"]
        done = lagrange("solve", "leaking.yaml", *options, cwd=tmp_path)
        assert done.returncode == 4
        assert said.format(t) in done.stderr and told.format("cart", mass) in done.stderr
        with h5py.File(tmp_path / "leaking.h5") as file:
            x = 1 - np.asarray(file["v/x"]) ** 2 / 2 if lost != "1/2" else np.zeros(0)
            assert np.abs(np.asarray(file["q/x"])[: len(x)] ** 2 - x).max(initial=0.0) < 1e-15
    done = lagrange("sweep", "leaking.yaml", "--over", "lost=0.1,2", "--stop", "4", cwd=tmp_path)
    assert done.returncode == 4
    assert "1 of 2 members failed; member 1 (lost = 2): a mass is no longer" in done.stderr


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            ["--method", "LSODA"],
            "a system with events needs method taylor, ias15, DOP853 or Radau, not LSODA",
        ),
        (["--start", "30", "--stop", "0"], "cannot be undone in a motion that is integrated backward"),
    ],
)
def test_what_cannot_be_done_with_events(options, said, tmp_path):
    (tmp_path / "spring.yaml").write_text(SPRING)
    done = lagrange("solve", "spring.yaml", *options, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert not list(tmp_path.glob("*.h5"))

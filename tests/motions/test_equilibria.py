"""Coordinates that hardly move: rates that are rounding must neither set the step nor stop the motion."""

from __future__ import annotations

import json
import math
from pathlib import Path
from unittest.mock import patch

import h5py
import numpy as np
import pytest

from lagrange_cli.api.sweep import sweep
from tests.support.command import lagrange
from tests.support.motion import follow

LAGRANGE_POINT = """
parameters: {mu: 0.01}
coordinates: {x: {initial: 0.5 - mu}, y: {initial: sqrt(3)/2}}
lagrangian: >
  (x_dot**2 + y_dot**2)/2 + x*y_dot - y*x_dot + (x**2 + y**2)/2
  + (1 - mu)/sqrt((x + mu)**2 + y**2) + mu/sqrt((x - 1 + mu)**2 + y**2)
"""


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize(
    ("system", "start", "steps"),
    [
        ("central_force", {"r": 1.0, "r_dot": 0.0, "theta_dot": 1.0}, 10),  # a circle, exactly
        ("central_force", {"r": 1.1, "r_dot": 0.0, "theta_dot": 1.1**-1.5}, 1000),  # a circle, up to rounding
        ("rotating_hoop", {"theta": float(np.arccos(0.25)), "theta_dot": 0.0}, 2000),
        ("rotating_hoop", {"theta": 1e-300, "theta_dot": 0.0}, 2000),
        ("pendulum", {"theta": np.pi, "theta_dot": 0.0}, 2000),  # pi is not quite the top
        ("pendulum", {"theta": 0.0, "theta_dot": 0.0}, 1),
        (LAGRANGE_POINT, {}, 500),
    ],
)
def test_equilibria_take_no_more_steps_than_motions_about_them(
    system: str, start: dict[str, float], steps: int
) -> None:
    motion = follow(system, 100.0, 11, sets=start)
    assert motion.t[-1] == 100.0
    assert motion.outcome.steps <= steps
    h = motion["diagnostics/h"]
    assert abs(h - h[0]).max() <= 1e-13 * max(1.0, abs(h[0]))


def test_stable_equilibria_stay_where_they_are() -> None:
    motion = follow(LAGRANGE_POINT, 100.0, 11)
    for name in "xy":
        assert np.ptp(motion[f"q/{name}"]) < 1e-12
    circle = follow("central_force", 100.0, 11, sets={"r": 1.1, "r_dot": 0.0, "theta_dot": 1.1**-1.5})
    assert np.ptp(circle["q/r"]) < 1e-13
    assert abs(circle["q/theta"] - 1.1**-1.5 * circle.t).max() < 1e-11


DECAYING = """
coordinates: {x: {initial: 1, velocity: 1}, z: {initial: 1}}
masses: {p: 1, r: 1}
embedding: {p: [x], r: [z]}
potential: z**2/2
dissipation: x_dot**2/2
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("options", [(), ("--precision", "double-double")])
def test_what_has_decayed_below_the_smallest_numbers_does_not_end_the_motion(tmp_path, options):
    """At t = 750 the velocity of x is less than any number; z moves on."""
    (tmp_path / "decaying.yaml").write_text(DECAYING)
    run = lagrange("solve", "decaying.yaml", "--stop", "1000", "--samples", "3", *options, cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    with h5py.File(tmp_path / "decaying.h5") as file:
        assert abs(file["q/x"][-1] - 2) < 1e-14
        assert abs(file["q/z"][-1] - math.cos(1000)) < 1e-12
        assert file.attrs["steps"] < 1500


HANGING = """
parameters: {k: 47.0, a: 0.1, g: 9.81}
coordinates: {r: {initial: a + g/k}, theta: {initial: 0.0}}
lagrangian: (r_dot**2 + r**2*theta_dot**2)/2 + g*r*cos(theta) - k/2*(r - a)**2
"""
FALLING = """
parameters: {k: 50.0, a: 0.1, g: 9.81}
coordinates: {x: {initial: 0.0}, z: {initial: 0.0}, X: {initial: a}, Z: {initial: 0.0}}
lagrangian: >
  (x_dot**2 + z_dot**2 + X_dot**2 + Z_dot**2)/2 - g*(z + Z)
  - k/2*(sqrt((X - x)**2 + (Z - z)**2) - a)**2 - 1000*k*(x**2 + z**2)
"""
SPRINGS = """
parameters: {k: 50.0, a: 0.1}
coordinates: {x: {initial: 0.0}, y: {initial: a}}
lagrangian: >
  (x_dot**2 + y_dot**2)/2 - 1000*k*x**2
  - k/2*(sqrt((x - y)**2 + 0.01*y**2) - sqrt(1.01)*a)**2
solve: {stop: 1, samples: 2}
"""
OUTPUTS = ("q", "v", "p", "h", "ledger")


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("k", [47.0, 43.0, 3.3, 7.7])
def test_ledgers_close_where_forces_are_rounding(k: float) -> None:
    """A mass hangs at rest from a spring: its weight and the force of the spring cancel."""
    motion = follow(HANGING, 10.0, 6, sets={"k": k, "theta": 1e-17}, outputs=OUTPUTS)
    for quantity in ("h", "p/r", "p/theta"):
        assert abs(motion[f"diagnostics/ledger/{quantity}"]).max() < 1e-13


@pytest.mark.exhaustive(keep=0.7)
def test_ledgers_close_where_forces_begin_as_rounding() -> None:
    """Of two bodies with a spring at its natural length, one is held: the force along the spring grows with
    the fourth power of time."""
    motion = follow(FALLING, 1.0, 6, outputs=OUTPUTS)
    for quantity in ("h", "p/x", "p/z", "p/X", "p/Z"):
        assert abs(motion[f"diagnostics/ledger/{quantity}"]).max() < 1e-13


def test_double_double_steps_where_forces_are_rounding(tmp_path: Path) -> None:
    """A spring at its natural length, up to rounding, beside one at which nothing moves."""
    file = tmp_path / "springs.yaml"
    file.write_text(SPRINGS, encoding="utf-8")
    run = lagrange("solve", file, "--precision", "double-double", "--json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    summary = json.loads(run.stdout)
    assert summary["steps"] < 1000
    assert summary["warning"] is None  # h is nothing but rounding, too


@pytest.mark.exhaustive(keep=0.7)
def test_double_double_ledgers_close_where_forces_begin_as_rounding(tmp_path: Path) -> None:
    """The force along the spring is far below the other forces at first, and known to fewer digits."""
    file = tmp_path / "falling.yaml"
    file.write_text(FALLING, encoding="utf-8")
    options = "--precision", "double-double", "--outputs", "ledger", "--stop", "0.02", "--samples", "6"
    run = lagrange("solve", file, *options, cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    with h5py.File(tmp_path / "falling.h5") as data:
        for quantity in ("h", "p/x", "p/z", "p/X", "p/Z"):
            assert abs(data[f"diagnostics/ledger/{quantity}"][:]).max() < 1e-28


NET = """
sizes: {N: 4}
parameters: {m: 0.01, k: 50.0, a: 0.1, c: 0.002, g: 9.81}
coordinates:
  x[i in range(N), j in range(N)]: {initial: a*i}
  y[i in range(N), j in range(N)]: {initial: a*(j + 1)}
  z[i in range(N), j in range(N)]: {initial: 0.0}
masses: {"knot[i in range(N), j in range(N)]": m}
embedding: {"knot[i in range(N), j in range(N)]": ["x[i,j]", "y[i,j]", "z[i,j]"]}
potential: >-
  sum(m*g*z[i,j] for i in range(N) for j in range(N))
  + sum(k/2*(sqrt((x[i+1,j]-x[i,j])**2 + (y[i+1,j]-y[i,j])**2 + (z[i+1,j]-z[i,j])**2) - a)**2
      for i in range(N-1) for j in range(N))
  + sum(k/2*(sqrt((x[i,j+1]-x[i,j])**2 + (y[i,j+1]-y[i,j])**2 + (z[i,j+1]-z[i,j])**2) - a)**2
      for i in range(N) for j in range(N-1))
  + sum(1000*k/2*(x[0,j]**2 + (y[0,j]-a*(j + 1))**2 + z[0,j]**2) for j in range(N))
dissipation: sum(c/2*(x_dot[i,j]**2+y_dot[i,j]**2+z_dot[i,j]**2) for i in range(N) for j in range(N))
"""


@pytest.mark.exhaustive(keep=0.25)
def test_ledgers_of_a_net_close_at_samples_within_steps_of_few_parts() -> None:
    """A hanging net swings in planes, but for rounding. Its series are computed in batches; a part that
    rounding stops is tried again once, so that no step has more than a few."""
    with patch("lagrange_cli.native.stepping.division.MOST", 6):
        motion = follow(NET, 0.05, 301, outputs=OUTPUTS)
    for quantity in ("h", "p/x", "p/y", "p/z"):
        assert abs(motion[f"diagnostics/ledger/{quantity}"]).max() < 1e-15


@pytest.mark.exhaustive(keep=0.2)
def test_ledgers_of_a_net_continue_with_the_same_bytes(tmp_path: Path) -> None:
    """What was measured of rounding goes on with the state."""
    (tmp_path / "net.yaml").write_text(NET, encoding="utf-8")
    options = "--step", "0.001", "--outputs", "ledger"
    for name, stop, more in (("parts", "0.02", ()), ("parts", "0.03", ("--resume",)), ("whole", "0.03", ())):
        run = lagrange("solve", "net.yaml", "--stop", stop, *options, *more, "-o", f"{name}.h5", cwd=tmp_path)
        assert run.returncode == 0, run.stderr
    with h5py.File(tmp_path / "parts.h5") as parts, h5py.File(tmp_path / "whole.h5") as whole:
        for path in ("h", "p/x", "p/y", "p/z"):
            assert (
                parts[f"diagnostics/ledger/{path}"][:].tobytes()
                == whole[f"diagnostics/ledger/{path}"][:].tobytes()
            )


PINNED = """
sizes: {N: 3}
parameters: {m: 0.01, k: 50.0, a: 0.1, g: 9.81}
coordinates:
  x[i in range(N), j in range(N)]: {initial: a*j}
  y[i in range(N), j in range(N)]: {initial: a*(i + 1)}
  z[i in range(N), j in range(N)]: {initial: 0.0}
masses: {"knot[i in range(N), j in range(N)]": m}
embedding: {"knot[i in range(N), j in range(N)]": ["x[i,j]", "y[i,j]", "z[i,j]"]}
potential: >-
  sum(m*g*z[i,j] for i in range(N) for j in range(N))
  + sum(k/2*(sqrt((x[i+1,j]-x[i,j])**2 + (y[i+1,j]-y[i,j])**2 + (z[i+1,j]-z[i,j])**2) - a)**2
      for i in range(N-1) for j in range(N))
  + sum(k/2*(sqrt((x[i,j+1]-x[i,j])**2 + (y[i,j+1]-y[i,j])**2 + (z[i,j+1]-z[i,j])**2) - a)**2
      for i in range(N) for j in range(N-1))
constraints: {"along[j in range(N)]": "x[0,j] - a*j", "across[j in range(N)]": "y[0,j] - a",
  "up[j in range(N)]": "z[0,j]"}
"""
HUNG = """
parameters: {k: 47.0, a: 1.0, g: 9.81}
coordinates: {r: {initial: 1.5}, theta: {initial: 0.0}, s: {initial: 0.0}}
lagrangian: >
  (r_dot**2 + r**2*theta_dot**2 + s_dot**2)/2 + g*r*cos(theta) - k/2*(r - a)**2 - 37**2*s**2/2
"""
WAVE = """
sizes: {N: 9}
coordinates: {"x[i in range(N)]": {initial: 0.0}, y: {initial: 0.0, velocity: 1.0}}
lagrangian: >
  y_dot**2/2 - (x[0] - y)**2/2
  + sum(x_dot[i]**2/2 for i in range(N)) - sum((x[i+1] - x[i])**2/2 for i in range(N-1))
"""


@pytest.mark.exhaustive(keep=0.4)
def test_velocities_that_are_rounding_do_not_set_the_steps() -> None:
    """Of a net that hangs from three pins the columns move alike, each in its plane. Their distances are
    rounding, far below that of their places; steps that followed these were shorter than 2e-6."""
    motion = follow(PINNED, 1.0, 11)
    assert motion.outcome.steps < 400
    h = motion["diagnostics/h"]
    assert np.ptp(h) < 1e-14
    assert np.ptp(motion["q/x"], axis=0).max() < 1e-12


@pytest.mark.exhaustive(keep=0.25)
def test_double_double_velocities_that_are_rounding_do_not_set_the_steps(tmp_path: Path) -> None:
    """The same net: steps were shorter than 1e-10."""
    (tmp_path / "net.yaml").write_text(PINNED, encoding="utf-8")
    options = "--precision", "double-double", "--stop", "0.02", "--samples", "2", "--json"
    run = lagrange("solve", "net.yaml", *options, cwd=tmp_path)
    summary = json.loads(run.stdout)
    assert summary["steps"] < 100
    assert summary["h_drift"] < 1e-31


@pytest.mark.exhaustive(keep=0.4)
def test_members_in_lanes_are_not_held_up_by_rounding(tmp_path: Path) -> None:
    """The same net with several springs: steps were shorter than 1e-4."""
    (tmp_path / "net.yaml").write_text(PINNED, encoding="utf-8")
    options = "--over", "k=40:60:9", "--stop", "0.05", "--samples", "2", "--outputs", "q,h"
    run = lagrange("sweep", "net.yaml", *options, "-o", "net.h5", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    with h5py.File(tmp_path / "net.h5") as file:
        assert max(file["steps"]) < 100
        assert np.ptp(file["q/x"][:, -1], axis=1).max() < 1e-13  # of the columns


def test_members_in_lanes_keep_the_digits_of_small_motions() -> None:
    """Swings of all sizes beside one another, and one without any rounding that is measured."""
    sizes = [1e-280, 1e-9, 1e-20, 1e-100, 1e-9, 0.0, 1e-250, 1e-30, 1e-200]
    swept = sweep(HUNG, over={"theta": sizes}, stop=5.0, samples=11, outputs="q", cache=False)
    swings = np.asarray(swept.q["theta"])
    swing = swings[1] / 1e-9
    for size, found in zip(sizes, swings):
        assert abs(found - size * swing).max() <= 1e-12 * size * abs(swing).max()


@pytest.mark.parametrize("size", [1e-20, 1e-100, 1e-280])
def test_small_motions_keep_their_digits(size: float) -> None:
    """A swing that a vertical spring makes grow, and a spring beside it, both of any size."""
    large, small = (follow(HUNG, 20.0, 41, sets={"theta": one, "s": one}) for one in (1e-9, size))
    swing = large["q/theta"] / 1e-9
    assert abs(small["q/theta"] / size - swing).max() < 1e-12 * abs(swing).max()
    assert abs(small["q/s"] / size - np.cos(37.0 * small.t)).max() < 1e-12


def test_the_tail_of_a_wave_keeps_its_digits() -> None:
    """In a chain of springs, the k-th mass begins to move like t^(2k + 1)/(2k + 1)!."""
    motion = follow(WAVE, 1e-4, 2)
    for k in range(1, 10):
        known = 1e-4 ** (2 * k + 1) / math.factorial(2 * k + 1)
        assert motion["q/x"][-1, k - 1] == pytest.approx(known, rel=1e-7)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("nod", [0.0, 1e-14, 1e-13])
def test_rounding_is_followed_as_precisely_as_what_moves(nod: float) -> None:
    """A coin that leans and rolls in a circle nods at 17 rad/s. Longer steps would leave out what is only
    rounding today, and make it a nod a thousand times as large."""
    motion = follow("coin", 5.0, 51, sets={"disturbance": nod})
    assert motion.outcome.steps < 120
    assert abs(motion["q/theta"] - motion["q/theta"][0]).max() < nod / 17 + 8e-15

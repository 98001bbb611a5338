"""Problems of the test set for IVP solvers, and motions with constraints whose closed form is known.

The digits cited are those of F. Mazzia and C. Magherini, Test Set for Initial Value Problem Solvers, release
2.4 (2008), from the routines ``solut`` of its programs. The multipliers there have the opposite sign where it
writes M a = f - G^T lambda.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks import ROOT
from tests.support.motion import CONSTRAINED, SYSTEMS, Motion, follow

Array = NDArray[np.float64]
OUTPUTS = ("q", "v", "multipliers", "constraints")
CONSERVATIVE = (*OUTPUTS, "h")


def problem(name: str) -> str:
    """The text of a system file: one that is shipped, or one of the benchmarks."""
    folder = SYSTEMS if name in CONSTRAINED else ROOT / "benchmarks" / "motions" / "constrained"
    return (folder / f"{name}.yaml").read_text(encoding="utf-8")


def residual(motion: Motion) -> float:
    """The largest value of a constraint."""
    return max(abs(x).max() for path, x in motion.data.items() if path.startswith("diagnostics/constraints"))


def ends(motion: Motion, paths: str, prefix: str = "q") -> Array:
    """The last values of some series."""
    return np.array([motion[f"{prefix}/{name}"][-1] for name in paths.split()])


@pytest.mark.exhaustive(keep=0.4)
def test_andrews_squeezer():
    """The published digits are wrong from the tenth on, those of the multipliers from the seventh. These come
    from double-double precision; DOP853 with a relative tolerance of 1e-13 agrees with them to 2e-13, on
    equations of index 1 that were written by hand."""
    motion = follow(problem("andrews_squeezer"), 0.03, 4, outputs=OUTPUTS)
    known = [
        15.810771195153706, -15.756371058411839, 0.040822240119645796, -0.5347301163420796,
        0.5244099658799540, 0.5347301163420796, 1.048080741041938,
    ]  # fmt: skip
    names = "beta theta gamma phi delta omega epsilon"
    assert np.abs(ends(motion, names) - known).max() < 1e-12
    published = [
        15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948,
        0.5244099658805304, 0.5347301163226948, 1.048080741042263,
    ]  # fmt: skip
    assert 1e-9 < np.abs(ends(motion, names) - published).max() < 2e-9
    multipliers = [
        -199.17534810453864, 29.755309974971663, -23.06654361162216, -31.45272527577116,
        -22.642494786394384, -11.617392352611223,
    ]  # fmt: skip
    assert np.abs(ends(motion, "g1 g2 g3 g4 g5 g6", "multipliers") - multipliers).max() < 1e-9
    assert residual(motion) < 1e-16


@pytest.mark.exhaustive(keep=0.45)
def test_car_axis():
    """The constraint at the right wheel depends on t."""
    motion = follow(problem("car_axis"), 3.0, 301, outputs=(*OUTPUTS, "ledger"))
    wheels = "xl yl xr yr"
    positions = [
        0.0493455784275402809122, 0.496989460230171153861, 1.04174252488542151681, 0.373911027265361256927,
    ]  # fmt: skip
    velocities = [
        -0.0770583684040972358, 0.00744686658723778553, 0.0175568157537232222, 0.770341043779251976,
    ]  # fmt: skip
    multipliers = [-0.00473688659084893324729, -0.00110468033125734368808]
    assert np.abs(ends(motion, wheels) - positions).max() < 1e-12
    assert np.abs(ends(motion, wheels, "v") - velocities).max() < 2e-11
    assert np.abs(ends(motion, "suspension axle", "multipliers") - multipliers).max() < 1e-13
    assert residual(motion) < 1e-15
    for name in ("h", *(f"p/{name}" for name in wheels.split())):
        assert np.abs(motion[f"diagnostics/ledger/{name}"]).max() < 1e-16


@pytest.mark.exhaustive(keep=0.45)
def test_flexible_slider_crank():
    """Without damping, with linear stiffness: rods that oscillate 20000 times a second."""
    motion = follow(problem("slider_crank"), 0.1, 101, outputs=OUTPUTS)
    rigid = [15.0, -0.3311734988256260, 0.1697373328427860]
    elastic = [0.1893192899613509e-3, 0.2375751249879174e-4, -0.5323896770569702e-5, -0.8363313279112129e-5]
    assert np.abs(ends(motion, "phi1 phi2 x3") - rigid).max() < 1e-12
    assert np.abs(ends(motion, "q1 q2 q3 q4") - elastic).max() < 1e-13
    multipliers = np.array([-62.32935833287916, -163.7920993367306, 25.29857947066878])
    assert np.abs(ends(motion, "f1 f2 f3", "multipliers") + multipliers).max() < 1e-7
    assert residual(motion) < 1e-15


@pytest.mark.exhaustive(keep=0)
@pytest.mark.parametrize("stop", [1000.0])
def test_fekete_points(stop):
    """Damped, so that what is reached is known to 1e-12: the first, the last and their multipliers."""
    motion = follow(problem("fekete"), stop, 11, outputs=OUTPUTS)
    points = np.stack([motion[f"q/{x}"][-1] for x in "xyz"], axis=-1)
    first = [-0.4070263380333202, 0.3463758772791802, 0.8451942450030429]
    last = [0.2414481766969039, -0.3416456818373135, -0.9082846503446250]
    assert np.abs(points[0] - first).max() < 1e-11
    assert np.abs(points[-1] - last).max() < 1e-11
    assert np.abs((points**2).sum(axis=-1) - 1).max() < 1e-15
    assert np.abs(motion["multipliers/sphere"][-1] + 19 / 4).max() < 1e-12  # the virial: N - 1 pairs each
    assert max(np.abs(motion[f"v/{x}"][-1]).max() for x in "xyz") < 1e-14


@pytest.mark.exhaustive(keep=0)
def test_fekete_points_pass_the_time_at_which_others_lose_them():
    """ModelingToolkit ends at t = 4 (its issue 5012)."""
    motion = follow(problem("fekete"), 8.0, 9, outputs=("constraints",))
    assert motion.outcome.ending.status == "complete"
    assert residual(motion) < 1e-15


@pytest.mark.exhaustive(keep=0)
def test_wheelset():
    """The creep forces depend on the normal forces. The digits of the test set are those of DASSL with
    tolerances of 1e-9; here those of multipliers agree to 1e-8, others to 5e-6. Conditions of contact have no
    force."""
    motion = follow(problem("wheelset"), 10.0, 11, outputs=(*OUTPUTS, "ledger"))
    places = [
        0.86355386965811e-2, 0.13038281022727e-4, -0.93635784016818e-4, -0.13642299804033e-1,
        0.15292895005422e-2,
    ]  # fmt: skip
    speeds = [
        -0.76985374142666e-1, -0.25151106429207e-3, 0.20541188079539e-2, -0.23904837703692,
        -0.13633468454173e-1, -0.24421377661131,
    ]  # fmt: skip
    assert np.abs(ends(motion, "x y z theta phi") / places - 1).max() < 5e-6
    assert np.abs(ends(motion, "x y z theta phi beta", "v") / speeds - 1).max() < 2e-6
    assert np.abs(motion["multipliers/touch"][0] + [83.593, 74.144]).max() < 2e-3
    assert np.abs(motion["multipliers/touch"][-1] + [101.24044903201, 56.285630573753]).max() < 2e-6
    assert np.abs(motion["q/xi"][-1] - [0.14173214964613, -0.15949425684022]).max() < 1e-9
    assert np.abs(motion["q/psi"][-1] - [0.37839614386969e-3, -0.33666751972196e-3]).max() < 2e-10
    assert max(np.abs(motion[f"multipliers/{name}"]).max() for name in ("along", "upright")) < 1e-13
    assert residual(motion) < 1e-14


def pendulum_of_hairer_and_wanner(t: Array) -> tuple[Array, Array, Array]:
    """x, y and lambda of the pendulum with m = l = g = 1 that is released from the horizontal, by Jacobi's
    functions: sin(theta/2) = k sn(K - t), k^2 = 1/2."""
    from mpmath import ellipfun, ellipk, mp

    with mp.workdps(30):
        m = mp.mpf(1) / 2
        half = np.array([float(mp.sqrt(m) * ellipfun("cd", float(x), m=m)) for x in t])
        assert abs(float(ellipk(m)) - 1.854074677301372) < 1e-15
    x, y = 2 * half * np.sqrt(1 - half**2), 2 * half**2 - 1
    return x, y, 3 * y / 2


@pytest.mark.exhaustive(keep=0.7)
def test_pendulum_of_hairer_and_wanner():
    """E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, sec. VII.1."""
    text = """
    coordinates: {x: {initial: 1}, y: {initial: 0}}
    masses: {bob: 1}
    positions: {bob: [x, y]}
    potential: y
    constraints: {rod: x**2 + y**2 - 1}
    """
    motion = follow(text, 100.0, 401, outputs=OUTPUTS)
    x, y, multiplier = pendulum_of_hairer_and_wanner(motion.t)
    assert np.abs(np.abs(motion["q/x"]) - np.abs(x)).max() < 3e-14 * 100
    assert np.abs(motion["q/y"] - y).max() < 1e-12
    assert np.abs(motion["multipliers/rod"] - multiplier).max() < 2e-12
    assert residual(motion) < 1e-15


@pytest.mark.exhaustive(keep=0.65)
def test_four_bar_linkage():
    motion = follow(problem("four_bar"), 100.0, 1001, outputs=CONSERVATIVE)
    energy = motion["diagnostics/h"]
    assert residual(motion) < 1e-15
    assert np.abs(energy - energy[0]).max() < 1e-14 * abs(energy[0]) * 10


@pytest.mark.exhaustive(keep=0.25)
def test_coupled_four_bar_linkages_pass_the_horizontal():
    """All bars are equal, so that they move as one bar: J theta'' = K sin(theta). In the horizontal, which is
    passed ten times, all bars are in one line, and the rank of the constraints drops."""
    count = 5
    inertia, pull = (count + 1) / 3 + count, 9.81 * ((count + 1) / 2 + count)
    angle = solve_ivp(
        lambda t, y: [y[1], pull / inertia * np.sin(y[0])], (0, 10), [0, 1], method="DOP853", rtol=1e-13,
        atol=1e-14, dense_output=True,
    ).sol  # fmt: skip
    motion = follow(problem("n_four_bar"), 10.0, 101, outputs=CONSERVATIVE)
    for i in range(count + 1):
        assert np.abs(motion[f"q/x[{i}]"] - i - np.sin(angle(motion.t)[0])).max() < 1e-10


@pytest.mark.exhaustive(keep=0.4)
def test_chain_in_cartesian_coordinates():
    angles = follow("n_pendulum", 2.0, 21, outputs=("positions",))
    text = problem("chain").replace("N: 10", "N: 5")
    motion = follow(text, 2.0, 21, outputs=CONSERVATIVE)
    assert residual(motion) < 1e-14
    bobs = angles["positions/bob"]
    for axis, name in enumerate("xy"):
        assert np.abs(motion[f"q/{name}"] - bobs[..., axis]).max() < 1e-11


def knife_edge(t: Array) -> dict[str, Array]:
    """A cycloid (Yu. I. Neimark and N. A. Fufaev, Dynamics of Nonholonomic Systems, 1972)."""
    w = 1.5
    size = 9.81 * np.sin(np.pi / 6) / (2 * w**2)
    return {"q/x": size * np.sin(w * t) ** 2, "q/y": size * (w * t - np.sin(2 * w * t) / 2), "q/theta": w * t}


def chaplygin_sleigh(t: Array) -> dict[str, Array]:
    """theta' = w/cosh(k t) (S. A. Chaplygin 1911)."""
    w, inertia, a = 2.0, 0.3 + 0.5**2, 0.5
    k = a * w / np.sqrt(inertia)
    return {"v/theta": w / np.cosh(k * t), "q/theta": 2 * w / k * np.arctan(np.tanh(k * t / 2))}


def turntable_ball(t: Array) -> dict[str, Array]:
    """Circles, at 2/7 of the angular velocity of the turntable (S. Earnshaw 1844)."""
    n = 2 / 7 * 7.0
    sine, rest = np.sin(n * t), 1 - np.cos(n * t)
    return {"q/x": 0.2 + (0.1 * sine - 0.3 * rest) / n, "q/y": (0.1 * rest + 0.3 * sine) / n}


def cylinder_ball(t: Array) -> dict[str, Array]:
    """Up and down sqrt(2/7) times for each time around (E. J. Routh, Advanced Rigid Dynamics, 1884)."""
    w, k = 6.0, np.sqrt(2 / 7) * 6.0
    force = -5 / 7 * 9.81 - 2 / 7 * w * 0.05 * 3
    return {"q/phi": w * t, "q/z": force / k**2 * (1 - np.cos(k * t)) + 0.4 / k * np.sin(k * t)}


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("known", [knife_edge, chaplygin_sleigh, turntable_ball, cylinder_ball])
def test_nonholonomic_motions(known: Callable[[Array], dict[str, Array]]):
    motion = follow(problem(known.__name__), 10.0, 101, outputs=(*CONSERVATIVE, "ledger"))
    for path, values in known(motion.t).items():
        assert np.abs(motion[path] - values).max() < 3e-14
    assert residual(motion) < 5e-14
    for path, values in motion.data.items():
        if path.startswith("diagnostics/ledger"):
            assert np.abs(values).max() < 1e-12


def rolling(t: float, state: Array, radius: float, gravity: float) -> list[float]:
    """Newton's and Euler's equations of a disc of mass 1 that rolls, in axes along its heading, to its centre
    and normal to both: theta, theta', phi, phi', the spin, x and y of the centre."""
    theta, rate, phi, turn, spin, _, _ = state
    s, c = np.sin(theta), np.cos(theta)
    inertia, centre = radius**2 / 4 * np.array([1, 1, 2]), np.array([0, radius, 0])
    axes, omega = np.array([-rate, turn * c, turn * s]), np.array([-rate, turn * c, -spin])

    def torque(unknown: Array) -> Array:
        alpha = np.array([-unknown[0], unknown[1] * c - turn * rate * s, -unknown[2]])
        force = (
            np.cross(alpha, centre) + np.cross(axes, np.cross(omega, centre)) + gravity * np.array([0, c, s])
        )
        return inertia * alpha + np.cross(axes, inertia * omega) + np.cross(centre, force)

    rest = torque(np.zeros(3))
    found = np.linalg.solve(np.column_stack([torque(one) - rest for one in np.eye(3)]), -rest)
    along, across = radius * spin, radius * rate * c
    centre_moves = [along * np.cos(phi) - across * np.sin(phi), along * np.sin(phi) + across * np.cos(phi)]
    return [rate, found[0], turn, found[1], found[2], *centre_moves]


@pytest.mark.exhaustive(keep=0.15)
def test_rolling_disc():
    motion = follow(problem("rolling_disc"), 2.0, 3, outputs=(*CONSERVATIVE, "ledger"))
    start = [0.2, 0, 0, 1.0, 10 - np.sin(0.2), 0, 0]
    rates = partial(rolling, radius=0.3, gravity=9.81)
    known = solve_ivp(rates, (0, 2), start, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    assert np.abs(ends(motion, "theta phi x y") - known[[0, 2, 5, 6]]).max() < 1e-10
    assert residual(motion) < 1e-14
    assert np.ptp(motion["diagnostics/h"]) < 1e-13


WHIPPLE = """
parameters: {speed: 5.0, g: 9.81}
coordinates: {phi: {initial: 0}, delta: {initial: 0}}
lagrangian: >-
  (80.81722*phi_dot**2 + 2*2.31941332208709*phi_dot*delta_dot + 0.29784188199686*delta_dot**2)/2
  - g*(-80.95*phi**2 - 2*2.59951685249872*phi*delta - 0.80329488458618*delta**2)/2
generalized_forces:
  phi: -speed*33.86641391492494*delta_dot - speed**2*76.59734589573222*delta
  delta: speed*(0.85035641456978*phi_dot - 1.68540397397560*delta_dot) - speed**2*2.65431523794604*delta
"""
"""The benchmark bicycle (J. P. Meijaard, J. M. Papadopoulos, A. Ruina and A. L. Schwab, Proc. R. Soc. A 463,
2007, sec. 5), linearized: M q'' + v C1 q' + (g K0 + v^2 K2) q = 0."""


@pytest.mark.parametrize(
    ("speed", "weaves"), [(4.29238253634111, True), (6.02426201538837, False)], ids=["weave", "capsize"]
)
def test_whipples_bicycle_is_indifferent_at_its_critical_speeds(speed, weaves):
    """Its motions over 1 s from each start are the columns of exp(A t): an eigenvalue has no real part."""
    starts = ("phi", "delta", "phi_dot", "delta_dot")
    motions = [follow(WHIPPLE, 1.0, 2, sets={"speed": speed, one: 1.0}) for one in starts]
    paths = ("q/phi", "q/delta", "v/phi", "v/delta")
    found = np.linalg.eigvals(np.array([[motion[path][-1] for motion in motions] for path in paths]))
    off = np.abs(np.log(np.abs(found[np.abs(found.imag) > 1e-3] if weaves else found)))
    assert off.min() < 3e-12

"""``--precision double-double`` against closed forms and second routes with fifty digits."""

from itertools import pairwise

import h5py
import mpmath
import numpy as np
import pytest

from tests.support.command import SYSTEMS, lagrange

MP = mpmath.mp.clone()
MP.dps = 50
LONG = ("--precision", "double-double")


def solved(folder, system, *options):
    """(attributes, {path: values with all their digits}) of a run."""
    name = system
    if "\n" in str(system):
        name = folder / "system.yaml"
        name.write_text(system, encoding="utf-8")
    run = lagrange("solve", name, "-o", "out.h5", "--force", "--quiet", *options, cwd=folder)
    assert (run.returncode, run.stderr) == (0, "")
    with h5py.File(folder / "out.h5") as file:
        found = {}

        def visit(path, item):
            if isinstance(item, h5py.Dataset) and item.dtype == float and not path.startswith("low/"):
                low = file[f"low/{path}"][:] if f"low/{path}" in file else np.zeros_like(item[:])
                pairs = zip(item[:].ravel(), low.ravel())
                found[path] = [MP.mpf(float(a)) + MP.mpf(float(b)) for a, b in pairs]

        file.visititems(visit)
        return dict(file.attrs), found


def largest(found, known):
    return max(abs(a - b) for a, b in zip(found, known, strict=True))


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("system", ["central_force_cartesian", "central_force"])
def test_kepler(tmp_path, system):
    """Ten periods of an ellipse with e = 0.6."""
    attributes, found = solved(
        tmp_path, SYSTEMS / f"{system}.yaml", *LONG, "--samples", "41", "--outputs", "q,v,p,h"
    )
    e = MP.mpf("0.6")
    x, y = [], []
    for t in found["t"]:
        u = MP.findroot(lambda u, t=t: u - e * MP.sin(u) - t, t)
        x.append(MP.cos(u) - e)
        y.append(MP.sqrt(1 - e * e) * MP.sin(u))
    if system == "central_force":
        r, theta = found["q/r"], found["q/theta"]
        found["q/x"] = [a * MP.cos(b) for a, b in zip(r, theta)]
        found["q/y"] = [a * MP.sin(b) for a, b in zip(r, theta)]
    assert largest(found["q/x"], x) < 1e-28
    assert largest(found["q/y"], y) < 1e-28
    assert attributes["h_drift"] < 1e-29
    assert largest(found["diagnostics/h"], [MP.mpf(-1) / 2] * len(x)) < 1e-29


CHOSEN = """
parameters: {a: -3, k: "where(a > 0, sqrt(a), abs(a)/3)"}
coordinates: {x: {initial: 1}, y: {initial: 1}}
lagrangian: (x_dot**2 + y_dot**2)/2 - where(a < 0, k*(x**2 + y**2)/2, x**4*y)
observables: {f: "max(x, y, 0)", g: "where(x > 0 and y > 2, log(x), min(abs(x), 3))"}
"""


def test_branches(tmp_path):
    _, found = solved(tmp_path, CHOSEN, *LONG, "--stop", "2", "--step", "1", "--outputs", "q,observables")
    known = [MP.cos(t) for t in found["t"]]
    assert largest(found["q/x"], known) < 1e-29
    assert largest(found["observables/f"], [max(x, MP.mpf(0)) for x in known]) < 1e-29
    assert largest(found["observables/g"], map(abs, known)) < 1e-29


def test_pendulum(tmp_path):
    """From rest at 170 degrees: theta = 2 arcsin(k cd(omega t, k)) (Lawden, Elliptic Functions, sec. 5.1)."""
    _, found = solved(
        tmp_path, SYSTEMS / "pendulum.yaml", *LONG, "--set", "theta=170*pi/180", "--set", "g=9.81",
        "--set", "l=0.7", "--stop", "20", "--samples", "21",
    )  # fmt: skip
    k = MP.sin(MP.mpf(170) * MP.pi / 360)
    omega = MP.sqrt(MP.mpf("9.81") / MP.mpf("0.7"))
    known = [2 * MP.asin(k * MP.ellipfun("cd", omega * t, k=k)) for t in found["t"]]
    assert largest(found["q/theta"], known) < 1e-25  # each swing multiplies errors


def test_numbers_are_what_is_written(tmp_path):
    """0.1, 1/3, pi and a fractional power of a number, in coefficients, exponents and parameters."""
    system = """
parameters: {c: 1/3}
coordinates: {x: {initial: 0.1, velocity: 0}, y: {initial: 1.1}, z: {initial: 0.3}}
lagrangian: (x_dot**2 + y_dot**2 + z_dot**2)/2 - 0.1*x**2/2 - c*y**2/2 - pi*2**(1/3)*z**2*sin(1)/2
"""
    _, found = solved(tmp_path, system, *LONG, "--stop", "30", "--samples", "7")
    rates = {"x": MP.mpf("0.1"), "y": MP.mpf(1) / 3, "z": MP.pi * MP.cbrt(2) * MP.sin(1)}
    starts = {"x": "0.1", "y": "1.1", "z": "0.3"}
    for name, rate in rates.items():
        known = [MP.mpf(starts[name]) * MP.cos(MP.sqrt(rate) * t) for t in found["t"]]
        assert largest(found[f"q/{name}"], known) < 1e-29


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    "potential",
    [
        "x**(10/3)/7 + 0.1*sqrt(1.3 + x**2)",
        "log(2 + x) + exp(-0.3*x) + atan(x)*tanh(x)",
        "x**c/3 + asin(x/10) + cosh(0.7*x)",
        "atan2(x, 0.2 + x**2) + (1 + x)**(-2.5) - 1/(x + 3)",
    ],
)
def test_h_is_kept(tmp_path, potential):
    """Coefficients that derivation makes belong to those of the energy to the last digit."""
    system = f"""
parameters: {{c: 2.7}}
coordinates: {{x: {{initial: 1, velocity: 0.9}}}}
lagrangian: x_dot**2*(1 + x**2/7)/2 - ({potential}) - 0.2*x**2
"""
    attributes, _ = solved(tmp_path, system, *LONG, "--stop", "0.8")
    assert attributes["h_drift"] < 1e-29


@pytest.mark.exhaustive(keep=0.2)
def test_many_coordinates(tmp_path):
    """Blocks of the mass matrix are solved, ledgers and the action follow, sums of outputs have low parts."""
    attributes, found = solved(
        tmp_path, SYSTEMS / "n_pendulum.yaml", *LONG, "--stop", "1", "--samples", "9", "--outputs", "all"
    )
    assert attributes["h_drift"] < 1e-28
    assert max(map(abs, found["diagnostics/ledger/h"])) < 1e-28
    total = [a + b for a, b in zip(found["diagnostics/T"], found["diagnostics/U"])]
    assert largest(found["diagnostics/energy"], total) < 1e-29
    assert largest(found["diagnostics/energy"], found["diagnostics/h"]) < 1e-29


def known_until(t, one, other, digits=12):
    """The time until which two motions agree to so many digits."""
    for when, a, b in zip(t, one, other, strict=True):
        if abs(a - b) > MP.mpf(10) ** -digits * max(1, abs(a)):
            return when
    return t[-1]


@pytest.mark.exhaustive(keep=0.3)
def test_chaos_is_known_for_twice_as_long(tmp_path):
    system, end = SYSTEMS / "double_pendulum.yaml", ("--stop", "40", "--step", "0.05", "--outputs", "q")
    _, double = solved(tmp_path, system, *end)
    _, long = solved(tmp_path, system, *end, *LONG)
    attributes, other = solved(tmp_path, system, *end, *LONG, "--tolerance", "1e-28")
    path = "q/theta2"
    short = known_until(long["t"], double[path], long[path])
    assert 1 < short < 20
    assert known_until(long["t"], long[path], other[path]) > 2 * short
    assert attributes["precision"] == "double-double"


@pytest.mark.exhaustive(keep=0.4)
def test_the_error_follows_the_tolerance(tmp_path):
    errors, e = [], MP.mpf("0.3")
    for tolerance in (1e-18, 1e-22, 1e-26):
        options = ("--set", "e=0.3", "--samples", "3", "--tolerance", f"{tolerance}")
        _, found = solved(tmp_path, SYSTEMS / "central_force_cartesian.yaml", *LONG, *options)
        t = found["t"][-1]
        u = MP.findroot(lambda u, t=t: u - e * MP.sin(u) - t, t)
        errors.append(abs(found["q/x"][-1] - MP.cos(u) + e))
    assert all(later < 1e-3 * before for before, later in pairwise(errors))
    assert errors[-1] < 1e-24


def test_explicit_time_and_a_start_elsewhere(tmp_path):
    """x'' = cos(t/3) from t = 0.7, against the integral."""
    system = """
coordinates: {x: {initial: 0, velocity: 0}}
lagrangian: x_dot**2/2
generalized_forces: {x: cos(t/3)}
solve: {start: 0.7, stop: 50, samples: 11}
"""
    _, found = solved(tmp_path, system, *LONG)
    begin = MP.mpf(0.7)

    def known(t):
        return 9 * (MP.cos(begin / 3) - MP.cos(t / 3)) - 3 * MP.sin(begin / 3) * (t - begin)

    assert largest(found["q/x"], [known(t) for t in found["t"]]) < 1e-28


@pytest.mark.exhaustive(keep=0.5)
def test_pulses_that_only_the_action_contains(tmp_path):
    """Of time, and of place as a total derivative; q and v are those of a run without the action."""
    system = """
parameters: {w: 1/50}
coordinates: {x: {initial: 0, velocity: 1}}
lagrangian: x_dot**2/2 - 3/(1 + ((t - 5)/w)**2) + x_dot/(1 + ((x - 7/2)/w)**2)
"""
    times = *LONG, "--stop", "10", "--step", "1/2"
    _, plain = solved(tmp_path, system, *times, "--outputs", "q,v")
    _, found = solved(tmp_path, system, *times, "--outputs", "q,v,action,ledger")
    assert all(found[path] == values for path, values in plain.items())
    w = MP.mpf(1) / 50
    known = [
        t / 2
        - 3 * w * (MP.atan((t - 5) / w) + MP.atan(5 / w))
        + w * (MP.atan((t - MP.mpf("3.5")) / w) + MP.atan(MP.mpf("3.5") / w))
        for t in found["t"]
    ]
    assert largest(found["diagnostics/action"], known) < 1e-29
    assert max(map(abs, found["diagnostics/ledger/h"])) < 1e-28


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "rest",
    [
        "coordinates: {a: {initial: 1.0}}\npositions: {bob: [sin(a), -cos(a)]}\n"
        "observables: {s: a_dot**2 + 9*cos(a)}",
        "coordinates: {x: {initial: sin(1.0)}, y: {initial: -cos(1.0)}}\npositions: {bob: [x, y]}\n"
        "constraints: {rod: x**2 + y**2 - 1}\nobservables: {s: bob.vx**2 + bob.vy**2 - 9*y}",
    ],
)
def test_the_tension_of_a_pendulum(tmp_path, rest):
    system = f"masses: {{bob: 1.0}}\npotential: 9*bob.y\n{rest}\n"
    outputs = "--outputs", "positions,reactions,observables"
    _, found = solved(tmp_path, system, *LONG, "--stop", "3", "--samples", "7", *outputs)
    pairs = zip(found["positions/bob"], [s for s in found["observables/s"] for _ in "xy"])
    assert largest(found["reactions/bob"], [-s * x for x, s in pairs]) < 1e-28


@pytest.mark.exhaustive(keep=0.6)
def test_a_coupled_motion_decays_to_nothing(tmp_path):
    """Below 1e-290 low parts lose their digits; the steps become no shorter for that."""
    system = """
        coordinates: {x: {initial: 1}, y: {initial: 0.3}}
        lagrangian: x_dot**2/2 + y_dot**2/2 - x**2/2 - y**2 + x*y/3
        dissipation: x_dot**2/2 + y_dot**2/3
        """
    attributes, found = solved(tmp_path, system, *LONG, "--stop", "3000", "--samples", "4")
    assert attributes["steps"] < 12000
    assert abs(found["q/x"][-1]) < 1e-270 and abs(found["v/y"][-1]) < 1e-270

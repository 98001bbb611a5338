"""Action and ledgers: their integrands may change faster than the motion does."""

from __future__ import annotations

import math

import h5py
import mpmath
import numpy as np
import pytest

from lagrange_cli.native.stepping import division
from tests.support.command import lagrange
from tests.support.motion import follow

OUTPUTS = ("q", "v", "action", "ledger")
FREE = "lagrangian: x_dot**2/2 {}\ncoordinates: {{x: {{initial: 0, velocity: 1}}}}"
WIDTHS = [(width, place) for width in (3e-4, 0.1, 7.0) for place in (5.0, 3.14159, 0.02)]


def lorentz(t: np.ndarray, width: float, place: float) -> np.ndarray:
    """The integral of 1/(1 + ((t - place)/width)^2) from 0."""
    return width * (np.arctan((t - place) / width) + math.atan(place / width))


def heights() -> np.ndarray:
    return 10.0 ** np.random.default_rng(7).uniform(-2, 5, len(WIDTHS))


PULSE = """
    parameters: {place: 5, width: 0.1, height: 1}
    lagrangian: x_dot**2/2 %s
    coordinates: {x: {initial: 0, velocity: 1}}
    """


@pytest.mark.parametrize(("width", "place", "height"), [(*one, h) for one, h in zip(WIDTHS, heights())])
def test_a_pulse_of_time_in_the_lagrangian(width, place, height):
    text, sets = (
        PULSE % "- height/(1 + ((t - place)/width)**2)",
        {"place": place, "width": width, "height": height},
    )
    motion = follow(text, 10.0, 41, outputs=OUTPUTS, sets=sets)
    known = motion.t / 2 - height * lorentz(motion.t, width, place)
    assert motion.outcome.steps == 1
    assert np.max(np.abs(motion["diagnostics/action"] - known)) <= 1e-13 * (height * width + 10)
    assert np.max(np.abs(motion["diagnostics/ledger/h"])) <= 1e-11 * (1 + height)


@pytest.mark.exhaustive(keep=7)
@pytest.mark.parametrize(("width", "place"), WIDTHS)
def test_a_pulse_of_place_that_is_no_force(width, place):
    """A total derivative: x_dot f(x) adds the integral of f to the action, and nothing to the motion."""
    text, sets = PULSE % "+ x_dot/(1 + ((x - place)/width)**2)", {"place": place, "width": width}
    motion = follow(text, 10.0, 41, outputs=OUTPUTS, sets=sets)
    known = motion.t / 2 + lorentz(motion.t, width, place)
    assert np.max(np.abs(motion["diagnostics/action"] - known)) <= 1e-13


@pytest.mark.exhaustive(keep=0.7)
def test_samples_do_not_change_the_parts_of_a_step():
    text = FREE.format("- 30/(1 + 1e4*(t - 5)**2)")
    few, many = (follow(text, 10.0, n, outputs=OUTPUTS)["diagnostics/action"] for n in (11, 100001))
    assert many[::10000].tolist() == few.tolist()


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("force", ["", "- x**2/2", "- x**2/2 - x**4/40", "+ cos(x)"])
def test_the_motion_is_the_same_without_quadratures(force):
    """To the last bit, however its steps are divided."""
    text = FREE.format(force + " - 1/(1 + 1e4*(t - 5)**2)")
    plain, kept = follow(text, 10.0, 101, outputs=("q", "v")), follow(text, 10.0, 101, outputs=OUTPUTS)
    assert plain.outcome.steps == kept.outcome.steps
    for path in ("q/x", "v/x"):
        assert plain[path].tolist() == kept[path].tolist()
    assert np.max(np.abs(kept["diagnostics/ledger/h"])) <= 1e-12


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("place", [5.0, 7.123])
def test_an_integrand_with_a_kink_or_a_jump(place):
    def rest(t: np.ndarray) -> np.ndarray:
        return ((t - place) * np.abs(t - place) + place**2) / 2

    motion = follow(FREE.format(f"- abs(t - {place})"), 10.0, 21, outputs=OUTPUTS)
    assert np.max(np.abs(motion["diagnostics/action"] - motion.t / 2 + rest(motion.t))) <= 1e-13
    assert np.max(np.abs(motion["diagnostics/ledger/h"])) <= 1e-13


@pytest.mark.exhaustive(keep=0.75)
def test_a_kink_that_no_switch_shows():
    """((t - c)^2)^0.6, written so that it is not a power of an absolute value."""
    text = FREE.format("- ((t - 5)**2 + 2*(t - 5)**2)**0.6")
    motion = follow(text, 10.0, 22, outputs=("q", "action"))
    t, place = motion.t, 5.0
    known = t / 2 - 3**0.6 * (np.sign(t - place) * np.abs(t - place) ** 2.2 + place**2.2) / 2.2
    assert np.all(
        np.isnan(motion["diagnostics/action"]) | (abs(motion["diagnostics/action"] - known) < 1e-11)
    )
    assert np.all(np.isfinite(motion["diagnostics/action"][t < place]))


@pytest.mark.exhaustive(keep=0.65)
def test_behind_a_pole_an_integral_is_no_number():
    motion = follow(FREE.format("- 1/(t - 3.7)"), 10.0, 101, outputs=("q", "action"))
    action, before = motion["diagnostics/action"], motion.t < 3.65
    known = motion.t[before] / 2 - np.log(1 - motion.t[before] / 3.7)
    assert np.max(np.abs(action[before] - known)) <= 1e-13
    assert np.all(np.isnan(action[motion.t > 3.75]))
    assert np.max(np.abs(motion["q/x"] - motion.t)) <= 1e-14
    assert [*motion.outcome.unknown] == ["diagnostics/action"]


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    "form", ["abs(t - {c})**({p})", "x_dot*abs(x - {c})**({p})", "{p}*log(abs(t - {c}))"]
)
@pytest.mark.parametrize("power", [0.5, 0.21, -0.3, -0.7])
def test_an_integrand_with_a_power_of_a_distance(form, power):
    """The integral of |t - c|^p. Where p < 0 it depends on c by (dc)^(1 + p)."""
    c = 0.3711
    text = FREE.format("+ " + form.format(p=power, c=c))
    motion = follow(text, 1.0, 5, outputs=("q", "action"))
    t, q = motion.t, 1 + power
    known = t / 2 + (c**q + np.sign(t - c) * np.abs(t - c) ** q) / q
    if "log" in form:
        known = t / 2 + power * ((t - c) * np.log(np.abs(t - c)) + c * math.log(c) - t)
        q = 1.0
    assert np.max(np.abs(motion["diagnostics/action"] - known)) <= max(1e-14, 1e-13**q)
    assert not motion.outcome.unknown


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    ("form", "known"),
    [
        ("exp(-1/(t - a)**2)", lambda s, a: mpmath.exp(-1 / s**2)),
        ("t*exp(-1/(t - a)**2)/(t - a)**3", lambda s, a: (s + a) * mpmath.exp(-1 / s**2) / s**3),
        ("atan(1/(t - a))", lambda s, a: mpmath.atan(1 / s)),
        ("tanh(1/(t - a)**2)", lambda s, a: mpmath.tanh(1 / s**2)),
    ],
)
def test_an_integrand_without_a_series_at_a_place_where_it_has_limits(form, known):
    """A function that is smooth, or jumps, where the denominator in its argument is 0."""
    text = f"parameters: {{a: 1.234}}\n{FREE.format('+ ' + form)}"
    motion = follow(text, 3.0, 4, outputs=("q", "action"))
    with mpmath.workdps(30):
        whole = mpmath.quad(lambda t: known(t - 1.234, 1.234), [0, 0.6, 1, 1.234, 1.5, 2, 3])
    assert motion["diagnostics/action"][-1] == pytest.approx(1.5 + float(whole), rel=1e-14)


@pytest.mark.exhaustive(keep=0.35)
def test_such_an_integrand_on_a_moving_place():
    """dF/dt in L, with F' = exp(-1/(x - 1/3)^2): the action of an oscillator passes it twice a period."""
    text = """
    coordinates: {x: {initial: 1.0}}
    lagrangian: x_dot**2/2 - x**2/2 + x_dot*exp(-1/(x - 1/3)**2)
    """
    motion = follow(text, 10.0, 21, outputs=("q", "action"))
    for t, x, action in zip(motion.t, np.cos(motion.t), motion["diagnostics/action"]):
        places = [1.0, *([1 / 3] if x < 1 / 3 else []), x]
        with mpmath.workdps(30):
            added = mpmath.quad(lambda y: mpmath.exp(-1 / (y - mpmath.mpf(1 / 3)) ** 2), places)
        assert action == pytest.approx(-math.sin(2 * t) / 4 + float(added), abs=1e-14)


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(
    "form",
    ["sin(1/(t - 1/3))", "exp(1/(t - 1/3)**2)", "exp(-1/(t - 1/3))", "log(abs(t - 1/3))**2", "1/(t - 1/3)"],
)
def test_an_integrand_that_no_parts_can_follow_has_no_integral(form, monkeypatch):
    """None of its samples are what the step's polynomial gives, either."""
    monkeypatch.setattr(division, "MOST", 1 << 12)
    motion = follow(FREE.format("+ " + form), 1.0, 5, outputs=("q", "action"))
    assert np.isnan(motion["diagnostics/action"][motion.t > 1 / 3]).all()
    assert (
        np.max(np.abs(motion["q/x"] - motion.t)) <= 1e-15 and "diagnostics/action" in motion.outcome.unknown
    )


ROOTS = {
    "of a distance in the potential": ("x**2/2 + abs(t - 1)**0.5*x", "0"),
    "0 before a time": ("x**2/2 + sqrt(max(0, t - 1))*x", "0"),
    "that begins at once": ("x**2 + 1.3*x*max(0, sin(2*t))**1.5 + x*where(t > 0.7, t - 0.7, 0)**0.3", "0"),
    "a force": ("x**2/2", "max(0, t - 1)**0.5"),
    "of a speed": ("2*x**2", "-1.3*sign(x_dot)*abs(x_dot)**0.5"),
    "of a moving place": ("x**2", "-0.5*min(1, abs(x))**0.5 - 1.3*max(0, x + 0.1)**1.5"),
}


@pytest.mark.exhaustive(keep=0.6)
@pytest.mark.parametrize(("potential", "force"), ROOTS.values(), ids=ROOTS)
def test_the_books_of_roots_of_switches(potential, force):
    """Where they are 0 their slopes are infinite, and coefficients of series overflow nearby. The momentum,
    whose integral is 0 when the body turns around, is written down all the same."""
    text = f"""
    parameters: {{m: 1.2}}
    coordinates: {{x: {{initial: 0.3, velocity: 0.4}}}}
    masses: {{b: m}}
    embedding: {{b: [x]}}
    potential: {potential}
    generalized_forces: {{x: "{force}"}}
    """
    motion = follow(text, 3.0, 31, outputs=OUTPUTS)
    assert motion.t[-1] == 3.0
    for name in ("h", "p/x"):
        assert np.max(np.abs(motion[f"diagnostics/ledger/{name}"])) <= 1e-14


@pytest.mark.exhaustive(keep=0.7)
def test_the_balance_of_the_root_of_a_distance():
    """dL/dt is infinite at t = 1/3, and h changes by its integral."""
    motion = follow(FREE.format("+ abs(t - 1/3)**0.5"), 1.0, 5, outputs=("q", "action", "ledger"))
    known = 0.5 + ((1 / 3) ** 1.5 + (2 / 3) ** 1.5) / 1.5
    assert motion["diagnostics/action"][-1] == pytest.approx(known, rel=1e-15)
    assert np.max(np.abs(motion["diagnostics/ledger/h"])) <= 1e-14


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("precision", ["double", "double-double"])
@pytest.mark.parametrize("width", [2e-4, 6e-3])
@pytest.mark.parametrize(
    ("pulse", "area"), [("1/cosh(U)**2", 2), ("exp(-U)/(1 + exp(-U))**2", 1), ("1 - tanh(U)**2", 2)]
)
def test_the_books_of_a_pulse_whose_exponentials_overflow(pulse, area, width, precision, tmp_path):
    """Far from it they are greater than all doubles; the ledgers stay finite, as the motion does."""
    text = f"""
    lagrangian: x_dot**2/2
    coordinates: {{x: {{initial: 0.3, velocity: 0.1}}}}
    generalized_forces: {{x: 40*({pulse.replace("U", f"((t - 4.7)/{width})")})}}
    """
    (tmp_path / "pulse.yaml").write_text(text)
    asked = ["--stop", "10", "--samples", "5", "--outputs", "v,ledger", "--precision", precision]
    lagrange("solve", "pulse.yaml", "-o", "pulse.h5", *asked, cwd=tmp_path)
    with h5py.File(tmp_path / "pulse.h5") as file:
        assert file["v/x"][-1] == pytest.approx(0.1 + 40 * area * width, rel=1e-13)
        for name in ("h", "p/x"):
            assert np.max(np.abs(file[f"diagnostics/ledger/{name}"])) <= 1e-13


@pytest.mark.exhaustive(keep=0.65)
def test_a_pulse_on_a_moving_pendulum():
    """int dt / (1 + (th/w)^2) along a small oscillation, against quadrature of the closed form."""
    text = """
        lagrangian: th_dot**2/2 - th**2/2 + th_dot*1e-9/(1e-9 + th**2)
        coordinates: {th: {initial: 1, velocity: 0}}
        """
    motion = follow(text, 6.0, 13, outputs=("q", "action"))
    width = math.sqrt(1e-9)
    for t, found in zip(motion.t, motion["diagnostics/action"]):
        known = -math.sin(2 * t) / 4 + width * (math.atan(math.cos(t) / width) - math.atan(1 / width))
        assert abs(found - known) <= 1e-13


@pytest.mark.exhaustive(keep=0.35)
def test_many_pulses_within_a_step():
    motion = follow(FREE.format("- 1/(1 + 1e3*sin(3*t)**2)"), 10.0, 3, outputs=("q", "action"))
    one = mpmath.quad(lambda t: 1 / (1 + 1000 * mpmath.sin(3 * t) ** 2), mpmath.linspace(0, 10, 121))
    assert abs(motion["diagnostics/action"][-1] - (5 - float(one))) <= 1e-13


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(("width", "place"), [(0.011, 2.9), (0.3, 8.1), (1e-3, 0.7)])
def test_a_pulse_of_which_nothing_is_seen_before(width, place):
    """exp(-u^2) is 0 to the last bit, with all its derivatives, where the step begins."""
    text, sets = PULSE % "- height*exp(-((t - place)/width)**2)", {"place": place, "width": width}
    motion = follow(text, 10.0, 41, outputs=OUTPUTS, sets=sets)
    both = np.array([math.erf((t - place) / width) + math.erf(place / width) for t in motion.t])
    known = motion.t / 2 - width * math.sqrt(math.pi) / 2 * both
    assert motion.outcome.steps == 1
    assert np.max(np.abs(motion["diagnostics/action"] - known)) <= 1e-13
    assert np.max(np.abs(motion["diagnostics/ledger/h"])) <= 1e-12


@pytest.mark.exhaustive(keep=0.45)
def test_integrals_of_many_coordinates_leave_the_motion_as_it_is():
    """Five coordinates take more than one vector. What is expected at the end of a step lies beside what
    parts of the step work on, and must outlive it."""
    text = """
    sizes: {N: 5}
    coordinates: {"x[i in range(N)]": {initial: 0, velocity: "1 + 0.1*i"}}
    lagrangian: "sum(x_dot[i]**2/2 - x[i]**2/2*(1 + 0.3*i) for i in range(N)) - 30/(1 + 1e6*(t - 0.1)**2)"
    """
    alone, beside = (follow(text, 3.0, 11, outputs=outputs) for outputs in (("q", "v"), OUTPUTS))
    assert alone.outcome.steps == beside.outcome.steps
    assert all(np.array_equal(samples, beside[path]) for path, samples in alone.data.items())


@pytest.mark.exhaustive(keep=0.8)
def test_ledgers_leave_out_what_balances_identically():
    """In p the steep F' is 10^6 at the pulse, and so would be what rounding of x leaves in its balance."""
    steep = "+ x_dot*1e3*exp(-(((x - 1)/1e-3)**2))"
    found = follow(FREE.format(steep), stop=4.0, samples=4, outputs=(*OUTPUTS, "h", "p"))
    assert np.all(found["diagnostics/ledger/p/x"] == 0) and np.all(found["diagnostics/ledger/h"] == 0)
    assert np.ptp(found["diagnostics/p/x"]) == 0 and found["q/x"][-1] == 4  # no sample is on the pulse

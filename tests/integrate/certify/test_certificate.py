"""The estimated errors beside the true ones, known to 50 digits: of regular, damped and chaotic motions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from functools import cache

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from lagrange_cli.integrate.certify.certificate import AS_RUN, FOLDER, relative, typical_difference
from lagrange_cli.integrate.certify.companion import Companion
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.outcome import Outcome
from lagrange_cli.integrate.run import integrate
from lagrange_cli.run.certify import Demand
from lagrange_cli.run.motion import Ready, certificate_of, prepare_all, read_motion
from lagrange_cli.run.request import Request
from lagrange_cli.spec.spec import SolveDefaults
from tests.support.motion import spec_of

Number = mpmath.mpf
COVERAGE = 0.99

PENDULUM = """\
parameters: {k: 2.25}
coordinates: {x: {initial: 2.5}}
masses: {p: 1}
embedding: {p: [sin(x), -cos(x)]}
potential: k*p.y
"""
DAMPED = """\
coordinates: {x: {initial: 1}}
masses: {p: 1}
embedding: {p: x}
potential: 2*x**2
dissipation: x_dot**2/8
"""
HENON_HEILES = """\
coordinates: {x: {initial: 0.25, velocity: 0.375}, y: {initial: -0.25, velocity: 0.25}}
masses: {p: 1}
embedding: {p: [x, y]}
potential: (x**2 + y**2)/2 + x**2*y - y**3/3
"""


def pendulum(t: Number) -> list[Number]:
    """sin(x/2) = k cd(w t) (DLMF 22.19.2), in its first swing or any other."""
    w, k = Number(1.5), mpmath.sin(Number(2.5) / 2)
    u = mpmath.fmod(w * t, 4 * mpmath.ellipk(k**2))
    return [2 * mpmath.asin(k * mpmath.ellipfun("cd", u, m=k**2))]


def damped(t: Number) -> list[Number]:
    """x'' + x'/4 + 4 x = 0 from rest."""
    w = mpmath.sqrt(4 - Number(1) / 64)
    return [mpmath.exp(-t / 8) * (mpmath.cos(w * t) + mpmath.sin(w * t) / (8 * w))]


def product(a: Sequence[Number], b: Sequence[Number], n: int) -> Number:
    return mpmath.fsum(a[k] * b[n - k] for k in range(n + 1))


class HenonHeiles:
    """x'' = -x - 2xy, y'' = -y - x^2 + y^2, from one sample to the next by 40 terms of the Taylor series."""

    def __init__(self) -> None:
        self._t = Number(0)
        self._state = [Number(0.25), Number(-0.25), Number(0.375), Number(0.25)]

    def __call__(self, t: Number) -> list[Number]:
        step = t - self._t
        x, y = ([self._state[i], self._state[2 + i]] for i in range(2))
        for n in range(40):
            x.append((-x[n] - 2 * product(x, y, n)) / ((n + 1) * (n + 2)))
            y.append((-y[n] - product(x, x, n) + product(y, y, n)) / ((n + 1) * (n + 2)))
        rates = [[k * one[k] for k in range(1, len(one))] for one in (x, y)]
        self._state = [mpmath.polyval(series[::-1], step) for series in (x, y, *rates)]
        self._t = t
        return self._state[:2]


@cache
def ready_of(
    text: str, stop: float, samples: int, method: str, start: str, outputs: tuple[str, ...]
) -> Ready:
    """A system file's text, or the name of a shipped system, compiled as ``solve --certify`` does."""
    times = {"stop": repr(stop), "start": start}
    given = SolveDefaults(samples=samples, method=method, outputs=outputs)
    request = Request(given, times, cache=False)
    motion = read_motion(spec_of(text).text.encode(), "system.yaml", request)
    return prepare_all(motion, request, Demand(6, None), lambda stage: nullcontext())


def certified(
    system: str,
    stop: float,
    samples: int,
    method: str = "taylor",
    target: float | None = None,
    start: str = "0",
    outputs: tuple[str, ...] = ("q", "v"),
) -> tuple[dict[str, NDArray[np.float64]], Outcome]:
    """The samples of a run whose errors are estimated, as ``solve --certify`` goes."""
    ready = ready_of(system, stop, samples, method, start, outputs)
    chunks: list[dict[str, NDArray[np.float64]]] = []
    with certificate_of(ready, Demand(6, target)) as certificate:
        outcome = integrate(
            ready.prepared,
            ready.motion.values,
            ready.times,
            lambda chunk: chunks.append({path: np.array(x) for path, x in chunk.items()}),
            lambda: False,
            certificate=certificate,
        )
    return {path: np.concatenate([one[path] for one in chunks]) for path in chunks[0]}, outcome


def coverage(
    data: Mapping[str, NDArray[np.float64]], path: str, truth: Sequence[Number], folder: str = FOLDER
) -> float:
    """The share of samples whose estimate is neither below a tenth of the error nor above a hundred times it;
    a rounding of the sample is no error. Of a vector, the size of the whole counts."""
    with mpmath.workdps(50):
        wrong = [float(abs(Number(x) - y)) for x, y in zip(data[path].ravel().tolist(), truth, strict=True)]
    sizes = np.abs(data[path]).reshape(len(data[path]), -1)
    rounding = np.spacing(np.maximum.accumulate(np.max(sizes, axis=1)))
    error = np.reshape(wrong, sizes.shape)
    ratio = data[folder + path].reshape(sizes.shape) / np.maximum(error, rounding[:, None])
    return float(np.mean((ratio >= 0.1) & (ratio <= 100)))


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("method", ["taylor", "DOP853"])
@pytest.mark.parametrize(
    ("system", "known", "stop"),
    [(PENDULUM, lambda: pendulum, 100.0), (DAMPED, lambda: damped, 60.0), (HENON_HEILES, HenonHeiles, 150.0)],
)
def test_the_estimate_is_near_the_true_error(
    system: str, known: Callable[[], Callable[[Number], list[Number]]], stop: float, method: str
) -> None:
    """All inputs are doubles, so that the problem is run as it is written."""
    data, _ = certified(system, stop, 301, method)
    with mpmath.workdps(50):
        exact, names = known(), [path for path in data if path.startswith("q/")]
        truth = [exact(Number(t)) for t in data["t"].tolist()]
    for i, path in enumerate(names):
        for folder in (FOLDER, AS_RUN):
            assert coverage(data, path, [row[i] for row in truth], folder) >= COVERAGE


@given(st.permutations([0.0, 1.0, 3.5]), st.permutations([2.0, 2.5, -7.0]))
def test_the_middle_one_of_three_distances_counts(one: list[float], other: list[float]) -> None:
    """Whatever the order of the motions; of two, their only distance."""
    motions = [np.array([pair]) for pair in zip(one, other)]
    np.testing.assert_array_equal(typical_difference(motions), [[2.5, 9.0]])
    first, second = motions[:2]
    np.testing.assert_array_equal(typical_difference([first, second]), np.abs(first - second))


@pytest.mark.exhaustive(keep=0.8)
def test_the_estimate_is_at_least_the_distance_of_the_motions(monkeypatch):
    """Companions that are off by 1e-3, to either side."""
    whole, sides = Companion.take, iter([1, -1] * 1000)

    def take(self, count, interrupted):
        return whole(self, count, interrupted) + 1e-3 * next(sides)

    monkeypatch.setattr(Companion, "take", take)
    data, _ = certified(PENDULUM, 10.0, 11)
    np.testing.assert_allclose(data[f"{FOLDER}q/x"], 1e-3, rtol=1e-9)


@pytest.mark.parametrize("missing", [0, 1])
def test_what_a_companion_has_not_reached_is_not_known(missing: int) -> None:
    beside = [np.ones((2, 3)), np.ones((2, 3))]
    beside[missing][:, 1:] = np.nan
    found = typical_difference([np.zeros((2, 3)), *beside])
    np.testing.assert_array_equal(found, [[1, np.inf, np.inf]] * 2)


@pytest.mark.exhaustive(keep=0.45)
def test_the_run_ends_where_the_target_is_missed_and_not_before() -> None:
    plain, whole = certified(HENON_HEILES, 400.0, 4001)
    cut, outcome = certified(HENON_HEILES, 400.0, 4001, target=1e-12)
    count = len(cut["t"])
    assert outcome.ending is Ending.TARGET_MISSED and 0 < count < len(plain["t"])
    assert outcome.t == plain["t"][count]
    assert whole.ending is Ending.COMPLETE
    for path, samples in cut.items():
        assert np.array_equal(samples, plain[path][:count])
    relative = [plain[FOLDER + path] / np.maximum.accumulate(np.abs(plain[path])) for path in ("q/x", "q/y")]
    worst = np.max(relative, axis=0)
    assert np.all(worst[:count] <= 1e-12) and worst[count] > 1e-12


def test_digits_hold_as_long_as_the_estimate_says() -> None:
    data, outcome = certified("double_pendulum", 60.0, 601)
    relative = np.max(
        [
            data[f"{FOLDER}q/{k}"] / np.maximum.accumulate(np.abs(data[f"q/{k}"]))
            for k in ("theta1", "theta2")
        ],
        axis=0,
    )
    assert outcome.estimated is not None
    assert 0 < outcome.estimated.trusted_until < 60
    trusted = int(np.sum(data["t"] <= outcome.estimated.trusted_until))
    assert np.all(relative[:trusted] <= 1e-6) and relative[trusted] > 1e-6
    assert outcome.estimated.error == relative[-1]


def test_where_companions_have_stopped_the_error_is_not_known(monkeypatch):
    """Without a word: every warning is an error here."""
    whole = Companion.take

    def take(self, count, interrupted):
        samples = whole(self, count, interrupted).copy()
        samples[:, count // 2 :] = np.nan
        return samples

    monkeypatch.setattr(Companion, "take", take)
    data, outcome = certified(PENDULUM, 10.0, 11)
    errors = data[f"{FOLDER}q/x"]
    assert np.all(np.isfinite(errors[:5])) and np.all(errors[5:] == np.inf)
    assert outcome.estimated is not None
    assert outcome.estimated.trusted_until == 4.0


def test_a_member_that_is_rounding_beside_its_family_loses_no_digits() -> None:
    sizes = np.array([[1e-30], [0.0], [20.0], [1e-9], [1e-30]])
    errors = np.array([[4e-20], [1e-25], [2e-13], [1e-12], [4e-20]])
    found = relative(errors, sizes, np.array([0, 0, 0, 0, 1]))
    assert np.allclose(found, [[2.0**-52], [2.0**-52], [1e-14], [1e-3], [4e10]], rtol=1e-12)

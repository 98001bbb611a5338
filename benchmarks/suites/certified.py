"""``solve --certify``: estimated errors beside true ones, and the time that the estimates take.

The reference is a run in double-double, with 31 digits, of the same equations from the same doubles. (The
tests use series with 50 digits.) A sample is covered if the estimate is at least a tenth and at most a
hundred times its error. Errors below the spacing of doubles at the largest value so far are replaced by this
spacing. Chaotic motions continue until no digit is left. Each motion is repeated with initial values that
differ by 1e-9.
"""

from __future__ import annotations

import sys
import time
from argparse import Namespace
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from statistics import median

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.motions.motion import shipped
from benchmarks.motions.uncertain import SYSTEMS
from lagrange_cli.cli.options.certify import DIGITS
from lagrange_cli.integrate.certify.certificate import FOLDER, Certificate
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.outcome import Outcome
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE
from lagrange_cli.integrate.prepare import prepare, prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.run import integrate
from lagrange_cli.integrate.samples import LOW
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import replace
from lagrange_cli.run.certify import companion_settings
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.settings import resolve_settings
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import SolveDefaults
from lagrange_cli.spec.values import Values, resolve_values

Array = NDArray[np.float64]
SAMPLES = 4001
LEAST, MOST = 0.1, 100.0
COVERAGE = 0.99
DEARER = 2.3
DRAWS, NEAR = 5, 1e-9
"""How many initial values, and how far they are apart; the first ones are the scene's own."""
TURNS = 5000.0
"""How long the motions are whose cost is measured, in their own time: some ten thousand steps."""
NONE = frozenset({"q", "v"})


@dataclass(frozen=True)
class Scene:
    """A shipped system or one of ``uncertain``, and when it stops."""

    system: str
    stop: float
    method: str = "taylor"


SCENES = (
    Scene("harmonic_oscillator", 200),
    Scene("pendulum", 100),
    Scene("pendulum", 20, "DOP853"),
    Scene("central_force_cartesian", 200),
    Scene("central_force", 200),
    Scene("rotating_hoop", 60),
    Scene("rotating_rod", 10),
    Scene("spherical_pendulum", 60),
    Scene("charged_particle", 60),
    Scene("fpu_chain", 200),
    Scene("solar_system", 36525),
    Scene("figure_eight", 60),
    Scene("driven_damped_pendulum", 60),
    Scene("double_pendulum", 20),
    Scene("n_pendulum", 10),
    Scene("Henon-Heiles, h = 0.12", 400),
    Scene("heavy top", 60),
    Scene("spring pendulum", 40),
    Scene("driven Duffing oscillator", 60),
    Scene("damped, coupled", 100),
    Scene("Kepler, e = 0.9", 100),
    Scene("swinging Atwood machine", 20),
    Scene("anharmonic, coupled", 100),
    Scene("driven, damped double well", 80),
    Scene("three bodies", 10),
    Scene("x^2 y^2", 100),
    Scene("pendulum on a cart", 30),
    Scene("Stormer's charge", 60),
    Scene("Kapitza's pendulum", 20),
)
QUICK = (SCENES[1], SCENES[3], SCENES[13])
TIMED = ("pendulum", "double_pendulum", "central_force_cartesian")


class Compiled:
    """A scene in compiled form: the run, its companions and the truth."""

    def __init__(self, scene: Scene) -> None:
        text = SYSTEMS.get(scene.system) or shipped(scene.system)
        spec = self._spec = read_spec(text.encode(), scene.system)
        asked = SolveDefaults(stop=scene.stop, samples=SAMPLES, method=scene.method)
        self._settings = resolve_settings(spec, asked)
        self._values, self._residual = resolve_values(spec), derive_system(spec)
        self._given = self._values
        step = (scene.stop - self._settings.start) / (SAMPLES - 1)
        self._times = Times(self._settings.start, scene.stop, SAMPLES, step)
        self._run = prepare(
            self._residual, Compilation(method=scene.method, tolerance=self._settings.tolerance, outputs=NONE)
        )
        chosen, orders = companion_settings(self._settings)
        self._companions = [
            prepare(
                self._residual,
                Compilation(method=chosen.method, tolerance=chosen.tolerance, outputs=NONE, order=order),
            )
            for order in orders
        ]

    def start(self, draw: int) -> None:
        """Take other initial values: the ``draw``-th ones, of which the 0-th are the scene's own."""
        source = np.random.default_rng(draw)

        def near(values: tuple[float, ...]) -> tuple[float, ...]:
            return tuple(float(x * (1 + bool(draw) * NEAR * source.standard_normal())) for x in values)

        self._values = replace(self._given, q=near(self._given.q), v=near(self._given.v))

    def truth(self) -> Mapping[str, Array]:
        """Samples by path, in two parts."""
        zeros = (0.0,) * len(self._values.q)
        nothing = replace(
            self._values, parameters=dict.fromkeys(self._values.parameters, 0.0), q=zeros, v=zeros
        )
        ready = prepare_system(
            self._spec,
            lambda spec: self._residual,
            None,
            Compilation(method="taylor", tolerance=2.0**-104, outputs=NONE, precision=DOUBLE_DOUBLE),
        )
        return self._follow(ready, replace(self._values, remainder=nothing))[0]

    def certified(self) -> tuple[Mapping[str, Array], Outcome]:
        """Samples and estimates by path."""
        return self._follow(self._run, self._values, self._certificate())

    def seconds(self) -> tuple[float, float]:
        """What the integration takes, plain and certified."""
        found = []
        for certificate in (nullcontext(), self._certificate()):
            began = time.perf_counter()
            self._follow(self._run, self._values, certificate)
            found.append(time.perf_counter() - began)
        return found[0], found[1]

    def _certificate(self) -> Certificate:
        return Certificate(self._companions, self._values, self._times, DIGITS, None)

    def _follow(
        self,
        ready: Prepared,
        values: Values,
        certifying: AbstractContextManager[Certificate | None] | None = None,
    ) -> tuple[Mapping[str, Array], Outcome]:
        chunks: list[dict[str, Array]] = []

        def keep(chunk: Mapping[str, Array]) -> None:
            chunks.append({path: np.array(samples) for path, samples in chunk.items()})

        with certifying or nullcontext() as certificate:
            outcome = integrate(ready, values, self._times, keep, lambda: False, certificate=certificate)
        return {path: np.concatenate([one[path] for one in chunks]) for path in chunks[0]}, outcome


def ratios(data: Mapping[str, Array], truth: Mapping[str, Array]) -> Array:
    """The estimate over the error, of every number of q and v."""
    found = []
    for path in (path.removeprefix(FOLDER) for path in data if path.startswith(FOLDER)):
        error = np.abs(data[path] - truth[path] - truth[LOW + path])
        spacing = np.spacing(np.maximum.accumulate(np.abs(data[path]), axis=0))
        found.append(np.ravel(data[FOLDER + path] / np.maximum(error, spacing)))
    return np.concatenate(found)


def measure(options: Namespace) -> Report:
    """Coverage of every scene, and the cost of some."""
    rows, every = [], []
    for scene in QUICK if options.quick else SCENES:
        compiled, found, outcomes = Compiled(scene), [], []
        for draw in range(1 if options.quick else DRAWS):
            compiled.start(draw)
            data, outcome = compiled.certified()
            found.append(ratios(data, compiled.truth()))
            outcomes.append(outcome)
        outcome = outcomes[0]
        below, above = np.mean(np.array(found) < LEAST), np.mean(np.array(found) > MOST)
        every.append((below, above))
        shares = f"{100 * (1 - below - above):.2f}", f"{100 * below:.2f}", f"{100 * above:.2f}"
        trusted = f"{outcome.trusted_until:.6g}"
        rows.append((scene.system, scene.method, f"{scene.stop:g}", *shares, f"{outcome.error:.1e}", trusted))
    costs = []
    for name in TIMED:
        compiled = Compiled(Scene(name, TURNS))
        pairs = [compiled.seconds() for _ in range(options.runs)]
        plain, certified = (median(column) for column in zip(*pairs))
        costs.append((name, f"{1e3 * plain:.1f}", f"{1e3 * certified:.1f}", certified / plain))
    heads = (
        "motion",
        "method",
        "until t",
        "covered, %",
        "too low, %",
        "too high, %",
        "error",
        "6 digits until t",
    )
    table = markdown_table(heads, rows)
    times = markdown_table(
        ("motion", "plain, ms", "certified, ms", "ratio"), [(*row[:3], f"{row[3]:.2f}") for row in costs]
    )
    covered = 1 - float(np.mean([below + above for below, above in every]))
    worst = 1 - float(max(below + above for below, above in every))
    return Report(
        (table, times),
        (
            Requirement("share of samples covered, mean of the motions", covered, ">=", COVERAGE),
            Requirement("share of samples covered, worst motion", worst, ">=", COVERAGE),
            Requirement(
                "time of certified relative to plain, worst motion",
                max(row[3] for row in costs),
                "<=",
                DEARER,
            ),
        ),
    )


SUITE = Suite("certified", measure, packages=("llvmlite", "numpy"), runs=7, quick="three motions only")

if __name__ == "__main__":
    sys.exit(SUITE.main())

"""``solve --certify``: estimated errors beside true ones, and the time that the estimates take.

The motions begin at unstable equilibria, meet walls, friction, switches, pulses and impacts, or are regular
or chaotic. Their numbers are drawn anew with every --seed. The true errors are taken from runs in
double-double, with 31 digits: of the problem as it is written, and as it is run, with all inputs rounded to
doubles. A sample is covered if its estimate is at least a tenth and at most a hundred times its error. Errors
below the spacing of doubles at the largest value so far are replaced by this spacing; of a vector, the size
of the whole counts. Chaotic motions continue until no digit is left. Of systems with constraints, multipliers
and reactions are judged, too. The doubles of their starts satisfy the constraints to rounding only, so that
most of them have no motion of 31 digits as run.
"""

from __future__ import annotations

import sys
import time
from argparse import Namespace
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from statistics import median

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.motions.motion import shipped
from benchmarks.motions.uncertain import SYSTEMS
from benchmarks.motions.unstable import unstable
from benchmarks.truth.drawing import cases
from lagrange_cli.cli.options.certify import DIGITS
from lagrange_cli.errors import LagrangeError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.integrate.certify.certificate import AS_RUN, FOLDER
from lagrange_cli.integrate.outcome import Outcome
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.run import integrate
from lagrange_cli.integrate.samples import LOW
from lagrange_cli.records import replace
from lagrange_cli.run.certify import Demand
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.monitor import untimed
from lagrange_cli.run.motion import certificate_of, prepare_all, read_motion
from lagrange_cli.run.request import Request
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import SolveDefaults
from lagrange_cli.spec.values import Values, resolve_long_values, resolve_values

Array = NDArray[np.float64]
SAMPLES = 1001
LEAST, MOST = 0.1, 100.0
COVERAGE = 0.99
DEARER = 2.3
NEAR = 1e-9
"""How far initial values are from those of a scene."""
TURNS = 5000.0
"""How long the motions are whose cost is measured, in their own time: some ten thousand steps."""
FAMILIES = "walls", "friction", "switches", "pulses", "barriers", "impacts", "rest"
"""Those of ``benchmarks.truth`` whose motions are taken."""
PATIENCE = 5.0
"""Seconds after which a run is cut; what it has until then is judged."""
LONGEST = 500.0
"""When motions of these families stop, if not before."""
DEMAND = Demand(DIGITS, None)


@dataclass(frozen=True)
class Scene:
    """A motion: the system file, the initial values in place of its own, and when it stops."""

    group: str
    name: str
    text: str
    stop: float
    method: str = "taylor"
    initial: Mapping[str, str] = field(default_factory=dict)
    outputs: tuple[str, ...] = ("q", "v")


SHIPPED = (
    ("harmonic_oscillator", 200, "taylor"),
    ("pendulum", 100, "taylor"),
    ("pendulum", 20, "DOP853"),
    ("central_force_cartesian", 200, "taylor"),
    ("central_force", 200, "taylor"),
    ("rotating_hoop", 60, "taylor"),
    ("rotating_rod", 10, "taylor"),
    ("spherical_pendulum", 60, "taylor"),
    ("charged_particle", 60, "taylor"),
    ("fpu_chain", 200, "taylor"),
    ("solar_system", 36525, "taylor"),
    ("figure_eight", 60, "taylor"),
    ("driven_damped_pendulum", 60, "taylor"),
    ("double_pendulum", 20, "taylor"),
    ("n_pendulum", 10, "taylor"),
    ("Henon-Heiles, h = 0.12", 400, "taylor"),
    ("heavy top", 60, "taylor"),
    ("spring pendulum", 40, "taylor"),
    ("driven Duffing oscillator", 60, "taylor"),
    ("damped, coupled", 100, "taylor"),
    ("Kepler, e = 0.9", 100, "taylor"),
    ("swinging Atwood machine", 20, "taylor"),
    ("anharmonic, coupled", 100, "taylor"),
    ("driven, damped double well", 80, "taylor"),
    ("three bodies", 10, "taylor"),
    ("x^2 y^2", 100, "taylor"),
    ("pendulum on a cart", 30, "taylor"),
    ("Stormer's charge", 60, "taylor"),
    ("Kapitza's pendulum", 20, "taylor"),
)
"""Shipped systems and those of ``uncertain``, when they stop, and the method."""
FORCES = "multipliers", "reactions"
CONSTRAINED = (
    ("four_bar", 20, FORCES[:1]),
    ("chain", 5, FORCES),
    ("rolling_disc", 10, FORCES[:1]),
    ("knife_edge", 10, FORCES[:1]),
    ("chaplygin_sleigh", 20, FORCES[:1]),
    ("turntable_ball", 20, FORCES[:1]),
    ("coin", 5, FORCES),
    ("bicycle", 5, FORCES),
    ("rattleback", 5, FORCES),
    ("gyroscope", 5, FORCES),
    ("car_axis", 3, FORCES),
    ("andrews_squeezer", 0.03, FORCES[:1]),
    ("pendulum", 20, FORCES[1:]),
    ("double_pendulum", 10, FORCES[1:]),
)
"""Systems of which forces of constraint are judged, when they stop, and which."""
TIMED = ("pendulum", "double_pendulum", "central_force_cartesian")


def text_of(name: str) -> str:
    """A system of ``SHIPPED``."""
    return SYSTEMS.get(name) or shipped(name)


def scenes(seed: int) -> Iterator[Scene]:
    """All motions, with the numbers of a seed."""
    for name, (text, stop) in unstable(seed).items():
        yield Scene("unstable", name, text, stop)
    for case in cases(seed, 1, FAMILIES):
        yield Scene(case.family, case.name, case.text, min(float(case.stop), LONGEST))
    source = np.random.default_rng(seed)
    for name, stop, method in SHIPPED:
        text = text_of(name)
        spec = read_spec(text.encode(), name)
        values, names = resolve_values(spec), [one.name for one in spec.coordinates]
        given = dict(zip([*names, *map(velocity_name, names)], [*values.q, *values.v]))
        near = {one: repr(x * (1 + NEAR * source.standard_normal())) for one, x in given.items() if x}
        yield Scene("smooth", name, text, stop, method, near)
    for name, stop, outputs in CONSTRAINED:
        yield Scene("constraints", name, shipped(name), stop, outputs=("q", "v", *outputs))


class Compiled:
    """A scene in compiled form: the run and its companions, and what is true."""

    def __init__(self, scene: Scene) -> None:
        asked = SolveDefaults(stop=scene.stop, samples=SAMPLES, method=scene.method, outputs=scene.outputs)
        request = Request(asked, overrides=scene.initial, cache=False)
        self._motion = read_motion(scene.text.encode(), scene.name, request)
        self._initial = scene.initial
        self._ready = prepare_all(self._motion, request, DEMAND, untimed)

    def truths(self) -> tuple[Mapping[str, Array], Mapping[str, Array]]:
        """Samples by path, in two parts, of the problem as it is written, and as it is run; none where there
        is no such motion."""
        spec, values = self._motion.spec, self._motion.values
        zeros = (0.0,) * len(values.q)
        nothing = Values(dict.fromkeys(values.parameters, 0.0), zeros, zeros)
        settings = replace(
            self._motion.settings, method="taylor", precision=DOUBLE_DOUBLE, tolerance=2.0**-104
        )
        found = []
        for exact, given in (
            (True, resolve_long_values(spec, self._initial)),
            (False, replace(values, remainder=nothing)),
        ):
            ready = prepare_system(
                spec, partial(derive_system, exact=exact, resting=True), None, settings.compilation()
            )
            found.append(self._follow(ready, given)[0])
        return found[0], found[1]

    def certified(self) -> tuple[Mapping[str, Array], Outcome]:
        """Samples and estimates by path."""
        return self._follow(self._ready.prepared, self._motion.values, DEMAND)

    def seconds(self) -> tuple[float, float]:
        """What the integration takes, plain and certified."""
        found = []
        for demand in (None, DEMAND):
            began = time.perf_counter()
            self._follow(self._ready.prepared, self._motion.values, demand)
            found.append(time.perf_counter() - began)
        return found[0], found[1]

    def _follow(
        self, ready: Prepared, values: Values, demand: Demand | None = None
    ) -> tuple[Mapping[str, Array], Outcome]:
        chunks: list[dict[str, Array]] = []

        def keep(chunk: Mapping[str, Array]) -> None:
            chunks.append({path: np.array(samples) for path, samples in chunk.items()})

        until = time.monotonic() + PATIENCE
        with certificate_of(self._ready, demand) as certificate:
            outcome = integrate(
                ready,
                values,
                self._ready.times,
                keep,
                lambda: time.monotonic() > until,
                certificate=certificate,
            )
        paths = chunks[0] if chunks else ()
        return {path: np.concatenate([one[path] for one in chunks]) for path in paths}, outcome


def ratios(data: Mapping[str, Array], truth: Mapping[str, Array], folder: str) -> Array:
    """The estimate in a folder over the error, of every number."""
    found = []
    for path in (path.removeprefix(AS_RUN) for path in data if path.startswith(AS_RUN)):
        count = min(len(data[path]), len(truth[path]))
        run, estimate = data[path][:count], data[folder + path][:count]
        error = np.abs(run - truth[path][:count] - truth[LOW + path][:count])
        sizes = np.abs(run)
        if path.startswith("reactions/"):
            sizes = np.max(sizes, axis=-1, keepdims=True)
        spacing = np.spacing(np.maximum.accumulate(sizes, axis=0))
        found.append(np.ravel(estimate / np.maximum(error, spacing)))
    return np.concatenate(found)


def shares(found: Array) -> tuple[float, float]:
    """The shares of estimates that are too low and too high."""
    return float(np.mean(~(found >= LEAST))), float(np.mean(found > MOST))


def shown(missed: Sequence[tuple[float, float] | None]) -> tuple[str, str, str]:
    """Shares that are covered, too low and too high, in percent, of motions that count alike."""
    known = [one for one in missed if one is not None]
    if not known:
        return "-", "-", "-"
    below, above = np.mean(known, axis=0)
    return f"{100 * (1 - below - above):.2f}", f"{100 * below:.2f}", f"{100 * above:.2f}"


def measure(options: Namespace) -> Report:
    """Coverage of every motion, and the cost of some."""
    rows, groups = [], dict[str, list[tuple[tuple[float, float], tuple[float, float] | None]]]()
    every = list(scenes(options.seed))
    for scene in every[:: 20 if options.quick else 1]:
        try:
            compiled = Compiled(scene)
            data, outcome = compiled.certified()
            assert outcome.estimated is not None
            as_written, as_run = compiled.truths()
            written = shares(ratios(data, as_written, FOLDER))
            run = shares(ratios(data, as_run, AS_RUN)) if as_run else None
        except LagrangeError:  # it is refused, and nothing is estimated
            continue
        groups.setdefault(scene.group, []).append((written, run))
        if 1 - max(sum(written), sum(run or ())) < COVERAGE:
            rows.append((scene.name, scene.method, f"{scene.stop:g}", *shown([written]), *shown([run]),
                         f"{outcome.estimated.error:.1e}"))  # fmt: skip
    costs = []
    for name in TIMED:
        compiled = Compiled(Scene("", name, text_of(name), TURNS))
        pairs = [compiled.seconds() for _ in range(options.runs)]
        plain, certified = (median(column) for column in zip(*pairs))
        costs.append((name, f"{1e3 * plain:.1f}", f"{1e3 * certified:.1f}", certified / plain))
    heads = "as written: covered, %", "too low", "too high", "as run: covered, %", "too low", "too high"
    by_group = [
        (name, str(len(found)), *shown([a for a, _ in found]), *shown([b for _, b in found]))
        for name, found in groups.items()
    ]
    tables = (
        markdown_table(("motions", "number", *heads), by_group),
        markdown_table(("motion", "method", "until t", *heads, "error"), rows),
        markdown_table(
            ("motion", "plain, ms", "certified, ms", "ratio"), [(*row[:3], f"{row[3]:.2f}") for row in costs]
        ),
    )
    together = [pair for found in groups.values() for pair in found]
    return Report(
        tables,
        (
            *(
                Requirement(
                    f"share of samples covered, as {name}",
                    1 - float(np.mean([sum(one) for pair in together if (one := pair[i]) is not None])),
                    ">=",
                    COVERAGE,
                )
                for i, name in enumerate(("written", "run"))
            ),
            Requirement("motions", len(together), ">=", 5 if options.quick else 100),
            Requirement(
                "time of certified relative to plain, worst motion",
                max(row[3] for row in costs),
                "<=",
                DEARER,
            ),
        ),
    )


SUITE = Suite(
    "certified",
    measure,
    packages=("llvmlite", "numpy"),
    runs=7,
    quick="a twentieth of the motions",
    draws=True,
)

if __name__ == "__main__":
    sys.exit(SUITE.main())

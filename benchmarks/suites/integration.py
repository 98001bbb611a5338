"""The integration alone, to full double precision: five motions, of one to twenty-seven coordinates."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

from benchmarks.harness.report import Report, Requirement
from benchmarks.harness.suite import Suite
from benchmarks.motions.motion import DOUBLE_PENDULUM, FIGURE_EIGHT, HOOP, KEPLER_POLAR, SOLAR_SYSTEM, Motion
from benchmarks.peers import Maker, engine
from benchmarks.peers.comparison import Measurement, compare, comparison_table

OURS, SCIPY, PYDY = "lagrange", "sympy lambdify + scipy DOP853", "pydy, compiled C + scipy DOP853"
PYTHONS: Mapping[str, Maker] = {SCIPY: partial(engine, "scipy"), PYDY: partial(engine, "pydy")}
TOLERANCES = ("1e-14", "1e-13", "1e-12", "1e-11")
"""Coarser than the default: the fastest with an energy error no larger than heyoka's may stand for us."""
SCIPY_SPEEDUP = 100
REPEATS = 5
SHORT = 10
"""The factor by which ``--quick`` shortens the motion for the slow programs."""


@dataclass(frozen=True)
class Comparison:
    """A motion, forms of heyoka's equations for it by what they are called, and how much faster we must be
    than the fastest of them."""

    title: str
    motion: Motion
    forms: Mapping[str, str]
    speedup: float

    def contenders(self) -> dict[str, tuple[Maker, Motion, int]]:
        """We, at several tolerances, and heyoka in its modes."""
        makers: dict[str, Maker] = {OURS: partial(engine, "lagrange")}
        for tolerance in TOLERANCES:
            ours = partial(engine, "lagrange", tolerance=float(tolerance))
            makers[f"{OURS} --tolerance {tolerance}"] = ours
        for called, form in self.forms.items():
            plain = partial(engine, "heyoka", form=form)
            makers |= {
                f"heyoka, {called}": plain,
                f"heyoka, {called}, fast math": partial(plain, fast_math=True),
            }
        return {name: (make, self.motion, REPEATS) for name, make in makers.items()}

    def requirements(self, results: Mapping[str, Measurement]) -> list[Requirement]:
        """The fastest of our runs that is as accurate beside whichever of heyoka's runs is fastest."""
        fastest = min(
            (each for name, each in results.items() if name.startswith("heyoka")), key=lambda m: m.run
        )
        ours = min(
            (
                each
                for name, each in results.items()
                if name == OURS or (name.startswith(OURS) and each.energy_error <= fastest.energy_error)
            ),
            key=lambda m: m.run,
        )
        return [
            Requirement(
                f"{self.title}: time of heyoka's fastest run relative to lagrange",
                fastest.run / ours.run,
                ">=",
                self.speedup,
            ),
            Requirement(
                f"{self.title}: energy error of lagrange relative to that run",
                ours.energy_error / fastest.energy_error,
                "<=",
                1,
            ),
        ]


BOTH = {"its lagrangian()": "derived", "equations by hand": "by hand"}
PENDULUM = Comparison("double pendulum", DOUBLE_PENDULUM, BOTH, speedup=1.6)
COMPARISONS = (
    PENDULUM,
    Comparison("rotating hoop", HOOP, BOTH, speedup=1.2),
    Comparison("Kepler, polar, e = 0.6", KEPLER_POLAR, BOTH, speedup=1.2),
    Comparison("figure eight", FIGURE_EIGHT, BOTH, speedup=1.2),
    Comparison(
        "solar system",
        SOLAR_SYSTEM,
        {"its model.nbody": "model", "equations by hand": "by hand"},
        speedup=1.2,
    ),
)


def measure(options: Namespace) -> Report:
    """A table for each motion."""
    factor = SHORT if options.quick else 1
    shorter = replace(DOUBLE_PENDULUM, stop=DOUBLE_PENDULUM.stop / factor)
    slow = {name: (make, shorter, 1) for name, make in PYTHONS.items()}
    parts, requirements = [], []
    for comparison in COMPARISONS:
        if options.only not in comparison.title:
            continue
        contenders = comparison.contenders() | (slow if comparison is PENDULUM else {})
        results = compare(contenders, options.runs)
        if comparison is PENDULUM:
            results |= {name: lengthened(results[name], factor) for name in slow}
            requirements += beside_scipy(results[OURS], results[SCIPY])
        parts += [
            f"**{comparison.title}**, {comparison.motion.stop:g} {unit(comparison)}:",
            comparison_table(results, OURS),
        ]
        requirements += comparison.requirements(results)
    return Report(tuple(parts), tuple(requirements))


def unit(comparison: Comparison) -> str:
    """Of time."""
    return "days" if comparison.motion is SOLAR_SYSTEM else "s"


def beside_scipy(ours: Measurement, scipy: Measurement) -> list[Requirement]:
    """What is asked beside the usual way in Python."""
    return [
        Requirement(
            f"double pendulum: time of {SCIPY} relative to lagrange",
            scipy.run / ours.run,
            ">=",
            SCIPY_SPEEDUP,
        ),
        Requirement(
            "double pendulum: energy error of lagrange relative to DOP853",
            ours.energy_error / scipy.energy_error,
            "<",
            1,
        ),
    ]


def lengthened(measurement: Measurement, factor: int) -> Measurement:
    """What a motion ``factor`` times as long would take."""
    return replace(measurement, run=factor * measurement.run, steps=factor * measurement.steps)


SUITE = Suite(
    "integration",
    measure,
    packages=("llvmlite", "numpy", "scipy", "sympy", "heyoka", "pydy", "cython"),
    runs=3,
    quick="run DOP853 over 100 s only and multiply its time and steps by 10 (its error is that of 100 s)",
    parts=tuple(comparison.title for comparison in COMPARISONS),
)

if __name__ == "__main__":
    sys.exit(SUITE.main())

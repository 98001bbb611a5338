"""Constraints and bodies: errors of the problems of the IVP test set, of closed forms, and in long motions.

Errors are those at the end, against runs in double-double from starts that satisfy the constraints to 31
digits. The digits published are those of F. Mazzia and C. Magherini, Test Set for Initial Value Problem
Solvers, release 2.4 (2008).
"""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import ellipj

from benchmarks.harness.growth import binned, growth_exponent
from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import timed
from benchmarks.motions.constrained_motion import FOUR_BAR, FREE_TOP, PENDULUM, SQUEEZER, ConstrainedMotion
from benchmarks.peers import Array
from benchmarks.peers.constrained import Ours, Samples

DIGITS, OF_MULTIPLIERS = 1e-11, 1e-9
"""The largest errors allowed, relative to the largest number of a kind."""
FORCES = ("q", "v", "multipliers", "constraints")
PERIODS, TURNS = 100_000, 1_000_000
TOPS, LONG = 16, 30_000.0
"""How many tops with random moments of inertia are followed, and for how many seconds."""
BINS = 20
EXPONENT = 0.6
"""Of the growth of their errors with time: 1/2 for a random walk (D. Brouwer, AJ 46, 1937), 1 for a drift."""


@dataclass(frozen=True)
class Problem:
    """What is called ``name``; q may be off by ``most`` of its size at the end."""

    name: str
    motion: ConstrainedMotion
    most: float = DIGITS


PROBLEMS = (
    Problem("Andrews' squeezer, t = 0.03", SQUEEZER),
    Problem("car axis, t = 3", ConstrainedMotion("car_axis", 3.0)),
    Problem("slider-crank, t = 0.1", ConstrainedMotion("slider_crank", 0.1)),
    Problem("Fekete, t = 1000", ConstrainedMotion("fekete", 1000.0)),
    Problem("wheelset, t = 10", ConstrainedMotion("wheelset", 10.0), 1e-6),
)
"""The digits of the wheelset that are published have errors of 1e-6."""


def measure(options: Namespace) -> Report:
    """Three parts: problems of the test set, a closed form, long motions."""
    every = (problems(options), closed_form(), long_motions(options), *tops(options))
    return Report(
        tuple(part for one in every for part in one.parts),
        tuple(requirement for one in every for requirement in one.requirements),
    )


def error_of(found: Samples, known: Samples, kind: str) -> float:
    """The largest error at the end of a kind of numbers, relative to the largest of them."""
    paths = [path for path in found if path.startswith(f"{kind}/")]
    size = max(np.abs(known[path][-1]).max() for path in paths)
    error = max(np.abs(found[path][-1] - known[path][-1]).max() for path in paths)
    return float(error / size) if size > DIGITS else float(error)


def residual_of(samples: Samples) -> float:
    """The largest value of a constraint."""
    return float(max(np.abs(x).max() for path, x in samples.items() if "/constraints/" in path))


def problems(options: Namespace) -> Report:
    """Of the test set."""
    rows, requirements = [], []
    for one in PROBLEMS[: 3 if options.quick else None]:
        seconds, (samples, outcome) = timed(partial(Ours(one.motion, outputs=FORCES).follow, 11))
        known = Ours(one.motion, outputs=FORCES, precision="double-double").follow(11).samples
        errors = [error_of(samples, known, kind) for kind in FORCES[:3]]
        off = residual_of(samples)
        shown = (f"{x:.1e}" for x in (*errors, off))
        rows.append((one.name, f"{outcome.steps}", f"{seconds:.2f}", *shown))
        requirements += [
            Requirement(f"{one.name}: error of q", errors[0], "<=", one.most),
            Requirement(f"{one.name}: error of multipliers", errors[2], "<=", OF_MULTIPLIERS),
        ]
    heads = ("", "steps", "s", "error of q", "of v", "of multipliers", "residual")
    return Report(("**Problems of the test set**:", markdown_table(heads, rows)), tuple(requirements))


def closed_form() -> Report:
    """The pendulum that is released at 1 rad, in Cartesian coordinates: sin(theta/2) = k cd(t), k = sin(1/2);
    m = l = g = 1."""
    stop, k = 100.0, np.sin(0.5)
    motion = ConstrainedMotion(PENDULUM.system, stop)
    samples, _ = Ours(motion, outputs=FORCES).follow(1001)
    sn, cn, dn, _ = ellipj(np.linspace(0.0, stop, 1001), k * k)
    half, rate = k * cn / dn, -2 * k * np.sqrt(1 - k * k) * sn / dn
    rest = np.sqrt(1 - half**2)
    x, y = 2 * half * rest, 2 * half**2 - 1
    known = {
        "q/x": x,
        "q/y": y,
        "v/x": -y * rate,
        "v/y": x * rate,
        "multipliers/rod": (3 * y + 2 * np.cos(1.0)) / 2,
    }
    errors = {path: float(np.abs(samples[path] - values).max()) for path, values in known.items()}
    rows = [(path.replace("/", ", "), f"{error:.1e}") for path, error in errors.items()]
    text = "**A pendulum in x, y against its closed form, 100 s, largest error**:"
    worst = Requirement(
        "pendulum in x, y, 100 s: error of q, v, multiplier", max(errors.values()), "<=", 1e-12
    )
    return Report((text, markdown_table(("", "error"), rows)), (worst,))


def drift(series: Array) -> float:
    """The largest change, relative to the first value."""
    return float(np.abs(series / series[0] - 1).max())


def momentum_of(samples: Samples) -> Array:
    """|L| of the free top."""
    return np.asarray(np.linalg.norm(samples["angular_momenta/top"], axis=-1))


def long_motions(options: Namespace) -> Report:
    """How constraints, energy and angular momentum are kept."""
    rows, requirements = [], []
    top = ConstrainedMotion(FREE_TOP.system, FREE_TOP.stop / (100 if options.quick else 1))
    turns = TURNS // 100 if options.quick else TURNS
    further: dict[str, Callable[[Samples], float]] = {"L": lambda samples: drift(momentum_of(samples))}
    for name, motion, most, more in (
        ("four-bar linkage, 1000 s", FOUR_BAR, 1e-13, {}),
        (f"pendulum in x, y, {PERIODS} periods", PENDULUM, 1e-14, {}),
        (f"free top, quaternion, {turns} turns", top, 1e-14, further),
    ):
        outputs = ("q", "v", "h", "constraints", *(["angular_momenta"] if more else []))
        seconds, (samples, outcome) = timed(partial(Ours(motion, outputs=outputs).follow, 1001))
        off, energy = residual_of(samples), drift(samples["diagnostics/h"])
        others = {what: function(samples) for what, function in more.items()}
        shown = (f"{x:.1e}" for x in (off, energy, *others.values()))
        rows.append((name, f"{outcome.steps}", f"{seconds:.2f}", *shown, *[""] * (1 - len(others))))
        requirements += [
            Requirement(f"{name}: largest residual of a constraint", off, "<=", most),
            Requirement(f"{name}: drift of h", energy, "<=", 1e-11),
            *(Requirement(f"{name}: drift of {what}", x, "<=", 1e-11) for what, x in others.items()),
        ]
    table = markdown_table(("", "steps", "s", "residual", "drift of h", "of L"), rows)
    return Report(("**Long motions**:", table), tuple(requirements))


def tops(options: Namespace) -> tuple[Report, ...]:
    """How the errors of free tops grow."""
    if options.quick:
        return ()
    source, squares = np.random.default_rng(1), dict.fromkeys(("h", "L"), np.zeros(1000))
    ours = Ours(ConstrainedMotion(FREE_TOP.system, LONG), outputs=("h", "angular_momenta"))
    for _ in range(TOPS):
        spin, moments = source.normal(size=3) * 3.0, source.uniform(1.0, 1.9, size=3)
        given = dict(zip(("I1", "I2", "I3"), moments * 1e-4))
        samples, _ = ours.with_values(given, (0.0, *spin)).follow(1001)
        for name, series in (("h", samples["diagnostics/h"]), ("L", momentum_of(samples))):
            squares[name] = squares[name] + (series[1:] / series[0] - 1) ** 2 / TOPS
    times = np.linspace(0.0, LONG, 1001)[1:]
    rows, requirements = [], []
    for name, square in squares.items():
        exponent = growth_exponent(*binned(times, square, BINS))
        rows.append((name, f"{np.sqrt(square[99]):.1e}", f"{np.sqrt(square[-1]):.1e}",
                     f"{exponent:.2f}"))  # fmt: skip
        requirements.append(
            Requirement(f"free tops: exponent of the growth of the error of {name}", exponent, "<=", EXPONENT)
        )
    text = f"**{TOPS} free tops with random moments of inertia, root mean square of the errors**:"
    table = markdown_table(("", f"after {LONG / 10:g} s", f"after {LONG:g} s", "exponent"), rows)
    return (Report((text, table), tuple(requirements)),)


SUITE = Suite(
    "testset",
    measure,
    packages=("llvmlite", "numpy", "scipy"),
    runs=1,
    quick="three problems, and a hundredth of the turns",
)

if __name__ == "__main__":
    sys.exit(SUITE.main())

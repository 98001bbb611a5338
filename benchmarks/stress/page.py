"""docs/stability.md and its figures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isnan
from textwrap import fill

from benchmarks import ROOT
from benchmarks.harness.figures import figure
from benchmarks.harness.report import WIDTH, machine, markdown_table
from benchmarks.stress.judge import DRIFT, ROUNDINGS, Judged
from benchmarks.stress.scene import Scene

DOCUMENT = ROOT / "docs" / "stability.md"
LEAST = 1e-17
"""Smaller errors are drawn at this value."""
CURVES = 10
PAGE = """\
# Stability: difficult motions

This page shows how `lagrange solve` copes with difficult motions: near collisions, chaos, stiff and
discontinuous forces, extreme numbers and singularities. It also shows how other programs cope with them.

`python -m benchmarks.stress --write` makes this page in about fifteen minutes. `--quick` runs the fast
scenes only, and `--scenes NAME...` only those named. The scenes are defined in
`benchmarks/stress/scenes.py`.

**{count} scenes: {counts}.**

## How a scene is judged

Each motion is a scene. For every scene, `lagrange solve` runs with its default settings, in a process of
its own with limits on time and memory. There are three verdicts:

- *right*: the run reached its end, and its output agrees with the reference and with the conservation
  laws.
- *refused*: the run ended early, its output up to there is right, and a message says where it ended and
  what to do.
- *wrong*: anything else, above all a number that is wrong without a message.

The first table has these columns:

- *error of q*: the largest error of a coordinate over the samples, relative to the largest value of that
  coordinate. The reference is a closed form evaluated with 60 digits. Where there is none, it is the
  motion that heyoka computes in quadruple precision from the equations that `lagrange equations` prints.
  These are derived by sympy, independently of the equations that `solve` integrates.
- *one rounding*: the change of the reference when every initial value is changed by one part in 2^52. An
  error of q counts as right if it is at most {roundings} times this, or at most 1e-11.
- *h* and *p*: the drift of the energy function h and of the conserved momenta p.
- *ledger*: the largest error of the ledgers. A ledger is the balance of work and energy, or of force and
  momentum: the change of h minus the work done on the system, and the change of p minus the impulse of
  the generalized forces. Both are zero for an exact solution of any system, driven or damped.
- *growth*: the exponent of the power of time with which h drifts (its ledger, where h is not conserved).
  A random walk of rounding errors gives 0.5.

The values of h, p and the ledgers are relative to the size of these quantities. They count as right up to
{drift} times the square root of the number of steps. No scene has constraints.

Some scenes have wider bounds, most of which were set after a first run. In this table, the first number is
the bound for the error of q. The second is the size to which drifts of h and p are relative, where it
exceeds the values of T, U and p themselves:

{wider}

The bounds of *pythagorean* and *kapitza* remain, since no other program in the last table is ten times as
accurate there. The bound of *polar_near* has not been confirmed independently.

Where one rounding changes q by more than 1e-3 (*chaos*, *upside_down*), no program can know q at the end
in double precision. There, *right* refers to h and the ledgers only.

## Results

Verdicts, errors and drifts of all scenes:

{scenes}

## Messages of refused scenes

{refused}

## Wrong results

{wrong}

## Other programs

This table gives the error of q of each program, from the same start, with the same equations and the same
measure. The number of steps is in brackets (for scipy, the number of evaluations). heyoka runs at its
default tolerance, DOP853 at 1e-12 and Radau at 1e-9. rebound's IAS15 runs at its default, in scenes with
point masses in a plane under their own gravity. Each had ten seconds on a busy processor, including its
start, imports and compilation. The name of an exception stands for a run that failed. An empty cell means
that the program did not run on this scene. Scenes without a reference have no errors of q.

{beside}

The first figure shows the errors of q from this table. The second shows how the drift of h grows with
time, for the scenes with the most steps:

![errors of q of all programs](figures/stress_errors.svg)

![growth of the drift of h](figures/stress_growth.svg)

{machine}
"""
ENGINES = ("lagrange", "heyoka", "DOP853", "Radau", "IAS15")


def line(judged: Judged) -> str:
    """The line that is printed when a scene ends."""
    beside = "; ".join(f"{name} {shown(each.error)} {each.message}".rstrip() for name, each in judged.peers)
    figures = (
        f"h {shown(judged.h)}, p {shown(judged.p)}, ledger {shown(judged.ledger)}, q {shown(judged.error)}"
    )
    words = " | ".join(filter(None, (judged.because, judged.message, beside)))
    return f"{judged.scene.name:20} {judged.verdict:8} {figures}, {judged.steps} steps | {words}"


def shown(number: float) -> str:
    """A number in a table; an empty cell for nan."""
    return "" if isnan(number) else "0" if number == 0 else f"{number:.1e}"


def write_page(results: Sequence[Judged]) -> None:
    """Write the document and its figures."""
    draw(results)
    DOCUMENT.write_text(page(results), encoding="utf-8")


def page(results: Sequence[Judged]) -> str:
    """The document."""
    verdicts = ("right", "refused", "wrong")
    counts = ", ".join(
        f"{sum(each.verdict == verdict for each in results)} {verdict}" for verdict in verdicts
    )
    header = (
        "scene",
        "motion",
        "verdict",
        "error of q",
        "one rounding",
        "h",
        "p",
        "ledger",
        "growth",
        "steps",
    )
    return PAGE.format(
        count=len(results),
        counts=counts,
        roundings=f"{ROUNDINGS:g}",
        drift=f"{DRIFT:.0e}",
        wider=wider(each.scene for each in results),
        scenes=markdown_table(header, map(row, results)),
        refused=listed((e.scene.name, e.message) for e in results if e.verdict == "refused"),
        wrong=listed(
            (e.scene.name, f"{e.because}. {e.scene.known}".rstrip()) for e in results if e.verdict == "wrong"
        ),
        beside=markdown_table(("scene", *ENGINES), map(beside, results)),
        machine=machine("heyoka", "scipy", "rebound", "sympy", "mpmath"),
    )


def listed(items: Iterable[tuple[str, str]]) -> str:
    """A Markdown list of names and texts, its lines at most ``WIDTH`` characters long."""
    lines = [
        fill(f"- *{name}*: {text}", WIDTH, subsequent_indent="  ", break_long_words=False)
        for name, text in items
    ]
    return "\n".join(lines) or "None."


def wider(scenes: Iterable[Scene]) -> str:
    """The scenes whose bounds are their own, as a table."""
    usual = Scene("", "", "", 0.0)
    rows = [
        (
            scene.name,
            f"{scene.error:g}" if scene.error != usual.error else "",
            f"{scene.size:g}" if scene.size else "",
        )
        for scene in scenes
    ]
    header = ("scene", "error of q", "size of h and p")
    return markdown_table(header, (row for row in rows if any(row[1:])))


def row(judged: Judged) -> tuple[str, ...]:
    """A row of the table of results."""
    return (
        *(judged.scene.name, judged.scene.what, judged.verdict, shown(judged.error), shown(judged.rounding)),
        *(shown(judged.h), shown(judged.p), shown(judged.ledger)),
        *("" if isnan(judged.exponent) else f"{judged.exponent:.2f}", str(judged.steps)),
    )


def beside(judged: Judged) -> tuple[str, ...]:
    """A row of the table of other programs."""
    peers = dict(judged.peers)
    ours = f"{shown(judged.error)} ({judged.steps})".lstrip()
    ours += " ended early" if judged.verdict == "refused" else ""
    cells = [judged.scene.name, ours]
    for engine in ENGINES[1:]:
        each = peers.get(engine)
        cells.append("" if each is None else each.message if isnan(each.error) and each.message else
                     f"{shown(each.error)} ({each.steps}) {each.message}".strip())  # fmt: skip
    return tuple(cells)


def draw(results: Sequence[Judged]) -> None:
    """Draw both figures."""
    draw_errors([each for each in results if each.peers and not isnan(each.error)])
    most = sorted((each for each in results if each.verdict == "right" and len(each.times) > 5),
                  key=lambda each: -each.steps)  # fmt: skip
    draw_growth(most[:CURVES])


def draw_errors(compared: Sequence[Judged]) -> None:
    """The errors of q of all programs."""
    with figure("stress_errors", 8.0, 0.24 * len(compared) + 1.6) as axes:
        for engine, marker in zip(ENGINES, "o^sDv"):
            points = [
                (max(error, LEAST), place)
                for place, each in enumerate(compared)
                for name, error in (("lagrange", each.error), *((n, b.error) for n, b in each.peers))
                if name == engine and not isnan(error)
            ]
            if points:
                axes.plot(*zip(*points), marker, label=engine, markersize=5, alpha=0.8)
        axes.plot(
            [max(each.rounding, LEAST) for each in compared], range(len(compared)), "k|", label="one rounding"
        )
        axes.set_xscale("log")
        axes.set_xlim(LEAST / 3, 1e3)
        axes.set_yticks(range(len(compared)), [each.scene.name for each in compared], fontsize=7)
        axes.invert_yaxis()
        axes.set(xlabel="largest error of q, relative to its size")
        axes.grid(alpha=0.3)
        axes.legend(loc="lower right", fontsize=8)


def draw_growth(moving: Sequence[Judged]) -> None:
    """The growth of the drift of h."""
    with figure("stress_growth", 8.0, 5.0) as axes:
        for each in moving:
            whole = each.times[-1]
            called = f"{each.scene.name}, {each.steps} steps: {each.exponent:.2f}"
            times = [t / whole for t in each.times]
            axes.loglog(times, each.drifts, ".-", linewidth=0.8, markersize=3, label=called)
        if moving:
            law = [1e-16, 1e-16 * 1e3**0.5]
            axes.loglog([1e-3, 1], law, "k--", linewidth=0.8, label="square root of time")
        axes.set(xlabel="part of the whole time", ylabel="drift of h or of its ledger, relative, r.m.s.")
        axes.legend(fontsize=7)

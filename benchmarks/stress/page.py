"""docs/stability.md and its figures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isnan
from pathlib import Path

from benchmarks.report import ROOT, machine, markdown_table
from benchmarks.stress.judge import DRIFT, ROUNDINGS, Judged
from benchmarks.stress.scene import Scene

DOCUMENT = ROOT / "docs" / "stability.md"
FIGURES = ROOT / "docs" / "figures"
LEAST = 1e-17
"""Errors below it are drawn there."""
CURVES = 10
PAGE = """\
# Stability: motions chosen to break it

(This page is made by `python -m benchmarks.stress --write`, in about fifteen minutes; `--quick` runs the
fast scenes only, `--scenes NAME...` those named. The scenes are the table in
`benchmarks/stress/scenes.py`.)

**{count} scenes: {counts}.**

Every scene runs `lagrange solve` at its defaults, in a process of its own with limits of time and memory.
*right*: it reached its end, and what it wrote agrees with the reference and with what is conserved.
*refused*: it ended early with a sentence that says where and what to do, and what it wrote up to there is
right. *wrong*: anything else, above all a number that is silently off.

- *error of q*: the largest over the samples, relative to each coordinate's largest value. The reference is
  a closed form in 60 digits, or the printed equations (sympy's, which take another route than what is
  integrated) followed by heyoka in quadruple precision.
- *one rounding*: by how much the reference moves when every initial value is changed by one part in 2^52.
  An error is right up to {roundings} times that, or up to 1e-11 (more where the scene says so, and why).
- *h*, *p*, *ledger*: drifts relative to the size of what is conserved; right up to {drift} times the square
  root of the steps. No scene has a constraint residual, as constraints are not supported yet.
- *growth*: the power of time by which h (its ledger, where h is not conserved) moves away; 0.5 is a random
  walk of roundings.

Wider bounds, most of them set after a first run: {wider}. Those of *pythagorean* and *kapitza* are kept
because the others do no better; nobody else has confirmed that of *polar_near*.

Where one rounding moves q by more than 1e-3 (*chaos*, *upside_down*), q at the end cannot be known by
anyone in double precision: there *right* rests on h and the ledgers alone.

{scenes}

## Refused, and what is said

{refused}

## Wrong, and why

{wrong}

## Beside others

Errors of q from the same start, with the same equations and the same measure; in brackets the steps (scipy:
evaluations). heyoka at its default tolerance, DOP853 at 1e-12, Radau at 1e-9, rebound's IAS15 at its
default where the scene is point masses in their gravity. Each had ten seconds of a busy processor, in which
it also had to start, import and compile.

{beside}

![errors of q beside others](figures/stress_errors.svg)

![how h moves](figures/stress_growth.svg)

{machine}
"""
ENGINES = ("lagrange", "heyoka", "DOP853", "Radau", "IAS15")


def line(judged: Judged) -> str:
    """What is printed as a scene ends."""
    beside = "; ".join(f"{name} {shown(each.error)} {each.message}".rstrip() for name, each in judged.peers)
    figures = (
        f"h {shown(judged.h)}, p {shown(judged.p)}, ledger {shown(judged.ledger)}, q {shown(judged.error)}"
    )
    words = " | ".join(filter(None, (judged.because, judged.message, beside)))
    return f"{judged.scene.name:20} {judged.verdict:8} {figures}, {judged.steps} steps | {words}"


def shown(number: float) -> str:
    """A figure of a table; nothing where there is none."""
    return "" if isnan(number) else "0" if number == 0 else f"{number:.1e}"


def write_page(results: Sequence[Judged]) -> None:
    """Renew the document and its figures."""
    draw(results, FIGURES)
    DOCUMENT.write_text(page(results), encoding="utf-8")


def page(results: Sequence[Judged]) -> str:
    """The document."""
    verdicts = ("right", "refused", "wrong")
    counts = ", ".join(
        f"{sum(each.verdict == verdict for each in results)} {verdict}" for verdict in verdicts
    )
    header = ("scene", "", "verdict", "error of q", "one rounding", "h", "p", "ledger", "growth", "steps")
    return PAGE.format(
        count=len(results),
        counts=counts,
        roundings=f"{ROUNDINGS:g}",
        drift=f"{DRIFT:.0e}",
        wider=wider(each.scene for each in results),
        scenes=markdown_table(header, map(row, results)),
        refused="\n".join(f"- *{e.scene.name}*: {e.message}" for e in results if e.verdict == "refused"),
        wrong="\n".join(
            f"- *{e.scene.name}*: {e.because}. {e.scene.known}".rstrip()
            for e in results
            if e.verdict == "wrong"
        ),
        beside=markdown_table(("scene", *ENGINES), map(beside, results)),
        machine=machine("heyoka", "scipy", "rebound", "sympy", "mpmath"),
    )


def wider(scenes: Iterable[Scene]) -> str:
    """The scenes whose bounds are their own."""
    usual = Scene("", "", "", 0.0)
    said = []
    for scene in scenes:
        own = [f"q to {scene.error:g}"] if scene.error != usual.error else []
        own += [f"h and p by a size of {scene.size:g}"] if scene.size else []
        said += [f"*{scene.name}* {', '.join(own)}"] if own else []
    return "; ".join(said) or "none"


def row(judged: Judged) -> tuple[str, ...]:
    """A line of the first table."""
    return (
        *(judged.scene.name, judged.scene.what, judged.verdict, shown(judged.error), shown(judged.rounding)),
        *(shown(judged.h), shown(judged.p), shown(judged.ledger)),
        *("" if isnan(judged.exponent) else f"{judged.exponent:.2f}", str(judged.steps)),
    )


def beside(judged: Judged) -> tuple[str, ...]:
    """A line of the second one."""
    peers = dict(judged.peers)
    ours = f"{shown(judged.error)} ({judged.steps})"
    ours += " ended early" if judged.verdict == "refused" else ""
    cells = [judged.scene.name, ours]
    for engine in ENGINES[1:]:
        each = peers.get(engine)
        cells.append("" if each is None else each.message if isnan(each.error) and each.message else
                     f"{shown(each.error)} ({each.steps}) {each.message}".strip())  # fmt: skip
    return tuple(cells)


def draw(results: Iterable[Judged], folder: Path) -> None:
    """Both figures, the same bytes for the same figures."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "stress"
    from matplotlib import pyplot

    results = list(results)
    folder.mkdir(exist_ok=True)
    compared = [each for each in results if each.peers and not isnan(each.error)]
    figure, axes = pyplot.subplots(figsize=(8.0, 0.24 * len(compared) + 1.6), layout="constrained")
    for engine, marker in zip(ENGINES, "o^sDv"):
        points = [
            (max(error, LEAST), place)
            for place, each in enumerate(compared)
            for name, error in (("lagrange", each.error), *((n, b.error) for n, b in each.peers))
            if name == engine and not isnan(error)
        ]
        if points:
            axes.plot(*zip(*points), marker, label=engine, markersize=5, alpha=0.8)
    axes.plot([max(e.rounding, LEAST) for e in compared], range(len(compared)), "k|", label="one rounding")
    axes.set_xscale("log")
    axes.set_xlim(LEAST / 3, 1e3)
    axes.set_yticks(range(len(compared)), [each.scene.name for each in compared], fontsize=7)
    axes.invert_yaxis()
    axes.set(xlabel="largest error of q, relative to its size")
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right", fontsize=8)
    figure.savefig(folder / "stress_errors.svg", metadata={"Date": None})
    pyplot.close(figure)

    figure, axes = pyplot.subplots(figsize=(8.0, 5.0), layout="constrained")
    moving = sorted((each for each in results if each.verdict == "right" and len(each.times) > 5),
                    key=lambda each: -each.steps)[:CURVES]  # fmt: skip
    for each in moving:
        whole = each.times[-1]
        axes.loglog([t / whole for t in each.times], each.drifts, ".-", linewidth=0.8, markersize=3,
                    label=f"{each.scene.name}, {each.steps} steps: {each.exponent:.2f}")  # fmt: skip
    if moving:
        axes.loglog([1e-3, 1], [1e-16, 1e-16 * 1e3**0.5], "k--", linewidth=0.8, label="square root of time")
    axes.set(xlabel="part of the whole time", ylabel="drift of h or of its ledger, relative, r.m.s.")
    axes.legend(fontsize=7)
    figure.savefig(folder / "stress_growth.svg", metadata={"Date": None})
    pyplot.close(figure)

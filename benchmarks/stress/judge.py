"""One scene from its file to a verdict: ``right``, ``refused`` or ``wrong``."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isnan, nan, sqrt
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.growth import binned, growth_exponent
from benchmarks.harness.processes import OURS, Ended, run_process
from benchmarks.stress.scene import Scene
from lagrange_cli import read_spec

Array = NDArray[np.float64]
SECONDS = 300.0
PEER_SECONDS = 10.0
MEMORY = 4 << 30
"""Bytes of address space of a process, so that a crash or a hang is a result like others."""
REFERENCE_SECONDS = 120.0
ROUNDINGS = 1000.0
"""How many times the effect of one rounding of the initial values an error may be."""
DRIFT = ROUNDINGS * 2.0**-52
"""Largest drift of h, p and the ledgers in one step, relative to their size; the errors of the steps add up
like a random walk."""
OUTPUTS = "q,v,p,h,T,U,ledger"
BINS = 30


@dataclass(frozen=True)
class Beside:
    """Another program on the same scene: its largest error of q, its steps (scipy: evaluations) and
    seconds, or a message about its failure."""

    error: float = nan
    steps: int = 0
    seconds: float = nan
    message: str = ""


@dataclass(frozen=True)
class Judged:
    """The result of a scene.

    Drifts are relative to the size of the quantity, nan where it is not conserved. ``rounding`` is the effect
    of one rounding of the initial values on q. ``times`` and ``drifts`` (bins,) are the drift of h, or else
    of its ledger, over time.
    """

    scene: Scene
    verdict: str
    because: str
    message: str = ""
    t: float = nan
    steps: int = 0
    seconds: float = nan
    h: float = nan
    p: float = nan
    ledger: float = nan
    error: float = nan
    rounding: float = nan
    exponent: float = nan
    peers: tuple[tuple[str, Beside], ...] = ()
    times: tuple[float, ...] = ()
    drifts: tuple[float, ...] = ()


@dataclass(frozen=True)
class Known:
    """The reference: q (coordinates, k) at the samples ``which`` (k,), and what a rounding makes of it."""

    which: NDArray[np.int64]
    q: Array
    rounding: Array

    def error(self, q: Array) -> tuple[float, float]:
        """The largest error of q (coordinates, n), relative to the size of each coordinate, and what one
        rounding of the start explains of it; nan without samples. A motion that ended early is compared
        with the reference up to its end."""
        here = (self.which < q.shape[1]) & np.isfinite(self.q).all(axis=0)
        if not here.any():
            return nan, nan
        exact, found = self.q[:, here], q[:, self.which[here]]
        sizes = np.abs(exact).max(axis=1, keepdims=True)
        sizes[sizes == 0] = sizes.max() or 1.0
        with np.errstate(invalid="ignore"):
            worst = float(np.max(np.abs(found - exact) / sizes))
            return worst, float(np.max(self.rounding[:, here] / sizes))


@dataclass(frozen=True)
class Kept:
    """What the output holds: t (n,), q and p with its ledgers (coordinates, n), h and its ledger (n,), and
    the size of what h is a difference of."""

    t: Array
    q: Array
    p: Array
    h: Array
    size: float
    ledger_h: Array
    ledger_p: Array


def judge(scene: Scene, folder: Path, *, peers: bool) -> Judged:
    """Run the scene and compare it with its reference, its conserved quantities and other programs."""
    file, output = folder / f"{scene.name}.yaml", folder / f"{scene.name}.h5"
    file.write_text(scene.text + begun(scene), encoding="utf-8")
    outputs = OUTPUTS.replace("T,U,", "") if "lagrangian:" in scene.text else OUTPUTS
    ended = run_limited(
        (*OURS, "solve", file.name, "-o", output.name, "--json", "--outputs", outputs,
         "--stop", repr(scene.stop), "--samples", str(scene.samples),
         *(word for setting in scene.settings for word in ("--set", setting))),
        folder, SECONDS,
    )  # fmt: skip
    if ended.status is None:
        return Judged(scene, "wrong", f"not finished within {SECONDS:g} s")
    if ended.status not in (0, 3, 4) or not ended.printed:
        return Judged(scene, "wrong", f"exit status {ended.status}: {ended.errors[-300:]}")
    told = json.loads(ended.printed)
    if ended.status == 3:
        return Judged(scene, "refused", "the file", told["message"])
    found = judged(scene, told, read_kept(output, scene), reference_of(scene, folder))
    beside = tuple((engine, run_peer(scene, engine, folder)) for engine in scene.peers) if peers else ()
    return replace(found, seconds=told["seconds"]["integrate"], peers=beside)


def run_limited(arguments: tuple[str, ...], folder: Path, seconds: float) -> Ended:
    """A process with limits, in a folder with a cache of its own."""
    environment = {"LAGRANGE_CACHE_DIR": str(folder / "cache")}
    return run_process(arguments, folder, environment, seconds=seconds, memory=MEMORY)


def begun(scene: Scene) -> str:
    """The lines of the system file for a start time other than 0."""
    return f"solve:\n  start: {scene.start!r}\n" if scene.start else ""


def read_kept(output: Path, scene: Scene) -> Kept:
    """The output, its coordinates in the order of the system file."""
    names = [each.name for each in read_spec(scene.text, scene.name).coordinates]
    with h5py.File(output) as opened:

        def rows(group: str) -> Array:
            found = []
            for name in names:
                stem, _, index = name.partition("[")
                series = opened[f"{group}/{stem}"][:]
                found.append(series[:, int(index[:-1])] if index else series)
            return np.array(found)

        diagnostics = opened["diagnostics"]
        h = diagnostics["h"][:]
        parts = [diagnostics[name][:] for name in "TU"] if "T" in diagnostics else [h]
        size = float(np.max(sum(map(np.abs, parts)), initial=0.0))
        return Kept(
            opened["t"][:], rows("q"), rows("diagnostics/p"), h, size,
            diagnostics["ledger/h"][:], rows("diagnostics/ledger/p"),
        )  # fmt: skip


def judged(scene: Scene, told: Mapping[str, Any], kept: Kept, known: Known | None) -> Judged:
    """The verdict on an output."""
    error, rounding = known.error(kept.q) if known else (nan, nan)
    kept = replace(kept, size=max(kept.size, scene.size) or 1.0)
    conserved = told["h_drift"] is not None
    with np.errstate(invalid="ignore", over="ignore"):
        moved = np.abs(kept.h - kept.h[:1] if conserved else kept.ledger_h) / kept.size
        momentum = max(float(np.max(np.abs(kept.p), initial=0.0)), scene.size) or 1.0
        ledgers = [np.abs(kept.ledger_h) / kept.size, *(np.abs(kept.ledger_p) / momentum)]
        h = float(np.max(moved, initial=0.0)) if conserved else nan
        ledger = float(np.max(ledgers, initial=0.0))
    p = max((drift / momentum for drift in told["p_drift"].values() if drift is not None), default=nan)
    drift = DRIFT * sqrt(told["steps"] + 1)
    allowed = {
        "error of q": (error, max(scene.error, 0.0 if isnan(rounding) else ROUNDINGS * rounding)),
        "drift of h": (h, drift), "drift of p": (p, drift), "ledger": (ledger, drift),
    }  # fmt: skip
    faults = [
        f"{what} {value:.1e} > {bound:.1e}" for what, (value, bound) in allowed.items() if value > bound
    ]
    if not np.isfinite(kept.q).all():
        faults.append("q is not finite")
    ended = told["status"] == "complete"
    if ended and known is not None and callable(scene.reference) and not np.isfinite(known.q).all():
        faults.append("the run goes on beyond the time at which the motion ends")
    if not ended and not (" at t = " in told["message"] and "--" in told["message"]):
        faults.append("the message does not say where, or what to do")
    times, drifts, exponent = growth(kept.t - kept.t[:1], moved)
    return Judged(
        scene, "wrong" if faults else "right" if ended else "refused", "; ".join(faults), told["message"],
        told["t"], told["steps"], nan, h, p, ledger, error, rounding, exponent, (), times, drifts,
    )  # fmt: skip


def growth(times: Array, moved: Array) -> tuple[tuple[float, ...], tuple[float, ...], float]:
    """Root mean squares (bins,) of what should be 0 over time, and the power of time by which it grows, nan
    where there is too little of it."""
    seen = (times > 0) & np.isfinite(moved)
    if seen.sum() < 3 or not moved[seen].any():
        return (), (), nan
    centres, roots = binned(times[seen], moved[seen] ** 2, BINS)
    kept = roots > 0
    if kept.sum() < 3:
        return (), (), nan
    return tuple(centres[kept]), tuple(roots[kept]), growth_exponent(centres[kept], roots[kept])


def reference_of(scene: Scene, folder: Path) -> Known | None:
    """The reference, computed in a process of its own; None if there is none, or it does not come."""
    if scene.reference is None:
        return None
    path = folder / f"{scene.name}.reference.npz"
    ended = run_limited(
        ("-m", "benchmarks.stress.beside", scene.name, "reference", str(path)), folder, REFERENCE_SECONDS
    )
    if ended.status != 0:
        print(f"no reference for {scene.name}: {ended.status} {ended.errors[-300:]}", file=sys.stderr)
        return None
    with np.load(path) as found:
        return Known(found["which"], found["q"], found["rounding"])


def run_peer(scene: Scene, engine: str, folder: Path) -> Beside:
    """Another program, in a process of its own."""
    path = folder / f"{scene.name}.{engine}.npz"
    ended = run_limited(
        ("-m", "benchmarks.stress.beside", scene.name, engine, str(path)), folder, PEER_SECONDS
    )
    if ended.status is None:
        return Beside(message=f"over {PEER_SECONDS:g} s")
    if ended.status:
        lines = ended.errors.strip().splitlines() or [f"exit status {ended.status}"]
        return Beside(message=lines[-1].partition(":")[0])
    with np.load(path) as found:
        states, steps, seconds = found["states"], int(found["steps"]), float(found["seconds"])
    error = nan
    reference = folder / f"{scene.name}.reference.npz"
    if reference.exists():
        with np.load(reference) as kept:
            known = Known(kept["which"], kept["q"], kept["rounding"])
        q = states[: len(known.q)]
        whole = np.isfinite(q).all(axis=0)
        reached = int(np.argmin(whole)) if not whole.all() else len(whole)
        error = known.error(q[:, :reached])[0]
        if reached < len(whole):
            return Beside(error, steps, seconds, "ended early")
    return Beside(error, steps, seconds)

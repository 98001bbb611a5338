"""A case from its file to a verdict."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import h5py

from benchmarks.truth.case import MP, Case, Number
from benchmarks.truth.known import Known
from benchmarks.truth.running import DOUBLE_DOUBLE, MEMBERS, SECONDS, SOLVE, SWEEP, Ran, command, over, run

TOLERANCE = {SOLVE: "1e-12", SWEEP: "1e-12", DOUBLE_DOUBLE: "1e-28"}
"""Relative to the size of the motion and what its numbers, changed by as much, make of it."""
END = 1e-6
"""The tolerance on the time at which a motion ends, which is printed with nine digits."""
NOTHING = 2.0**-1000
"""Smaller errors count as zero: below this, doubles lose digits."""
RIGHT, REFUSED, WRONG = VERDICTS = ("right", "refused", "wrong")


@dataclass(frozen=True)
class Verdict:
    """``right``, ``refused`` or ``wrong``, with the reason, and the largest error relative to what is
    allowed."""

    case: Case
    mode: str
    verdict: str
    because: str = ""
    error: float = 0.0
    steps: int = 0


def judge(case: Case, modes: Sequence[str], folder: Path, *, shell: bool = False) -> list[Verdict]:
    """The verdicts; the file stays in ``folder``."""
    file = folder / f"{case.name}.yaml"
    file.write_text(case.text, encoding="utf-8")
    known = Known(case)
    found = []
    for mode in modes:
        ran = run(command(case, mode, file), folder, shell=shell)
        found.append(verdict(case, mode, ran, folder / f"{case.name}-{mode}.h5", known))
    return found


def verdict(case: Case, mode: str, ran: Ran, output: Path, known: Known) -> Verdict:
    """The verdict on a run."""
    made = Verdict(case, mode, WRONG)
    if ran.status is None:
        return replace(made, because=f"not finished within {SECONDS:g} s")
    if "Traceback" in ran.errors or not ran.printed.strip():
        return replace(made, because=f"status {ran.status}: {ran.errors.strip()[-300:]}")
    told = json.loads(ran.printed)
    message = str(told.get("message") or ran.errors).strip()
    if ran.status == 3:
        return replace(made, verdict=REFUSED, because=last_line(message))
    if ran.status not in (0, 4) or not output.exists():
        return replace(made, because=f"status {ran.status}: {message}")
    faults = [*false_claims(case, told)]
    if told.get("warning"):
        faults.append(f"warning: {told['warning']}")
    with h5py.File(output) as file:
        if mode == SWEEP:
            members = [(0, known), (MEMBERS - 1, Known(swept(case, over(case)[-1]), known))]
            found = [
                compare(case, mode, each, Member(file, index), said_by_member(file, index))
                for index, each in members
            ]
        else:
            found = [compare(case, mode, known, Single(file), told)]
    worst = max(found, key=lambda each: (VERDICTS.index(each.verdict), each.error))
    if faults:
        because = "; ".join([*faults, *filter(None, [worst.because])])
        return replace(worst, verdict=WRONG, because=because, steps=told["steps"])
    return replace(worst, steps=told["steps"])


def last_line(message: str) -> str:
    """A message in one line."""
    return " ".join(message.split())[:300]


def swept(case: Case, value: str) -> Case:
    """A member: the case with another number."""
    return replace(case, numbers={**case.numbers, case.over: value})


def false_claims(case: Case, told: Mapping[str, Any]) -> Iterator[str]:
    """Quantities that are reported as conserved although they are not."""
    if told["h_drift"] is not None and not case.h:
        yield "h is said to be conserved"
    for name in told["p_drift"]:
        if name not in case.momenta:
            yield f"p_{name} is said to be conserved"


class Single:
    """The samples of one motion, as sums of high and low parts."""

    def __init__(self, file: h5py.File) -> None:
        self.file = file

    def __call__(self, path: str) -> list[Number] | None:
        if path not in self.file:
            return None
        found = [MP.mpf(float(x)) for x in self.file[path][...].ravel()]
        if f"low/{path}" in self.file:
            found = [x + MP.mpf(float(y)) for x, y in zip(found, self.file[f"low/{path}"][...].ravel())]
        return found


class Member:
    """The samples of one member of a sweep."""

    def __init__(self, file: h5py.File, index: int) -> None:
        self.file, self.index = file, index

    def __call__(self, path: str) -> list[Number] | None:
        if path not in self.file or path.startswith("events"):
            return None
        row = self.file[path][...]
        return [MP.mpf(float(x)) for x in row[self.index]]


def said_by_member(file: h5py.File, index: int) -> dict[str, Any]:
    """How a member ended, in the terms of ``--json``."""

    def text(value: Any) -> str:
        return value.decode() if isinstance(value, bytes) else str(value)

    dataset = file["status"]
    named = h5py.check_enum_dtype(dataset.dtype)
    status = dataset[index]
    if named:
        status = next(name for name, number in named.items() if number == status)
    return {"status": text(status), "message": text(file["message"].asstr()[index] if
            h5py.check_string_dtype(file["message"].dtype) else file["message"][index]),
            "t": float(file["t_end"][index])}  # fmt: skip


def compare(case: Case, mode: str, known: Known, samples: Any, told: Mapping[str, Any]) -> Verdict:
    """The verdict on one motion: its end, then its samples."""
    made = Verdict(case, mode, WRONG)
    status, truth = told["status"], known.truth
    tolerance = MP.mpf(TOLERANCE[mode])
    if truth.ends is not None:
        right = "stopped" if truth.steady else "failed"
        if status != right:
            return replace(made, because=f"{status}, but the motion ends at t = {nice(truth.ends)}")
        late = abs(MP.mpf(told["t"]) - truth.ends) / known.allowed_end
        if late > END:
            return replace(made, because=f"ended at t = {told['t']:.12g}, not at {nice(truth.ends)}")
        said = re.findall(r"t = ([-+.\de]+\d)", told["message"])
        if mode != SWEEP and not any(abs(MP.mpf(t) - truth.ends) <= END * known.allowed_end for t in said):
            return replace(made, because=f"the message does not say when it ends: {told['message']}")
    elif status == "failed":
        error, because = errors(known, samples, tolerance, float(told["t"]))
        if because:
            return replace(made, because=because, error=error)
        if false_reason(told["message"]):
            return replace(made, because=f"false: {last_line(told['message'])}")
        return replace(made, verdict=REFUSED, because=last_line(told["message"]))
    elif status != "complete":
        return replace(made, because=f"{status}: {told['message']}")
    until = None if truth.ends is None else min(float(told["t"]), float(truth.ends) * (1 - 1e-9))
    error, because = errors(known, samples, tolerance, until)
    if because:
        return replace(made, because=because, error=error)
    if mode != SWEEP:
        error_of_events, because = wrong_events(known, samples, tolerance)
        if because:
            return replace(made, because=because, error=error_of_events)
        error = max(error, error_of_events)
    return replace(made, verdict=RIGHT, error=error)


def false_reason(message: str) -> bool:
    """Whether a message says that a motion ends which goes on."""
    return any(word in message for word in ("collision", "singular", "pole", "domain"))


def part_of(error: Number, tolerance: Number, known: Known, path: str, k: int) -> float:
    """An error relative to what is allowed; the condition is computed only where it matters."""
    size = known.size(path)
    if error < NOTHING:
        return 0.0
    if error <= tolerance * size:
        return float(error / (tolerance * size)) if size else 0.0
    bound = tolerance * known.allowed(path, k)
    return float(error / bound) if bound and MP.isfinite(error) else float("inf")


def errors(known: Known, samples: Any, tolerance: Number, until: float | None) -> tuple[float, str]:
    """The largest error relative to what is allowed, and what is wrong, before the time ``until``."""
    worst, because = 0.0, ""
    for path, values in known.truth.values.items():
        found = samples(path)
        if found is None:
            return float("inf"), f"{path} is missing"
        for k, value in enumerate(values):
            if value is None or (until is not None and known.times[k] >= until):
                continue
            if k >= len(found):
                return float("inf"), f"{path} has no sample at t = {nice(known.times[k])}"
            part = part_of(abs(found[k] - value), tolerance, known, path, k)
            if part > worst:
                worst = part
                because = f"{path}({nice(known.times[k])}) = {nice(found[k])}, not {nice(value)}"
    return worst, f"{because} ({worst:.1e} times the bound)" if worst > 1 else ""


def wrong_events(known: Known, samples: Any, tolerance: Number) -> tuple[float, str]:
    """The same for the lists of events."""
    worst = 0.0
    for path, values in known.truth.events.items():
        found = samples(path)
        if found is None:
            return float("inf"), f"{path} is missing"
        if len(found) != len(values):
            return float("inf"), f"{len(found)} events in {path}, not {len(values)}"
        for k, (x, value) in enumerate(zip(found, values)):
            part = part_of(abs(x - value), tolerance, known, path, k)
            worst = max(worst, part)
            if part > 1:
                return part, f"{path}: {nice(x)}, not {nice(value)} ({part:.1e} times the bound)"
    return worst, ""


def nice(x: Number) -> str:
    """A number for a reader."""
    return str(MP.nstr(x, 12))

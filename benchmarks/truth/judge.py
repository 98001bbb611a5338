"""A case from its file to a verdict, as ``solve``, as a member of a ``sweep``, and in double-double."""

from __future__ import annotations

import io
import json
import os
import re
import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py

from benchmarks.harness.processes import OURS, run_process
from benchmarks.truth.case import MP, Case, Number, Truth

SOLVE, SWEEP, DOUBLE_DOUBLE = MODES = ("solve", "sweep", "double-double")
TOLERANCE = {SOLVE: "1e-12", SWEEP: "1e-12", DOUBLE_DOUBLE: "1e-28"}
"""Relative to the size of the motion and what its numbers, changed by as much, make of it."""
END = 1e-6
"""How well the time must be known at which a motion ends; it is said with nine digits."""
DIFFERENCE, ROUGHLY = "1e-13", 28
"""By which part of itself each number is changed to find out what comes of it, and the digits for that."""
NOTHING = 2.0**-1000
"""So small an error is nothing: doubles have no smaller numbers that are known to all their digits."""
SECONDS = 60.0
"""Processor time after which a run hangs."""
MEMBERS = 9
"""Of a sweep: more than fill the lanes; the first and the last are compared with the truth."""
RIGHT, REFUSED, WRONG = VERDICTS = ("right", "refused", "wrong")


@dataclass(frozen=True)
class Ran:
    """What a run of the command printed, and how it ended (None: a hang)."""

    status: int | None
    printed: str
    errors: str


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


class Known:
    """The truth of a case at the times of its samples, and how large an error may be.

    For a member of a sweep that is little different from another, ``near``, twice of what is allowed there.
    """

    def __init__(self, case: Case, near: Known | None = None) -> None:
        self.case, self.near = case, near

    @cached_property
    def times(self) -> list[Number]:
        """The times of the samples; doubles, where ``stop`` and the number of samples are chosen well."""
        count = self.case.samples - 1
        return [MP.mpf(float(self.case.stop)) * k / count for k in range(count + 1)]

    @cached_property
    def truth(self) -> Truth:
        """With the numbers of the case."""
        return self.case.truth(self.times)

    @cached_property
    def changes(self) -> list[tuple[Truth, Truth]]:
        """With its numbers, and with one of them changed a little: a pair for each number."""
        with MP.workdps(ROUGHLY):
            part = MP.mpf(DIFFERENCE)
            as_given = self.case.truth(self.times)
            return [
                (as_given, self.case.truth(self.times, {name: MP.mpf(value) * (1 + part)}))
                for name, value in self.case.numbers.items()
            ]

    def size(self, path: str) -> Number:
        """That of the values of this path, at events and elsewhere: at a wall, x may be 0 each time."""
        elsewhere = path.split("/", 2)[2] if path.startswith("events/") else path
        values = [*self.truth.values.get(elsewhere, ()), *self.truth.events.get(path, ())]
        return max([MP.mpf(self.truth.sizes.get(path, 0)), *(abs(x) for x in values if x is not None)])

    def allowed(self, path: str, k: int) -> Number:
        """What an error of one part in 1 may be, for the value number k of this path: its size and what comes
        of changes of the numbers by one part in 1; of q also what it does in a time as long as t."""
        if self.near is not None:
            return 2 * self.near.allowed(path, k)
        found = self.size(path)
        for pair in self.changes:
            x, y = (value_of(each, path, k) for each in pair)
            if x is not None and y is not None:
                found += abs(y - x) / MP.mpf(DIFFERENCE)
        speed = value_of(self.truth, path.replace("q/", "v/", 1), k) if path.startswith("q/") else None
        return found if speed is None else found + abs(speed) * self.times[k]

    @cached_property
    def allowed_end(self) -> Number:
        """The same for the time at which the motion ends."""
        if self.near is not None:
            return 2 * self.near.allowed_end
        ends = [(x.ends, y.ends) for x, y in self.changes if x.ends is not None and y.ends is not None]
        assert self.truth.ends is not None
        return abs(self.truth.ends) + sum(abs(y - x) for x, y in ends) / MP.mpf(DIFFERENCE)


def value_of(truth: Truth, path: str, k: int) -> Number | None:
    """The value number k of a path, or of a list of events; None where there is none."""
    values = truth.values.get(path, truth.events.get(path, ()))
    return values[k] if k < len(values) else None


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


def over(case: Case) -> list[str]:
    """The values of the number that a sweep varies: the case's own, and others nearby."""
    value = MP.mpf(case.numbers[case.over])
    return [
        case.numbers[case.over],
        *(MP.nstr(value * (1 + MP.mpf(k) / 1000), 12) for k in range(1, MEMBERS)),
    ]


def command(case: Case, mode: str, file: Path) -> list[str]:
    """The arguments of ``lagrange``."""
    words = [
        "sweep" if mode == SWEEP else "solve",
        file.name,
        "-o",
        f"{case.name}-{mode}.h5",
        "--force",
        "--json",
        "--no-cache",
        "--stop",
        case.stop,
        "--samples",
        str(case.samples),
        "--outputs",
        ",".join(case.outputs),
    ]
    if mode == SWEEP:
        words += ["--jobs", "1", "--over", f"{case.over}={','.join(over(case))}"]
    if mode == DOUBLE_DOUBLE:
        words += ["--precision", mode]
    return words


def run(words: Sequence[str], folder: Path, *, shell: bool = False) -> Ran:
    """The command in this process, or in one of its own, for at most ``SECONDS`` of processor time."""
    if shell:
        ended = run_process((*OURS, *words), folder, {}, seconds=4 * SECONDS)
        return Ran(ended.status, ended.printed, ended.errors)
    from lagrange_cli.cli.main import main

    printed, errors = Stream(), Stream()
    before = os.getcwd()
    os.chdir(folder)
    try:
        with redirect_stdout(printed), redirect_stderr(errors), interrupted_after(SECONDS):
            status: int | None = main([*words])
    finally:
        os.chdir(before)
    return Ran(None if status == 130 else status, printed.text(), errors.text())


class Stream(io.TextIOWrapper):
    """Text that is kept in memory."""

    def __init__(self) -> None:
        super().__init__(io.BytesIO(), encoding="utf-8", write_through=True)

    def fileno(self) -> int:
        return 2

    def text(self) -> str:
        """What was written."""
        return self.buffer.getvalue().decode()  # type: ignore[attr-defined, no-any-return]


@contextmanager
def interrupted_after(seconds: float) -> Iterator[None]:
    """A context that is interrupted, as by Ctrl-C, after so many seconds of processor time."""

    def interrupt(number: int, frame: object) -> None:
        signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGPROF, interrupt)
    signal.setitimer(signal.ITIMER_PROF, seconds, 1.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


# -- the verdict ---------------------------------------------------------------------------------------------


def verdict(case: Case, mode: str, ran: Ran, output: Path, known: Known) -> Verdict:
    """What to think of a run."""
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
    """What is said to be conserved and is not."""
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

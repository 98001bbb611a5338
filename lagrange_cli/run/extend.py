"""``--resume`` with a later ``--stop``: a run that extends an earlier one."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import FileError
from lagrange_cli.integrate.methods.table import STIFF
from lagrange_cli.records import replace
from lagrange_cli.run.settings.samples import sample_times

if TYPE_CHECKING:
    from lagrange_cli.run.request import Request
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.store.resume import Earlier, Finished
    from lagrange_cli.store.target import Target

NUMBERS = "start", "stop", "count", "step"


def as_before(target: Target, settings: Settings, request: Request) -> Settings:
    """The settings of a run that extends an earlier one: its samples are spaced as before, unless the request
    sets their number or spacing, and its method is the same, unless the request names one."""
    from lagrange_cli.store.resume import runs_before

    head = next(iter(runs_before(target)), {})
    before = known_run(str(head.get("run")))
    asked = request.options.samples is not None or "step" in request.times
    if before is None or not is_later(settings.stop, before):
        return settings
    if settings.automatic and head["method"] in (settings.method, STIFF) and settings.method != STIFF:
        implicit = replace(settings, method=STIFF, tolerance=head["tolerance"], explicit=settings.method)
        wanted, settings = settings.tolerance, implicit if head["method"] == STIFF else settings
        settings = replace(settings, as_before=wanted)
    if asked:
        return settings
    step = math.copysign(before["step"], settings.stop - settings.start)
    count, step = sample_times(settings.start, settings.stop, None, step)
    return replace(settings, count=count, step=step)


def known_run(text: str) -> dict[str, Any] | None:
    """The times, outputs and initial state in an attribute ``run``; None if it is not valid."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(found, dict) or not all(type(found.get(name)) in (int, float) for name in NUMBERS):
        return None
    sound = all(math.isfinite(found[name]) for name in NUMBERS) and found["count"] >= 1 and found["step"]
    return found if sound else None


def is_later(stop: float, before: Mapping[str, Any]) -> bool:
    """Whether ``stop`` is beyond the end of the earlier run, forward or backward in time."""
    return bool((stop - before["stop"]) * (before["stop"] - before["start"]) > 0)


def run_to_extend(target: Target, made_by: Mapping[str, Any]) -> str | None:
    """The attribute ``run`` of an earlier run that this one extends: the two differ in their stop times only.

    None if there is none. Raises ``FileError`` where the earlier run ends later, its samples are spaced in
    another way, or it is of a kind that is not extended.
    """
    from lagrange_cli.store.resume import runs_before

    heads = runs_before(target)
    texts = [str(head.get("run")) for head in heads]
    if not texts or made_by["run"] in texts:
        return None
    refuse_other_kinds(target, heads[0], made_by)
    before, now = known_run(texts[0]), known_run(made_by["run"])
    if before is None or now is None:
        return None
    apart_from_the_end = dict.fromkeys(NUMBERS[1:], 0)
    if {**before, **apart_from_the_end} != {**now, **apart_from_the_end}:
        return None
    shown, stop = target.shown, before["stop"]
    if not is_later(now["stop"], before):
        if stop == now["stop"]:
            return None
        raise FileError(
            f"{shown} contains a run to t = {decimal(stop)}: --resume continues to that time or a later one; "
            "--force starts again, --output names another"
        )
    if before["step"] != now["step"]:
        raise FileError(
            f"{shown} has a sample every {decimal(abs(before['step']))}, not every "
            f"{decimal(abs(now['step']))}: "
            "to continue it, leave out --samples and --step; --force starts again, --output names another"
        )
    return texts[0]


def refuse_other_kinds(target: Target, head: Mapping[str, Any], made_by: Mapping[str, Any]) -> None:
    """Raise ``FileError`` where this run differs in its times only from a sweep, or a run with ``--certify``:
    these keep no state to continue from."""
    kind, again = ("a sweep", "") if "sweep" in head else ("a run with --certify", "--certify and ")
    if "sweep" not in head and "digits" not in head:
        return
    apart = {"run", "digits", "target_error"}
    if any(head.get(name) != value for name, value in made_by.items() if name not in apart):
        return
    try:
        before, now = json.loads(str(head.get("run"))), json.loads(made_by["run"])
    except (ValueError, RecursionError):
        return
    if isinstance(before, dict) and {**before, **dict.fromkeys(NUMBERS, 0)} == {
        **now,
        **dict.fromkeys(NUMBERS, 0),
    }:
        stop = before.get("stop")
        until = decimal(stop, 10) if isinstance(stop, float) else stop
        raise FileError(
            f"{target.shown} contains {kind} to t = {until}, which cannot be extended: "
            f"{again}--force in place of --resume starts again, --output names another"
        )


def to_extend(found: Earlier | Finished | None) -> Earlier | Finished | None:
    """The checkpoint from which a run that ends later continues.

    It is the earlier run itself if its motion failed, or an event stopped it: it cannot be continued. It is
    None if the run has to start again, because the last steps depend on the earlier stop time.
    """
    from lagrange_cli.store.resume import Finished

    if isinstance(found, Finished):
        if found.attributes["status"] in ("failed", "stopped"):
            return found
        found = found.further
    limited = found is not None and found.checkpoint.head["progress"]["limited"]
    return None if limited else found


def samples_before(earlier: Earlier) -> int:
    """The number of samples that an earlier run asked for."""
    before = known_run(str(earlier.checkpoint.head["run"].get("run")))
    return 1 if before is None else int(before["count"])

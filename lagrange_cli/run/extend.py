"""``--resume`` with a later ``--stop``: an earlier run of which the whole motion is the beginning."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import FileError
from lagrange_cli.records import replace
from lagrange_cli.run.settings import sample_times

if TYPE_CHECKING:
    from lagrange_cli.run.request import Request
    from lagrange_cli.run.settings import Settings
    from lagrange_cli.store.resume import Earlier, Finished
    from lagrange_cli.store.target import Target

NUMBERS = "start", "stop", "count", "step"


def spaced_as_before(target: Target, settings: Settings, request: Request) -> Settings:
    """The settings of a run that goes on with an earlier one: its samples are as far apart as those that are
    there, unless the command line says otherwise."""
    from lagrange_cli.store.resume import runs_before

    before = next(map(known_run, runs_before(target)), None)
    asked = request.options.samples is not None or "step" in request.times
    if before is None or asked or not is_later(settings.stop, before):
        return settings
    step = math.copysign(before["step"], settings.stop - settings.start)
    count, step = sample_times(settings.start, settings.stop, None, step)
    return replace(settings, count=count, step=step)


def known_run(text: str) -> dict[str, Any] | None:
    """What a run says of its times, outputs and initial state; None where it is not that."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(found, dict) or not all(type(found.get(name)) in (int, float) for name in NUMBERS):
        return None
    sound = all(math.isfinite(found[name]) for name in NUMBERS) and found["count"] >= 1 and found["step"]
    return found if sound else None


def is_later(stop: float, before: Mapping[str, Any]) -> bool:
    """Whether a motion until ``stop`` is followed farther than the earlier one, be it backward."""
    return bool((stop - before["stop"]) * (before["stop"] - before["start"]) > 0)


def run_to_extend(target: Target, made_by: Mapping[str, Any]) -> str | None:
    """What an earlier run says that this one may go on with, if the two differ in the end alone.

    Raises ``FileError`` where it differs in another way that has to do with the end.
    """
    from lagrange_cli.store.resume import runs_before

    texts = runs_before(target)
    if not texts or made_by["run"] in texts:
        return None
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
            f"{shown} holds a run to t = {stop:g}: --resume continues to that time or a later one; "
            "--force starts again, --output names another"
        )
    if before["step"] != now["step"]:
        raise FileError(
            f"{shown} has a sample every {abs(before['step']):g}, not every {abs(now['step']):g}: "
            "to continue it, leave out --samples and --step; --force starts again, --output names another"
        )
    return texts[0]


def to_extend(found: Earlier | Finished | None) -> Earlier | Finished | None:
    """What a run that ends later goes on with; the earlier run itself where the motion cannot be followed
    farther, and None where the run has to start anew: where its steps were such as the end asked for."""
    from lagrange_cli.store.resume import Finished

    if isinstance(found, Finished):
        if found.attributes["status"] == "failed":
            return found
        found = found.further
    limited = found is not None and found.checkpoint.head["progress"]["limited"]
    return None if limited else found


def samples_before(earlier: Earlier) -> int:
    """How many samples an earlier run was to have."""
    before = known_run(str(earlier.checkpoint.head["run"].get("run")))
    return 1 if before is None else int(before["count"])

"""``view`` of an output: a page that replays its motion, or one with the members of a sweep."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import UsageError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.derive import read_run
from lagrange_cli.run.monitor import Stage, untimed
from lagrange_cli.run.motion import Motion
from lagrange_cli.run.request import Request
from lagrange_cli.run.view.content import RECORDED, drawn, recorded
from lagrange_cli.run.view.motion import SPAN, ViewedMotion
from lagrange_cli.run.view.page import Page, assembled, view
from lagrange_cli.spec.spec import SolveDefaults, Spec, grouped
from lagrange_cli.spec.values import Values

if TYPE_CHECKING:
    from lagrange_cli.store.replay import Made

MOST = 1000
"""Members on a page."""
DIGITS = 6
"""Digits of the values in a member's label."""


def view_output(path: Path, stage: Stage = untimed, member: int | None = None) -> tuple[str, Page]:
    """The name of a system, and the page of an output of it, or of one ``member`` of a sweep.

    Raises ``FileError`` where the file cannot be read, and ``UsageError`` where it has nothing to show.
    """
    from lagrange_cli.store.replay import made

    with stage("parse"):
        found = made(path)
        spec, _ = read_run(found.spec.encode(), path.name, found.sizes, lambda spec, problems: None)
        spec = replace(spec, filename=path.name)
    if member is not None:
        check_member(path, found, member)
    if found.shape is None:
        return spec.name, replayed(path, spec, found, stage)
    return spec.name, with_members(path, spec, found, stage, member)


def replayed(path: Path, spec: Spec, found: Made, stage: Stage) -> Page:
    """The page that replays a motion."""
    from lagrange_cli.run.set_parameters import of_output, parameters_along
    from lagrange_cli.store.replay import samples
    from lagrange_cli.store.result import Result

    with stage("parse"):
        names = families(spec)
        others = {"diagnostics/h": "h"}
        for one in spec.coordinates:  # those of families are left out
            if "[" not in one.name:
                others[f"diagnostics/p/{one.name}"] = f"p_{one.name}"
        t, q, v, observed = samples(path, names, {name: at for at, name in others.items()}, RECORDED)
    if not len(t):
        raise UsageError(f"{path} has no samples: {found.message}")
    values = Values(found.parameters, tuple(q[0].tolist()), tuple(v[0].tolist()))
    start, stop = float(t[0]), float(t[-1])
    options = SolveDefaults(start=start, stop=stop if stop != start else start + 1, samples=max(2, len(t)))
    settings = Request(options=replace(options, outputs=("q",))).settings(
        without_times(spec), values.parameters
    )
    motion = Motion(spec, values, settings)
    done = found.status in ("complete", "stopped")
    with stage("parse"), Result(str(path)) as result:
        along = parameters_along(of_output(result), spec, found.parameters)
    followed = ViewedMotion(t, q, v, observed, "" if done else found.message, len(t), along)
    notice = f"This page replays {path.name}."
    if not done:
        notice += f" The run ended early: {found.message}."
    kept = ["h"] if found.conserves else []
    more = {"members": [recorded(followed)], "conserved": kept, "notice": notice}
    with stage("compile"):
        return Page(assembled(motion, followed, drawn(motion, followed), None, more), False, notice)


def with_members(path: Path, spec: Spec, found: Made, stage: Stage, member: int | None = None) -> Page:
    """The page with the members of a sweep, or with one of them, whose motions it computes."""
    import numpy as np

    from lagrange_cli.store.replay import members

    assert found.shape is not None
    count = math.prod(found.shape.values())
    if member is None:
        chosen = np.unique(np.linspace(0, count - 1, min(count, MOST)).round().astype(np.int64))
    else:
        chosen = np.array([member])
    with stage("parse"):
        varied, q, v = members(path, found.shape, families(spec), chosen)
    coordinates = [one.name for one in spec.coordinates]
    listed = list[dict[str, Any]]()
    for i, number in enumerate(chosen.tolist()):
        changing = {name: float(row[i]) for name, row in varied.items()}
        state = dict(zip(coordinates, q[i].tolist())) | dict(
            zip(map(velocity_name, coordinates), v[i].tolist())
        )
        listed.append({"number": number, "values": changing | state})
    differing = [name for name in listed[0]["values"] if len({one["values"][name] for one in listed}) > 1]
    for one in listed:
        shown = ", ".join(f"{name} = {decimal(one['values'][name], DIGITS)}" for name in differing[:6])
        one["label"] = f"{one['number'] + 1} of {count}: {shown}"
    first = listed[0]["values"]
    parameters = {**found.parameters, **{name: first[name] for name in varied}}
    values = Values(parameters, tuple(q[0].tolist()), tuple(v[0].tolist()))
    times = SolveDefaults(start=found.start, stop=found.start + SPAN if found.stop is None else found.stop)
    settings = Request(options=times).settings(without_times(spec), parameters)
    begun = [{"label": one["label"], "values": one["values"]} for one in listed]
    return view(Motion(spec, values, settings), stage, begun if member is None else ())


def check_member(path: Path, found: Made, member: int) -> None:
    """Raise ``UsageError`` where an output has no member of that number."""
    if found.shape is None:
        raise UsageError(f"--member {member}: {path} contains one motion, not a sweep")
    count = math.prod(found.shape.values())
    if member >= count:
        raise UsageError(f"--member {member}: the members of {path} are those from 0 to {count - 1}")


@dataclass(frozen=True)
class Member:
    """The inputs for computing one member of a sweep again: the text of the system file, sizes, and values of
    parameters and of the initial state by name; from ``start`` to ``stop``, as texts."""

    content: bytes
    sizes: Mapping[str, str]
    values: Mapping[str, str]
    times: Mapping[str, str]


def member_of(path: Path, member: int) -> Member:
    """A member of the sweep in an output, by its number from 0 on.

    Raises ``FileError`` where the file cannot be read, and ``UsageError`` where it has no such member.
    """
    import numpy as np

    from lagrange_cli.store.replay import made, members

    found = made(path)
    check_member(path, found, member)
    assert found.shape is not None
    content = found.spec.encode()
    spec, _ = read_run(content, path.name, found.sizes, lambda spec, problems: None)
    varied, q, v = members(path, found.shape, families(spec), np.array([member]))
    values = {**found.parameters, **{name: float(row[0]) for name, row in varied.items()}}
    for one, position, velocity in zip(spec.coordinates, q[0].tolist(), v[0].tolist()):
        values |= {one.name: position, velocity_name(one.name): velocity}
    ends = {"start": found.start, "stop": found.stop}
    times = {name: repr(t) for name, t in ends.items() if t is not None}
    return Member(content, found.sizes, {name: repr(x) for name, x in values.items()}, times)


def families(spec: Spec) -> list[str]:
    """The names of the datasets of coordinates."""
    given = spec.coordinate_families
    return [one.name for one in grouped((one.name for one in spec.coordinates), given)]


def without_times(spec: Spec) -> Spec:
    """The system without defaults of its own, since the output has the values of the run."""
    return replace(spec, solve=SolveDefaults())

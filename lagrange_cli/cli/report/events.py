"""The report of events: how often each has happened."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lagrange_cli.decimals import decimal
from lagrange_cli.expression.vocabulary import member_name

MOST = 4
"""Events or families of events whose counts are shown."""


def events_shown(events: Mapping[str, Any]) -> list[str]:
    """The line of the summary that says how often each event happened. Of many those that happened most are
    named, a family in one; those that never happened are not."""
    if not events:
        return []
    found = [(name, one["count"], one.get("last"), "") for name, one in events.items()]
    if len(events) > MOST:
        found = [counted(label, each) for label, each in by_family(events).items()]
        found = [one for one in found if one[1]]
        if not found:
            return ["  events: none happened"]
    found.sort(key=lambda one: -one[1])
    said = [
        f"{name} {count}{among}" + (f" (last at t = {decimal(last)})" if last is not None else "")
        for name, count, last, among in found[:MOST]
    ]
    more = len(found) - MOST
    return [f"  events: {', '.join(said)}" + (f" (and {more} more)" if more > 0 else "")]


def by_family(events: Mapping[str, Any]) -> dict[str, list[Any]]:
    """What is told of each event, by the name of its family: ``hit[i,j]``."""
    found: dict[str, list[Any]] = {}
    for name, one in events.items():
        base, _, indices = name.partition("[")
        label = member_name(base, "ijklmn"[: indices.count(",") + 1]) if indices else name
        found.setdefault(label, []).append(one)
    return found


def counted(label: str, events: list[Any]) -> tuple[str, int, float | None, str]:
    """A family of events: its name, how often they happened, the last time, and at how many of them."""
    happened = [one for one in events if one["count"]]
    last = [one["last"] for one in happened if one.get("last") is not None]
    among = f" at {len(happened)} of {len(events)} members" if len(events) > 1 else ""
    return label, sum(one["count"] for one in happened), max(last, default=None), among

"""Systems of which each quantity is made a family: several that do not act on each other."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

import yaml

BY_MEMBER = {
    "definitions", "masses", "embedding", "positions", "forces", "torques", "generalized_forces",
    "constraints", "nonholonomic",
}  # fmt: skip
SUMMED = {"potential", "lagrangian", "dissipation"}


def replicated(text: str, count: int) -> str | None:
    """The file of so many members of a system, without its observables; None if it has families already, or
    events, or is written in a way that this does not read."""
    try:
        given = yaml.load(text, yaml.BaseLoader)
    except yaml.YAMLError:
        return None
    coordinates = given["coordinates"]
    if isinstance(coordinates, list):
        coordinates = {name: {} for name in coordinates}
    if "sizes" in given or any(isinstance(one, list) for one in given.get("parameters", {}).values()):
        return None
    sections = ("definitions", "masses", "bodies", "constraints", "embedding", "positions")
    names = {*coordinates, *(name for one in sections for name in given.get(one) or ())}
    listed = "|".join(sorted(map(re.escape, names), key=len, reverse=True))
    pattern = re.compile(rf"(?<![\w.])({listed})(_dot)?(?![\w(])")

    def member(value: Any) -> Any:
        if isinstance(value, list):
            return [member(one) for one in value]
        if isinstance(value, dict):
            return {name: one if name == "sequence" else member(one) for name, one in value.items()}
        return pattern.sub(lambda found: f"{found[1]}{found[2] or ''}[i]", value)

    def family(section: Mapping[str, Any], change: Callable[[Any], Any] = member) -> dict[str, Any]:
        return {f"{name}[i in range(N)]": change(one) for name, one in section.items()}

    def body(one: Mapping[str, Any]) -> dict[str, Any]:
        return {**one, **{name: member(one[name]) for name in ("position", "orientation")}}

    def total(value: str) -> str:
        return f"sum({member(value)} for i in range(N))"

    found: dict[str, Any] = {"sizes": {"N": str(count)}, "coordinates": family(coordinates, lambda one: one)}
    for name, section in given.items():
        if name in BY_MEMBER:
            found[name] = family(section)
        elif name == "bodies":
            found[name] = family(section, body)
        elif name in SUMMED:
            whole = isinstance(section, dict)
            found[name] = {k: total(one) for k, one in section.items()} if whole else total(section)
        elif name in ("parameters", "time"):
            found[name] = section
        elif name == "solve":
            found[name] = {key: one for key, one in section.items() if key in ("start", "stop")}
        elif name == "events":
            return None
    return yaml.dump(found, sort_keys=False, width=10000)

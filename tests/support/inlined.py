"""System files with their definitions put in by hand: text for text, without the package."""

from __future__ import annotations

import re
from typing import Any

import yaml

KEY = re.compile(r"(\w+)(?:\[(.*)\])?")
NAME = re.compile(r"(?<![\w.])(\w+)(\[[^\[\]]*(?:\[[^\[\]]*\][^\[\]]*)*\])?(?:\.([xyz])\b)?")
"""A name, its indices, which may be members of lists, and the component."""


def inlined(text: str) -> str:
    """The same system without ``definitions``. A family has one piece, and as many indices as its key."""
    file = yaml.safe_load(text)
    definitions = {}
    for key, value in file.pop("definitions").items():
        name, axes = KEY.fullmatch(key).groups()  # type: ignore[union-attr]
        indices = re.findall(r"(\w+) in ", axes) if axes else []
        definitions[name] = indices, value
    for _ in definitions:  # which may contain one another
        file = replaced(file, definitions)
    return yaml.safe_dump(file, sort_keys=False, width=10**9)


def replaced(part: Any, definitions: dict[str, Any]) -> Any:
    """A part of a file, each definition replaced by what it stands for."""

    def written(found: re.Match[str]) -> str:
        name, given, component = found.groups()
        if name not in definitions:
            within = replaced(given, definitions) if given else ""
            return name + within + (f".{component}" if component else "")
        indices, value = definitions[name]
        point = component and isinstance(value, str)  # a particle, or a point of a body
        if component and not point:
            value = value["xyz".index(component)]
        value = f"({', '.join(map(str, value))})" if isinstance(value, list) else str(value)
        places = [one.strip() for one in given[1:-1].split(",")] if given else []
        for index, place in zip(indices, places, strict=True):
            value = re.sub(rf"\b{index}\b", f"({place})", value)
        return f"{value}.{component}" if point else f"({value})"

    if isinstance(part, dict):
        return {key: replaced(value, definitions) for key, value in part.items()}
    if isinstance(part, list):
        return [replaced(value, definitions) for value in part]
    return NAME.sub(written, part) if isinstance(part, str) else part

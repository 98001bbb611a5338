"""From what a page shows to the page: one file that needs nothing else.

Texts of the user are in the data alone, which scripts put into the page as text; what stands in the HTML
itself, and in the equations, is escaped. Scripts, equations and tables are packed, but for the script that
unpacks them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from typing import Any

from lagrange_cli.page.packed import packed

SCRIPTS = (
    "engine", "motion", "settling", "standstill", "happenings", "recorded", "format", "shapes", "scene",
    "chart", "graphs", "controls", "start", "player", "link", "save", "hand", "main",
)  # fmt: skip
"""The scripts, in the order in which they are joined."""
FIRST = "unpack"
"""The script that adds the others."""
STAGE, SPACE = "stage", ("three", "space")
"""Pages in space have these, too: ``SPACE`` on its own, for browsers that can show it."""
TABLES = ("coordinates", "velocities", "drawing", "engine")
"""What has an entry for each coordinate or particle: packed, as members of a family have much in common."""
TEMPLATE, STYLE = "page.html", "style.css"


def asset(name: str) -> str:
    """A file of the package."""
    return files("lagrange_cli.page").joinpath("assets").joinpath(name).read_text(encoding="utf-8")


def document(data: Mapping[str, Any], equations: str) -> str:
    """The page that shows ``data``; ``equations`` are HTML, in which all text is escaped."""
    space = data["drawing"] is not None and data["drawing"]["dimension"] == 3
    texts = {"equations": equations, "script": scripts(space)}
    if space:
        texts["space"] = joined(SPACE)
    tables = {name: packed(embedded(data[name]).encode()) for name in TABLES}
    parts = {
        "title": escape(str(data["name"])),
        "style": asset(STYLE),
        "data": embedded({**data, **{name: packed(text.encode()) for name, text in texts.items()}, **tables}),
        "script": joined([FIRST]),
    }
    page = asset(TEMPLATE)
    first, *others = page.split("{{")
    found = [first]
    for other in others:  # in one pass: inserted text is not scanned again
        name, _, rest = other.partition("}}")
        found += [parts[name], rest]
    return "".join(found)


def scripts(space: bool) -> str:
    """The scripts of a page as one."""
    *most, main = SCRIPTS
    return '"use strict";\n' + joined([*most, STAGE, main] if space else SCRIPTS)


def joined(names: Sequence[str]) -> str:
    """The scripts of these names, one after the other."""
    return "\n".join(asset(f"{name}.js") for name in names)


def embedded(data: Any) -> str:
    """JSON that may stand in a script element: no tag and no comment can begin in it."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    for letter in "<>&":
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return text

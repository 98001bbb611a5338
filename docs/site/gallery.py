"""The gallery: a page for each shipped system, with a picture, a live page, its equations, its file and what
to look at."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress

import numpy as np
from formulas import mathml

from lagrange_cli.errors import LagrangeError
from lagrange_cli.run.equations import Derived, as_page, as_written, derive
from lagrange_cli.run.motion import Motion
from lagrange_cli.run.reel import TRAIL, usual_speed
from lagrange_cli.run.request import Request
from lagrange_cli.run.shipped import names, text
from lagrange_cli.run.view.content import READING, UNREADABLE, drawn
from lagrange_cli.run.view.motion import ViewedMotion, follow, read_shown, watched
from lagrange_cli.run.view.page import page as live_page
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import Spec

PARTS = re.compile(r"\\paragraph\{(?P<title>.*?)\}\n(?P<body>.*?)(?=\\paragraph|\Z)", re.DOTALL)
ALIGNED = re.compile(r"\\begin\{align\*\}.*?\\end\{align\*\}", re.DOTALL)
ITEM = re.compile(r"\\item (.*)")
INLINE = re.compile(r"\$(.*?)\$")
REMARK = re.compile(r"\\text\{\((.*)\)\}")
"""A remark such as "(x, divided by m)" with formulas in it."""


SIZE = (720, 440)
"""Of a picture, in pixels."""
MOMENT = 0.4
"""The part of the motion after which the picture is taken."""


def pages() -> dict[str, str | bytes]:
    """The gallery's files by their path."""
    with ProcessPoolExecutor() as pool:
        begun = sorted(names(), key=lambda name: -len(text(name)))  # what takes longest is begun first
        made = dict(zip(begun, pool.map(pages_of, begun)))
    index = "# Gallery\n\nThe systems that come with `lagrange`: `lagrange systems NAME` writes one out.\n"
    index += "Each has a [page that computes](../view.md) its motion in the browser.\n\n"
    rows = [f"| [{name}]({name}.md) | {read(name).description} | {link(name, 'live')} |" for name in names()]
    index += "| system | | |\n|---|---|---|\n" + "\n".join(rows) + "\n"
    found: dict[str, str | bytes] = {"gallery/index.md": index}
    for one in made.values():
        found |= one
    return found


def read(name: str) -> Spec:
    """The system of that name."""
    return read_spec(text(name), f"{name}.yaml")


def link(name: str, shown: str) -> str:
    """A link to a live page."""
    return f"[{shown}](live/{name}.html)"


def pages_of(name: str) -> dict[str, str | bytes]:
    """The files of one system: its page in Markdown, its live page and its picture."""
    motion = watched(read_shown(text(name).encode(), f"{name}.yaml", Request()))
    spec, followed = motion.spec, follow(motion)
    derived, readable = None, f"<p>{UNREADABLE}</p>"
    with suppress(LagrangeError):
        derived = derive(spec, most=READING)
        readable = as_page(derived)
    live = live_page(motion, followed, equations=readable)
    found: dict[str, str | bytes] = {f"gallery/live/{name}.html": live.text}
    shown = link(name, f"Move it yourself: the live page of {name}" if live.live else "Its motion on a page")
    if picture := still(motion, followed):
        found[f"gallery/{name}.png"] = picture
        shown = f"{link(name, f'![{spec.name}]({name}.png){{ .system }}')}\n\n{shown}"
    commands = f"systems {name} > {name}.yaml", f"solve {name}.yaml", f"view {name}.yaml --open"
    parts = [
        f"# {spec.name[0].upper()}{spec.name[1:]}",
        spec.description or "",
        shown,
        " ".join(remarks(text(name))),
        "\n".join(["```sh", *(f"lagrange {one}" for one in commands), "```"]),
        *(() if derived is None else equations(derived)),
        "## System file",
        f"```yaml\n{text(name).rstrip()}\n```",
    ]
    return {**found, f"gallery/{name}.md": "\n\n".join(parts)}


def still(motion: Motion, followed: ViewedMotion) -> bytes:
    """A picture of the motion, PNG; empty where nothing is drawn."""
    import matplotlib.image

    from lagrange_cli.figures.scene import Scene

    drawing, t = drawn(motion, followed), followed.t
    if drawing is None or len(t) < 2:
        return b""
    last = int(MOMENT * (len(t) - 1))
    first = int(np.searchsorted(t, t[last] - TRAIL * usual_speed(t[-1] - t[0])))
    if len(t) < followed.steps:  # its trails would have corners
        first = last
    scene = Scene(drawing, motion.values.parameters, "", *SIZE)
    file = io.BytesIO()
    matplotlib.image.imsave(
        file, scene.frame(t[first : last + 1], followed.q[first : last + 1])[..., :3], format="png"
    )
    return file.getvalue()


def remarks(file: str) -> Iterator[str]:
    """The comments at the head of a system file: what to look at."""
    for line in file.splitlines():
        if line.startswith("#"):
            yield line.lstrip("# ")
        elif not line.startswith(("name:", "description:")):
            return


def equations(derived: Derived) -> Iterator[str]:
    """The parts of the equations of motion; nothing where they are too long to be read."""
    try:
        tex = as_written(derived, "latex", "lagrange", {})
    except LagrangeError:
        return
    for part in PARTS.finditer(tex):
        yield f"## {part['title']}"
        if ITEM.search(part["body"]):
            yield "\n".join(f"- {INLINE.sub(inline, escaped(item))}" for item in ITEM.findall(part["body"]))
        for formula in ALIGNED.findall(part["body"]):
            yield f'<div class="formulas">{block(formula)}</div>'


def escaped(prose: str) -> str:
    """Prose of LaTeX as that of Markdown."""
    return re.sub(r"\\([_&%#])", r"\1", prose)


def inline(found: re.Match[str]) -> str:
    """A formula within a line."""
    return mathml(found[1])


def block(formula: str) -> str:
    """Lines of formulas; remarks in them are left as they are read."""
    formula = REMARK.sub(lambda found: r"\quad[" + remark(found[1]) + "]", formula)
    return mathml(formula, block=True)


def remark(prose: str) -> str:
    """Prose with formulas as a formula with prose."""
    parts = re.split(r"\$(.*?)\$", prose)
    return "".join(part if i % 2 else rf"\text{{{part}}}" for i, part in enumerate(parts) if part)

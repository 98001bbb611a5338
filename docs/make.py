"""Write what the commands say into the pages: ``python docs/make.py``. A test fails when they differ.

``docs/cli.md`` and the manual pages in ``docs/man`` are made whole, from the commands' options. The tables of
keys, of datasets and of methods in ``docs/system-file.md``, ``docs/output-file.md`` and ``docs/methods.md``
are made from the tables of the package. In the other pages the blocks of ``sh`` and ``python`` are run in
their order, as if they were pasted, and the ``text`` block after one is what it prints.
``--renew`` renews times and step counts as well, which are otherwise kept where nothing else has changed.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from command_page import page
from manpages import pages
from sessions import RENEWED, ROOT, masked, run_sessions, run_together
from tables import with_keys, with_methods, with_outputs

PAGES = ("tutorial", "howto", "methods", "theory", "plot", "animate")
SESSIONS = (ROOT / "README.md", *(ROOT / "docs" / f"{name}.md" for name in PAGES))
METHODS = ROOT / "docs" / "methods.md"
RECIPES = ROOT / "docs" / "python.md"


def made(wanted: Callable[[str], bool] = lambda name: True) -> Iterator[tuple[Path, str]]:
    """Every page of a ``wanted`` name that is made, wholly or in part, with what it should say."""
    if wanted("cli.md"):
        yield ROOT / "docs" / "cli.md", page()
    for name, text in pages():
        if wanted(name):
            yield ROOT / "docs" / "man" / name, text
    changed: dict[Path, Callable[[str], str]] = {
        **dict.fromkeys(SESSIONS, run_sessions),
        METHODS: lambda text: run_sessions(with_methods(text)),
        RECIPES: run_together,
        ROOT / "docs" / "system-file.md": with_keys,
        ROOT / "docs" / "output-file.md": with_outputs,
    }
    for path, change in changed.items():
        if wanted(path.name):
            yield path, change(path.read_text(encoding="utf-8"))


if __name__ == "__main__":
    for path, text in made():
        if RENEWED or not path.exists() or masked(path.read_text(encoding="utf-8")) != masked(text):
            path.write_text(text, encoding="utf-8")

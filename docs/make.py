"""Write what the commands say into the pages: ``python docs/make.py``. A test fails when they differ.

``docs/cli.md`` and the manual pages in ``docs/man`` are made whole, from the commands' options. The tables of
keys, of datasets and of methods in ``docs/system-file.md``, ``docs/output-file.md`` and ``docs/methods.md``
are made from the tables of the package. In the other pages the blocks of ``sh`` and ``python`` are run in
their order, as if they were pasted, and the ``text`` block after one is what it prints.
``--renew`` renews times and step counts as well, which are otherwise kept where nothing else has changed.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from command_page import page
from manpages import pages
from sessions import RENEWED, ROOT, masked, run_sessions, run_together
from tables import with_keys, with_methods, with_outputs

PAGES = ("tutorial", "howto", "methods", "theory", "plot", "animate")
SESSIONS = (ROOT / "README.md", *(ROOT / "docs" / f"{name}.md" for name in PAGES))
RECIPES = ROOT / "docs" / "python.md"


def made() -> Iterator[tuple[Path, str]]:
    """Every page that is made, wholly or in part, with what it should say."""
    yield ROOT / "docs" / "cli.md", page()
    for name, text in pages():
        yield ROOT / "docs" / "man" / name, text
    for path in SESSIONS:
        text = path.read_text(encoding="utf-8")
        yield path, run_sessions(with_methods(text) if path.name == "methods.md" else text)
    yield RECIPES, run_together(RECIPES.read_text(encoding="utf-8"))
    for name, made_in in (("system-file.md", with_keys), ("output-file.md", with_outputs)):
        path = ROOT / "docs" / name
        yield path, made_in(path.read_text(encoding="utf-8"))


if __name__ == "__main__":
    for path, text in made():
        if RENEWED or not path.exists() or masked(path.read_text(encoding="utf-8")) != masked(text):
            path.write_text(text, encoding="utf-8")

"""What the manual's site has besides the pages of docs/: README as its front page, the changelog, the
gallery, and formulas as MathML, which browsers draw by themselves."""

from __future__ import annotations

import html
import re
import sys
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "docs" / "site"), str(ROOT)]
from formulas import mathml  # noqa: E402  (these two lie beside this file)
from gallery import pages  # noqa: E402

FORMULA = re.compile(
    r'<(?P<tag>span|div) class="arithmatex">\\(?P<open>[(\[])(?P<tex>.*?)\\[)\]]</(?P=tag)>', re.DOTALL
)
"""As the extension ``arithmatex`` leaves it."""
CSS = """\
math[display="block"] { margin: 1em 0; overflow-x: auto; }
math mtd { text-align: left; padding-left: 0.2em; }
math mtd:first-child { text-align: right; }
.md-typeset .system { display: block; margin: 1em auto; max-width: 32rem; width: 100%; }
.md-typeset .formulas { overflow-x: auto; }
"""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add what does not lie in docs/."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    contributing = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    made: dict[str, str | bytes] = {
        "index.md": within(readme),
        "contributing.md": within(contributing),
        "changelog.md": changelog.replace("](docs/", "]("),
        "assets/manual.css": CSS,
        **pages(),
    }
    for name, content in made.items():
        files.append(File.generated(config, name, content=content))
    return files


def within(text: str) -> str:
    """A page of the root with links that hold in the site; files that are no pages are named."""
    text = re.sub(r"\[([^]]*)\]\((LICENSE|CITATION\.cff)\)", r"\1 (`\2`)", text)
    pages = {"](docs/": "](", "](CHANGELOG.md": "](changelog.md", "](CONTRIBUTING.md": "](contributing.md"}
    for link, page in pages.items():
        text = text.replace(link, page)
    return text


def on_page_markdown(markdown: str, **others: Any) -> str:
    """Links to README and the changelog lead to their pages of the site."""
    return markdown.replace("](../README.md", "](index.md").replace("](../CHANGELOG.md", "](changelog.md")


def on_page_content(content: str, **others: Any) -> str:
    """Formulas in LaTeX become MathML."""
    return FORMULA.sub(lambda found: mathml(html.unescape(found["tex"]), found["open"] == "["), content)

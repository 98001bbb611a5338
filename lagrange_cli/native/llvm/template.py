"""IR that does not depend on the system, kept in ``.ll`` files beside this one, with @@names@@ to fill in."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path


def fill_in(name: str, values: Mapping[str, object]) -> str:
    """The text of ``name.ll`` with every ``@@key@@`` replaced by its value."""
    text = Path(__file__).with_name(f"{name}.ll").read_text(encoding="ascii")
    for key, value in values.items():
        text = text.replace(f"@@{key}@@", str(value))
    return text

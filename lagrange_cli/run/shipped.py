"""The systems that come with the package: where they are and what each one is."""

from __future__ import annotations

from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent


def folder() -> Path:
    """The folder of the shipped systems: inside the installed package, or beside it in a checkout."""
    installed = PACKAGE / "systems_data"
    return installed if installed.is_dir() else PACKAGE.parent / "systems"


def names() -> list[str]:
    """The names of the shipped systems, in alphabetical order."""
    return sorted(path.stem for path in folder().glob("*.yaml"))


def text(name: str) -> str:
    """The system file of that name."""
    return (folder() / f"{name}.yaml").read_text(encoding="utf-8")


def summary(name: str) -> str:
    """The one line that says what the system is: its ``description``, else its first comment.

    Read as plain text: a list of the systems is not worth importing a YAML parser.
    """
    lines = text(name).splitlines()
    described = [line.partition(":")[2] for line in lines if line.startswith("description:")]
    comments = [line.lstrip("#") for line in lines if line.startswith("#")]
    return next(iter(described + comments), "").strip().strip("\"'")

"""Stand-in for ``pip`` in the blocks of README: installs nothing, and fails where a package is missing."""

import sys
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PROJECT = tomllib.loads((Path(__file__).resolve().parent.parent / "pyproject.toml").read_text())["project"]


def requirements(asked: str) -> list[str]:
    """What ``.[plot,xarray]`` stands for; anything else stands for itself."""
    if not asked.startswith("."):
        return [asked]
    extras = [name for name in asked[1:].strip("[]").split(",") if name]
    return [
        *PROJECT["dependencies"],
        *(each for name in extras for each in PROJECT["optional-dependencies"][name]),
    ]


for argument in sys.argv[2:]:
    if not argument.startswith("-"):
        for each in map(Requirement, requirements(argument)):
            assert each.specifier.contains(metadata.version(each.name)), f"{each} is not installed"

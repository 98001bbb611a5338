"""The other things that compiled code depends on: this package's code, LLVM, Python and the processor.

LLVM's library is not loaded for this: loading takes longer than the rest of a short run.
"""

from __future__ import annotations

import os
import sys
from functools import cache
from importlib import import_module

STAGES = (
    "expression", "spec", "model", "series", "mechanics", "families", "native", "outputs", "integrate",
)  # fmt: skip
"""The packages that compiled code depends on."""
PROCESSOR = (
    "vendor_id", "cpu family", "model", "model name", "stepping", "flags",
    "CPU implementer", "CPU architecture", "CPU variant", "CPU part", "CPU revision", "Features",
)  # fmt: skip
"""The lines of Linux's /proc/cpuinfo that identify the processor and its instruction sets."""
ABILITIES = frozenset({"flags", "Features"})
FIRST_PROCESSOR = 16384
"""Bytes that hold the lines about the first processor, however many there are."""


@cache
def fingerprint() -> dict[str, object]:
    """All of it, as JSON data. Raises ``OSError`` if a file's status cannot be read.

    A process looks once: what changes later is not the code that it has in memory.
    """
    import llvmlite

    package = import_module(__name__.partition(".")[0])
    here = os.path.dirname(os.path.abspath(str(package.__file__)))
    library = os.path.join(os.path.dirname(os.path.abspath(llvmlite.__file__)), "binding")
    return {
        "version": package.__version__,
        "code": [files(os.path.join(here, stage)) for stage in STAGES],
        "llvm": [llvmlite.__version__, files(library)],
        "python": [sys.implementation.cache_tag, sys.platform, sys.maxsize],
        "processor": processor(),
    }


def machine() -> list[object]:
    """Everything besides the version on which the last bits of a result depend, as JSON data."""
    import llvmlite

    return [llvmlite.__version__, *processor()]


def files(folder: str) -> list[list[object]]:
    """Name, size and modification time of each file."""
    found: list[list[object]] = []
    with os.scandir(folder) as entries:
        for entry in sorted(entries, key=lambda entry: entry.name):
            if entry.is_file():
                status = entry.stat()
                found.append([entry.name, status.st_size, status.st_mtime_ns])
            elif entry.name != "__pycache__":
                found += files(entry.path)
    return found


def processor() -> list[str]:
    """The processor and its instruction sets, as Linux describes them, or LLVM on other systems."""
    lines = described()
    if any(line.partition(":")[0].rstrip() in ABILITIES for line in lines):
        return lines
    from lagrange_cli.native.compilation.llvm import features, processor_name

    return [processor_name(), features()]


def described() -> list[str]:
    """Those lines for the first processor, or none."""
    try:
        with open("/proc/cpuinfo", "rb") as file:
            text = file.read(FIRST_PROCESSOR).decode("utf-8", "replace")
    except OSError:
        return []
    first = text.partition("\n\n")[0].splitlines()
    return [line for line in first if line.partition(":")[0].rstrip() in PROCESSOR]

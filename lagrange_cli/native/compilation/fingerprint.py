"""What compiled code depends on besides its program: this code, LLVM, Python and the processor.

It is found out without loading LLVM's library, which would take longer than all the rest of a short run.
"""

from __future__ import annotations

import os
import sys
from importlib import import_module

STAGES = ("expression", "spec", "model", "series", "mechanics", "native", "outputs", "integrate")
"""The parts of this package that have a say in what is compiled."""
PROCESSOR = (
    "vendor_id", "cpu family", "model", "model name", "stepping", "flags",
    "CPU implementer", "CPU architecture", "CPU variant", "CPU part", "CPU revision", "Features",
)  # fmt: skip
"""The lines of Linux's /proc/cpuinfo that say which processor it is and what it can do."""
ABILITIES = frozenset({"flags", "Features"})
FIRST_PROCESSOR = 16384
"""Bytes that hold the lines about the first processor, however many there are."""


def identity() -> dict[str, object]:
    """All of it in terms of JSON; raises ``OSError`` where files that it is made of cannot be examined."""
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
    """What the last bits of a result depend on besides the version, in terms of JSON."""
    import llvmlite

    return [llvmlite.__version__, *processor()]


def files(folder: str) -> list[list[object]]:
    """Name, size and time of change of each file: an edit or another version makes them differ."""
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
    """Which processor this is and what it can do: in Linux's words, elsewhere in LLVM's."""
    lines = described()
    if any(line.partition(":")[0].rstrip() in ABILITIES for line in lines):
        return lines
    from lagrange_cli.native.compilation.llvm import features, processor_name

    return [processor_name(), features()]


def described() -> list[str]:
    """The lines about the first processor that matter, or none."""
    try:
        with open("/proc/cpuinfo", "rb") as file:
            text = file.read(FIRST_PROCESSOR).decode("utf-8", "replace")
    except OSError:
        return []
    first = text.partition("\n\n")[0].splitlines()
    return [line for line in first if line.partition(":")[0].rstrip() in PROCESSOR]

"""Digests of the datasets that portable runs write, for a test that runs this elsewhere, in another process.

``python -m tests.cli.portable_digests FOLDER CPU FEATURES SYSTEM.yaml ..`` with what LLVM calls the processor
to compile for (``here`` for the one that there is) prints a JSON object of them in its last line.
"""

import hashlib
import json
import sys
from pathlib import Path

import h5py

from lagrange_cli.cli.main import main
from lagrange_cli.native import compiler


def digests(folder: Path, system: str, *options: str) -> dict[str, str]:
    """By path, all that the datasets of a portable run hold."""
    output = str(folder / "out.h5")
    run = ["solve", system, "--portable", "--no-cache", "--force", "--json", "-o", output]
    code = main([*run, "--samples", "20", "--outputs", "all", *options])
    assert code in (0, 4), code
    found = {}
    with h5py.File(output) as file:

        def note(path: str, item: object) -> None:
            if isinstance(item, h5py.Dataset) and item.dtype.kind == "f":
                found[path] = hashlib.sha256(item[()].tobytes()).hexdigest()

        file.visititems(note)
        return {**found, "parameters": file.attrs["parameters"], "steps": int(file.attrs["steps"])}


def all_digests(folder: Path, cpu: str, features: str, systems: list[str]) -> dict[str, dict[str, str]]:
    """Those of several systems, compiled for a kind of processor."""
    if cpu != "here":
        compiler.processor_name = lambda: cpu
        compiler.features = lambda: features
    return {system: digests(folder, *system.split()) for system in systems}


if __name__ == "__main__":
    folder, cpu, features, *systems = sys.argv[1:]
    print(json.dumps(all_digests(Path(folder), cpu, features, systems)))

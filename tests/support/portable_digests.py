"""Digests of the datasets that portable runs write, for a test that runs this elsewhere, in another process.

``python -m tests.support.portable_digests FOLDER CPU FEATURES SYSTEM.yaml ..`` with LLVM's name of the
processor to compile for (``here`` for the present one) prints a JSON object of them in its last line. Without
systems, it takes all that there are.
"""

import hashlib
import json
import os
import sys
from pathlib import Path

import h5py

from lagrange_cli.cli.main import main
from lagrange_cli.native.compilation import llvm as compiler
from tests.support.command import SYSTEMS

FUNCTIONS = """
parameters: {a: sin(0.3), b: 2**0.3, c: pi*tanh(1.7)}
coordinates:
  x: {initial: "atan2(a, 2)", velocity: exp(0.1)}
  y: {initial: asin(0.3), velocity: log(1.7)}
lagrangian: >
  x_dot**2/2 + y_dot**2/2 + cosh(0.1*y)*x_dot*y_dot/3 - tan(0.1*x)*sinh(0.1*x) - (2+cos(x))**a
  - exp(-x**2/8)*b - tanh(x*y)*atan(y) - acos(0.1*sin(x)) - log(3+x**2)**c - (x**2 + y**2)**1.3
  + atan2(y + 5, x**2 + 1)*sqrt(2.0)**0.7 - cosh(x/2) + asin(0.2*cos(y)) - sin(1.1)*x*exp(0.7)
observables: {far: sin(1e15*x), power: (3+x)**(y+0.1), steep: exp(800*sin(x) + 700)}
solve: {stop: 1}
"""
SHORT = {
    "solar_system": "--stop 200", "fpu_chain": "--stop 20", "foucault_gyroscope": "--stop 0.5",
    "kovalevskaya_top": "--stop 1", "lagrange_top": "--stop 0.5", "double_pendulum": "--stop 10",
    "newtons_cradle": "--stop 0.2256",
}  # fmt: skip
"""Motions that would take long with an fma in software."""


def functions(folder: Path) -> list[str]:
    """One that has every function, in either precision."""
    written = folder / "functions.yaml"
    written.write_text(FUNCTIONS, encoding="utf-8")
    return [str(written), f"{written} --precision double-double"]


def shipped(name: str) -> str:
    """One that comes with the program, with its options."""
    return f"{SYSTEMS / name}.yaml {SHORT.get(name, '')}".strip()


def all_systems(folder: Path) -> list[str]:
    """Every one of these."""
    return [*functions(folder), *(shipped(path.stem) for path in sorted(SYSTEMS.glob("*.yaml")))]


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
    place = Path(folder)
    print(json.dumps(all_digests(place, cpu, features, systems or all_systems(place))), flush=True)
    os._exit(0)  # as the command does: better code may still be compiling

"""Digests of the object code of all shipped systems, to tell whether a change of this package changes it:

    python -m benchmarks.tools.object_code --write before.json
    python -m benchmarks.tools.object_code --compare before.json

LLVM compiles for a fixed processor, so that the digests do not depend on the machine. Names of functions
do not enter them. A program whose text is that of the compared file is not compiled again. ``--root`` takes
another checkout's package: everything goes through the command line, which all versions have in common.

One line for each program has the system, the kind of program, its outputs, LLVM's level of code generation,
the bytes of code and constants, the number of floating-point instructions in the program's text (those on
vectors count once), the milliseconds of processor time from reading the system to its text, and the digest.
The exit status is 1 if a program differs from that of the compared file.
"""

from __future__ import annotations

import argparse
import io
import json
import re
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import asdict, dataclass
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding as llvm

from benchmarks.tools.elf import examined

ROOT = Path(__file__).resolve().parents[2]
PROCESSOR, FEATURES = "x86-64-v4", "+avx512f,+fma,+avx2"
LEVELS = (0, 3)
ALL, STATES = "all", "q,v"
KINDS: Mapping[str, tuple[str, ...]] = {
    "double": (),
    "lanes": (),
    "double-double": ("--precision", "double-double"),
    "portable": ("--portable",),
    "backward": (),
    "rates": ("--method", "DOP853"),
    "jacobian": ("--method", "Radau"),
}
"""Options by kind of program."""
ALSO = {
    "narrow_force": """
coordinates: {x: {initial: -1, velocity: 2}, y: {initial: 1}}
lagrangian: (x_dot**2 + y_dot**2)/2 - exp(-(10*x)**2)/4 - tanh(10*(x - y)) - (x**2 + y**2)/2
""",
    "indefinite_mass_matrix": """
coordinates: {x: {initial: 1}, y: {initial: 0.5}}
lagrangian: x_dot*y_dot*(2 + cos(x)) - x**2/2 - x*y
""",
    "general_ring": """
sizes: {N: 7}
coordinates: {"u[i in range(N)]": {initial: 0.1*i}}
lagrangian: "sum(u_dot[i]*u_dot[(i + 1) % N]*(2 + cos(u[i])) - u[i]**2/2 for i in range(N))"
""",
}
"""Systems for what no shipped one has: hidden forces, and mass matrices that are not positive definite."""
LARGER = (("n_pendulum", "N=13"), ("n_pendulum", "N=40"), ("lattice", "M=20"))
"""Shipped systems, larger: with code in loops, and with mass matrices in blocks."""
FIRST_COORDINATE = re.compile(r"^coordinates:\s*{?\s*\"?(\w+)(?:\[([^\]]*)\])?", re.MULTILINE)


class Written(BaseException):
    """Raised in place of compiling: the text of a program."""


class NotWritten(Exception):
    """The command failed."""


@dataclass(frozen=True)
class Case:
    """What is compiled: a system file with a size, the kind of program, and its outputs."""

    file: Path
    size: str
    kind: str
    outputs: str

    @property
    def name(self) -> str:
        """For people."""
        return " ".join(part for part in (self.file.stem, self.size, self.kind, self.outputs) if part)

    @property
    def arguments(self) -> list[str]:
        """Of the command line."""
        made = ["sweep" if self.kind == "lanes" else "solve", str(self.file), "--no-cache"]
        made += [*KINDS[self.kind], "--outputs", self.outputs, "--samples", "2"]
        made += ["--stop", "-1" if self.kind == "backward" else "1"]
        made += ["--size", self.size] if self.size else []
        if self.kind == "lanes":
            found = FIRST_COORDINATE.search(self.file.read_text(encoding="utf-8"))
            assert found is not None, self.file
            name, indices = found.groups()
            member = f"[{','.join('0' for _ in indices.split(','))}]" if indices else ""
            made += ["--over", f"{name}{member}=0.1,0.2"]
        return made


@dataclass(frozen=True)
class Code:
    """A program's code: digests of its text and of what it is compiled to, and of each function by name."""

    text: str
    operations: int
    bytes: int
    digest: str
    functions: Mapping[str, tuple[int, str]]


def cases(files: Sequence[Path], kinds: Sequence[str]) -> Iterator[Case]:
    """Every kind of program of every system, the larger ones for doubles only."""
    for file in files:
        for kind in kinds:
            for outputs in (STATES, ALL):
                yield Case(file, "", kind, outputs)
    for file in files if "double" in kinds else ():
        for name, size in LARGER:
            if file.stem == name:
                yield Case(file, size, "double", STATES)


def main() -> int:
    """Compile, print, write and compare."""
    made = argparse.ArgumentParser(
        prog="python -m benchmarks.tools.object_code",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    made.add_argument("--root", type=Path, default=ROOT, help="the checkout whose package is used [this one]")
    made.add_argument("--systems", nargs="+", metavar="NAME", help="only these systems [all]")
    made.add_argument("--kinds", nargs="+", choices=KINDS, metavar="KIND", help=f"only these of {[*KINDS]}")
    made.add_argument("--write", type=Path, metavar="FILE", help="write the digests to a file, as JSON")
    made.add_argument("--compare", type=Path, metavar="FILE", help="compare with a file of --write")
    options = made.parse_args()
    sys.path.insert(0, str(options.root.resolve()))
    before = json.loads(options.compare.read_text(encoding="utf-8")) if options.compare else {}
    compiled = compiled_before(before)
    found: dict[str, Code] = {}
    seconds: dict[str, float] = {}
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, text in ALSO.items():
            Path(folder, f"{name}.yaml").write_text(text, encoding="utf-8")
        files = [*sorted((ROOT / "systems").glob("*.yaml")), *sorted(Path(folder).glob("*.yaml"))]
        chosen = [file for file in files if not options.systems or file.stem in options.systems]
        kinds = [kind for kind in KINDS if not options.kinds or kind in options.kinds]
        for kind in kinds:  # what is imported now is not measured
            with suppress(NotWritten):
                program_text(Case(ROOT / "systems" / "pendulum.yaml", "", kind, STATES), folder)
        for case in cases(chosen, kinds):
            try:
                text, seconds[case.name] = program_text(case, folder)
            except NotWritten as error:
                print(f"{case.name}: {error}", flush=True)
                failed += 1
                continue
            for level in LEVELS:
                name, key = f"{case.name} {level}", (digest(text), level)
                code = found[name] = compiled[key] = compiled.get(key) or code_of(text, level)
                print(
                    f"{name:56} {code.bytes:8} bytes {code.operations:7} operations "
                    f"{1e3 * seconds[case.name]:7.1f} ms {code.digest[:16]}",
                    flush=True,
                )
    print(f"{len(found)} programs, texts written in {sum(seconds.values()):.1f} s")
    if options.write:
        data = {
            "made by": made_by(),
            "seconds": seconds,
            "programs": {name: asdict(code) for name, code in found.items()},
        }
        options.write.write_text(json.dumps(data, indent=1), encoding="utf-8")
    if options.compare:
        asked = {name for name in before["programs"] if name.rpartition(" ")[0] in seconds}
        failed += compared({name: read_code(before["programs"][name]) for name in asked}, found)
        both = seconds.keys() & before["seconds"].keys()
        took = [sum(each[name] for name in both) for each in (before["seconds"], seconds)]
        print(f"texts written in {took[1]:.2f} s, before in {took[0]:.2f} s")
    return 1 if failed else 0


def program_text(case: Case, folder: str) -> tuple[str, float]:
    """The LLVM IR that the command writes for a case, and the seconds until it is written.

    Raises ``NotWritten`` with what the command says, if it fails.
    """
    command = import_module("lagrange_cli.cli.main").main
    said = io.StringIO()
    with tempfile.TemporaryDirectory(dir=folder) as place:
        arguments = [*case.arguments, "--output", str(Path(place, "out.h5"))]
        began = time.process_time()
        try:
            with intercepted(), redirect_stdout(said), redirect_stderr(said):
                command(arguments)
        except Written as written:
            text: str = written.args[0]
            return text, time.process_time() - began
    raise NotWritten(said.getvalue().strip())


class intercepted:
    """A context in which LLVM says that it runs on the fixed processor, and raises ``Written`` for a text."""

    def __enter__(self) -> None:
        self._kept = {name: getattr(llvm, name) for name in ("parse_assembly", "get_host_cpu_features")}

        def written(text: str, *_: object) -> None:
            raise Written(text)

        class Features:
            def flatten(self) -> str:
                return FEATURES

        llvm.parse_assembly, llvm.get_host_cpu_features = written, Features

    def __exit__(self, *_: object) -> None:
        for name, function in self._kept.items():
            setattr(llvm, name, function)


def code_of(text: str, level: int) -> Code:
    """A program, compiled."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple("x86_64-unknown-linux-gnu")
    machine = target.create_target_machine(cpu=PROCESSOR, features=FEATURES, opt=level, jit=True)
    size, whole, functions = examined(machine.emit_object(llvm.parse_assembly(text)))
    return Code(digest(text), operations(text), size, whole, functions)


def operations(text: str) -> int:
    """Floating-point instructions of LLVM IR."""
    return len(re.findall(r"= (?:f(?:add|sub|mul|div|neg) |(?:tail )?call [^@\n]*double[^@\n]*@llvm)", text))


def digest(text: str | bytes) -> str:
    """SHA-256."""
    return sha256(text.encode() if isinstance(text, str) else text).hexdigest()


def made_by() -> list[Any]:
    """What digests depend on besides the programs."""
    return [llvmlite.__version__, list(llvm.llvm_version_info), PROCESSOR, FEATURES]


def read_code(data: Mapping[str, Any]) -> Code:
    """A program as it was written to a file."""
    functions = {name: (size, found) for name, (size, found) in data["functions"].items()}
    return Code(**{**data, "functions": functions})


def compiled_before(before: Mapping[str, Any]) -> dict[tuple[str, int], Code]:
    """The programs of a file by the digest of their text and the level, if they were compiled alike."""
    if before.get("made by") != made_by():
        return {}
    every = ((int(name.rpartition(" ")[2]), read_code(data)) for name, data in before["programs"].items())
    return {(code.text, level): code for level, code in every}


def compared(before: Mapping[str, Code], after: Mapping[str, Code]) -> int:
    """Print what differs; how many programs do."""
    differing = 0
    for name in sorted(before.keys() | after.keys()):
        if name not in before or name not in after:
            differing += 1
            print(f"{name}: only {'before' if name in before else 'now'}")
            continue
        one, other = before[name], after[name]
        if one.digest == other.digest:
            continue
        differing += 1
        changed = [
            f"{each} {one.functions.get(each, (0, ''))[0]} -> {other.functions.get(each, (0, ''))[0]}"
            for each in sorted(one.functions.keys() | other.functions.keys())
            if one.functions.get(each) != other.functions.get(each)
        ]
        same = sorted(one.functions.values()) == sorted(other.functions.values())
        print(
            f"{name}: {one.bytes} -> {other.bytes} bytes ({other.bytes - one.bytes:+}), "
            f"{one.operations} -> {other.operations} operations; "
            + ("the same functions, in another order or under other names" if same else ", ".join(changed))
        )
    print(f"{differing} of {len(before.keys() | after.keys())} programs differ")
    return differing


if __name__ == "__main__":
    sys.exit(main())

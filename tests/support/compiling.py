"""How LLVM compiles programs within the tests' own processes: quickly, and each text once."""

from __future__ import annotations

import os
from hashlib import sha256
from pathlib import Path
from threading import get_ident

from lagrange_cli.native.compilation import llvm, machine


def begin_quickly() -> None:
    """Small programs begin with quickly compiled code, as large ones do: it takes a third of the time.

    Both levels give the same bits (``tests/integrate/methods/test_recompilation.py``), and better code takes
    over in runs that last. Commands that are processes of their own choose the level as they do for users.
    To be called before what uses ``first_level`` is imported.
    """
    machine.first_level = lambda program: machine.QUICK


def compile_once(folder: Path) -> None:
    """A text is compiled for a processor and a level once; ``folder`` has what it was compiled to.

    The folder may be shared by processes: what two of them write at the same time are the same bytes.
    """
    compile_text = llvm.compile_text

    def remembered(text: str, optimize: int) -> bytes:
        made_for = f"{llvm.processor_name()} {llvm.features()} {optimize} {compiled_from(text)}"
        path = folder / sha256(made_for.encode()).hexdigest()
        if path.exists():
            return path.read_bytes()
        code = compile_text(text, optimize)
        folder.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_suffix(f".{os.getpid()}.{get_ident()}")
        unfinished.write_bytes(code)
        unfinished.replace(path)
        return code

    def compiled_from(text: str) -> str:
        return sha256(llvm.suited(text).encode()).hexdigest()

    llvm.compile_text = remembered

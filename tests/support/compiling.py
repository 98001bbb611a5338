"""How LLVM compiles programs within the tests' own processes: quickly, and each text once."""

from __future__ import annotations

from hashlib import sha256

from lagrange_cli.native.compilation import llvm, machine

LASTING = 0.5
"""Seconds that a run takes before better code is compiled for it: few runs of tests do."""


def begin_quickly() -> None:
    """Small programs begin with quickly compiled code, as large ones do: it takes a third of the time.

    Both levels give the same bits (``tests/integrate/methods/test_recompilation.py``), and better code takes
    over in runs that last. Commands that are processes of their own choose the level as they do for users.
    To be called before what uses ``first_level`` is imported.
    """
    machine.first_level = lambda program: machine.QUICK
    from lagrange_cli.integrate.methods import compiled  # not before: what it imports uses first_level

    compiled.PATIENCE = LASTING


def compile_once() -> None:
    """A text is compiled once for a processor and a level."""
    compile_text, known = llvm.compile_text, dict[bytes, bytes]()

    def remembered(text: str, optimize: int, loops: bool = False) -> bytes:
        made_for = f"{llvm.processor_name()} {llvm.features()} {optimize} {loops} {llvm.suited(text)}"
        key = sha256(made_for.encode()).digest()
        if key not in known:
            known[key] = compile_text(text, optimize, loops)
        return known[key]

    llvm.compile_text = remembered

"""Machine code from a program, and its functions as callables."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from lagrange_cli.native.compilation.object_loader import Unsupported, load_image
from lagrange_cli.native.compilation.stack import with_stack
from lagrange_cli.native.interface import STEPPING, Interface
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.native.program import Program

QUICK, FULL = 0, 1
"""LLVM's levels of code generation: the first compiles up to ten times faster, the code of the second runs up
to twice as fast, and loops over members of families up to five times. Both give the same bits."""
LARGE = 400_000
"""Characters of a program above which ``FULL`` is not chosen at once (0.2 s of compilation)."""
LARGE_LOOPS = 1_000_000
"""The same for loops over members of families, whose time is that of their members."""
LARGE_RATES = 3_000_000
"""The same for programs without series."""
LARGEST_IMPROVED = 6_000_000
"""Bytes of ``QUICK`` code above which ``FULL`` code is never made: compiling takes minutes and gigabytes."""
STACK_PER_BYTE = 4
"""Bytes of stack for one of instructions: to compute and store a vector of 64 bytes takes at least 16."""
SMALL = 2**20
"""Bytes of instructions that run on the caller's stack: a call with another one starts a thread."""
COMPILER_STACK = 2**28


class LoadedCode(Protocol):
    """Code in memory, for as long as this object lives."""

    def address(self, function: str) -> int:
        """Where a function is, 0 if there is none of that name."""
        ...

    @property
    def instructions(self) -> int:
        """The bytes of instructions, at most: without tables, where these are known."""
        ...


@dataclass(frozen=True)
class Machine:
    """A compiled program: its functions as callables over addresses; ``loaded`` keeps the code alive."""

    program: Interface
    loaded: LoadedCode
    prepare: Callable[..., None]
    observe: Callable[..., None]
    linearize: Callable[..., None] | None
    act: Callable[..., None] | None
    speeds: Callable[..., None] | None
    project: Callable[..., None] | None
    constrain: Callable[..., None] | None
    push: Callable[..., int] | None
    advance: Callable[..., int] | None
    accelerate: Callable[..., int]
    follow: Callable[..., None] | None
    help: Callable[..., int] | None


def first_level(program: Program) -> int:
    """The level to compile ``program`` with first, however long the run is."""
    return QUICK if len(program.text) - program.tables > largest(program) else FULL


def largest(program: Program) -> int:
    """The characters of a program of this kind above which ``FULL`` is not chosen at once."""
    return LARGE_RATES if program.order < STEPPING else LARGE_LOOPS if program.loops else LARGE


def worth_improving(code: bytes) -> bool:
    """Whether a ``QUICK`` program is small enough to be compiled again with ``FULL``."""
    return len(code) <= LARGEST_IMPROVED


def compile_program(program: Program, optimize: int = FULL) -> Machine:
    """Compile ``program`` for this processor and load it."""
    return load_machine(compile_object(program, optimize), program)


def compile_object(program: Program, optimize: int = FULL) -> bytes:
    """The object code of ``program`` for this processor; raises ``MemoryError`` where memory is limited, and
    too little."""
    from lagrange_cli.native.compilation.apart import compile_apart, limited
    from lagrange_cli.native.compilation.blocks import with_short_blocks
    from lagrange_cli.native.compilation.llvm import compile_text

    text = with_short_blocks(program.text) if optimize == QUICK else program.text
    if len(text) <= LARGE:
        return compile_text(text, optimize, program.loops)
    if limited():
        return compile_apart(text, optimize, COMPILER_STACK, program.loops)
    return with_stack(compile_text, COMPILER_STACK)(text, optimize, program.loops)


def load_machine(code: bytes, program: Interface) -> Machine:
    """Object code of ``compile_object`` in memory."""
    loaded = load(code)
    pointer, integer, real = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double

    def function(name: str, result: Any, *arguments: Any) -> Any:
        address = loaded.address(name)
        if not address:
            return None
        found = ctypes.CFUNCTYPE(result, *arguments)(address)
        size = loaded.instructions
        return with_stack(found, STACK_PER_BYTE * size) if size > SMALL else found

    at_samples = (*[pointer] * 4, integer, integer)
    advance = (*[pointer] * 4, real, pointer, integer, pointer, integer, integer, integer, pointer)
    follow = (*[pointer] * 4, real, real, pointer, integer, pointer, pointer, pointer, integer)
    return Machine(
        program=program,
        loaded=loaded,
        prepare=function("prepare", None, pointer, pointer),
        observe=function("observe", None, *at_samples),
        linearize=function("linearize", None, *at_samples),
        act=function("act", None, *at_samples),
        speeds=function("speeds", None, *at_samples),
        project=function("project", None, pointer, pointer),
        constrain=function("constrain", None, *at_samples),
        push=function("push", integer, *[pointer] * 4, integer),
        advance=function("advance", integer, *advance),
        accelerate=function("accelerate", integer, pointer, real, pointer, pointer, pointer),
        follow=function("follow", None, *follow) if program.lanes else None,
        help=function("help", integer, pointer) if program.strips else None,
    )


def load(code: bytes) -> LoadedCode:
    """Object code in memory: by this package's loader where it can, else by LLVM."""
    try:
        return load_image(code)
    except Unsupported:
        from lagrange_cli.native.compilation.llvm import load_with_llvm

        return load_with_llvm(code)

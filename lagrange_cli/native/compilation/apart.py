"""Compilation in a process of its own, where memory is limited: LLVM ends its process when it gets none."""

from __future__ import annotations

import json
import subprocess
import sys

COMMAND = """
import json, signal, sys
signal.signal(signal.SIGINT, signal.SIG_DFL)
sys.path[:] = json.loads(sys.argv[1])
from lagrange_cli.native.compilation.apart import serve
serve(*map(int, sys.argv[2:]))
"""


def limited() -> bool:
    """Whether the memory of this process is limited, by ``ulimit`` or ``LAGRANGE_LIMITS``."""
    try:
        import resource
    except ImportError:  # Windows has none
        return False
    return resource.getrlimit(resource.RLIMIT_AS)[0] != resource.RLIM_INFINITY and bool(sys.executable)


def compile_apart(text: str, optimize: int, stack: int, loops: bool) -> bytes:
    """The object code of LLVM IR, compiled with so many bytes of stack; raises ``MemoryError``."""
    numbers = (f"{int(one)}" for one in (optimize, stack, loops))
    command = [sys.executable, "-I", "-c", COMMAND, json.dumps(sys.path), *numbers]
    done = subprocess.run(command, input=text.encode(), capture_output=True, check=False)
    if done.returncode or not done.stdout:
        raise MemoryError("compilation")
    return done.stdout


def serve(optimize: int, stack: int, loops: int) -> None:
    """Compile what standard input has, to standard output."""
    from lagrange_cli.native.compilation.llvm import compile_text
    from lagrange_cli.native.compilation.stack import with_stack

    text = sys.stdin.buffer.read().decode()
    sys.stdout.buffer.write(with_stack(compile_text, stack)(text, optimize, bool(loops)))

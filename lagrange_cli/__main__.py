"""The command ``lagrange``, and ``python -m lagrange_cli``.

Up to ``run``, Ctrl-C is Python's own and shows a traceback. So nothing is imported before it that takes time:
of ``signal`` only its compiled part, which the interpreter has loaded already.
"""

import _signal  # type: ignore[import-not-found]

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn


def run() -> "NoReturn":
    """Run the command line, and exit.

    While it is loaded, Ctrl-C ends the process as it does any other, and not with a traceback of what was
    loading.
    """
    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
    import gc
    import os

    # Matrices are small here: a thread for each core costs more to start than it would save, and with one
    # thread sums do not depend on the number of cores. numpy's BLAS reads this when it is loaded.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Modules and graphs are many objects that stay (100,000 in sympy alone): to look through them for garbage
    # less often than every 700 saves 4 to 7 % of a short command.
    gc.set_threshold(200_000)
    from lagrange_cli.cli.main import run as run_commands

    run_commands()


if __name__ == "__main__":
    run()

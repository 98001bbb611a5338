"""The command ``lagrange``, and ``python -m lagrange_cli``."""

import signal
from typing import NoReturn


def run() -> NoReturn:
    """Run the command line, and exit.

    While it is loaded, Ctrl-C ends the process as it does any other, and not with a traceback of what was
    loading.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from lagrange_cli.cli.main import run as run_commands

    run_commands()


if __name__ == "__main__":
    run()

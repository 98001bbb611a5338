"""``python -m lagrange_cli``: the same as the command ``lagrange``."""

from lagrange_cli.cli.main import run

run()

"""``python -m lagrange_cli``: the same as the command ``lagrange``."""

import sys

from lagrange_cli.cli.main import main

sys.exit(main())

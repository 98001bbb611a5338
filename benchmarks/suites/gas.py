"""A gas of hard discs in a box as a whole command, beside an event-driven simulation in numpy."""

from __future__ import annotations

import sys
from argparse import Namespace
from statistics import median

from benchmarks.harness.processes import OURS, PROGRAMS, shell
from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite

COUNTS, STOPS = (100, 400), (1, 5)
MOST = 1.5
"""Milliseconds of the processor for each impact that 400 discs may take."""
GAS = """
sizes: {{N: {count}, K: {across}}}
parameters: {{R: 0.2, L: {length}}}
coordinates:
  x[i in range(N)]: {{initial: "0.5*(i % K) + 0.25 + 0.02*sin(i)", velocity: "cos(7*i*i + 1)"}}
  y[i in range(N)]: {{initial: "0.5*(i // K) + 0.25 + 0.03*cos(i)", velocity: "sin(5*i*i + 2)"}}
masses: {{"disc[i in range(N)]": 1}}
positions: {{"disc[i in range(N)]": ["x[i]", "y[i]"]}}
potential: 0
definitions:
  dx[i in range(N), j in range(i)]: x[i] - x[j]
  dy[i in range(N), j in range(i)]: y[i] - y[j]
  push[i in range(N), j in range(i)]: >-
    ((x_dot[i] - x_dot[j])*dx[i,j] + (y_dot[i] - y_dot[j])*dy[i,j])/(dx[i,j]**2 + dy[i,j]**2)
events:
  hit[i in range(N), j in range(i)]:
    when: dx[i,j]**2 + dy[i,j]**2 - 4*R**2
    direction: falling
    action:
      set:
        x_dot[i]: x_dot[i] - push[i,j]*dx[i,j]
        y_dot[i]: y_dot[i] - push[i,j]*dy[i,j]
        x_dot[j]: x_dot[j] + push[i,j]*dx[i,j]
        y_dot[j]: y_dot[j] + push[i,j]*dy[i,j]
  right[i in range(N)]:
    {{when: "x[i] - L + R", direction: rising, action: {{set: {{"x_dot[i]": "-x_dot[i]"}}}}}}
  left[i in range(N)]:
    {{when: "x[i] - R", direction: falling, action: {{set: {{"x_dot[i]": "-x_dot[i]"}}}}}}
  top[i in range(N)]:
    {{when: "y[i] - L + R", direction: rising, action: {{set: {{"y_dot[i]": "-y_dot[i]"}}}}}}
  bottom[i in range(N)]:
    {{when: "y[i] - R", direction: falling, action: {{set: {{"y_dot[i]": "-y_dot[i]"}}}}}}
solve: {{samples: 3}}
"""


def ours(count: int, stop: int) -> str:
    """Our command, as it is shown."""
    return f"lagrange solve gas{count}.yaml --stop {stop} --no-cache"


def peer(count: int, stop: int) -> str:
    """The other program, as it is shown."""
    return f"numpy, event-driven: {count} discs to t = {stop}"


def measure(options: Namespace) -> Report:
    """Every command's seconds of the processor, and those that an impact takes."""
    cases = [(count, stop) for count in COUNTS for stop in STOPS]
    commands = {ours(*one): (*OURS, *ours(*one).split()[1:], "--force") for one in cases}
    commands |= {peer(*one): (str(PROGRAMS / "event_driven_discs.py"), *map(str, one)) for one in cases}
    with shell() as place:
        for count in COUNTS:
            across = round(count**0.5)
            text = GAS.format(count=count, across=across, length=across / 2)
            (place.folder / f"gas{count}.yaml").write_text(text, encoding="utf-8")
        ended = place.in_turns(commands, options.runs)
    seconds = {name: median(each.processor for each in runs) for name, runs in ended.items()}
    impacts = {one: int(ended[peer(*one)][0].printed.split()[0]) for one in cases}
    rows, each = [], {}
    for show in (ours, peer):
        for count in COUNTS:
            first, last = ((count, stop) for stop in STOPS)
            more = seconds[show(*last)] - seconds[show(*first)]
            each[show, count] = 1e3 * more / (impacts[last] - impacts[first])
            for one in (first, last):
                number = f"{each[show, count]:.2f}" if one == last else ""
                rows.append((show(*one), f"{impacts[one]}", f"{seconds[show(*one)]:.1f}", number))
    header = "command", "impacts", "s of the processor", "ms for each further impact"
    return Report(
        (markdown_table(header, rows),),
        (Requirement("lagrange, 400 discs: ms for each further impact", each[ours, 400], "<=", MOST),),
    )


SUITE = Suite("gas", measure, packages=("llvmlite", "numpy", "h5py"), runs=3)

if __name__ == "__main__":
    sys.exit(SUITE.main())

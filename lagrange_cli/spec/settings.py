"""The sections ``solve`` and ``time``: their keys, a row each, and how they are read."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from lagrange_cli.spec import nodes
from lagrange_cli.spec.fields import read_count, read_number, read_scalar, read_text, read_words
from lagrange_cli.spec.nodes import Node
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.table import Row, Table, read_part, read_table

TIME = Table(
    "time",
    (Row("unit", read_text, "the unit of t", also="units in"),),
    {"it belongs under 'solve', as in 'solve: {stop: 10}'": "start stop step end from to t0 t1 tmax dt span"},
)
SOLVE = Table(
    "solve",
    (
        Row(
            "start",
            read_scalar,
            "the time at which the motion begins [0]",
            also="t0 begin t_start tstart start_time from",
        ),
        Row(
            "stop",
            read_scalar,
            "the time at which it ends; if that is before `start`, the motion is integrated "
            "[backward](output-file.md#datasets)",
            also="end t_end tend tmax t_max tstop t_stop stop_time duration final until t1 tf t_final time "
            "to",
        ),
        Row(
            "samples",
            read_count,
            "the number of samples, evenly spaced [1001]",
            also="n N points npoints n_points num_points n_samples num_samples num count n_steps sample",
        ),
        Row(
            "step",
            read_scalar,
            "the time between samples, in place of `samples`",
            also="dt h delta_t deltat timestep time_step step_size stepsize interval",
        ),
        Row("method", read_text, "the integration method [auto]", also="solver integrator scheme algorithm"),
        Row("tolerance", read_number, "the relative error per step", also="tol rtol atol eps accuracy error"),
        Row("outputs", read_words, "what is written, a list or `all`", also="output write save"),
        Row("unit", read_text, "the unit of t, unless `time` gives it", also="units"),
    ),
    {
        "write 'start: 0' and 'stop: 10'": "t t_span tspan span time_span interval range",
        "it is an option of the command line: see 'lagrange solve --help'": "format file filename jobs "
        "precision certify digits checkpoint portable resume force parallel target_error",
        "write 'samples: 1001' for the number of samples, or 'step: 0.1' for the time between them": "steps",
        "the steps of the integration follow from 'tolerance'": "max_step min_step first_step maxstep order",
        "write 'step' or 'samples': samples are evenly spaced": "times t_eval saveat grid every",
        "they are a section of their own, beside 'solve'": "events event",
    },
)


def read_solve(node: Node, where: str, problems: Problems) -> Mapping[str, Any]:
    """The section ``solve``."""
    return read_part(SOLVE, node, where, problems)


def read_time(node: Node, where: str, problems: Problems) -> str:
    """The section ``time``, the unit of t: ``time: d`` or ``time: {unit: d}``."""
    if isinstance(node, nodes.Mapping):
        return str(read_table(node, TIME, where, problems).get("unit", ""))
    if isinstance(node, nodes.Scalar) and re.fullmatch(r"[-+.\d][-+.\deE]*", node.text):
        hint = f"write 'solve: {{stop: {node.text}}}' for the end of the motion"
        problems.add(node.place, "time is the unit of t, not a number", hint)
    return read_text(node, where, problems)

"""What the benchmarks conclude from what they measure."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.__main__ import BENCHMARKS
from benchmarks.benchmark import DOCUMENT
from benchmarks.brouwer import binned, growth_exponent
from benchmarks.chain import cost
from benchmarks.comparison import Measurement, comparison_table, measured, medians
from benchmarks.engines import lagrange
from benchmarks.problems import (
    DOUBLE_PENDULUM,
    FIGURE_EIGHT,
    HOOP,
    KEPLER_CARTESIAN,
    KEPLER_POLAR,
    SOLAR_SYSTEM,
    n_pendulum,
)
from benchmarks.report import Report, Requirement, markdown_table, replaced_section
from benchmarks.turns import in_turns


@pytest.mark.parametrize(
    ("value", "relation", "bound", "met"),
    [
        (1.0, "<", 1.0, False),
        (1.0, "<=", 1.0, True),
        (1.0, ">=", 1.0, True),
        (0.9, ">=", 1.0, False),
        (float("nan"), "<=", 1.0, False),
        (float("nan"), ">=", 1.0, False),
    ],
)
def test_a_figure_is_reached_if_its_relation_holds(value, relation, bound, met):
    requirement = Requirement("speed", value, relation, bound)
    assert requirement.met is met
    report = Report(("a table",), (requirement,))
    assert report.missed == (() if met else (requirement,))
    assert ("| NO" in report.text(())) is not met


def test_columns_are_as_wide_as_their_widest_cell():
    assert markdown_table(("a", "b"), [("long", "1")]).splitlines() == [
        "| a    | b |",
        "| ---- | - |",
        "| long | 1 |",
    ]


def test_a_section_is_replaced_and_nothing_else():
    document = (
        "# T\n\n<!-- one -->\nold\n<!-- end of one -->\n\n<!-- two -->\nkept\n<!-- end of two -->\nend\n"
    )
    once = replaced_section(document, "one", "new")
    assert once == document.replace("old", "\nnew\n")
    assert replaced_section(once, "one", "new") == once
    with pytest.raises(ValueError, match="no section 'three'"):
        replaced_section(document, "three", "new")


@pytest.mark.parametrize("benchmark", BENCHMARKS, ids=lambda each: each.name)
def test_every_benchmark_has_a_section_a_command_and_a_name_that_runs_it(benchmark):
    document = DOCUMENT.read_text(encoding="utf-8")
    assert replaced_section(document, benchmark.name, "new") != document
    assert f"python -m benchmarks.{benchmark.name} " in document
    assert benchmark.measure.__module__ == f"benchmarks.{benchmark.name}"
    assert benchmark.parser().parse_args([]).runs == benchmark.runs


def test_turns_alternate():
    log = []
    results = in_turns({name: lambda name=name: log.append(name) or len(log) for name in "ab"}, 3)
    assert log == list("ababab")
    assert results == {"a": [1, 3, 5], "b": [2, 4, 6]}


def test_medians_over_turns_and_ratios_to_ours():
    runs = [Measurement(seconds, 10 * seconds, 7, seconds / 8) for seconds in (1.0, 5.0, 2.0)]
    middle = medians(runs)
    assert middle == Measurement(2.0, 20.0, 7, 5 / 8)
    table = comparison_table({"ours": middle, "theirs": Measurement(4.0, 60.0, 9, 1e-12)}, "ours")
    assert [cell.strip() for cell in table.splitlines()[-1].split("|")[1:-1]] == [
        *("theirs", "4000", "2.0", "60000.0", "3.0", "9", "1.0e-12"),
    ]


def test_the_cost_of_a_step_is_shared_by_the_pendulums():
    assert cost({10: Measurement(0.0, 3.0, 30, 0.0)}, 10) == pytest.approx(0.01)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
def test_the_growth_of_a_power_of_time_is_its_exponent(exponent):
    times = np.linspace(0.01, 1.0, 2000)
    periods, errors = binned(times, (3.0 * times**exponent) ** 2, 30)
    assert growth_exponent(periods, errors) == pytest.approx(exponent, abs=0.01)
    assert np.all(np.diff(periods) > 0)


def test_bins_hold_every_sample_once():
    times, squares = np.arange(1.0, 1001.0), np.arange(1000.0)
    for bins in (1, 7):
        centres, _ = binned(times, squares, bins)
        assert len(centres) == bins
    assert binned(times, squares, 1)[1] == pytest.approx([np.sqrt(squares.mean())])


PROBLEMS = (
    (DOUBLE_PENDULUM, 1.0),
    (HOOP, 1.0),
    (KEPLER_POLAR, 1.0),
    (KEPLER_CARTESIAN, 1.0),
    (FIGURE_EIGHT, 1.0),
    (SOLAR_SYSTEM, 100.0),
    (n_pendulum(4, 1.0), 1.0),
)


@pytest.mark.parametrize(("problem", "stop"), PROBLEMS, ids=lambda each: getattr(each, "system", ""))
def test_the_energy_function_of_each_problem_is_kept_by_its_motion(problem, stop):
    short = replace(problem, stop=stop)
    found = measured(lagrange, short, 2)
    assert found.energy_error < 1e-13
    q, v = short.starts(2)[1]
    moved = np.stack([q, 1.01 * q], axis=1), np.stack([v, v], axis=1)
    assert abs(short.energy_errors(*moved)[1]) > 1e-4

"""The suites, and the table of them."""

import pytest

from benchmarks.harness.report import replaced_section
from benchmarks.harness.suite import DOCUMENT
from benchmarks.peers.comparison import Measurement
from benchmarks.suites import SUITES, suite
from benchmarks.suites.chain import cost


@pytest.mark.parametrize("name", SUITES)
def test_every_suite_has_a_section_and_a_command_that_runs_it(name: str) -> None:
    document, found = DOCUMENT.read_text(encoding="utf-8"), suite(name)
    assert found.name == name
    assert replaced_section(document, name, "new") != document
    assert f".venv/bin/python -m benchmarks.{name:15}# {SUITES[name]}\n" in document
    assert found.measure.__module__ == f"benchmarks.suites.{name}"
    assert found.parser().parse_args([]).runs == found.runs


def test_the_cost_of_a_step_is_shared_by_the_pendulums() -> None:
    assert cost({10: Measurement(0.0, 3.0, 30, 0.0)}, 10) == pytest.approx(0.01)

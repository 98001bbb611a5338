"""System files from the fuzzer's grammar: every command ends as documented, and touches nothing else."""

from __future__ import annotations

import os
from random import Random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests import fuzz, grammar


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of the test's own, where faults show themselves."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LAGRANGE_DEBUG", "1")
    monkeypatch.setenv("LAGRANGE_NO_CACHE", "1")
    return tmp_path


@settings(
    max_examples=60, derandomize=True, deadline=None, database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(st.integers(0, 2**63))
def test_whatever_the_file_says(folder, seed):
    statuses = fuzz.feed(grammar.system(Random(seed)).encode(errors="replace"))
    assert set(statuses) <= set(fuzz.DOCUMENTED)
    assert set(os.listdir(folder)) <= {"input.yaml", "out.h5"}


@pytest.mark.parametrize(
    "path", sorted((fuzz.ROOT / "tests" / "corpus").glob("*.yaml")), ids=lambda path: path.stem
)
def test_what_was_found_before(folder, path):
    fuzz.feed(path.read_bytes())
    assert set(os.listdir(folder)) <= {"input.yaml", "out.h5"}


@pytest.mark.parametrize("name", sorted(fuzz.kept_inputs())[::16])
def test_some_of_what_the_fuzzer_kept(folder, name):
    """Inputs that reach different code; all of them are where the next run of the fuzzer begins."""
    assert set(fuzz.feed(fuzz.kept_inputs()[name])) <= set(fuzz.DOCUMENTED)
    assert set(os.listdir(folder)) <= {"input.yaml", "out.h5"}

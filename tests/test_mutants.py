"""The mutations of ``tests.mutants`` are mistakes in the code as it is."""

import ast

import pytest

from tests.mutants import MUTATIONS, ROOT


@pytest.mark.parametrize("name", MUTATIONS)
def test_a_mutation_has_one_place_and_tests_that_exist(name):
    mutation = MUTATIONS[name]
    text = mutation.applied()
    if mutation.file.endswith(".py"):
        ast.parse(text)
    for test in mutation.tests:
        path, _, function = test.partition("::")
        text = (ROOT / path).read_text(encoding="utf-8")
        assert f"def {function.partition('[')[0]}(" in text or not function

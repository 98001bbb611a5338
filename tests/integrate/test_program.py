"""Programs that are too large, and the ways out that are named."""

import pytest

from lagrange_cli import GraphAlgebra, build_model, derive
from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.exact import ExactGraphAlgebra
from lagrange_cli.integrate import convolutions
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE
from lagrange_cli.integrate.program import write_run
from lagrange_cli.native.llvm import length
from lagrange_cli.records import replace
from tests.support.motion import spec_of

RUN = Compilation("taylor", 2.0**-52, frozenset({"q", "v"}))


@pytest.mark.parametrize(("name", "another"), [("pendulum", True), ("four_bar", False)])
@pytest.mark.parametrize("instructions", [True, False])
def test_no_other_method_is_named_for_systems_with_constraints(name, another, instructions, monkeypatch):
    """It would refuse them."""
    residual = derive(build_model(spec_of(name), GraphAlgebra()))
    if instructions:
        monkeypatch.setattr(length, "MOST_INSTRUCTIONS", 10)
    else:
        monkeypatch.setattr(convolutions, "most_convolutions", lambda precision, straight=False: 0)
    with pytest.raises(TooLarge) as found:
        write_run(residual, RUN)
    assert ("--method" in found.value.hint) == another
    assert "LAGRANGE_LIMITS=" in found.value.hint


@pytest.mark.parametrize("change", [{"precision": DOUBLE_DOUBLE}, {"factor": 8}, {"proven": True}])
def test_nor_where_no_other_method_can_be_chosen(change, monkeypatch):
    """Double-double numbers, companions and proofs need series."""
    residual = derive(build_model(spec_of("pendulum"), ExactGraphAlgebra()))
    monkeypatch.setattr(length, "MOST_INSTRUCTIONS", 10)
    with pytest.raises(TooLarge, match="instructions") as found:
        write_run(residual, replace(RUN, **change))
    assert "--method" not in found.value.hint and "LAGRANGE_LIMITS=" in found.value.hint

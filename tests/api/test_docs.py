"""The notebook runs. (The page of recipes is run with the other pages.)"""

import ast
import json

import pytest

from tests.support.command import ROOT


@pytest.fixture(scope="module")
def shown():
    """What each cell of the notebook would show, in its own representation."""
    notebook = json.loads((ROOT / "docs" / "pendulum.ipynb").read_text(encoding="utf-8"))
    assert (notebook["nbformat"], len({cell["id"] for cell in notebook["cells"]})) == (
        4,
        len(notebook["cells"]),
    )
    names, found = {}, []
    for cell in notebook["cells"]:
        if cell["cell_type"] != "code":
            continue
        assert cell["outputs"] == [] and cell["execution_count"] is None
        tree = ast.parse("".join(cell["source"]))
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, "a cell", "exec"), names)
        if last is not None:
            found.append(eval(compile(ast.Expression(last.value), "a cell", "eval"), names))
    return found


@pytest.mark.exhaustive(keep=0.15)
def test_the_notebook_runs_and_shows_formulas(shown):
    assert any(hasattr(one, "_repr_latex_") and one._repr_latex_().startswith("$") for one in shown)
    assert any(hasattr(one, "_repr_png_") and one._repr_png_() for one in shown)
    assert any("reached the end" in repr(one) for one in shown)

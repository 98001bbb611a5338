"""The structure of the package: no module imports itself in a circle, nor does a package."""

import ast
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import pytest

import lagrange_cli

ROOT = Path(lagrange_cli.__file__).parent


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_of(path): path for path in ROOT.rglob("*.py")}


def statements(inside: ast.AST) -> Iterator[ast.AST]:
    """All statements within one or a module, without looking through their expressions."""
    for field in ("body", "orelse", "finalbody", "handlers", "cases"):
        for one in getattr(inside, field, []):
            yield one
            yield from statements(one)


def imported(path: Path) -> Iterator[str]:
    """What a module imports of the package, wherever in it: in a function, or for type checkers only, too."""
    for node in statements(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            named = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from (one if one in MODULES else node.module for one in named)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


@cache
def imports() -> dict[str, set[str]]:
    """The modules that each module imports."""
    return {name: {*imported(path)} & MODULES.keys() - {name} for name, path in MODULES.items()}


def circle(graph: Mapping[str, set[str]]) -> list[str]:
    """What is left when whatever imports nothing that is left is taken away, again and again."""
    left = {name: {*others} for name, others in graph.items()}
    while leaves := [name for name, others in left.items() if not others & left.keys()]:
        for name in leaves:
            del left[name]
    return sorted(left)


def test_no_module_is_imported_in_a_circle():
    assert len(MODULES) > 200
    assert circle(imports()) == []


def packages() -> list[str]:

    return sorted(name for name, path in MODULES.items() if path.name == "__init__.py")


@pytest.mark.parametrize("package", packages())
def test_the_parts_of_a_package_do_not_import_each_other_in_a_circle(package):
    """A part is a module, or a package with all that is in it."""
    depth = package.count(".") + 2
    graph: dict[str, set[str]] = defaultdict(set)
    for name, others in imports().items():
        own = ".".join(name.split(".")[:depth])
        if name.startswith(f"{package}."):
            parts = {".".join(one.split(".")[:depth]) for one in others if one.startswith(f"{package}.")}
            graph[own] |= parts - {own}
    assert circle(graph) == []


def test_a_circle_is_found():
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": set()}) == ["a", "b", "c"]


def test_docstrings_name_only_modules_that_exist():
    """``package.module`` or ``package.module.Name``, with the first part a package of ours."""
    packages = {path.parent.name for path in ROOT.glob("*/__init__.py")}
    known = {name.removeprefix("lagrange_cli.") for name in MODULES}
    named = 0
    for path in MODULES.values():
        for one in re.findall(r"``([a-z_]+(?:\.[A-Za-z_]+)+)``", path.read_text(encoding="utf-8")):
            if one.partition(".")[0] in packages:
                named += 1
                assert {one, one.rpartition(".")[0]} & known - packages, f"{path.name} names {one}"
    assert named > 20


def test_code_is_written_by_python_alone() -> None:
    """No file of LLVM IR: control flow is that of ``native.llvm.function``."""
    assert not [*ROOT.rglob("*.ll")]


EVALUATING = {"eval", "exec", "compile", "sympify", "lambdify", "parse_expr", "__import__"}
"""What would run a text, or lets sympy do so. (``re.compile`` does not.)"""


def test_no_text_is_evaluated():
    """Nothing is called or named ``eval`` or ``exec``; pages set no markup but that of ``mathml``."""
    package = Path(lagrange_cli.__file__).parent
    for path in package.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)) if any(name in text for name in EVALUATING) else ():
            if isinstance(node, ast.Call):
                called, owner = node.func, ""
                if isinstance(called, ast.Attribute):
                    owner, name = getattr(called.value, "id", "?"), called.attr
                else:
                    name = getattr(called, "id", "")
                assert name not in EVALUATING or (owner, name) == ("re", "compile"), f"{path}:{node.lineno}"
            elif isinstance(node, ast.FunctionDef):
                assert node.name not in EVALUATING, f"{path}:{node.lineno}"
    for path in (package / "page" / "assets").glob("*.js"):
        text = path.read_text(encoding="utf-8")
        found = re.findall(
            r"\beval\(|\bexec\(|\bFunction\(|innerHTML|insertAdjacentHTML|document\.write|set(?:Timeout|Interval)\(\s*[\"'`]",
            text,
        )
        assert found == (["innerHTML"] if path.name == "main.js" else []), path

"""What a command does not need it does not import: each runs in a process of its own that tells."""

import json
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

import pytest

from tests.support.command import ROOT, SYSTEMS, environment

HEAVY = {"click", "yaml", "numpy", "h5py", "llvmlite", "sympy", "mpmath", "scipy", "matplotlib"}
PROBE = """
import json, sys
from lagrange_cli.cli.main import main
status = max(map(main, json.loads(sys.argv[1])))
print(json.dumps([status, sorted(sys.modules)]), file=sys.stderr)
"""
PENDULUM = str(SYSTEMS / "pendulum.yaml")


def modules_imported_by(arguments: list[str], cwd: Path, *more: list[str], **variables: str) -> set[str]:
    """The modules in memory after commands have done their work (which must have succeeded), with these
    environment variables."""
    run = subprocess.run(
        [sys.executable, "-c", PROBE, json.dumps([arguments, *more])],
        cwd=cwd,
        env={**environment(), **variables},
        capture_output=True,
        text=True,
    )
    messages, _, answer = run.stderr.rstrip().rpartition("\n")
    status, modules = json.loads(answer)
    assert status == 0, messages
    return set(modules)


@cache
def modules_of(*arguments: str) -> set[str]:
    """The same of a command that several tests look at; of a solve, when its program is in the cache."""
    with tempfile.TemporaryDirectory() as folder:
        if arguments[0] == "solve":
            modules_imported_by([*arguments], Path(folder))
        return modules_imported_by([*arguments], Path(folder))


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(
    ("arguments", "needed"),
    [
        (["--help"], {"click"}),
        (["--version"], {"click"}),
        (["systems"], {"click"}),
        (["systems", "pendulum"], {"click"}),
        (["solve", "--help"], {"click"}),
        (["equations", "--help"], {"click"}),
        (["check", PENDULUM], {"click", "yaml"}),
        (["solve", PENDULUM], {"click", "yaml", "numpy", "llvmlite", "h5py"}),
        (["solve", PENDULUM, "--outputs", "all"], {"click", "yaml", "numpy", "llvmlite", "h5py"}),
        (["sweep", "--help"], {"click"}),
        (["sweep", PENDULUM, "--over", "m=1,2"], {"click", "yaml", "numpy", "llvmlite", "h5py"}),
        (["section", "--help"], {"click"}),
        (["section", PENDULUM, "--where", "theta"], {"click", "yaml", "numpy", "llvmlite", "h5py"}),
        (["bench", PENDULUM, "--methods", "taylor", "--runs", "1"], {"click", "yaml", "numpy", "llvmlite"}),
        (["equations", PENDULUM], {"click", "yaml", "sympy", "mpmath"}),
    ],
    ids=lambda value: " ".join(value).replace(PENDULUM, "pendulum.yaml") if isinstance(value, list) else None,
)
def test_a_command_imports_what_it_needs_and_nothing_else(arguments, needed, tmp_path):
    assert modules_imported_by(arguments, tmp_path) & HEAVY == needed


@pytest.mark.exhaustive(keep=0.15)
def test_scipy_is_imported_by_its_own_methods(tmp_path):
    dop853, radau, bdf = (
        ["solve", PENDULUM, "--method", method, "--force"] for method in ("DOP853", "Radau", "BDF")
    )
    assert "scipy" not in modules_imported_by(dop853, tmp_path, radau)
    modules = modules_imported_by(bdf, tmp_path)
    assert "scipy" in modules and "sympy" not in modules


@pytest.mark.exhaustive(keep=0.6)
def test_a_plain_solve_loads_only_the_stages_it_goes_through(tmp_path):
    modules = modules_imported_by(["solve", PENDULUM], tmp_path)
    assert not [name for name in modules if name.startswith(("lagrange_cli.symbolic", "lagrange_cli.api"))]
    assert not modules & {f"lagrange_cli.run.{name}" for name in ("schema", "shipped", "view", "memory")}
    assert "lagrange_cli.expression.symbolic" not in modules
    assert not modules & {"_hashlib", "numpy.typing"}  # 6 ms


@pytest.mark.exhaustive(keep=0.3)
def test_a_solve_whose_program_is_in_the_cache_does_not_derive_it_again():
    modules = modules_of("solve", PENDULUM, "--force")
    assert not modules & {"llvmlite.binding", "lagrange_cli.expression.graph", "lagrange_cli.outputs.plan"}
    stages = ("mechanics", "series", "native.recurrences", "native.stepping")
    assert not [name for name in modules if name.startswith(tuple(f"lagrange_cli.{one}" for one in stages))]


def test_a_system_without_families_is_compiled_without_what_they_need(tmp_path):
    """A bound on all that is imported where nothing is in the cache, too; a module takes 0.3 ms."""
    modules = modules_imported_by(["solve", PENDULUM], tmp_path, LAGRANGE_NO_CACHE="1")
    own = {name for name in modules if name.startswith("lagrange_cli")}
    others = ("families", "native.families", "native.ensembles", "native.rates.radau")
    assert not [name for name in own if name.startswith(tuple(f"lagrange_cli.{one}" for one in others))]
    assert len(own) <= 320


def test_families_load_no_masked_arrays(tmp_path):
    """They take 10 ms of numpy's."""
    lattice = PENDULUM.replace("pendulum.yaml", "lattice.yaml")
    modules = modules_imported_by(
        ["solve", lattice, "--size", "N=20", "--stop", "0.1"], tmp_path, LAGRANGE_NO_CACHE="1"
    )
    assert "lagrange_cli.native.families.program" in modules and "numpy.ma" not in modules


RARE = {f"lagrange_cli.spec.{name}" for name in (
    "bodies", "draw", "events", "transformations", "unknown", "vanishing",
)}  # fmt: skip
"""Modules for sections that few files have, and for mistakes."""


@pytest.mark.exhaustive(keep=0.25)
def test_a_short_command_loads_few_modules():
    """Bounds on what grows unseen; a module takes a fifth of a millisecond, and one if it has no bytecode."""
    for arguments, most in (
        (["--help"], 14),
        (["solve", PENDULUM, "--force"], 156),
        (["equations", PENDULUM], 153),
    ):
        own = {name for name in modules_of(*arguments) if name.startswith("lagrange_cli")}
        assert len(own) <= most and not own & RARE
        assert not own & {"lagrange_cli.expression.squares", "lagrange_cli.mechanics.conserved.tops"}


def test_help_does_not_load_what_reads_files():
    assert not modules_of("--help") & {"pathlib", "urllib", "tempfile", "random"}


@pytest.mark.exhaustive(keep=0.3)
def test_printed_equations_do_not_load_the_compiler():
    modules = modules_of("equations", PENDULUM)
    stages = ("series", "native", "mechanics.residual", "symbolic.hamilton", "symbolic.latex")
    assert not [name for name in modules if name.startswith(tuple(f"lagrange_cli.{one}" for one in stages))]
    assert not modules & {"_hashlib", "dataclasses"}  # 4 ms


@pytest.mark.exhaustive(keep=0.2)
def test_a_consistent_start_needs_neither_sympy_nor_the_graph(tmp_path):
    content = (SYSTEMS / "pendulum.yaml").read_text()
    system = tmp_path / "bound.yaml"
    system.write_text(content + "\nconstraints: {wall: theta - 0.2}\n")
    command = ["solve", str(system), "--force", "--set", "theta=0.2"]
    modules = modules_imported_by(command, tmp_path)
    assert not modules & {"sympy", "scipy", "mpmath"}
    modules = modules_imported_by(command, tmp_path)
    assert not modules & {"lagrange_cli.expression.graph", "lagrange_cli.mechanics.constraints"}


def test_the_package_itself_imports_nothing():
    script = "import sys, lagrange_cli, json; print(json.dumps(list(sys.modules)))"
    run = subprocess.run(
        [sys.executable, "-c", script],
        cwd=ROOT,
        env=environment(),
        capture_output=True,
        text=True,
        check=True,
    )
    modules = set(json.loads(run.stdout))
    assert not modules & HEAVY
    assert [name for name in modules if name.startswith("lagrange_cli")] == ["lagrange_cli"]


def test_nothing_is_imported_before_ctrl_c_is_heeded():
    """Until ``run`` is called, Ctrl-C shows a traceback, so that must not take long."""
    probe = "import sys; before = set(sys.modules); import lagrange_cli.__main__ as m; m.run"
    probe += "; print(sorted(set(sys.modules) - before))"
    run = subprocess.run([sys.executable, "-c", probe], env=environment(), capture_output=True, text=True)
    assert (run.stdout, run.stderr) == ("['lagrange_cli', 'lagrange_cli.__main__']\n", "")

"""Calls on stacks of their own: compiled code whose values do not fit the caller's."""

from __future__ import annotations

import resource
import threading

import pytest

from lagrange_cli.errors import TooLarge
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import family_run
from lagrange_cli.integrate.family_program import write_families
from lagrange_cli.integrate.precision import FULL_PRECISION
from lagrange_cli.integrate.program import write_run
from lagrange_cli.native.compilation import machine
from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.stack import with_stack
from lagrange_cli.native.llvm import length
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.numbers.double_double import DoubleDouble
from lagrange_cli.records import replace
from lagrange_cli.spec.read import read_spec
from tests.support.command import SYSTEMS, lagrange_process
from tests.support.motion import residual_of

BODIES = """
sizes: {N: 24}
coordinates:
  x[i in range(N)]: {initial: 0.37*i - 0.01*i*i}
  y[i in range(N)]: {initial: 0.11*i + 0.003*i*i}
  z[i in range(N)]: {initial: 0.5*i}
masses:
  b[i in range(N)]: 1/N
embedding:
  b[i in range(N)]: (x[i], y[i], z[i])
potential: >-
  -sum(1/N/N/sqrt((x[i] - x[j])**2 + (y[i] - y[j])**2 + (z[i] - z[j])**2 + 0.01)
       for i in range(N) for j in range(i))
solve: {stop: 0.001, samples: 2}
"""


def test_a_call_gets_the_stack_that_it_is_given():
    before = threading.stack_size()
    assert with_stack(lambda a, b: (a + b, threading.current_thread().name), 2**24)(1, 2)[0] == 3
    assert threading.stack_size() == before
    assert with_stack(threading.current_thread, 2**24)() is not threading.current_thread()


def test_what_a_call_raises_is_raised():
    with pytest.raises(ZeroDivisionError):
        with_stack(lambda: 1 // 0, 2**20)()


def test_tables_need_no_stack():
    """A call with a stack of its own starts a thread: code of families is short, however long its tables."""
    count = 2**18
    numbers = ", ".join(f"i32 {i}" for i in range(count))
    text = f"""
@table = internal constant [{count} x i32] [{numbers}]
define i32 @entry(i64 %i) {{
  %place = getelementptr i32, ptr @table, i64 %i
  %value = load i32, ptr %place
  ret i32 %value
}}
"""
    code = compile_text(text, 0)
    assert len(code) > machine.SMALL
    assert 0 < machine.load(code).instructions < 1000


@pytest.mark.exhaustive(keep=0)
def test_values_that_do_not_fit_the_stack_of_the_process(tmp_path):
    """24 bodies: a step holds 0.8 MB of values at once, and the process has a stack of half of that."""
    (tmp_path / "bodies.yaml").write_text(BODIES)

    def small_stack() -> None:
        resource.setrlimit(resource.RLIMIT_STACK, (2**19, 2**19))

    run = lagrange_process("solve", "bodies.yaml", "--no-cache", cwd=tmp_path, preexec_fn=small_stack)
    assert run.returncode == 0, run.stderr


def test_functions_of_too_many_instructions_are_refused(monkeypatch):
    monkeypatch.setattr(length, "MOST_INSTRUCTIONS", 100)
    f = Function("define void @long()")
    for _ in range(101):
        f.define("fadd double 0.0, 0.0")
    with pytest.raises(TooLarge, match=r"more than 100 instructions; .*--method DOP853.*=instructions="):
        f.define("fadd double 0.0, 0.0")
    twice = Function("define void @long()")
    DoubleDouble(twice)
    with pytest.raises(TooLarge, match="more than 50 instructions"):
        for _ in range(52):
            twice.define("fadd double 0.0, 0.0")


def test_programs_of_too_many_instructions_are_refused(monkeypatch):
    """Also where none of their functions has as many."""
    asked = Compilation("Radau", 1e-6, frozenset({"q"}))
    program, _ = write_run(residual_of("double_pendulum"), asked)
    functions = program.text.split("\ndefine ")
    count = program.text.count(" = ")
    assert max(one.count(" = ") for one in functions) < count - 1
    monkeypatch.setattr(length, "MOST_INSTRUCTIONS", count)
    write_run(residual_of("double_pendulum"), asked)
    monkeypatch.setattr(length, "MOST_INSTRUCTIONS", count - 1)
    with pytest.raises(TooLarge, match=f"more than {count - 1} instructions"):
        write_run(residual_of("double_pendulum"), asked)


@pytest.mark.exhaustive(keep=0)
def test_series_of_too_many_convolutions_are_refused_before_any_code_is_written(tmp_path, monkeypatch):
    monkeypatch.setenv("LAGRANGE_LIMITS", "convolutions=527")  # 12*11/2 pairs take 8 each
    turned = BODIES.replace("N: 24", "N: 12").replace("-sum(", "1e-9*atan2(x[0] + 9, -5) - sum(")
    (tmp_path / "bodies.yaml").write_text(turned)  # cuts of energies go through the members of families
    run = lagrange_process("solve", "bodies.yaml", "--no-cache", cwd=tmp_path)
    assert run.returncode == 3
    assert "convolutions per order; at most 527" in run.stderr
    assert "--method ias15" in run.stderr and "LAGRANGE_LIMITS=convolutions=" in run.stderr
    assert not list(tmp_path.glob("*.h5"))
    run = lagrange_process("solve", "bodies.yaml", "--method", "ias15", "--no-cache", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    twice = ("--precision", "double-double", "--force", "--no-cache")
    run = lagrange_process("solve", "bodies.yaml", *twice, cwd=tmp_path)
    assert run.returncode == 3 and "at most 131" in run.stderr and "ias15" not in run.stderr


@pytest.mark.exhaustive(keep=0.75)
def test_the_refusal_names_the_file(tmp_path, monkeypatch):
    monkeypatch.setenv("LAGRANGE_LIMITS", "instructions=50")
    system = str(SYSTEMS / "double_pendulum.yaml")
    run = lagrange_process("solve", system, "--no-cache", cwd=tmp_path)
    assert run.returncode == 3 and run.stderr.startswith(f"{system}: the machine code has more than 50 ")


def test_loops_over_members_are_compiled_at_the_full_level_at_once():
    """Sums over pairs, as every order has them, are more text than is compiled so elsewhere."""
    spec = read_spec(BODIES, "bodies", {"N": "60"})
    compilation = Compilation("taylor", FULL_PRECISION, frozenset({"h"}))
    system = family_run(spec, compilation)
    assert system is not None
    program, _ = write_families(system, compilation)
    assert machine.LARGE < len(program.text) - program.tables < machine.largest(program)
    assert machine.largest(replace(program, loops=False)) == machine.LARGE


def test_better_code_is_not_made_of_what_takes_minutes():
    assert machine.worth_improving(bytes(1000))
    assert not machine.worth_improving(bytes(machine.LARGEST_IMPROVED + 1))

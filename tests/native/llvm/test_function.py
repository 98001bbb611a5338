"""Control flow: random programs give what Python gives, and hand-made ones what they should."""

from __future__ import annotations

import ctypes
import os
import random
from collections.abc import Callable
from contextlib import suppress

import numpy as np
import pytest

from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import load
from lagrange_cli.native.llvm.flow import Loop, Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Real

MASK = 2**64 - 1
VARIABLES = 3


def compiled(function: Function, result: type = ctypes.c_uint64, *kinds: type) -> Callable[..., object]:
    """The function ``@run``."""
    code = load(compile_text(function.text(), 0))
    made = ctypes.CFUNCTYPE(result, *kinds)(code.address("run"))
    return lambda *arguments: (code, made(*arguments))[1]


def test_greatest_common_divisor():
    f = Function("define i64 @run(i64 %a, i64 %b)")
    a, b = f.variable(Integer(f, "%a")), f.variable(Integer(f, "%b"))
    with f.forever() as rounds:
        with f.when(b.get().equals(0)):
            rounds.leave()
        rest = a.get().operation("urem", b.get())
        a.set(b.get())
        b.set(rest)
    f.give(a.get())
    run = compiled(f, ctypes.c_uint64, ctypes.c_uint64, ctypes.c_uint64)
    assert run(2**5 * 3 * 49, 2**3 * 7 * 11) == 56


def test_sum_over_lanes():
    """Memory, vectors, a loop that is entered at least once, and a reduction."""
    f = Function("define double @run(ptr %a, i64 %n)")
    total = f.variable(f.splat(f.constant(0.0), 4))
    with f.loop(0, Integer(f, "%n"), step=4, tested=False) as i:
        row = f.load_row("%a", i, 4)
        total.set(total.get() + f.select(row > 0.0, row, -row))
    f.give(f.reduce("fadd", total.get(), f.constant(0.0)))
    run = compiled(f, ctypes.c_double, ctypes.c_void_p, ctypes.c_int64)
    numbers = np.array([1.0, -2.0, 3.0, -4.0, 5.0, 6.0, -7.0, 8.0])
    assert run(numbers.ctypes.data, 8) == 36


def test_no_phi_is_left_that_has_one_value():
    f = Function("define i64 @run(i64 %a)")
    kept, changed = f.variable(Integer(f, "%a")), f.variable(Integer(f, "%a"))
    with f.loop(0, kept.get()) as i:
        with f.when(i > kept.get()):
            changed.set(changed.get() + 1)
        with f.otherwise():
            changed.set(changed.get() + 2)
    f.give(changed.get() + kept.get())
    assert f.text().count("phi") == 4  # i; what changes: in the loop, behind branch and loop
    assert compiled(f, ctypes.c_uint64, ctypes.c_uint64)(5) == 20


def test_otherwise_belongs_to_a_when():
    f = Function("define void @run()")
    with pytest.raises(ValueError, match="must follow a when"), f.otherwise():
        pass


class Program:
    """A random program of a few variables: run by Python, and written as a function."""

    def __init__(self, chance: random.Random) -> None:
        self.chance = chance
        self.tree = self.block(3)

    def block(self, depth: int) -> list[tuple]:
        return [self.statement(depth) for _ in range(self.chance.randint(1, 4))]

    def statement(self, depth: int) -> tuple:
        kinds = ["set"] * 3 + (["when", "either", "loop", "section"] if depth else []) + ["leave", "give"]
        kind = self.chance.choice(kinds)
        a, b, c = (self.chance.randrange(VARIABLES) for _ in range(3))
        if kind == "set":
            return kind, a, self.chance.choice(["+", "*", "-"]), b, c, self.chance.randrange(9)
        if kind in ("when", "leave", "give"):
            inside = self.block(depth - 1) if kind == "when" else []
            return kind, a, self.chance.randrange(2, 5), inside
        if kind == "either":
            return kind, a, self.chance.randrange(2, 5), self.block(depth - 1), self.block(depth - 1)
        return kind, self.chance.randrange(4), a, self.block(depth - 1)

    def run(self, values: list[int]) -> int:
        """In Python."""

        class Give(Exception):
            pass

        class Leave(Exception):
            pass

        def go(block: list[tuple], sections: int) -> None:
            for one in block:
                if one[0] == "set":
                    _, a, sign, b, c, number = one
                    x, y = values[b], values[c] + number
                    values[a] = (x + y if sign == "+" else x - y if sign == "-" else x * y) & MASK
                elif one[0] in ("when", "either"):
                    holds = values[one[1]] % one[2] == 0
                    if holds:
                        go(one[3], sections)
                    elif one[0] == "either":
                        go(one[4], sections)
                elif one[0] == "loop":
                    for i in range(one[1]):
                        values[one[2]] = (values[one[2]] + i) & MASK
                        go(one[3], sections)
                elif one[0] == "section":
                    with suppress(Leave):
                        go(one[3], sections + 1)
                elif values[one[1]] % one[2] == 0:
                    if one[0] == "give":
                        raise Give
                    if sections:
                        raise Leave

        try:
            go(self.tree, 0)
        except Give:
            return values[0] ^ 1
        return sum(values) & MASK

    def function(self) -> Function:
        """The same."""
        f = Function("define i64 @run(i64 %a0, i64 %a1, i64 %a2)")
        values: list[Variable[Integer]] = [f.variable(Integer(f, f"%a{i}")) for i in range(VARIABLES)]

        def holds(one: tuple):
            return values[one[1]].get().operation("urem", one[2]).equals(0)

        def go(block: list[tuple], sections: list[Loop]) -> None:
            for one in block:
                if one[0] == "set":
                    _, a, sign, b, c, number = one
                    x, y = values[b].get(), values[c].get() + number
                    values[a].set(x + y if sign == "+" else x - y if sign == "-" else x * y)
                elif one[0] in ("when", "either"):
                    with f.when(holds(one)):
                        go(one[3], sections)
                    if one[0] == "either":
                        with f.otherwise():
                            go(one[4], sections)
                elif one[0] == "loop":
                    with f.loop(0, one[1]) as i:
                        values[one[2]].set(values[one[2]].get() + i)
                        go(one[3], sections)
                elif one[0] == "section":
                    with f.section() as section:
                        go(one[3], [*sections, section])
                else:
                    with f.when(holds(one)):
                        if one[0] == "give":
                            f.give(values[0].get().operation("xor", 1))
                        elif sections:
                            sections[-1].leave()

        go(self.tree, [])
        total = values[0].get()
        for one in values[1:]:
            total = total + one.get()
        f.give(total)
        return f


@pytest.mark.exhaustive(keep=0.3)
def test_random_programs_give_what_python_gives():
    seed = int.from_bytes(os.urandom(4), "little")
    print("seed", seed)
    for number in range(100):
        chance = random.Random(seed + number)
        program = Program(chance)
        run = compiled(program.function(), ctypes.c_uint64, *[ctypes.c_uint64] * VARIABLES)
        for _ in range(5):
            values = [chance.randrange(20) for _ in range(VARIABLES)]
            assert run(*values) == program.run(list(values)), f"seed {seed + number}, {values}"


def test_reals_compare_as_ieee_says():
    f = Function("define i64 @run(double %x, double %y)")
    x, y = Real(f, "%x"), Real(f, "%y")
    bits = [x < y, x <= y, x > y, x >= y, x.equals(y), x.equals(x)]
    code = f.count(0)
    for place, bit in enumerate(bits):
        code = code | (bit.to_integer() << place)
    f.give(code)
    run = compiled(f, ctypes.c_uint64, ctypes.c_double, ctypes.c_double)
    for a, b in [(1.0, 2.0), (2.0, 1.0), (1.0, 1.0), (float("nan"), 1.0), (1.0, float("nan")), (0.0, -0.0)]:
        expected = [a < b, a <= b, a > b, a >= b, a == b, a == a]
        assert run(a, b) == sum(int(one) << place for place, one in enumerate(expected))


def test_the_work_of_finding_phis_grows_with_the_number_of_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    """A variable is read behind many loops that leave it alone: each has one phi for it, which is looked at a
    few times."""

    def reads(loops: int) -> int:
        count = 0
        read = Function._read

        def counted(self: Function, *given: object) -> str:
            nonlocal count
            count += 1
            return read(self, *given)

        with monkeypatch.context() as context:
            context.setattr(Function, "_read", counted)
            f = Function("define i64 @run(i64 %a)")
            kept = f.variable(Integer(f, "%a"))
            total = f.variable(Integer(f, "%a"))
            for _ in range(loops):
                with f.loop(0, 3) as i:
                    total.set(total.get() + i)
            f.give(total.get() + kept.get())
            f.text()
        return count

    assert reads(200) <= 2.1 * reads(100)

"""Object code in memory by the short way: the same code as by LLVM's, and LLVM's where it does not fit."""

import ctypes
import math
import platform
import sys

import pytest

from lagrange_cli.native.compilation import machine
from lagrange_cli.native.compilation.llvm import Engine, compile_text, load_with_llvm
from lagrange_cli.native.compilation.object_loader import Image, Unsupported, load_image

SHORT_WAY = sys.platform.startswith("linux") and platform.machine() == "x86_64"
CODE = """
@table = private constant [4 x double] [double 1.5, double 2.5, double 3.5, double 4.5]
define internal double @shifted(double %x) noinline {
  %y = fadd double %x, 1.25
  ret double %y
}
define double @first(double %x) {
  %s = call double @llvm.sin.f64(double %x)
  %y = call double @shifted(double %s)
  ret double %y
}
define double @second(i64 %i, double %x) {
  %p = getelementptr inbounds double, ptr @table, i64 %i
  %a = load double, ptr %p
  %y = call double @atan2(double %a, double %x)
  ret double %y
}
"""


def call(loaded, name, *arguments):
    kinds = [ctypes.c_int64 if isinstance(x, int) else ctypes.c_double for x in arguments]
    return ctypes.CFUNCTYPE(ctypes.c_double, *kinds)(loaded.address(name))(*arguments)


@pytest.mark.parametrize("load", [machine.load, load_with_llvm])
def test_code_calls_itself_its_tables_and_the_c_library(load):
    loaded = load(compile_text(CODE, 1))
    assert call(loaded, "first", 0.5) == math.sin(0.5) + 1.25
    for i in range(4):
        assert call(loaded, "second", i, 0.3) == math.atan2(1.5 + i, 0.3)
    assert loaded.address("third") == 0


def test_the_short_way_is_taken_where_there_is_one():
    assert isinstance(machine.load(compile_text(CODE, 1)), Image if SHORT_WAY else Engine)


def test_code_that_the_short_way_does_not_know_goes_the_long_way():
    writable = CODE.replace("private constant", "internal global")
    code = compile_text(writable, 1)
    with pytest.raises(Unsupported):
        load_image(code)
    assert call(machine.load(code), "second", 2, 0.3) == math.atan2(3.5, 0.3)


@pytest.mark.parametrize("code", [b"", b"\x7fELF", b"\x7fELF\x02\x01" + b"\0" * 58, b"\xcf\xfa\xed\xfe" * 40])
def test_what_is_no_such_code_is_refused(code):
    with pytest.raises(Unsupported):
        load_image(code)


def test_code_cut_short_is_refused():
    code = compile_text(CODE, 1)
    for length in range(0, len(code) - 1, 97):
        with pytest.raises(Unsupported):
            load_image(code[:length])


def test_a_function_that_the_library_lacks_is_refused():
    with pytest.raises(Unsupported):
        extra = "declare double @atan3(double, double)\n" + CODE.replace("atan2", "atan3")
        load_image(compile_text(extra, 1))


def test_code_is_not_writable_once_it_can_run():
    loaded = machine.load(compile_text(CODE, 1))
    if isinstance(loaded, Image):
        place = loaded.address("first")
        with open("/proc/self/maps") as file:
            areas = [line.split() for line in file]
        spans = [([int(end, 16) for end in area[0].split("-")], area[1]) for area in areas]
        (rights,) = [rights for (start, stop), rights in spans if start <= place < stop]
        assert rights[:3] == "r-x"

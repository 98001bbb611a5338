"""The functions of portable programs against mpmath, and their bits on several kinds of processor."""

import math
import struct
import sys
from collections.abc import Callable
from functools import cache

import llvmlite.binding as llvm
import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from lagrange_cli.expression.exact import ExactGraphAlgebra, PortableGraphAlgebra
from lagrange_cli.expression.vocabulary import FUNCTIONS
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE
from lagrange_cli.integrate.program import write_run
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.model.build import build_model
from lagrange_cli.native.functions.portable import portable
from lagrange_cli.native.llvm.declarations import INTRINSICS, complete
from lagrange_cli.native.llvm.vector import Real
from lagrange_cli.spec.read import read_spec
from tests.support.calls import compiled, loaded, over_columns
from tests.support.draws import examples

MP = mpmath.mp.clone()
MP.prec = 1300
ARITY = {**{name: count for name, count in FUNCTIONS.items() if name != "sqrt"}, "pow": 2}
EXACT = {name: getattr(MP, {"pow": "power"}.get(name, name)) for name in ARITY}
BOUND = {"sin": 0.8, "cos": 0.8, "exp": 0.7, "pow": 0.7, "log": 1.0}
"""Units in the last place; of the others, which are computed with twice the digits, 0.501."""


def text(name: str) -> str:
    """A portable program that computes the function of arrays."""
    called = f"llvm.{name}.f64" if name in INTRINSICS else name
    run = over_columns(lambda f, values: [f.call(Real, called, *values)], ARITY[name], 1)
    return portable(run)


@cache
def made(name: str) -> Callable[..., np.ndarray]:
    """It, compiled."""
    return compiled(text(name), 1)


TINY = 2.0**-960
"""Below this, low parts of double-double numbers have few digits, or none."""


def check(name: str, *arguments: float) -> None:
    found = float(made(name)(*([x] for x in arguments))[0, 0])
    exact = EXACT[name](*map(MP.mpf, arguments))
    bound = BOUND.get(name, 0.501)
    if abs(exact) < TINY:
        bound = max(bound, 0.75)
    assert abs(found - exact) <= bound * math.ulp(float(exact)), (found, float(exact))


ANGLES = st.floats(-1e300, 1e300) | st.floats(-30, 30) | st.integers(1, 10**25).map(lambda n: n * math.pi / 2)


@pytest.mark.parametrize("name", ["sin", "cos", "tan"])
@given(ANGLES)
@example(6381956970095103.0 * 2.0**797)  # the double that is nearest to a multiple of pi/2
@example(sys.float_info.max)
@example(2.0**20)
@pytest.mark.exhaustive(keep=0.65)
@examples(75)
def test_angles(name: str, x: float) -> None:
    check(name, x)


@pytest.mark.parametrize("name", ["asin", "acos"])
@given(st.floats(-1, 1))
@pytest.mark.exhaustive(keep=1)
@examples(50)
def test_inverse_functions(name: str, x: float) -> None:
    check(name, x)


@given(st.floats(allow_nan=False, allow_infinity=False))
@pytest.mark.exhaustive(keep=2)
@examples(50)
def test_the_arc_tangent(x: float) -> None:
    check("atan", x)


@given(st.floats(allow_nan=False, allow_infinity=False), st.floats(allow_nan=False, allow_infinity=False))
@pytest.mark.exhaustive(keep=0.85)
@examples(100)
def test_the_angle_of_a_point(y: float, x: float) -> None:
    if (x, y) != (0.0, 0.0) and abs(float(EXACT["atan2"](MP.mpf(y), MP.mpf(x)))) > sys.float_info.min:
        check("atan2", y + 0.0, x)


@pytest.mark.parametrize("name", ["exp", "sinh", "cosh", "tanh"])
@given(st.floats(-709, 709) | st.floats(-1, 1))
@pytest.mark.exhaustive(keep=1)
@examples(75)
def test_exponentials(name: str, x: float) -> None:
    check(name, x)


@given(st.floats(0, exclude_min=True, allow_infinity=False))
@pytest.mark.exhaustive(keep=2)
@examples(50)
def test_the_logarithm(x: float) -> None:
    check("log", x)


@given(st.floats(0, exclude_min=True, allow_infinity=False), st.floats(-50, 50))
@example(6.496498093393153e307, 0.999)  # beyond e^708
@pytest.mark.exhaustive(keep=0.65)
@examples(100)
def test_powers(x: float, y: float) -> None:
    if abs(MP.log(EXACT["pow"](MP.mpf(x), MP.mpf(y)), 2)) < 1022:
        check("pow", x, y)


@given(st.floats(-1e6, 0, exclude_max=True), st.integers(-40, 40))
@pytest.mark.exhaustive(keep=4)
@examples(50)
def test_whole_powers_of_negative_numbers(x: float, n: int) -> None:
    if abs(n * math.log2(-x)) < 1022:
        check("pow", x, n)


SPECIAL = np.array(
    [math.nan, math.inf, -math.inf, 0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 0.5, 5e-324, 1e308, -3.5, 1e4, -1e4, 3.0]
)


@pytest.mark.parametrize("name", ARITY)
def test_special_values_are_those_of_the_c_library(name: str) -> None:
    """But for signs that follow from that of -0."""
    x, y = (axis.ravel() for axis in np.meshgrid(SPECIAL, SPECIAL))
    numpys = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2", "pow": "power"}
    if ARITY[name] == 1:
        given = [SPECIAL]
    else:
        keep = ~(np.signbit(x) & (x == 0)) & ~(np.signbit(y) & (y == 0))
        given = [x[keep], y[keep]]
    with np.errstate(all="ignore"):
        known = getattr(np, numpys.get(name, name))(*given)
    np.testing.assert_array_max_ulp(made(name)(*given)[0], known, 2)


def emitted(program: str, triple: str, cpu: str, features: str, optimize: int = 2) -> bytes:
    """The object code for a processor, of which there need be none here."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(triple).create_target_machine(
        cpu=cpu, features=features, opt=optimize, jit=True
    )
    code: bytes = machine.emit_object(llvm.parse_assembly(complete(program)))
    return code


def undefined(code: bytes) -> set[str]:
    """The functions of libraries that object code calls: the names of its undefined symbols (ELF of 64 bits,
    lowest byte first)."""
    (start,) = struct.unpack_from("<Q", code, 40)
    width, count = struct.unpack_from("<HH", code, 58)
    sections = [struct.unpack_from("<IIQQQQIIQQ", code, start + i * width) for i in range(count)]
    found = set()
    for section in sections:
        if section[1] == 2:  # the table of symbols
            texts, (offset, size) = sections[section[6]][4], section[4:6]
            for name, _, _, place, _, _ in struct.iter_unpack("<IBBHQQ", code[offset : offset + size]):
                if not place and name:
                    found.add(code[texts + name : code.index(b"\0", texts + name)].decode())
    return found


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("optimize", [0, 2])
@pytest.mark.parametrize(
    ("triple", "features", "needed"),
    [
        ("aarch64-unknown-linux-gnu", "", set()),
        ("x86_64-unknown-linux-gnu", "", {"fma", "floor"}),
        ("x86_64-unknown-linux-gnu", "+fma,+sse4.1", set()),
    ],
)
def test_no_function_of_the_c_library_is_called(
    triple: str, features: str, needed: set[str], optimize: int
) -> None:
    """But fma and floor, where the processor has none: their results are defined."""
    for name in ARITY:
        assert undefined(emitted(text(name), triple, "", features, optimize)) <= needed


def test_what_is_called_is_found() -> None:
    """The test above would see the C library's sine."""
    program = over_columns(lambda f, values: [f.function("sin", *values)], 1, 1)
    assert undefined(emitted(program, "aarch64-unknown-linux-gnu", "", "")) == {"sin"}


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("optimize", [0, 2])
@pytest.mark.parametrize("name", ARITY)
def test_the_simplest_processor_computes_the_same_bits(name: str, optimize: int) -> None:
    simple = loaded(emitted(text(name), llvm.get_process_triple(), "", "", optimize), 1)
    random = np.random.default_rng(20260102)
    x = np.concatenate(
        [random.uniform(-1, 1, 500), random.normal(0, 1e3, 500), 10 ** random.uniform(4, 300, 99)]
    )
    given = [x, random.permutation(x)][: ARITY[name]]
    assert simple(*given).tobytes() == made(name)(*given).tobytes()


SYSTEM = b"""
parameters: {k: 0.3}
coordinates: {x: {initial: 1}, y: {initial: 1}}
lagrangian: (2 + cos(x))*x_dot**2/2 + y_dot**2/2 + sin(x - y)*x_dot*y_dot - exp(x)*(2 + y**2)**k - tanh(y)
"""


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("precision", [DOUBLE, DOUBLE_DOUBLE])
@pytest.mark.parametrize("triple", ["aarch64-unknown-linux-gnu", "x86_64-unknown-linux-gnu"])
def test_nor_by_the_stepper(triple: str, precision: str) -> None:
    """A whole program calls only what fills and copies memory."""
    algebra = PortableGraphAlgebra() if precision == DOUBLE else ExactGraphAlgebra()
    residual = derive(build_model(read_spec(SYSTEM, "test", {}), algebra))
    outputs = frozenset({"q", "v", "p", "h", "ledger", "action"})
    program, _ = write_run(
        residual, Compilation(method="taylor", tolerance=1e-15, outputs=outputs, precision=precision)
    )
    made = portable(program.text)
    assert "fmuladd" not in made
    features = "+fma,+sse4.1" if triple.startswith("x86") else ""
    assert undefined(emitted(made, triple, "", features)) <= {"memset", "memcpy"}

"""The elementary functions as LLVM IR of our own, for one double or for eight at a time.

LLVM computes the sine of a vector by one call of the C library per lane. These functions compute all lanes
together, sine and cosine share their reduction, and the low part of a compensated argument is taken in.
In an emitter's function

    sine, cosine = sin_cos(emitter, x, low, lanes=8)

writes a call; x and low are operands, of type double for ``lanes=1``, else vectors; constants of one
double stand for all lanes, None for 0. So do ``exponential``, ``logarithm`` and ``power``, and
``emit_function`` for any function of the language.
``definitions(text)`` returns the functions that a program's text calls, to be appended to it.

Every number of lanes gives the same bits, and within a formula's range so should every processor: each
operation is rounded as IEEE 754 says. Where a lane is not in that range (an angle beyond 10^6, an infinity,
not-a-number) all are computed one by one, by the version for one double, which asks the C library for such
arguments. The functions that have no formula here (tan, atan2, ..) are the C library's, one lane after the
other. The sign of a sine that is zero is lost: sin(-0) is 0.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from lagrange_cli.native.functions import formulas
from lagrange_cli.native.llvm.declarations import LIBRARY
from lagrange_cli.native.llvm.text import Operand, Value, operand
from lagrange_cli.native.llvm.vector import Body, Real, kind, suffix
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Function:
    """A function: its formula, if any, and what computes it for one double where that does not hold."""

    arguments: int
    results: int
    formula: Callable[..., formulas.Results] | None
    beyond: Callable[..., list[Real]]


FUNCTIONS = {
    "sin_cos": Function(2, 2, formulas.sine_and_cosine, formulas.library_sine_and_cosine),
    "exp": Function(2, 1, formulas.exponential, formulas.library_exponential),
    "log": Function(1, 1, formulas.logarithm, formulas.library_logarithm),
    "pow": Function(2, 1, formulas.power, formulas.library_power),
    **{name: Function(count, 1, None, formulas.library(name)) for name, count in LIBRARY.items()},
}
ATTRIBUTES = 'nounwind noinline "min-legal-vector-width"="512" "prefer-vector-width"="512"'


def sin_cos(emitter: Emitter, x: Value, low: Value = None, lanes: int = 1) -> tuple[Operand, Operand]:
    """sin(x + low) and cos(x + low); ``low`` is at most some units in the last place of x."""
    sine, cosine = call(emitter, "sin_cos", [x, low], lanes)
    return sine, cosine


def exponential(emitter: Emitter, x: Value, low: Value = None, lanes: int = 1) -> Operand:
    """e^(x + low); ``low`` is at most some units in the last place of x."""
    return call(emitter, "exp", [x, low], lanes)[0]


def logarithm(emitter: Emitter, x: Value, lanes: int = 1) -> Operand:
    """ln x."""
    return call(emitter, "log", [x], lanes)[0]


def power(emitter: Emitter, x: Value, y: Value, lanes: int = 1) -> Operand:
    """x^y."""
    return call(emitter, "pow", [x, y], lanes)[0]


def emit_function(emitter: Emitter, name: str, arguments: Sequence[Value], lanes: int = 1) -> Operand:
    """One of the expression language's functions. (Where sine and cosine are needed, use ``sin_cos``.)"""
    if name in ("sin", "cos"):
        return sin_cos(emitter, arguments[0], None, lanes)[name == "cos"]
    if name == "sqrt":
        vector = kind("double", lanes)
        return emitter.define(
            f"call {vector} @llvm.sqrt.{suffix(lanes)}({vector} {written(arguments[0], lanes)})"
        )
    given = [*arguments, None] if name == "exp" else arguments
    return call(emitter, name, given, lanes)[0]


def call(emitter: Emitter, name: str, arguments: Sequence[Value], lanes: int) -> list[Operand]:
    """The results of a call of one of ``FUNCTIONS``."""
    return write_call(emitter, name, [written(a, lanes) for a in arguments], lanes)


def written(value: Value, lanes: int) -> Operand:
    """A value as an instruction needs it: constants in every lane, 0 written out."""
    one = operand(value)
    return f"<{', '.join([f'double {one}'] * lanes)}>" if lanes > 1 and one.startswith("0x") else one


def definitions(text: str) -> str:
    """The functions that ``text`` calls, and the declarations that they need and it lacks."""
    called = set(re.findall(rf"@({'|'.join(FUNCTIONS)})\.(\d+)\(", text))
    called |= {(name, "1") for name, _ in called}
    parts: list[str] = []
    declared: dict[str, str] = {}
    for name, lanes in sorted(called):
        body = Body(int(lanes))
        parts.append(definition(body, name))
        declared.update(body.declared)
    for lanes in re.findall(r"@llvm\.sqrt\.v(\d+)f64\(", text):
        vector = kind("double", int(lanes))
        declared[f"llvm.sqrt.v{lanes}f64"] = f"declare {vector} @llvm.sqrt.v{lanes}f64({vector})\n"
    present = set(re.findall(r"^ *declare .*@([\w.]+)\(", text, re.MULTILINE))
    return "".join([line for name, line in declared.items() if name not in present] + parts)


def definition(body: Body, name: str) -> str:
    """The text of one function."""
    function = FUNCTIONS[name]
    arguments = [Real(body, f"%a{i}") for i in range(function.arguments)]
    if function.formula is None:
        body.lines.append("  br label %beyond\nbeyond:")
    else:
        condition, made = function.formula(body, *arguments)
        body.lines.append(f"  br i1 {body.all(condition).name}, label %plain, label %beyond\nplain:")
        give_back(body, made)
        body.lines.append("beyond:")
    if body.lanes == 1:
        give_back(body, function.beyond(body, *arguments))
    else:
        one_by_one(body, name, arguments)
    head = ", ".join(f"{body.real} {a.name}" for a in arguments)
    type, lines = result_type(name, body.lanes), "\n".join(body.lines)
    return f"define internal {type} @{name}.{body.lanes}({head}) {ATTRIBUTES} {{\n{lines}\n}}\n"


def one_by_one(body: Body, name: str, arguments: list[Real]) -> None:
    """Compute each lane by the version for one double, and return."""
    real, results = body.real, range(FUNCTIONS[name].results)
    body.lines.append("  br label %lane\nlane:\n  %i = phi i64 [ 0, %beyond ], [ %next, %lane ]")
    body.lines += [f"  %r{k} = phi {real} [ poison, %beyond ], [ %n{k}, %lane ]" for k in results]
    lane = [body.define(f"extractelement {real} {a.name}, i64 %i") for a in arguments]
    for k, one in enumerate(write_call(body, name, lane, 1)):
        body.lines.append(f"  %n{k} = insertelement {real} %r{k}, double {one}, i64 %i")
    body.lines.append(f"  %next = add i64 %i, 1\n  %more = icmp ult i64 %next, {body.lanes}")
    body.lines.append("  br i1 %more, label %lane, label %done\ndone:")
    give_back(body, [Real(body, f"%n{k}") for k in results])


def write_call(writer: Emitter | Body, name: str, arguments: Sequence[Operand], lanes: int) -> list[Operand]:
    """A call, and its results taken apart."""
    type = result_type(name, lanes)
    listed = ", ".join(f"{kind('double', lanes)} {a}" for a in arguments)
    made = writer.define(f"call {type} @{name}.{lanes}({listed})")
    return [writer.define(f"extractvalue {type} {made}, {k}") for k in range(FUNCTIONS[name].results)]


def give_back(body: Body, results: list[Real]) -> None:
    """Return them."""
    type = f"{{ {', '.join([body.real] * len(results))} }}"
    made = "poison"
    for k, one in enumerate(results):
        made = body.define(f"insertvalue {type} {made}, {body.real} {one.name}, {k}")
    body.lines.append(f"  ret {type} {made}")


def result_type(name: str, lanes: int) -> str:
    """The type of a function's results together."""
    return f"{{ {', '.join([kind('double', lanes)] * FUNCTIONS[name].results)} }}"

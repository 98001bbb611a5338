"""Declarations of what programs call: LLVM's functions, and the C library's."""

from __future__ import annotations

from lagrange_cli.native.interface import LANES

INTRINSICS = {"sin": 1, "cos": 1, "exp": 1, "log": 1, "pow": 2, "sqrt": 1, "fabs": 1, "floor": 1}
LIBRARY = {
    "tan": 1, "asin": 1, "acos": 1, "atan": 1, "sinh": 1, "cosh": 1, "tanh": 1, "atan2": 2,
}  # fmt: skip

DECLARATIONS = "\n".join(
    [f"declare double @llvm.{n}.f64({', '.join(['double'] * a)})" for n, a in INTRINSICS.items()]
    + [f"declare double @{n}({', '.join(['double'] * a)}) memory(none)" for n, a in LIBRARY.items()]
    + ["declare double @llvm.fmuladd.f64(double, double, double)"]
)

GLOBALS = "\n".join(
    [
        *(
            f"declare {kind} @llvm.{name}.{tag}({', '.join([kind] * count)})"
            for name, count in (("fmuladd", 3), ("fma", 3), ("fabs", 1), ("maxnum", 2), ("minnum", 2))
            for kind, tag in (("double", "f64"), *((f"<{n} x double>", f"v{n}f64") for n in (2, 4, LANES)))
            if (name, tag) not in (("fmuladd", "f64"), ("fabs", "f64"))
        ),
        *(
            f"declare double @llvm.vector.reduce.{name}.v{n}f64({first}<{n} x double>)"
            for name, first in (("fadd", "double, "), ("fmax", ""))
            for n in (2, 4, LANES)
        ),
        *(f"declare i1 @llvm.vector.reduce.or.v{n}i1(<{n} x i1>)" for n in (2, 4, LANES)),
        "declare i8 @llvm.ctpop.i8(i8)",
    ]
)

MORE = "\n".join(f"declare double @llvm.{name}.f64(double)" for name in ("log2", "exp2"))
"""What double-double programs call besides."""

ATTRIBUTES = 'attributes #0 = { nounwind "min-legal-vector-width"="512" "prefer-vector-width"="512" }'

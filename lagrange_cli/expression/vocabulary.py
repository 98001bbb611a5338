"""The words of the expression language: operators, functions with their arity, constants, reserved names."""

from __future__ import annotations

from collections.abc import Iterable

OR, AND, NOT, COMPARISON, SUM, PRODUCT, SIGN, POWER = range(1, 9)
LEVELS: dict[str, int] = {
    "or": OR, "and": AND, "==": COMPARISON, "!=": COMPARISON, "<": COMPARISON, "<=": COMPARISON,
    ">": COMPARISON, ">=": COMPARISON, "+": SUM, "-": SUM, "*": PRODUCT, "/": PRODUCT, "//": PRODUCT,
    "%": PRODUCT, "**": POWER,
}  # fmt: skip
"""The operators, and how tightly each binds, as in Python."""

FUNCTIONS: dict[str, int] = {
    "sin": 1, "cos": 1, "tan": 1, "asin": 1, "acos": 1, "atan": 1, "atan2": 2,
    "sinh": 1, "cosh": 1, "tanh": 1, "exp": 1, "log": 1, "sqrt": 1,
}  # fmt: skip
"""Scalar functions and how many arguments each takes."""

VECTOR_FUNCTIONS: dict[str, int] = {"dot": 2, "cross": 2, "norm": 1}
"""Functions of vectors; ``dot`` and ``norm`` give scalars, ``cross`` a vector."""

NON_SMOOTH: dict[str, int] = {"abs": 1, "sign": 1, "min": 2, "max": 2, "where": 3}
"""Functions with kinks and jumps; the first argument of ``where`` is a condition."""

CALLABLE: dict[str, int] = FUNCTIONS | NON_SMOOTH | VECTOR_FUNCTIONS
"""Everything that may stand before a parenthesis, and how many arguments it takes."""

ANY_NUMBER = frozenset({"min", "max"})
"""What takes so many arguments or more."""

KINKED = "where", "sign", "abs", "min", "max", "sqrt", "norm"
"""Functions that may have kinks."""
FAMILY_WORDS = frozenset({"sum", "range"})
"""Words of indexed families."""

CONSTANTS = frozenset({"pi"})
TIME = "t"
RESERVED = frozenset(CALLABLE) | FAMILY_WORDS | CONSTANTS | {TIME}
"""Names that a system file cannot declare."""

COMPONENTS = ("x", "y", "z")
VELOCITY_COMPONENTS = ("vx", "vy", "vz")
ACCELERATION_COMPONENTS = ("ax", "ay", "az")
"""As ``equations`` prints them; system files do not have them."""
AXES_COMPONENTS = tuple(f"R{i}{j}" for i in "123" for j in "123")
"""Components of a rigid body's axes: ``R12`` is the x component of its second axis."""
AXES_RATES = tuple(f"v{name}" for name in AXES_COMPONENTS)
SPACE_SPIN, BODY_SPIN = ("wx", "wy", "wz"), ("w1", "w2", "w3")
"""Its angular velocity along the axes of space, and along its own."""
MOVING_COMPONENTS = (*VELOCITY_COMPONENTS, *AXES_RATES, *SPACE_SPIN, *BODY_SPIN)
"""The components that depend on velocities."""
BODY_COMPONENTS = (*AXES_COMPONENTS, *AXES_RATES, *SPACE_SPIN, *BODY_SPIN)
"""The components of a body that a particle does not have."""
MULTIPLIER = "multiplier"
"""``rod.multiplier`` is the Lagrange multiplier of a constraint."""
POINT = "at"
"""``plate.at(a, b, c)`` is a point of a body."""
VELOCITY_SUFFIX = "_dot"
ACCELERATION_SUFFIX = "_ddot"


def velocity_name(coordinate: str) -> str:
    """The name of a coordinate's velocity: ``theta_dot`` for ``theta``, ``theta_dot[1]`` for ``theta[1]``."""
    return suffixed(coordinate, VELOCITY_SUFFIX)


def acceleration_name(coordinate: str) -> str:
    """The name of a coordinate's acceleration: ``theta_ddot`` for ``theta``."""
    return suffixed(coordinate, ACCELERATION_SUFFIX)


def dotted(name: str) -> tuple[str, int]:
    """A name without its ending ``_dot`` or ``_ddot``, and the number of dots this ending stands for."""
    base, bracket, index = name.partition("[")
    for suffix, dots in ((ACCELERATION_SUFFIX, 2), (VELOCITY_SUFFIX, 1)):
        if base.endswith(suffix) and base != suffix:
            return base.removesuffix(suffix) + bracket + index, dots
    return name, 0


def suffixed(name: str, suffix: str) -> str:
    """The name with a suffix before the index that it may have."""
    base, bracket, index = name.partition("[")
    return base + suffix + bracket + index


def member_name(identifier: str, indices: Iterable[object]) -> str:
    """The name of a member of a family: ``bob[2].x`` for ``bob.x`` and 2, ``u[1,2]`` for ``u`` and 1, 2."""
    base, dot, component = identifier.partition(".")
    return f"{base}[{','.join(map(str, indices))}]{dot}{component}"


def family_name(name: str) -> str:
    """The name without component and index: ``bob`` for ``bob[2].x``."""
    return name.partition("[")[0].partition(".")[0]

"""How a rigid body stands and turns, over any algebra.

The columns of R are the body's axes in space. Angles a, b, c about the axes i, j, k, each as turned so far,
make R = R_i(a) R_j(b) R_k(c), with the angular velocity (H. Goldstein, Classical Mechanics, 3rd ed.,
sec. 4.9)

    omega = da/dt e_i + db/dt R_i e_j + dc/dt R_i R_j e_k.

A quaternion q of length 1 makes R v = q v q*, and omega = 2 Im(dq/dt q*) in space, 2 Im(q* dq/dt) in the
body. For a matrix omega follows from the axes: omega_1 = e_3 . de_2/dt.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Generic

from lagrange_cli.expression.algebra import Algebra, E
from lagrange_cli.expression.operations import cross
from lagrange_cli.expression.vocabulary import AXES_COMPONENTS, AXES_RATES, BODY_SPIN, SPACE_SPIN
from lagrange_cli.records import dataclass

Matrix = tuple[tuple[Any, ...], ...]
"""Three rows of three."""


@dataclass(frozen=True)
class Turning(Generic[E]):
    """``axes`` e_1, e_2, e_3 in space and their ``rates``, and the angular velocity in components along the
    axes of space and of the body."""

    axes: tuple[tuple[E, ...], ...]
    rates: tuple[tuple[E, ...], ...]
    in_space: tuple[E, ...]
    in_body: tuple[E, ...]

    def component(self, name: str) -> E:
        """One of ``vocabulary.BODY_COMPONENTS``."""
        if name in SPACE_SPIN:
            return self.in_space[SPACE_SPIN.index(name)]
        if name in BODY_SPIN:
            return self.in_body[BODY_SPIN.index(name)]
        moving = name in AXES_RATES
        row, column = divmod((AXES_RATES if moving else AXES_COMPONENTS).index(name), 3)
        return (self.rates if moving else self.axes)[column][row]


def turning(
    algebra: Algebra[E], form: str, sequence: str, given: Sequence[E], rate: Callable[[E], E]
) -> Turning[E]:
    """How a body turns whose orientation is ``given`` in this form; ``rate`` is d/dt."""
    if form == "euler":
        matrix, in_space, in_body = by_angles(algebra, sequence, given, rate)
    elif form == "quaternion":
        matrix, in_space, in_body = by_quaternion(algebra, given, rate)
    else:
        matrix = tuple(tuple(given[3 * i : 3 * i + 3]) for i in range(3))
        in_space = in_body = ()
    axes = transposed(matrix)
    rates = tuple(tuple(map(rate, axis)) for axis in axes)
    if not in_body:
        in_body = tuple(dot(algebra, axes[i - 1], rates[i - 2]) for i in range(3))
        in_space = times(algebra, matrix, in_body)
    return Turning(axes, rates, in_space, in_body)


def by_angles(
    algebra: Algebra[E], sequence: str, given: Sequence[E], rate: Callable[[E], E]
) -> tuple[Matrix, tuple[Any, ...], tuple[Any, ...]]:
    """R and omega of three angles about the axes of ``sequence``."""
    numbers = [algebra.number(text) for text in "01"]
    turns = [elementary(algebra, "xyz".index(axis), angle) for axis, angle in zip(sequence, given)]
    units = [tuple(numbers[int(axis == other)] for other in "xyz") for axis in sequence]
    speeds = [rate(angle) for angle in given]
    a, b, c = turns
    about = units[0], times(algebra, a, units[1]), times(algebra, a, times(algebra, b, units[2]))
    b_back, c_back = transposed(b), transposed(c)
    within = (
        times(algebra, c_back, times(algebra, b_back, units[0])),
        times(algebra, c_back, units[1]),
        units[2],
    )
    spins = [tuple(dot(algebra, speeds, parts) for parts in zip(*one)) for one in (about, within)]
    return product(algebra, product(algebra, a, b), c), spins[0], spins[1]


def elementary(algebra: Algebra[E], axis: int, angle: E) -> Matrix:
    """The rotation by an angle about an axis of space."""
    cosine: Any = algebra.function("cos", [angle])
    sine: Any = algebra.function("sin", [angle])
    rows: list[list[Any]] = [[algebra.number("1" if i == j else "0") for j in range(3)] for i in range(3)]
    j, k = (axis + 1) % 3, (axis + 2) % 3
    rows[j][j] = rows[k][k] = cosine
    rows[j][k], rows[k][j] = -sine, sine
    return tuple(map(tuple, rows))


def by_quaternion(
    algebra: Algebra[E], given: Sequence[Any], rate: Callable[[E], E]
) -> tuple[Matrix, tuple[Any, ...], tuple[Any, ...]]:
    """R and omega of a quaternion, its scalar first; both are of degree 2 in it."""
    two: Any = algebra.number("2")
    w, *vector = given
    fast, *moving = (rate(one) for one in given)
    x, y, z = vector
    matrix = (
        (w * w + x * x - y * y - z * z, two * (x * y - w * z), two * (x * z + w * y)),
        (two * (x * y + w * z), w * w - x * x + y * y - z * z, two * (y * z - w * x)),
        (two * (x * z - w * y), two * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    across = cross(vector, moving)
    common = [w * u - fast * p for u, p in zip(moving, vector)]
    in_space = tuple(two * (one + c) for one, c in zip(common, across))
    in_body = tuple(two * (one - c) for one, c in zip(common, across))
    return matrix, in_space, in_body


def dot(algebra: Algebra[E], a: Sequence[Any], b: Sequence[Any]) -> Any:
    """a . b."""
    return algebra.total([x * y for x, y in zip(a, b)])


def times(algebra: Algebra[E], matrix: Matrix, vector: Sequence[Any]) -> tuple[Any, ...]:
    """A matrix by a vector."""
    return tuple(dot(algebra, row, vector) for row in matrix)


def product(algebra: Algebra[E], a: Matrix, b: Matrix) -> Matrix:
    """A matrix by another."""
    columns = transposed(b)
    return tuple(tuple(dot(algebra, row, column) for column in columns) for row in a)


def transposed(matrix: Matrix) -> Matrix:
    """Rows for columns."""
    return tuple(zip(*matrix))

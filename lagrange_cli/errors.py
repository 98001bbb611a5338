"""Every error a user can cause, and the exit status each one ends with.

LagrangeError
├── UsageError       2    an option, its value, a --set of an unknown name
│   └── MissingPackage    what an extra would have installed
├── SpecError        3    the system file is wrong: one Problem or many, each with its place
│   └── TooLargeSystem    it is right, but too large for what was asked
├── SingularCoordinate 3  found while deriving; the command line gives it its place
├── InfiniteForce    3    likewise
├── TooLarge         3    likewise, the file as a whole
├── NotReal          3    likewise, the file as a whole
├── MotionError      4    the motion could not be started or continued
└── FileError        5    a file could not be read or written

Foreign exceptions (yaml, h5py, OSError) are translated once, where they occur, with ``from exc``;
``cli.main`` is the one place that turns these into messages and exits.
"""

from __future__ import annotations

from typing import Any

from lagrange_cli.records import dataclass


class LagrangeError(Exception):
    """Root of every error of this project; ``exit_code`` is the process's exit status."""

    exit_code = 1

    def __reduce__(self) -> tuple[Any, ...]:
        return restored, (type(self), self.args, self.__dict__)  # as it is, also from another process


def restored(kind: type[LagrangeError], args: tuple[Any, ...], fields: dict[str, Any]) -> LagrangeError:
    """An error as it was when it was pickled."""
    error = kind.__new__(kind, *args)
    error.__dict__.update(fields)
    return error


class UsageError(LagrangeError):
    """The command line asks for something that does not exist or makes no sense."""

    exit_code = 2


class NotDefined(UsageError):
    """An output does not exist, or not all of it; the message says why."""


class MissingPackage(UsageError):
    """``what`` needs a package that is not installed: it comes with an extra of ours."""

    def __init__(self, what: str, package: str, extra: str) -> None:
        super().__init__(f"{what} needs {package}: pip install 'lagrange-cli[{extra}]'")


class MotionError(LagrangeError):
    """The motion could not be started or continued; in a Python program ``result`` has the motion so far."""

    exit_code = 4
    result: Any = None


class Interrupted(KeyboardInterrupt):
    """A Python program was interrupted while it followed motions; ``result`` has the results so far."""

    result: Any = None


class LagrangeWarning(UserWarning):
    """The text of the warning on standard error."""


class FileError(LagrangeError):
    """A file could not be read or written."""

    exit_code = 5


@dataclass(frozen=True, order=True)
class Problem:
    """One mistake in a system file: where it is, what it is, and a way out.

    ``line`` and ``column`` count from 1 (0: the file as a whole); ``length`` is the number of
    characters to underline; ``excerpt`` is the source line itself.
    """

    line: int
    column: int
    message: str
    length: int = 1
    hint: str = ""
    excerpt: str = ""

    def render(self, filename: str) -> str:
        """The message with its place, the excerpt and a caret, as printed on standard error."""
        if self.line == 0:
            head = f"{filename}: {self.message}"
            return f"{head}\n  {self.hint}" if self.hint else head
        lines = [f"{filename}:{self.line}:{self.column}: {self.message}"]
        excerpt, column = clip(self.excerpt, self.column)
        number = f"{self.line:>2}"
        carets = "^" * max(1, min(self.length, len(excerpt) - column + 1))
        lines.append(f"  {number} | {excerpt}")
        pointer = f"  {' ' * len(number)} | {' ' * (column - 1)}{carets}"
        lines.append(f"{pointer} {self.hint}" if self.hint else pointer)
        return "\n".join(lines)


class SpecError(LagrangeError):
    """The system file is wrong; ``problems`` holds every mistake found, in file order."""

    exit_code = 3

    def __init__(self, filename: str, problems: list[Problem]) -> None:
        self.filename = filename
        self.problems = tuple(sorted(problems))
        super().__init__("\n".join(problem.render(filename) for problem in self.problems))


class TooLargeSystem(SpecError):
    """The system file is right, but too large for what was asked."""


class SingularCoordinate(LagrangeError):
    """No kinetic energy depends on the velocity of any of the ``coordinates``: the mass matrix has rows of
    zeros. Or it does not depend on all of them ``together``. ``messages`` has a sentence for each mistake."""

    exit_code = 3

    def __init__(self, coordinates: list[str], *, together: bool = False) -> None:
        self.together = together
        self.messages = {one: f"no kinetic energy depends on the velocity of '{one}'" for one in coordinates}
        if together:
            named = f"{', '.join(coordinates[:-1])} and {coordinates[-1]}"
            message = "the mass matrix is singular in every state: the kinetic energy does not depend on the "
            self.messages = {coordinates[0]: f"{message}velocities of {named} separately"}
        super().__init__(self.messages[coordinates[0]])


class NotLinear(LagrangeError):
    """The nonholonomic ``constraint`` is not linear in the velocities."""

    exit_code = 3

    def __init__(self, constraint: str) -> None:
        self.constraint = constraint
        super().__init__(f"nonholonomic constraint '{constraint}' is not linear in the velocities")


class Spinning(LagrangeError):
    """The ``body``, a thin rod, has an undetermined rotation about its own axis, or ``only`` this
    rotation."""

    exit_code = 3

    def __init__(self, body: str, only: bool = False) -> None:
        self.body, self.only = body, only
        what = "nothing else determines its rotation about that axis"
        if only:
            what = "this orientation turns it about that axis only, so that its rotation has no energy"
        super().__init__(f"body '{body}' has no moment of inertia about its own axis, and {what}")


class Undetermined(LagrangeError):
    """Forces or events use the multiplier of the ``constraint``, which depends on others."""

    exit_code = 3

    def __init__(self, constraint: str) -> None:
        self.constraint = constraint
        reason = "constraints depend on one another, so that only the sum of their forces is known"
        super().__init__(f"the multiplier of constraint '{constraint}' is not determined: {reason}")


class InfiniteForce(LagrangeError):
    """The energy that ``key`` declares has a jump, ``when`` certain conditions hold; or the position or the
    constraint ``name`` of this section has one, or a ``kink``, where velocities jump, or it changes in a
    ``rush``, infinitely fast. Events must not jump either: they are where an expression becomes 0."""

    exit_code = 3

    def __init__(
        self, key: str, when: str = "", *, name: str = "", kink: bool = False, rush: bool = False
    ) -> None:
        self.key, self.name, self.kink = key, name, kink or rush
        kind = {"embedding": "the position of", "events": "event"}.get(key, "constraint")
        what = f"{kind} '{name}'"
        fault = "a kink, where velocities jump and the force is infinite"
        fault = fault if kink else "a jump, where the force is infinite"
        fault = "a time at which velocities are infinite, and so is the force" if rush else fault
        fault = "an expression that jumps instead of passing through 0" if key == "events" else fault
        super().__init__(f"{when}{what if name else repr(key)} has {fault}")


class Underivable(LagrangeError):
    """No equations of a system can be given; ``hint`` is the way out."""

    exit_code = 3

    def __init__(self, message: str, hint: str) -> None:
        self.message, self.hint = message, hint
        super().__init__(f"{message}; {hint}")


class TooLarge(Underivable):
    """The equations of a system take more memory and time than a limit allows."""


class TooLong(TooLarge):
    """An expression is too long to print."""


class TooManyNumbers(TooLarge):
    """What steps work on takes more memory than a limit allows, whatever the longest expression is."""


class NotReal(Underivable):
    """The equations of a system contain numbers that are not real, or beyond doubles."""


class BeyondDoubles(NotReal):
    """The numbers of a system multiply to one that is larger than any double."""

    def __init__(self) -> None:
        message = "numbers multiply to more than the largest double, about 1.8e308"
        super().__init__(message, "choose units in which they are closer to 1")


def clip(excerpt: str, column: int, width: int = 100) -> tuple[str, int]:
    """A window of a long source line around ``column``, and the column within that window."""
    text = excerpt.replace("\t", " ")
    if len(text) <= width:
        return text, min(column, len(text) + 1)
    start = max(0, min(column - 1 - width // 2, len(text) - width))
    return text[start : start + width], column - start

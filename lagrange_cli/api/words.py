"""The messages of errors in the words of a Python program: arguments in place of options."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, TypeVar

from lagrange_cli.errors import FileError, MotionError, SpecError, UsageError
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from typing import ParamSpec

    P = ParamSpec("P")
R = TypeVar("R")

_OPTION = re.compile(r"(?<![^\s'(:])--([a-z]+(?:-[a-z]+)*)(?!\w)")
_TO_ADD = re.compile(r"\b(add|leave out) --([a-z]+(?:-[a-z]+)*) ([^\s,;:]+)")
_TO_SET = re.compile(r"\bor --set ([^\s=]+)=([^\s,;:]+)")
_ARGUMENTS = {"from": "begin", "to": "end", "output": "the name"}
"""Arguments that are not called like their options."""
_WAYS = (
    ("--force replaces it, --output names another", "force=True replaces it, or give another name"),
    ("give --output another name", "give another name"),
    ("give --output a name", "give a name"),
)


def in_python(function: Callable[P, R]) -> Callable[P, R]:
    """A function whose errors name its arguments, as ``stop`` for ``--stop``."""

    @wraps(function)
    def spoken(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return function(*args, **kwargs)
        except (UsageError, FileError, MotionError) as error:
            error.args = (python_words(str(error)), *error.args[1:])
            raise
        except SpecError as error:
            problems = [
                replace(one, message=python_words(one.message), hint=python_words(one.hint))
                for one in error.problems
            ]
            error.problems = tuple(problems)
            error.args = ("\n".join(one.render(error.filename) for one in problems),)
            raise

    return spoken


def python_words(message: str) -> str:
    """``add stop=10`` for ``add --stop 10``, and ``stop abc: unknown name`` for ``--stop abc: ...``."""
    for option, argument in _WAYS:
        message = message.replace(option, argument)
    message = _TO_ADD.sub(lambda found: f"{found[1]} {_argument(found[2])}={found[3]}", message)
    message = _TO_SET.sub(r"or set={'\1': \2}", message)
    return _OPTION.sub(lambda found: _argument(found[1]), message)


def _argument(option: str) -> str:
    return _ARGUMENTS.get(option, option.replace("-", "_"))

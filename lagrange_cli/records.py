"""The part of ``dataclasses`` that this package uses, without the code that it makes as a module loads.

``dataclasses`` writes and compiles half a dozen functions for every class, which takes a third of a
millisecond each time, and a short run meets fifty classes. Here all classes share the same functions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeVar, overload

T = TypeVar("T")
C = TypeVar("C", bound=type)

if TYPE_CHECKING:
    from typing_extensions import dataclass_transform
else:

    def dataclass_transform(**_):
        """What tells type checkers; Python has it from 3.11 on."""
        return lambda function: function


SET = object.__setattr__


class _Nothing:
    """No default."""


class Field:
    """How a field is treated: its default or what makes one, and whether it is shown and compared."""

    __slots__ = ("compare", "default", "factory", "repr")

    def __init__(self, default: object, factory: Callable[[], object] | None, repr: bool, compare: bool):
        self.default, self.factory, self.repr, self.compare = default, factory, repr, compare


def field(
    *,
    default: Any = _Nothing,
    default_factory: Callable[[], Any] | None = None,
    repr: bool = True,
    compare: bool = True,
) -> Any:
    """A field with more properties than a default, as in ``dataclasses``."""
    return Field(default, default_factory, repr, compare)


@overload
def dataclass(cls: C, /) -> C: ...
@overload
def dataclass(*, frozen: bool = False, order: bool = False, eq: bool = True) -> Callable[[C], C]: ...
@dataclass_transform(field_specifiers=(field,))
def dataclass(cls: Any = None, /, *, frozen: bool = False, order: bool = False, eq: bool = True) -> Any:
    """The class with ``__init__``, ``__eq__``, ``__repr__``; if ``frozen``, it cannot change and has a hash.

    ``order`` compares as tuples of the fields do. Without ``eq`` a record equals nothing but itself.
    """
    if cls is None:
        return lambda one: dataclass_of(one, frozen, order, eq)
    return dataclass_of(cls, frozen, order, eq)


def dataclass_of(cls: Any, frozen: bool, order: bool, eq: bool) -> Any:
    """The class itself, with what makes it a record."""
    fields: dict[str, Field] = {}
    for base in reversed(cls.__mro__[1:]):
        fields |= vars(base).get("__record_fields__", {})
    for name in cls.__annotations__:
        given = vars(cls).get(name, _Nothing)
        fields[name] = given if isinstance(given, Field) else Field(given, None, True, True)
        if isinstance(given, Field):
            delattr(cls, name)
    cls.__record_fields__ = fields
    cls.__record_plain__ = not hasattr(cls, "__post_init__")
    cls.__record_compared__ = tuple(name for name, one in fields.items() if one.compare)
    cls.__init__ = _initializer(fields, hasattr(cls, "__post_init__"))
    methods: dict[str, Any] = {"__eq__": _equal, "__repr__": _shown, "__hash__": _hash if frozen else None}
    if not eq:
        methods |= {"__eq__": object.__eq__, "__hash__": object.__hash__}
    if frozen:
        methods |= {"__setattr__": _refuse, "__delattr__": _refuse}
    if order:
        methods |= {"__lt__": _less}
    for name, method in methods.items():
        if name not in vars(cls) or (name == "__hash__" and vars(cls)[name] is None):
            setattr(cls, name, method)
    return cls


def replace(record: T, **changes: Any) -> T:
    """A record like this one except for ``changes``."""
    cls: Any = type(record)
    names = cls.__record_fields__
    if cls.__record_plain__ and changes.keys() <= names.keys():
        made: T = cls.__new__(
            cls
        )  # half of the time that __init__ takes, and of the memory: no __dict__ is made
        for name in names:
            SET(made, name, changes[name] if name in changes else getattr(record, name))
        return made
    return cls(**{**{name: getattr(record, name) for name in names}, **changes})  # type: ignore[no-any-return]


def fields_of(record: object) -> tuple[str, ...]:
    """The names of a record's fields, or of those of a class of records, in order."""
    return tuple(getattr(record, "__record_fields__"))  # noqa: B009 - it is nothing that a type checker knows


def _initializer(fields: Mapping[str, Field], post: bool) -> Callable[..., None]:
    names, known = tuple(fields), set(fields)
    defaults = {
        name: one.default
        for name, one in fields.items()
        if one.factory is None and one.default is not _Nothing
    }

    def __init__(self: Any, *args: Any, **kwargs: Any) -> None:
        values = self.__dict__
        if len(args) + len(kwargs) != len(names):
            values.update(defaults)
        values.update(zip(names, args))
        values.update(kwargs)
        if (
            values.keys() != known
            or len(args) > len(names)
            or not kwargs.keys().isdisjoint(names[: len(args)])
        ):
            _complete(self, names, args, kwargs)
        if post:
            self.__post_init__()

    return __init__


def _complete(self: Any, names: tuple[str, ...], args: tuple[Any, ...], kwargs: dict[str, Any]) -> None:
    """Add the defaults; raise ``TypeError`` for arguments that do not fit."""
    what = f"{type(self).__qualname__}()"
    if len(args) > len(names):
        raise TypeError(f"{what} takes {len(names)} arguments, not {len(args)}")
    for name in kwargs:
        if name not in names:
            raise TypeError(f"{what} has no field {name!r}")
        if name in names[: len(args)]:
            raise TypeError(f"{what} got {name!r} twice")
    for name, one in type(self).__record_fields__.items():
        if name not in self.__dict__:
            if one.factory is None and one.default is _Nothing:
                raise TypeError(f"{what} lacks {name!r}")
            self.__dict__[name] = one.default if one.factory is None else one.factory()


def _compared(self: Any) -> Iterator[Any]:
    return (getattr(self, name) for name in self.__record_compared__)


def _equal(self: Any, other: object) -> bool:
    if other.__class__ is not self.__class__:
        return NotImplemented  # type: ignore[no-any-return]
    return [*_compared(self)] == [*_compared(other)]


def _less(self: Any, other: object) -> bool:
    if other.__class__ is not self.__class__:
        return NotImplemented  # type: ignore[no-any-return]
    return [*_compared(self)] < [*_compared(other)]


def _hash(self: Any) -> int:
    return hash(tuple(_compared(self)))


def _shown(self: Any) -> str:
    fields = self.__record_fields__.items()
    listed = ", ".join(f"{name}={getattr(self, name)!r}" for name, one in fields if one.repr)
    return f"{type(self).__qualname__}({listed})"


def _refuse(self: Any, name: str, *value: object) -> None:
    raise AttributeError(f"{type(self).__qualname__} is frozen: {name!r} stays as it is")

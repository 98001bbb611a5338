"""Numbers in messages: in few digits, and as files have them, ``1e-9`` where Python writes ``1e-09``."""

from __future__ import annotations

from typing import TYPE_CHECKING, SupportsFloat

if TYPE_CHECKING:
    from fractions import Fraction


def decimal(value: float, digits: int = 6) -> str:
    """``value`` in at most so many significant digits: ``0.5``, ``1e-6``, ``2.5e7``."""
    return _as_in_files(f"{value:.{digits}g}")


def scientific(value: float, digits: int = 1) -> str:
    """``value`` with an exponent and so many digits after the point, as errors have them: ``7.1e-15``."""
    return _as_in_files(f"{value:.{digits}e}")


def exact(value: SupportsFloat) -> str:
    """``value`` with all digits that tell it from other doubles."""
    return _as_in_files(repr(float(value)))


def as_decimal(value: Fraction, digits: int) -> str:
    """A fraction with all of its digits, or so many: ``1.25``, ``0.3333``, ``1e-9``."""
    from decimal import Decimal, localcontext

    with localcontext() as context:
        context.prec = digits
        return _as_in_files(f"{(Decimal(value.numerator) / value.denominator).normalize():g}")


def _as_in_files(digits: str) -> str:
    """A number that Python has written, without the sign and the zeros that its exponent may begin with."""
    mantissa, _, exponent = digits.partition("e")
    return f"{mantissa}e{int(exponent)}" if int(exponent or 0) else mantissa

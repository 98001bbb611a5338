"""What the results of ``equations`` have in common: texts and data as of the command."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lagrange_cli.api.kept import WORKING
from lagrange_cli.errors import UsageError
from lagrange_cli.run.equations import FORMATS, FORMS
from lagrange_cli.run.family_equations import Printed, data_of, in_form, written


class Written:
    """Equations of motion that can be written as the command prints them."""

    _derived: Printed
    _parameters: dict[str, float]

    @property
    def parameters(self) -> dict[str, float]:
        """The values of the parameters by name."""
        return dict(self._parameters)

    def write(self, format: str = "text", form: str = "lagrange") -> str:
        """The equations as the command prints them.

        Parameters
        ----------
        format : {"text", "unicode", "latex", "json", "python"}
        form : {"lagrange", "explicit", "hamilton", "matrix", "reactions", "vakonomic"}

        Raises
        ------
        UsageError
            There is no such format or form, or the system does not have this form.
        """
        check_known("format", format, FORMATS)
        check_known("form", form, FORMS)
        with WORKING:
            if format == "json":
                import json

                from lagrange_cli.run.attributes import finite

                return json.dumps(finite(self.as_data(form)), allow_nan=False)
            return written(in_form(self._derived, form), format, form, self._parameters)

    def as_data(self, form: str = "lagrange") -> dict[str, Any]:
        """The object that ``lagrange equations --json`` prints; raises ``UsageError`` as ``write``."""
        check_known("form", form, FORMS)
        with WORKING:
            return data_of(in_form(self._derived, form), form, self._parameters)

    def __str__(self) -> str:
        return self.write()


def check_known(what: str, word: str, known: Sequence[str]) -> None:
    """Raise ``UsageError`` unless a word is one of those known."""
    if word not in known:
        raise UsageError(f"unknown {what} {word!r:.60}; known: {', '.join(known)}")

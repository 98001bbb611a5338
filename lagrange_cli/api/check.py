"""``check``: what kind of system it is."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.api.given import Values, check_lengths, sizes_given, texts_of
from lagrange_cli.api.kept import WORKING
from lagrange_cli.api.system import System, content_of
from lagrange_cli.api.words import in_python
from lagrange_cli.errors import LagrangeWarning
from lagrange_cli.records import replace
from lagrange_cli.run.check import Classification, classify
from lagrange_cli.run.classification import as_object, as_text
from lagrange_cli.run.derive import read_run

if TYPE_CHECKING:
    from lagrange_cli.mechanics.conservation import Conserved


class Checked:
    """What is known of a system before any run. ``str`` gives the text that the command prints.

    Attributes
    ----------
    degrees_of_freedom : int
    scleronomic : bool
        Whether positions and constraints do not depend on t.
    cyclic : tuple of str
        The coordinates that L does not contain.
    conserved : dict of str to Conserved
        The conserved quantities, each with its ``expression`` and the reason, ``because``.
    structure : tuple of str
        Combinations of coordinates that are cyclic, and parts that do not act on each other, in sentences.
    skipped, engine : tuple of str
        What a run does not compute, and how the equations are integrated, in sentences.
    warnings : tuple of Problem
        Places of the file where units contradict each other, rounding may decide, names have no use, or
        dissipation does not brake.
    """

    def __init__(self, found: Classification) -> None:
        self._found = found

    @property
    def name(self) -> str:
        """The name of the system."""
        return self._found.spec.name

    @property
    def degrees_of_freedom(self) -> int:
        """The number of coordinates less that of independent constraints."""
        return self._found.spec.degrees_of_freedom

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the coordinates, in their order."""
        return tuple(one.name for one in self._found.spec.coordinates)

    @property
    def scleronomic(self) -> bool:
        """Whether positions and constraints do not depend on t."""
        return not self._found.mechanics.depending

    @property
    def cyclic(self) -> tuple[str, ...]:
        """The coordinates that L does not contain."""
        return self._found.mechanics.cyclic

    @property
    def conserved(self) -> dict[str, Conserved]:
        """The conserved quantities by name."""
        return {one.quantity: one for one in self._found.mechanics.conserved}

    @property
    def structure(self) -> tuple[str, ...]:
        """What the system is made of."""
        return self._found.mechanics.structure

    @property
    def skipped(self) -> tuple[str, ...]:
        """Quantities that a run does not compute."""
        return self._found.skipped

    @property
    def eliminated(self) -> dict[str, str]:
        """Coordinates, or velocities, that follow from linear constraints, as functions of the others."""
        return {one.quantity: one.expression for one in self._found.mechanics.eliminated}

    @property
    def engine(self) -> tuple[str, ...]:
        """How the equations are integrated."""
        return self._found.mechanics.engine

    @property
    def warnings(self) -> tuple[Any, ...]:
        """Doubtful places of the file."""
        return self._found.warnings

    def as_data(self) -> dict[str, Any]:
        """The object that ``lagrange check --json`` prints."""
        return as_object(self._found)

    def __str__(self) -> str:
        return as_text(self._found, verbose=False)

    def __repr__(self) -> str:
        return f"<{str(self).splitlines()[0]}>"


@in_python
def check(
    system: System, *, set: Values | None = None, size: Mapping[str, int | str] | None = None
) -> Checked:
    """Validate a system and classify it. It is accepted exactly if ``solve`` accepts it.

    Parameters
    ----------
    system : str, path or mapping
        The name of a system file, its content as text, or its content as a mapping.
    set, size : mapping, optional
        Parameters and initial values, and sizes, by name.

    Returns
    -------
    Checked

    Raises
    ------
    SpecError
        The system is wrong; ``problems`` has all mistakes with their places.
    UsageError
        An argument is wrong.
    FileError
        The file cannot be read.

    Warns
    -----
    LagrangeWarning
        Doubtful places of the file.
    """
    from lagrange_cli.spec.values import resolve_values

    overrides, sizes = texts_of("set", set), sizes_given(size)
    content, filename = content_of(system)
    with WORKING:
        spec, values = read_run(
            content, filename, sizes, lambda spec, problems: resolve_values(spec, overrides, problems)
        )
        check_lengths(spec, set)
        found = classify(spec, values=values, given=overrides)
    for warning in found.warnings:
        told = replace(warning, message=f"warning: {warning.message}").render(spec.filename)
        warnings.warn(told, LagrangeWarning, stacklevel=2)
    return Checked(found)

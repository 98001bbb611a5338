"""``equations``: the equations of motion as sympy expressions, which notebooks show as formulas."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lagrange_cli.api.given import Values, check_lengths, flag_of, sizes_given, texts_of
from lagrange_cli.api.indexed_equations import IndexedEquations
from lagrange_cli.api.kept import WORKING
from lagrange_cli.api.system import System, content_of
from lagrange_cli.api.words import in_python
from lagrange_cli.api.written import Written
from lagrange_cli.run.derive import read_run
from lagrange_cli.run.equations import FORMS, Derived
from lagrange_cli.run.family_equations import DerivedFamilies, derive_printed

if TYPE_CHECKING:
    import sympy


class Equations(Written):
    """The equations of motion of a system, derived by computer algebra.

    Symbols have the names of the system file: ``theta``, ``theta_dot`` and ``theta_ddot`` are a coordinate,
    its velocity and its acceleration, ``t`` is the time. Numbers of the file are exact. ``str`` gives what
    the command prints, and a notebook shows the equations as formulas.

    Attributes
    ----------
    L, h : sympy.Expr
        The Lagrangian and the energy function.
    T, U : sympy.Expr or None
        The kinetic energy and the potential; None where the file gives L.
    equations : dict of str to sympy.Eq
        The Euler-Lagrange equation of each coordinate.
    momenta : dict of str to sympy.Expr
        p_k = dL/dq_dot_k.
    accelerations : dict of str to sympy.Expr, or None
        The explicit solution; None where there is none.
    mass_matrix : sympy.ImmutableMatrix, shape (n, n)
    conserved : dict of str to sympy.Expr
        The conserved quantities.
    constraints : dict of str to sympy.Expr
        The expressions that the constraints keep at 0.
    """

    def __init__(self, derived: Derived, parameters: Mapping[str, float]) -> None:
        self._derived, self._found, self._parameters = derived, derived.equations, dict(parameters)

    @property
    def name(self) -> str:
        """The name of the system."""
        return self._found.name

    @property
    def L(self) -> sympy.Expr:
        """The Lagrangian."""
        return self._found.L

    @property
    def T(self) -> sympy.Expr | None:
        """The kinetic energy."""
        return self._found.T

    @property
    def U(self) -> sympy.Expr | None:
        """The potential."""
        return self._found.U

    @property
    def h(self) -> sympy.Expr:
        """The energy function, sum q_dot_k p_k - L."""
        return self._found.h

    @property
    def q(self) -> dict[str, sympy.Expr]:
        """The symbols of the coordinates."""
        return dict(zip(self._found.coordinates, self._found.q))

    @property
    def v(self) -> dict[str, sympy.Expr]:
        """The symbols of their velocities."""
        return dict(zip(self._found.coordinates, self._found.v))

    @property
    def equations(self) -> dict[str, sympy.Eq]:
        """The Euler-Lagrange equation of each coordinate."""
        from lagrange_cli.symbolic.expressions import equalities

        return equalities(self._found)

    @property
    def momenta(self) -> dict[str, sympy.Expr]:
        """p_k = dL/dq_dot_k of each coordinate."""
        return dict(zip(self._found.coordinates, self._found.momenta))

    @property
    def generalized_forces(self) -> dict[str, sympy.Expr]:
        """Q_k of each coordinate, without those of constraints."""
        return dict(zip(self._found.coordinates, self._found.generalized_forces))

    @property
    def accelerations(self) -> dict[str, sympy.Expr] | None:
        """The explicit solution for each coordinate; None where there is none."""
        found = self._found.accelerations
        return None if found is None else dict(zip(self._found.coordinates, found))

    @property
    def mass_matrix(self) -> sympy.ImmutableMatrix:
        """M in M a = f + forces of constraint."""
        from lagrange_cli.symbolic.expressions import matrix

        return matrix(self._found.mass_matrix)

    @property
    def conserved(self) -> dict[str, sympy.Expr]:
        """The conserved quantities by name."""
        return {one.quantity: one.expression for one in self._found.conserved}

    @property
    def constraints(self) -> dict[str, sympy.Expr]:
        """The expressions that the constraints keep at 0, by name."""
        return {one.name: one.expression for one in self._found.constraints}

    def __repr__(self) -> str:
        return f"<equations of motion of {self.name}: {', '.join(self._found.coordinates)}>"

    def _repr_latex_(self) -> str:
        from lagrange_cli.symbolic.latex import as_display

        with WORKING, self._derived.bounded():
            return as_display(self._found, "lagrange")


@in_python
def equations(
    system: System,
    *,
    coordinates: str = "",
    indexed: bool | None = None,
    set: Values | None = None,
    size: Mapping[str, int | str] | None = None,
) -> Equations | IndexedEquations:
    """Derive the equations of motion of a system.

    Parameters
    ----------
    system : str, path or mapping
        The name of a system file, its content as text, or its content as a mapping.
    set, size : mapping, optional
        Values of parameters, and sizes, by name.
    coordinates : str, optional
        The name of a transformation of the file, in whose coordinates they are derived.
    indexed : bool, optional
        Whether families are kept whole. By default large families are, as the command prints them.

    Returns
    -------
    Equations, or IndexedEquations where families are whole

    Raises
    ------
    SpecError
        The system is wrong, or its equations are too large to be read.
    UsageError
        An argument is wrong, or families cannot be written with indices as ``indexed`` asks.
    FileError
        The file cannot be read.
    """
    from lagrange_cli.spec.values import resolve_parameters

    overrides, sizes = texts_of("set", set), sizes_given(size)
    indexed = None if indexed is None else flag_of("indexed", indexed)
    content, filename = content_of(system)
    with WORKING:
        spec, parameters = read_run(
            content, filename, sizes, lambda spec, problems: resolve_parameters(spec, overrides, problems)
        )
        check_lengths(spec, set)
        derived = derive_printed(
            spec, FORMS[0], overrides=overrides, coordinates=coordinates, indexed=indexed
        )
        if isinstance(derived, DerivedFamilies):
            return IndexedEquations(derived, parameters)
        return Equations(derived, parameters)

"""``equations``: the equations of motion as sympy expressions, which notebooks show as formulas."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.api.given import Values, texts_of
from lagrange_cli.api.kept import WORKING
from lagrange_cli.api.system import System, content_of
from lagrange_cli.errors import UsageError
from lagrange_cli.run.derive import read_run
from lagrange_cli.run.equations import FORMATS, FORMS, Derived, as_data, as_written, derive

if TYPE_CHECKING:
    import sympy


class Equations:
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
    def parameters(self) -> dict[str, float]:
        """The values of the parameters by name."""
        return dict(self._parameters)

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
        for what, word, known in (("format", format, FORMATS), ("form", form, FORMS)):
            if word not in known:
                raise UsageError(f"unknown {what} {word!r:.60}; known: {', '.join(known)}")
        with WORKING:
            if format == "json":
                import json

                from lagrange_cli.run.attributes import finite

                return json.dumps(finite(self.as_data(form)), allow_nan=False)
            return as_written(self._derived, format, form, self._parameters)

    def as_data(self, form: str = "lagrange") -> dict[str, Any]:
        """The object that ``lagrange equations --json`` prints."""
        with WORKING:
            return as_data(self._derived, form, self._parameters)

    def __str__(self) -> str:
        return self.write()

    def __repr__(self) -> str:
        return f"<equations of motion of {self.name}: {', '.join(self._found.coordinates)}>"

    def _repr_latex_(self) -> str:
        from lagrange_cli.symbolic.latex import as_display

        with WORKING, self._derived.bounded():
            return as_display(self._found, "lagrange")


def equations(
    system: System,
    *,
    coordinates: str = "",
    set: Values | None = None,
    size: Mapping[str, int | str] | None = None,
) -> Equations:
    """Derive the equations of motion of a system.

    Parameters
    ----------
    system : str, path or mapping
        The name of a system file, its content as text, or its content as a mapping.
    set, size : mapping, optional
        Values of parameters, and sizes, by name.
    coordinates : str, optional
        The name of a transformation of the file, in whose coordinates they are derived.

    Returns
    -------
    Equations

    Raises
    ------
    SpecError
        The system is wrong, or its equations are too large to be read.
    UsageError
        An argument is wrong.
    FileError
        The file cannot be read.
    """
    from lagrange_cli.spec.values import resolve_parameters

    overrides, sizes = texts_of("set", set), texts_of("size", size)
    content, filename = content_of(system)
    with WORKING:
        spec, parameters = read_run(
            content, filename, sizes, lambda spec, problems: resolve_parameters(spec, overrides, problems)
        )
        return Equations(derive(spec, overrides=overrides, coordinates=coordinates), parameters)

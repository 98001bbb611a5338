"""The equations of large families as sympy expressions, with their indices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from lagrange_cli.api.kept import WORKING
from lagrange_cli.api.written import Written
from lagrange_cli.run.family_equations import DerivedFamilies

if TYPE_CHECKING:
    import sympy

    from lagrange_cli.symbolic.families.equations import FamilyEquations
    from lagrange_cli.symbolic.families.lines import Line
    from lagrange_cli.symbolic.indexed.conditions import Loop


class IndexedEquations(Written):
    """The equations of motion of large families, with their indices.

    A line stands for all members that are alike. Its key is the name of a member, such as ``x[i]``, and
    ``members`` says for which indices it holds. Families are ``sympy.IndexedBase``, sums ``sympy.Sum``;
    indices and sizes are integer symbols. Otherwise as ``Equations``.

    Attributes
    ----------
    L, h : sympy.Expr
        The Lagrangian and the energy function.
    T, U : sympy.Expr or None
        The kinetic energy and the potential; None where the file gives L.
    equations : dict of str to sympy.Eq
        The Euler-Lagrange equation of each line.
    momenta : dict of str to sympy.Expr
        p_k = dL/dq_dot_k.
    accelerations, masses, force : dict of str to sympy.Expr, or None
        The explicit solution, which is None with constraints, and the diagonal of M and f in M a = f (with
        constraints, M a = f + A^T lambda). Where M couples members as along chains and trees, there is no
        solution, and ``masses`` is None where it is not diagonal.
    mass_matrix : dict of str to sympy.Expr
        The entries of M from the diagonal on, but those that are 0: ``M_theta[i,j]``, ``M_theta_phi[i,j]``.
    positions : dict of str to sympy.Expr
        What the names of places stand for that the equations contain.
    constraints : dict of str to sympy.Expr
        The expressions that the constraints keep at 0; the multiplier of ``rod[i]`` is ``lambda_rod[i]``.
    conserved : dict of str to sympy.Expr
        The conserved quantities.
    members : dict of str to dict
        By quantity, such as ``"momenta"``: the loops of its lines, such as ``for i in range(1, N)``.
    sizes : dict of str to int
    """

    def __init__(self, derived: DerivedFamilies, parameters: Mapping[str, float]) -> None:
        self._derived, self._found, self._parameters = derived, derived.equations, dict(parameters)

    def _sympy(self, expression: sympy.Expr, loops: Sequence[Loop] = ()) -> sympy.Expr:
        from lagrange_cli.symbolic.families.as_sympy import as_sympy

        return as_sympy(expression, [*self._found.sizes], loops)

    def _lines(self, lines: Sequence[Line]) -> dict[str, sympy.Expr]:
        return {one.name(): self._sympy(one.expression, one.loops) for one in lines}

    @property
    def name(self) -> str:
        """The name of the system."""
        return self._found.name

    @property
    def sizes(self) -> dict[str, int]:
        """The sizes of the families by name."""
        return dict(self._found.sizes)

    @property
    def L(self) -> sympy.Expr:
        """The Lagrangian."""
        return self._sympy(self._found.L)

    @property
    def T(self) -> sympy.Expr | None:
        """The kinetic energy."""
        return None if self._found.T is None else self._sympy(self._found.T)

    @property
    def U(self) -> sympy.Expr | None:
        """The potential."""
        return None if self._found.U is None else self._sympy(self._found.U)

    @property
    def h(self) -> sympy.Expr:
        """The energy function, sum q_dot_k p_k - L."""
        return self._sympy(self._found.h)

    @property
    def equations(self) -> dict[str, sympy.Eq]:
        """The Euler-Lagrange equation of each line."""
        from lagrange_cli.symbolic.expressions import equality

        return {
            line.name(): equality(*(self._sympy(x, line.loops) for x in (one.left, one.right)))
            for line, one in self._found.equations
        }

    @property
    def momenta(self) -> dict[str, sympy.Expr]:
        """p_k = dL/dq_dot_k of each line."""
        return self._lines(self._found.momenta)

    @property
    def generalized_forces(self) -> dict[str, sympy.Expr]:
        """Q_k of each line that has one."""
        return self._lines(self._found.forces)

    @property
    def accelerations(self) -> dict[str, sympy.Expr] | None:
        """The explicit solution for each line; None where M couples members, and with constraints."""
        return None if self._found.accelerations is None else self._lines(self._found.accelerations)

    @property
    def masses(self) -> dict[str, sympy.Expr] | None:
        """The diagonal of M in M a = f; None where M is not diagonal."""
        return None if self._found.diagonal is None else self._lines(self._found.diagonal)

    @property
    def mass_matrix(self) -> dict[str, sympy.Expr]:
        """The entries of M from the diagonal on, but those that are 0."""
        return self._lines([one for one in self._with_matrix.masses or () if one.expression != 0])

    @property
    def force(self) -> dict[str, sympy.Expr]:
        """f in M a = f, or in M a = f + A^T lambda with constraints."""
        return self._lines(self._with_matrix.rates or ())

    @property
    def _with_matrix(self) -> FamilyEquations:
        from lagrange_cli.run.family_equations import in_form

        with WORKING:
            found = in_form(self._derived, "matrix")
        assert isinstance(found, DerivedFamilies)
        return found.equations

    @property
    def positions(self) -> dict[str, sympy.Expr]:
        """What the names of places stand for."""
        return {one.symbol.name: self._sympy(one.expression, one.loops) for one in self._found.places}

    @property
    def conserved(self) -> dict[str, sympy.Expr]:
        """The conserved quantities by name."""
        found = {one.quantity: self._sympy(one.expression) for one in self._found.conserved}
        return found | ({"h": self.h} if "h" in found else {})

    @property
    def members(self) -> dict[str, dict[str, str]]:
        """For which indices the lines of each quantity hold."""
        from lagrange_cli.symbolic.families.data import members_of

        return members_of(self._found)

    @property
    def constraints(self) -> dict[str, sympy.Expr]:
        """The expressions that the constraints keep at 0, by line."""
        return self._lines(self._found.constraints)

    def __repr__(self) -> str:
        families = ", ".join(one.name for one in self._found.coordinates)
        return f"<equations of motion of {self.name}: families {families}>"

    def _repr_latex_(self) -> str:
        from lagrange_cli.symbolic.families.report import as_display

        with WORKING, self._derived.bounded():
            return as_display(self._found)

"""Which equations accelerations and multipliers follow from, by whether M is diagonal."""

from __future__ import annotations

from typing import TypeAlias

from lagrange_cli.families.bonds import Bonds
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.saddle_points import SaddlePoint
from lagrange_cli.native.families.constraints.dense import DenseTables, SolvingTables
from lagrange_cli.native.families.constraints.held import HeldAlongMotion
from lagrange_cli.native.families.constraints.in_turn import DependentTables
from lagrange_cli.native.families.constraints.moves import Moves, MovesTogether
from lagrange_cli.native.families.constraints.restraint import AlongMotion, AtAState
from lagrange_cli.native.families.constraints.saddle_tables import SaddleTables
from lagrange_cli.native.families.constraints.together import (
    FreeAtAState,
    TogetherAlongMotion,
    TogetherAtAState,
)
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.tables import Tables

Pulled: TypeAlias = "AtAState | TogetherAtAState | FreeAtAState"
"""What is solved for at a state."""


def along_motion(system: FamilySystem, lasting: Lasting, parts: int) -> AlongMotion:
    """Those along a motion, in numbers of so many ``parts``."""
    if system.saddle is not None:
        return TogetherAlongMotion(system, lasting)
    if system.modes is not None and system.modes.halts is not None:
        return HeldAlongMotion(system, lasting, parts)
    return AlongMotion(system, lasting)


def moves_of(system: FamilySystem, lasting: Lasting) -> Moves | MovesTogether:
    """Those of a projection."""
    if system.saddle is not None:
        return MovesTogether(system, lasting)
    return Moves(system, lasting)


def at_a_state(system: FamilySystem, lasting: Lasting) -> Pulled | None:
    """Those at a state; None where accelerations are forces divided by masses."""
    if system.saddle is not None:
        return TogetherAtAState(system, lasting)
    if system.bonds is not None:
        return AtAState(system, lasting)
    return None if system.coupled_masses is None else FreeAtAState(system, lasting)


def tables_of(equations: Bonds | SaddlePoint, tables: Tables) -> SolvingTables:
    """How they are solved."""
    bonds = equations if isinstance(equations, Bonds) else equations.bonds
    if bonds.surplus or (isinstance(equations, SaddlePoint) and equations.in_blocks):
        first = equations.count - bonds.count
        surplus = {first + i for i in bonds.surplus}
        return DependentTables(equations.count, equations.blocks, first, surplus, tables)
    if equations.elimination is None:
        return DenseTables(equations.count, tables)
    return SaddleTables(equations.elimination, tables)

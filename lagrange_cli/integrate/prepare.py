"""From a system to a run that is ready to go: compiled now, or taken from the cache."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

from lagrange_cli.integrate.background import alongside
from lagrange_cli.integrate.methods.names import DOUBLE, IMPLICIT, TAYLOR
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.native.compilation.machine import (
    FULL,
    Machine,
    compile_object,
    first_level,
    load_machine,
    worth_improving,
)
from lagrange_cli.native.interface import Interface
from lagrange_cli.outputs.recording import Recording
from lagrange_cli.records import replace
from lagrange_cli.spec.structure import structure

if TYPE_CHECKING:
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.mechanics.residual import Residual
    from lagrange_cli.native.compilation.cache import Cache
    from lagrange_cli.native.program import Program
    from lagrange_cli.spec.spec import Spec

Stage = Callable[[str], AbstractContextManager[None]]
"""A context in which a stage of the work is done: ``import``, ``derive``, ``program`` (writing it),
``compile`` or ``cache``."""


def untimed(stage: str) -> AbstractContextManager[None]:
    """A stage that is not reported."""
    return nullcontext()


def nothing() -> None:
    """Do nothing in the meantime."""


def prepare(
    residual: Residual,
    *,
    method: str,
    tolerance: float,
    outputs: frozenset[str],
    ensemble: bool = False,
    order: int | None = None,
    backward: bool = False,
) -> Prepared:
    """Compile ``residual`` for ``method`` (``taylor`` or one of scipy's) with what ``outputs`` need.

    What is prepared for an ``ensemble`` is for ``integrate.ensemble`` alone; for ``order`` see ``write_run``.
    Motions that end before they start need it prepared ``backward``.
    """
    from lagrange_cli.integrate.program import write_run

    program, recording = write_run(
        residual, method=method, tolerance=tolerance, outputs=outputs, ensemble=ensemble, order=order,
        backward=backward,
    )  # fmt: skip
    machine = load_machine(compile_object(program), program)
    following = follower(machine, method, tolerance, backward=backward)
    return Prepared(recording, machine, method, tolerance, following, backward)


def prepare_system(
    spec: Spec,
    derive: Callable[[Spec], Residual],
    cache: Cache | None,
    *,
    method: str,
    tolerance: float,
    outputs: frozenset[str],
    ensemble: bool = False,
    precision: str = DOUBLE,
    portable: bool = False,
    order: int | None = None,
    backward: bool = False,
    stage: Stage = untimed,
    meanwhile: Callable[[], object] = nothing,
) -> Prepared:
    """``prepare`` for the residual that ``derive`` makes of ``spec``, unless ``cache`` has it compiled.

    A ``portable`` program computes the same bits on every machine, if ``derive`` brings such numbers.
    ``meanwhile`` is called once, while LLVM compiles if it has to: it is for what the run needs next.
    """

    def prepare_rest() -> None:
        with stage("import"):
            meanwhile()

    def write(stage: Stage = untimed) -> tuple[Program, Recording]:
        from lagrange_cli.integrate.program import write_run

        with stage("derive"):
            residual = derive(spec)
        with stage("program"):
            program, recording = write_run(
                residual, method=method, tolerance=tolerance, outputs=outputs, ensemble=ensemble,
                precision=precision, order=order, backward=backward,
            )  # fmt: skip
            if portable:
                from lagrange_cli.native.functions.portable import portable as made_portable

                program = replace(program, text=made_portable(program.text))
        return program, recording

    def keep(program: Interface, recording: Recording, code: bytes, level: int) -> None:
        if cache is not None and key is not None:
            cache.store(key, pack(program, recording, code, level))

    kept, key = None, None
    with stage("cache"):
        if cache is not None:
            key = key_of(
                spec, method=method, tolerance=tolerance, outputs=outputs, ensemble=ensemble,
                precision=precision, portable=portable, order=order, backward=backward,
            )  # fmt: skip
        if cache is not None and key is not None:
            kept = unpack(cache.load(key))
        if kept is not None:
            code = kept[2]
            machine, recording, level = load_machine(code, kept[0]), kept[1], kept[3]
    if kept is None:
        with stage("import"):
            import lagrange_cli.integrate.program  # noqa: F401
        program, recording = write(stage)
        level = first_level(program)
        with stage("compile"):
            code = alongside(lambda: compile_object(program, level), prepare_rest)
            machine = load_machine(code, program)
        with stage("cache"):
            keep(program, recording, code, level)
    else:
        prepare_rest()

    def improve() -> Machine:
        better, recording = write() if kept is not None else (program, machine_recording)
        code = compile_object(better, FULL)
        keep(better, recording, code, FULL)
        return load_machine(code, better)

    machine_recording = recording
    with stage("import"):
        better = improve if level != FULL and worth_improving(code) else None
        following = follower(machine, method, tolerance, better, backward=backward)
    return Prepared(recording, machine, method, tolerance, following, backward, cached=kept is not None)


def follower(
    machine: Machine,
    method: str,
    tolerance: float,
    improve: Callable[[], Machine] | None = None,
    *,
    backward: bool = False,
) -> Method:
    """The method of that name on equations compiled for it; ``improve`` makes better code for a long run, if
    any."""
    if backward:
        from lagrange_cli.integrate.methods.backward import Backward

        return Backward(follower(machine, method, tolerance, improve), machine.program)
    if method == TAYLOR:
        from lagrange_cli.integrate.methods.recompilation import Better
        from lagrange_cli.integrate.methods.taylor import TaylorMethod

        return TaylorMethod(machine, None if improve is None else Better(improve))
    from lagrange_cli.integrate.methods.scipy import ScipyMethod

    return ScipyMethod(machine, method, tolerance)


def key_of(
    spec: Spec,
    *,
    method: str,
    tolerance: float,
    outputs: frozenset[str],
    ensemble: bool = False,
    precision: str = DOUBLE,
    portable: bool = False,
    order: int | None = None,
    backward: bool = False,
) -> str | None:
    """All that a compiled program depends on; None where that cannot be found out.

    It holds no number of a run: neither parameters nor the initial state are part of a program.
    """
    from lagrange_cli.native.compilation.fingerprint import identity

    try:
        made_by = identity()
    except OSError:
        return None
    kind = (
        ["taylor", tolerance.hex(), ensemble, precision, portable, order]
        if method == TAYLOR
        else ["rates", method in IMPLICIT]
    )
    return json.dumps([structure(spec), kind, backward, sorted(outputs), made_by])


def pack(interface: Interface, recording: Recording, code: bytes, level: int) -> bytes:
    """What a later run needs: a line of JSON, then the object code, compiled at ``level``."""
    head = json.dumps({"interface": interface.as_data(), "recording": recording.as_data(), "level": level})
    return head.encode() + b"\n" + code


def unpack(payload: bytes | None) -> tuple[Interface, Recording, bytes, int] | None:
    """What ``pack`` was given; None where there is nothing, or nothing that can be read."""
    if payload is None:
        return None
    head, _, code = payload.partition(b"\n")
    try:
        data: dict[str, Any] = json.loads(head)
        interface, recording = Interface.from_data(data["interface"]), Recording.from_data(data["recording"])
        return interface, recording, code, int(data["level"])
    except (ValueError, KeyError, TypeError):
        return None

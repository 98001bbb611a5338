"""From a system to a run that is ready to go: compiled now, or taken from the cache, where programs have a
key and are bytes."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

from lagrange_cli.integrate.background import concurrently
from lagrange_cli.integrate.methods.selection import follower
from lagrange_cli.integrate.methods.table import METHODS, Needs
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.limits import uncollected
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
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.mechanics.residual import Residual
    from lagrange_cli.native.compilation.cache import Cache
    from lagrange_cli.native.program import Program
    from lagrange_cli.spec.spec import Spec


def key_of(spec: Spec, compilation: Compilation) -> str | None:
    """All that a compiled program depends on; None where that cannot be found out.

    It holds no number of a run: neither parameters nor the initial state are part of a program.
    """
    from lagrange_cli.native.compilation.fingerprint import fingerprint

    try:
        made_by = fingerprint()
    except OSError:
        return None
    asked = compilation
    needs, kind = METHODS[asked.method].needs, list[Any]()
    if needs in (Needs.SERIES, Needs.STEPS):  # the other programs serve several methods, at any tolerance
        kind = [
            asked.method,
            asked.tolerance.hex(),
            asked.ensemble,
            asked.few,
            asked.precision,
            asked.portable,
            asked.order,
        ]
        kind += [asked.proven, asked.unproven, asked.section, asked.factor]
    return json.dumps(
        [
            structure(spec),
            needs.value,
            kind,
            asked.backward,
            sorted(asked.outputs),
            sorted(asked.optional),
            asked.by_default,
            made_by,
        ]
    )


def pack(interface: Interface, recording: Recording, code: bytes, level: int) -> bytes:
    """What a later run needs: a line of JSON, then the object code, compiled at ``level``."""
    head = json.dumps({"interface": interface.as_data(), "recording": recording.as_data(), "level": level})
    return head.encode() + b"\n" + code


def unpack(payload: bytes | None) -> tuple[Interface, Recording, bytes, int] | None:
    """The arguments of ``pack``; None where there is nothing, or nothing readable."""
    if payload is None:
        return None
    head, _, code = payload.partition(b"\n")
    try:
        data: dict[str, Any] = json.loads(head)
        interface, recording = Interface.from_data(data["interface"]), Recording.from_data(data["recording"])
        return interface, recording, code, int(data["level"])
    except (ValueError, KeyError, TypeError):
        return None


Stage = Callable[[str], AbstractContextManager[None]]
"""A context in which a stage of the work is done: ``import``, ``derive``, ``program`` (writing it),
``compile`` or ``cache``."""


def untimed(stage: str) -> AbstractContextManager[None]:
    """A stage that is not reported."""
    return nullcontext()


def nothing() -> None:
    """Do nothing in the meantime."""


def prepare(residual: Residual, compilation: Compilation, level: int = FULL) -> Prepared:
    """Compile the equations of motion. What is prepared for an ensemble is for ``integrate.ensemble`` alone.

    Raises ``TooLarge`` where the code would be too large to be compiled.
    """
    from lagrange_cli.integrate.program import write_run

    program, recording = write_run(residual, compilation)
    machine = load_machine(compile_object(program, level), program)
    return Prepared(recording, machine, compilation, follower(machine, compilation))


@uncollected()
def prepare_system(
    spec: Spec,
    derive: Callable[[Spec], Residual],
    cache: Cache | None,
    compilation: Compilation,
    *,
    stage: Stage = untimed,
    meanwhile: Callable[[], object] = nothing,
) -> Prepared:
    """``prepare`` for the residual that ``derive`` makes of ``spec``, unless ``cache`` has it compiled. Where
    that is too large or costly, outputs that are optional are left out if members are written out for them
    alone.

    ``meanwhile`` is called once, while LLVM compiles if it has to: it is for what the run needs next.
    """

    def prepare_rest() -> None:
        with stage("import"):
            meanwhile()

    def write(stage: Stage = untimed) -> tuple[Program, Recording]:
        if not spec.coordinate_families:
            return written_out(stage)
        with stage("import"):
            from lagrange_cli.errors import TooLarge, TooLargeSystem
            from lagrange_cli.integrate.families import family_run, without_costly, without_expansion

        try:
            with stage("derive"):
                system, less = without_costly(spec, compilation)
                if system is None:
                    system, less = family_run(spec, compilation), compilation
            if system is None:
                return written_out(stage)
        except (TooLarge, TooLargeSystem):
            system, less = without_expansion(spec, compilation)
            if less is None or less == compilation:
                raise
        assert system is not None and less is not None
        with stage("import"):
            from lagrange_cli.integrate.family_program import write_families
        with stage("program"):
            program, recording = write_families(system, less)
        left_out = tuple(sorted(compilation.outputs - less.outputs))
        return program, replace(recording, left_out=left_out)

    def written_out(stage: Stage) -> tuple[Program, Recording]:
        with stage("import"):
            from lagrange_cli.integrate.program import write_run
        with stage("derive"):
            residual = derive(spec)
        with stage("program"):
            return write_run(residual, compilation)

    def store(program: Interface, recording: Recording, code: bytes, level: int) -> None:
        if cache is not None and key is not None:
            cache.store(key, pack(program, recording, code, level))

    stored, key = None, None
    with stage("cache"):
        if cache is not None:
            key = key_of(spec, compilation)
        if cache is not None and key is not None:
            stored = unpack(cache.load(key))
        if stored is not None:
            interface, recording, code, level = stored
            machine = load_machine(code, interface)
    if stored is None:
        program, recording = write(stage)
        level = first_level(program)
        with stage("compile"):
            code = concurrently(lambda: compile_object(program, level), prepare_rest)
            machine = load_machine(code, program)
        with stage("cache"):
            store(program, recording, code, level)
    else:
        prepare_rest()

    def improve() -> Machine:
        with uncollected():
            improved, made = (program, recording) if stored is None else write()
        code = compile_object(improved, FULL)
        store(improved, made, code, FULL)
        return load_machine(code, improved)

    with stage("import"):
        recompile = improve if level != FULL and worth_improving(code) else None
        following = follower(machine, compilation, recompile)
    return Prepared(recording, machine, compilation, following, cached=stored is not None)

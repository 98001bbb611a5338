"""A compiled program in the cache: its key, and its form as bytes."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from lagrange_cli.integrate.methods.table import METHODS, Needs
from lagrange_cli.native.interface import Interface
from lagrange_cli.outputs.recording import Recording
from lagrange_cli.spec.structure import structure

if TYPE_CHECKING:
    from lagrange_cli.integrate.compilation import Compilation
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

"""The engine of a page: a system's program as WebAssembly, and what its driver must know of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any, cast

from lagrange_cli.drawing.draw import MANY
from lagrange_cli.drawing.drawing import Drawing
from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.index_arrays import Differ
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.expression.vocabulary import TIME
from lagrange_cli.families.starts import initial_state
from lagrange_cli.integrate.workspace import outer_rows
from lagrange_cli.native.compilation.webassembly import compile_webassembly
from lagrange_cli.native.families.pages import write_deriving, write_placing
from lagrange_cli.native.functions.elementary import definitions
from lagrange_cli.native.guards import INFO, LOOSE, SIMPLE, Role
from lagrange_cli.native.interface import Interface
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.observation import write_map, write_prepare, write_values
from lagrange_cli.native.program import Program
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.page.packed import packed
from lagrange_cli.spec.constants import builder
from lagrange_cli.spec.spec import Expression, Spec


def engine(spec: Spec, program: Program | None, drawing: Drawing | None) -> dict[str, Any]:
    """The module of ``program``, and the layout of its arrays, in terms of JSON.

    Besides ``program``'s own functions it has ``@place``, which computes the points of the ``drawing``,
    functions of q, t and parameters, at states, and of what is free, which has rows behind those of q;
    ``@derive``, which computes what the file gives as expressions in parameters: the parameters themselves, q
    and v; and ``@measure``, which computes the drawing's sizes. Without a ``program`` it has these alone, for
    pages that replay.
    """
    sizes = () if drawing is None else drawing.sizes
    free = () if drawing is None else drawing.free
    placing, constants = ("", 0) if drawing is None else placed(spec, drawing)
    deriving, filled = derived(spec)
    text = "\n".join(["" if program is None else program.text, placing, deriving, measured(spec, sizes)])
    module = compile_webassembly(text + definitions(text), loops=program is not None and program.loops)
    degrees = len(spec.coordinates)
    described = NOTHING if program is None else layout(spec, program)
    return described | {
        "heap": module.heap,
        "degrees": degrees,
        "parameters": [one.name for one in spec.parameters],
        "points": 0 if drawing is None else drawing.count * drawing.dimension,
        "free": len(free),
        "derived": len(spec.parameters) + 2 * degrees,
        "results": max(filled, len(sizes), 1),
        "measured": len(sizes),
        "sizes": ({} if program is None else array_sizes(program)) | {"placing": max(1, constants)},
        "code": packed(module.code),
    }


def placed(spec: Spec, drawing: Drawing) -> tuple[str, int]:
    """``@place`` and ``@prepare_place`` for a drawing, and how many constants they take."""
    if drawing.located is None:
        return place(spec, drawing.nodes, drawing.free)
    return write_placing(drawing.located.system, drawing.located.axes)


def place(spec: Spec, points: Sequence[Node], free: Sequence[str] = ()) -> tuple[str, int]:
    """The same for points that are expressions."""
    if not points:
        return "", 0
    symbol, constants = symbols_like(points[0]), Constants()
    q = [symbol(name) for name in (*(one.name for one in spec.coordinates), *free)]
    text, _ = write_values("place", Emitter, symbol(TIME), q, len(q), [*points], constants)
    named = {one.name: symbol(one.name) for one in spec.parameters}
    prepare, count = write_prepare(Emitter, constants, named, "void @prepare_place")
    return f"{text}\n{prepare}", count


def symbols_like(node: Node) -> Callable[[str], Node]:
    """The symbols of the graph that a node is in, by name."""
    return cast(Graph, node.graph).symbol


def derived(spec: Spec) -> tuple[str, int]:
    """``@derive``: each parameter as the file has it, q and v; and the doubles that it fills."""
    algebra = GraphAlgebra()
    symbols = {one.name: algebra.symbol(one.name) for one in spec.parameters}
    given = written([one.value for one in spec.parameters], spec, symbols, algebra)
    if len(spec.coordinates) >= MANY:
        with suppress(Unsuited, Differ, ExpressionError, TooLarge):
            system, *state = initial_state(spec)
            return write_deriving(system, symbols, given, state)
    start = [*(one.initial for one in spec.coordinates), *(one.velocity for one in spec.coordinates)]
    given += written(start, spec, symbols, algebra)
    return function("derive", symbols, given), len(given)


def written(
    listed: Sequence[Expression | None], spec: Spec, symbols: Mapping[str, Node], algebra: GraphAlgebra
) -> list[Node]:
    """Expressions in parameters and constant definitions; 0 where there is none."""
    trees = [one.tree for one in listed if one is not None]
    made, zero = builder(trees, spec, symbols.__getitem__, algebra), algebra.number("0")
    return [zero if one is None else made.build(one.tree, one.indices) for one in listed]


def measured(spec: Spec, sizes: Sequence[Node]) -> str:
    """``@measure``: the sizes of a drawing."""
    if not sizes:
        return ""
    symbol = symbols_like(sizes[0])
    return function("measure", {one.name: symbol(one.name) for one in spec.parameters}, sizes)


def function(name: str, parameters: Mapping[str, Node], nodes: Sequence[Node]) -> str:
    """A function of parameters that puts ``nodes`` one after the other."""
    return write_map(Emitter, parameters, [(node, i) for i, node in enumerate(nodes)], f"void @{name}")[0]


def array_sizes(program: Interface) -> dict[str, int]:
    """The arrays that the program's functions work on, in doubles."""
    constants = max(1, program.constants)
    return {
        "constants": constants,
        "observing": constants,
        "memory": program.inner.memory,
        "work": max(1, program.work),
        "trial": max(1, program.trial),
        "info": INFO,
    }


NOTHING = {"rows": 0, "inner": 0, "outer": [], "room": 0, "observed": [], "acted": 0, "records": 0}
"""The description of a program for a page that replays."""


def layout(spec: Spec, program: Interface) -> dict[str, Any]:
    """The places of the parts of a state, and the rows of arrays."""
    inner = program.inner
    cyclic = inner.cyclic_momenta
    return {
        "rows": program.rows,
        "inner": inner.rows,
        "outer": outer_rows(program).tolist(),
        "room": program.rows_of_guards.count if program.guarded else 0,
        "observed": list(program.observed),
        "acted": program.acted,
        "records": program.records,
        "layout": {
            "v": inner.degrees,
            "width": inner.width,
            "third": inner.third,
            "clock": inner.clock.start,
            "cyclic": [cyclic.start, cyclic.stop],
        },
        "guards": guards(spec, program) if program.guarded else None,
    }


def guards(spec: Spec, program: Interface) -> dict[str, Any]:
    """The data for settling modes and for actions at events."""
    rows, inner = program.rows_of_guards, program.inner
    rests = iter([j for j, one in enumerate(rows.guards) if one.role is Role.REST])
    motion = 2 * program.degrees
    return {
        "switches": len(program.guards),
        "guards": [
            {
                "role": int(one.role),
                "row": one.row,
                "multiplier": one.multiplier,
                "direction": one.direction,
                "beside": one.beside,
                "parts": one.parts,
                "placed": one.placed,
                "jumps": one.jumps,
            }
            for one in rows.guards
        ],
        "silent": [list(one) for one in program.silent],
        "settings": inner.settings.start,
        "parameters": rows.parameters,
        "mode": rows.mode(inner),
        "fresh": rows.fresh(inner),
        "times": rows.times(inner).start,
        "seriesAt": list(program.series_at),
        "events": [
            {
                "name": name,
                "rest": next(rests) if one[2] not in (SIMPLE, LOOSE) else -1,
                "impact": event in program.slowing,
            }
            for event, (name, one) in enumerate(zip(spec.events, program.events))
        ],
        "changed": [list(one) for one in program.changed],
        "masses": len(program.masses),
        "setsParameters": any(place >= motion for _, place in program.changed),
    }

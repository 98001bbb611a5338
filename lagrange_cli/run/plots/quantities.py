"""``Quantity``: a number at every sample, by the name that a user gives it, and its label on an axis."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.near import near_match, shown
from lagrange_cli.records import dataclass
from lagrange_cli.store.result import Held, Result

COMPONENTS = "xyz"
FOLDERS = {
    "q/": ("{}", "q"),
    "v/": ("{}_dot", "v"),
    "diagnostics/p/": ("p_{}", "p"),
    "positions/": ("{}", "positions"),
    "reactions/": ("R_{}", "reactions"),
    "multipliers/": ("lambda_{}", "multipliers"),
    "observables/": ("{}", "observables"),
    "diagnostics/constraints/": ("constraint_{}", "constraints"),
    "diagnostics/conserved/": ("{}", "conserved"),
    "diagnostics/ledger/p/": ("ledger_p_{}", "ledger"),
    "diagnostics/ledger/": ("ledger_{}", "ledger"),
    "diagnostics/error/q/": ("error_{}", "error"),
    "diagnostics/error/v/": ("error_{}_dot", "error"),
    "diagnostics/": ("{}", ""),
}
"""How datasets of a folder are called, and the output that they belong to."""
MOST_MEMBERS = 100_000
"""Numbers of a dataset for each sample that have labels of their own."""
LONGEST = 28
"""Letters of a name in labels; a longer one is shortened."""
SAFE_UNIT = re.compile(r"[\w%°·*/^ ().-]+")


@dataclass(frozen=True)
class Quantity:
    """One number a sample: the dataset with its ``path``, and which of its numbers (``index``)."""

    name: str
    path: str
    index: tuple[int, ...]
    unit: str

    @property
    def symbol(self) -> str:
        """Its name as a formula for labels."""
        from lagrange_cli.symbolic.latex import Latex

        name, dot, component = self.name.partition(".")
        if name.startswith(("R_", "lambda_", "constraint_")):  # R_bob.x, lambda_joint.x, lambda_joint.x[0]
            stem, bracket, index = self.name.replace(".", "_").partition("[")
            index, _, axis = index.partition("]")
            return f"${Latex().symbol(shortened(f'{stem}{axis}{bracket}{index}' + ']' * bool(bracket)))}$"
        error = name.startswith("error_")
        made = Latex().symbol(shortened(name.removeprefix("error_")))
        if dot:
            made = f"{component}_{{{made}}}"
        return f"error of ${made}$" if error else f"${made}$"

    @property
    def label(self) -> str:
        """Its symbol with its unit."""
        return with_unit(self.symbol, self.unit)


def shortened(name: str) -> str:
    """A name that has room beside an axis."""
    if len(name) <= LONGEST:
        return name
    return f"{name[: LONGEST - 8]}\N{HORIZONTAL ELLIPSIS}{name[-7:]}"


def with_unit(text: str, unit: str) -> str:
    """A label with a unit behind it, where there is one."""
    return f"{text} ({unit_text(unit)})" if unit and unit != "1" else text


def unit_text(unit: str) -> str:
    """A unit for a label; what is no plain unit is left as it is, and is no formula."""
    if not SAFE_UNIT.fullmatch(unit):
        return unit.replace("$", r"\$")
    raised = re.sub(r"\^(-?\d+)", r"$^{\1}$", unit)
    return raised.replace("*", "\N{MIDDLE DOT}")


def quantities(result: Result) -> dict[str, Quantity]:
    """Everything in a file that has a number for each sample or crossing, by name."""
    found: dict[str, Quantity] = {}
    if "t" in result.held:
        found["t"] = Quantity("t", "t", (), result.held["t"].unit)
    for folder, (pattern, _) in FOLDERS.items():
        for name, path in result.within(folder).items():
            if "/" in name:
                continue
            for own, index in members(pattern.format(name), path, result.held[path], result):
                found.setdefault(own, Quantity(own, path, index, result.held[path].unit))
    return found


def too_large(result: Result, outputs: Sequence[str]) -> str:
    """What to say of a dataset of some outputs that has more numbers than can be told apart; nothing if there
    is none."""
    folders = [folder for folder, (_, output) in FOLDERS.items() if output in outputs]
    for path, held in result.held.items():
        count = math.prod(held.shape[len(leading(result, held)) :])
        if path.startswith(tuple(folders)) and count > MOST_MEMBERS:
            return f"{path} has {count} numbers for each sample, and plots have at most {MOST_MEMBERS}"
    return ""


def members(name: str, path: str, held: Held, result: Result) -> Iterator[tuple[str, tuple[int, ...]]]:
    """The names of the numbers of one dataset with their indices behind the sample's."""
    shape = held.shape[len(leading(result, held)) :]
    vector = path.startswith(("positions/", "reactions/")) or (
        bool(shape) and held.axes[-1] in ("xy", "xyz", "x")
    )
    family, last = (shape[:-1], shape[-1]) if vector and shape else (shape, 0)
    if math.prod(shape) > MOST_MEMBERS:
        return  # see ``too_large``
    places: Iterable[Sequence[object]] = itertools.product(*map(range, family))
    axis = held.axes[len(held.shape) - len(shape)] if len(family) == 1 else ""
    if axis in result.held:  # which may be a list of the members that there are
        places = [[place] for place in result.read(axis)]
    for index, place in zip(itertools.product(*map(range, family)), places):
        own = f"{name}[{','.join(map(str, place))}]" if index else name
        if not last:
            yield own, index
        for k in range(last):
            yield f"{own}.{COMPONENTS[k]}", (*index, k)


def leading(result: Result, held: Held) -> tuple[str, ...]:
    """The axes in front: those of a sweep's members, and that of time, or of a section's crossings."""
    if result.kind == "section" and "member" in result.held:
        return held.axes[: len(result.held["member"].shape) + 1]
    if result.kind == "sweep" and "t" not in held.axes and "member" in result.held:
        return held.axes[: len(result.held["member"].shape)]
    return held.axes[: held.axes.index("t") + 1] if "t" in held.axes else held.axes[:1]


def look_up(result: Result, known: Mapping[str, Quantity], name: str, option: str) -> Quantity:
    """The quantity of that name, or of that path in the file.

    Raises ``UsageError`` with what to ask for.
    """
    if name in known:
        return known[name]
    path = name.strip("/")
    if path in result.held:
        for each in known.values():
            if each.path == path and not any(each.index):
                return each
    wanted = output_of(name)
    if large := too_large(result, [wanted or "q"]):
        raise UsageError(f"{option} {name}: in {result.name}, {large}; read it with h5py")
    there = any(result.within(folder) for folder, (_, output) in FOLDERS.items() if output == wanted)
    if wanted and not there and not result.solved_for_this:
        raise UsageError(
            f"{option} {name}: {result.name} does not contain it: solve again with --outputs {wanted}"
        )
    near = near_match(name, list(known))
    hint = f"did you mean {near}?" if near else f"known: {', '.join(itertools.islice(known, 12))}"
    if set("+-*/(") & set(name):
        hint = "write an expression under 'observables' in the system file, and its name here"
    raise UsageError(f"{option} {shown(name)}: {result.name} has no such quantity; {hint}")


def output_of(name: str) -> str:
    """The output that would hold a quantity of this name, if the name says so."""
    if name in ("T", "U", "energy", "action", "h"):
        return name
    for start, output in (
        ("p_", "p"), ("R_", "reactions"), ("lambda_", "multipliers"), ("ledger_", "ledger"),
        ("constraint_", "constraints"),
    ):  # fmt: skip
        if name.startswith(start):
            return output
    return "positions" if "." in name else ""

"""Which events may change what a system of families conserves: each is carried out at random states, wherever
its argument is 0 (see ``mechanics.conservation``)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from lagrange_cli.expression.index_arrays import Places, distinct
from lagrange_cli.families.arrays import Total
from lagrange_cli.families.chains import ChainBuilder
from lagrange_cli.families.conserved.currents import current, energies_of_parts
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.events import built, refuse_unchanging
from lagrange_cli.families.slopes import slopes
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.families.written_events import arguments_of, assigned_by
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.model.events import between_events
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.spec import Spec

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.float64]


class State(Protocol):
    """A state of a system, and what it is made of."""

    t: float
    q: Values
    v: Values
    parameters: Values
    values: FamilyValues

    def moved(
        self, q: Values, v: Values, parameters: Values | None = None
    ) -> tuple[FamilyValues, Values]: ...


ROUNDED = 1e-10
"""Numbers that differ by a smaller part of them are equal."""
NUMBERS = 2**21
"""Numbers of an array of states."""
MOST = 2e8
"""Terms of the energy at all events up to which it is evaluated; beyond, any of these may change it."""


@dataclass(frozen=True, eq=False)
class Actions:
    """What the events of these ``names`` set: the numbers of those that are ``acting``, the ``places`` that
    are set among coordinates, velocities and parameters, and the new ``values`` at a state."""

    names: Sequence[str]
    acting: Places
    places: Places
    values: Callable[[State], Values]


def actions_in(system: FamilySystem) -> Actions | None:
    """Those of a system."""
    if system.events is None:
        return None
    values = system.events.values
    acting, places = system.events.changed
    return Actions([*system.spec.events], acting, places, lambda state: state.values.of(values))


def actions_of(spec: Spec) -> Actions | None:
    """Those of a file, whether or not events can be followed in loops. Raises ``Unsuited``, also where what
    becomes 0 at an event is the same in all states."""
    if not spec.events:
        return None
    builder = ChainBuilder(spec)
    refuse_unchanging(builder, built(builder, arguments_of(spec)))
    sets = assigned_by(spec)
    values = built(builder, sets.values)

    def at(state: State) -> Values:
        return FamilyValues(builder, state.t, state.q, state.v, state.parameters).of(values)

    return Actions([*spec.events], sets.events, sets.places, at)


def with_breaks(
    system: FamilySystem, states: Sequence[State], found: Sequence[Conserved], actions: Actions | None
) -> Iterator[Conserved]:
    """What is conserved, with the events that may change it."""
    if actions is None or not len(actions.acting):
        yield from found
        return
    safe = ["h"] if system.events is not None and system.events.keeps_energy else []
    asked = [one.quantity for one in found if one.quantity not in safe]
    broken: dict[str, Sequence[int]] = {**dict.fromkeys(safe, ()), **breaks(system, states, asked, actions)}
    if system.events is not None and system.bonds is not None and "h" in asked:
        broken["h"] = distinct(actions.acting).tolist()  # by impulses of constraints, too
    for one in found:
        events = tuple(actions.names[e] for e in broken[one.quantity])
        because = f"{one.because}; {between_events(events)}" if events else one.because
        yield replace(one, because=because, breaks=events)


def breaks(
    system: FamilySystem, states: Sequence[State], quantities: Sequence[str], actions: Actions
) -> Mapping[str, Sequence[int]]:
    """The events that may change each of the ``quantities``, by number."""
    n = system.q.count
    momenta = {f"p_{name}": k for k, name in enumerate(names_of(system.spec.coordinates))}
    rows = np.array([momenta[one] for one in quantities if one in momenta], dtype=np.int64)
    numbers, energies = energies_of_parts(system, quantities)
    of_parts = [one for one in quantities if one in numbers]
    parts = np.array([numbers[one] for one in of_parts], dtype=np.int64)
    others = [one for one in quantities if one not in momenta and one not in numbers]
    currents = [None if one == "h" else current(system, one) for one in others]
    speeds = (actions.places >= n) & (actions.places < 2 * n)
    simple = ~np.isin(actions.acting, actions.acting[~speeds])
    if not system.straight or of_parts:
        simple[:] = False
    acting, places = actions.acting[~simple], actions.places[~simple]
    only_speeds = bool(np.all(speeds[~simple])) and system.vector is None
    costly = not only_speeds and system.terms * len(acting) > MOST

    def values(at: FamilyValues, v: Values) -> Values:
        """All quantities (quantities, states), of h what actions may change."""
        made = [at.of(system.momenta)[rows]]
        if energies is not None:
            made.append(at.of(energies)[parts])
        for one in currents:
            if one is not None:
                made.append(at.of(one))
            elif costly:
                made.append(np.full(v.shape[1:], np.nan))
            else:
                h = np.sum(at.of(system.momenta) * v, axis=0) - at.node(system.kinetic)
                made.append(h if only_speeds else h + at.node(system.potential))
        return np.concatenate([np.reshape(one, (-1, *v.shape[1:])) for one in made])

    pairs: list[Places] = []
    for state in states:
        new = actions.values(state)
        if simple.any():
            own = actions.acting[simple], actions.places[simple] - n
            pairs += by_speeds(system, state, rows, currents, *own, new[simple])
        if not len(acting):
            continue
        new = new[~simple]
        before = values(*state.moved(state.q, state.v))
        for events, sets in together(acting, places, 2 * n, max(2 * n, 0 if only_speeds else system.terms)):
            whole = np.concatenate([state.q, state.v, state.parameters])
            columns = np.repeat(whole[:, None], len(events), axis=1)
            columns[places[sets], np.searchsorted(events, acting[sets])] = new[sets]
            after = values(*state.moved(columns[:n], columns[n : 2 * n], columns[2 * n :, 0]))
            which, event = np.nonzero(differ(after, before[:, None], after - before[:, None]))
            pairs.append(np.array([which, events[event]]))
    which, event = np.concatenate(pairs, axis=1)
    count = len(actions.names)
    which, event = np.divmod(distinct(which * count + event), count)
    order = [*(one for one in quantities if one in momenta), *of_parts, *others]
    found = np.split(event, np.searchsorted(which, np.arange(1, len(order))))
    return {name: own.tolist() for name, own in zip(order, found)}


def differ(after: Values, before: Values, change: Values) -> NDArray[np.bool_]:
    """Whether numbers have changed by more than rounding, or are none."""
    return ~(np.abs(change) <= ROUNDED * (np.abs(after) + np.abs(before)))


def by_speeds(
    system: FamilySystem,
    state: State,
    rows: Places,
    currents: Sequence[Total | None],
    acting: Places,
    places: Places,
    new: Values,
) -> Iterator[Places]:
    """Which momenta of coordinates (their ``rows``) and which ``currents`` change, by number, and at which
    events, where these set nothing but velocities (``places``) and M is diagonal: a momentum is m v, and all
    currents are sums of such momenta but h, which stands as None. So each event is only looked at where it
    sets something."""  # fmt: skip
    speeds, masses = state.v[places], state.values.of(system.masses)[places]
    number = np.full(system.q.count, -1, dtype=np.int64)
    number[rows] = np.arange(len(rows))
    own = np.flatnonzero((number[places] >= 0) & differ(new, speeds, new - speeds))
    yield np.array([number[places[own]], acting[own]])
    for k, one in enumerate(currents):
        if one is None:
            whole = state.values.node(system.kinetic)
            steps = masses * (new**2 - speeds**2) / 2
        else:
            (whole,), root = (state.values.of(one), system.slots.own(system.root, one))
            (slope,), _ = slopes(root, system.root, [system.momenta, one], system.slots, system.v)
            steps = state.values.of(slope)[places] * (new - speeds)
        changes = np.bincount(acting, steps).astype(np.float64)
        events = np.flatnonzero(differ(whole + changes, whole, changes))
        yield np.array([np.full(len(events), len(rows) + k), events])


def together(acting: Places, places: Places, parameters: int, size: int) -> Iterator[tuple[Places, Places]]:
    """Events that are carried out side by side, and the numbers of what they set: those that set parameters
    alone; ``size`` is what one takes."""
    alone = distinct(acting[places >= parameters])
    others, most = np.setdiff1d(acting, alone), max(1, NUMBERS // size)
    for events in (*alone[:, None], *(others[k : k + most] for k in range(0, len(others), most))):
        yield events, np.flatnonzero(np.isin(acting, events))

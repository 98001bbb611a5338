"""Mistakes that the tests must find: ``python -m tests.mutants [NAME ..]``.

Each mutation changes one place of a copy of the package. The tests that should notice it must pass before and
fail after. A mutation names its place by a text that occurs once in its file: where the code has changed,
the mutation must follow (``tests/test_mutants.py`` tells).
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "lagrange_cli"
PATIENCE = 60.0
"""Seconds that tests of a mistake may take however short all of them are without one: longer ones hang."""


@dataclass(frozen=True)
class Mutation:
    """``before`` becomes ``after`` in a file of the package; ``tests`` are arguments of pytest."""

    file: str
    before: str
    after: str
    tests: tuple[str, ...]

    def applied(self) -> str:
        """The text of the file with the mistake; raises ``LookupError`` where there is not one such place."""
        text = (PACKAGE / self.file).read_text(encoding="utf-8")
        if (count := text.count(self.before)) != 1:
            raise LookupError(f"{self.file} has {count} places {self.before!r}; there must be one")
        return text.replace(self.before, self.after)


FORMULATIONS = "tests/mechanics/test_formulations.py::"
SUMS = "tests/native/stepping/test_cancelling.py::"
MEMBERS = "tests/native/families/test_enclosures.py::"
LEDGERS = "tests/motions/test_ledgers.py::"
CERTIFICATE = "tests/integrate/certify/test_certificate.py::"
SPINS = "tests/families/test_spins.py::"
CURVED = "tests/families/test_curved_masses.py::"
CONSTRAINTS = "tests/motions/test_constraints.py::"
SECTIONS = "tests/motions/test_sections.py::"
PAGES = "tests/page/test_engine.py::"
CACHE = "tests/native/compilation/test_cache.py"

MUTATIONS = {
    "a sign in Routh's reduction": Mutation(
        "mechanics/routh.py", "(unit * symbol - rest) / inertia", "(unit * symbol + rest) / inertia",
        (FORMULATIONS + "test_routh_s_motion_is_that_of_the_other_formulations",),
    ),
    "the sign of the Routhian": Mutation(
        "mechanics/routh.py", "routhian = without - inertia * speed**2 / 2.0",
        "routhian = without + inertia * speed**2 / 2.0",
        (FORMULATIONS + "test_routh_s_motion_is_that_of_the_other_formulations",),
    ),
    "the slope of the energy of what spins": Mutation(
        "native/families/joints/kind_series.py", "graph.ddt(p) - slope", "graph.ddt(p) + slope",
        (SPINS + "test_tops_precess_steadily[double-heavy-400]",),
    ),
    "what a spin has of the others' accelerations": Mutation(
        "native/families/joints/kind_masses.py", "max(spin, b)] = self._kept(-node)",
        "max(spin, b)] = self._kept(node)",
        (SPINS + "test_the_axis_is_known_close_to_the_vertical",),
    ),
    "the sign of masses that change, times accelerations": Mutation(
        "native/families/constraints/together.py", "graph.ddt(graph.ddt(other)), -1.0",
        "graph.ddt(graph.ddt(other)), 1.0",
        (CURVED + "test_members_alike_take_the_steps_of_one[taylor]",),
    ),
    "the sign of dT/dq where masses depend on coordinates": Mutation(
        "families/curved_masses.py", "-(slope * v * w)", "slope * v * w",
        (CURVED + "test_members_alike_take_the_steps_of_one[taylor]",),
    ),
    "parts whose terms contain t": Mutation(
        "families/conserved/parts.py", "steady[of[one.tables[0]]] = False",
        "steady[of[one.tables[0]]] = True",
        (CURVED + "test_what_is_conserved_is_what_members_conserve[driven]",),
    ),
    "what a spin has of others where it stands alone": Mutation(
        "native/families/constraints/together.py", "terms.append(Term(spin.domain, -node, spin.rows))",
        "terms.append(Term(spin.domain, node, spin.rows))",
        ("tests/families/test_curved_spins.py",),
    ),
    "a power of the step in the compensated Horner scheme": Mutation(
        "native/stepping/polynomial.py", "square * square * h, rest)", "square * square, rest)",
        ("tests/native/stepping/test_polynomial.py",),
    ),
    "the compensation of the Horner scheme": Mutation(
        "native/stepping/polynomial.py", "f.fma(rest, h, f.fma(total, h, -product))", "rest * h",
        ("tests/native/stepping/test_polynomial.py",),
    ),
    "acceptance skipped": Mutation(
        "native/stepping/acceptance.py", "bad.set(bad.get() | row.moving(apart))",
        "bad.set(bad.get() & row.moving(apart))",
        ("tests/native/stepping/test_acceptance.py",),
    ),
    "what is beyond the series of a sum": Mutation(
        "native/stepping/cancelling.py", "extent[node] + beyond)", "extent[node])",
        (SUMS + "test_sums_lie_in_their_disks_which_are_not_much_larger[late-1.0]",),
    ),
    "what is beyond the series of a sum over members": Mutation(
        "native/families/proof_arrays.py", "extent.get() + beyond)", "extent.get())",
        (MEMBERS + "test_values_lie_in_their_disks[a mean-3-late-doubles]",),
    ),
    "a ledger's sign": Mutation(
        "mechanics/energetics.py", "self.power - self.lagrangian_rate(time)",
        "self.power + self.lagrangian_rate(time)",
        (LEDGERS + "test_a_potential_that_changes_in_time_is_in_the_ledger",),
    ),
    "a checkpoint left out": Mutation(
        "integrate/methods/taylor.py", "checkpoints.keep(snapshot)", "pass",
        ("tests/cli/test_resume.py::test_a_run_that_was_killed_is_kept_and_goes_on",),
    ),
    "the cache's digest unchecked": Mutation(
        "native/compilation/cache.py", "known = content[:start] == MAGIC + digest(content[start:])",
        "known = content.startswith(MAGIC)",
        (CACHE,),
    ),
    "the cache's owner unchecked": Mutation(
        "native/compilation/cache.py", "if status.st_uid != os.geteuid():", "if False:",
        (CACHE,),
    ),
    "an error estimate halved": Mutation(
        "integrate/certify/certificate.py", "        found: Array = np.fmax.reduce(",
        "        found: Array = 0.5 * np.fmax.reduce(",
        (CERTIFICATE + "test_the_estimate_is_at_least_the_distance_of_the_motions",),
    ),
    "the smaller of two distances": Mutation(
        "integrate/certify/certificate.py", "np.maximum(np.minimum(a, b), np.minimum(np.maximum(a, b), c))",
        "np.minimum(a, b)",
        (CERTIFICATE + "test_the_middle_one_of_three_distances_counts",),
    ),
    "SLACK's end moved": Mutation(
        "native/stepping/step_size.py", "block[-1] < 0.75 * top", "block[-1] < 0.5 * top",
        ("tests/native/stepping/test_step_size.py",),
    ),
    "the refill of lanes off by one": Mutation(
        "native/ensembles/ensemble.py", '"%states", n * rows', '"%states", (n + 1) * rows',
        ("tests/integrate/ensemble/test_lanes.py::test_members_move_as_they_do_alone[pendulum-1]",),
    ),
    "a velocity's unit": Mutation(
        "model/quantity.py", "unit=quantity.unit / time.unit)", "unit=quantity.unit * time.unit)",
        ("tests/outputs/units/test_given.py",),
    ),
    "the sign of dissipation": Mutation(
        "mechanics/energetics.py", "(graph.diff(model.dissipation, v), -1.0)",
        "(graph.diff(model.dissipation, v), 1.0)",
        ("tests/motions/test_backward.py::test_a_driven_damped_oscillator_before_its_start",),
    ),
    "the momentum of a potential with velocities": Mutation(
        "mechanics/energetics.py", "self._moving) - graph.diff(model.potential, v))",
        "self._moving) + graph.diff(model.potential, v))",
        (LEDGERS + "test_ledgers_close_for_every_system[charged_particle]",),
    ),
    "h of an embedding that moves": Mutation(
        "mechanics/energetics.py", "drift * drift, -0.5", "drift * drift, 0.5",
        (LEDGERS + "test_h_of_the_rotating_rod_stays_although_its_energy_grows",),
    ),
    "half of a rounding error": Mutation(
        "native/numbers/error_free.py", "kind.add(kind.sub(a, kind.sub(total, back)), kind.sub(b, back))",
        "kind.sub(b, back)",
        ("tests/native/numbers/test_double_double.py",),
    ),
    "no projection back to the constraints": Mutation(
        "native/stepping/projection.py", "away = ~Bit(f, fine)", "away = Bit(f, fine) & ~Bit(f, fine)",
        (CONSTRAINTS + "test_rounding_does_not_add_up",),
    ),
    "the sign of what a projection gives back to velocities": Mutation(
        "mechanics/constraints.py", "(multiplier * graph.diff(slope, symbol) * speed, -1.0)",
        "(multiplier * graph.diff(slope, symbol) * speed, 1.0)",
        (CONSTRAINTS + "test_rounding_does_not_add_up",),
    ),
    "a multiplier's sign": Mutation(
        "mechanics/constraints.py", "terms[k].append((slope, multiplier))",
        "terms[k].append((slope, -multiplier))",
        ("tests/symbolic/test_constraints.py::test_three_routes_agree_at_states_that_satisfy_the_constraints",),
    ),
    "the sign of the power of constraints that move": Mutation(
        "mechanics/constraints.py", "one.multiplier * drift, -1.0", "one.multiplier * drift, 1.0",
        (CONSTRAINTS + "test_a_constrained_motion_is_that_in_an_independent_coordinate[a changing length]",),
    ),
    "an impulse's sign": Mutation(
        "integrate/impacts/impulses.py", "added(state[:, own], moved)",
        "added(state[:, own], -moved)",
        (CONSTRAINTS + "test_a_constrained_motion_is_that_in_an_independent_coordinate[impacts]",),
    ),
    "the side of a section's root": Mutation(
        "native/ensembles/crossings.py", "beyond = value * last > 0.0", "beyond = value * last < 0.0",
        (SECTIONS + "test_an_oscillator_crosses_once_a_period_and_not_at_its_start",
         SECTIONS + "test_roots_of_any_pattern_within_one_step"),
    ),
    "a section's root found to half its digits": Mutation(
        "native/ensembles/crossings.py", "~(inside & (change <= QUADRATIC))", "~inside",
        (SECTIONS + "test_the_period_of_a_pendulum_is_an_elliptic_integral",
         SECTIONS + "test_crossings_lie_on_the_motion_that_solve_follows"),
    ),
    "the sign of h in Noether's current": Mutation(
        "mechanics/conserved/noether.py", "terms += [(change.time * self.energy, -1.0)] if",
        "terms += [(change.time * self.energy, 1.0)] if",
        ("tests/mechanics/conserved/test_symmetries.py::test_what_is_conserved",),
    ),
    "the sign of what L gains in Noether's current": Mutation(
        "mechanics/conserved/noether.py", "[(change.gain, -1.0)] if", "[(change.gain, 1.0)] if",
        ("tests/mechanics/conserved/test_symmetries.py::test_what_is_conserved",),
    ),
    "the rate of a term of a conserved polynomial": Mutation(
        "mechanics/conserved/columns.py",
        "(rate * x + value * x_rate) % p",
        "(rate * x - value * x_rate) % p",
        ("tests/mechanics/conserved/test_polynomial_integrals.py::test_published_integrals_are_found",),
    ),
    "the error of a product with a mass of a body": Mutation(
        "native/recurrences/expansion.py", "kind.add(kind.add(rest, lost), error)", "kind.add(rest, error)",
        ("tests/motions/test_bodies.py::test_the_energy_of_a_free_top_does_a_random_walk",),
    ),
    "a node of ias15": Mutation(
        "native/rates/gauss_radau_nodes.py", "0.5471536263305554", "0.5471536263305555",
        ("tests/integrate/methods/test_ias15.py::test_every_node_is_the_double_nearest_to_a_zero",),
    ),
    "an error weight of Radau": Mutation(
        "native/rates/radau_constants.py", "(-13 - 7 * ROOT) / 3", "(-13 - 6 * ROOT) / 3",
        ("tests/integrate/methods/test_radau.py::test_the_numbers_are_those_of_a_method_of_order_5",),
    ),
    "the order of coordinates in bands": Mutation(
        "native/rates/implicit.py", 'f.load_integer("@coupled", p) if self.coupling.places else p', "p",
        ("tests/families/test_coupling.py",),
    ),
    "where derivatives belong is carried": Mutation(
        "native/rates/implicit.py", 'f.copy_rows(("%work", point), ("%state", carried)',
        'f.copy_rows(("%state", 0), ("%state", carried)',
        ("tests/cli/test_resume.py::test_an_implicit_run_goes_on_to_the_same_bytes",),
    ),
    "a jump of a force that is taken for rounding": Mutation(
        "native/rates/steps.py", "\nSUDDEN = 0.5\n", "\nSUDDEN = 0.0\n",
        ("tests/motions/test_cuts.py::test_steps_on_rates_pass_a_force_that_jumps_as_precisely_as_time_is_resolved",),
    ),
    "a coefficient of ias15": Mutation(
        "native/rates/gauss_radau_nodes.py", "/ ((k + 2) * (k + 3))",
        "/ ((k + 2) * (k + 3) + (k == TERMS - 1))",
        ("tests/integrate/methods/test_ias15.py",),
    ),
    "the speed that an impact leaves": Mutation(
        "native/events.py", "rates_of(model, [event]), after)", "rates_of(model, [event]), {})",
        ("tests/integrate/impacts/test_in_compiled_code.py",),
    ),
    "the force that would hold a motion": Mutation(
        "native/stepping/passing.py", "(f.magnitude(force) > most * EXCEEDS)",
        "(f.magnitude(force) > most * 0.0)",
        ("tests/integrate/guards/test_passing.py",),
    ),
    "sides of switches after an action": Mutation(
        "native/events.py", "(i in rests and not switched & bits)", "i in rests",
        ("tests/integrate/impacts/test_in_compiled_code.py",),
    ),
    "the rest of a polynomial that is looked at": Mutation(
        "native/stepping/roots.py", "f.load(p)) > rest", "f.load(p)) > rest * -1e9",
        ("tests/motions/test_events.py",),
    ),
    "a power in the derivative of a polynomial": Mutation(
        "native/stepping/roots.py", "f.lane(powers, LANES - 1)", "f.lane(powers, LANES - 2)",
        ("tests/native/stepping/test_roots.py::test_no_root_is_missed[3]",),
    ),
    "which roots bound a cautious step": Mutation(
        "native/stepping/step_size.py", "CLEARLY, DENORMAL = 0.06,", "CLEARLY, DENORMAL = -0.06,",
        ("tests/native/stepping/test_step_size.py",),
    ),
    "a limit without effect": Mutation(
        "limits.py", "if self.spent > self.most:", "if False:",
        ("tests/test_limits.py", "tests/cli/test_limits.py::test_the_work_of_deriving_is_bounded"),
    ),
    "the velocities that a page begins with": Mutation(
        "page/engine.py", "*(one.velocity for one in spec.coordinates)]",
        "*(one.initial for one in spec.coordinates)]",
        (PAGES + "test_a_start_that_depends_on_parameters_follows_them",),
    ),
    "the sign of a velocity in a page": Mutation(
        "page/assets/motion.js", "[begin.q[k], begin.v[k]]", "[begin.q[k], -begin.v[k]]",
        (PAGES + "test_values_may_be_changed",),
    ),
}  # fmt: skip
"""What is wrong, and the place."""


def copy_of_the_package(folder: Path) -> None:
    """Copy what the tests need."""
    for name in ("lagrange_cli", "systems", "tests", "docs", "benchmarks"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", ".*"))
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, folder)


def failure(folder: Path, tests: Sequence[str], limit: float | None = None) -> str | None:
    """What tests say that fail on the copy, or take longer than the ``limit``; None if they pass.

    Raises ``RuntimeError`` where they cannot be run.
    """
    try:
        run = subprocess.run(
            [sys.executable, "-B", "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *tests],
            cwd=folder, env={**os.environ, "PYTHONPATH": str(folder)}, capture_output=True, text=True,
            timeout=limit,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return "they take too long"
    if run.returncode not in (0, 1):
        raise RuntimeError(run.stdout + run.stderr)
    return run.stdout if run.returncode else None


def main(names: Sequence[str]) -> int:
    """Make each mistake and say whether it is found; 1 if one is not, or if tests fail without it."""
    mutations = {name: MUTATIONS[name] for name in names or MUTATIONS}
    mutated = {name: each.applied() for name, each in mutations.items()}
    missed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        copy_of_the_package(folder)
        tests = dict.fromkeys(test for each in mutations.values() for test in each.tests)
        began = time.monotonic()
        if said := failure(folder, [*tests]):
            print(f"{said}\nthe tests fail without any mistake")
            return 1
        limit = max(PATIENCE, time.monotonic() - began)
        for name, each in mutations.items():
            path = folder / "lagrange_cli" / each.file
            right = path.read_text(encoding="utf-8")
            path.write_text(mutated[name], encoding="utf-8")
            caught = failure(folder, each.tests, limit) is not None
            path.write_text(right, encoding="utf-8")
            print(f"{name}: {'caught' if caught else 'MISSED'}", flush=True)
            missed += not caught
    print(f"{len(mutations) - missed} of {len(mutations)} mutations caught")
    return int(missed > 0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="; ".join(["all of them", *MUTATIONS]))
    given = parser.parse_args().names
    if unknown := [name for name in given if name not in MUTATIONS]:
        parser.error(f"no mutation is called {unknown[0]!r}")
    sys.exit(main(given))
